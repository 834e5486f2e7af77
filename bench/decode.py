"""How fast programs become blocks: check and decoding of long programs."""

from __future__ import annotations

import tempfile
from datetime import datetime
from pathlib import Path

import numpy as np

from bench import programs
from bench.figure import Figure
from bench.stopwatch import seconds
from runtime.cli.check import check
from runtime.cnc.blocks import Polyline
from runtime.cnc.decoder import Decoder, DecoderSetup, load_program
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.motion_queue import MotionQueue
from runtime.cnc.path_preparation import PumpState, SoftwareLimits
from runtime.cnc.preparation_link import PreparationLink, StartOrder
from runtime.config.loader import load_machine
from runtime.config.machine import Machine
from runtime.hli.memory import HliMemory
from runtime.kernels import warm_up
from runtime.scheduler.outside import RunningMachine
from runtime.scheduler.preparation import Preparation

SURFACE_MOVES = 200_000
LOOP_PASSES = 20_000
PLAIN_LIMIT = 5_000_000.0  # blocks/s
QUEUE_LIMIT = 1_000_000.0
HSC_LIMIT = 100_000.0
SMOOTHED_MOVES = 50_000
LOOP_LIMIT = 300_000.0


def measure() -> list[Figure]:
    """Blocks per second on the built-in demo machine; the first check is left out, it builds the parser."""
    warm_up()
    machine = load_machine(None)
    setup, limits = DecoderSetup.from_machine(machine), SoftwareLimits.of(machine)
    axes = AxisLimits.of(machine.axes[machine.axis_index(name)] for name in machine.channels[0].axes)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        surface = programs.write(folder, "surface.nc", programs.surface(SURFACE_MOVES))
        loop = programs.write(folder, "loop.nc", programs.loop(LOOP_PASSES))
        hsc = programs.write(
            folder, "hsc.nc", programs.smoothed_surface(SMOOTHED_MOVES, "#HSC ON [BSPLINE PATH_DEV=0.01]")
        )
        corners = programs.write(
            folder, "corners.nc", programs.smoothed_surface(SMOOTHED_MOVES, "#CONTOUR MODE ON [DEV PATH_DEV=0.01]")
        )
        while_loop = programs.write(folder, "while.nc", programs.while_loop(LOOP_PASSES))
        arcs = programs.write(folder, "arcs.nc", programs.arcs(LOOP_PASSES))
        check(surface, setup, limits, axes)
        while_blocks = LOOP_PASSES * programs.WHILE_BLOCKS
        rates: list[tuple[str, float, float | None]] = [
            ("plain blocks, decoded", SURFACE_MOVES / seconds(lambda: _decode(surface, setup)), PLAIN_LIMIT),
            (
                "plain blocks, from the file to the motion queue",
                SURFACE_MOVES / seconds(lambda: _prepare(surface, machine)),
                QUEUE_LIMIT,
            ),
            (
                "short moves through an HSC B-spline to the motion queue",
                SMOOTHED_MOVES / seconds(lambda: _prepare(hsc, machine)),
                HSC_LIMIT,
            ),
            (
                "corners through contouring to the motion queue",
                SMOOTHED_MOVES / seconds(lambda: _prepare(corners, machine)),
                None,
            ),
            (
                "WHILE with two assignments and a motion",
                while_blocks / seconds(lambda: _decode(while_loop, setup)),
                LOOP_LIMIT,
            ),
            ("FOR with expressions and a branch", _decode(loop, setup) / seconds(lambda: _decode(loop, setup)), None),
            ("arcs", LOOP_PASSES / seconds(lambda: _decode(arcs, setup)), None),
        ]
        whole = Figure(
            f"check of {SURFACE_MOVES} plain blocks", seconds(lambda: check(surface, setup, limits, axes)), "s"
        )
        return [whole, *(Figure(name, rate, "blocks/s", limit, better="higher") for name, rate, limit in rates)]


def _prepare(path: Path, machine: Machine) -> None:
    """Take a program all the way: decoder, software limits, limits of the axes, records. The queue is emptied at once."""
    queue = MotionQueue(len(machine.channels[0].axes))
    link = PreparationLink(queue.n_axes)
    outside = RunningMachine(machine, HliMemory.private().hli, link, datetime.now)
    preparation = Preparation(machine, 0, queue, link, outside)
    link.start(StartOrder(str(path), np.zeros(queue.n_axes), 0))
    while preparation.poll() is not PumpState.FINISHED:
        queue.discard_all()
    if link.problem.id:
        raise RuntimeError(link.problem.text)


def _decode(path: Path, setup: DecoderSetup) -> int:
    """Decode a program to its end; the count of executed entries."""
    program = load_program(path, setup)
    decoder = Decoder(program, setup, start=np.zeros(len(setup.axes)))
    moves = 0
    for block in decoder.blocks():
        moves += len(block.feeds) if isinstance(block, Polyline) else 1
    program.close()
    return decoder.executed
