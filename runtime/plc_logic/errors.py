"""The exceptions of the PLC side."""

from __future__ import annotations

from runtime.diagnostics.errors import ErrorEntry, Place, TandemError


class PlcError(TandemError):
    """A mistake in a PLC program that the library finds: a wrong name, an input that is assigned, two handlers."""


class PlcFailure(TandemError):  # noqa: N818 - not an error of a call: the state of the PLC
    """The PLC program stands: it could not be loaded, or it raised. `trace` is the traceback of the user's code."""

    def __init__(self, entry: ErrorEntry, place: Place, trace: str, **values: object) -> None:
        super().__init__(entry, place, **values)
        self.trace = trace
