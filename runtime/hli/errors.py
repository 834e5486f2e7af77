"""The exception of the HLI: attaching to it, its modes, its elements."""

from runtime.diagnostics.errors import TandemError


class HliError(TandemError):
    """Something about the HLI that a user meets; carries a problem of the catalogue."""
