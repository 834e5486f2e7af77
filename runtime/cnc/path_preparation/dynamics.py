"""What the axes allow on an element and at its entry: path velocity, acceleration and jerk from the limits per axis.

With u = q' (share of each axis in the path velocity) and k = q'' (curvature), at path velocity v, acceleration a,
jerk j:

    velocity of an axis       u v                          ≤ V
    acceleration              u a + k v²                   ≤ A
    jerk                      u j + 3 k v a + q''' v³      ≤ J

Every element gets one v, a and j with which all of this holds together. What curvature takes is decided by the speed
that the programmed feed can ask for (override 200 %): up to half of the acceleration is given to it freely, up to 70
% if the feed at 100 % needs it, along runs of short lines as much as the way ahead makes worth it (`curve_shares`);
the rest is left to speed up and brake.

At a corner the axes jump by Δu v, at most their `velocity_step`. Where an arc begins or ends the acceleration jumps
by Δk v². An axis that may jump by `velocity_step` may also lag as much, and with its jerk it catches up with a jump
of acceleration ΔA while its velocity is off by at most ΔA²/8J: so ΔA ≤ √(8 J velocity_step) is allowed, and ΔA ≤
J·period/2 for an axis that may not jump at all. In a corner where the velocities jump the path acceleration may do so, too,
from braking to speeding up, within the same ΔA of every axis.

A run of short lines stands for a curve: its corners then also have a curvature k = Δu / mean length, kept like that
of an arc.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.geometry.elements import greatest_cosine
from runtime.cnc.path_preparation.curve_shares import curve_shares

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

GREATEST_OVERRIDE = 2.0
CURVATURE_SHARE = 0.5  # of the acceleration, given to curvature freely
GREATEST_CURVATURE_SHARE = 0.7  # if the feed needs it
TANGENTIAL = 1e-6  # a change of direction below this is rounding
RUN = (
    16  # lines: in longer runs the limits go down in steps, or each line would be a constraint of its own in the cycle
)
SMOOTH = 0.15  # a change of direction below this may stand for a curve (8.6 degrees)


@dataclass(frozen=True, slots=True)
class Border:
    """How an element ends: u and k of the axes, its length, and whether it is measured along the main axes."""

    direction: Floats
    curvature: Floats
    length: float
    main: bool


@dataclass(frozen=True, slots=True)
class Dynamics:
    """Limits of k elements, each (k,): per s, s², s³ along the path; `v_entry` at the corner before the element.

    `v_corner` is `v_entry` without what the curvature of a corner that stands for a curve allows. `a_entry`: from a
    deceleration up to it the path may change at the corner to any acceleration up to it; 0: the acceleration goes on.
    """

    v_limit: Floats
    a_limit: Floats
    j_limit: Floats
    v_entry: Floats
    v_corner: Floats
    a_entry: Floats


def _least(limit: Floats, share: Floats) -> Floats:
    """min over the axes of limit / share, (k,), for shares (k, n_axes); inf where nothing moves.

    Axis by axis: a NumPy minimum over a last dimension of three costs more than the divisions.
    """
    least: Floats = np.full(share.shape[:-1], np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        for axis in range(share.shape[-1]):
            part = share[..., axis]
            np.minimum(least, np.where(part > 0.0, limit[..., axis] / part, np.inf), out=least)
    return least


def _acceleration_step(limits: AxisLimits, period: float) -> Floats:
    jerk = limits.least_jerk
    allowed = np.maximum(np.sqrt(8.0 * jerk * limits.velocity_step), 0.5 * jerk * period)
    step: Floats = np.minimum(allowed, limits.least_acceleration)
    return step


def corner_speed(
    limits: AxisLimits, period: float, turn: Floats, bend: Floats, length: Floats, share: Floats | float
) -> Floats:
    """Greatest path velocity over corners (k,).

    `turn` (k, n): |Δu|; `bend` (k, n): |Δk|, the jump of curvature; `length` (k,): mean length of the neighbours;
    `share`: of the acceleration that curvature may take.
    """
    curve = np.sqrt(share * _least(limits.least_acceleration, np.where(turn > TANGENTIAL, turn, 0.0)) * length)
    speed: Floats = np.minimum(jump_speed(limits, period, turn, bend), curve)
    return speed


def jump_speed(limits: AxisLimits, period: float, turn: Floats, bend: Floats) -> Floats:
    """Greatest path velocity over corners (k,) for which the jumps of velocity and acceleration are allowed."""
    jump = _least(limits.velocity_step, np.where(turn > TANGENTIAL, turn, 0.0))
    onset = np.sqrt(_least(_acceleration_step(limits, period), bend))
    speed: Floats = np.minimum(jump, onset)
    return speed


def jump_acceleration(limits: AxisLimits, period: float, before: Floats, behind: Floats) -> Floats:
    """Greatest deceleration before and acceleration behind corners (k,) between directions (k, n) that may meet there.

    Braking with a- before and accelerating with a+ behind, an axis jumps by u+ a+ + u- a-: by the sum where it goes on, by the
    difference where it turns back, and either may be 0. Only where the velocities jump as well: a curve, however finely
    divided, has no such corners.
    """
    sharp = np.abs(behind - before).max(axis=1) >= SMOOTH
    together = np.maximum(np.maximum(np.abs(before), np.abs(behind)), np.abs(before + behind))
    allowed = _least(_acceleration_step(limits, period), together)
    step: Floats = np.where(sharp & (limits.velocity_step.max() > 0.0), allowed, 0.0)
    return step


def line_dynamics(
    limits: AxisLimits,
    period: float,
    direction: Floats,
    length: Floats,
    main: Flags,
    feed: Floats,
    before: Border | None,
) -> tuple[Dynamics, Border]:
    """Limits of k successive lines: directions (k, n), lengths (k,), feeds (k,) per s, and how the last one ends.

    `main` (k,): measured along the main axes. `before` is the end of the element before, None at the start of a path.
    """
    n = limits.n
    acceleration = limits.least_acceleration
    share = np.abs(direction)
    v_limit = _least(limits.velocity, share)
    a_plain = _least(acceleration, share)
    j_limit = _least(limits.least_jerk, share)
    first = before or Border(direction[0], np.zeros(n), float(length[0]), bool(main[0]))
    before_direction = np.vstack([first.direction, direction[:-1]])
    before_length = np.concatenate([[first.length], length[:-1]])
    before_main = np.concatenate([[first.main], main[:-1]])
    turn = np.abs(direction - before_direction)
    turn[turn <= TANGENTIAL] = 0.0
    mean = 0.5 * (length + before_length)
    bend = np.zeros_like(turn)
    bend[0] = np.abs(first.curvature)

    curvature = np.where(turn.max(axis=1, keepdims=True) < SMOOTH, turn / mean[:, None], 0.0)  # at the corner before
    here = curvature.copy()  # the sharper of the corners at both ends; that after the last line is not known yet
    here[:-1] = np.maximum(here[:-1], curvature[1:])
    v_corner = jump_speed(limits, period, turn, bend)
    a_entry = jump_acceleration(limits, period, before_direction, direction)
    asked = np.minimum(feed, v_limit)
    cap = np.append(v_corner, asked[-1])
    cap[:-1] = np.minimum(np.minimum(cap[:-1], asked), np.concatenate([asked[:1], asked[:-1]]))
    # where the path comes from and goes on is not known here
    cap[[0, -1]] = np.minimum(cap[[0, -1]], np.sqrt(GREATEST_CURVATURE_SHARE * _least(acceleration, here[[0, -1]])))
    if before is None:
        cap[0] = 0.0
    share_here = np.empty(len(length))
    curve_shares(share, here, length, acceleration, cap, CURVATURE_SHARE, share_here)
    share_at = share_here.copy()  # of the corner before
    share_at[1:] = np.minimum(share_at[1:], share_here[:-1])
    v_entry = corner_speed(limits, period, turn, bend, mean, share_at)
    measured_anew = before_main != main  # mm before, degrees after
    v_entry[measured_anew] = v_corner[measured_anew] = a_entry[measured_anew] = 0.0
    if before is None:
        v_entry[0] = v_corner[0] = a_entry[0] = 0.0

    # at both ends as fast as they may be passed; that after the last line may have any curvature up to the one before
    most = np.minimum(GREATEST_OVERRIDE * feed, v_limit)
    behind = np.append(v_entry[1:], np.sqrt(share_here[-1:] * _least(acceleration, here[-1:])))
    bend_behind = np.vstack([curvature[1:], here[-1:]])
    at_begin = curvature * np.minimum(v_entry, most)[:, None] ** 2
    at_end = bend_behind * np.minimum(behind, most)[:, None] ** 2
    axes = _least_left(acceleration, np.maximum(at_begin, at_end), share)
    moving = (share > 0.0) | (here > 0.0)
    isotropic = np.where(moving, acceleration, np.inf).min(axis=1)
    across = np.sqrt(np.maximum((at_begin**2).sum(axis=1), (at_end**2).sum(axis=1)))
    circle = np.sqrt(np.maximum(isotropic**2 - across**2, 0.0))
    a_limit = np.minimum(np.maximum(axes, circle), a_plain)
    after = Border(direction[-1], np.zeros(n), float(length[-1]), bool(main[-1]))
    if len(length) >= RUN:
        v_limit, v_entry = _step_down(v_limit, 0.005), _step_down(v_entry, 0.005)
        a_limit, j_limit = _step_down(a_limit, 0.02), _step_down(j_limit, 0.02)
    return Dynamics(v_limit, a_limit, j_limit, v_entry, v_corner, a_entry), after


def _step_down(values: Floats, step: float) -> Floats:
    """The next lower number of a geometric row; 0 and inf as they are."""
    with np.errstate(divide="ignore", invalid="ignore"):
        lower = np.exp(np.floor(np.log(values) / step) * step)
    rounded: Floats = np.where(np.isfinite(values) & (values > 0.0), np.minimum(lower, values), values)
    return rounded


def _least_left(limit: Floats, taken: Floats, share: Floats) -> Floats:
    """min over the axes of (limit - taken) / share, (k,), at least 0."""
    least: Floats = np.maximum(_least(limit - taken, share), 0.0)
    return least


def arc_dynamics(
    limits: AxisLimits,
    period: float,
    plane: tuple[int, int],
    begin: float,
    angle: float,
    radius: float,
    linear: Floats,
    length: float,
    feed: float,
    before: Border | None,
) -> tuple[Dynamics, Border]:
    """Limits of one arc or helix, arrays of shape (1,), and how it ends.

    `begin`, `angle`: radians; `linear` (n,): way of the axes outside the plane, 0 in it; `feed` per s.
    """
    first, second = plane
    acceleration, jerk = limits.least_acceleration, limits.least_jerk
    in_plane = radius * abs(angle) / length  # share of the path velocity that turns
    sine = greatest_cosine(begin - math.pi / 2, begin + angle - math.pi / 2)
    cosine = greatest_cosine(begin, begin + angle)
    share = np.abs(linear) / length
    share[first], share[second] = in_plane * sine, in_plane * cosine
    curve = np.zeros(limits.n)
    kappa = in_plane**2 / radius
    curve[first], curve[second] = kappa * cosine, kappa * sine
    rate = in_plane**3 / radius**2  # q''', along the direction

    moving = share > 0.0
    A = float(acceleration[moving].min())
    J = float(jerk[moving].min())
    v_axes = float(_least(limits.velocity, share))
    part = min(max(kappa * min(feed, v_axes) ** 2 / A, CURVATURE_SHARE), GREATEST_CURVATURE_SHARE)
    v_limit = min(v_axes, math.sqrt(part * A / kappa), (0.4 * J / rate) ** (1.0 / 3.0))
    fastest = min(v_limit, GREATEST_OVERRIDE * feed)
    across = kappa * fastest**2
    a_axes = float(_least_left(acceleration, curve * fastest**2, share))
    a_limit = max(a_axes, math.sqrt(max(A * A - across * across, 0.0)))
    a_limit = min(a_limit, float(_least(acceleration, share)), 0.6 * J / (3.0 * kappa * fastest))
    j_limit = min(0.8 * J - rate * fastest**3, float(_least(jerk, share)))

    def border(phi: float) -> Border:
        direction = linear / length
        sense = math.copysign(in_plane, angle)
        direction[first], direction[second] = -sense * math.sin(phi), sense * math.cos(phi)
        bend = np.zeros(limits.n)
        bend[first], bend[second] = -kappa * math.cos(phi), -kappa * math.sin(phi)
        return Border(direction, bend, length, True)

    start = border(begin)
    v_entry = v_corner = 0.0
    if before is not None and before.main:
        turn = np.abs(start.direction - before.direction)[None, :]
        bend = np.abs(start.curvature - before.curvature)[None, :]
        mean = np.array([0.5 * (length + before.length)])
        v_entry = float(corner_speed(limits, period, turn, bend, mean, GREATEST_CURVATURE_SHARE)[0])
        v_corner = float(jump_speed(limits, period, turn, bend)[0])
    values = (v_limit, a_limit, j_limit, v_entry, v_corner, 0.0)
    return Dynamics(*(np.array([value]) for value in values)), border(begin + angle)
