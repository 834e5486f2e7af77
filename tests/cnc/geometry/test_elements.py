"""Lines and arcs as functions of the share of their length."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.geometry.elements import arc_at, cosine_range, greatest_cosine, line_at

pytestmark = pytest.mark.uncompiled

angles = st.floats(-20.0, 20.0)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(first=angles, last=angles)
def test_ranges_of_the_cosine(first: float, last: float) -> None:
    phi = np.cos(np.linspace(first, last, 4001))
    low, high = cosine_range(first, last)
    assert low <= phi.min() + 1e-12
    assert high >= phi.max() - 1e-12
    assert low == pytest.approx(phi.min(), abs=1e-4)
    assert high == pytest.approx(phi.max(), abs=1e-4)
    assert greatest_cosine(first, last) == pytest.approx(np.abs(phi).max(), abs=1e-4)


@settings(max_examples=100, deadline=None, derandomize=True)
@given(
    begin=angles,
    angle=st.floats(0.01, 12.0) | st.floats(-12.0, -0.01),
    radius=st.floats(0.01, 1000.0),
    share=st.floats(0.01, 0.99),
    error=st.floats(-1e-3, 1e-3),
)
def test_arcs_meet_their_ends_and_their_derivative_is_that_of_the_position(
    begin: float, angle: float, radius: float, share: float, error: float
) -> None:
    centre = np.array([3.0, -2.0])
    start, end = np.zeros(8), np.zeros(8)
    start[:3] = *(centre + radius * np.array([math.cos(begin), math.sin(begin)])), 1.0
    end[:3] = *(centre + (radius + error) * np.array([math.cos(begin + angle), math.sin(begin + angle)])), 5.0
    length = math.hypot(radius * angle, 4.0)
    q, dq, ahead, behind, unused = (np.zeros(8) for _ in range(5))

    def at(place: float, where: np.ndarray, slope: np.ndarray) -> None:
        arc_at(start, end, 0, 1, centre[0], centre[1], angle, place, length, 3, where, slope)

    at(1.0, q, dq)
    assert np.array_equal(q, end)
    at(0.0, q, dq)
    assert np.allclose(q, start, atol=1e-12 * radius + 1e-12)
    at(share, q, dq)
    h = 1e-6
    at(share + h, ahead, unused)
    at(share - h, behind, unused)
    assert np.allclose(dq[:3], (ahead - behind)[:3] / (2 * h * length), atol=1e-5)


def test_a_line_ends_exactly() -> None:
    start, end = np.zeros(8), np.zeros(8)
    start[:2], end[:2] = (0.1, 0.7), (0.30000000000000004, 1e9)
    q, dq = np.zeros(8), np.zeros(8)
    line_at(start, end, 1.0, 5.0, 2, q, dq)
    assert np.array_equal(q, end)
