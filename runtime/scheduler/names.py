"""Names of the shared memories of one runtime; the HLI carries the runtime's own name."""


def events(name: str) -> str:
    return f"{name}-events"


def statistics(name: str) -> str:
    return f"{name}-statistics"


def queue(name: str, channel: int) -> str:
    return f"{name}-queue{channel}"


def link(name: str, channel: int) -> str:
    return f"{name}-preparation{channel}"


def recorder(name: str) -> str:
    return f"{name}-recorder"
