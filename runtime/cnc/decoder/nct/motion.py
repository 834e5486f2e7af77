"""The motions of the dialect: from the words of a block to lines and arcs (manual lines 952–1164)."""

from __future__ import annotations

from runtime.cnc.decoder import circles
from runtime.cnc.decoder.feed import require_feed
from runtime.cnc.decoder.modal import Plane
from runtime.cnc.decoder.motion import centre_point, emit_arc, plane_of, size_scale, straight, target
from runtime.cnc.decoder.motion import clockwise as turns_clockwise
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.language.errors import LineError
from runtime.diagnostics.catalogue import nct as catalogue

OUTSIDE = {Plane.XY: "K", Plane.ZX: "J", Plane.YZ: "I"}  # the letter of the centre that has no meaning in a plane


def line(x: NctExecution) -> None:
    """A straight move to the axis words, in rapid traverse or at feed."""
    end = target(x, x.words)
    straight(x, x.words, end, None)
    x.coordinates.moved(end)


def arc(x: NctExecution) -> None:
    """An arc to the axis words, by R or by I, J, K; axes outside of the plane go along with it."""
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
        circle = circles.by_kept_centre(begin, goal, centre_point(x, plane, letters), sense, RADIUS_DIFFERENCE, 0.0)
    elif radius is not None:
        circle = circles.by_radius(begin, goal, x.length(radius) * size_scale(x, plane), sense)
    else:
        raise LineError(catalogue.CIRCLE, words.all[0][0].column)
    emit_arc(x, words, end, plane, circle, None)
    x.coordinates.moved(end)


RADIUS_DIFFERENCE = 0.01  # mm, RADDIF
