"""The demo's PLC program on its whole machine, written with the fixtures that machine builders use."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from runtime.demo.plc import CLAMP_TIME
from runtime.hli.layout import State, StopCondition
from runtime.testbench import MachineBench, ProgramResult

Run = Callable[..., ProgramResult]
Wait = Callable[..., float]
Press = Callable[..., None]
Inject = Callable[..., Callable[[], None]]


def test_the_path_waits_for_the_clamp(machine: MachineBench, run_program: Run) -> None:
    result = run_program("N10 G01 X20 F6000\nN20 M20\nN30 G01 X40\nN40 M21\nN50 M30")
    assert result.good
    assert result.functions == ("M20", "M21")
    assert result.positions["X"] == pytest.approx(40.0)
    assert result.time > 0.6, "the clamp takes 0.3 s to close and to open"
    assert machine.input("clamp_open")


def test_a_clamp_that_does_not_close_is_told_and_the_path_stands(
    machine: MachineBench, wait_until: Wait, inject_fault: Inject
) -> None:
    heal = inject_fault("clamp_closed", False)
    machine.start_program("N10 M20\nN20 G01 X40 F6000\nN30 M30")
    wait_until(lambda: machine.alarms, CLAMP_TIME + 0.5)
    assert "clamp does not close" in machine.alarms[0]
    assert machine.output("lamp_red")
    assert machine.waits_for & StopCondition.WAIT_TECHNOLOGY
    assert machine.position("X") == 0.0
    heal()
    wait_until(lambda: machine.state is State.SELECTED)
    assert machine.position("X") == pytest.approx(40.0)
    assert machine.alarms == ()


def test_an_open_door_holds_the_path_and_closing_it_goes_on(
    machine: MachineBench, wait_until: Wait, inject_fault: Inject
) -> None:
    machine.start_program("N10 G01 X100 F6000\nN20 M30")
    wait_until(lambda: machine.position("X") > 20.0)
    close = inject_fault("door_closed", False)
    wait_until(lambda: not machine.moving, 1.0)
    here = machine.position("X")
    machine.run(0.5)
    assert machine.position("X") == here
    assert "door is open" in machine.alarms
    close()
    wait_until(lambda: machine.state is State.SELECTED)
    assert machine.position("X") == pytest.approx(100.0)


def test_the_operator_holds_resets_and_starts_again(
    machine: MachineBench, wait_until: Wait, press: Press, run_program: Run
) -> None:
    machine.start_program("N10 G01 X100 F6000\nN20 M30")
    wait_until(lambda: machine.position("X") > 20.0)
    press("hold")
    wait_until(lambda: not machine.moving, 1.0)
    assert machine.state.name == "HOLD"
    press("resume")
    wait_until(lambda: machine.moving, 1.0)
    press("reset")
    wait_until(lambda: machine.state is State.SELECTED, 2.0)
    assert machine.position("X") < 100.0
    assert run_program("N10 G01 X100 F6000\nN20 M30").positions["X"] == pytest.approx(100.0)


def test_a_tool_change_turns_the_magazine(machine: MachineBench, run_program: Run) -> None:
    assert run_program("N10 T3\nN20 M6\nN30 M30").good
    assert vars(machine.program)["tool"] == 3
    assert not machine.output("tool_unlock")


def test_a_plc_that_hangs_stops_the_path_and_comes_back_with_a_reset(
    machine: MachineBench, wait_until: Wait, press: Press, inject_fault: Inject, run_program: Run
) -> None:
    machine.start_program("N10 G01 X100 F6000\nN20 M30")
    wait_until(lambda: machine.position("X") > 20.0)
    heal = inject_fault("plc", "hang")
    wait_until(lambda: machine.state is State.ERROR and not machine.moving, 2.0)
    assert "no sign of life" in machine.alarms[0]
    heal()
    press("reset")
    wait_until(machine.simulation.ready)
    assert run_program("N10 G01 X100 F6000\nN20 M30").positions["X"] == pytest.approx(100.0)


@pytest.mark.tandem(simulated_drives=True)
def test_a_drive_that_fails_stops_the_program(machine: MachineBench, wait_until: Wait, inject_fault: Inject) -> None:
    machine.start_program("N10 G01 X100 F6000\nN20 M30")
    wait_until(lambda: machine.position("X") > 20.0)
    inject_fault("X", "drive")
    wait_until(lambda: machine.state is State.ERROR, 1.0)
    assert any("axis X" in text for text in machine.alarms)
