"""Frames in space: rotations against turning the axes themselves, and the laws of rigid motion."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.geometry.frames import HERE, SEQUENCES, Floats, Frame, rotation_of, turn_about

angles = st.tuples(*[st.floats(-360, 360)] * 3)
shifts = st.tuples(*[st.floats(-500, 500)] * 3)
sequences = st.sampled_from(SEQUENCES)


def about(axis: Floats, angle: float, vector: Floats) -> Floats:
    """Rodrigues: a vector turned about any axis."""
    turn = math.radians(angle)
    along = axis * float(axis @ vector) * (1.0 - math.cos(turn))
    turned: Floats = vector * math.cos(turn) + np.cross(axis, vector) * math.sin(turn) + along
    return turned


def turned_axes(given: tuple[float, float, float], sequence: str, *, fixed: bool) -> Floats:
    """The three axes (columns) after the rotations of a sequence, one turned after the other."""
    axes = np.eye(3)
    names = "XYZ"
    for place, letter in enumerate(sequence):
        number = names.index(letter)
        angle = given[number if len(set(sequence)) == 3 else place]
        about_what = np.eye(3)[number] if fixed else axes[:, number].copy()
        axes = np.column_stack([about(about_what, angle, axes[:, i]) for i in range(3)])
    return axes


@pytest.mark.spec("isg.cs.rotation-default", "isg.cs.mode-rotation", "chan.cs.rotation")
@given(angles, sequences, st.booleans())
def test_the_axes_are_where_they_are_turned_to(given: tuple[float, float, float], sequence: str, fixed: bool) -> None:
    made = rotation_of(given, sequence, fixed=fixed)
    np.testing.assert_allclose(made, turned_axes(given, sequence, fixed=fixed), atol=1e-9)


@given(angles, sequences)
def test_about_fixed_axes_is_the_reverse_order_about_new_ones(given: tuple[float, float, float], sequence: str) -> None:
    reverse = given if len(set(sequence)) == 3 else given[::-1]
    fixed, moving = rotation_of(given, sequence, fixed=True), rotation_of(reverse, sequence[::-1])
    np.testing.assert_allclose(fixed, moving, atol=1e-12)


@given(angles, sequences, st.booleans())
def test_a_rotation_is_orthonormal_and_right_handed(
    given: tuple[float, float, float], sequence: str, fixed: bool
) -> None:
    made = rotation_of(given, sequence, fixed=fixed)
    np.testing.assert_allclose(made @ made.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(made) == pytest.approx(1.0, abs=1e-12)


@given(angles, shifts, shifts)
def test_there_and_back_is_nothing(
    given: tuple[float, float, float], shift: tuple[float, float, float], point: tuple[float, float, float]
) -> None:
    frame = Frame(rotation_of(given), np.array(shift))
    np.testing.assert_allclose(frame.inner(frame.outer(point)), point, atol=1e-9)
    np.testing.assert_allclose(frame.outer(np.array([point, shift]))[1], frame.outer(shift), atol=1e-12)


@given(st.lists(st.tuples(angles, shifts), min_size=1, max_size=4), shifts)
def test_a_link_is_one_frame(
    chain: list[tuple[tuple[float, float, float], tuple[float, float, float]]], point: tuple[float, float, float]
) -> None:
    whole, frames = HERE, [Frame(rotation_of(angle), np.array(shift)) for angle, shift in chain]
    for frame in frames:
        whole = whole.holding(frame)
    stepwise = np.array(point)
    for frame in reversed(frames):
        stepwise = frame.outer(stepwise)
    np.testing.assert_allclose(whole.outer(point), stepwise, atol=1e-9)


@pytest.mark.parametrize("quarters", range(-5, 6))
def test_quarter_turns_are_exact(quarters: int) -> None:
    made = turn_about(2, 90.0 * quarters)
    assert set(np.abs(made).ravel()) == {0.0, 1.0}
    assert (turn_about(2, -90.0 * quarters) @ made == np.eye(3)).all()


def test_only_shifted() -> None:
    assert Frame.shifted((1, 2, 3)).only_shifted
    assert Frame(rotation_of((360, 0, -720)), np.zeros(3)).only_shifted
    assert not Frame(rotation_of((0, 0, 1e-6)), np.zeros(3)).only_shifted
