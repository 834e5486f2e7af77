"""Polynomial elements for the queue: their tables, and what the axes allow on them.

At PLACES of an element q', q'' and q''' are taken as they are driven, errors of the parameter included. The path velocity
is chosen so that curvature takes at most its share of the acceleration (see `dynamics`) and its change RATE_SHARE of the
jerk. Of what is left the tangential acceleration takes, per axis, the better of two bounds that both hold:

    |u| a ≤ A - |k| v²              always
    a² + (κ v²)² ≤ A²               for a main axis, as u and k/κ are perpendicular unit vectors in them
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from runtime.cnc.blocks import Polynomials
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.geometry.polynomial_table import MAP, ROWS, WIDTH
from runtime.cnc.geometry.polynomials import MAIN_AXES, MOST_PARTS, arrange, polynomial_derivatives
from runtime.cnc.path_preparation.dynamics import (
    CURVATURE_SHARE,
    GREATEST_CURVATURE_SHARE,
    GREATEST_OVERRIDE,
    Border,
    Dynamics,
    corner_speed,
    jump_speed,
)
from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Flags = npt.NDArray[np.bool_]

PLACES = 9
BETWEEN = 0.985  # what may lie higher between two places
RATE_SHARE = 0.4  # of the jerk, given to the change of curvature freely
GREATEST_RATE_SHARE = 0.85  # if the feed needs it
BEND_SHARE = 0.6  # of the jerk that the change of curvature leaves at a place, for accelerating on the curve


@dataclass(frozen=True, slots=True)
class Fitted:
    """m elements as the queue holds them: tables (m, ROWS, WIDTH), lengths, ends (m, n); `parent` (m,) the programmed one.

    An element of length 0 stands for one without length.
    """

    tables: Floats
    length: Floats
    main: Flags
    parent: Ints
    ends: Floats


def fit(block: Polynomials, start: Floats, no_length: float) -> Fitted | None:
    """The elements of a run that begins exactly at `start` (n,); None if one of them stands still on its way."""
    coefficients = block.coefficients.copy()
    ends = block.ends
    missing = np.vstack([start, ends[:-1]]) - coefficients[:, 0]  # rounding: taken in on the way, the end stays
    coefficients[:, 0] += missing
    coefficients[:, 1] -= missing
    k = len(coefficients)
    size = 2 * k + 16
    while True:
        tables = np.zeros((size, ROWS, WIDTH))
        length, main, parent = np.zeros(size), np.zeros(size, dtype=np.bool_), np.zeros(size, dtype=np.int64)
        count, failed = arrange(coefficients, no_length, tables, length, main, parent)
        if failed >= 0:
            return None
        if count >= 0:
            break
        if size > 4 * MOST_PARTS * k:
            return None
        size *= 4
    tables, length, main, parent = tables[:count], length[:count], main[:count], parent[:count]
    reached: Floats = tables[:, :MAP, : coefficients.shape[2]].sum(axis=1)
    last = np.append(parent[1:] != parent[:-1], True)
    reached[last] = ends
    return Fitted(tables, length, main, parent, reached)


@kernel
def element_limits(
    tables: Floats,
    length: Floats,
    main: Flags,
    feed: Floats,
    velocity: Floats,
    acceleration: Floats,
    jerk: Floats,
    check_jerk: bool,
    boxes: Floats,
    borders: Floats,
) -> None:
    """Fill `boxes` (m, 3) with v, a, j and `borders` (m, 2, 2, n) with q' and q'' at start and end of m elements.

    Without `check_jerk` what curvature takes of the jerk is not watched.
    """
    n = velocity.shape[0]
    q, u, k, r = np.zeros(n), np.zeros((PLACES, n)), np.zeros((PLACES, n)), np.zeros((PLACES, n))
    for element in range(length.shape[0]):
        for place in range(PLACES):
            share = place / (PLACES - 1)
            polynomial_derivatives(tables[element], share, length[element], n, q, u[place], k[place], r[place])
        for axis in range(n):
            borders[element, 0, 0, axis], borders[element, 0, 1, axis] = u[0, axis], k[0, axis]
            borders[element, 1, 0, axis], borders[element, 1, 1, axis] = u[PLACES - 1, axis], k[PLACES - 1, axis]
        v_axes, bend, rate = np.inf, 0.0, 0.0
        for place in range(PLACES):
            for axis in range(n):
                if u[place, axis] != 0.0:
                    v_axes = min(v_axes, velocity[axis] / abs(u[place, axis]))
                bend = max(bend, abs(k[place, axis]) / acceleration[axis])
                if check_jerk:
                    rate = max(rate, abs(r[place, axis]) / jerk[axis])
        asked = min(feed[element], v_axes)
        share = min(max(bend * asked * asked, CURVATURE_SHARE), GREATEST_CURVATURE_SHARE)
        v = v_axes
        if bend > 0.0:
            v = min(v, math.sqrt(share / bend))
        if rate > 0.0:
            share = min(max(rate * asked**3, RATE_SHARE), GREATEST_RATE_SHARE)
            v = min(v, (share / rate) ** (1.0 / 3.0))
        v *= BETWEEN
        fastest = min(v, GREATEST_OVERRIDE * feed[element])
        square, cube = fastest**2, fastest**3
        a = np.inf
        for place in range(PLACES):
            kappa = 0.0
            for axis in range(min(MAIN_AXES, n)):
                kappa += k[place, axis] ** 2
            kappa = math.sqrt(kappa)
            for axis in range(n):
                along, across = abs(u[place, axis]), abs(k[place, axis])
                allowed = np.inf
                if along > 0.0:
                    allowed = max(acceleration[axis] - across * square, 0.0) / along
                if main[element] and axis < MAIN_AXES and kappa * square < acceleration[axis]:
                    allowed = max(allowed, math.sqrt(acceleration[axis] ** 2 - (kappa * square) ** 2))
                if across * fastest > 0.0 and check_jerk:
                    left = jerk[axis] - abs(r[place, axis]) * cube
                    allowed = min(allowed, BEND_SHARE * left / (3.0 * across * fastest))
                a = min(a, allowed)
        a *= BETWEEN
        j = np.inf
        for place in range(PLACES):
            for axis in range(n):
                if u[place, axis] != 0.0:
                    taken = abs(r[place, axis]) * cube + 3.0 * abs(k[place, axis]) * fastest * a if check_jerk else 0.0
                    j = min(j, (jerk[axis] - taken) / abs(u[place, axis]))
        boxes[element, 0], boxes[element, 1], boxes[element, 2] = v, a, j


def polynomial_dynamics(
    limits: AxisLimits,
    period: float,
    tables: Floats,
    length: Floats,
    main: Flags,
    feed: Floats,
    before: Border | None,
    *,
    check_jerk: bool = True,
    constant_velocity: bool = False,
) -> tuple[Dynamics, Border]:
    """Limits of m successive elements, `tables` (m, ROWS, WIDTH), feeds (m,) per s, and how the last one ends.

    `constant_velocity`: all as fast as the slowest. Without `check_jerk` curvature and its change may cause any jerk.
    """
    m, n = len(length), limits.n
    boxes, borders = np.zeros((m, 3)), np.zeros((m, 2, 2, n))
    element_limits(
        tables, length, main, feed, limits.velocity, limits.least_acceleration, limits.least_jerk,
        check_jerk, boxes, borders,
    )  # fmt: skip
    if constant_velocity:
        boxes[:, 0] = boxes[:, 0].min()
    first = before or Border(borders[0, 0, 0], borders[0, 0, 1], float(length[0]), bool(main[0]))
    ends = np.concatenate([np.stack([first.direction, first.curvature])[None], borders[:-1, 1]])
    turn, bend = np.abs(borders[:, 0, 0] - ends[:, 0]), np.abs(borders[:, 0, 1] - ends[:, 1])
    mean = 0.5 * (length + np.concatenate([[first.length], length[:-1]]))
    v_entry = corner_speed(limits, period, turn, bend, mean, GREATEST_CURVATURE_SHARE)
    v_corner = jump_speed(limits, period, turn, bend)
    measured_anew = np.concatenate([[first.main], main[:-1]]) != main
    if before is None:
        measured_anew[0] = True
    v_entry[measured_anew] = v_corner[measured_anew] = 0.0
    after = Border(borders[-1, 1, 0], borders[-1, 1, 1], float(length[-1]), bool(main[-1]))
    return Dynamics(boxes[:, 0], boxes[:, 1], boxes[:, 2], v_entry, v_corner, np.zeros(m)), after


@warms("limits of polynomials")
def _warm_up() -> None:
    one = np.ones(2)
    tables = np.zeros((1, ROWS, WIDTH))
    tables[0, 1, 0] = tables[0, MAP, 1] = 1.0
    element_limits(
        tables, np.ones(1), np.ones(1, dtype=np.bool_), np.ones(1), one, one, one, True, np.zeros((1, 3)),
        np.zeros((1, 2, 2, 2))
    )  # fmt: skip
