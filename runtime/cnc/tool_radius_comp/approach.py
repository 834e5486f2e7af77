"""How the tool comes to the contour and leaves it: the strategies of the ISG dialect.

Each makes the way from the point `from_` to the begin of the first compensated element. Leaving is the same seen backwards:
the last element is turned around, and so is the way that comes out.

    direct         straight to the normal of the start of the first element
    indirect       the same at inside corners; at outside ones the approach ends on its own normal, the corner follows
    perpendicular  a line of its own along the normal
    tangential     an arc that ends in the direction of the element, on its normal
    on the path    along the programmed approach to where it meets the offset, or to one radius before its end and
                   from there around that end
    inside corner  straight to where last and first element of the closed contour meet

An approach along an arc always ends on its own normal, with the corner behind it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from runtime.cnc.blocks import Approach, CompensationSettings
from runtime.cnc.tool_radius_comp.corners import join
from runtime.cnc.tool_radius_comp.elements import (
    ARC,
    ELEMENT,
    GOOD,
    LINE,
    NO_LENGTH,
    TWISTED,
    Element,
    Elements,
    offset,
    place,
    way_on,
)
from runtime.cnc.tool_radius_comp.meeting import NEAR, meet_circles, meet_line_circle, meet_lines
from runtime.cnc.tool_radius_comp.pieces import Piece, Point, corner_pieces, element_piece
from runtime.diagnostics.catalogue import radius as catalogue
from runtime.diagnostics.errors import ErrorEntry

RIGHT_ANGLE = math.pi / 2 - 1e-9


class ApproachError(Exception):
    """The approach is not possible; `entry` and `values` say why."""

    def __init__(self, entry: ErrorEntry, **values: object) -> None:
        super().__init__(entry.id)
        self.entry, self.values = entry, values


@dataclass(frozen=True, slots=True)
class Way:
    """The pieces of an approach, and how far along the first element it leads (mm, negative where that is extended)."""

    pieces: tuple[Piece, ...]
    begin: float = 0.0


def enter(
    approach: Approach,
    from_: Point,
    block: Elements,
    first: Element,
    settings: CompensationSettings,
    corner: float = 0.0,
) -> Way:
    """The way from the point `from_` to `first`, whose offset is computed already.

    `block` (1,) is the approach block as it is programmed, `corner` for the inside corner the way along `first` to it.
    """
    if approach is Approach.PERPENDICULAR:
        return Way((Piece(_start(first)),))
    if approach is Approach.TANGENTIAL:
        return Way((_tangential(from_, first),))
    if approach is Approach.INSIDE_CORNER:
        x, y = place(first, corner)
        return Way((Piece((float(x), float(y))),), corner)
    if approach is Approach.ON_PATH:
        return _on_path(block, first, settings)
    inside = turn_to_tool(block[0], first) >= 0.0
    if block["kind"][0] == LINE and (inside or approach is not Approach.INDIRECT):
        return Way((Piece(_start(first)),))
    return _with_corner(block, first, settings)


def turn_to_tool(block: Element, first: Element) -> float:
    """Turn from the end of an element to the start of the next, rad, positive towards the tool (an inside corner)."""
    t, u = _end_tangent(block), (float(first["t0x"]), float(first["t0y"]))
    return math.atan2(t[0] * u[1] - t[1] * u[0], t[0] * u[0] + t[1] * u[1]) * math.copysign(1.0, first["o0"])


def reversed_element(e: Element) -> Elements:
    """An element (1,) travelled the other way: what was left of it is right of it now. Its offset is computed."""
    turned = np.zeros(1, ELEMENT)
    for name, other in (("x0", "x1"), ("y0", "y1"), ("x1", "x0"), ("y1", "y0"), ("cx", "cx"), ("cy", "cy")):
        turned[name] = e[other]
    turned["kind"], turned["sweep"] = e["kind"], -e["sweep"]
    turned["o0"], turned["o1"] = -e["o1"], -e["o0"]
    offset(turned, 0, 1)
    return turned


def reversed_way(way: Way, from_: Point) -> tuple[Piece, ...]:
    """The pieces of a way that began at `from_`, travelled the other way: they end there."""
    starts = [from_, *(piece.end for piece in way.pieces[:-1])]
    pairs = list(zip(way.pieces, starts, strict=True))
    return tuple(Piece(start, piece.centre, -piece.angle) for piece, start in reversed(pairs))


def _start(e: Element) -> Point:
    return float(e["px"]), float(e["py"])


def _end_tangent(e: Element) -> Point:
    """Direction of a programmed element at its end."""
    if e["kind"] == LINE:
        dx, dy = float(e["x1"] - e["x0"]), float(e["y1"] - e["y0"])
    else:
        sense = math.copysign(1.0, e["sweep"])
        dx, dy = float(e["cy"] - e["y1"]) * sense, float(e["x1"] - e["cx"]) * sense
    length = math.hypot(dx, dy)
    return dx / length, dy / length


def _tangential(from_: Point, first: Element) -> Piece:
    """The arc from a point that ends at the start of the offset in its direction; a line where it would be straight."""
    x, y = _start(first)
    tx, ty = float(first["t0x"]), float(first["t0y"])
    wx, wy = from_[0] - x, from_[1] - y
    square, left = wx * wx + wy * wy, wy * tx - wx * ty
    ahead = wx * tx + wy * ty
    if square <= NO_LENGTH**2:
        raise ApproachError(catalogue.APPROACH_IMPOSSIBLE)
    if abs(left) <= NEAR:
        if ahead > 0.0:
            raise ApproachError(catalogue.APPROACH_IMPOSSIBLE)
        return Piece((x, y))
    reach = square / (2.0 * left)  # to the centre, along the left normal
    centre = x - ty * reach, y + tx * reach
    sense = math.copysign(1.0, reach)
    ux, uy = from_[0] - centre[0], from_[1] - centre[1]
    vx, vy = x - centre[0], y - centre[1]
    angle = math.atan2(ux * vy - uy * vx, ux * vx + uy * vy) * sense
    return Piece((x, y), centre, sense * (angle if angle > 0.0 else angle + 2.0 * math.pi))


def _with_corner(block: Elements, first: Element, settings: CompensationSettings) -> Way:
    """The radius is built up over the whole approach block, the corner is that of any two elements."""
    pair = np.zeros(2, ELEMENT)
    pair[0], pair[1] = block[0], first
    pair[0]["o0"], pair[0]["o1"] = 0.0, first["o0"]
    offset(pair, 0, 1)
    if pair[0]["status"] == TWISTED:
        raise ApproachError(catalogue.CHANGE_OVER_ARC, before=0.0, after=abs(float(first["o0"])))
    e, f = pair[0], pair[1]
    join(e, f, settings.circular, settings.stretch, corner_limit(settings))
    if e["status"] != GOOD:
        raise ApproachError(catalogue.OFFSETS_APART, radius=abs(float(first["o0"])))
    return Way((element_piece(e), *corner_pieces(e)), float(f["begin"]))


def corner_limit(settings: CompensationSettings) -> float:
    """Turn in rad up to which an outside corner gets no inserted block."""
    return math.radians(1.0) if settings.extended_limit else 0.0


def _on_path(block: Elements, first: Element, settings: CompensationSettings) -> Way:
    radius = abs(float(first["o0"]))
    inside = turn_to_tool(block[0], first)
    if radius <= NEAR:
        return Way((_part(block, *_start(first)),))
    if inside > RIGHT_ANGLE or (settings.line_on_path and inside >= 0.0):
        x, y = _meeting(block, first, radius)
        begin = float(way_on(first, x, y))
        pieces = [_part(block, x, y)]
        if begin < 0.0:
            pieces.append(Piece(_start(first)))
            begin = 0.0
        return Way(tuple(pieces), begin)
    x, y = _before_end(block, radius)
    arc = _around(block, first, (x, y))
    part = _part(block, x, y)
    return Way((part,) if arc is None else (part, arc))


def _meeting(block: Elements, first: Element, radius: float) -> Point:
    """Where the programmed approach comes to the offset of the first element, the last such place."""
    plain = block.copy()
    plain["o0"] = plain["o1"] = 0.0
    offset(plain, 0, 1)
    e = plain[0]
    if e["kind"] == LINE and first["kind"] == LINE:
        found, x, y = meet_lines(e["px"], e["py"], e["dx"], e["dy"], first["px"], first["py"], first["dx"], first["dy"])
        places = [(x, y)] if found else []
    elif e["kind"] == LINE or first["kind"] == LINE:
        line, arc = (e, first) if e["kind"] == LINE else (first, e)
        found, *xy = meet_line_circle(
            line["px"], line["py"], line["dx"], line["dy"], arc["mx"], arc["my"], arc["radius"]
        )
        places = [(xy[0], xy[1]), (xy[2], xy[3])] if found else []
    else:
        found, *xy = meet_circles(e["mx"], e["my"], e["radius"], first["mx"], first["my"], first["radius"])
        places = [(xy[0], xy[1]), (xy[2], xy[3])] if found else []
    length = float(e["length"])
    ways = sorted((float(way_on(e, *point)), point) for point in places)
    there = [point for way, point in ways if -NEAR <= way <= length + NEAR]
    if not there:
        raise ApproachError(catalogue.APPROACH_SHORT, radius=radius, needed=length - (ways[-1][0] if ways else 0.0))
    return there[-1]


def _before_end(block: Elements, radius: float) -> Point:
    """The place on the programmed approach that is one radius away from its end."""
    e = block[0]
    x1, y1 = float(e["x1"]), float(e["y1"])
    if e["kind"] == LINE:
        length = math.hypot(float(e["x1"] - e["x0"]), float(e["y1"] - e["y0"]))
        if length < radius - NEAR:
            raise ApproachError(catalogue.APPROACH_SHORT, radius=radius, needed=radius)
        tx, ty = _end_tangent(e)
        return x1 - tx * radius, y1 - ty * radius
    arc_radius = math.hypot(x1 - float(e["cx"]), y1 - float(e["cy"]))
    if radius > 2.0 * arc_radius or 2.0 * math.asin(radius / 2.0 / arc_radius) > abs(e["sweep"]):
        raise ApproachError(catalogue.APPROACH_SHORT, radius=radius, needed=radius)
    back = -math.copysign(2.0 * math.asin(radius / 2.0 / arc_radius), e["sweep"])
    ux, uy = x1 - float(e["cx"]), y1 - float(e["cy"])
    return (
        float(e["cx"]) + ux * math.cos(back) - uy * math.sin(back),
        float(e["cy"]) + ux * math.sin(back) + uy * math.cos(back),
    )


def _around(block: Elements, first: Element, begin: Point) -> Piece | None:
    """The arc about the end of the approach to the start of the first element, away from the contour."""
    e = block[0]
    centre = float(e["x1"]), float(e["y1"])
    goal = _start(first)
    ux, uy = begin[0] - centre[0], begin[1] - centre[1]
    vx, vy = goal[0] - centre[0], goal[1] - centre[1]
    sense = -math.copysign(1.0, first["o0"])
    angle = math.atan2(ux * vy - uy * vx, ux * vx + uy * vy) * sense
    if abs(angle) * math.hypot(ux, uy) <= NEAR:
        return None
    return Piece(goal, centre, sense * (angle if angle > 0.0 else angle + 2.0 * math.pi))


def _part(block: Elements, x: float, y: float) -> Piece:
    """The programmed approach up to a place on it."""
    e = block[0]
    if e["kind"] != ARC:
        return Piece((float(x), float(y)))
    centre = float(e["cx"]), float(e["cy"])
    ux, uy = float(e["x0"]) - centre[0], float(e["y0"]) - centre[1]
    vx, vy = x - centre[0], y - centre[1]
    sense = math.copysign(1.0, e["sweep"])
    angle = math.atan2(ux * vy - uy * vx, ux * vx + uy * vy) * sense
    return Piece((float(x), float(y)), centre, sense * (angle if angle > -1e-12 else angle + 2.0 * math.pi))
