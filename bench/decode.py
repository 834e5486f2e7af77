"""How fast programs become blocks: check and decoding of long programs."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from bench import programs
from bench.figure import Figure
from bench.stopwatch import seconds
from runtime.cli.check import check
from runtime.cnc.blocks import Polyline
from runtime.cnc.decoder import Decoder, DecoderSetup, load_program
from runtime.cnc.path_preparation import SoftwareLimits
from runtime.config.loader import load_machine
from runtime.kernels import warm_up

SURFACE_MOVES = 200_000
LOOP_PASSES = 20_000


def measure() -> list[Figure]:
    """Blocks per second on the built-in demo machine; the first check is left out, it builds the parser."""
    warm_up()
    machine = load_machine(None)
    setup, limits = DecoderSetup.from_machine(machine), SoftwareLimits.of(machine)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        surface = programs.write(folder, "surface.nc", programs.surface(SURFACE_MOVES))
        loop = programs.write(folder, "loop.nc", programs.loop(LOOP_PASSES))
        arcs = programs.write(folder, "arcs.nc", programs.arcs(LOOP_PASSES))
        check(surface, setup, limits)
        rates = {
            "scan of plain blocks": SURFACE_MOVES / seconds(lambda: load_program(surface, setup).close()),
            "decoding of plain blocks": SURFACE_MOVES / seconds(lambda: _decode(surface, setup)),
            "expressions in a loop": _decode(loop, setup) / seconds(lambda: _decode(loop, setup)),
            "arcs": LOOP_PASSES / seconds(lambda: _decode(arcs, setup)),
        }
        whole = Figure(f"check of {SURFACE_MOVES} plain blocks", seconds(lambda: check(surface, setup, limits)), "s")
        return [whole, *(Figure(name, rate, "blocks/s", better="higher") for name, rate in rates.items())]


def _decode(path: Path, setup: DecoderSetup) -> int:
    """Decode a program to its end; the count of executed entries."""
    program = load_program(path, setup)
    decoder = Decoder(program, setup, start=np.zeros(len(setup.axes)))
    moves = 0
    for block in decoder.blocks():
        moves += len(block.feeds) if isinstance(block, Polyline) else 1
    program.close()
    return decoder.executed
