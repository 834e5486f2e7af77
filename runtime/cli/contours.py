"""What a program tells about compensated contours: the programmed contour, and the tool at places of its path, for pictures.

The program is decoded once more without the machine. Only contours of the plane X Y are told, since that is what the plan shows.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from runtime.cnc.blocks import (
    Arc,
    Block,
    Line,
    Polyline,
    RadiusCompensation,
    ToolRadius,
    VectorCompensation,
    VectorOrder,
)
from runtime.cnc.decoder import ChannelMemory, DecoderSetup, decoder_of, load_program
from runtime.cnc.path_preparation import SoftwareLimits
from runtime.cnc.tool_radius_comp import ToolRadiusCompensation
from runtime.config.machine import Machine
from runtime.diagnostics.errors import TandemError
from runtime.scheduler.offset_tables import copied_offsets
from runtime.scheduler.tool_tables import copied_tools

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = npt.NDArray[np.float64]

MOST_MOTIONS = 20_000  # of all contours: more than the picture has room for
DISCS = 12  # shown on each contour
_STEP = math.radians(3.0)
_CONTOUR_COLOUR = "#202020"
_TOOL_COLOUR = "#d55e00"


@dataclass
class Contour:
    """Points of a programmed contour, and the motions of the tool along it with its radius, mm."""

    radius: float
    programmed: list[Floats] = field(default_factory=list)  # (k, 2) each
    tool: list[Floats] = field(default_factory=list)

    def discs(self) -> list[Floats]:
        """Places of the tool, (2,) each: the middle of some motions."""
        stride = max(1, math.ceil(len(self.tool) / DISCS))
        return [(points[(len(points) - 1) // 2] + points[len(points) // 2]) / 2 for points in self.tool[::stride]]


def contours_of(file: Path, machine: Machine, dialect: str = "isg") -> list[Contour]:
    """The compensated contours of a program; those in front of an error, if there is one."""
    setup = DecoderSetup.from_machine(machine)
    found = _Contours()
    try:
        program = load_program(file, setup, dialect)
    except TandemError:
        return []
    try:
        start = SoftwareLimits.of(machine).nearest(np.zeros(len(setup.axes)))
        memory = ChannelMemory(setup, copied_tools(machine, os.environ), copied_offsets(machine, os.environ))
        decoder = decoder_of(program, setup, start=start, memory=memory, idle_limit=MOST_MOTIONS)
        for block in ToolRadiusCompensation()(found.programmed(decoder.blocks())):
            if not found.drive(block):
                break
    except TandemError:
        pass  # the simulation has told it
    finally:
        program.close()
    return found.contours


class _Contours:
    """Listens in front of the compensation and behind it."""

    def __init__(self) -> None:
        self.contours: list[Contour] = []
        self._radius = 0.0
        self._lines: dict[int, Contour] = {}  # by the line of a compensated motion
        self._on = False
        self._motions = 0

    def programmed(self, blocks: Iterable[Block]) -> Iterator[Block]:
        for block in blocks:
            if isinstance(block, ToolRadius):
                self._radius = abs(block.radius)
            elif isinstance(block, RadiusCompensation):
                if block.side and block.plane == (0, 1) and not self._on:
                    self.contours.append(Contour(self._radius))
                self._on = block.side != 0 and block.plane == (0, 1)
            elif isinstance(block, VectorCompensation):
                if block.order is VectorOrder.SELECT:
                    on = block.active and block.plane == (0, 1)
                    self._radius = abs(block.offset)
                    if on and not self._on:
                        self.contours.append(Contour(self._radius))
                    self._on = on
            elif self._on:
                for line, points in _lines(block):
                    contour = self.contours[-1]
                    contour.radius = self._radius
                    contour.programmed.append(points)
                    self._lines[line] = contour
            yield block

    def drive(self, block: Block) -> bool:
        """A block of the tool path; False if there are enough."""
        for line, points in _lines(block):
            if line in self._lines:
                self._lines[line].tool.append(points)
                self._motions += 1
        return self._motions < MOST_MOTIONS


def _lines(block: Block) -> Iterator[tuple[int, Floats]]:
    """Program line and points of the motions of a block."""
    if isinstance(block, Polyline):
        for move, line in enumerate(block.lines.tolist()):
            yield line, block.points[move : move + 2, :2]
    elif isinstance(block, Line):
        yield block.source.line, np.stack([block.start[:2], block.end[:2]])
    elif isinstance(block, Arc) and block.plane == (0, 1):
        angle = math.radians(block.angle)
        phi = np.linspace(0.0, angle, max(2, math.ceil(abs(angle) / _STEP)) + 1)[:, None]
        u = block.start[:2] - block.centre
        yield block.source.line, block.centre + np.cos(phi) * u + np.sin(phi) * np.array([-u[1], u[0]])


def draw_contours(plan: Axes, contours: Iterable[Contour]) -> None:
    """The programmed contours as thin dark lines, and the tool as discs at places of its path."""
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Circle

    label: str | None = "programmed contour"
    for contour in contours:
        lines = LineCollection(contour.programmed, colors=_CONTOUR_COLOUR, linewidths=0.9, label=label)
        plan.add_collection(lines)
        label = None
        for x, y in contour.discs():
            plan.add_patch(Circle((x, y), contour.radius, fill=True, alpha=0.12, color=_TOOL_COLOUR, linewidth=0.0))
            plan.add_patch(Circle((x, y), contour.radius, fill=False, color=_TOOL_COLOUR, linewidth=0.5))
