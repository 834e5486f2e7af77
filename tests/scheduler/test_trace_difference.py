"""Comparing two traces: distances of paths, times of lines."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.diagnostics.catalogue import system
from runtime.scheduler.trace import write_samples
from runtime.scheduler.trace_difference import TraceError, compare, corner_points, deviations, read_trace

Floats = npt.NDArray[np.float64]


def folder_of(
    path: Path, points: Floats, lines: list[int], errors: tuple[str, ...] = (), axes: tuple[str, ...] = ("X", "Y", "Z")
) -> Path:
    """A trace folder with a sample per millisecond."""
    path.mkdir()
    t = np.arange(1.0, len(points) + 1.0) * 1e-3
    speed = np.linalg.norm(np.diff(points, axis=0, prepend=points[:1]), axis=1) / 1e-3
    arrays = {"t": t, **{axis: points[:, i] for i, axis in enumerate(axes)}, "v_path": speed, "line": np.array(lines)}
    write_samples(path / "samples.npz", arrays)
    (path / "summary.json").write_text(json.dumps({"errors": list(errors)}))
    return path


def along(*corners: tuple[float, float, float], step: float = 0.25) -> Floats:
    """Samples along straight ways."""
    parts = [np.array([corners[0]])]
    for a, b in zip(np.array(corners[:-1]), np.array(corners[1:]), strict=True):
        count = max(round(float(np.linalg.norm(b - a)) / step), 1)
        parts.append(a + np.linspace(0.0, 1.0, count + 1)[1:, None] * (b - a))
    return np.concatenate(parts)


def test_the_same_trace_differs_in_nothing(tmp_path: Path) -> None:
    points = along((0, 0, 0), (10, 0, 0), (10, 5, 0))
    lines = [2] * 41 + [3] * 20
    found = compare(
        read_trace(folder_of(tmp_path / "a", points, lines)), read_trace(folder_of(tmp_path / "b", points, lines))
    )
    assert found.deviation == pytest.approx(0.0, abs=1e-12)
    assert found.first.time == pytest.approx(0.061)
    assert [(one.line, one.won) for one in found.lines] == [(2, 0.0), (3, 0.0)]
    assert set(found.axes.values()) == {0.0}


def test_deviation_time_and_place_are_those_of_the_paths(tmp_path: Path) -> None:
    """A corner of 10 mm that is cut: the corner is 1 mm away, though no sample of the other path is."""
    first = along((0, 0, 0), (10, 0, 0), (10, 10, 0))
    cut = np.sqrt(2.0)
    second = along((0, 0, 0), (10 - cut, 0, 0), (10, cut, 0), (10, 10, 0), step=0.5)
    a = read_trace(folder_of(tmp_path / "a", first, [1] * 41 + [2] * (len(first) - 41), ("x: 1: only here",)))
    b = read_trace(folder_of(tmp_path / "b", second, [1] * 20 + [2] * (len(second) - 20)))
    found = compare(a, b)
    assert found.deviation == pytest.approx(1.0)
    assert found.place.tolist() == [10.0, 0.0, 0.0]
    assert found.line == 1
    by_line = {one.line: one for one in found.lines}
    assert by_line[1].won == pytest.approx(-0.021)
    assert sum(one.won for one in found.lines) == pytest.approx(b.time - a.time)


def test_a_path_that_goes_the_same_way_twice_is_followed_in_order(tmp_path: Path) -> None:
    """The second pass lies 0.1 mm beside the first one: a nearest place anywhere would find no difference."""
    first = along((0, 0, 0), (50, 0, 0), (50, 20, 0), (0, 20, 0), (0, 0.1, 0), (50, 0.1, 0))
    second = along((0, 0, 0), (50, 0, 0), (50, 20, 0), (0, 20, 0), (0, 0, 0), (50, 0, 0))
    distance, at = deviations(first, second)
    assert distance[-1] == pytest.approx(0.1)
    assert distance[:200].max() == pytest.approx(0.0, abs=1e-12)
    assert at[-1] == pytest.approx(50 + 20 + 50 + 19.9 + 50)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(*[st.integers(-20, 20)] * 3), min_size=1, max_size=8), st.integers(1, 5))
def test_a_polyline_of_corners_is_the_path(corners: list[tuple[int, int, int]], steps: int) -> None:
    points = along(*[(float(x), float(y), float(z)) for x, y, z in corners], step=0.5 * steps)
    kept = points[corner_points(points)]
    assert len(kept) <= len(corners) + 1
    distance, _ = deviations(points, points)
    assert distance.max() < 1e-6


def test_what_is_no_trace_is_told(tmp_path: Path) -> None:
    points = along((0, 0, 0), (1, 0, 0))
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "samples.npz").write_text("no archive")
    empty = folder_of(tmp_path / "empty", np.zeros((0, 3)), [])
    for folder in (tmp_path / "missing", tmp_path / "broken", empty):
        with pytest.raises(TraceError) as caught:
            read_trace(folder)
        assert caught.value.problem.entry is system.NO_TRACE
    good = read_trace(folder_of(tmp_path / "a", points, [1] * len(points)))
    other = read_trace(folder_of(tmp_path / "b", points[:, :2], [1] * len(points), axes=("X", "C")))
    with pytest.raises(TraceError):
        compare(good, other)
    one = read_trace(folder_of(tmp_path / "one", points[:1], [1]))
    assert compare(one, one).deviation == 0.0
