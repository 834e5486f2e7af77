"""Random closed contours of lines and arcs, and independent judges of what a tool path keeps away from them.

The distance of a tool path is judged at many places of each motion, exactly against every edge. Whether a tool fits at all is
judged by shapely, on polygons whose arcs are off by CHORD.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from random import Random

import numpy as np
from shapely.geometry import Polygon

from runtime.cnc.blocks import Arc, Floats
from tests.cnc.tool_radius_comp.paths import Motion

Point = tuple[float, float]
CHORD = 1e-3  # mm: by how much the judge's polygons of arcs are off
SHARPEST = 165.0  # degrees: what is sharper may cross itself by less than the judges see
PLACES = 24  # on each motion where the distance is taken


@dataclass(frozen=True)
class Edge:
    """An edge to the next corner: a line, or an arc by its signed angle in degrees."""

    start: Point
    end: Point
    angle: float = 0.0

    @property
    def centre(self) -> Point:
        """Centre of the arc."""
        tangent = math.tan(math.radians(self.angle) / 2)
        mx, my = (self.start[0] + self.end[0]) / 2, (self.start[1] + self.end[1]) / 2
        dx, dy = self.end[0] - self.start[0], self.end[1] - self.start[1]
        return mx - dy / 2 / tangent, my + dx / 2 / tangent

    @property
    def radius(self) -> float:
        return math.dist(self.start, self.centre)

    def at(self, share: float) -> Point:
        """The point at a share of the edge."""
        (x, y), (u, v) = self.start, self.end
        if self.angle == 0.0:
            return x + share * (u - x), y + share * (v - y)
        (cx, cy), phi = self.centre, math.radians(self.angle) * share
        dx, dy = x - cx, y - cy
        return cx + dx * math.cos(phi) - dy * math.sin(phi), cy + dx * math.sin(phi) + dy * math.cos(phi)

    def heading(self, share: float) -> float:
        """Direction of travel at a share of the edge, degrees."""
        chord = math.degrees(math.atan2(self.end[1] - self.start[1], self.end[0] - self.start[0]))
        return chord + self.angle * (share - 0.5)

    def distance(self, points: Floats) -> Floats:
        """Distance of points (k, 2) from the edge, (k,)."""
        start, end = np.array(self.start), np.array(self.end)
        ends = np.minimum(np.hypot(*(points - start).T), np.hypot(*(points - end).T))
        if self.angle == 0.0:
            along = end - start
            share = (points - start) @ along / (along @ along)
            beside = np.abs((points - start) @ np.array([-along[1], along[0]])) / math.hypot(*along)
            return np.asarray(np.where((share >= 0) & (share <= 1), beside, ends))
        centre = np.array(self.centre)
        turned = np.arctan2(*(points - centre).T[::-1]) - math.atan2(*(start - centre)[::-1])
        turned = np.mod(turned * math.copysign(1, self.angle), 2 * math.pi)
        to_circle = np.abs(np.hypot(*(points - centre).T) - self.radius)
        return np.asarray(np.where(turned <= abs(math.radians(self.angle)), to_circle, ends))

    def rough(self) -> list[Point]:
        """Points on the edge, without its end, for the judge of shapes."""
        if self.angle == 0.0:
            return [self.start]
        count = max(2, math.ceil(abs(math.radians(self.angle)) / (2 * math.sqrt(2 * CHORD / self.radius))))
        return [self.at(step / count) for step in range(count)]


def random_contour(random: Random) -> list[Edge]:
    """A simple closed contour, counter-clockwise, of 3 to 10 corners 10 to 50 mm from the middle; 40 % of its edges are arcs.

    It begins within its first edge, so that it closes without a corner.
    """
    while True:
        count = random.randint(3, 10)
        angles = sorted(random.uniform(0, 2 * math.pi) for _ in range(count))
        if min(b - a for a, b in pairwise([*angles, angles[0] + 2 * math.pi])) < 0.1:
            continue
        sizes = [random.uniform(10, 50) for _ in angles]
        corners = [(round(r * math.cos(a), 4), round(r * math.sin(a), 4)) for a, r in zip(angles, sizes, strict=True)]
        edges = [
            Edge(a, b, 0.0 if random.random() < 0.6 else random.choice((-1, 1)) * random.uniform(5, 170))
            for a, b in pairwise([*corners, corners[0]])
        ]
        first = edges[0]
        middle = first.at(0.5)
        edges = [Edge(middle, first.end, first.angle / 2), *edges[1:], Edge(first.start, middle, first.angle / 2)]
        shape = polygon(edges)
        if shape.is_valid and shape.area > 50 and shape.exterior.is_ccw and sharpest(edges) < SHARPEST:
            return edges


def sharpest(edges: Sequence[Edge]) -> float:
    """Greatest turn at a corner of a closed contour, degrees."""
    turns = []
    for before, after in zip(edges, [*edges[1:], edges[0]], strict=True):
        difference = after.heading(0.0) - before.heading(1.0)
        turns.append(abs(math.remainder(difference, 360.0)))
    return max(turns)


def polygon(edges: Sequence[Edge]) -> Polygon:
    """The shape, for the judge of shapes."""
    return Polygon([point for edge in edges for point in edge.rough()])


def places_of(motion: Motion) -> Floats:
    """Places on a motion in the plane X Y, (PLACES, 2), with its ends."""
    share = np.linspace(0.0, 1.0, PLACES)[:, None]
    start, end = motion.start[:2], motion.end[:2]
    if not isinstance(motion, Arc):
        return np.asarray(start + share * (end - start))
    phi = math.radians(motion.angle) * share
    u = start - motion.centre
    across = np.array([-u[1], u[0]])
    return np.asarray(motion.centre + np.cos(phi) * u + np.sin(phi) * across)


def distances(edges: Sequence[Edge], places: Floats) -> Floats:
    """Distance of places (k, 2) from the contour, (k,)."""
    return np.asarray(np.min([edge.distance(places) for edge in edges], axis=0))
