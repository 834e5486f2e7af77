"""NC programs to measure with."""

from __future__ import annotations

import math
from importlib import resources
from pathlib import Path


def surface(moves: int, step: float = 0.1) -> str:
    """A finishing program of short straight moves, `step` mm in X, over a wavy surface 40 mm wide."""
    lines = ["%SURFACE", "N1 G90 G71 G94 G17", "N2 S18000 M3", "N3 G00 X0 Y0 Z10", "N4 G01 Z0 F1000", "N5 F6000"]
    per_row = round(40.0 / step)
    for i in range(moves):
        row, k = divmod(i, per_row)
        x, y = (k if row % 2 == 0 else per_row - k) * step, row % 800 * 0.25
        lines.append(f"G01 X{x:.4f} Y{y:.4f} Z{2 * math.sin(x / 5) * math.cos(y / 7):.4f}")
    return "\n".join([*lines, "G00 Z10", "M5", "M30", ""])


def plate() -> str:
    """The demo program: lines, arcs, helices, rapids, tools, spindle, M functions with acknowledgement."""
    return resources.files("runtime.demo").joinpath("plate.nc").read_text(encoding="utf-8")


def loop(passes: int) -> str:
    """Blocks with expressions in a loop, five per pass."""
    body = "P2 = P1 MOD 7\nG01 X[10 + P2] Y[SIN[P1] * 5]\nX[P2 * 2]\n$IF P2 > 3\nY[P2]\n$ENDIF"
    return f"G90 F1000\n$FOR P1 = 1, {passes}, 1\n{body}\n$ENDFOR\nM30\n"


def arcs(count: int) -> str:
    """Numeric blocks that are not plain."""
    pairs = "G02 X-10 Y0 I-10 J0\nG03 X10 Y0 I10 J0\n"
    return "G90 F1000\nG00 X10 Y0\n" + pairs * (count // 2) + "M30\n"


def shortest() -> str:
    """One move of a tenth of a millimetre."""
    return "G90 G01 F1000 X0.1\nM30\n"


def write(folder: Path, name: str, text: str) -> Path:
    """The program as a file."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path
