"""The demo mill's PLC program against a small model of the machine: no CNC, no bus."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest

from runtime.config.loader import load_machine
from runtime.demo.plc import CLAMP_TIME, COOLANT_TIME, SPINDLE_TIME, TOOL_TIME, DemoMill
from runtime.hli.layout import State
from runtime.plc_logic.bench import Bench

IO = load_machine().fieldbus.io[0]


@dataclass
class Plant:
    """Valves and pumps with their times; `stuck` names inputs that do not answer."""

    stuck: set[str] = field(default_factory=set)
    since: dict[str, float] = field(default_factory=dict)
    state: dict[str, bool] = field(default_factory=dict)
    steps: int = 0  # of the magazine
    stepping: bool = False

    def __call__(self, bench: Bench[DemoMill]) -> None:
        clamped, unclamped = self.delayed(bench, "clamp_valve", 0.3)
        pressure, _ = self.delayed(bench, "coolant_pump", 0.2)
        unlocked, locked = self.delayed(bench, "tool_unlock", 0.25)
        inputs = {
            "clamp_closed": clamped,
            "clamp_open": unclamped,
            "coolant_pressure": pressure,
            "tool_unlocked": unlocked,
            "tool_in_spindle": locked,
        }
        bench.set(**{name: value for name, value in inputs.items() if name not in self.stuck})
        step = bench.output("magazine_step")
        if step and not self.stepping:
            assert bench.output("tool_unlock"), "the magazine turns with the tool locked"
            self.steps += 1
        self.stepping = step

    def delayed(self, bench: Bench[DemoMill], output: str, seconds: float) -> tuple[bool, bool]:
        """Whether the output has been TRUE, and whether it has been FALSE, for this time."""
        now = bench.output(output)
        if self.state.get(output) != now:
            self.state[output] = now
            self.since[output] = bench.time if output in self.since else -10.0
        settled = bench.time - self.since[output] >= seconds - 1e-9
        return now and settled, not now and settled


@pytest.fixture
def plant() -> Plant:
    return Plant()


@pytest.fixture
def mill(plant: Plant) -> Bench[DemoMill]:
    bench = Bench(DemoMill, inputs=IO.inputs, outputs=IO.outputs, plant=plant)
    bench.set(door_closed=True, e_stop_ok=True)
    bench.spindle("S", 0)
    bench.run(0.02)
    assert bench.alarms == []
    return bench


def test_clamp_closes_and_opens(mill: Bench[DemoMill]) -> None:
    close = mill.m(20)
    assert mill.run_until(lambda: close.done) == pytest.approx(0.3, abs=0.02)
    release = mill.m(21)
    assert mill.run_until(lambda: release.done) == pytest.approx(0.3, abs=0.02)
    assert not mill.output("clamp_valve")


@pytest.mark.parametrize(
    ("function", "stuck", "seconds", "says"),
    [
        (20, "clamp_closed", CLAMP_TIME, "clamp does not close"),
        (8, "coolant_pressure", COOLANT_TIME, "no coolant pressure"),
        (6, "tool_unlocked", TOOL_TIME, "tool does not unlock"),
        (6, "tool_in_spindle", TOOL_TIME, "tool is not clamped"),
    ],
)
def test_what_does_not_answer_raises_an_alarm_and_is_not_acknowledged(
    mill: Bench[DemoMill], plant: Plant, function: int, stuck: str, seconds: float, says: str
) -> None:
    mill.set(**{stuck: False})
    plant.stuck.add(stuck)
    sent = mill.m(function)
    mill.run(seconds - 0.1)
    assert mill.alarms == []
    mill.run(1.0)
    assert len(mill.alarms) == 1
    assert says in mill.alarms[0]
    assert mill.output("lamp_red")
    assert not sent.done
    plant.stuck.clear()
    mill.run_until(lambda: sent.done)
    mill.run(0.01)
    assert mill.alarms == []
    assert not mill.output("lamp_red")


def test_an_opening_clamp_that_hangs(mill: Bench[DemoMill], plant: Plant) -> None:
    done = mill.m(20)
    mill.run_until(lambda: done.done)
    plant.stuck.add("clamp_open")
    mill.m(21)
    mill.run(CLAMP_TIME + 0.1)
    assert "clamp does not open" in mill.alarms[0]


def test_coolant(mill: Bench[DemoMill]) -> None:
    on = mill.m(8)
    assert mill.run_until(lambda: on.done) == pytest.approx(0.2, abs=0.02)
    off = mill.m(9, wait=False)
    mill.run(0.02)
    assert off.done
    assert not mill.output("coolant_pump")


@pytest.mark.parametrize(("before", "tool", "steps"), [(0, 3, 3), (6, 2, 4), (4, 4, 0)])
def test_tool_change_turns_the_magazine_the_right_number_of_places(
    mill: Bench[DemoMill], plant: Plant, before: int, tool: int, steps: int
) -> None:
    mill.program.tool = before
    mill.t(tool)
    change = mill.m(6)
    seconds = mill.run_until(lambda: change.done)
    assert plant.steps == steps
    assert mill.program.tool == tool
    assert not mill.output("tool_unlock")
    assert seconds == pytest.approx(0.25 + 0.2 * steps + 0.25, abs=0.05)


def test_no_tool_change_while_the_spindle_turns(mill: Bench[DemoMill]) -> None:
    mill.spindle("S", 3000)
    change = mill.m(6)
    mill.run(SPINDLE_TIME + 0.1)
    assert mill.alarms == ["tool change: the spindle turns"]
    assert not mill.output("tool_unlock")
    mill.spindle("S", 0)
    mill.run_until(lambda: change.done)


def test_spindle_is_acknowledged_at_speed(mill: Bench[DemoMill]) -> None:
    mill.spindle("S", 100, at_speed=False)
    on = mill.s(3, 6000)
    mill.run(1.0)
    assert not on.done
    mill.spindle("S", 6000)
    mill.run_until(lambda: on.done, 0.1)
    mill.spindle("S", 100, at_speed=False)
    slow = mill.s(4, 12_000)
    mill.run(SPINDLE_TIME + 0.1)
    assert mill.alarms == ["spindle does not reach 12000 rev/min"]
    assert not slow.done


def test_other_spindle_functions_are_only_noted(mill: Bench[DemoMill]) -> None:
    told = [mill.s(0, 3000, wait=False), mill.s(5)]
    mill.run(0.02)
    assert all(function.done for function in told)


def test_holes_are_counted_once_each(mill: Bench[DemoMill]) -> None:
    for _ in range(3):
        mill.h(12, wait=False)
        mill.run(0.05)
    assert mill.program.holes == 3


@pytest.mark.parametrize(("name", "says"), [("door_closed", "door is open"), ("e_stop_ok", "emergency stop")])
def test_open_door_and_emergency_stop_hold_the_feed(mill: Bench[DemoMill], name: str, says: str) -> None:
    mill.set(**{name: False})
    mill.run(0.008)
    assert mill.commands.feed_hold, "at once"
    assert mill.alarms == [], "contacts bounce: the alarm waits"
    mill.run(0.2)
    assert mill.alarms == [says]
    mill.set(**{name: True})
    mill.run(0.02)
    assert not mill.commands.feed_hold
    assert mill.alarms == []


def test_the_operators_feed_hold_still_works(mill: Bench[DemoMill]) -> None:
    mill.hli.operator[0].feedhold_w = True
    mill.run(0.02)
    assert mill.commands.feed_hold
    mill.hli.operator[0].feedhold_w = False
    mill.run(0.02)
    assert not mill.commands.feed_hold


def test_lamps(mill: Bench[DemoMill]) -> None:
    assert not mill.output("lamp_green")
    mill.channel.control.mode_and_state.state_r = State.ACTIVE
    mill.run(0.01)
    assert mill.output("lamp_green")
    assert not mill.output("lamp_red")
    mill.channel.status.error_id_r = 301001
    mill.run(0.01)
    assert mill.output("lamp_red")


def test_a_reset_in_the_middle_of_a_tool_change_leaves_the_tool_locked(mill: Bench[DemoMill]) -> None:
    mill.t(5)
    mill.m(6)
    mill.m(8)
    mill.run(0.4)
    assert mill.output("tool_unlock")
    assert mill.output("coolant_pump")
    mill.reset()
    mill.run(0.02)
    assert not any(mill.output(name) for name in ("tool_unlock", "magazine_step", "coolant_pump"))
    assert mill.program.tool == 0
    again = mill.m(6)
    mill.run_until(lambda: again.done)
    assert mill.program.tool == 5
