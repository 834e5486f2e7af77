"""Programmed coordinates → machine coordinates: scale, rotation, mirroring, offsets, systems (programming manual 1991–2076).

    programmed ─ scale ─ rotation in the plane ─ mirror ─ + offsets ─▶ position ─ rotated frame, if there is one ─▶ machine

A coordinate system that is only shifted is one more offset. With a rotated one everything here counts along its axes, and a stage
behind the decoder makes machine axes of it (`path_preparation/frames.py`). Offsets that belong to the machine (tool, clamp,
measuring) do not turn with a system: what the frame would make of them is taken back (`update`).

Selecting any of them moves no axis: it acts with the next word of the axis. An incremental word adds its way, so a new offset
is only taken up by the next absolute word. Lengths in mm and degrees, lists of n axes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from runtime.cnc.blocks import Floats
from runtime.cnc.geometry.frames import Frame

MAIN = 3  # main axes


@dataclass(slots=True)
class Rotation:
    """Contour rotation: `angle` in degrees in the plane of two axes, about the programmed zero, shifted to `centre`."""

    plane: tuple[int, int]
    angle: float
    centre: tuple[float, float]

    def turned(self, first: float, second: float) -> tuple[float, float]:
        """A way in the plane, turned."""
        c, s = math.cos(math.radians(self.angle)), math.sin(math.radians(self.angle))
        return first * c - second * s, first * s + second * c

    def back(self, first: float, second: float) -> tuple[float, float]:
        """The way that is turned into this one."""
        c, s = math.cos(math.radians(self.angle)), math.sin(math.radians(self.angle))
        return first * c + second * s, -first * s + second * c


@dataclass(slots=True)
class Offsets:
    """The linear offsets by kind, (n,) each: zero offset, reference point (G92), preset, clamp, tool, measuring, manual."""

    zero: list[float]
    reference: list[float]
    preset: list[float]
    clamp: list[float]
    tool: list[float]
    measuring: list[float]

    @classmethod
    def none(cls, axes: int) -> Offsets:
        return cls(*([0.0] * axes for _ in range(6)))


@dataclass(slots=True)
class Coordinates:
    """The position of the decoder and everything between programmed and machine coordinates.

    `position`: end of the last decoded motion, in machine coordinates as long as `frame` is None, else along its axes. After
    any change of the other fields `update` has to be called; `gain` and `shift` are what it makes of them: position =
    programmed · gain + shift, as long as no rotation is active. `travelled` are gain and shift of the last motion, which give
    its programmed coordinates. `lower` (n,): what the coordinate systems put on top of the offsets, without those of the
    active system itself.
    """

    position: list[float]
    offsets: Offsets
    mirror_plane: list[float]  # +1 or -1 by G21…G23
    mirror_axis: list[float]  # +1 or -1 by G351
    scale: list[float]
    scale_active: bool = False
    rotation: Rotation | None = None
    gain: list[float] = field(default_factory=list)
    shift: list[float] = field(default_factory=list)
    travelled: tuple[list[float], list[float]] = ([], [])
    last_rotation: Rotation | None = None
    turns: list[float] = field(default_factory=list)  # by which the machine counts further than the program, degrees
    left_out: frozenset[str] = frozenset()  # kinds of offsets that the block in work leaves out
    frame: Frame | None = None  # of the active coordinate system, if it is rotated
    lower: list[float] = field(default_factory=list)
    left_programmed: list[float] | None = (
        None  # programmed coordinates of the last motion, in the system that it was in
    )

    @classmethod
    def at(cls, position: Floats) -> Coordinates:
        """At a machine position, nothing selected."""
        n = len(position)
        made = cls([float(p) for p in position], Offsets.none(n), [1.0] * n, [1.0] * n, [1.0] * n)
        made.turns, made.lower = [0.0] * n, [0.0] * n
        made.update()
        made.travelled = (made.gain, made.shift)
        return made

    @property
    def plain(self) -> bool:
        """Machine = programmed + shift for every axis by itself: the fast roads may be taken."""
        return self.rotation is None

    @property
    def unit_gain(self) -> bool:
        """Neither mirrored nor scaled."""
        return all(g == 1.0 for g in self.gain)

    def update(self) -> None:
        """Make gain and shift anew; new lists, so that whoever kept the old ones keeps them as they were."""
        o = self.offsets
        scale = self.scale if self.scale_active else [1.0] * len(self.position)
        axes = range(len(self.position))
        self.gain = [scale[i] * self.mirror_plane[i] * self.mirror_axis[i] for i in axes]
        local_kinds = {"ZERO": o.zero, "ADD_ZERO": self.mirrored_reference(), "PSET": o.preset}
        global_kinds = {"CLAMP": o.clamp, "TOOL": o.tool, "MEASURE": o.measuring}
        kept = [values for kind, values in local_kinds.items() if kind not in self.left_out]
        fixed = [values for kind, values in global_kinds.items() if kind not in self.left_out]
        if self.frame is None:
            self.shift = [sum((values[i] for values in (*kept, *fixed)), self.turns[i] + self.lower[i]) for i in axes]
            return
        machine = np.array([sum(values[i] for values in fixed) for i in axes])
        machine[:MAIN] = machine[:MAIN] @ self.frame.rotation
        self.shift = [
            sum((values[i] for values in kept), self.turns[i] + self.lower[i] + float(machine[i])) for i in axes
        ]

    def mirrored_reference(self) -> list[float]:
        """The reference point offset as it acts: that of a mirrored axis is mirrored too (G351)."""
        return [value * sign for value, sign in zip(self.offsets.reference, self.mirror_axis, strict=True)]

    # ------------------------------------------------------------------ coordinate systems

    def enter(self, placement: Frame, lower: list[float]) -> None:
        """The active coordinate system lies in the machine as `placement` says; `lower` (n,) counts from the fourth axis on.

        Nothing moves: the place on the machine stays, the position is told anew.
        """
        machine, programmed = self.machine(), self.programmed()
        shifted = placement.only_shifted
        self.frame = None if shifted else placement
        main = placement.origin.tolist() if shifted else [0.0] * MAIN
        self.lower = [*main, *lower[MAIN:]][: len(machine)]
        self.update()
        self.position = self.of_machine(machine)
        self.left_programmed = programmed

    def machine(self, position: Sequence[float] | None = None) -> list[float]:
        """Machine coordinates (n,) of the position, or of another one that counts as it does."""
        here = self.position if position is None else position
        if self.frame is None:
            return list(here)
        return [*self.frame.outer(here[:MAIN]).tolist(), *here[MAIN:]]

    def of_machine(self, place: Sequence[float]) -> list[float]:
        """Machine coordinates (n,) as the position counts."""
        if self.frame is None:
            return [float(value) for value in place]
        return [*self.frame.inner(place[:MAIN]).tolist(), *(float(value) for value in place[MAIN:])]

    def moved_to(self, place: Sequence[float]) -> None:
        """Something has moved the axes to a place on the machine, (n,)."""
        self.moved(self.of_machine(place))

    def in_system(self, axis: int) -> float:
        """Where the position lies in the active coordinate system, with the offsets that are programmed in it."""
        return self.position[axis] - (self.lower[axis] if axis < MAIN else 0.0)

    def suppress(self, kinds: Iterable[str]) -> None:
        """Leave out kinds of offsets (the keys of #SUPPRESS OFFSETS) until `resume`."""
        self.left_out = frozenset(kinds)
        self.update()

    def resume(self) -> None:
        """All offsets hold again."""
        if self.left_out:
            self.left_out = frozenset()
            self.update()

    def target(self, words: Mapping[int, float], incremental: Mapping[int, bool] | bool) -> list[float]:
        """Machine position after a move to the programmed words (axis → mm or degrees, inch already converted)."""
        end = self.position.copy()
        plane = self.rotation.plane if self.rotation is not None else ()
        for axis, value in words.items():
            if axis in plane:
                continue
            relative = incremental if isinstance(incremental, bool) else incremental.get(axis, False)
            step = value * self.gain[axis]
            end[axis] = end[axis] + step if relative else step + self.shift[axis]
        if self.rotation is not None and any(axis in words for axis in plane):
            self._rotated(end, words, incremental, self.rotation)
        return end

    def _rotated(
        self, end: list[float], words: Mapping[int, float], incremental: Mapping[int, bool] | bool, rotation: Rotation
    ) -> None:
        """Targets of the two axes of a rotated plane; a coordinate that is not programmed stays what it is there."""
        first, second = rotation.plane
        now = self.programmed_in_plane(rotation)
        wanted = list(now)
        for place, axis in enumerate(rotation.plane):
            if axis in words:
                relative = incremental if isinstance(incremental, bool) else incremental.get(axis, False)
                wanted[place] = words[axis] * self.scale_of(axis) + (now[place] if relative else 0.0)
        turned = rotation.turned(*wanted)
        for place, axis in ((0, first), (1, second)):
            end[axis] = (turned[place] + rotation.centre[place]) * self.mirror(axis) + self.shift[axis]

    def mirror(self, axis: int) -> float:
        """-1 for an axis that is mirrored, else 1."""
        return self.mirror_plane[axis] * self.mirror_axis[axis]

    def scale_of(self, axis: int) -> float:
        """The factor that programmed values of an axis are multiplied with, 1 while scaling is off."""
        return self.scale[axis] if self.scale_active else 1.0

    def contour_place(self, axis: int) -> float:
        """Where the position lies on an axis of the contour: without offsets and mirroring, rotated and scaled as it is."""
        return (self.position[axis] - self.shift[axis]) * self.mirror(axis)

    def programmed_in_plane(self, rotation: Rotation) -> tuple[float, float]:
        """Where the machine position lies in the rotated plane, before rotation, scaled."""
        first, second = (self.contour_place(axis) - rotation.centre[i] for i, axis in enumerate(rotation.plane))
        return rotation.back(first, second)

    def in_plane(self, plane: tuple[int, int]) -> tuple[float, float]:
        """The position as it would be programmed in a plane, mm."""
        if self.rotation is not None and self.rotation.plane == plane:
            first, second = self.programmed_in_plane(self.rotation)
        else:
            first, second = self.contour_place(plane[0]), self.contour_place(plane[1])
        return first / self.scale_of(plane[0]), second / self.scale_of(plane[1])

    def machine_in_plane(self, plane: tuple[int, int], point: tuple[float, float]) -> tuple[float, float]:
        """Machine coordinates of a programmed point of a plane, mm."""
        end = self.target(dict(zip(plane, point, strict=True)), False)
        return end[plane[0]], end[plane[1]]

    def moved(self, end: list[float]) -> None:
        """A motion was decoded."""
        self.position = end
        self.left_programmed = None
        self.travelled = (self.gain, self.shift)
        self.last_rotation = self.rotation

    def programmed(self) -> list[float]:
        """Programmed coordinates of the last motion, mapped onto the machine axes where a rotation is active."""
        if self.left_programmed is not None:
            return self.left_programmed
        gain, shift = self.travelled
        return [(p - s) / g for p, g, s in zip(self.position, gain, shift, strict=True)]

    def programmed_of(self, place: list[float]) -> list[float]:
        """Programmed coordinates of a machine position under what is selected now, both (n,), with the rotation taken out."""
        programmed = [(p - s) / g for p, g, s in zip(place, self.gain, self.shift, strict=True)]
        if self.rotation is not None:
            plane, centre = self.rotation.plane, self.rotation.centre
            first, second = (
                (place[axis] - self.shift[axis]) * self.mirror(axis) - centre[k] for k, axis in enumerate(plane)
            )
            for axis, value in zip(plane, self.rotation.back(first, second), strict=True):
                programmed[axis] = value / self.scale_of(axis)
        return programmed

    def array(self) -> Floats:
        """The position on the machine as (n,)."""
        return np.array(self.machine())
