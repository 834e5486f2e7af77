"""The ring between preparation and interpolator."""

from __future__ import annotations

import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.motion_queue import RECORD, MotionQueue, Records
from runtime.cnc.queue_limits import DECELERATION, SETS, VELOCITY


def numbered(first: int, count: int) -> Records:
    records = np.zeros(count, dtype=RECORD)
    records["line"] = np.arange(first, first + count)
    return records


@settings(max_examples=50, deadline=None, derandomize=True)
@given(steps=st.lists(st.tuples(st.integers(0, 30), st.integers(0, 30)), max_size=40))
def test_everything_comes_out_once_and_in_order(steps: list[tuple[int, int]]) -> None:
    queue = MotionQueue(3, capacity=16)
    offered = taken = 0
    for append, take in steps:
        free = queue.free
        done = queue.append(numbered(offered, append))
        assert done == min(append, free)
        offered += done
        for _ in range(min(take, queue.written - queue.read)):
            assert int(queue.record(taken)["line"]) == taken
            taken += 1
            queue.counters[1] = taken
        assert queue.free == 16 - (offered - taken)


def test_a_second_user_sees_the_same_memory() -> None:
    name = f"tandem-test-queue-{os.getpid()}"
    producer = MotionQueue(3, name, capacity=64)
    consumer = MotionQueue(3, name, create=False, capacity=64)
    try:
        program = producer.program_id("part.nc")
        records = numbered(5, 3)
        records["program"] = program
        producer.append(records)
        assert consumer.written == 3
        assert int(consumer.record(2)["line"]) == 7
        assert consumer.program_name(program) == "part.nc"
        consumer.discard_all()
        assert producer.free == 64
    finally:
        consumer.close()
        producer.close(unlink=True)
    with pytest.raises(FileNotFoundError):
        MotionQueue(3, name, create=False, capacity=64)


def test_many_programs_keep_the_newest_names() -> None:
    queue = MotionQueue(1, capacity=4)
    ids = [queue.program_id(f"{k}.nc") for k in range(100)]
    assert queue.program_id("99.nc") == ids[99]
    assert queue.program_name(ids[99]) == "99.nc"
    assert queue.program_id("0.nc") not in ids


@pytest.mark.parametrize("axes", [0, 9])
def test_impossible_numbers_of_axes_are_refused(axes: int) -> None:
    with pytest.raises(ValueError, match="1 to 8 axes"):
        MotionQueue(axes)


def axis_limits(velocity: float) -> AxisLimits:
    return AxisLimits(np.full(3, velocity), np.full(3, 2000.0), np.full(3, 5e4), np.full(3, 5.0))


def test_sets_of_limits_are_kept_as_long_as_their_records() -> None:
    queue = MotionQueue(3, capacity=512)
    numbers = []
    for k in range(SETS):
        assert queue.limits.room
        numbers.append(queue.limits.put(axis_limits(100.0 + k)))
        assert queue.limits.put(axis_limits(100.0 + k)) == numbers[-1]  # nothing new
        queue.append(numbered(k, 1))
    assert numbers == list(range(SETS))
    assert not queue.limits.room
    queue.counters[1] = 1
    assert queue.limits.room
    assert queue.limits.put(axis_limits(1.0)) == SETS
    assert queue.limits.sets[0, VELOCITY].tolist() == [1.0, 1.0, 1.0] + 5 * [np.inf]
    assert queue.limits.sets[1, DECELERATION, 0] == 2000.0
    assert not queue.limits.room
