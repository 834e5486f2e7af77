"""Errors of the PLC program, its process and the HLI."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity
