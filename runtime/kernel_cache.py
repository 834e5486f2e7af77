"""Where compiled kernels are kept between two starts. Knows nothing of Numba, so that asking costs nothing."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path

_SOURCES = Path(__file__).parent


def cache_candidates(environment: Mapping[str, str]) -> list[Path]:
    """Where compiled kernels may be kept, the best place first: $NUMBA_CACHE_DIR, the user's cache folder, /tmp."""
    home = Path(environment.get("XDG_CACHE_HOME") or Path(environment.get("HOME") or "/nonexistent") / ".cache")
    places = [home / "tandem" / "kernels", Path(tempfile.gettempdir()) / f"tandem-kernels-{os.getuid()}"]
    given = environment.get("NUMBA_CACHE_DIR")
    return [Path(given), *places] if given else places


def choose_cache(places: Iterable[Path], version: str) -> Path | None:
    """The first place that can be written to, with a folder of its own for this version of the kernels."""
    for place in places:
        folder = place / version
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return folder
    return None


def sources_version() -> str:
    """Numba looks only at the file of a kernel, not at those of the kernels it calls: any changed source makes a new cache."""
    digest = hashlib.sha256()
    for source in sorted((_SOURCES / "cnc").rglob("*.py")):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]
