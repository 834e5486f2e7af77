"""Programs under radius compensation as tool paths: text in, motions of the tool out."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from runtime.cnc.blocks import Arc, Block, Floats, Line, Polyline
from runtime.cnc.decoder import DecoderSetup
from runtime.cnc.tool_radius_comp import CompensationError, ToolRadiusCompensation
from runtime.cnc.tool_radius_comp.window import move_of
from tests.cnc.decoder.programs import SETUP, decode

Motion = Line | Arc


@dataclass
class Path:
    """What came out of the stage, up to the error if there was one."""

    blocks: list[Block]
    error: CompensationError | None = None

    @property
    def motions(self) -> list[Motion]:
        """All motions, runs one by one."""
        return list(motions_of(self.blocks))

    @property
    def shape(self) -> list[tuple[float, ...]]:
        """A line as (line of the program, x, y), an arc as (line, x, y, centre x, centre y, radius, angle); rounded."""
        return [shape_of(motion) for motion in self.motions]

    def of(self, line: int) -> list[tuple[float, ...]]:
        """The shapes of a program line, without its number."""
        return [shape[1:] for shape in self.shape if shape[0] == line]


def motions_of(blocks: Iterable[Block]) -> Iterable[Motion]:
    for block in blocks:
        if isinstance(block, Line | Arc):
            yield block
        elif isinstance(block, Polyline):
            yield from (move_of(block, move) for move in range(len(block.feeds)))


def shape_of(motion: Motion) -> tuple[float, ...]:
    plane = motion.plane
    shape: list[float] = [motion.source.line, *(motion.end[axis] for axis in plane)]
    if isinstance(motion, Arc):
        shape += [*motion.centre, motion.radius, motion.angle]
    return tuple(round(float(value), 6) + 0.0 for value in shape)


def compensate(blocks: Iterable[Block]) -> Path:
    """The stage alone."""
    path = Path([])
    try:
        for block in ToolRadiusCompensation()(blocks):
            path.blocks.append(block)
    except CompensationError as error:
        path.error = error
    check_continuous(path.motions)
    return path


def tool_path(text: str, setup: DecoderSetup = SETUP, radius: float = 5.0) -> Path:
    """The tool path of the lines of a program; the first of them is line 1."""
    lines = text.split("\n")
    first = next(number for number, line in enumerate(lines) if not line.startswith("#"))  # a statement stands alone
    lines[first] = f"V.G.WZ_AKT.R={radius:.17g} F1000 " + lines[first]
    run = decode("\n".join(lines), setup)
    assert run.problem is None, run.problem
    return compensate(run.blocks)


def contour(text: str, setup: DecoderSetup = SETUP) -> list[Motion]:
    """The programmed motions."""
    return list(motions_of(decode("N1 F1000 " + text, setup).blocks))


def check_continuous(motions: Iterable[Motion]) -> None:
    """Every motion begins where the one before ends, and every arc lies on its circle."""
    end: Floats | None = None
    for motion in motions:
        if end is not None:
            assert np.abs(motion.start - end).max() < 1e-9
        end = motion.end
        if isinstance(motion, Arc):
            u = motion.start[list(motion.plane)] - motion.centre
            phi = math.radians(motion.angle)
            turned = np.array(
                [u[0] * math.cos(phi) - u[1] * math.sin(phi), u[0] * math.sin(phi) + u[1] * math.cos(phi)]
            )
            assert np.abs(motion.centre + turned - motion.end[list(motion.plane)]).max() < 1e-6
