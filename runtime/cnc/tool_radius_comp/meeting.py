"""Where offset elements meet: lines and circles of the plane, in double precision. Kernels, pure mathematics.

A point counts as common to two elements if it is off by less than NEAR; so a line that passes a circle at a distance
that exceeds the radius by less than that touches it. Degenerate pairs have no meeting point: parallel and collinear
lines, concentric circles, circles that lie in each other or apart.
"""

from __future__ import annotations

import math

from runtime.kernels import kernel, warms

NEAR = 1e-7  # mm
PARALLEL = 1e-12  # sine of the angle between two lines


@kernel
def meet_lines(
    x0: float, y0: float, dx0: float, dy0: float, x1: float, y1: float, dx1: float, dy1: float
) -> tuple[int, float, float]:
    """Common point of two lines through (x, y) along the unit vector (dx, dy): how many (0 or 1), and where."""
    sine = dx0 * dy1 - dy0 * dx1
    if abs(sine) < PARALLEL:
        return 0, 0.0, 0.0
    way = ((x1 - x0) * dy1 - (y1 - y0) * dx1) / sine
    return 1, x0 + way * dx0, y0 + way * dy0


@kernel
def meet_line_circle(
    x: float, y: float, dx: float, dy: float, cx: float, cy: float, radius: float
) -> tuple[int, float, float, float, float]:
    """Common points of a line and a circle: how many (0 or 2, equal ones where they touch), and where."""
    along = (cx - x) * dx + (cy - y) * dy
    beside = (cx - x) * dy - (cy - y) * dx
    half = (radius - abs(beside)) * (radius + abs(beside))
    if half < 0.0:
        if abs(beside) - radius > NEAR:
            return 0, 0.0, 0.0, 0.0, 0.0
        half = 0.0
    half = math.sqrt(half)
    foot_x, foot_y = x + along * dx, y + along * dy
    return 2, foot_x - half * dx, foot_y - half * dy, foot_x + half * dx, foot_y + half * dy


@kernel
def meet_circles(
    x0: float, y0: float, radius0: float, x1: float, y1: float, radius1: float
) -> tuple[int, float, float, float, float]:
    """Common points of two circles: how many (0 or 2, equal ones where they touch), and where."""
    dx, dy = x1 - x0, y1 - y0
    apart = math.hypot(dx, dy)
    if apart < NEAR or apart > radius0 + radius1 + NEAR or apart < abs(radius0 - radius1) - NEAR:
        return 0, 0.0, 0.0, 0.0, 0.0
    dx, dy = dx / apart, dy / apart
    along = (apart + (radius0 - radius1) * (radius0 + radius1) / apart) / 2.0
    half = math.sqrt(max(0.0, (radius0 - along) * (radius0 + along)))
    foot_x, foot_y = x0 + along * dx, y0 + along * dy
    return 2, foot_x + half * dy, foot_y - half * dx, foot_x - half * dy, foot_y + half * dx


@warms("meeting points")
def _warm() -> None:
    meet_lines(0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0)
    meet_line_circle(0.0, 0.0, 1.0, 0.0, 1.0, 0.5, 1.0)
    meet_circles(0.0, 0.0, 1.0, 1.0, 0.0, 1.0)
