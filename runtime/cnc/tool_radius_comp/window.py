"""The blocks that the compensation has in hand: motions as elements of arrays, everything else in its place between them.

    blocks      Line  M8  Polyline ────────── BlockEnd  Line
    elements     0         1   2   3   …                 k      programmed and offset geometry, one record each

A run of straight moves stays a run. Blocks that move nothing in the plane keep their place in the stream; what they move
beside the plane they move where the tool path is then.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from runtime.cnc.blocks import Arc, Block, CompensationSettings, Floats, Line, Polyline, Source
from runtime.cnc.tool_radius_comp.corners import vertices
from runtime.cnc.tool_radius_comp.elements import (
    ARC,
    CIRCLE,
    ELEMENT,
    LINE,
    LINES,
    NO_INSERT,
    NO_LENGTH,
    NO_RADIUS,
    NONE,
    Elements,
)
from runtime.cnc.tool_radius_comp.pieces import corner_pieces, in_pieces, straight

TRANSITION_SPEED = 2.0  # G11: inserted blocks run that much faster
_GROWTH = 256


class Window:
    """The motions in hand between `load` and `put_out`; `plane` are the indices of its two axes."""

    def __init__(self, axes: int, plane: tuple[int, int]) -> None:
        self.plane = plane
        self.elements: Elements = np.zeros(_GROWTH, ELEMENT)
        self.count = 0
        self._starts: Floats = np.zeros((_GROWTH, axes))
        self._ends: Floats = np.zeros((_GROWTH, axes))
        self._blocks: list[Block] = []
        self._loaded = 0  # blocks whose motions are in the arrays

    @property
    def waiting(self) -> int:
        """Blocks that were added and not loaded."""
        return len(self._blocks) - self._loaded

    @property
    def held(self) -> int:
        """All blocks in hand."""
        return len(self._blocks)

    def add(self, block: Block) -> None:
        """Take a block behind the others."""
        self._blocks.append(block)

    def load(self, offset: float) -> int:
        """Bring the motions that were added into the arrays, `offset` mm to the left; the first new element."""
        first = self.count
        run: list[Line | Arc] = []
        for block in self._blocks[self._loaded :]:
            if isinstance(block, Line | Arc):
                run.append(block)
            elif isinstance(block, Polyline):
                self._load_motions(run)
                run = []
                self._load_polyline(block)
        self._load_motions(run)
        self._loaded = len(self._blocks)
        new = self.elements[first : self.count]
        new["o0"] = new["o1"] = offset
        return first

    def _load_motions(self, run: list[Line | Arc]) -> None:
        if not run:
            return
        rows = self._room(len(run))
        self._starts[rows] = [motion.start for motion in run]
        self._ends[rows] = [motion.end for motion in run]
        self._places(rows)
        at = [number for number, motion in enumerate(run) if type(motion) is Arc]
        if not at:
            return
        arcs = [motion for motion in run if isinstance(motion, Arc)]
        new = self.elements[rows]
        sweep = np.radians([motion.angle for motion in arcs])
        radius = np.array([motion.radius for motion in arcs])
        new["kind"][at] = np.where(radius * np.abs(sweep) > NO_LENGTH, ARC, NONE)
        centres = np.array([motion.centre for motion in arcs])
        new["cx"][at], new["cy"][at], new["sweep"][at] = centres[:, 0], centres[:, 1], sweep

    def _load_polyline(self, run: Polyline) -> None:
        rows = self._room(len(run.feeds))
        self._starts[rows], self._ends[rows] = run.points[:-1], run.points[1:]
        self._places(rows)

    def _places(self, rows: slice) -> None:
        """Start and end in the plane, and the kind of lines."""
        first, second = self.plane
        new = self.elements[rows]
        new["x0"], new["y0"] = self._starts[rows, first], self._starts[rows, second]
        new["x1"], new["y1"] = self._ends[rows, first], self._ends[rows, second]
        length = np.hypot(new["x1"] - new["x0"], new["y1"] - new["y0"])
        new["kind"] = np.where(length > NO_LENGTH, LINE, NONE)

    def _room(self, count: int) -> slice:
        rows = slice(self.count, self.count + count)
        while len(self.elements) < rows.stop:
            more = max(len(self.elements), _GROWTH)
            self.elements = np.concatenate([self.elements, np.zeros(more, ELEMENT)])
            self._starts = np.concatenate([self._starts, np.zeros((more, self._starts.shape[1]))])
            self._ends = np.concatenate([self._ends, np.zeros((more, self._ends.shape[1]))])
        self.count = rows.stop
        return rows

    # ------------------------------------------------------------------ out

    def motion_at(self, element: int) -> Line | Arc:
        """The programmed motion of an element."""
        at = 0
        for block in self._blocks:
            if isinstance(block, Line | Arc):
                if at == element:
                    return block
                at += 1
            elif isinstance(block, Polyline):
                if at <= element < at + len(block.feeds):
                    return move_of(block, element - at)
                at += len(block.feeds)
        raise IndexError(element)

    def put_out(self, behind: int, settings: CompensationSettings) -> list[Block]:
        """The tool path of the elements before `behind`, and what stands between and directly after them.

        Blocks in front of element `behind` go out too. What is put out is no longer in hand.
        """
        blocks, loaded = self._blocks, self._loaded
        out: list[Block] = []
        path = _Path(self, behind, settings, out)
        at = taken = 0
        for block in blocks:
            kind = type(block)
            if kind is Line or kind is Arc:
                if at >= behind:
                    break
                path.motion(block, at)  # type: ignore[arg-type]
                at += 1
            elif isinstance(block, Polyline):
                if at >= behind:
                    break
                here = min(behind - at, len(block.feeds))
                path.run(part(block, 0, here), at)
                at += here
                if here < len(block.feeds):
                    blocks[taken] = part(block, here, len(block.feeds))
                    break
            else:
                out.append(block)
            taken += 1
        self._blocks, self._loaded = blocks[taken:], loaded - taken
        rest = self.count - behind
        for array in (self.elements, self._starts, self._ends):
            array[:rest] = array[behind : self.count].copy()
        self.count = rest
        return out

    def placed(self, behind: int) -> tuple[Floats, Floats, Floats]:
        """Starts and ends on the tool path of the elements before `behind`, and by what their ends were moved, (k, n)."""
        elements = self.elements[:behind]
        first, second = self.plane
        starts, ends = self._starts[:behind].copy(), self._ends[:behind].copy()
        starts[:, first], starts[:, second] = elements["bx"], elements["by"]
        ends[:, first], ends[:, second] = elements["ex"], elements["ey"]
        return starts, ends, ends - self._ends[:behind]


class _Path:
    """Elements of a window on their way to `out`."""

    def __init__(self, window: Window, behind: int, settings: CompensationSettings, out: list[Block]) -> None:
        self._elements = elements = window.elements[:behind]
        self._plane = window.plane
        self._adapt, self._adapted_from = settings.adapt_feed, settings.adapted_from
        self._out = out
        starts, ends, moved = window.placed(behind)
        self._starts, self._ends, self._moved = list(starts), list(ends), list(moved)
        self._insert: list[int] = elements["insert"].tolist()
        self._kinds: list[int] = elements["kind"].tolist()
        if (elements["kind"] == ARC).any():
            radius = np.where(elements["radius"] > NO_RADIUS, elements["radius"], 1.0)
            angle = np.degrees((elements["end"] - elements["begin"]) / radius) * np.sign(elements["turn"])
            whole = (elements["begin"] == 0.0) & (elements["end"] == elements["length"])
            angle = np.where(whole, np.degrees(elements["turn"]), angle)  # to the bit where nothing was cut
            self._radius: list[float] = elements["radius"].tolist()
            self._angle: list[float] = angle.tolist()
            self._centres = list(np.stack([elements["mx"], elements["my"]], axis=1))
        if any(self._insert):
            self._corners(ends)

    def _corners(self, ends: Floats) -> None:
        """What the corners behind the elements need: where each leads, and the angle of an arc around it."""
        e = self._elements
        following = ends.copy()
        following[:, self._plane[0]], following[:, self._plane[1]] = e["nx"], e["ny"]
        self._points: list[int] = e["points"].tolist()
        self._following = list(following)
        self._to_following = list(following - ends + np.asarray(self._moved))
        ux, uy, vx, vy = e["ex"] - e["x1"], e["ey"] - e["y1"], e["nx"] - e["x1"], e["ny"] - e["y1"]
        sense = -np.sign(e["o1"])  # around the corner, which lies on the other side than the tool
        angle = np.arctan2(ux * vy - uy * vx, ux * vx + uy * vy) * sense
        self._around: list[float] = np.degrees(sense * np.where(angle > 0.0, angle, angle + 2.0 * np.pi)).tolist()
        self._corner_places = list(np.stack([e["x1"], e["y1"]], axis=1))
        self._corner_radius: list[float] = np.abs(e["o1"]).tolist()

    def motion(self, block: Line | Arc, at: int) -> None:
        """The tool path of a motion and of the corner behind it."""
        start, end, gain = self._starts[at], self._ends[at], block.pcs_gain
        end_pcs = block.end_pcs + (self._moved[at] if gain is None else self._moved[at] / gain)
        if type(block) is Line:
            self._out.append(
                Line(
                    block.source, start, end, block.feed, block.rapid, end_pcs, block.plane, None,
                    block.end_feed, block.override_off, gain,
                )
            )  # fmt: skip
        elif self._kinds[at] != ARC or self._radius[at] <= NO_RADIUS:
            self._out.append(straight(block, start, end, block.feed))
        else:
            assert isinstance(block, Arc)
            feed = block.feed
            if self._adapt and block.radius >= self._adapted_from:
                feed *= self._radius[at] / block.radius
            self._out.append(
                Arc(
                    block.source, start, end, feed, end_pcs, block.plane, self._centres[at], self._radius[at],
                    self._angle[at], None, block.end_feed, block.override_off, gain,
                )
            )  # fmt: skip
        if self._insert[at] != NO_INSERT:
            self._corner(block, at)

    def _corner(self, block: Line | Arc, at: int) -> None:
        """What is inserted behind an element."""
        feed = self._transition(block)
        if self._insert[at] == LINES and self._points[at]:
            pieces = corner_pieces(self._elements[at])
            self._out.extend(in_pieces(block, self._ends[at], pieces, self._plane, feed))
            return
        end, gain = self._following[at], block.pcs_gain
        end_pcs = block.end_pcs + (self._to_following[at] if gain is None else self._to_following[at] / gain)
        if self._insert[at] == LINES:
            self._out.append(
                Line(
                    block.source, self._ends[at], end, feed, math.isinf(feed), end_pcs, block.plane, None,
                    None, block.override_off, gain,
                )
            )  # fmt: skip
        else:
            self._out.append(
                Arc(
                    block.source, self._ends[at], end, feed, end_pcs, self._plane, self._corner_places[at],
                    self._corner_radius[at], self._around[at], None, None, block.override_off, gain,
                )
            )  # fmt: skip

    def _transition(self, block: Line | Arc) -> float:
        feed = block.feed if block.end_feed is None else block.end_feed
        return feed * TRANSITION_SPEED if self._adapt else feed

    def run(self, run: Polyline, at: int) -> None:
        """The tool path of a run of straight moves, and of the corners in it and behind it."""
        here = self._elements[at : at + len(run.feeds)]
        done = 0
        for circle in np.flatnonzero(here["insert"] == CIRCLE).tolist():
            self._out.append(self._straight(part(run, done, circle + 1), at + done))
            self._corner(move_of(run, circle), at + circle)
            done = circle + 1
        if done < len(run.feeds):
            self._out.append(self._straight(part(run, done, len(run.feeds)), at + done))

    def _straight(self, run: Polyline, at: int) -> Polyline:
        count = len(run.feeds)
        behind = at + count
        points = np.vstack([self._starts[at], self._ends[at:behind]])
        if not any(self._insert[at:behind]):
            return replace(run, points=points)
        index, xy = np.empty(4 * count, np.int64), np.empty((4 * count, 2))
        made = vertices(self._elements, at, behind, index, xy)
        index, xy = index[:made] - at, xy[:made]
        points = np.vstack([points[:1], points[1:][index]])
        points[1:, self._plane[0]], points[1:, self._plane[1]] = xy[:, 0], xy[:, 1]
        feeds = run.feeds[index]
        if self._adapt:
            feeds[1:] *= np.where(index[1:] == index[:-1], TRANSITION_SPEED, 1.0)
        return replace(run, points=points, feeds=feeds, lines=run.lines[index], numbers=run.numbers[index])


def part(run: Polyline, first: int, behind: int) -> Polyline:
    """The moves `first` to before `behind` of a run."""
    if first == 0 and behind == len(run.feeds):
        return run
    return replace(
        run,
        points=run.points[first : behind + 1],
        feeds=run.feeds[first:behind],
        lines=run.lines[first:behind],
        numbers=run.numbers[first:behind],
    )


def move_of(run: Polyline, at: int) -> Line:
    """A move of a run as a block of its own."""
    end = run.points[at + 1]
    gain = 1.0 if run.pcs_gain is None else run.pcs_gain
    number = int(run.numbers[at])
    return Line(
        Source(run.program, int(run.lines[at]), None if number < 0 else number),
        run.points[at],
        end,
        float(run.feeds[at]),
        math.isinf(run.feeds[at]),
        (end - run.pcs_shift) / gain,
        (0, 1) if run.plane is None else run.plane,
        pcs_gain=run.pcs_gain,
    )
