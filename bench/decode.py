"""How fast programs become blocks: check and decode of long programs. `measure()` gives name → value."""

from __future__ import annotations

import json
import math
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from runtime.cli.check import check
from runtime.cnc.blocks import Polyline
from runtime.cnc.decoder import Decoder, DecoderSetup, load_program
from runtime.cnc.path_preparation import SoftwareLimits
from runtime.config.loader import load_machine
from runtime.kernels import warm_up

SURFACE_MOVES = 200_000
LOOP_PASSES = 20_000


def surface(moves: int) -> str:
    """A finishing program of short straight moves over a wavy surface."""
    lines = ["%SURFACE", "N1 G90 G71 G94 G17", "N2 S18000 M3", "N3 G00 X0 Y0 Z10", "N4 G01 Z0 F1000", "N5 F6000"]
    for i in range(moves):
        row, k = divmod(i, 400)
        x, y = (k if row % 2 == 0 else 400 - k) * 0.1, row * 0.25
        lines.append(f"G01 X{x:.4f} Y{y:.4f} Z{2 * math.sin(x / 5) * math.cos(y / 7):.4f}")
    return "\n".join([*lines, "G00 Z10", "M5", "M30", ""])


def loop(passes: int) -> str:
    """Blocks with expressions in a loop, five per pass."""
    body = "P2 = P1 MOD 7\nG01 X[10 + P2] Y[SIN[P1] * 5]\nX[P2 * 2]\n$IF P2 > 3\nY[P2]\n$ENDIF"
    return f"G90 F1000\n$FOR P1 = 1, {passes}, 1\n{body}\n$ENDFOR\nM30\n"


def arcs(count: int) -> str:
    """Numeric blocks that are not plain."""
    pairs = "G02 X-10 Y0 I-10 J0\nG03 X10 Y0 I10 J0\n"
    return "G90 F1000\nG00 X10 Y0\n" + pairs * (count // 2) + "M30\n"


def measure() -> dict[str, float]:
    """Seconds and blocks per second; the machine is the built-in demo."""
    warm_up()
    machine = load_machine(None)
    setup, limits = DecoderSetup.from_machine(machine), SoftwareLimits.of(machine)
    results: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)

        def program(file: str, text: str) -> Path:
            path = folder / file
            path.write_text(text)
            return path

        path = program("surface.nc", surface(SURFACE_MOVES))
        check(path, setup, limits)  # the parser of the channel is built once
        results["check_surface_200000_s"] = _seconds(lambda: check(path, setup, limits))
        loading = _seconds(lambda: load_program(path, setup).close())
        results["scan_plain_blocks_per_s"] = SURFACE_MOVES / loading
        results["decode_plain_blocks_per_s"] = SURFACE_MOVES / _seconds(lambda: _decode(path, setup))
        path = program("loop.nc", loop(LOOP_PASSES))
        executed = _decode(path, setup)
        results["loop_blocks_per_s"] = executed / _seconds(lambda: _decode(path, setup))
        path = program("arcs.nc", arcs(LOOP_PASSES))
        results["arc_blocks_per_s"] = LOOP_PASSES / _seconds(lambda: _decode(path, setup))
    return results


def _decode(path: Path, setup: DecoderSetup) -> int:
    """Decode a program to its end; the count of executed entries."""
    program = load_program(path, setup)
    decoder = Decoder(program, setup, start=np.zeros(len(setup.axes)))
    moves = 0
    for block in decoder.blocks():
        moves += len(block.feeds) if isinstance(block, Polyline) else 1
    program.close()
    return decoder.executed


def _seconds(call: Callable[[], object]) -> float:
    """The best of three, to leave out what else the computer does."""
    times = []
    for _ in range(3):
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return min(times)


if __name__ == "__main__":
    print(json.dumps(measure(), indent=2))
