"""Histograms of the cycle: bounded, consistent, readable from another process."""

from __future__ import annotations

import multiprocessing
import os

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.diagnostics.memory import open_shared
from runtime.scheduler.statistics import BOUNDS_NS, CycleStatistics

durations = st.lists(st.integers(0, 10**9), min_size=1, max_size=60)


@settings(max_examples=60, deadline=None)
@given(durations)
def test_every_duration_is_in_its_bucket(values: list[int]) -> None:
    statistics = CycleStatistics()
    for value in values:
        statistics.work.add(value)
    lower = -1
    for bound, count in zip((*BOUNDS_NS, 2 * 10**9), statistics.work.counts, strict=True):
        assert count == sum(lower < value <= bound for value in values)
        lower = bound
    assert statistics.work.count == len(values)
    assert statistics.work.sum == pytest.approx(sum(values) / 1e9)
    assert statistics.work.greatest == max(values) / 1e9
    assert statistics.work.last == values[-1] / 1e9
    assert statistics.lateness.count == 0


@settings(max_examples=60, deadline=None)
@given(durations, st.floats(0, 1))
def test_a_quantile_stands_in_the_bucket_of_the_true_one(values: list[int], share: float) -> None:
    statistics = CycleStatistics()
    for value in values:
        statistics.work.add(value)
    quantile = statistics.work.quantile(share) * 1e9
    index = max(0, -int(-share * len(values) // 1) - 1)
    true = sorted(values)[min(index, len(values) - 1)]
    bounds = (0, *BOUNDS_NS, max(*values, BOUNDS_NS[-1]))
    lower = max(bound for bound in bounds if bound < true or bound == 0)
    upper = min(bound for bound in bounds[1:] if bound >= true)  # 0 counts in the first bucket
    assert lower - 1e-3 <= quantile <= upper + 1e-3


def test_nothing_counted_is_zero() -> None:
    assert CycleStatistics().work.quantile(0.99) == 0.0


def _count(name: str) -> None:
    statistics = CycleStatistics(name, create=False)
    for value in (1_000, 1_001, 10**12):
        statistics.lateness.add(value)
    statistics.close()


def test_another_process_reads_and_writes_the_same_numbers() -> None:
    name = f"tandem-test-{os.getpid()}-statistics"
    statistics = CycleStatistics(name)
    try:
        process = multiprocessing.get_context("spawn").Process(target=_count, args=(name,))
        process.start()
        process.join()
        assert process.exitcode == 0
        assert statistics.lateness.counts[:2] == (1, 1)
        assert statistics.lateness.counts[-1] == 1
        assert statistics.work.count == 0
    finally:
        statistics.close(unlink=True)
    with pytest.raises(FileNotFoundError):
        CycleStatistics(name, create=False)


def test_memory_of_something_else_is_refused() -> None:
    name = f"tandem-test-{os.getpid()}-other"
    memory = open_shared(name, 4096)
    try:
        with pytest.raises(ValueError, match="no cycle statistics"):
            CycleStatistics(name, create=False)
    finally:
        memory.remove()
