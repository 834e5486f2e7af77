"""The motions of the dialect: from the words of a block to lines and arcs (manual lines 952–1164)."""

from __future__ import annotations

import math

from runtime.cnc.decoder import circles
from runtime.cnc.decoder.circles import RESOLUTION, SAME_POINT, Circle, Point
from runtime.cnc.decoder.feed import path_length, require_feed
from runtime.cnc.decoder.modal import INCH, FeedMode, Motion, Plane
from runtime.cnc.decoder.motion import centre_point, emit_arc, plane_of, size_scale, straight
from runtime.cnc.decoder.motion import clockwise as turns_clockwise
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.goals import goal, whole_turns
from runtime.cnc.language.errors import LineError
from runtime.cnc.language.motion_words import WordKind
from runtime.diagnostics.catalogue import nct as catalogue

OUTSIDE = {Plane.XY: "K", Plane.ZX: "J", Plane.YZ: "I"}  # the letter of the centre that has no meaning in a plane


def line(x: NctExecution) -> None:
    """A straight move to the axis words, in rapid traverse or at feed."""
    line_to(x, goal(x).end)


def line_to(x: NctExecution, end: list[float]) -> None:
    """A straight move to a machine position (n_axes,)."""
    way = [e - s for s, e in zip(x.coordinates.position, end, strict=True)]
    straight(x, x.words, end, x.corner, _faster(x, way, None))
    x.coordinates.moved(end)


def arc(x: NctExecution) -> None:
    """An arc to the axis words, by R or by I, J, K; axes outside of the plane go along with it.

    Raises LineError 3011, 3012, 3014.
    """
    words, found = x.words, goal(x)
    end = found.end
    require_feed(x, words)
    plane, letters, _ = plane_of(x, words)
    if OUTSIDE[x.modal.plane] in words:
        raise LineError(catalogue.CIRCLE, words.place(OUTSIDE[x.modal.plane]))
    start = x.coordinates.position
    begin, last = (start[plane[0]], start[plane[1]]), (end[plane[0]], end[plane[1]])
    sense = turns_clockwise(x)
    radius = words.number("R")
    if any(letter in words for letter in letters):
        if radius is not None:
            raise LineError(catalogue.CIRCLE, words.place("R"))
        circle = _by_centre(x, begin, last, centre_point(x, plane, letters), sense)
    elif radius is not None:
        circle = _by_radius(x, begin, last, x.length(radius) * size_scale(x, plane), sense)
    else:
        raise LineError(catalogue.CIRCLE, words.all[0][0].column)
    turns = whole_turns(x, found, circle)
    if turns:
        circle = Circle(circle.centre, circle.radius, circle.angle + math.copysign(360.0 * turns, circle.angle))
    way = [e - s for s, e in zip(start, end, strict=True)]
    emit_arc(x, words, end, plane, circle, x.corner, _faster(x, way, (plane, circle)))
    x.coordinates.moved(end)


def _by_centre(x: NctExecution, begin: Point, goal: Point, centre: Point, clockwise: bool) -> Circle:
    """The arc around a centre; start and end may lie at different distances from it, which makes a spiral (line 1090)."""
    first, last, limit = math.dist(begin, centre), math.dist(goal, centre), x.nct.raddif
    if abs(last - first) > max(RESOLUTION, limit):
        raise LineError(catalogue.RADIUS_DIFFERENCE, x.words.column(WordKind.AXIS), start=first, end=last, limit=limit)
    return circles.by_kept_centre(begin, goal, centre, clockwise, limit, 0.0)


def _by_radius(x: NctExecution, begin: Point, goal: Point, radius: float, clockwise: bool) -> Circle:
    """The arc of a radius; with one below half the chord half a turn around a point of the chord, that far from the start
    (line 1112)."""
    chord = math.dist(begin, goal)
    if chord <= SAME_POINT:
        raise LineError(catalogue.CIRCLE_RADIUS, x.words.place("R"))
    size = abs(radius)
    if not SAME_POINT < size < chord / 2 - RESOLUTION:
        return circles.by_radius(begin, goal, radius, clockwise)
    share = size / chord
    centre = (begin[0] + share * (goal[0] - begin[0]), begin[1] + share * (goal[1] - begin[1]))
    return Circle(centre, size, -180.0 if clockwise else 180.0)


# -- feed ----------------------------------------------------------------------------------------------------------


def _faster(x: NctExecution, way: list[float], arc: tuple[tuple[int, int], Circle] | None) -> float:
    """The speed along the path as the queue measures it, per F.

    F holds along all axes together, a degree counting as a unit of length (line 1010); of a helix on its circle alone, unless
    HELICALF says otherwise. FEEDMAX of an axis limits it (line 1983).
    """
    feed = x.modal.feed
    if not feed or x.modal.motion is Motion.RAPID:
        return 1.0
    unit = INCH if x.modal.inch else 1.0
    linear = x.setup.linear
    moved = [abs(w) / unit if linear[axis] else abs(w) for axis, w in enumerate(way)]
    length = path_length(way, arc)
    if arc is None:
        driven = math.hypot(*moved)
    else:
        plane, circle = arc
        driven = math.radians(abs(circle.angle)) * circle.radius / unit
        for axis in plane:  # somewhere on the circle each of them may move at the speed of the circle
            moved[axis] = driven
        if x.nct.helicalf:
            driven = math.hypot(driven, *(m for axis, m in enumerate(moved) if axis not in plane))
    if driven <= 0.0:
        return 1.0
    faster = length / (driven * unit)
    slower = 1.0
    if x.nct.feedmax:
        speed = feed / unit * (x.modal.speed if x.modal.feed_mode is FeedMode.PER_REVOLUTION else 1.0)  # of `driven`
        for name, axis in x.axis_of.items():
            most = x.nct.feedmax.get(name, math.inf) * 60.0 / (unit if linear[axis] else 1.0)
            if moved[axis] / driven * speed > most:
                slower = min(slower, most * driven / (moved[axis] * speed))
    return faster * slower
