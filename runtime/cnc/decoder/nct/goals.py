"""Where the words of a block lead to: Cartesian, polar, by the angle of a line (manual lines 1520–1618, 4566–4610).

axis words ─ G16: radius and angle in the plane ─┐
axis words ─ ,A: one coordinate and an angle ────┼─▶ machine position
axis words ──────────────────────────────────────┘
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from runtime.cnc.decoder.circles import SAME_POINT, Circle
from runtime.cnc.decoder.modal import PLANE_AXES
from runtime.cnc.decoder.motion import target
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.registry import Group
from runtime.cnc.language.angles import cosine, sine
from runtime.cnc.language.errors import LineError
from runtime.diagnostics.catalogue import nct as catalogue

POLAR = 160  # G16
FLAT = 1e-9  # below it a line runs along an axis


@dataclass(frozen=True, slots=True)
class Goal:
    """A machine position (n_axes,). Of a polar one `sweep` is the angle from the point before in degrees, as programmed, and
    `pole` where the radius counts from, in machine coordinates of the plane."""

    end: list[float]
    sweep: float | None = None
    pole: tuple[float, float] = (0.0, 0.0)


def goal(x: NctExecution) -> Goal:
    """Where the axis words lead to. The words of the plane are taken as polar ones with G16. Raises LineError."""
    plane = PLANE_AXES[x.modal.plane]
    if x.active.get(Group.POLAR) == POLAR and any(axis in x.axis_words for axis in plane):
        return _polar(x, plane)
    angle = x.words.number(",A")
    if angle is not None:
        return Goal(_by_angle(x, plane, angle))
    if any(axis in x.axis_words for axis in plane):
        x.polar_angle = None  # what is incremental counts from where the axes are
    return Goal(target(x, x.words))


def _polar(x: NctExecution, plane: tuple[int, int]) -> Goal:
    """Radius at the first axis of the plane, angle at the second one; what is not programmed stays as it is."""
    if max(plane) >= len(x.setup.axes):
        raise LineError(catalogue.PLANE_MISSING, 1, axes=", ".join(x.setup.axes))
    first, second = plane
    here = x.coordinates.in_plane(plane)
    angle_here = math.degrees(math.atan2(here[1], here[0])) if x.polar_angle is None else x.polar_angle
    words, incremental = dict(x.axis_words), x.incremental_words
    radius = x.length(words.pop(first)) if first in words else None
    angle = words.pop(second, None)
    if angle is None:
        angle = angle_here
    else:
        angle = x.angle(angle) + (angle_here if incremental.get(second) else 0.0)
    pole = (0.0, 0.0)
    if radius is None:
        radius = math.hypot(*here)
    elif incremental.get(first):
        pole = here
    point = (pole[0] + radius * cosine(angle), pole[1] + radius * sine(angle))
    end = _others(x, plane)
    end[first], end[second] = x.coordinates.machine_in_plane(plane, point)
    x.polar_angle = angle
    return Goal(end, angle - angle_here, x.coordinates.machine_in_plane(plane, pole))


def _others(x: NctExecution, plane: tuple[int, int]) -> list[float]:
    """The target of the axes outside of the plane."""
    own = x.axis_words
    x.axis_words = {axis: value for axis, value in own.items() if axis not in plane}
    try:
        return target(x, x.words)
    finally:
        x.axis_words = own


def _by_angle(x: NctExecution, plane: tuple[int, int], angle: float) -> list[float]:
    """One coordinate of the plane and the angle from its first axis fix the point. LineError for both or none, or a line that
    does not come to the coordinate."""
    given = [place for place, axis in enumerate(plane) if axis in x.axis_words]
    column = x.words.place(",A")
    if len(given) != 1:
        raise LineError(
            catalogue.ANGLE_COORDINATE, column, reason="it needs one coordinate of the plane, and no second one"
        )
    place = given[0]
    axis = plane[place]
    here = x.coordinates.in_plane(plane)
    value = x.axis_value(axis, x.axis_words[axis])
    way = value if x.incremental_words.get(axis) else value - here[place]
    direction = (cosine(angle), sine(angle))
    if abs(direction[place]) < FLAT:
        raise LineError(
            catalogue.ANGLE_COORDINATE, column, reason="a line in this direction does not come to the coordinate"
        )
    other = way * direction[1 - place] / direction[place]
    point = [0.0, 0.0]
    point[place], point[1 - place] = here[place] + way, here[1 - place] + other
    end = _others(x, plane)
    end[plane[0]], end[plane[1]] = x.coordinates.machine_in_plane(plane, (point[0], point[1]))
    return end


def whole_turns(x: NctExecution, found: Goal, circle: Circle) -> int:
    """Of a polar arc around its pole: the whole turns in front of it (line 1590). LineError for an angle of a turn and more
    against the sense of the arc."""
    if found.sweep is None or math.dist(found.pole, circle.centre) > 10.0 * SAME_POINT:
        return 0
    turns = int((abs(found.sweep) + 1e-9) // 360.0)
    if turns and (found.sweep > 0) != (circle.angle > 0):
        raise LineError(catalogue.POLAR_TURNS, x.words.all[0][0].column)
    if turns and abs(abs(found.sweep) - 360.0 * turns) < 1e-9 and abs(abs(circle.angle) - 360.0) < 1e-6:
        turns -= 1  # the full circle itself is one of them
    return turns
