"""Runs of short lines: what curvature takes of the acceleration and what is left along the path, whatever was chosen."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.path_preparation.curve_shares import LEFT, MOST
from runtime.cnc.path_preparation.dynamics import SMOOTH, line_dynamics
from tests.cnc.interpolator.driving import PERIOD, limits

Floats = npt.NDArray[np.float64]
HARD = limits(250.0, 2000.0, 50_000.0, 5.0)
A = 2000.0


def made(points: Floats, feed: float) -> tuple[Floats, Floats, Floats]:
    """|u| of lines (m, n), |k| v² at both ends as fast as they may be passed (2, m, n), acceleration along them (m,)."""
    way = np.diff(points, axis=0)
    length = np.linalg.norm(way, axis=1)
    m = len(length)
    found, _ = line_dynamics(
        HARD, PERIOD, way / length[:, None], length, np.ones(m, dtype=np.bool_), np.full(m, feed), None
    )
    turn = np.abs(np.diff(way / length[:, None], axis=0))
    turn[turn.max(axis=1) >= SMOOTH] = 0.0  # corners, not a curve
    bend = np.zeros((m + 1, 3))
    bend[1:-1] = turn / (0.5 * (length[1:] + length[:-1]))[:, None]
    most = np.minimum(2.0 * feed, found.v_limit)
    entry = np.append(found.v_entry, 0.0)
    ends = [bend[at] * np.minimum(entry[at], most)[:, None] ** 2 for at in (slice(0, m), slice(1, m + 1))]
    return np.abs(way) / length[:, None], np.stack(ends), found.a_limit


@given(
    st.floats(2.0, 60.0),
    st.floats(2.0, 60.0),
    st.sampled_from([0.0, 0.5, 3.0]),
    st.floats(10.0, 2000.0),
    st.integers(40, 600),
)
@settings(max_examples=40, deadline=None, derandomize=True)
def test_curvature_and_what_is_left_keep_the_acceleration_together(
    x: float, y: float, z: float, feed: float, count: int
) -> None:
    t = np.linspace(0.0, 2.0 * np.pi, count + 1)
    points = np.stack([x * np.cos(t), y * np.sin(t), z * np.sin(3.0 * t)], axis=1)
    direction, across, a = made(points, feed)
    axes = (direction * a[:, None] + across).max(axis=2)
    circle = np.hypot(a, np.linalg.norm(across, axis=2))
    assert (np.minimum(axes, circle) <= (1.0 + 1e-9) * A).all()
    assert (a >= 0.9 * LEFT * A / direction.max(axis=1)).all()


def test_curvature_takes_more_where_nothing_else_needs_it() -> None:
    t = np.linspace(0.0, 6.0 * np.pi, 2001)
    circle = np.stack([20.0 * np.cos(t), 20.0 * np.sin(t), 0.0 * t], axis=1)
    _, across, _ = made(circle, 1000.0)
    share = np.linalg.norm(across, axis=2).max(axis=0) / A
    assert share[1] < 0.75  # from standstill on the path has to speed up
    assert share[800:1200].min() > 0.85
    assert across.max() / A <= MOST + 0.01
