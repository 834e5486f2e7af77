"""Legs of a curve that is being collected, and the polynomials that they become."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from runtime.cnc.blocks import Block, BlockEnd, Floats, Line, Source, Spline, programmed_way
from runtime.cnc.geometry.bsplines import merged
from runtime.cnc.path_preparation.motion_pieces import Origin

Ints = npt.NDArray[np.int64]

MERGE_SHARE = 0.25  # of the tolerance, for merging


@dataclass(slots=True)
class Legs:
    """Legs of the curve that is being collected: k + 1 places, and what belongs to each leg."""

    points: list[Floats] = field(default_factory=list)
    origins: list[Origin] = field(default_factory=list)  # one per leg, shared between the legs of a run
    feeds: list[float] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    ends: list[bool] = field(default_factory=list)  # an NC block ends with the leg
    actions: dict[int, list[Block]] = field(default_factory=dict)  # behind so many legs

    def __len__(self) -> int:
        return len(self.feeds)

    def array(self) -> Floats:
        return np.array(self.points)

    def ends_from_actions(self) -> None:
        """Block ends that came as blocks become marks of their legs: they need no place of their own."""
        for count, actions in list(self.actions.items()):
            if count > 0 and isinstance(actions[0], BlockEnd) and not self.ends[count - 1]:
                self.ends[count - 1] = True
                self.actions[count] = actions[1:]
                if not actions[1:]:
                    del self.actions[count]

    def kept(self, places: Ints) -> Legs:
        """Legs between some of the points, the first and the last among them; functions stand at points that stay."""
        chosen = (places[1:] - 1).tolist()  # the leg that ends at a kept place stands for those before it
        number = {place: i for i, place in enumerate(places.tolist())}
        return Legs(
            [self.points[i] for i in places],
            [self.origins[i] for i in chosen],
            [min(self.feeds[a:b]) for a, b in pairwise(places.tolist())],
            [self.lines[i] for i in chosen],
            [self.numbers[i] for i in chosen],
            [any(self.ends[a:b]) for a, b in pairwise(places.tolist())],
            {number[k]: v for k, v in self.actions.items()},
        )

    def cut(self, at: int) -> tuple[Legs, Legs]:
        """Up to the middle of leg `at`, and the rest; what belongs to the end of the leg belongs to the rest."""
        first, rest = self.split(at + 1)
        first.points[-1] = middle = 0.5 * (self.points[at] + self.points[at + 1])
        first.ends[-1] = False
        behind = first.actions.pop(at + 1, [])
        half = Legs(
            [middle, *self.points[at + 1 :]], self.origins[at:], self.feeds[at:], self.lines[at:], self.numbers[at:],
            self.ends[at:], {k + 1: v for k, v in rest.actions.items()},
        )  # fmt: skip
        if behind:
            half.actions[1] = behind
        return first, half

    def split(self, count: int) -> tuple[Legs, Legs]:
        """The first `count` legs, and the rest."""
        first = Legs(
            self.points[: count + 1], self.origins[:count], self.feeds[:count], self.lines[:count],
            self.numbers[:count], self.ends[:count], {k: v for k, v in self.actions.items() if k <= count},
        )  # fmt: skip
        rest = Legs(
            self.points[count:], self.origins[count:], self.feeds[count:], self.lines[count:], self.numbers[count:],
            self.ends[count:], {k - count: v for k, v in self.actions.items() if k > count},
        )  # fmt: skip
        return first, rest


def straight_legs(legs: Legs) -> Iterator[Block]:
    """Legs as lines, each with what is to be done at its end."""
    legs.ends_from_actions()
    yield from legs.actions.pop(0, [])
    for i in range(len(legs)):
        origin, (start, end) = legs.origins[i], legs.points[i : i + 2]
        number, feed = legs.numbers[i], legs.feeds[i]
        source = Source(origin.program, legs.lines[i], None if number < 0 else number)
        yield Line(
            source, start, end, feed, math.isinf(feed), programmed_way(end - origin.pcs_shift, origin.pcs_gain),
            origin.plane or (0, 1), None, None,
            origin.override_off, origin.pcs_gain,
        )  # fmt: skip
        if legs.ends[i]:
            yield BlockEnd(source)
        yield from legs.actions.get(i + 1, [])


def handed_on(legs: Legs, made: Floats, leg: Ints, *, check_jerk: bool = True) -> Iterator[Block]:
    """Polynomials (k, 6, n) of legs, `leg` (k,) which one; cut where something is to be done, or the offsets change."""
    last = np.append(leg[1:] != leg[:-1], True)
    legs.ends_from_actions()
    cuts = {count for count in legs.actions if count > 0}
    cuts |= {i for i in range(1, len(legs)) if not alike(legs.origins[i - 1], legs.origins[i])}
    borders = [0, *sorted(cut for cut in cuts if cut < len(legs)), len(legs)]
    feeds, lines, numbers = np.array(legs.feeds), np.array(legs.lines), np.array(legs.numbers)
    ends = np.array(legs.ends)
    for begin, end in pairwise(borders):
        actions = legs.actions.get(end, [])
        there = slice(int(np.searchsorted(leg, begin)), int(np.searchsorted(leg, end)))
        origin, mine = legs.origins[begin], leg[there]
        block_ends = last[there] & ends[mine]
        yield replace(
            origin.polynomials(made[there]),
            feeds=feeds[mine],
            lines=lines[mine],
            numbers=numbers[mine],
            block_ends=block_ends,
            check_jerk=check_jerk,
        )
        yield from actions


def alike(first: Origin, second: Origin) -> bool:
    """Whether elements of both can share a run."""
    if first is second:
        return True
    one, two = first.pcs_gain, second.pcs_gain
    same = one is two or (one is not None and two is not None and np.array_equal(one, two))
    return bool(same and first.program == second.program and np.array_equal(first.pcs_shift, second.pcs_shift))


def straightened(made: Floats) -> None:
    """Straight spans (k, 6, n) get a parameter that runs evenly: on a long leg between close points it hardly moves at first."""
    way = made[:, 1:].sum(axis=1)
    square = (way**2).sum(axis=1)
    safe = np.where(square > 0.0, square, 1.0)
    away = np.zeros(len(made))
    for power in (1, 2, 3):
        along = (made[:, power] * way).sum(axis=1) / safe
        away = np.maximum(away, np.abs(made[:, power] - along[:, None] * way).max(axis=1))
    straight = (square > 0.0) & (away <= 1e-12 * np.sqrt(safe))
    made[straight, 1], made[straight, 2:] = way[straight], 0.0


def merged_legs(spline: Spline, legs: Legs) -> Legs:
    """Legs of which several have become one, where nothing is to be done between them."""
    points = legs.array()
    kept = np.zeros(len(points), dtype=np.bool_)
    borders = sorted({0, len(legs), *(k for k in legs.actions if 0 < k < len(legs))})
    borders = sorted({*borders, *(i for i in range(1, len(legs)) if legs.origins[i] is not legs.origins[i - 1])})
    for begin, end in pairwise(borders):
        part = np.zeros(end - begin + 1, dtype=np.bool_)
        merged(
            points[begin : end + 1],
            spline.deviation * MERGE_SHARE,
            spline.tracking_deviation * MERGE_SHARE if spline.tracking_deviation > 0.0 else math.inf,
            part,
        )
        kept[begin : end + 1] |= part
    return legs.kept(np.flatnonzero(kept))
