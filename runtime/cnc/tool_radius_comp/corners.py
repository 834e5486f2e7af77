"""The corners of a compensated contour: each two neighbours of the offset are cut where they meet, or joined around it.

    inside (the path turns to the tool)          both are cut at their meeting point, nothing is inserted
    tangential                                   the offsets meet by themselves
    outside, G25                                 straight on to the meeting point of the tangents; where that is
                                                 farther than `reach`, only so far, and a line between both ends
    outside, G26                                 an arc about the corner; for two lines that turn hardly some tangents of it,
                                                 so that a run stays one: never nearer, farther by PEAK at most

A line is extended, an arc is not: its tangent is inserted. That gives what the table of the manual lists: two lines
need no block up to 270 degrees and one beyond, every arc that takes part one more. An element whose cut end lies in
front of its cut begin runs backwards: the tool does not fit (REVERSED); neighbours that never meet are APART.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from runtime.cnc.tool_radius_comp.elements import (
    APART,
    ARC,
    CIRCLE,
    ELEMENT,
    GOOD,
    LINE,
    LINES,
    NO_INSERT,
    NONE,
    REVERSED,
    Element,
    Elements,
    offset,
    place,
    way_back,
    way_on,
)
from runtime.cnc.tool_radius_comp.meeting import NEAR, meet_circles, meet_line_circle, meet_lines
from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

BACK = 1e-7  # rad: an element that turns by 180 degrees but for this goes back
PEAK = 5e-7  # mm: by how much a path of tangents may be farther out than the arc about a corner whose place it takes
MOST_VERTICES = 4  # of such a path
FLAT = 1e-7  # mm: an arc that rises by no more above its chord is inserted as a line


@kernel
def connect(elements: Elements, first: int, behind: int, circular: bool, stretch: float, limit: float) -> int:
    """Join the elements from `first` (which counts, its begin is known) to before `behind`; the last one that counts.

    `circular`: G26; `stretch`: greatest extension at outside corners in radii; `limit`: turn in rad up to which an outside
    corner is one of tangents that are cut like those of an inside corner.
    """
    last = first
    for following in range(first + 1, behind):
        f = elements[following]
        if f["kind"] == NONE:
            continue
        e = elements[last]
        join(e, f, circular, stretch, limit)
        for between in range(last + 1, following):
            g = elements[between]
            g["bx"], g["by"], g["ex"], g["ey"] = f["bx"], f["by"], f["bx"], f["by"]
        last = following
    return last


@kernel
def join(e: Element, f: Element, circular: bool, stretch: float, limit: float) -> None:
    """Set the end of `e` and the begin of `f`, and what is inserted between them."""
    e["end"], e["ex"], e["ey"] = e["length"], e["qx"], e["qy"]
    f["begin"], f["bx"], f["by"] = 0.0, f["px"], f["py"]
    if abs(e["qx"] - f["px"]) <= NEAR and abs(e["qy"] - f["py"]) <= NEAR:
        f["bx"], f["by"] = e["qx"], e["qy"]
    else:
        cross = e["t1x"] * f["t0y"] - e["t1y"] * f["t0x"]
        turn = math.atan2(cross, e["t1x"] * f["t0x"] + e["t1y"] * f["t0y"])
        if _outside(e, f, turn):
            flat = _flat_corner(e, f, turn) if circular else 0
            if flat > 1 and abs(turn) > limit:
                _tangents(e, f, turn, flat)
            elif (abs(turn) > limit and flat == 0) or not _cut(e, f, True):
                _around(e, f, turn, circular, stretch)
        elif not _cut(e, f, False):
            e["insert"] = LINES
            if e["status"] == GOOD and f["status"] == GOOD:
                e["status"] = APART
    e["nx"], e["ny"] = f["bx"], f["by"]
    if e["end"] < e["begin"] - NEAR and e["status"] == GOOD:
        e["status"] = REVERSED


@kernel
def _flat_corner(e: Element, f: Element, turn: float) -> int:
    """How many vertices a path of tangents around the corner of two lines needs to be off an arc by PEAK at most; 0: too many."""
    if e["kind"] != LINE or f["kind"] != LINE or e["o0"] != e["o1"] or f["o0"] != f["o1"]:
        return 0
    for count in range(1, MOST_VERTICES + 1):
        quarter = turn / 4.0 / count
        if abs(e["o1"]) * 2.0 * math.sin(quarter) ** 2 <= PEAK * math.cos(2.0 * quarter):
            return count
    return 0


@kernel
def _tangents(e: Element, f: Element, turn: float, count: int) -> None:
    """A path of tangents with `count` vertices around an outside corner; the first and the last extend the lines."""
    half = turn / 2.0 / count
    on = abs(e["o1"] * math.tan(half))
    e["end"], e["ex"], e["ey"] = e["length"] + on, e["qx"] + on * e["dx"], e["qy"] + on * e["dy"]
    f["begin"], f["bx"], f["by"] = -on, f["px"] - on * f["dx"], f["py"] - on * f["dy"]
    e["insert"], e["points"] = LINES, count - 2
    reach = 1.0 / math.cos(half)
    ux, uy = (e["qx"] - e["x1"]) * reach, (e["qy"] - e["y1"]) * reach
    for number in range(1, count - 1):
        angle = half * (2 * number + 1)
        x = e["x1"] + ux * math.cos(angle) - uy * math.sin(angle)
        y = e["y1"] + ux * math.sin(angle) + uy * math.cos(angle)
        if number == 1:
            e["ix"], e["iy"] = x, y
        else:
            e["jx"], e["jy"] = x, y


@kernel
def _outside(e: Element, f: Element, turn: float) -> bool:
    """Whether the path turns away from the tool. Where it goes back, the elements' bends tell on which side it does."""
    if abs(turn) < math.pi - BACK:
        return bool(turn * e["o1"] < 0.0)
    return bool((_bend(e) + _bend(f)) * e["o1"] >= 0.0)


@kernel
def _bend(e: Element) -> float:
    """Curvature of the programmed element, to the left positive, 1/mm."""
    if e["kind"] == LINE:
        return 0.0
    radius = math.hypot(e["x0"] - e["cx"], e["y0"] - e["cy"])
    return math.copysign(1.0 / radius, e["sweep"])


@kernel
def _cut(e: Element, f: Element, outside: bool) -> bool:
    """Cut both elements at their meeting point next to the corner; False if there is none.

    Outside, lines are extended to it, and the little that arcs are extended too must be less than what is bridged.
    """
    if e["kind"] == LINE and f["kind"] == LINE and e["o0"] == e["o1"] and f["o0"] == f["o1"]:
        cross = e["t1x"] * f["t0y"] - e["t1y"] * f["t0x"]
        dot = e["t1x"] * f["t0x"] + e["t1y"] * f["t0y"]
        if not 1.0 + dot > 0.0:
            return False
        back = e["o1"] * cross / (1.0 + dot)  # o · tan(turn / 2), well conditioned for flat corners
        _set(e, f, e["qx"] - back * e["dx"], e["qy"] - back * e["dy"], back, back)
        return True
    found, x0, y0, x1, y1 = _meet(e, f)
    least = math.inf
    chosen_x, chosen_y, chosen_back, chosen_on = 0.0, 0.0, 0.0, 0.0
    for candidate in range(found):
        x, y = (x0, y0) if candidate == 0 else (x1, y1)
        back, on = way_back(e, x, y), way_on(f, x, y)
        if outside:
            back, on = _shorter(e, back), _shorter(f, on)
        elif (back < -NEAR and e["o0"] == e["o1"]) or (on < -NEAR and f["o0"] == f["o1"]):
            continue
        if abs(back) + abs(on) < least:
            least = abs(back) + abs(on)
            chosen_x, chosen_y, chosen_back, chosen_on = x, y, back, on
    if least == math.inf or (outside and least > 4.0 * math.hypot(e["qx"] - f["px"], e["qy"] - f["py"])):
        return False
    _set(e, f, chosen_x, chosen_y, chosen_back, chosen_on)
    return True


@kernel
def _shorter(e: Element, way: float) -> float:
    """Of the two ways around a circle the shorter one, negative beyond the element."""
    if e["kind"] == ARC and way > math.pi * e["radius"]:
        return float(way - 2.0 * math.pi * e["radius"])
    return way


@kernel
def _set(e: Element, f: Element, x: float, y: float, back: float, on: float) -> None:
    e["end"], f["begin"] = e["length"] - back, on
    e["ex"], e["ey"], f["bx"], f["by"] = x, y, x, y


@kernel
def _meet(e: Element, f: Element) -> tuple[int, float, float, float, float]:
    if e["kind"] == LINE:
        if f["kind"] == LINE:
            found, x, y = meet_lines(e["qx"], e["qy"], e["dx"], e["dy"], f["px"], f["py"], f["dx"], f["dy"])
            return found, x, y, x, y
        return meet_line_circle(e["qx"], e["qy"], e["dx"], e["dy"], f["mx"], f["my"], f["radius"])
    if f["kind"] == LINE:
        return meet_line_circle(f["px"], f["py"], f["dx"], f["dy"], e["mx"], e["my"], e["radius"])
    return meet_circles(e["mx"], e["my"], e["radius"], f["mx"], f["my"], f["radius"])


@kernel
def _around(e: Element, f: Element, turn: float, circular: bool, stretch: float) -> None:
    """Lines or an arc around an outside corner."""
    radius = abs(e["o1"])
    if circular:
        flat = radius * (1.0 - math.cos(turn / 2.0)) <= FLAT
        e["insert"] = LINES if flat else CIRCLE
        return
    ex, ey = (e["dx"], e["dy"]) if e["kind"] == LINE else (e["t1x"], e["t1y"])
    fx, fy = (f["dx"], f["dy"]) if f["kind"] == LINE else (f["t0x"], f["t0y"])
    reach = stretch * radius * (1.0 + 1e-9)
    straight = e["o0"] == e["o1"] and f["o0"] == f["o1"]
    on, back = radius * abs(math.tan(turn / 2.0)), 0.0
    meets = on <= reach
    if straight:
        back = on
    elif meets:
        found, x, y = meet_lines(e["qx"], e["qy"], ex, ey, f["px"], f["py"], fx, fy)
        on = (x - e["qx"]) * ex + (y - e["qy"]) * ey
        back = (f["px"] - x) * fx + (f["py"] - y) * fy
        meets = found == 1 and 0.0 <= on <= 2.0 * reach and 0.0 <= back <= 2.0 * reach
    if not meets:
        on = back = stretch * radius
    ax, ay = e["qx"] + on * ex, e["qy"] + on * ey
    bx, by = f["px"] - back * fx, f["py"] - back * fy
    if meets:
        bx, by = ax, ay
    e["insert"] = LINES
    points = 0
    if e["kind"] == LINE:
        e["end"], e["ex"], e["ey"] = e["length"] + on, ax, ay
    else:
        e["ix"], e["iy"] = ax, ay
        points = 1
    if f["kind"] == LINE:
        f["begin"], f["bx"], f["by"] = -back, bx, by
        if meets:
            points = 0  # the tangent of an arc leads to where the line begins
    elif not meets:
        if points:
            e["jx"], e["jy"] = bx, by
        else:
            e["ix"], e["iy"] = bx, by
        points += 1
    e["points"] = points
    if points == 0 and e["ex"] == f["bx"] and e["ey"] == f["by"]:
        e["insert"] = NO_INSERT


@kernel
def vertices(elements: Elements, first: int, behind: int, index: Ints, xy: Floats) -> int:
    """The corners of the tool path of straight elements: `index` which element each belongs to, `xy` (k, 2); their count k.

    What is inserted belongs to the element in front of it.
    """
    count = 0
    for i in range(first, behind):
        e = elements[i]
        index[count], xy[count, 0], xy[count, 1] = i, e["ex"], e["ey"]
        count += 1
        if e["insert"] != LINES:
            continue
        if e["points"] > 0:
            index[count], xy[count, 0], xy[count, 1] = i, e["ix"], e["iy"]
            count += 1
        if e["points"] > 1:
            index[count], xy[count, 0], xy[count, 1] = i, e["jx"], e["jy"]
            count += 1
        if xy[count - 1, 0] != e["nx"] or xy[count - 1, 1] != e["ny"]:
            index[count], xy[count, 0], xy[count, 1] = i, e["nx"], e["ny"]
            count += 1
    return count


@warms("corners of the tool radius compensation")
def _warm() -> None:
    elements = np.zeros(3, ELEMENT)
    elements["kind"] = LINE, ARC, LINE
    elements["x0"], elements["x1"], elements["y1"] = (0.0, 1.0, 2.0), (1.0, 2.0, 3.0), (0.0, 1.0, 5.0)
    elements["cx"], elements["cy"], elements["sweep"] = 1.0, 1.0, math.pi / 2.0
    offset(elements, 0, 3)
    connect(elements, 0, 3, False, 1.0, 0.0)
    join(elements[0], elements[1], False, 1.0, 0.0)
    place(elements[1], 0.1)
    vertices(elements, 0, 3, np.zeros(12, np.int64), np.zeros((12, 2)))
