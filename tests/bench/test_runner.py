"""`python -m bench`: every subject runs, a failure does not hide the others, limits are told and never enforced."""

from __future__ import annotations

import json
import sys
import types
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import bench.__main__ as runner
from bench.figure import Figure
from bench.stopwatch import distribution


@pytest.fixture
def subjects(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[..., None]:
    """Replace the measurements by functions, and the working folder by an empty one."""

    def replace(**functions: Callable[[], list[Figure]]) -> None:
        monkeypatch.setattr(runner, "subjects", lambda: sorted(functions))
        for name, function in functions.items():
            module = types.ModuleType(f"bench.{name}")
            module.measure = function  # type: ignore[attr-defined]
            monkeypatch.setitem(sys.modules, f"bench.{name}", module)

    monkeypatch.chdir(tmp_path)
    return replace


def broken() -> list[Figure]:
    raise RuntimeError("no bus")


def test_figures_are_printed_and_written(subjects: Callable[..., None], capsys: pytest.CaptureFixture[str]) -> None:
    subjects(
        cycle=lambda: [Figure("work, 99th percentile", 612.5, "µs", limit=500), Figure("overruns", 0, "", limit=0)],
        rate=lambda: [Figure("blocks", 2_000_000, "1/s", limit=1_000_000, better="higher"), Figure("plain", 1.0, "s")],
    )
    assert runner.main([]) == 0  # a missed limit is told, not enforced
    printed = capsys.readouterr().out
    assert "612.5" in printed
    assert "missed" in printed
    written = json.loads(Path("out/bench.json").read_text())
    assert set(written) == {"computer", "figures"}
    assert [figure["good"] for figure in written["figures"]["cycle"]] == [False, True]
    assert [figure["good"] for figure in written["figures"]["rate"]] == [True, True]
    assert written["figures"]["cycle"][0] == {
        "name": "work, 99th percentile",
        "value": 612.5,
        "unit": "µs",
        "limit": 500,
        "better": "lower",
        "good": False,
    }


def test_a_measurement_that_fails_does_not_hide_the_others(
    subjects: Callable[..., None], capsys: pytest.CaptureFixture[str]
) -> None:
    subjects(first=broken, second=lambda: [Figure("n", 1.0, "s")])
    assert runner.main([]) == 1
    captured = capsys.readouterr()
    assert "no bus" in captured.err
    assert "failed: first" in captured.out
    assert list(json.loads(Path("out/bench.json").read_text())["figures"]) == ["second"]


def test_named_subjects_only(subjects: Callable[..., None]) -> None:
    subjects(first=broken, second=lambda: [Figure("n", 1.0, "s")])
    assert runner.main(["second"]) == 0
    assert runner.main(["third"]) == 2


def test_every_module_that_measures_is_a_subject() -> None:
    modules = {file.stem for file in Path("bench").glob("*.py") if "\ndef measure() -> " in file.read_text()}
    assert set(runner.subjects()) == modules
    assert {"machine", "interpolator", "command"} <= modules


def test_a_distribution_is_that_of_the_calmest_window() -> None:
    calm, disturbed = np.arange(1, 1001) * 1000, np.full(1000, 5_000_000)
    median, p99, p999, highest, everything = distribution("work", [disturbed, calm], limit=500.0)
    assert (round(median.value), round(p99.value), round(p999.value), highest.value) == (500, 990, 999, 1000.0)
    assert everything.value == 5000.0
    assert p99.limit == 500.0
    assert not p99.good
