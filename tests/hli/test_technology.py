"""The handshake of technology functions: nothing lost, nothing overtaken, nothing acknowledged for another."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import SupportsIndex

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from runtime.hli.layout import TECHNO_UNITS, Channel, TechnologyUnit
from runtime.hli.technology import Function, Kind, Sent, Taken, TechnologyPort, TechnologyTaker

MOS, MVS_SVS, MVS_SNS, MNS_SNS, PLC_INFO = 0x1, 0x2, 0x4, 0x8, 0x20000
MVS_SLM, MVS_SLP = 0x4000, 0x8000


def m(number: int, synch: int = MVS_SVS) -> Function:
    return Function(Kind.M, number, synch=synch)


def sides(present: bool = True) -> tuple[Channel, TechnologyPort, TechnologyTaker]:
    channel = Channel(plc_present_w=present)
    return channel, TechnologyPort(channel), TechnologyTaker(channel)


@pytest.mark.spec("hli.tech.unit", "hli.tech.mh-data")
def test_the_two_steps_taken_and_executed() -> None:
    channel, port, taker = sides()
    function = Function(Kind.H, 12, value=-7, synch=MVS_SNS, line=44, block_number=30, time=5)
    sent = port.put(function)
    unit = channel.techno_unit_std_sync[0]
    assert (unit.please_rw, unit.done_w, unit.fkt_ctrl_r) == (True, False, 2)
    assert (unit.number_r, unit.value_r, unit.line_r, unit.block_number_r, unit.time_r) == (12, -7, 44, 30, 5)
    assert port.poll() == []
    (taken,) = taker.take()
    assert taken.function == function
    assert not unit.please_rw
    assert port.poll() == [], "taken is not executed"
    assert taker.take() == [], "taken once"
    taken.done()
    assert port.poll() == [sent]
    assert sent is not None
    assert sent.done
    assert port.pending == 0


@pytest.mark.spec("hli.tech.sync-kinds")
@pytest.mark.parametrize(
    ("synch", "acknowledged"),
    [(MOS, False), (MVS_SVS, True), (MVS_SNS, True), (MNS_SNS, True), (PLC_INFO | MVS_SVS, True), (0x40000, False)],
)
def test_kinds_without_wait_end_when_they_are_taken(synch: int, acknowledged: bool) -> None:
    channel, port, taker = sides()
    port.put(m(9, synch))
    (taken,) = taker.take()
    assert (port.poll() == []) == acknowledged
    taken.done()
    assert channel.techno_unit_std_sync[0].done_w == acknowledged, "the unit of a MOS may be another's already"


@pytest.mark.spec("hli.tech.s-data", "hli.tech.t-data")
def test_spindle_and_tool_data() -> None:
    _, port, taker = sides()
    port.put(Function(Kind.S, 3, synch=MVS_SVS, revolutions=6_000_000, position=900_000))
    port.put(Function(Kind.T, 7, synch=MOS))
    spindle, tool = taker.take()
    assert (spindle.function.revolutions, spindle.function.position) == (6_000_000, 900_000)
    assert (tool.function.kind, tool.function.number) == (Kind.T, 7)


@pytest.mark.spec("hli.tech.block-sync")
def test_functions_of_a_block_lie_from_index_0_and_may_be_done_in_any_order() -> None:
    channel, port, taker = sides()
    block = [port.put(m(n)) for n in (1, 2, 3)]
    assert [unit.number_r for unit in channel.techno_unit_std_sync[:3]] == [1, 2, 3]
    assert channel.used_units_std_sync_r == 3
    first, second, third = taker.take()
    second.done()
    assert port.poll() == [block[1]]
    assert port.pending == 2
    third.done()
    first.done()
    assert port.poll() == [block[0], block[2]]
    assert channel.used_units_std_sync_r == 0
    port.put(m(4))
    assert channel.techno_unit_std_sync[0].number_r == 4


@pytest.mark.spec("hli.mech.operation-without-plc", "hli.mech.plc-present")
def test_without_a_plc_everything_is_acknowledged_at_once() -> None:
    channel, port, _ = sides(present=False)
    sent = [port.put(m(n)) for n in range(TECHNO_UNITS + 5)]
    assert all(s is not None and s.done for s in sent)
    assert port.poll() == sent
    assert port.poll() == []
    assert not any(unit.please_rw for unit in channel.techno_unit_std_sync)


def test_a_plc_that_logs_off_frees_what_waits() -> None:
    channel, port, taker = sides()
    sent = [port.put(m(1)), port.put(m(2))]
    taker.take()
    channel.plc_present_w = False
    assert port.poll() == sent


def test_a_full_array_takes_nothing_until_it_is_empty() -> None:
    _, port, taker = sides()
    for n in range(TECHNO_UNITS):
        assert port.put(m(n)) is not None
    assert port.put(m(99)) is None
    for taken in taker.take():
        taken.done()
    assert len(port.poll()) == TECHNO_UNITS
    assert port.put(m(99)) is not None


@pytest.mark.spec("hli.ch.cu.reset")
def test_a_late_acknowledgement_of_a_withdrawn_function_acknowledges_no_other() -> None:
    channel = Channel(plc_present_w=True)
    resets: list[bool] = []
    port, taker = TechnologyPort(channel), TechnologyTaker(channel, lambda: resets.append(True))
    old = [port.put(m(1)), port.put(m(2))]
    early, late = taker.take()
    assert port.drop_all() == old
    assert port.put(m(3)) is None, "not before the PLC has forgotten the old ones"
    early.done()
    assert taker.take() == []
    assert resets == [True]
    new = [port.put(m(3)), port.put(m(4))]
    third, fourth = taker.take()
    late.done()
    assert port.poll() == []
    third.done()
    fourth.done()
    assert port.poll() == new


def test_a_reset_without_a_plc_needs_no_answer() -> None:
    channel, port, _ = sides()
    port.put(m(1))
    port.drop_all()
    channel.plc_present_w = False
    assert port.put(m(2)) is not None
    port.poll()
    channel.plc_present_w = True
    assert port.put(m(3)) is not None


class Scanned(list[TechnologyUnit]):
    """The units as a slow PLC scans them: after each one something happens in the CNC."""

    def __init__(self, units: list[TechnologyUnit], between: Callable[[], None]) -> None:
        super().__init__(units)
        self._between = between

    def __iter__(self) -> Iterator[TechnologyUnit]:
        for index in range(len(self)):
            yield super().__getitem__(index)
            self._between()

    def __getitem__(self, index: SupportsIndex | slice) -> TechnologyUnit:  # type: ignore[override]
        raise NotImplementedError


_steps = st.lists(st.sampled_from(["put mos", "put", "poll"]), max_size=3)


@given(st.lists(_steps, max_size=80), st.booleans())
@settings(max_examples=100, deadline=None)
def test_a_scan_that_is_overtaken_by_the_cnc_reorders_nothing(script: list[list[str]], log_on_meanwhile: bool) -> None:
    """The CNC may finish, restart at index 0 and fill the array again while the PLC is in the middle of it."""
    channel, port, taker = sides()
    put: list[int] = []
    taken: list[int] = []
    open_functions: list[Taken] = []
    steps = iter(script)

    def cnc() -> None:
        for action in next(steps, []):
            if action == "poll":
                port.poll()
            elif port.put(m(len(put), MOS if action == "put mos" else MVS_SVS)) is not None:
                put.append(len(put))

    taker._units = Scanned(list(channel.techno_unit_std_sync), cnc)
    for _ in range(4):
        for function in taker.take():
            taken.append(function.function.number)
            open_functions.append(function)
        for function in open_functions:
            function.done()
        if log_on_meanwhile:
            taker.restart()
    taker._units = list(channel.techno_unit_std_sync)
    taken += [function.function.number for function in taker.take()]
    assert taken == put


@pytest.mark.spec("hli.tech.late-sync")
def test_late_functions_have_units_of_their_own_and_any_of_them_may_end_first() -> None:
    channel, port, taker = sides()
    late = [port.put(m(n, MVS_SLM)) for n in (1, 2, 3)]
    block = port.put(m(4))
    assert [unit.number_r for unit in channel.techno_unit_late_sync[:3]] == [1, 2, 3]
    assert [unit.nr_late_sync_r for unit in channel.techno_unit_late_sync[:3]] == [1, 2, 3]
    assert channel.techno_unit_std_sync[0].number_r == 4
    taken = taker.take()
    assert [one.function.number for one in taken] == [1, 2, 3, 4], "in the order of output, over both arrays"
    taken[1].done()
    taken[3].done()
    assert port.poll() == [block, late[1]]
    assert (channel.used_units_late_sync_r, channel.used_units_std_sync_r) == (2, 0)
    port.put(m(5, MVS_SLP))
    assert channel.techno_unit_late_sync[1].number_r == 5, "the unit that has become free"
    assert (port.pending, port.pending_in_block) == (3, 0)


class Handshake(RuleBasedStateMachine):
    """Any order of CNC and PLC steps, with log-off, log-on and reset in between."""

    def __init__(self) -> None:
        super().__init__()
        self.channel = Channel()
        self.port = TechnologyPort(self.channel)
        self.taker = TechnologyTaker(self.channel)
        self.number = 0
        self.alive: list[Sent] = []  # put and neither finished nor dropped, in order
        self.taken: list[Taken] = []
        self.acknowledged: set[int] = set()
        self.seen: list[int] = []  # numbers as the PLC saw them
        self.finished: set[int] = set()

    @rule(synch=st.sampled_from([MOS, MVS_SVS, MVS_SNS, MNS_SNS, MVS_SLM, MVS_SLP]))
    def put(self, synch: int) -> None:
        sent = self.port.put(m(self.number, synch))
        if sent is not None:
            self.number += 1
            self.alive.append(sent)

    @rule()
    def poll(self) -> None:
        for sent in self.port.poll():
            number = sent.function.number
            assert sent in self.alive, "finished once, and not after a reset"
            if self.channel.plc_present_w and sent.index >= 0:
                assert number in self.seen, "finished though the PLC never saw it"
                if sent.function.acknowledged:
                    assert number in self.acknowledged, "acknowledged for another"
            self.alive.remove(sent)
            self.finished.add(number)

    @rule()
    def take(self) -> None:
        for taken in self.taker.take():
            assert taken.function.number not in self.seen, "taken twice"
            assert not self.seen or taken.function.number > self.seen[-1], "overtaken"
            self.seen.append(taken.function.number)
            self.taken.append(taken)

    @precondition(lambda self: self.taken)
    @rule(data=st.data())
    def done(self, data: st.DataObject) -> None:
        taken = data.draw(st.sampled_from(self.taken))
        self.taken.remove(taken)
        if not taken.is_done:
            self.acknowledged.add(taken.function.number)
        taken.done()

    @rule()
    def reset(self) -> None:
        dropped = self.port.drop_all()
        assert all(sent in self.alive for sent in dropped)
        self.alive = []

    @precondition(lambda self: not self.channel.plc_present_w)
    @rule()
    def log_on(self) -> None:
        self.taker.restart()
        self.taken = []
        self.channel.plc_present_w = True

    @precondition(lambda self: self.channel.plc_present_w)
    @rule()
    def log_off(self) -> None:
        self.channel.plc_present_w = False
        self.poll()  # a PLC process takes longer to come back than a cycle

    @invariant()
    def pending_is_what_lives(self) -> None:
        assert self.port.pending == len([sent for sent in self.alive if not sent.done])

    def teardown(self) -> None:
        """Nothing is stuck: with both sides working, everything that lives ends and a new function goes out."""
        if not self.channel.plc_present_w:
            self.log_on()
        for _ in range(3):
            self.poll()
            self.take()
            for taken in list(self.taken):
                if not taken.is_done:
                    self.acknowledged.add(taken.function.number)
                taken.done()
        self.poll()
        assert self.alive == []
        assert self.port.put(m(self.number)) is not None


_covers = pytest.mark.spec("hli.tech.unit", "hli.tech.block-sync", "hli.tech.late-sync", "hli.mech.plc-present")
TestHandshake = _covers(Handshake.TestCase)
TestHandshake.settings = settings(max_examples=150, stateful_step_count=40, deadline=None)
