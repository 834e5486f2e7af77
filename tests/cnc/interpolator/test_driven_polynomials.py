"""Polynomials through writer, queue and interpolator: the path is the polynomial, the axes keep their limits."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.block_json import rows
from runtime.cnc.blocks import Line, Polynomials, Source
from runtime.cnc.motion_queue import MotionQueue, RecordKind
from runtime.cnc.path_preparation import PathError, PumpState, QueueWriter, SoftwareLimitError, SoftwareLimits
from runtime.diagnostics.catalogue.motion import NO_FEED, PATH_GAP, POLYNOMIAL_GEOMETRY
from tests.cnc.interpolator.driving import PERIOD, Order, check_path_laws, drive, limits

Floats = npt.NDArray[np.float64]
HARD = limits(250.0, 2000.0, 50_000.0, 0.0)
S = Source("p", 1)


def run_of(coefficients: Floats, feed: float = 6000.0) -> Polynomials:
    k, _, n = coefficients.shape
    numbers = np.full(k, -1)
    return Polynomials(
        "p", coefficients, np.full(k, feed), np.arange(2, k + 2), numbers, np.ones(k, dtype=np.bool_), np.zeros(n)
    )


def hermite(points: Floats, tangents: Floats) -> Floats:
    """Quintics (k, 6, n) through points (k + 1, n) with tangents per element and no second derivative at the joints."""
    p0, p1, m0, m1 = points[:-1], points[1:], tangents[:-1], tangents[1:]
    way = p1 - p0
    made = np.zeros((len(way), 6, points.shape[1]))
    made[:, 0], made[:, 1] = p0, m0
    made[:, 3] = 10 * way - 6 * m0 - 4 * m1
    made[:, 4] = -15 * way + 8 * m0 + 7 * m1
    made[:, 5] = 6 * way - 3 * m0 - 3 * m1
    return made


@st.composite
def runs(draw: st.DrawFn) -> Floats:
    """Smooth curves of some elements that go on in X."""
    count = draw(st.integers(1, 6))
    sides = st.floats(-3.0, 3.0)
    points = np.array([[10.0 * k, draw(sides), draw(sides)] for k in range(count + 1)])
    points *= draw(st.sampled_from([0.02, 0.3, 1.0, 5.0]))
    tangents = np.gradient(points, axis=0) if count > 1 else np.repeat(np.diff(points, axis=0), 2, axis=0)
    return hermite(points, tangents)


def off_the_path(place: Floats, coefficients: Floats) -> float:
    """Distance of a place from a run whose X only grows."""
    element = int(np.clip(np.searchsorted(coefficients[:, 0, 0], place[0], side="right") - 1, 0, len(coefficients) - 1))
    column = coefficients[element, ::-1, 0].copy()
    column[-1] -= place[0]
    roots = np.roots(column)
    u = roots[np.argmin(np.abs(roots.imag) + np.abs(np.clip(roots.real, 0.0, 1.0) - roots.real))].real
    return float(np.linalg.norm(u ** np.arange(6) @ coefficients[element] - place))


@given(runs(), st.floats(200.0, 20_000.0), st.integers(20, 400))
@settings(max_examples=25, deadline=None)
def test_path_limits_and_end(coefficients: Floats, feed: float, held: int) -> None:
    def schedule(cycle: int, _: object) -> Order:
        return Order(override=0.3 + (cycle // 50 % 3) * 0.85, hold=held < cycle < held + 30)

    run = drive([run_of(coefficients, feed)], HARD, coefficients[0, 0], schedule)
    assert run.finished
    check_path_laws(run)
    path = run.path
    assert path[-1].tolist() == pytest.approx(coefficients[-1].sum(axis=0).tolist(), abs=1e-12)
    for place in path[:: max(1, len(path) // 60)]:
        assert off_the_path(place, coefficients) < 1e-6
    velocity = np.diff(path, axis=0) / PERIOD
    acceleration = np.diff(velocity, axis=0) / PERIOD
    assert np.abs(velocity).max() <= 250.0 * 1.005
    assert np.abs(acceleration).max() <= 2000.0 * 1.02


def test_lines_and_polynomials_join_without_stopping() -> None:
    curve = hermite(np.array([[20.0, 0, 0], [40.0, 20, 0]]), np.array([[30.0, 0, 0], [0.0, 30, 0]]))
    start, end = np.zeros(3), np.array([40.0, 60.0, 0.0])
    first = Line(S, start, curve[0, 0], 6000.0, False, curve[0, 0])
    last = Line(S, curve[0].sum(axis=0), end, 6000.0, False, end)
    run = drive([first, run_of(curve), last], HARD, start)
    inside = np.array(run.record)
    assert run.path[-1].tolist() == end.tolist()
    first_of_last = int(np.argmax(inside == inside.max()))
    assert run.v[first_of_last] > 20.0
    check_path_laws(run)


def test_block_ends_and_json() -> None:
    c = np.zeros((2, 6, 3))
    c[0, 1, 0] = c[1, 0, 0] = c[1, 1, 1] = 5.0
    run = drive([run_of(c)], HARD, np.zeros(3))
    assert [index for _, index in run.passed] == [0, 1]
    assert [int(record["block_end"]) for record in run.elements.values()] == [1, 1]
    first, second = rows(run_of(c), ("X", "Y", "Z"))
    assert (first["type"], first["line"], first["from"]) == ("poly", 2, {"X": 0.0, "Y": 0.0, "Z": 0.0})
    assert second["to"] == {"X": 5.0, "Y": 5.0, "Z": 0.0}
    assert second["coefficients"] == {"X": [5.0, 0, 0, 0, 0, 0], "Y": [0.0, 5.0, 0, 0, 0, 0], "Z": [0.0] * 6}


def test_single_block_stops_at_the_ends_of_its_blocks() -> None:
    c = np.zeros((2, 6, 3))
    c[0, 1, 0] = c[1, 0, 0] = c[1, 1, 0] = 5.0
    run = drive([run_of(c)], HARD, np.zeros(3), lambda _, i: Order(single_block=True, open_gates=i.at_gate))
    stops = {round(float(p[0]), 9) for p, v in zip(run.path, run.v, strict=True) if v == 0.0}
    assert stops == {5.0, 10.0}


def test_what_cannot_be_driven_is_refused() -> None:
    still, gap = np.zeros((1, 6, 3)), np.zeros((2, 6, 3))
    still[0, 3, 0] = 1.0
    gap[0, 1, 0] = gap[1, 1, 0] = 1.0
    for coefficients, feed, entry in (
        (still, 100.0, POLYNOMIAL_GEOMETRY),
        (gap, 100.0, PATH_GAP),
        (gap[:1], 0.0, NO_FEED),
    ):
        queue = MotionQueue(3)
        with pytest.raises(PathError) as error:
            QueueWriter(queue, HARD, PERIOD).pump(iter([run_of(coefficients, feed)]))
        assert error.value.problem.entry is entry
        assert queue.written == 0


def test_software_limits_see_the_turning_point() -> None:
    c = np.zeros((1, 6, 3))
    c[0, 1, 0], c[0, 1, 1], c[0, 2, 1] = 10.0, 8.0, -8.0  # Y rises to 2 in the middle and comes back
    for limit, fits in ((2.001, True), (1.999, False)):
        stage = SoftwareLimits(["X", "Y", "Z"], [None] * 3, [None, limit, None])
        if fits:
            assert len(list(stage([run_of(c)]))) == 1
        else:
            with pytest.raises(SoftwareLimitError):
                list(stage([run_of(c)]))


def test_a_small_queue_takes_a_long_run_in_pieces() -> None:
    points = np.array([[0.1 * k, math.sin(0.1 * k), 0.0] for k in range(601)])
    coefficients = hermite(points, np.gradient(points, axis=0))
    run = drive([run_of(coefficients)], HARD, points[0], capacity=64)
    assert run.finished
    assert run.path[-1].tolist() == pytest.approx(points[-1].tolist(), abs=1e-12)
    assert all(int(record["kind"]) == RecordKind.POLYNOMIAL for record in run.elements.values())
    check_path_laws(run)
    assert max(off_the_path(place, coefficients) for place in run.path[::25]) < 1e-6
    assert QueueWriter(MotionQueue(3), HARD, PERIOD).pump(iter([])) is PumpState.FINISHED
