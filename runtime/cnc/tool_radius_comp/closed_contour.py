"""A closed contour that is entered where it ends (G238): kept whole up to G40, since the approach needs its last element.

    P1  ── approach ──▶  corner of the offsets of last and first element ── contour ──▶ the same corner ── exit ──▶

Where that corner is an outside one the approach ends on the normal of the first element and the contour on that of the last.
"""

from __future__ import annotations

import math

import numpy as np

from runtime.cnc.blocks import Arc, Block, CompensationSettings, Floats, Line, Polyline
from runtime.cnc.tool_radius_comp.approach import ApproachError, Way, turn_to_tool
from runtime.cnc.tool_radius_comp.corners import join
from runtime.cnc.tool_radius_comp.elements import ARC, ELEMENT, GOOD, LINE, NONE, Elements, offset
from runtime.cnc.tool_radius_comp.meeting import NEAR, meet_line_circle
from runtime.cnc.tool_radius_comp.pieces import Piece
from runtime.cnc.tool_radius_comp.window import Window
from runtime.diagnostics.catalogue import radius as catalogue

MOST_KEPT = 20_000  # blocks, a move of a run counts as one
CLOSED = 1e-4  # mm: a contour whose ends are farther apart is open
FLAT = 1e-9  # rad: an approach that goes straight on turns by less
WHOLE_TURN = 2.0 * math.pi - 1e-9


class ClosedContour:
    """What follows the approach block. `blocks` in order, with the changes of settings between them."""

    def __init__(self, approach: Line, plane: tuple[int, int]) -> None:
        self.approach = approach
        self.blocks: list[Block] = []
        self._plane = plane
        self._window = Window(len(approach.start), plane)
        self._kept = 0

    @property
    def moves(self) -> bool:
        """Whether there is a motion in the plane."""
        self._window.load(0.0)
        return bool((self._window.elements["kind"][: self._window.count] != NONE).any())

    @property
    def full(self) -> bool:
        """It is longer than what is kept."""
        return self._kept > MOST_KEPT

    def add(self, block: Block) -> None:
        """The next block."""
        self._kept += len(block.feeds) if isinstance(block, Polyline) else 1
        self.blocks.append(block)
        if isinstance(block, Line | Arc | Polyline):
            self._window.add(block)

    def corner(self, distance: float, settings: CompensationSettings) -> tuple[Way, float]:
        """The approach, and how much is left of the last element, mm; offsets are `distance` mm to the left.

        Raises ApproachError for a contour that cannot be entered so (manual lines 19403–19437).
        """
        self._window.load(distance)
        elements = self._window.elements[: self._window.count]
        elements = elements[elements["kind"] != NONE]
        elements["o0"] = elements["o1"] = distance
        approach = np.zeros(1, ELEMENT)
        for axis, (begin, end) in zip(self._plane, (("x0", "x1"), ("y0", "y1")), strict=True):
            approach[begin], approach[end] = self.approach.start[axis], self.approach.end[axis]
        approach["kind"] = LINE
        offset(elements, 0, len(elements))
        _expect_closed(approach, elements, distance)
        pair = np.concatenate([elements[-1:], elements[:1]])
        last, first = pair[0], pair[1]
        if distance == 0.0 or turn_to_tool(last, first) < 0.0:
            return Way((Piece((float(first["px"]), float(first["py"]))),)), float(last["length"])
        join(last, first, settings.circular, settings.stretch, 0.0)
        if last["status"] != GOOD:
            raise ApproachError(catalogue.OFFSETS_APART, radius=abs(distance))
        return Way((Piece((float(first["bx"]), float(first["by"]))),), float(first["begin"])), float(last["end"])


def _expect_closed(approach: Elements, elements: Elements, distance: float) -> None:
    """ApproachError if one of the restrictions is violated."""
    last, first, way = elements[-1], elements[0], approach[0]
    if math.hypot(last["x1"] - way["x1"], last["y1"] - way["y1"]) > CLOSED:
        raise _error("it does not end where it begins")
    if last["kind"] == ARC and abs(last["sweep"]) >= WHOLE_TURN:
        raise _error("its last element is a full circle")
    if distance != 0.0 and turn_to_tool(way, first) < -FLAT:
        raise _error("its first element turns away from the tool")
    if _nearest(elements, float(way["x0"]), float(way["y0"])) < abs(distance) - NEAR:
        raise _error(f"the approach begins nearer to it than the radius of {abs(distance):g} mm")
    if _crosses(way, elements[1:-1]):
        raise _error("the approach crosses it")


def _error(why: str) -> ApproachError:
    return ApproachError(catalogue.INSIDE_CORNER, why=why)


def _nearest(elements: Elements, x: float, y: float) -> float:
    """Distance of a point from the programmed elements, mm."""
    ends = np.minimum(
        np.hypot(elements["x0"] - x, elements["y0"] - y), np.hypot(elements["x1"] - x, elements["y1"] - y)
    )
    lines, arcs = elements[elements["kind"] == LINE], elements[elements["kind"] == ARC]
    ux, uy = lines["x1"] - lines["x0"], lines["y1"] - lines["y0"]
    length = np.hypot(ux, uy)
    along = ((x - lines["x0"]) * ux + (y - lines["y0"]) * uy) / length
    beside = np.abs((y - lines["y0"]) * ux - (x - lines["x0"]) * uy) / length
    there = beside[(along >= 0.0) & (along <= length)]
    radius = np.hypot(arcs["x0"] - arcs["cx"], arcs["y0"] - arcs["cy"])
    to_circle = np.abs(np.hypot(x - arcs["cx"], y - arcs["cy"]) - radius)[_within(arcs, x, y)]
    return float(min(ends.min(), there.min(initial=math.inf), to_circle.min(initial=math.inf)))


def _within(arcs: Elements, x: Floats | float, y: Floats | float) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Whether points lie in the angle of the arcs, (k,)."""
    begin = np.arctan2(arcs["y0"] - arcs["cy"], arcs["x0"] - arcs["cx"])
    here = np.arctan2(y - arcs["cy"], x - arcs["cx"])
    turned = np.mod((here - begin) * np.sign(arcs["sweep"]), 2.0 * np.pi)
    return np.asarray(turned <= np.abs(arcs["sweep"]))


def _crosses(way: np.void, elements: Elements) -> bool:
    """Whether a line has a point in common with one of the programmed elements."""
    x, y = float(way["x0"]), float(way["y0"])
    dx, dy = float(way["x1"]) - x, float(way["y1"]) - y
    length = math.hypot(dx, dy)
    dx, dy = dx / length, dy / length
    lines, arcs = elements[elements["kind"] == LINE], elements[elements["kind"] == ARC]
    first, second = (dx * (lines[f"y{end}"] - y) - dy * (lines[f"x{end}"] - x) for end in "01")
    there = first * second <= 0.0
    lines, first, second = lines[there], first[there], second[there]
    share = np.where(first == second, 0.0, first / np.where(first == second, 1.0, first - second))
    along = dx * (lines["x0"] - x) + dy * (lines["y0"] - y)
    along = along + share * (dx * (lines["x1"] - lines["x0"]) + dy * (lines["y1"] - lines["y0"]))
    if ((along >= 0.0) & (along <= length)).any():
        return True
    for arc in arcs:
        radius = math.hypot(arc["x0"] - arc["cx"], arc["y0"] - arc["cy"])
        found, *places = meet_line_circle(x, y, dx, dy, arc["cx"], arc["cy"], radius)
        for px, py in ((places[0], places[1]), (places[2], places[3]))[:found]:
            if 0.0 <= (px - x) * dx + (py - y) * dy <= length and _within(arc[None], px, py)[0]:
                return True
    return False
