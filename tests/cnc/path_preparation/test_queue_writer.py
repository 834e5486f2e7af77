"""Blocks become records: limits, lengths, corners; a full queue is no problem."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
import pytest

from runtime.cnc.blocks import (
    Arc,
    AxisLimitChange,
    Block,
    BlockEnd,
    Dwell,
    ExternalWrite,
    Flush,
    FlushKind,
    Hold,
    Line,
    Message,
    Polyline,
    Receiver,
    Source,
    Stop,
    StopKind,
    Synch,
    Technology,
    TechnologyFunction,
    TimerAction,
    TimerCommand,
    UserError,
    Wait,
)
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.motion_queue import ActionKind, GateReason, MotionQueue, RecordKind
from runtime.cnc.path_preparation import PathError, PumpState, QueueWriter
from runtime.cnc.queue_limits import ACCELERATION, DECELERATION, SETS
from runtime.cnc.queue_record import read_record
from runtime.cnc.queue_texts import TEXTS
from tests.cnc.interpolator.driving import PERIOD, limits

Floats = npt.NDArray[np.float64]
LIMITS = AxisLimits(
    np.array([400.0, 300.0, 200.0]), np.array([4000.0, 3000.0, 2000.0]), np.full(3, 6e4), np.array([5.0, 4.0, 3.0])
)
S = Source("p", 3, 30)


def at(*place: float) -> Floats:
    return np.array(place)


def line(start: Floats, end: Floats, feed: float = 6000.0) -> Line:
    return Line(S, start, end, feed, math.isinf(feed), end)


def written(*blocks: Block, axes: AxisLimits = LIMITS) -> MotionQueue:
    queue = MotionQueue(axes.n, capacity=256)
    writer = QueueWriter(queue, axes, PERIOD, ("X", "Y", "Z"))
    assert writer.pump(iter(blocks)) is PumpState.FINISHED
    return queue


def test_rapid_runs_one_axis_at_its_limit() -> None:
    record = written(line(at(0, 0, 0), at(30, 40, 0), math.inf)).record(0)
    assert record["length"] == 50.0
    assert record["v_limit"] == pytest.approx(300.0 / 0.8)
    assert record["a_limit"] == pytest.approx(3000.0 / 0.8)
    assert record["rapid"] == 1


def test_corner_speed_is_what_the_velocity_steps_allow() -> None:
    queue = written(
        line(at(0, 0, 0), at(50, 0, 0)), line(at(50, 0, 0), at(50, 50, 0)), line(at(50, 50, 0), at(50, 80, 0))
    )
    assert queue.record(1)["v_entry"] == pytest.approx(4.0)  # X stops (5 mm/s), Y starts (4 mm/s)
    assert math.isinf(queue.record(2)["v_entry"])  # straight on


def test_without_velocity_step_a_corner_is_a_stop_but_a_tangent_is_not() -> None:
    hard = limits(400.0, 4000.0, 60_000.0, 0.0)
    arc = Arc(S, at(50, 0, 0), at(60, 10, 0), 6000.0, at(60, 10, 0), (0, 1), at(50, 10), 10.0, 90.0)
    queue = written(line(at(0, 0, 0), at(50, 0, 0)), arc, line(at(60, 10, 0), at(70, 10, 0)), axes=hard)
    assert queue.record(1)["v_entry"] > 10.0
    assert queue.record(2)["v_entry"] == 0.0


def test_arcs_leave_acceleration_for_their_curvature() -> None:
    hard = limits(400.0, 4000.0, 60_000.0, 5.0)
    end = at(0, 20, 0)
    record = written(Arc(S, at(0, 0, 0), end, 60_000.0, end, (0, 1), at(0, 10), 10.0, 180.0), axes=hard).record(0)
    v, a, j = float(record["v_limit"]), float(record["a_limit"]), float(record["j_limit"])
    assert record["length"] == pytest.approx(10.0 * math.pi)
    assert math.hypot(a, v * v / 10.0) <= 4000.0 + 1e-9
    assert math.hypot(j + v**3 / 100.0, 3.0 * v * a / 10.0) <= 60_000.0 * (1 + 1e-9)
    assert v > 100.0


def test_moves_without_length_vanish_but_their_block_end_stays() -> None:
    queue = written(line(at(1, 1, 1), at(1, 1, 1)), BlockEnd(S), line(at(1, 1, 1), at(2, 1, 1)))
    assert [int(queue.record(i)["kind"]) for i in range(queue.written)] == [RecordKind.BLOCK_END, RecordKind.LINE]
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 0], [2, 0, 0]])
    run = Polyline("p", points, np.full(3, 600.0), np.array([4, 5, 6]), np.full(3, -1), np.zeros(3))
    queue = written(run)
    assert [int(queue.record(i)["kind"]) for i in range(3)] == [RecordKind.LINE, RecordKind.BLOCK_END, RecordKind.LINE]
    assert [int(queue.record(i)["line"]) for i in range(3)] == [4, 5, 6]
    assert queue.record(2)["start"][:3].tolist() == [1, 0, 0]


def test_functions_and_gates() -> None:
    queue = written(
        TechnologyFunction(S, Technology.S, 3, 1200.0, Synch.MVS_SVS | Synch.PLC_INFO, 1),
        Wait(S),
        Dwell(S, 0.25),
        Stop(S, StopKind.OPTIONAL),
        Stop(S, StopKind.PROGRAM_END),
    )
    function = queue.record(0)
    assert (function["function"], function["number"], function["value"], function["spindle"]) == (3, 3, 1200.0, 1)
    assert Synch(int(function["synch"])) == Synch.MVS_SVS | Synch.PLC_INFO
    assert [int(queue.record(i)["reason"]) for i in range(1, 5)] == [
        GateReason.WAIT,
        GateReason.DWELL,
        GateReason.OPTIONAL_STOP,
        GateReason.PROGRAM_END,
    ]
    assert queue.record(2)["seconds"] == 0.25
    assert (queue.record(1)["line"], queue.record(1)["n"]) == (3, 30)
    assert queue.program_name(int(queue.record(1)["program"])) == "p"


def test_a_full_queue_interrupts_a_polyline_and_it_goes_on() -> None:
    k = 100
    points = np.stack([np.arange(k + 1.0), np.zeros(k + 1), np.zeros(k + 1)], axis=1)
    run = Polyline("p", points, np.full(k, 600.0), np.arange(k), np.full(k, -1), np.zeros(3))
    queue = MotionQueue(3, capacity=32)
    writer = QueueWriter(queue, LIMITS, PERIOD)
    blocks: Iterator[Block] = iter([run, BlockEnd(S)])
    ends: list[float] = []
    states = set()
    while True:
        state = writer.pump(blocks, budget=20)
        states.add(state)
        ends += [
            float(queue.record(i)["end"][0]) for i in range(queue.read, queue.written) if queue.record(i)["kind"] == 0
        ]
        if state is PumpState.FULL or state is PumpState.FINISHED:
            queue.discard_all()
        else:
            ends = ends[: len(ends) - (queue.written - queue.read)]
        if state is PumpState.FINISHED:
            break
    assert ends == list(range(1, k + 1))
    assert PumpState.MORE in states
    assert PumpState.FULL in states


def arc(centre: Floats, radius: float, angle: float) -> Arc:
    return Arc(S, at(0, 0, 0), at(1, 0, 0), 600.0, at(1, 0, 0), (0, 1), centre, radius, angle)


@pytest.mark.parametrize(
    ("block", "number", "words"),
    [
        (line(at(0, 0, 0), at(1, 0, 0), 0.0), 301003, "feed of 0 mm/min"),
        (line(at(0, 0, 0), at(1, 0, math.nan)), 301004, "axis Z is not a number"),
        (Arc(S, at(0, 0, 0), at(1, 0, 0), 0.0, at(1, 0, 0), (0, 1), at(0.5, 0), 0.5, 180.0), 301003, "feed of 0"),
        (arc(at(0.5, 0), math.inf, 180.0), 301005, "an arc of radius inf mm and 180 degrees"),
        (arc(at(0.5, 0), 0.5, math.nan), 301005, "an arc of radius 0.5 mm and nan degrees"),
        (arc(at(math.inf, 0), 0.5, 90.0), 301005, "an arc of radius 0.5 mm and 90 degrees"),
    ],
)
def test_what_cannot_be_driven_is_refused(block: Block, number: int, words: str) -> None:
    queue = MotionQueue(3, capacity=8)
    with pytest.raises(PathError, match=words) as caught:
        QueueWriter(queue, LIMITS, PERIOD, ("X", "Y", "Z")).write(block)
    assert caught.value.problem.entry.id == number
    assert caught.value.problem.place.line == 3
    assert queue.written == 0


def test_a_gap_in_the_path_is_refused() -> None:
    queue = MotionQueue(3, capacity=8)
    writer = QueueWriter(queue, LIMITS, PERIOD, ("X", "Y", "Z"))
    writer.write(line(at(0, 0, 0), at(1, 0, 0)))
    with pytest.raises(PathError, match=r"starts at 2\.0+ of axis Y"):
        writer.write(line(at(1, 2, 0), at(1, 5, 0)))


# --------------------------------------------------------------------------------------------- flush, hold, actions


def test_actions_become_records_with_their_texts() -> None:
    queue = written(
        Message(S, "hello", Receiver.HMI, information=True),
        TimerAction(S, TimerCommand.READ, 17),
        ExternalWrite(S, 24, "SGN16", 2, -5.0),
        ExternalWrite(S, 48, "STRING", 12, "roughing"),
        UserError(S, 455, 0, 0),
    )
    records = [read_record(queue, index) for index in range(queue.written)]
    assert [record.kind for record in records] == [RecordKind.ACTION] * 5
    assert [record.action for record in records] == [
        ActionKind.MESSAGE, ActionKind.TIMER, ActionKind.EXTERNAL, ActionKind.EXTERNAL, ActionKind.WARNING,
    ]  # fmt: skip
    texts = [queue.texts.take(record.text) for record in records]
    assert texts == ["hello", "", "", "roughing", "user error 455"]
    assert (records[1].number, records[2].value, records[2].offset, records[3].size) == (17, -5.0, 24, 12)


@pytest.mark.parametrize("acknowledge", [False, True])
@pytest.mark.parametrize("receiver", [Receiver.PLC, Receiver.DIAGNOSIS])
def test_only_messages_that_may_hold_the_path_have_a_gate(receiver: Receiver, acknowledge: bool) -> None:
    queue = written(*(Message(S, "x", receiver, acknowledge) for _ in range(2)))
    records = [read_record(queue, index) for index in range(queue.written)]
    gates = [record for record in records if record.kind is RecordKind.GATE]
    plc = receiver is Receiver.PLC
    assert [(gate.reason, gate.number, gate.value) for gate in gates] == [
        (GateReason.MESSAGE, number if plc else 0, float(acknowledge))
        for number in ((1, 2) if plc or acknowledge else ())
    ]


def test_errors_of_a_higher_class_are_gates() -> None:
    queue = written(UserError(S, 1, 2, 0), UserError(S, 2, 7, 0))
    records = [read_record(queue, index) for index in range(2)]
    assert [(record.kind, record.reason, record.value) for record in records] == [
        (RecordKind.GATE, GateReason.USER_ERROR, 2.0),
        (RecordKind.GATE, GateReason.USER_ERROR, 7.0),
    ]


def test_the_writer_comes_back_after_a_flush_that_waits_and_asks_for_nothing_more() -> None:
    asked: list[int] = []

    def blocks() -> Iterator[Block]:
        yield Flush(S, FlushKind.CONTINUE)
        yield Flush(S, FlushKind.STOP)
        yield Flush(S, FlushKind.WAIT)
        asked.append(1)
        yield Hold(S, "V.E.A == 1")
        yield Hold(S, "V.E.A == 1")
        yield BlockEnd(S)

    queue, stream = MotionQueue(3, capacity=1), blocks()
    writer = QueueWriter(queue, LIMITS, PERIOD)
    states = []
    for _ in range(8):
        states.append(writer.pump(stream))
        if states[-1] is PumpState.FULL:
            queue.discard_all()
        assert bool(asked) == (PumpState.HELD in states)  # not before the call after FLUSH
    assert states == [
        PumpState.FULL, PumpState.FLUSH, PumpState.FULL, PumpState.HELD, PumpState.HELD, PumpState.FULL,
        PumpState.FINISHED, PumpState.FINISHED,
    ]  # fmt: skip


def test_a_text_without_a_place_waits_and_nothing_is_lost() -> None:
    queue = MotionQueue(3, capacity=1024)
    writer = QueueWriter(queue, LIMITS, PERIOD)
    stream: Iterator[Block] = iter([Message(S, f"{k}") for k in range(2 * TEXTS + 3)])
    texts, done = [], 0
    for state in (PumpState.FULL, PumpState.FULL, PumpState.FINISHED):
        assert writer.pump(stream) is state
        texts += [queue.texts.take(read_record(queue, index).text) for index in range(done, queue.written)]
        done = queue.written
    assert texts == [f"{k}" for k in range(2 * TEXTS + 3)]


def test_limits_change_in_the_stream_and_every_element_names_its_own() -> None:
    slow = AxisLimits(LIMITS.velocity, LIMITS.acceleration, LIMITS.jerk, LIMITS.velocity_step, LIMITS.acceleration / 4)
    queue = written(
        line(at(0, 0, 0), at(5, 0, 0)), AxisLimitChange(S, slow), line(at(5, 0, 0), at(9, 0, 0)),
        AxisLimitChange(S, LIMITS), line(at(9, 0, 0), at(12, 0, 0)),
    )  # fmt: skip
    assert queue.written == 3
    sets = [queue.limits.sets[queue.record(k)["limits"]] for k in range(3)]
    assert [one[ACCELERATION, 0] for one in sets] == [4000.0, 4000.0, 4000.0]
    assert [one[DECELERATION, 0] for one in sets] == [4000.0, 1000.0, 4000.0]
    assert [float(queue.record(k)["a_limit"]) for k in range(3)] == [4000.0, 1000.0, 4000.0]


def test_the_writer_waits_when_all_sets_of_limits_are_in_use() -> None:
    queue = MotionQueue(3, capacity=1024)
    writer = QueueWriter(queue, LIMITS, PERIOD)

    def changing() -> Iterator[Block]:
        for k in range(SETS + 10):
            yield AxisLimitChange(
                S, AxisLimits(LIMITS.velocity, LIMITS.acceleration + k, LIMITS.jerk, LIMITS.velocity_step)
            )
            yield line(at(k, 0, 0), at(k + 1, 0, 0))

    blocks = changing()
    assert writer.pump(blocks) is PumpState.FULL
    assert queue.written == SETS
    queue.counters[1] = 20
    assert writer.pump(blocks) is PumpState.FINISHED
    assert queue.written == SETS + 10


def test_what_a_corner_allows_by_itself_leaves_its_curvature_out() -> None:
    t = np.linspace(0.0, 1.0, 40)
    points = np.stack([10 * np.cos(t), 10 * np.sin(t), 0 * t], axis=1)
    curve = Polyline("p", points, np.full(39, 60_000.0), np.arange(39), np.full(39, -1), at(0, 0, 0))
    queue = written(curve)
    turn = np.abs(np.diff(np.diff(points, axis=0) / np.linalg.norm(np.diff(points, axis=0), axis=1)[:, None], axis=0))
    for k in range(1, 39):
        jump = float((LIMITS.velocity_step / np.maximum(turn[k - 1], 1e-9)).min())
        assert queue.record(k)["v_corner"] == pytest.approx(jump, rel=1e-6)
        assert queue.record(k)["v_entry"] < jump
