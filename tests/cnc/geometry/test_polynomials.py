"""Polynomial elements: the parameter follows the length, parts are the whole, derivatives are derivatives."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.geometry.polynomial_table import ROWS, TERMS, WIDTH
from runtime.cnc.geometry.polynomials import (
    MOST_PARTS,
    SPEED_ERROR,
    arrange,
    part_of,
    polynomial_at,
    polynomial_derivatives,
)

Floats = npt.NDArray[np.float64]
numbers = st.floats(-5.0, 5.0, allow_nan=False)


@st.composite
def curves(draw: st.DrawFn) -> Floats:
    """Coefficients (6, 3) of a curve that goes on in X and may turn in all axes."""
    made = np.array([[draw(numbers) for _ in range(3)] for _ in range(TERMS)])
    made[2:] *= 0.4
    made[1, 0] = 8.0 + abs(made[1, 0])
    made[2:, 0] *= 0.2
    return made


def arranged(coefficients: Floats) -> tuple[Floats, Floats, npt.NDArray[np.bool_], npt.NDArray[np.int64], int]:
    size = MOST_PARTS * len(coefficients)
    tables, length = np.zeros((size, ROWS, WIDTH)), np.zeros(size)
    main, parent = np.zeros(size, dtype=np.bool_), np.zeros(size, dtype=np.int64)
    count, failed = arrange(coefficients, 1e-9, tables, length, main, parent)
    return tables[:count], length[:count], main[:count], parent[:count], failed


def place(coefficients: Floats, u: float) -> Floats:
    powers = u ** np.arange(TERMS)
    at: Floats = powers @ coefficients
    return at


@given(curves())
@settings(max_examples=60, deadline=None)
def test_the_parts_are_the_element_and_run_at_the_speed_of_the_path(c: Floats) -> None:
    tables, length, main, _, failed = arranged(c[None])
    assert failed < 0
    assert main.all()
    fine = np.array([place(c, u) for u in np.linspace(0.0, 1.0, 20_001)])
    assert length.sum() == pytest.approx(np.linalg.norm(np.diff(fine, axis=0), axis=1).sum(), rel=1e-6)
    q, dq = np.zeros(3), np.zeros(3)
    end = c[0]
    for table, way in zip(tables, length, strict=True):
        polynomial_at(table, 0.0, way, 3, q, dq)
        assert q == pytest.approx(end, abs=1e-9)
        for share in np.linspace(0.0, 1.0, 33):
            polynomial_at(table, float(share), way, 3, q, dq)
            assert np.linalg.norm(dq) == pytest.approx(1.0, abs=2 * SPEED_ERROR)
            assert np.linalg.norm(fine - q, axis=1).min() < 0.6 * np.linalg.norm(np.diff(fine, axis=0), axis=1).max()

        for share in (0.0, 1.0):
            polynomial_at(table, share, way, 3, q, dq)
            assert np.linalg.norm(dq) == pytest.approx(1.0, abs=1e-9)
        end = q.copy()
    assert end == pytest.approx(place(c, 1.0), abs=1e-9)


@given(curves(), st.floats(0.0, 0.9), st.floats(0.05, 1.0))
@settings(max_examples=60, deadline=None)
def test_a_part_lies_on_the_whole(c: Floats, low: float, width: float) -> None:
    high = min(low + width, 1.0)
    part = np.zeros((TERMS, 3))
    part_of(c, low, high, part)
    for u in np.linspace(0.0, 1.0, 11):
        assert place(part, float(u)) == pytest.approx(place(c, low + (high - low) * float(u)), abs=1e-9)


@given(curves(), st.floats(0.05, 0.95))
@settings(max_examples=60, deadline=None)
def test_derivatives_by_the_path_length(c: Floats, share: float) -> None:
    tables, length, _, _, _ = arranged(c[None])
    table, way = tables[0], float(length[0])
    step = 1e-5
    here = [np.zeros(3) for _ in range(4)]
    sides = []
    for shift in (-step, step):
        arrays = [np.zeros(3) for _ in range(4)]
        polynomial_derivatives(table, share + shift, way, 3, *arrays)
        sides.append(arrays)
    polynomial_derivatives(table, share, way, 3, *here)
    for order in range(3):
        slope = (sides[1][order] - sides[0][order]) / (2.0 * step * way)
        assert slope == pytest.approx(here[order + 1], rel=1e-4, abs=1e-4)


def test_a_badly_parameterised_line_is_split_and_still_a_line() -> None:
    c = np.zeros((TERMS, 3))
    c[1, 0], c[4, 0] = 0.5, 30.0  # slow at its start, 60 times as fast at its end
    _, length, _, _, failed = arranged(c[None])
    assert failed < 0
    assert len(length) > 1
    assert length.sum() == pytest.approx(30.5)


def test_an_element_that_stands_still_on_its_way_is_told() -> None:
    good, bad = np.zeros((TERMS, 3)), np.zeros((TERMS, 3))
    good[1, 0] = bad[3, 0] = 1.0  # u³ begins with standstill
    *_, failed = arranged(np.stack([good, bad]))
    assert failed == 1


def test_without_main_axes_the_length_is_that_of_the_others() -> None:
    c = np.zeros((TERMS, 5))
    c[1, 3], c[1, 4] = 3.0, 4.0
    _, length, main, _, failed = arranged(c[None])
    assert (length.tolist(), main.tolist(), failed) == ([pytest.approx(5.0)], [False], -1)


def test_an_element_without_length_is_kept_as_one() -> None:
    _, length, _, parent, failed = arranged(np.zeros((2, TERMS, 3)))
    assert (length.tolist(), parent.tolist(), failed) == ([0.0, 0.0], [0, 1], -1)
