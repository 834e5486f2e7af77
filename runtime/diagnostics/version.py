"""The version of the installed distribution."""

from __future__ import annotations

from importlib import metadata


def version() -> str:
    """The version of tandem-cnc, "unknown" when the package runs from a source tree that is not installed."""
    try:
        return metadata.version("tandem-cnc")
    except metadata.PackageNotFoundError:
        return "unknown"
