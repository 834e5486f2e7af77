"""The exception of path preparation."""

from __future__ import annotations

from runtime.diagnostics.errors import TandemError


class PathError(TandemError):
    """A block cannot become path: it is not handed on, and nothing of it moves."""


class SoftwareLimitError(PathError):
    """A target, or the way of an arc to it, lies beyond a software limit."""
