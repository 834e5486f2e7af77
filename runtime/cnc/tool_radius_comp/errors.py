"""The exception of radius compensation."""

from __future__ import annotations

from runtime.diagnostics.errors import TandemError


class CompensationError(TandemError):
    """The tool cannot follow the contour: from the block of the error on nothing is handed on."""
