"""What the PLC orders of a spindle, on the whole machine: orders of its own, stop at the end of a program, reset, error."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.diagnostics.catalogue import axis_jobs
from runtime.hli.layout import SpindleCommandKind as Kind
from runtime.hli.layout import SpindleWay
from runtime.hli.spindle_commands import SpindleCall, SpindleCaller
from runtime.plc_logic.areas import SpindlePort
from tests.machine.beside_channel import Rig

REV = 6.0  # degrees/s per rev/min


class Spindle(Rig):
    """The spindle of the demo machine, and what its PLC program orders."""

    def __init__(self, folder: Path, *, ideal: bool = True) -> None:
        super().__init__(folder, ideal=ideal)
        self.spindle = self.simulation.controller.channel.spindles[0]
        self.status = self.hli.axes[self.spindle.index].spindle

    @property
    def port(self) -> SpindlePort:
        return self.program.spindles["S"]

    def order(self, kind: Kind, **values: object) -> int:
        """Give an order and wait until it is taken; why it was refused."""
        assert self.port.order(kind, **values)  # type: ignore[arg-type]
        self.until(lambda: self.port.order_taken, 0.1)
        self.run(0.002)
        return self.port.order_error

    def rest(self) -> None:
        """Until it is at speed, which has a window of 10 rev/min, and some time more for the drive to settle."""
        self.until(lambda: self.spindle.reached(float(self.image.actual_velocity[self.spindle.index])), 10.0)
        self.run(0.3)

    @property
    def speed(self) -> float:
        """rev/min, signed."""
        return float(self.image.actual_velocity[self.spindle.index]) / REV

    @property
    def active(self) -> bool:
        return self.simulation.controller.channel.active


@pytest.fixture
def rig(tmp_path: Path) -> Spindle:
    return Spindle(tmp_path)


@pytest.mark.spec("hli.sp.cu.external-command")
@pytest.mark.parametrize("ideal", [True, False])
def test_what_a_program_orders_the_plc_orders_too(tmp_path: Path, ideal: bool) -> None:
    rig = Spindle(tmp_path, ideal=ideal)
    assert rig.order(Kind.M3, speed=600.0) == 0
    rig.rest()
    assert rig.speed == pytest.approx(600.0, rel=0.02)
    assert rig.status.mode_r == 2
    rig.order(Kind.SPEED, speed=300.0)
    rig.rest()
    assert rig.speed == pytest.approx(300.0, rel=0.02)
    rig.order(Kind.M4)
    rig.rest()
    assert rig.speed == pytest.approx(-300.0, rel=0.02), "the speed that was programmed stays"
    rig.order(Kind.SPEED_FACTOR, value=0.5)
    rig.run(1.0)
    assert rig.speed == pytest.approx(-150.0, rel=0.05)
    rig.order(Kind.SPEED_FACTOR, value=1.0)
    rig.order(Kind.M5)
    rig.rest()
    assert rig.speed == pytest.approx(0.0, abs=1.0)


@pytest.mark.spec("hli.sp.cu.external-command")
def test_a_position_by_its_angle_or_by_the_way_to_it(rig: Spindle) -> None:
    assert rig.order(Kind.M19, speed=100.0, angle=90.0) == 0
    rig.rest()
    assert rig.spindle.angle % 360.0 == pytest.approx(90.0, abs=0.2)
    before = rig.spindle.angle
    rig.order(Kind.M19, angle=-350.0, way=SpindleWay(0))
    rig.rest()
    assert rig.spindle.angle - before == pytest.approx(-350.0, abs=0.3), "the whole way, in its sense"
    before = rig.spindle.angle
    rig.order(Kind.M19, angle=-350.0, way=SpindleWay.SHORTEST)
    rig.rest()
    assert rig.spindle.angle - before == pytest.approx(10.0, abs=0.3), "to the same place the shorter way"


@pytest.mark.spec("hli.sp.cu.external-command")
def test_the_override_is_switched_off_until_the_next_order(rig: Spindle) -> None:
    rig.call("override", lambda p: setattr(p.spindles["S"], "override", 50.0))
    rig.order(Kind.M3, speed=400.0)
    rig.run(1.5)
    assert rig.speed == pytest.approx(200.0, rel=0.05)
    rig.order(Kind.OVERRIDE_OFF)
    rig.run(1.5)
    assert rig.speed == pytest.approx(400.0, rel=0.05)
    rig.order(Kind.SPEED, speed=300.0)
    rig.run(1.5)
    assert rig.speed == pytest.approx(150.0, rel=0.05)


@pytest.mark.spec("hli.sp.cu.external-command")
def test_orders_of_channel_and_plc_are_done_as_they_arrive(rig: Spindle) -> None:
    rig.start("%T\nN10 S500 M3\nN20 G04 1\nN30 S200 M4\nN40 G04 1\nM30\n")
    rig.until(lambda: rig.speed > 450.0)
    rig.order(Kind.SPEED, speed=100.0)
    rig.until(lambda: rig.speed < 110.0)
    assert rig.active
    rig.until(lambda: rig.speed < -190.0)
    rig.until(lambda: not rig.active)
    assert not rig.simulation.problems


@pytest.mark.spec("hli.sp.cu.external-command")
@pytest.mark.parametrize(
    ("call", "says"),
    [
        (SpindleCall(7), "no such order"),
        (SpindleCall(Kind.M19, angle=10.0), "no speed"),
        (SpindleCall(Kind.M19, 60.0, 360.0, SpindleWay(0)), "less than a turn"),
        (SpindleCall(Kind.M3, -6.0), "negative"),
        (SpindleCall(Kind.GEAR, value=9.0), "gear stage 9"),
        (SpindleCall(Kind.ACCELERATION, value=0.0), "outside of"),
        (SpindleCall(Kind.SPEED_FACTOR, value=float("nan")), "outside of"),
    ],
)
def test_what_is_refused_moves_nothing(rig: Spindle, call: SpindleCall, says: str) -> None:
    caller = SpindleCaller(rig.hli.axes[rig.spindle.index])
    assert caller.give(call)
    assert not caller.give(call), "one after the other"
    rig.run(0.01)
    assert caller.taken
    assert caller.error == axis_jobs.SPINDLE_ORDER.id
    assert says in rig.simulation.problems[-1].text
    rig.run(0.1)
    assert rig.speed == 0.0


@pytest.mark.spec("hli.sp.cu.external-command")
def test_a_spindle_whose_drive_is_off_takes_no_order_to_turn(rig: Spindle) -> None:
    rig.call("off", lambda p: setattr(p.spindles["S"], "drive_on", False))
    rig.run(0.3)
    assert rig.order(Kind.M3, speed=100.0) == axis_jobs.SPINDLE_ORDER.id
    rig.call("off", lambda p: setattr(p.spindles["S"], "drive_on", True))
    rig.run(1.0)
    assert rig.speed == 0.0, "what was refused does not come later"
    assert rig.order(Kind.M3, speed=100.0) == 0
    rig.rest()
    assert rig.speed == pytest.approx(100.0, rel=0.05)


@pytest.mark.spec("hli.sp.cu.commands")
@pytest.mark.parametrize("stops", [True, False])
def test_the_end_of_a_program_stops_the_spindle_if_it_shall(rig: Spindle, stops: bool) -> None:
    rig.call("stops", lambda p: setattr(p.spindles["S"], "stops_at_program_end", stops))
    rig.start("%T\nN10 S500 M3\nN20 G04 1\nM30\n")
    rig.until(lambda: rig.speed > 450.0)
    rig.until(lambda: not rig.active)
    rig.run(1.5)
    assert rig.speed == pytest.approx(0.0 if stops else 500.0, abs=10.0)


@pytest.mark.spec("hli.sp.cu.commands")
def test_a_reset_of_the_spindle_stops_it_and_the_channel_goes_on(rig: Spindle) -> None:
    rig.start("%T\nN10 S500 M3\nN20 G01 X100 F1200\nM30\n")
    rig.until(lambda: rig.speed > 450.0 and rig.place("X") > 5.0)
    rig.port.reset_spindle()
    rig.until(lambda: rig.port.resets, 0.1)
    rig.until(lambda: not rig.port.resets, 5.0)
    assert abs(rig.speed) < 15.0, "the state is TRUE until it stands"
    assert rig.active
    rig.until(lambda: not rig.active)
    assert rig.place("X") == pytest.approx(100.0)
    assert rig.order(Kind.M3, speed=100.0) == 0
    rig.rest()
    assert rig.speed == pytest.approx(100.0, rel=0.05)


@pytest.mark.spec("hli.sp.cu.commands")
def test_an_error_that_the_plc_reports_stops_the_spindle_and_the_path(rig: Spindle) -> None:
    failed = {"on": False}
    rig.call("failed", lambda p: setattr(p.spindles["S"], "failed", failed["on"]))
    rig.start("%T\nN10 S500 M3\nN20 G01 X100 F600\nM30\n")
    rig.until(lambda: rig.speed > 450.0 and rig.place("X") > 5.0)
    failed["on"] = True
    rig.until(lambda: not rig.active or rig.simulation.controller.channel.error is not None)
    rig.run(2.0)
    assert abs(rig.speed) < 1.0
    assert rig.place("X") < 50.0
    assert axis_jobs.SPINDLE_ERROR in [problem.entry for problem in rig.simulation.problems]
    assert rig.order(Kind.M3, speed=100.0) == axis_jobs.SPINDLE_ORDER.id
    failed["on"] = False
    rig.simulation.controller.reset()
    rig.run(1.0)
    assert rig.order(Kind.M3, speed=100.0) == 0
    rig.rest()
    assert rig.speed == pytest.approx(100.0, rel=0.05)
