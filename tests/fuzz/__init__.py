"""Whatever a file holds, the decoder gives blocks or a program error: `python -m tests.fuzz` looks for exceptions."""
