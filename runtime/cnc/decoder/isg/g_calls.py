"""G functions that call subprograms: G80–G89, G800–G839."""
