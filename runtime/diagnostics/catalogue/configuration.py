"""Errors of the machine description and channel lists."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity
