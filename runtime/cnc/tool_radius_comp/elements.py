"""Elements of a contour and their offset: one record each, what the kernels of the compensation work on.

    programmed   (x0, y0) ─────────────────▶ (x1, y1)          t   unit tangents at start and end
                      ▲ o0                      ▲ o1            o   distance of the tool path to the left, mm
    tool path    (bx, by) ── begin ─── end ──▶ (ex, ey)         way along the offset element, 0 … length

The offset of a line is a line, that of an arc an arc about the same centre. Where the distance changes over an element
(a new tool radius), a line runs obliquely and an arc gets a centre of its own, so that it ends tangentially to the new
offset. `begin` and `end` are what the corners leave of the element, in mm from where the offset itself starts; they may
lie beyond it where a line is extended.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from runtime.kernels import kernel, warms

NO_LENGTH = 1e-9  # mm: below it an element has no way in the plane
NO_RADIUS = 1e-7  # mm: an offset arc of this radius is a point

NONE, LINE, ARC = 0, 1, 2  # kinds of element; NONE has no way in the plane and does not count for the contour
GOOD, TOO_SMALL, TWISTED, REVERSED, APART = 0, 1, 2, 3, 4
# status: fine; arc smaller than the tool; radius change that no arc can follow; runs backwards; does not meet the next one
NO_INSERT, LINES, CIRCLE = 0, 1, 2  # what stands behind an element

ELEMENT = np.dtype(
    [
        ("kind", np.int64),
        ("x0", np.float64),
        ("y0", np.float64),
        ("x1", np.float64),
        ("y1", np.float64),
        ("cx", np.float64),
        ("cy", np.float64),
        ("sweep", np.float64),  # rad, counter-clockwise positive
        ("o0", np.float64),
        ("o1", np.float64),
        # computed
        ("status", np.int64),
        ("t0x", np.float64),
        ("t0y", np.float64),
        ("t1x", np.float64),
        ("t1y", np.float64),
        ("px", np.float64),  # start of the offset element
        ("py", np.float64),
        ("qx", np.float64),  # its end
        ("qy", np.float64),
        ("dx", np.float64),  # unit vector of an offset line
        ("dy", np.float64),
        ("mx", np.float64),  # centre, radius and opening angle of an offset arc
        ("my", np.float64),
        ("radius", np.float64),
        ("turn", np.float64),
        ("length", np.float64),
        ("begin", np.float64),
        ("end", np.float64),
        ("bx", np.float64),
        ("by", np.float64),
        ("ex", np.float64),
        ("ey", np.float64),
        ("insert", np.int64),
        ("points", np.int64),  # of the inserted lines, between the end of this and the begin of the next element
        ("ix", np.float64),
        ("iy", np.float64),
        ("jx", np.float64),
        ("jy", np.float64),
        ("nx", np.float64),  # where the next element begins
        ("ny", np.float64),
    ]
)
Elements = npt.NDArray[np.void]
Element = Any  # one record of them: numpy gives its fields no types
Floats = npt.NDArray[np.float64]


@kernel
def offset(elements: Elements, first: int, behind: int) -> None:
    """Compute the offset of the elements `first` to before `behind`; they begin and end where it does."""
    for i in range(first, behind):
        e = elements[i]
        e["status"] = GOOD
        e["insert"] = NO_INSERT
        e["points"] = 0
        if e["kind"] == LINE:
            _offset_line(e)
        elif e["kind"] == ARC:
            _offset_arc(e)
        e["begin"] = 0.0
        e["end"] = e["length"]
        e["bx"], e["by"], e["ex"], e["ey"] = e["px"], e["py"], e["qx"], e["qy"]


@kernel
def _offset_line(e: Element) -> None:
    dx, dy = e["x1"] - e["x0"], e["y1"] - e["y0"]
    length = math.hypot(dx, dy)
    dx, dy = dx / length, dy / length
    e["t0x"], e["t0y"], e["t1x"], e["t1y"] = dx, dy, dx, dy
    e["px"], e["py"] = e["x0"] - dy * e["o0"], e["y0"] + dx * e["o0"]
    e["qx"], e["qy"] = e["x1"] - dy * e["o1"], e["y1"] + dx * e["o1"]
    if e["o0"] != e["o1"]:
        dx, dy = e["qx"] - e["px"], e["qy"] - e["py"]
        length = math.hypot(dx, dy)
        dx, dy = dx / length, dy / length
    e["dx"], e["dy"], e["length"] = dx, dy, length


@kernel
def _offset_arc(e: Element) -> None:
    sense = 1.0 if e["sweep"] > 0.0 else -1.0
    ux, uy = e["x0"] - e["cx"], e["y0"] - e["cy"]
    vx, vy = e["x1"] - e["cx"], e["y1"] - e["cy"]
    start_radius, end_radius = math.hypot(ux, uy), math.hypot(vx, vy)
    ux, uy, vx, vy = ux / start_radius, uy / start_radius, vx / end_radius, vy / end_radius
    e["t0x"], e["t0y"], e["t1x"], e["t1y"] = -sense * uy, sense * ux, -sense * vy, sense * vx
    e["mx"], e["my"], e["turn"] = e["cx"], e["cy"], e["sweep"]
    first, last = start_radius - sense * e["o0"], end_radius - sense * e["o1"]
    if min(first, last) < -NO_RADIUS:
        e["status"] = TOO_SMALL
    if min(first, last) < NO_RADIUS:
        first, last = max(first, 0.0), max(last, 0.0)
    e["px"], e["py"] = e["cx"] + ux * first, e["cy"] + uy * first
    e["qx"], e["qy"] = e["cx"] + vx * last, e["cy"] + vy * last
    e["radius"] = last
    if e["o0"] != e["o1"]:
        _change_over_arc(e, vx, vy, sense)
    e["length"] = e["radius"] * abs(e["turn"])


@kernel
def _change_over_arc(e: Element, vx: float, vy: float, sense: float) -> None:
    """The circle through both ends of the offset that ends in the tangent of the programmed arc."""
    wx, wy = e["qx"] - e["px"], e["qy"] - e["py"]
    outward = 2.0 * (vx * wx + vy * wy)
    square = wx * wx + wy * wy
    if not outward > 1e-9 * math.sqrt(square):
        e["status"] = TWISTED
        return
    radius = square / outward
    e["mx"], e["my"], e["radius"] = e["qx"] - vx * radius, e["qy"] - vy * radius, radius
    sx, sy = e["px"] - e["mx"], e["py"] - e["my"]
    angle = math.atan2(sx * vy - sy * vx, sx * vx + sy * vy) * sense
    e["turn"] = sense * (angle if angle > 0.0 else angle + 2.0 * math.pi)


@kernel
def place(e: Element, way: float) -> tuple[float, float]:
    """The point of an offset element after `way` mm; the ends of the offset itself are met to the bit."""
    if way == 0.0:
        return e["px"], e["py"]
    if way == e["length"]:
        return e["qx"], e["qy"]
    if e["kind"] == LINE:
        return e["px"] + e["dx"] * way, e["py"] + e["dy"] * way
    angle = (1.0 if e["turn"] > 0.0 else -1.0) * way / e["radius"]
    ux, uy = e["px"] - e["mx"], e["py"] - e["my"]
    c, s = math.cos(angle), math.sin(angle)
    return e["mx"] + ux * c - uy * s, e["my"] + ux * s + uy * c


@kernel
def way_on(e: Element, x: float, y: float) -> float:
    """Way from the start of the offset element to a point that lies on it; an arc counts up to a whole turn."""
    if e["kind"] == LINE:
        return float((x - e["px"]) * e["dx"] + (y - e["py"]) * e["dy"])
    angle = _turned(e["px"] - e["mx"], e["py"] - e["my"], x - e["mx"], y - e["my"], e["turn"], e["radius"])
    return float(e["radius"] * angle)


@kernel
def way_back(e: Element, x: float, y: float) -> float:
    """Way back from the end of the offset element to a point that lies on it; an arc counts up to a whole turn."""
    if e["kind"] == LINE:
        return float((e["qx"] - x) * e["dx"] + (e["qy"] - y) * e["dy"])
    angle = _turned(x - e["mx"], y - e["my"], e["qx"] - e["mx"], e["qy"] - e["my"], e["turn"], e["radius"])
    return float(e["radius"] * angle)


@kernel
def _turned(ux: float, uy: float, vx: float, vy: float, turn: float, radius: float) -> float:
    """Angle from u to v in the sense of `turn`, 0 … 2π; hardly less than a whole turn is hardly less than none."""
    angle = math.atan2(ux * vy - uy * vx, ux * vx + uy * vy) * (1.0 if turn > 0.0 else -1.0)
    if angle < 0.0 and angle * radius < -NO_RADIUS:
        return angle + 2.0 * math.pi
    return angle


@warms("offset elements")
def _warm() -> None:
    elements = np.zeros(2, ELEMENT)
    elements["kind"] = LINE, ARC
    elements["x0"], elements["x1"], elements["y1"], elements["sweep"] = 1.0, 2.0, 2.0, 1.0
    elements["cx"] = 5.0
    offset(elements, 0, 2)
    place(elements[0], 0.5)
    way_on(elements[0], 0.5, 0.5)
    way_back(elements[0], 0.5, 0.5)
