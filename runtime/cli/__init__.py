"""The `tandem` command, a file per sub-command."""

INTERRUPTED = 130  # exit code of what was stopped on its way: 128 + SIGINT, as shells have it
