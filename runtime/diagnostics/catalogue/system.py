"""Errors of the runtime: processes, clock, watchdogs, files."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity
