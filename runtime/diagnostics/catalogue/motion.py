"""Errors of motion: limits, geometry, following error, standstill."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity
