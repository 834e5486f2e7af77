"""NC programs to measure with."""

from __future__ import annotations

import math
from importlib import resources
from pathlib import Path

_SURFACE_BEGIN = "%SURFACE\nN1 G90 G71 G94 G17\nN2 S18000 M3\nN3 G00 X0 Y0 Z10\nN4 G01 Z0 F1000\nN5 F6000\n"
_SURFACE_END = "G00 Z10\nM5\nM30\n"


def surface(moves: int, step: float = 0.1) -> str:
    """A finishing program of short straight moves, `step` mm in X, over a wavy surface 40 mm wide."""
    return _SURFACE_BEGIN + _surface_moves(moves, step) + _SURFACE_END


def smoothed_surface(moves: int, selection: str) -> str:
    """The same with a smoothing method selected in front of the moves."""
    return f"{_SURFACE_BEGIN}{selection}\n{_surface_moves(moves, 0.1)}M30\n"


def _surface_moves(moves: int, step: float) -> str:
    lines = []
    per_row = round(40.0 / step)
    for i in range(moves):
        row, k = divmod(i, per_row)
        x, y = (k if row % 2 == 0 else per_row - k) * step, row % 800 * 0.25
        lines.append(f"G01 X{x:.4f} Y{y:.4f} Z{2 * math.sin(x / 5) * math.cos(y / 7):.4f}\n")
    return "".join(lines)


def plate() -> str:
    """The demo program: lines, arcs, helices, rapids, tools, spindle, M functions with acknowledgement."""
    return resources.files("runtime.demo").joinpath("plate.nc").read_text(encoding="utf-8")


def loop(passes: int) -> str:
    """Blocks with expressions in a loop, five per pass."""
    body = "P2 = P1 MOD 7\nG01 X[10 + P2] Y[SIN[P1] * 5]\nX[P2 * 2]\n$IF P2 > 3\nY[P2]\n$ENDIF"
    return f"G90 F1000\n$FOR P1 = 1, {passes}, 1\n{body}\n$ENDFOR\nM30\n"


def while_loop(passes: int) -> str:
    """Two assignments and one motion block in a WHILE loop: WHILE_BLOCKS executed blocks per pass."""
    body = "P1 = P1 + 1\nP2 = [P1 MOD 7] * 2.5 - SIN[P1]\nG01 X[10 + P2]\n"
    return f"G90 F1000\nP1 = 0\n$WHILE P1 < {passes}\n{body}$ENDWHILE\nM30\n"


WHILE_BLOCKS = 5  # with the loop's own two


def arcs(count: int) -> str:
    """Numeric blocks that are not plain."""
    pairs = "G02 X-10 Y0 I-10 J0\nG03 X10 Y0 I10 J0\n"
    return "G90 F1000\nG00 X10 Y0\n" + pairs * (count // 2) + "M30\n"


def shortest() -> str:
    """One move of a tenth of a millimetre."""
    return "G90 G01 F1000 X0.1\nM30\n"


LONG_TILE = 100_000  # moves of a long surface that are written again and again


def write_long_surface(folder: Path, name: str, lines: int) -> Path:
    """A surface of `lines` moves as a file, some 30 bytes each; `lines` is a multiple of LONG_TILE."""
    path = folder / name
    tile = _surface_moves(LONG_TILE, 0.1)
    with path.open("w", encoding="utf-8") as file:
        file.write(_SURFACE_BEGIN)
        for _ in range(lines // LONG_TILE):
            file.write(tile)
        file.write(_SURFACE_END)
    return path


def write(folder: Path, name: str, text: str) -> Path:
    """The program as a file."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path
