"""Errors of the CANopen bus, its nodes and the CiA 402 drives."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity
