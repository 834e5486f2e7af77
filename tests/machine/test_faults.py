"""Faults in motion, with real CANopen nodes on the virtual bus: alarm, stop within limits, reset, and on with no jump."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import fieldbus, machine, plc
from runtime.diagnostics.errors import ErrorEntry
from runtime.drives import DriveState
from runtime.fieldbus.simulator.drive import Fault
from runtime.hli.layout import Mode, State
from runtime.plc_logic import Program
from runtime.scheduler.plc_inline import InlinePlc
from tests.machine.driven import LONG_LINE, SECOND, Driven

X, Y, Z, S = range(4)
Act = Callable[[Driven], None]
AFTER = 1500  # cycles that are watched after a fault: longer than the heartbeat time-out of 1 s


def inject(node: int, fault: Fault) -> Act:
    return lambda driven: driven.simulation.nodes.inject(node, fault)


def heal(node: int) -> Act:
    return lambda driven: driven.simulation.nodes.heal(node)


def nothing(driven: Driven) -> None:
    """The cause goes by itself."""


def freeze(driven: Driven) -> None:
    inline(driven).frozen = True


def thaw(driven: Driven) -> None:
    inline(driven).frozen = False


def inline(driven: Driven) -> InlinePlc:
    plc = driven.simulation.plc
    assert isinstance(plc, InlinePlc)
    return plc


def raise_in_plc(driven: Driven) -> None:
    def broken() -> None:
        raise ValueError("valve 7")

    driven.simulation.plc.host.program.cycle = broken  # type: ignore[union-attr]


@dataclass(frozen=True)
class Case:
    """A fault: what is done, what is told (with axis and text), within how many cycles the path is stopped."""

    act: Act
    entry: ErrorEntry
    axis: int  # logical number, 0 none
    text: str
    within: int  # cycles from the fault to the alarm
    lost: tuple[int, ...] = ()  # axes that do not follow any more
    heal: Act = nothing


# heartbeat time-out of the demo: 1 s, of a producer time of 0.1 s; following error 5 mm at 134 mm/s; PLC watchdog 50 ms
HEARTBEAT, LAG, WATCHDOG, PROCESS_DATA = 1102, 60, 56, 4
CASES = {
    "drive fault": Case(
        inject(1, Fault.DRIVE), fieldbus.DRIVE_FAULT, 1, "axis X (node 1) is in fault", PROCESS_DATA, (X,)
    ),
    "spindle fault": Case(
        inject(6, Fault.DRIVE), fieldbus.DRIVE_FAULT, 6, "axis S (node 6) is in fault", PROCESS_DATA, (S,)
    ),
    "spindle silent": Case(
        inject(6, Fault.SILENT), fieldbus.HEARTBEAT_LOST, 6, "heartbeat of node 6 (axis S)", HEARTBEAT, (S,),
        heal(6),
    ),
    "axis silent": Case(  # a moving axis is missed by its following error long before its heartbeat
        inject(2, Fault.SILENT), machine.FOLLOWING_ERROR, 2, "following error of axis Y", 2 * LAG, (Y,),
        heal(2),
    ),
    "reboot": Case(inject(1, Fault.REBOOT), fieldbus.NODE_RESTARTED, 1, "node 1 (axis X) restarted", 3, (X,)),
    "blocked axis": Case(
        inject(1, Fault.FOLLOWING_ERROR), machine.FOLLOWING_ERROR, 1, "following error of axis X", LAG, (X,), heal(1)
    ),
    "encoder freeze": Case(
        inject(1, Fault.ENCODER_FREEZE), machine.FOLLOWING_ERROR, 1, "following error of axis X", LAG, (X,), heal(1)
    ),
    "I/O node lost": Case(
        inject(10, Fault.SILENT), fieldbus.HEARTBEAT_LOST, 0, "heartbeat of node 10 (I/O node 0)", HEARTBEAT,
        heal=heal(10),
    ),
    "PLC frozen": Case(freeze, plc.PLC_WATCHDOG, 0, "no sign of life for 51 ms", WATCHDOG, heal=thaw),
    "PLC raises": Case(raise_in_plc, plc.PLC_RAISED, 0, "valve 7", 5),
    "PLC logs off": Case(lambda d: inline(d).host.stop(), plc.PLC_LOGGED_OFF, 0, "PLC has ended", 2),
}  # fmt: skip


@pytest.fixture(params=list(CASES))
def case(request: pytest.FixtureRequest) -> Case:
    return CASES[request.param]


def test_a_fault_in_motion_from_the_alarm_to_the_next_program(demo: Machine, tmp_path: Path, case: Case) -> None:
    driven = Driven(demo, tmp_path)
    driven.start(LONG_LINE)
    driven.until_x(60.0)
    driven.forget()
    case.act(driven)

    # the alarm, in history and as event, and the stop that begins with it
    assert driven.until(lambda: driven.channel.error is not None, 2.0) <= case.within
    driven.watch(AFTER - len(driven.targets))
    alarm = driven.alarm(case.entry)
    assert (alarm.axis, alarm.active) == (case.axis, True)
    assert case.text in alarm.text
    (event,) = [event for event in driven.errors if event.number == case.entry.id]
    assert case.text in event.text
    assert (demo.axes[event.axis].log_axis if event.axis >= 0 else 0) == case.axis
    assert not [event for event in driven.errors if event.number == machine.AXIS_TRACKING.id], "nobody else has dropped"

    # the other axes have braked within their limits, and all stand
    assert not driven.channel.active
    driven.assert_brakes_within_limits([axis for axis in (X, Y, Z) if axis not in case.lost])
    for axis in (X, Y, Z):
        if axis not in case.lost:
            assert driven.image.state[axis] == DriveState.OPERATION_ENABLED
        assert not driven.moving(axis)
    assert driven.image.target_velocity[S] == 0.0

    # refused while the error stands
    assert driven.state() is State.ERROR
    driven.start(SECOND)
    assert driven.operator.answer_r == plc.MODE_RESET_FIRST.id
    assert not driven.channel.active

    # reset: back where the cause is gone; a node that was lost has been taken into operation meanwhile
    case.heal(driven)
    driven.watch(500)
    driven.forget()
    driven.reset()
    driven.watch(1200)
    assert driven.errors == []
    assert driven.state() is State.SELECTED
    assert driven.simulation.ready()
    for axis in (X, Y, Z):
        assert driven.image.actual_position[axis] == pytest.approx(driven.place_of(axis), abs=2e-4), "not lost"
        assert driven.image.target_position[axis] == pytest.approx(driven.image.actual_position[axis], abs=0.01)
    driven.start(SECOND)
    driven.until_done()
    driven.watch(200)
    assert driven.errors == []
    driven.assert_no_jump()
    assert [driven.place_of(axis) for axis in (X, Y, Z)] == pytest.approx([30.0, 15.0, 5.0], abs=2e-4)
    driven.simulation.close()


def test_bus_gone_leaves_the_axes_to_their_drives(demo: Machine, tmp_path: Path) -> None:
    driven = Driven(demo, tmp_path)
    driven.start(LONG_LINE)
    driven.until_x(60.0)
    driven.forget()
    driven.simulation.drives.frames.bus.shutdown()  # type: ignore[attr-defined]
    assert driven.until(lambda: driven.channel.error is not None) <= 4
    driven.watch(2000)
    assert driven.alarm(fieldbus.BUS_GONE).active
    assert [event.number for event in driven.errors if event.number != plc.PLC_ALARM.id] == [fieldbus.BUS_GONE.id]
    assert not any(driven.moving(axis) for axis in (X, Y, Z, S)), "the master's heartbeat is missing"
    assert driven.state() is State.ERROR
    driven.forget()
    driven.reset()
    driven.watch(100)
    assert fieldbus.BUS_GONE.id in [event.number for event in driven.errors]
    assert driven.state() is State.ERROR
    driven.simulation.close()


def test_a_warning_of_a_node_is_told_and_stops_nothing(demo: Machine, tmp_path: Path) -> None:
    driven = Driven(demo, tmp_path)
    driven.start(LONG_LINE)
    driven.until_x(60.0)
    driven.forget()
    driven.drive(X).emergency(0x4210)
    driven.watch(10)
    alarm = driven.alarm(fieldbus.EMERGENCY)
    assert (alarm.axis, alarm.active) == (1, False)
    assert "0x4210" in alarm.text
    driven.until_done()
    assert driven.channel.error is None
    assert driven.place_of(X) == pytest.approx(400.0, abs=0.01)
    driven.simulation.close()


class SwitchingOff(Program):
    """Acknowledges everything; `off` withdraws the enable of X."""

    off = False

    def cycle(self) -> None:
        self.axes["X"].drive_on = not self.off


def test_a_drive_that_is_switched_off_under_a_program_ends_it(demo: Machine, tmp_path: Path) -> None:
    plc_machine = demo.model_copy(update={"plc": demo.plc.model_copy(update={"program": f"{__name__}:SwitchingOff"})})
    driven = Driven(plc_machine, tmp_path)
    driven.start("%NOSPINDLE\nN10 G90 G01 F9000 X400 Y200\nN30 M30\n")
    driven.until_x(60.0)
    driven.forget()
    program = inline(driven).host.program
    assert isinstance(program, SwitchingOff)
    program.off = True
    driven.watch(AFTER)
    assert driven.alarm(machine.AXIS_TRACKING).axis == 1
    assert driven.state() is State.ERROR
    driven.assert_brakes_within_limits([Y, Z])
    driven.start(SECOND)
    assert not driven.channel.active
    driven.forget()
    program.off = False
    driven.watch(200)
    driven.reset()
    driven.watch(50)
    driven.start(SECOND)
    driven.until_done()
    driven.assert_no_jump()
    driven.simulation.close()


def test_no_start_with_drives_off(demo: Machine, tmp_path: Path) -> None:
    plc_machine = demo.model_copy(update={"plc": demo.plc.model_copy(update={"program": f"{__name__}:SwitchingOff"})})
    driven = Driven(plc_machine, tmp_path)
    program = inline(driven).host.program
    assert isinstance(program, SwitchingOff)
    program.off = True
    driven.watch(100)
    driven.start(SECOND)
    assert driven.alarm(machine.AXES_NOT_READY).text.startswith("the program does not start: axis X")
    assert (driven.mode, driven.state()) == (Mode.AUTOMATIC, State.SELECTED)
    program.off = False
    driven.watch(100)
    driven.start(SECOND)
    driven.until_done()
    assert driven.place_of(X) == pytest.approx(30.0, abs=0.01)
    driven.simulation.close()


def test_a_reset_at_once_after_a_following_error_does_not_make_the_axis_jump(demo: Machine, tmp_path: Path) -> None:
    driven = Driven(demo, tmp_path)
    driven.start(LONG_LINE)
    driven.until_x(60.0)
    driven.simulation.nodes.inject(1, Fault.FOLLOWING_ERROR)
    driven.until(lambda: driven.channel.error is not None)
    before = driven.place_of(X)
    driven.reset()
    driven.until(lambda: driven.image.state[X] != DriveState.OPERATION_ENABLED, 0.2)
    driven.simulation.nodes.heal(1)
    places = []
    for _ in range(600):
        driven.watch(1)
        places.append(driven.place_of(X))
    assert np.abs(np.array(places) - before).max() < 0.1, "the 5 mm of lag are given up, not made good in a jump"
    driven.until(driven.simulation.ready, 2.0)
    driven.until(lambda: driven.state() is State.SELECTED, 2.0)
    driven.simulation.close()


@pytest.mark.spec("chan.axis-error-stop")
@pytest.mark.parametrize("fault", [Fault.FOLLOWING_ERROR, Fault.DRIVE])
@pytest.mark.parametrize("apart", [False, True])
def test_after_an_axis_error_the_others_stop_on_the_path_or_each_by_its_drive(
    demo: Machine, tmp_path: Path, fault: Fault, apart: bool
) -> None:
    """independent_axis_error_stop (P-CHAN-00218). LONG_LINE leads X twice as far as Y, from (0, 0)."""
    channel = demo.channels[0]
    parameters = channel.parameters.model_copy(update={"independent_axis_error_stop": apart})
    described = demo.model_copy(update={"channels": [channel.model_copy(update={"parameters": parameters})]})
    driven = Driven(described, tmp_path)
    driven.start(LONG_LINE)
    driven.until_x(60.0)
    driven.forget()
    driven.simulation.nodes.inject(1, fault)
    driven.until(lambda: driven.channel.error is not None, 2.0)
    at_alarm = len(driven.targets)
    driven.watch(AFTER)
    assert driven.state() is State.ERROR
    assert not any(driven.moving(axis) for axis in (X, Y, Z))
    braking = np.array(driven.states)[at_alarm:, Y]
    assert (DriveState.QUICK_STOP_ACTIVE in braking) is apart
    if not apart:
        driven.assert_brakes_within_limits([Y, Z])
    before = driven.place_of(Y)

    driven.simulation.nodes.heal(1)
    driven.watch(500)
    driven.reset()
    driven.watch(1200)
    assert driven.state() is State.SELECTED
    assert driven.place_of(Y) == pytest.approx(before, abs=1e-3), "the position is kept"
    driven.start(SECOND)
    driven.until_done()
    driven.watch(200)
    assert [driven.place_of(axis) for axis in (X, Y, Z)] == pytest.approx([30.0, 15.0, 5.0], abs=2e-4)
    driven.simulation.close()


@pytest.mark.spec("chan.axis-error-stop")
def test_an_error_of_a_spindle_never_takes_the_axes_off_the_path(demo: Machine, tmp_path: Path) -> None:
    """P-CHAN-00218 is about axes."""
    channel = demo.channels[0]
    parameters = channel.parameters.model_copy(update={"independent_axis_error_stop": True})
    described = demo.model_copy(update={"channels": [channel.model_copy(update={"parameters": parameters})]})
    driven = Driven(described, tmp_path)
    driven.start(LONG_LINE)
    driven.until_x(60.0)
    driven.forget()
    driven.simulation.nodes.inject(6, Fault.DRIVE)
    driven.until(lambda: driven.channel.error is not None, 2.0)
    driven.watch(AFTER)
    assert not any(driven.moving(axis) for axis in (X, Y, Z))
    driven.assert_brakes_within_limits([X, Y, Z])
    driven.simulation.close()
