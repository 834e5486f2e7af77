"""The simulated drive as a device: all transitions of CiA 402 by frames on the bus, its motion, its reactions."""

from __future__ import annotations

from collections.abc import Iterator

import can
import pytest

from runtime.drives import DriveState
from runtime.fieldbus.cia402 import drive_state
from runtime.fieldbus.simulator import Fault, SimulatedDrive
from runtime.fieldbus.simulator.device_states import AUTOMATIC, COMMANDED, FAULT_TRANSITION
from tests.fieldbus.rig import Rig

X = 1  # node id
SHUTDOWN, SWITCH_ON, ENABLE, DISABLE_VOLTAGE, QUICK_STOP, RESET = 0x06, 0x07, 0x0F, 0x00, 0x02, 0x80


class Line:
    """One configured drive, spoken to frame by frame."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        self.drive: SimulatedDrive = rig.simulated.drives[X]
        self.target = 0
        self.frames: list[can.Message] = []

    def order(self, controlword: int, cycles: int = 1) -> DriveState:
        """Send this control word for some cycles; the state that the drive then tells."""
        for _ in range(cycles):
            data = controlword.to_bytes(2, "little") + self.target.to_bytes(4, "little", signed=True)
            heartbeat = can.Message(arbitration_id=0x77F, data=[5], is_extended_id=False)
            for message in (
                can.Message(arbitration_id=0x200 + X, data=data, is_extended_id=False),
                can.Message(arbitration_id=0x80, is_extended_id=False),
                heartbeat,
            ):
                self.rig.bus.send(message)
            self.rig.time += 0.001
            self.rig.simulated.step(self.rig.time)
        request = bytes((0x40, 0x41, 0x60, 0, 0, 0, 0, 0))  # SDO upload of the status word
        self.rig.bus.send(can.Message(arbitration_id=0x600 + X, data=request, is_extended_id=False))
        self.rig.simulated.poll(self.rig.time)
        self.collect()
        answer = next(m.data for m in reversed(self.frames) if m.arbitration_id == 0x580 + X)
        return drive_state(int.from_bytes(answer[4:6], "little"))

    def collect(self) -> None:
        while (message := self.rig.bus.recv(0)) is not None:
            self.frames.append(message)

    def emergencies(self) -> list[int]:
        self.collect()
        return [int.from_bytes(m.data[:2], "little") for m in self.frames if m.arbitration_id == 0x80 + X]


@pytest.fixture
def line() -> Iterator[Line]:
    with Rig() as rig:
        rig.master.start()
        rig.master.image.enable[:] = False
        yield Line(rig)


# how to get to each state from power-on
WAYS = {
    DriveState.SWITCH_ON_DISABLED: (),
    DriveState.READY_TO_SWITCH_ON: (SHUTDOWN,),
    DriveState.SWITCHED_ON: (SHUTDOWN, SWITCH_ON),
    DriveState.OPERATION_ENABLED: (SHUTDOWN, SWITCH_ON, ENABLE),
}
E_, R_, O_, D_ = (
    DriveState.OPERATION_ENABLED,
    DriveState.READY_TO_SWITCH_ON,
    DriveState.SWITCHED_ON,
    DriveState.SWITCH_ON_DISABLED,
)


@pytest.mark.parametrize(
    ("start", "controlword", "number", "end"),
    [
        (D_, SHUTDOWN, 2, R_),
        (R_, SWITCH_ON, 3, O_),
        (R_, ENABLE, 4, E_),  # 3 and 4 at once
        (O_, ENABLE, 4, E_),
        (E_, SWITCH_ON, 5, O_),
        (O_, SHUTDOWN, 6, R_),
        (R_, DISABLE_VOLTAGE, 7, D_),
        (R_, QUICK_STOP, 7, D_),
        (E_, SHUTDOWN, 8, R_),
        (E_, DISABLE_VOLTAGE, 9, D_),
        (O_, DISABLE_VOLTAGE, 10, D_),
        (O_, QUICK_STOP, 10, D_),
    ],
)
def test_transitions_by_control_word(
    line: Line, start: DriveState, controlword: int, number: int, end: DriveState
) -> None:
    for word in WAYS[start]:
        line.order(word)
    assert line.drive.state is start
    assert line.order(controlword, cycles=3) is end
    assert line.drive.transitions[-1] == number


@pytest.mark.parametrize(
    ("start", "controlword"),
    [(D_, SWITCH_ON), (D_, ENABLE), (D_, QUICK_STOP), (D_, RESET), (R_, SHUTDOWN), (R_, RESET), (E_, RESET)],
)
def test_orders_that_change_nothing(line: Line, start: DriveState, controlword: int) -> None:
    for word in WAYS[start]:
        line.order(word)
    assert line.order(controlword, cycles=3) is start


def test_self_test_is_done_after_power_on(line: Line) -> None:
    assert line.drive.transitions[0] == 1


def test_quick_stop_brakes_then_disables(line: Line) -> None:
    """Transitions 11 and 12, and the order "disable voltage" in between."""
    move_at_speed(line)
    assert line.order(QUICK_STOP) is DriveState.QUICK_STOP_ACTIVE
    assert line.drive.moving
    assert line.order(QUICK_STOP, cycles=200) is DriveState.SWITCH_ON_DISABLED
    assert line.drive.transitions[-2:] == [11, 12]
    assert not line.drive.moving


def test_disable_voltage_ends_a_quick_stop(line: Line) -> None:
    move_at_speed(line)
    line.order(QUICK_STOP)
    assert line.order(DISABLE_VOLTAGE) is DriveState.SWITCH_ON_DISABLED
    assert line.drive.moving  # it coasts


def test_a_quick_stop_that_stays_can_be_left_by_enabling(line: Line) -> None:
    """Transition 16, with quick stop option code 6."""
    line.drive.local.set_data(0x605A, 0, (6).to_bytes(2, "little"))
    move_at_speed(line)
    assert line.order(QUICK_STOP, cycles=300) is DriveState.QUICK_STOP_ACTIVE
    assert not line.drive.moving
    assert line.order(ENABLE) is DriveState.OPERATION_ENABLED
    assert line.drive.transitions[-1] == 16


def test_fault_brakes_and_is_reset_by_the_rising_edge(line: Line) -> None:
    """Transitions 13, 14, 15."""
    move_at_speed(line)
    line.rig.simulated.inject(X, Fault.DRIVE, 0x3210)
    assert line.order(ENABLE) is DriveState.FAULT_REACTION_ACTIVE
    assert line.order(ENABLE, cycles=200) is DriveState.FAULT
    assert not line.drive.moving
    assert line.emergencies() == [0x3210]
    assert line.order(RESET | ENABLE) is DriveState.SWITCH_ON_DISABLED
    assert line.drive.transitions[-3:] == [13, 14, 15]
    assert line.emergencies() == [0x3210, 0x0000]
    line.rig.simulated.inject(X, Fault.DRIVE, 0x3210)
    assert line.order(RESET, cycles=200) is DriveState.FAULT  # bit 7 stood all the time


def test_the_tables_know_all_sixteen_transitions() -> None:
    numbers = {t.number for t in (*COMMANDED.values(), *AUTOMATIC.values(), FAULT_TRANSITION)}
    assert numbers == set(range(1, 17))


def move_at_speed(line: Line, increments_per_cycle: int = 2000) -> None:
    """Enabled and moving at 2 000 000 increments/s, 200 mm/s."""
    for word in WAYS[E_]:
        line.order(word)
    for _ in range(100):
        line.target += increments_per_cycle
        line.order(ENABLE)
    assert line.drive.moving


def test_disable_operation_brakes_before_the_power_goes(line: Line) -> None:
    move_at_speed(line)
    assert line.order(SWITCH_ON) is DriveState.OPERATION_ENABLED
    assert line.order(ENABLE) is DriveState.OPERATION_ENABLED  # too late, it brakes
    assert line.order(SWITCH_ON, cycles=200) is DriveState.SWITCHED_ON
    assert not line.drive.moving


def test_the_servo_follows_a_ramp_without_lag(line: Line) -> None:
    move_at_speed(line)
    assert abs(line.drive.servo.position - line.drive.servo.command) < 50
    assert line.drive.servo.velocity == pytest.approx(2e6, rel=0.01)


def test_positions_beyond_32_bits(line: Line) -> None:
    """An endless axis: the wire wraps, the motor does not."""
    line.drive.servo.position = 2.0**31 - 3000
    for word in WAYS[E_]:
        line.target = 2**31 - 3000
        line.order(word)
    for step in range(1, 21):
        value = 2**31 - 3000 + step * 500
        line.target = value - 2**32 if value >= 2**31 else value
        line.order(ENABLE)
    line.order(ENABLE, cycles=50)
    assert line.drive.servo.position == pytest.approx(2.0**31 + 7000, abs=2)


def test_without_the_masters_heartbeat_the_drive_stops(line: Line) -> None:
    move_at_speed(line)
    line.frames.clear()
    for _ in range(600):  # nobody sends anything any more
        line.rig.time += 0.001
        line.rig.simulated.step(line.rig.time)
    assert line.drive.state is DriveState.FAULT
    assert not line.drive.moving
    assert line.emergencies() == [0x8130]
    assert line.drive.values[0x603F, 0] == 0x8130


def test_a_blocked_axis_raises_the_following_error(line: Line) -> None:
    move_at_speed(line)
    line.rig.simulated.inject(X, Fault.FOLLOWING_ERROR)
    for _ in range(100):
        line.target += 2000
        line.order(ENABLE)
    assert line.drive.state is DriveState.FAULT
    assert line.emergencies() == [0x8611]


def test_a_frozen_encoder_raises_the_following_error(line: Line) -> None:
    move_at_speed(line)
    line.rig.simulated.inject(X, Fault.ENCODER_FREEZE)
    for _ in range(200):
        line.target += 2000
        line.order(ENABLE)
    assert line.drive.state is DriveState.FAULT
    assert not line.drive.moving
