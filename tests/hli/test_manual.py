"""Keys, handwheels, activations: no job is lost or taken twice, and no key stays pressed when who pressed it has gone."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from runtime.hli.layout import KEYS, Channel, KeyPress, OperatorUnit
from runtime.hli.manual import ManualCommands


class KeyJobs(RuleBasedStateMachine):
    """PLC, operator and CNC in any order; the number of a press is its hold time, so that each is another one."""

    def __init__(self) -> None:
        super().__init__()
        self.channel = Channel()
        self.operator = OperatorUnit()
        self.commands = ManualCommands(self.channel, self.operator)
        self.keys = self.commands._keys
        self.numbers = itertools.count(1)
        self.present = False
        self.given: dict[str, list[int]] = {"operator": [], "plc": []}
        self.copied: list[int] = []
        self.refused: set[int] = set()
        self.taken: list[int] = []

    def units(self) -> list[int]:
        return [i for i in range(KEYS) if self.channel.control.manual.key[i].enable_w]

    @precondition(lambda self: not self.operator.key.semaphor_rw)
    @rule()
    def operator_presses(self) -> None:
        number = next(self.numbers)
        self.operator.key.data_w = KeyPress(1, 1, number)
        self.operator.key.semaphor_rw = True
        self.given["operator"].append(number)

    @rule(unit=st.integers(0, KEYS - 1))
    def plc_presses(self, unit: int) -> None:
        area = self.channel.control.manual.key[unit]
        if not (self.present and area.enable_w) or area.command_semaphor_rw:
            return
        number = next(self.numbers)
        area.command_w = KeyPress(1, 1, number)
        area.command_semaphor_rw = True
        self.given["plc"].append(number)

    @rule(unit=st.integers(0, KEYS - 1), claimed=st.booleans())
    def plc_claims_or_gives_back(self, unit: int, claimed: bool) -> None:
        area = self.channel.control.manual.key[unit]
        if not area.command_semaphor_rw:
            area.enable_w = claimed

    @rule(present=st.booleans())
    def plc_comes_or_goes(self, present: bool) -> None:
        if any(self.channel.control.manual.key[i].command_semaphor_rw for i in range(KEYS)):
            return  # a PLC that goes on purpose waits for its command
        if not present:
            for i in range(KEYS):
                area = self.channel.control.manual.key[i]
                if area.request_semaphor_rw:
                    self.refused.add(int(area.request_r.hold_time))
        self.present = present
        self.cycle()  # the CNC has seen it

    @rule(unit=st.integers(0, KEYS - 1), allow=st.booleans())
    def plc_answers_a_request(self, unit: int, allow: bool) -> None:
        area = self.channel.control.manual.key[unit]
        if not (self.present and area.request_semaphor_rw) or (allow and area.command_semaphor_rw):
            return
        number = int(area.request_r.hold_time)
        if allow and area.enable_w:
            area.command_w = area.request_r
            area.command_semaphor_rw = True
        elif area.enable_w:
            self.refused.add(number)
        else:
            return
        area.request_semaphor_rw = False

    @rule()
    def cycle(self) -> None:
        self.taken += [int(job.hold_time) for job in self.keys.take(self.present)]

    @invariant()
    def nothing_is_taken_twice(self) -> None:
        assert len(self.taken) == len(set(self.taken))
        assert not self.refused & set(self.taken)

    def teardown(self) -> None:
        """Whatever the state: when everybody answers, nothing is stuck and nothing is lost."""
        for _ in range(4):
            for i in range(KEYS):
                self.plc_answers_a_request(i, True)
            self.cycle()
        given = {number for numbers in self.given.values() for number in numbers}
        assert set(self.taken) | self.refused == given
        assert not self.operator.key.semaphor_rw


TestKeyJobs = pytest.mark.spec("hli.mech.control-unit-usage-check", "hli.hb.cu.key")(KeyJobs.TestCase)
KeyJobs.TestCase.settings = settings(max_examples=60, stateful_step_count=40, deadline=None)


def press(operator: OperatorUnit, key: int, direction: int, hold_time: int = 0) -> None:
    operator.key.data_w = KeyPress(key, direction, hold_time)
    operator.key.semaphor_rw = True


@pytest.fixture
def commands() -> tuple[ManualCommands, Channel, OperatorUnit]:
    channel, operator = Channel(), OperatorUnit()
    return ManualCommands(channel, operator), channel, operator


Fixture = tuple[ManualCommands, Channel, OperatorUnit]


@pytest.mark.spec("hli.hb.cu.key")
def test_a_key_stays_pressed_until_it_is_released(commands: Fixture) -> None:
    manual, _, operator = commands
    press(operator, 3, -1)
    manual.sample(False, 0.0)
    assert manual.pressed[3] == -1
    manual.sample(False, 100.0)
    assert manual.pressed[3] == -1
    press(operator, 3, 0)
    manual.sample(False, 100.1)
    assert manual.pressed[3] == 0


def test_a_key_with_a_hold_time_is_released_by_itself_unless_it_is_renewed(commands: Fixture) -> None:
    manual, _, operator = commands
    press(operator, 1, 1, 100_000)
    manual.sample(False, 0.0)
    manual.sample(False, 0.09)
    assert manual.pressed[1] == 1
    press(operator, 1, 1, 100_000)
    manual.sample(False, 0.091)
    manual.sample(False, 0.18)
    assert manual.pressed[1] == 1
    manual.sample(False, 0.2)
    assert manual.pressed[1] == 0


def test_a_plc_that_goes_releases_every_key(commands: Fixture) -> None:
    manual, channel, _ = commands
    unit = channel.control.manual.key[0]
    unit.enable_w, unit.command_w, unit.command_semaphor_rw = True, KeyPress(2, 1, 0), True
    manual.sample(True, 0.0)
    assert manual.pressed[2] == 1
    manual.sample(False, 0.001)
    assert manual.pressed[2] == 0


def test_keys_that_do_not_exist_are_passed_over(commands: Fixture) -> None:
    manual, _, operator = commands
    press(operator, 99, 1)
    manual.sample(False, 0.0)
    assert not any(manual.pressed)
    assert not operator.key.semaphor_rw


@pytest.mark.parametrize(("before", "after", "pulses"), [(0, 5, 5), (5, 2, -3), (2**31 - 2, -(2**31) + 1, 3)])
def test_pulses_of_a_handwheel_go_through_the_overflow(before: int, after: int, pulses: int) -> None:
    channel, operator = Channel(), OperatorUnit()
    channel.control.manual.handwheel_w[1] = before
    manual = ManualCommands(channel, operator)
    manual.sample(True, 0.0)
    channel.control.manual.handwheel_w[1] = after
    manual.sample(True, 0.001)
    assert manual.pulses[2] == pulses
    manual.sample(True, 0.002)
    assert manual.pulses[2] == 0
