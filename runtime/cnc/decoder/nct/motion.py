"""The motions of the dialect: from the words of a block to lines and arcs (manual lines 952–1164)."""

from __future__ import annotations

import math

from runtime.cnc.decoder import circles
from runtime.cnc.decoder.circles import RESOLUTION, SAME_POINT, Circle, Point
from runtime.cnc.decoder.feed import path_length, require_feed
from runtime.cnc.decoder.modal import Plane
from runtime.cnc.decoder.motion import centre_point, emit_arc, plane_of, size_scale, straight, target
from runtime.cnc.decoder.motion import clockwise as turns_clockwise
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.language.errors import LineError
from runtime.cnc.language.motion_words import WordKind
from runtime.diagnostics.catalogue import nct as catalogue

OUTSIDE = {Plane.XY: "K", Plane.ZX: "J", Plane.YZ: "I"}  # the letter of the centre that has no meaning in a plane


def line(x: NctExecution) -> None:
    """A straight move to the axis words, in rapid traverse or at feed."""
    end = target(x, x.words)
    straight(x, x.words, end, None)
    x.coordinates.moved(end)


def arc(x: NctExecution) -> None:
    """An arc to the axis words, by R or by I, J, K; axes outside of the plane go along with it.

    Raises LineError 3011, 3012, 3014. F holds on the circle: what goes along makes the path faster (line 1140).
    """
    words = x.words
    end = target(x, words)
    require_feed(x, words)
    plane, letters, _ = plane_of(x, words)
    if OUTSIDE[x.modal.plane] in words:
        raise LineError(catalogue.CIRCLE, words.place(OUTSIDE[x.modal.plane]))
    start = x.coordinates.position
    begin, goal = (start[plane[0]], start[plane[1]]), (end[plane[0]], end[plane[1]])
    sense = turns_clockwise(x)
    radius = words.number("R")
    if any(letter in words for letter in letters):
        if radius is not None:
            raise LineError(catalogue.CIRCLE, words.place("R"))
        circle = _by_centre(x, begin, goal, centre_point(x, plane, letters), sense)
    elif radius is not None:
        circle = _by_radius(x, begin, goal, x.length(radius) * size_scale(x, plane), sense)
    else:
        raise LineError(catalogue.CIRCLE, words.all[0][0].column)
    along = math.radians(abs(circle.angle)) * circle.radius
    way = [e - s for s, e in zip(start, end, strict=True)]
    emit_arc(x, words, end, plane, circle, None, path_length(way, (plane, circle)) / along)
    x.coordinates.moved(end)


def _by_centre(x: NctExecution, begin: Point, goal: Point, centre: Point, clockwise: bool) -> Circle:
    """The arc around a centre; start and end may lie at different distances from it, which makes a spiral (line 1090)."""
    first, last = math.dist(begin, centre), math.dist(goal, centre)
    if abs(last - first) > max(RESOLUTION, RADIUS_DIFFERENCE):
        column = x.words.column(WordKind.AXIS)
        raise LineError(catalogue.RADIUS_DIFFERENCE, column, start=first, end=last, limit=RADIUS_DIFFERENCE)
    return circles.by_kept_centre(begin, goal, centre, clockwise, RADIUS_DIFFERENCE, 0.0)


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


RADIUS_DIFFERENCE = 0.01  # mm, RADDIF
