"""The vectors of a corner: where the tool passes between two motions (NCT manual 3563-3729, 3799-3841, 3874-3913).

    inside corner                     one vector, to the meeting point of both offset paths
    outside, 90 to 180 degrees        one vector, to the meeting point of the tangents
    outside, below 90 degrees         two vectors, each one radius beyond the end of its motion, a line between them

Angles are measured in the workpiece. An arc is not extended: its tangent is inserted, which gives one vector more. What two
motions have in common is computed with the radius that holds at the corner, whatever it was before.
"""

from __future__ import annotations

import math

import numpy as np

from runtime.cnc.blocks import Arc, Line
from runtime.cnc.tool_radius_comp.approach import turn_to_tool
from runtime.cnc.tool_radius_comp.corners import join
from runtime.cnc.tool_radius_comp.elements import APART, ARC, ELEMENT, LINE, Element, Elements, offset, way_back, way_on
from runtime.cnc.tool_radius_comp.meeting import NEAR, meet_circles, meet_line_circle, meet_lines
from runtime.cnc.tool_radius_comp.pieces import Piece, Point, corner_pieces

Plane = tuple[int, int]


class NoMeetingError(Exception):
    """Both offset paths have no point in common at an inside corner."""


def record(block: Line | Arc, plane: Plane, left: float) -> Elements:
    """A motion as an element (1,), its offset `left` mm to the left computed."""
    made = np.zeros(1, ELEMENT)
    e = made[0]
    first, second = plane
    e["x0"], e["y0"], e["x1"], e["y1"] = block.start[first], block.start[second], block.end[first], block.end[second]
    e["kind"] = LINE
    if isinstance(block, Arc):
        e["kind"], e["cx"], e["cy"], e["sweep"] = ARC, block.centre[0], block.centre[1], math.radians(block.angle)
    e["o0"] = e["o1"] = left
    offset(made, 0, 1)
    return made


def wall(end: Point, direction: tuple[float, float], left: float, before: bool) -> Elements:
    """An auxiliary line (1,) in a direction: it ends at a point if it stands `before` it, else it begins there."""
    made = np.zeros(1, ELEMENT)
    e = made[0]
    e["kind"] = LINE
    x, y = (end[0] - direction[0], end[1] - direction[1]) if before else end
    e["x0"], e["y0"], e["x1"], e["y1"] = x, y, x + direction[0], y + direction[1]
    e["o0"] = e["o1"] = left
    offset(made, 0, 1)
    return made


def square_end(e: Element) -> Point:
    """The point square to the end of a motion."""
    return float(e["qx"]), float(e["qy"])


def square_start(f: Element) -> Point:
    """The point square to the start of a motion."""
    return float(f["px"]), float(f["py"])


def is_inside(e: Element, f: Element) -> bool:
    """Whether the path turns towards the tool, or goes straight on."""
    return turn_to_tool(e, f) >= 0.0


def corner(e: Elements, f: Elements) -> list[Piece]:
    """The vectors between two motions with the same offset; the first one ends the motion in front. Raises NoMeetingError."""
    pair = np.concatenate([e, f])
    join(pair[0], pair[1], False, 1.0, 0.0)
    if pair[0]["status"] == APART:
        raise NoMeetingError
    here = Piece((float(pair[0]["ex"]), float(pair[0]["ey"])))
    return [here, *corner_pieces(pair[0])]


def change_of_side(e: Elements, f: Elements) -> list[Piece] | None:
    """The vectors where the side changes: the meeting point of both offset paths next to the corner, on prolonged paths too.

    That of two lines counts up to one radius beyond them, since it goes to infinity where they run straight on. Without one,
    for a straight motion in front: the points square to its end and to the start of the next. None: neither.
    """
    reach = abs(float(e[0]["o1"])) + NEAR if e[0]["kind"] == LINE and f[0]["kind"] == LINE else math.inf
    ways = []
    for x, y in _meeting_points(e[0], f[0]):
        back, on = _shorter(e[0], float(way_back(e[0], x, y))), _shorter(f[0], float(way_on(f[0], x, y)))
        if -reach <= back <= e[0]["length"] + NEAR and -reach <= on <= f[0]["length"] + NEAR:
            ways.append((round(abs(back) + abs(on), 6), back, (x, y)))
    if ways:
        return [Piece(min(ways)[2])]
    if e[0]["kind"] == LINE:
        return [Piece(square_end(e[0])), Piece(square_start(f[0]))]
    return None


def _shorter(e: Element, way: float) -> float:
    """Of the two ways around a circle the shorter one, negative beyond the motion."""
    if e["kind"] == ARC and way > math.pi * e["radius"]:
        return float(way - 2.0 * math.pi * e["radius"])
    return way


def moved_arc(e: Element, start: Point, end: Point) -> Piece | None:
    """An arc of the programmed radius and sense between two points, for a change of the side; None if they are too far apart."""
    radius = math.hypot(e["x0"] - e["cx"], e["y0"] - e["cy"])
    dx, dy = end[0] - start[0], end[1] - start[1]
    chord = math.hypot(dx, dy)
    if chord > 2.0 * radius or chord <= NEAR:
        return None
    sense = math.copysign(1.0, e["sweep"])
    half = math.asin(chord / 2.0 / radius)
    turn = 2.0 * half if abs(e["sweep"]) <= math.pi else 2.0 * (math.pi - half)
    beside = radius * math.cos(turn / 2.0) * sense  # of the centre, to the left of the chord
    centre = start[0] + dx / 2.0 - dy / chord * beside, start[1] + dy / 2.0 + dx / chord * beside
    return Piece(end, centre, sense * turn)


def arc_around(e: Element, f: Element | None, direction: tuple[float, float] | None) -> list[Piece]:
    """An arc about the corner, from the point square to the end of a motion to the one square to the start of the next, or
    square to a direction."""
    centre = float(e["x1"]), float(e["y1"])
    begin = square_end(e)
    left = float(e["o1"])
    if direction is not None:
        length = math.hypot(*direction)
        goal = centre[0] - direction[1] / length * left, centre[1] + direction[0] / length * left
    else:
        assert f is not None
        goal = square_start(f)
    ux, uy = begin[0] - centre[0], begin[1] - centre[1]
    vx, vy = goal[0] - centre[0], goal[1] - centre[1]
    sense = -math.copysign(1.0, left)
    angle = math.atan2(ux * vy - uy * vx, ux * vx + uy * vy) * sense
    if abs(angle) * abs(left) <= NEAR:
        return [Piece(begin)]
    return [Piece(begin), Piece(goal, centre, sense * (angle if angle > 0.0 else angle + 2.0 * math.pi))]


def to_wall(e: Elements, f: Elements, leaving: bool) -> list[Piece]:
    """The meeting point of an auxiliary line with the offset of a motion, nearest to the corner; without one the point square to
    the start of `f`, or if it leaves, to the end of `e`."""
    motion = (e if leaving else f)[0]
    ways = []
    for x, y in _meeting_points(e[0], f[0]):
        way = _shorter(motion, float(way_back(motion, x, y) if leaving else way_on(motion, x, y)))
        ways.append((abs(way), (x, y)))
    if ways:
        return [Piece(min(ways)[1])]
    return [Piece(square_end(motion) if leaving else square_start(motion))]


def _meeting_points(e: Element, f: Element) -> list[Point]:
    """What both offset paths, prolonged, have in common."""
    if e["kind"] == LINE and f["kind"] == LINE:
        found, x, y = meet_lines(e["qx"], e["qy"], e["dx"], e["dy"], f["px"], f["py"], f["dx"], f["dy"])
        return [(float(x), float(y))][:found]
    if e["kind"] == LINE or f["kind"] == LINE:
        line, arc = (e, f) if e["kind"] == LINE else (f, e)
        found, *xy = meet_line_circle(
            line["px"], line["py"], line["dx"], line["dy"], arc["mx"], arc["my"], arc["radius"]
        )
    else:
        found, *xy = meet_circles(e["mx"], e["my"], e["radius"], f["mx"], f["my"], f["radius"])
    return [(float(xy[0]), float(xy[1])), (float(xy[2]), float(xy[3]))][:found]


def without_small_gaps(pieces: list[Piece], least: float) -> list[Piece]:
    """Leave out the latter of two vectors that are nearer to each other than `least` mm in both axes."""
    if least <= 0.0:
        return pieces
    kept = [pieces[0]]
    for piece in pieces[1:]:
        last = kept[-1].end
        near = max(abs(piece.end[0] - last[0]), abs(piece.end[1] - last[1])) < least
        if not near or piece.centre is not None:
            kept.append(piece)
    return kept
