"""The absolute encoders of simulated drives: positions that survive the process, even when it is killed."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np

NODES: Final = 512  # 128 a bus


class EncoderFile:
    """Positions in increments by node id, in a memory-mapped file of 512 little-endian float64."""

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        size = NODES * 8
        missing = size - path.stat().st_size if path.exists() else size
        if missing > 0:  # a file of earlier versions has room for one bus
            with path.open("ab") as file:
                file.write(bytes(missing))
        self._positions = np.memmap(path, dtype="<f8", mode="r+", shape=(NODES,))

    def __getitem__(self, node: int) -> float:
        position = float(self._positions[node])
        return position if np.isfinite(position) else 0.0

    def __setitem__(self, node: int, position: float) -> None:
        self._positions[node] = position

    def close(self) -> None:
        self._positions.flush()
