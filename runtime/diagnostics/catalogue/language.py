"""Errors of NC programs: reading, decoding, variables, subprograms."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity
