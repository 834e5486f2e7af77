"""Coordinates that count programmed numbers: what the control shows and what incremental words go on from.

    numbers ─ transformations ─ + local (G52) + shift (G92) + work offset + common offset + length + tool offset ─▶ machine

A new offset is seen at once: the position counts anew in it, and nothing moves. A transformation that is switched on or off, and
a length that is taken up by a motion, leave the numbers of the last point as they are: the next word goes on from them (manual
lines 4306-4394, 3310-3360). Such an axis is out of step until it is programmed again. An axis that is not programmed does
not move; only the two axes of a turned plane go together.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from runtime.cnc.blocks import Floats
from runtime.cnc.decoder.coordinates import Coordinates, Offsets, Rotation
from runtime.cnc.decoder.nct.transformations import Transformations


@dataclass(slots=True)
class NumberedCoordinates(Coordinates):
    """The offsets of the dialect beside those of `Coordinates`: lists of n axes, mm or degrees. After a change `update`.

    `numbers`: the last programmed point. `length`: tool length by axis, with the sign of G43 or G44. `displaced`: what G45 to G48
    have left in the position.
    """

    numbers: list[float] = field(default_factory=list)
    common: list[float] = field(default_factory=list)
    shifted: list[float] = field(default_factory=list)
    local: list[float] = field(default_factory=list)
    length: list[float] = field(default_factory=list)
    displaced: list[float] = field(default_factory=list)
    transformations: Transformations = field(default_factory=Transformations)
    out_of_step: set[int] = field(default_factory=set)
    aimed: tuple[list[float], list[float], frozenset[int]] | None = None  # the last target: machine, numbers, words

    @classmethod
    def at(cls, position: Floats) -> NumberedCoordinates:
        """At a machine position, nothing selected."""
        n = len(position)
        made = cls([float(p) for p in position], Offsets.none(n), [1.0] * n, [1.0] * n, [1.0] * n)
        made.turns, made.lower = [0.0] * n, [0.0] * n
        made.common, made.shifted, made.local = [0.0] * n, [0.0] * n, [0.0] * n
        made.length, made.displaced = [0.0] * n, [0.0] * n
        made.numbers = list(made.position)
        made.update()
        made.travelled = (made.gain, made.shift)
        return made

    @property
    def plain(self) -> bool:
        """Machine = numbers + shift for every axis by itself, and every axis is in step."""
        return self.rotation is None and not self.out_of_step

    def update(self) -> None:
        """As `Coordinates.update`, with what the transformations make of the zero of the numbers."""
        n = len(self.position)
        steps = self.transformations
        turned, scaled = steps.turned, steps.scaled
        self.rotation = None if turned is None else Rotation(turned.plane, turned.angle, (0.0, 0.0))
        self.scale_active = scaled is not None
        self.scale = [scaled.factor if scaled and axis in scaled.axes else 1.0 for axis in range(n)]
        self.mirror_axis = [-1.0 if axis in steps.mirrors else 1.0 for axis in range(n)]
        Coordinates.update(self)
        origin = steps.image([0.0] * n)
        self.shift = [self.shift[i] + origin[i] + self._added(i) for i in range(n)]

    def _added(self, axis: int) -> float:
        return (
            self.common[axis] + self.shifted[axis] + self.local[axis] + self.length[axis] + self.displaced[axis]
        )  # fmt: skip

    def recount(self, axes: Iterable[int] | None = None) -> None:
        """Count anew where axes stand, all of them without `axes`. The axes of a turned plane go together."""
        there = self._numbers_at(self.position)
        chosen = set(range(len(there)) if axes is None else axes)
        if self.rotation is not None and chosen & set(self.rotation.plane):
            chosen |= set(self.rotation.plane)
        self.numbers = [there[i] if i in chosen else number for i, number in enumerate(self.numbers)]
        self.out_of_step -= chosen

    def keep_numbers(self) -> None:
        """Something else is selected that does not count the last point anew."""
        expected = self.machine_of(self.numbers)
        self.out_of_step = {
            axis for axis, place in enumerate(expected) if abs(place - self.position[axis]) > 1e-9
        }  # fmt: skip

    def machine_of(self, numbers: list[float]) -> list[float]:
        """Machine position of programmed numbers."""
        origin = self.transformations.image([0.0] * len(numbers))
        image = self.transformations.image(numbers)
        return [image[i] + self.shift[i] - origin[i] for i in range(len(numbers))]

    def _numbers_at(self, machine: list[float]) -> list[float]:
        origin = self.transformations.image([0.0] * len(machine))
        return self.transformations.source([machine[i] - self.shift[i] + origin[i] for i in range(len(machine))])

    def absolute(
        self, words: Mapping[int, float], incremental: Mapping[int, bool] | bool
    ) -> dict[int, float]:  # fmt: skip
        """Words as absolute numbers."""
        wanted = {}
        for axis, value in words.items():
            relative = incremental if isinstance(incremental, bool) else incremental.get(axis, False)
            wanted[axis] = self.numbers[axis] + value if relative else value
        return wanted

    def target(self, words: Mapping[int, float], incremental: Mapping[int, bool] | bool) -> list[float]:
        """Machine position after a move to the programmed words (axis → mm or degrees, inch already converted)."""
        wanted = self.absolute(words, incremental)
        if self.rotation is not None and any(axis in wanted for axis in self.rotation.plane):
            for axis in self.rotation.plane:
                wanted.setdefault(axis, self.numbers[axis])
        end = Coordinates.target(self, wanted, False)
        numbers = [wanted.get(axis, number) for axis, number in enumerate(self.numbers)]
        self.aimed = (end, numbers, frozenset(wanted))
        return end

    def moved(self, end: list[float]) -> None:
        """A motion was decoded. Behind one that does not lead to the last target every axis counts anew where it stands:
        whoever has made it has not said what the numbers are."""
        Coordinates.moved(self, end)
        aimed, self.aimed = self.aimed, None
        if aimed is None or aimed[0] is not end:
            if self.transformations.none:  # the fast road comes here with every block
                self.numbers = [place - shift for place, shift in zip(end, self.shift, strict=True)]
                self.out_of_step.clear()
            else:
                self.recount()
            return
        _, self.numbers, words = aimed
        self.out_of_step -= words
        expected = self.machine_of(self.numbers)  # an axis that turns without end may have gone to another turn
        other = {axis for axis in words if abs(expected[axis] - end[axis]) > 1e-9}
        if other:
            self.recount(other)
