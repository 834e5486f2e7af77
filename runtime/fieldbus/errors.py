"""The exception of this stage."""

from __future__ import annotations

from runtime.diagnostics.errors import TandemError


class FieldbusError(TandemError):
    """The bus cannot be opened, a node is missing or another than described, a configuration is refused."""
