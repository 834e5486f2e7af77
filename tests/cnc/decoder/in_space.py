"""Programs with coordinate systems: text in, the path of the machine out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from runtime.cnc.blocks import Block, Floats, Polyline, SpatialArc
from runtime.cnc.decoder import DecoderSetup
from runtime.cnc.path_preparation import Frames
from runtime.cnc.tool_radius_comp import ToolRadiusCompensation
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.paths import PLACES, path, programmed
from tests.cnc.decoder.programs import SETUP, Run, decode

FIVE = replace(
    SETUP,
    axes=("X", "Y", "Z", "A", "B"),
    linear=(True, True, True, False, False),
    position_limits=((None, None),) * 3 + ((-1e4, 1e4),) * 2,
    zero_offsets={54: np.array([100.0, 10.0, 1.0, 7.0, 8.0])},
)


def on_machine(text: str, setup: DecoderSetup = SETUP, **options: object) -> Run:
    """A program that is right, with its blocks as they are behind radius compensation and frames."""
    run = decode(text, setup, start=(0.0,) * len(setup.axes), **options)  # type: ignore[arg-type]
    assert run.problem is None, run.problem
    run.blocks = list(Frames()(ToolRadiusCompensation()(run.blocks)))
    return run


def machine_path(run: Run) -> Floats:
    """Points of the path, (k, n): as `paths.path`, arcs in space too."""
    blocks: list[Block] = [_sampled(block) if isinstance(block, SpatialArc) else block for block in run.blocks]
    return path(Run(run.decoder, blocks, None))


def _sampled(arc: SpatialArc) -> Polyline:
    share = np.arange(PLACES + 1)[:, None] / PLACES
    points = arc.start + share * (arc.end - arc.start)
    along = arc.start[:3] - arc.centre
    across = np.cross(arc.normal, along)
    turn = np.radians(arc.angle) * share
    height = arc.normal * float(arc.normal @ (arc.end - arc.start)[:3]) * share
    points[:, :3] = arc.centre + np.cos(turn) * along + np.sin(turn) * across + height
    lines = np.full(PLACES, arc.source.line, dtype=np.int64)
    return Polyline(arc.source.program, points, np.full(PLACES, arc.feed), lines, -lines, np.zeros(len(arc.start)))


def machine_ends(text: str, setup: DecoderSetup = SETUP, **options: object) -> list[list[float]]:
    """Ends of all motions on the machine, rounded."""
    return [[round(float(p), 9) + 0.0 for p in end] for end in on_machine(text, setup, **options).ends]


def told(text: str, setup: DecoderSetup = SETUP) -> list[tuple[ErrorEntry, int, int]]:
    """Entry, line and column of the warnings of a program that is right."""
    warnings = on_machine(text, setup).decoder.warnings
    return [(w.entry, w.place.line, w.place.column) for w in warnings]


def parameters(text: str, setup: DecoderSetup = SETUP, files: Mapping[str, str] | None = None) -> dict[int, float]:
    run = decode(text, setup, files, start=(0.0,) * len(setup.axes))
    assert run.problem is None, run.problem
    return run.parameters


__all__ = ["FIVE", "machine_ends", "machine_path", "on_machine", "parameters", "programmed", "told"]
