"""Weights of FIR filters: never negative, their sum is 1, and no motion within the limits comes farther off than foretold."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.geometry.fir_filter import (
    GAUSSIAN,
    MOVING_AVERAGE,
    TAPS,
    TIME_DELAY,
    WINDOWED_SINC,
    fill_weights,
    filter_half,
    greatest_deviation,
    one_side,
)

PERIOD = 0.001
KINDS = (MOVING_AVERAGE, GAUSSIAN, WINDOWED_SINC, TIME_DELAY)


@given(
    st.sampled_from(KINDS), st.integers(0, 200), st.floats(0.0, 1.0), st.floats(1.0, 500.0), st.floats(0.01, 1.0),
    st.integers(0, 100),
)  # fmt: skip
@settings(max_examples=200, deadline=None)
def test_weights_are_never_negative_and_their_sum_is_one(
    kind: int, order: int, share: float, cut_off: float, quality: float, further: int
) -> None:
    half = filter_half(kind, order, cut_off, PERIOD)
    middle = max(half, further) if kind != TIME_DELAY else further
    out = np.full((TAPS, 2), 7.0)
    fill_weights(kind, half, share, cut_off, quality, PERIOD, middle, 0, out)
    weights = out[:, 0]
    assert (weights >= 0.0).all()
    assert weights.sum() == pytest.approx(1.0, abs=1e-12)
    assert (out[:, 1] == 7.0).all()
    if kind != TIME_DELAY:
        around = weights[middle - half : middle + half + 1]
        assert around == pytest.approx(around[::-1], abs=1e-15)
        assert around.sum() == pytest.approx(1.0, abs=1e-12)


@given(
    st.sampled_from(KINDS), st.integers(2, 120), st.floats(0.0, 1.0), st.integers(0, 10**6), st.floats(0.1, 20.0),
)  # fmt: skip
@settings(max_examples=150, deadline=None)
def test_no_motion_within_the_limits_comes_farther_off(
    kind: int, order: int, share: float, seed: int, jump: float
) -> None:
    rng = np.random.default_rng(seed)
    velocity, acceleration = 200.0, 3000.0
    half = filter_half(kind, order, 25.0, PERIOD)
    side = np.zeros(half + 1)
    if kind != TIME_DELAY:
        one_side(kind, half, 25.0, 0.7, PERIOD, side)
    most = greatest_deviation(kind, half, share, PERIOD, side, velocity, acceleration, jump)
    ages = np.zeros((TAPS, 1))
    fill_weights(kind, half, share, 25.0, 0.7, PERIOD, half, 0, ages)
    # as fast as allowed to and fro, and one jump
    pushes = np.repeat(rng.choice([-1.0, 1.0], 60), rng.integers(1, 40, 60)) * acceleration * PERIOD
    speed = np.clip(np.cumsum(pushes), -velocity, velocity)
    speed[rng.integers(0, len(speed)) :] += rng.choice([-jump, jump])
    speed = np.clip(speed, -velocity, velocity)
    places = np.cumsum(speed) * PERIOD
    filtered = np.convolve(places, ages[:, 0])[: len(places)]
    delayed = np.concatenate([np.full(half, places[0]), places])[: len(places)]
    off = np.abs(filtered - delayed)[TAPS:]
    assert off.max(initial=0.0) <= most * (1.0 + 1e-9) + 1e-12
    constant = np.convolve(np.full(TAPS * 2, 3.25), ages[:, 0])[TAPS : 2 * TAPS]
    assert constant == pytest.approx(np.full(TAPS, 3.25), abs=1e-12)


def test_a_windowed_sinc_is_no_wider_than_its_weights_are_positive() -> None:
    assert filter_half(WINDOWED_SINC, 200, 30.0, PERIOD) == 16  # 1/(2 · 30 Hz) = 16.7 ms
    assert filter_half(WINDOWED_SINC, 20, 30.0, PERIOD) == 10
    assert filter_half(GAUSSIAN, 41, 30.0, PERIOD) == 20
    assert filter_half(TIME_DELAY, 41, 30.0, PERIOD) == 41


def test_a_higher_quality_is_a_wider_bell() -> None:
    widths = []
    for quality in (0.3, 0.6, 1.0):
        side = np.zeros(21)
        one_side(GAUSSIAN, 20, 30.0, quality, PERIOD, side)
        widths.append(side[0])
    assert widths == sorted(widths, reverse=True)
