"""Coordinate systems of a running program: what is defined, what is linked, and whose offsets are programmed (line 26906).

    machine ─ base: G54, G92, #PSET ─ BCS … ─ ACS … ─ CS … ─▶ position of the decoder
                  └──────── every system has such offsets of its own, zero when it begins ────────┘

The systems of a group follow each other in the order of their selection; BCS come before ACS and ACS before CS whatever the order
in the program was. In the place of CS a stack of named systems may stand (#CS ADD), of which those up to the selected one
count. The offsets of the last system of the chain are those in `Coordinates.offsets`, which G functions and variables change;
the others keep theirs in their `Layer`. Everything ends with the program.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from runtime.cnc.decoder.coordinates import MAIN, Rotation
from runtime.cnc.geometry.frames import HERE, Frame, rotation_of

GROUPS = ("BCS", "ACS", "CS")  # from the machine to the workpiece
DEFINITIONS = 5  # of a group, without configured ones
LINKED = 10
STACKED = 5  # named systems


@dataclass(slots=True)
class Layer:
    """The offsets of one system, (n,) each, and which data set its zero offset is."""

    zero: list[float]
    reference: list[float]
    preset: list[float]
    index: int = 0
    number: int = 0  # of the layer in its program, from 0

    @classmethod
    def empty(cls, axes: int, number: int) -> Layer:
        return cls([0.0] * axes, [0.0] * axes, [0.0] * axes, 0, number)

    def total(self, mirror: Sequence[float]) -> list[float]:
        """What all of them add to an axis, (n,)."""
        return [z + r * m + p for z, r, m, p in zip(self.zero, self.reference, mirror, self.preset, strict=True)]


@dataclass(slots=True, eq=False)
class System:
    """A system of the chain. `passing`: its definition ends with it. `specific`: offsets of axes behind the main axes add up."""

    name: str
    placement: Frame
    layer: Layer
    passing: bool = False
    specific: bool = True


@dataclass(slots=True)
class Group:
    """BCS, ACS or CS: what is defined, the last one at the end, and what is active."""

    defined: dict[str, Frame] = field(default_factory=dict)
    active: list[System] = field(default_factory=list)

    def define(self, name: str, placement: Frame) -> None:
        """It counts as the last one."""
        self.defined.pop(name, None)
        self.defined[name] = placement

    def free_id(self) -> str:
        """The lowest number that is not in use."""
        return next(str(number) for number in range(1, len(self.defined) + 2) if str(number) not in self.defined)


@dataclass(slots=True)
class MachineMode:
    """#MCS ON: what comes back with #MCS OFF."""

    layer: Layer
    clamp: list[float]
    measuring: list[float]
    rotation: Rotation | None
    scaled: bool


class Systems:
    """The coordinate systems of one program run."""

    def __init__(
        self, configured: Mapping[str, tuple[float, ...]], sequence: str, *, fixed: bool, specific: bool, axes: int
    ) -> None:
        self.groups = {name: Group() for name in GROUPS}
        self.configured = {  # definitions that all groups may use, by their names
            name.upper(): Frame(rotation_of(values[MAIN:], sequence, fixed=fixed), np.array(values[:MAIN]))
            for name, values in configured.items()
        }
        self.sequence, self.fixed, self.specific = self.usual = sequence, fixed, specific
        self.stack: list[System] = []
        self.selected = 0  # so many of the stack count
        self.base = Layer.empty(axes, 0)
        self.mcs: MachineMode | None = None
        self._layers = 0

    @property
    def chain(self) -> list[System]:
        """What is active, from the machine to the workpiece."""
        if self.mcs is not None:
            return []
        named = self.stack[: self.selected]
        return [system for name in GROUPS for system in self.groups[name].active] + named

    @property
    def top(self) -> Layer:
        """Whose offsets are programmed."""
        if self.mcs is not None:
            return self.mcs.layer
        chain = self.chain
        return chain[-1].layer if chain else self.base

    def new_layer(self, axes: int) -> Layer:
        self._layers += 1
        return Layer.empty(axes, self._layers)

    def placement(self, mirror: Sequence[float]) -> tuple[Frame, list[float]]:
        """Where the active system lies in the machine, without its own offsets, and what the offsets of the systems below put
        on axes behind the main axes, (n,). `mirror` (n,): signs of the axes (G351)."""
        layers = [self.base, *(system.layer for system in self.chain)]
        frame, lower = HERE, [0.0] * len(mirror)
        for below, system in zip(layers, self.chain, strict=False):
            offset = below.total(mirror)
            frame = frame.holding(Frame.shifted((*offset, 0.0, 0.0, 0.0)[:MAIN])).holding(system.placement)
            if system.specific:
                lower = [a + b for a, b in zip(lower, offset, strict=True)]
        return frame, lower
