"""The exception of this stage."""

from __future__ import annotations

from runtime.diagnostics.errors import TandemError


class FieldbusError(TandemError):
    """The bus cannot be opened, a node is missing or is not what the machine description says, a configuration is refused."""
