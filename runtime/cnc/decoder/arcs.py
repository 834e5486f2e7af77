"""Arcs beyond G02 and G03: through three points in space (G303), and with a radius that changes on the way (G164)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from runtime.cnc.blocks import Arc, Floats
from runtime.cnc.decoder.circles import RADIUS_LIMIT, RESOLUTION, SAME_POINT, CircleError
from runtime.diagnostics.catalogue import language as catalogue

RADIUS_STEP = 1e-3  # mm: change of radius within one piece of a radius transition
ANGLE_STEP = 22.5  # degrees: greatest piece of a radius transition


@dataclass(frozen=True, slots=True)
class SpatialCircle:
    """Centre and unit normal (3,), radius in mm, angle in degrees (0 to 360), right-handed around the normal."""

    centre: Floats
    normal: Floats
    radius: float
    angle: float


def through_three_points(start: Floats, interim: Floats, target: Floats) -> SpatialCircle:
    """The arc from `start` over `interim` to `target`, each (3,) in mm (G303, programming manual 2638–2697).

    Raises CircleError if two of them are the same point, or the interim point lies on the straight line through the
    other two, give or take the resolution.
    """
    named = {"start point": start, "interim point": interim, "target point": target}
    for first, second in (
        ("start point", "interim point"),
        ("interim point", "target point"),
        ("start point", "target point"),
    ):
        if np.linalg.norm(named[second] - named[first]) <= SAME_POINT:
            raise CircleError(catalogue.ARC_POINTS_EQUAL, first=first, second=second)
    a, b = interim - start, target - start
    across = np.cross(a, b)  # twice the area of the triangle
    area = float(np.linalg.norm(across))
    longest = max(float(np.linalg.norm(side)) for side in (a, b, b - a))
    if area / longest <= RESOLUTION:  # the height of the triangle
        raise CircleError(catalogue.ARC_POINTS_IN_LINE)
    normal = across / area
    centre = start + np.cross(across, a * float(b @ b) - b * float(a @ a)) / (2.0 * area**2)
    radius = float(np.linalg.norm(start - centre))
    if radius > RADIUS_LIMIT:
        raise CircleError(catalogue.RADIUS_RANGE, radius=radius, limit=RADIUS_LIMIT)
    begin, end = start - centre, target - centre
    angle = math.degrees(math.atan2(float(normal @ np.cross(begin, end)), float(begin @ end))) % 360.0
    return SpatialCircle(centre, normal, radius, angle)


def radius_transition(arc: Arc) -> list[Arc]:
    """An arc whose start and end lie at different distances from its centre, as pieces that follow each other.

    The radius changes linearly with the angle (G164, programming manual 4918–4959). Each piece keeps the centre; within
    a piece the path is off by less than 1e-4 mm, because a piece has at most RADIUS_STEP of the change and ANGLE_STEP
    of the angle. Other axes go along with the angle. `corner` stands at the last piece. A true arc comes back as it is.
    """
    axes = list(arc.plane)
    first = float(np.linalg.norm(arc.start[axes] - arc.centre))
    last = float(np.linalg.norm(arc.end[axes] - arc.centre))
    if abs(last - first) <= SAME_POINT:
        return [arc]
    count = math.ceil(max(abs(last - first) / RADIUS_STEP, abs(arc.angle) / ANGLE_STEP))
    begin = math.atan2(arc.start[axes[1]] - arc.centre[1], arc.start[axes[0]] - arc.centre[0])
    shares = np.arange(1, count) / count
    points = np.vstack([arc.start, arc.start + shares[:, None] * (arc.end - arc.start), arc.end])
    turned = begin + shares * math.radians(arc.angle)
    radii = first + shares * (last - first)
    points[1:-1, axes[0]] = arc.centre[0] + radii * np.cos(turned)
    points[1:-1, axes[1]] = arc.centre[1] + radii * np.sin(turned)
    pieces = [
        replace(
            arc,
            start=points[i],
            end=points[i + 1],
            end_pcs=arc.programmed(points[i + 1]),
            radius=float(np.linalg.norm(points[i, axes] - arc.centre)),
            angle=arc.angle / count,
            corner=None,
            end_feed=None,
        )
        for i in range(count)
    ]
    pieces[-1] = replace(pieces[-1], corner=arc.corner, end_feed=arc.end_feed)
    return pieces
