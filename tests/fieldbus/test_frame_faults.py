"""A bus that loses, repeats and reorders frames: what the axes do, and that no set-point jumps because of it."""

from __future__ import annotations

import itertools
import math
import random

import can
import pytest

from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.drives import DriveState
from runtime.fieldbus.cia402 import TARGET_POSITION
from tests.fieldbus.rig import Rig
from tests.fieldbus.test_operation import ENABLED, X, Y

INCREMENTS = 10_000  # per mm
VELOCITY = 400.0  # mm/s, the limit of X
CYCLES = 4000


class BadBus:
    """Both directions of a bus with faults; the same seed makes the same faults."""

    def __init__(self, bus: can.BusABC, *, loss: float = 0.0, repeat: float = 0.0, reorder: float = 0.0) -> None:
        self._bus = bus
        self._chance = random.Random(6)
        self.loss, self.repeat, self.reorder = loss, repeat, reorder
        self.faults = 0
        self._waiting: can.Message | None = None
        self._again: can.Message | None = None

    def _happens(self, probability: float) -> bool:
        happened = self._chance.random() < probability
        self.faults += happened
        return happened

    def send(self, message: can.Message, timeout: float | None = None) -> None:
        if self._happens(self.loss):
            return
        self._bus.send(message)
        if self._happens(self.repeat):
            self._bus.send(message)

    def recv(self, timeout: float | None = None) -> can.Message | None:
        message: can.Message | None
        if self._again is not None:
            message, self._again = self._again, None
            return message
        while (message := self._bus.recv(timeout)) is not None:
            if self._happens(self.loss):
                continue
            if self._happens(self.repeat):
                self._again = message
            elif self._happens(self.reorder) and (following := self._bus.recv(0)) is not None:
                self._again = message
                return following
            return message
        return None


def swing(rig: Rig, bus: BadBus, cycles: int = CYCLES) -> float:
    """X swings with up to 395 of 400 mm/s; the largest step of the set-point that its drive follows, mm per cycle."""
    rig.master.frames.bus = bus  # type: ignore[assignment]
    drive, image = rig.simulated.drives[1], rig.image
    before, worst = drive.servo.command, 0.0
    angle = 0.0
    for _ in range(cycles):
        if image.state[X] == ENABLED:
            angle += 7.9 * rig.machine.cycle.period
            image.target_position[X] = 50.0 * (1.0 - math.cos(angle))
        rig.cycle()
        after = drive.servo.command
        if drive.state is ENABLED:
            worst = max(worst, abs(after - before))
        before = after
    return worst / INCREMENTS


STEP = VELOCITY * 0.001  # one cycle's motion at the velocity limit, mm
ROUNDING = 2.0 / INCREMENTS


@pytest.mark.parametrize("loss", [0.001, 0.01])
def test_lost_frames_are_made_up_for_without_a_jump(loss: float) -> None:
    """A drive that missed a set-point goes on as before (0x60C2): the next one asks for the motion of one cycle."""
    with Rig() as rig:
        rig.enabled()
        bus = BadBus(rig.bus, loss=loss)
        step = swing(rig, bus)
        assert bus.faults > 0.5 * loss * CYCLES * 9
        assert rig.event_ids() == []
        assert rig.image.state[X] == ENABLED
        assert 0.9 * STEP < step <= STEP + ROUNDING


def test_one_frame_in_ten_lost_is_survived_or_told() -> None:
    with Rig() as rig:
        rig.enabled()
        step = swing(rig, BadBus(rig.bus, loss=0.1))
        told = set(rig.event_ids())
        assert told <= {
            catalogue.HEARTBEAT_LOST.id, catalogue.PROCESS_DATA_LOST.id, catalogue.EMERGENCY.id,
            catalogue.DRIVE_FAULT.id, catalogue.NODE_REJOINED.id, catalogue.REJOIN_REFUSED.id,
            catalogue.NODE_LEFT_OPERATIONAL.id,
        }  # fmt: skip
        assert rig.image.state[X] == ENABLED or told
        assert step <= STEP + ROUNDING


@pytest.mark.parametrize("lost", [1, 2, 3])
def test_set_points_lost_in_a_row_are_extrapolated(lost: int) -> None:
    """At a constant 300 mm/s a drive that misses up to three set-points moves as if nothing had been lost."""
    with Rig() as rig:
        rig.enabled()
        drive, image = rig.simulated.drives[1], rig.image
        for k in range(100):
            image.target_position[X] = 0.3 * k
            rig.cycle()
        hear = rig.master.frames.send
        left = lost

        def deaf(message: can.Message) -> None:
            nonlocal left
            if message.arbitration_id == 0x201 and left:
                left -= 1
            else:
                hear(message)

        rig.master.frames.send = deaf  # type: ignore[method-assign]
        commands = [drive.servo.command]
        for k in range(100, 120):
            image.target_position[X] = 0.3 * k
            rig.cycle()
            commands.append(drive.servo.command)
        steps = [b - a for a, b in itertools.pairwise(commands)]
        assert steps == pytest.approx([3000.0] * 20, abs=1.0)
        assert left == 0
        assert rig.event_ids() == []


def test_a_drive_that_hears_no_set_points_any_more_stops_by_itself() -> None:
    with Rig() as rig:
        rig.enabled()
        hear = rig.master.frames.send
        rig.master.frames.send = lambda message: None if message.arbitration_id == 0x201 else hear(message)  # type: ignore[method-assign]
        rig.cycle(10)
        assert rig.event_ids() == [catalogue.EMERGENCY.id, catalogue.DRIVE_FAULT.id]
        assert rig.image.fault_code[X] == 0x8250
        assert rig.image.state[Y] == ENABLED


@pytest.mark.parametrize("cycles", [1, 2, 5, 50])
def test_a_master_that_pauses_makes_no_set_point_jump(cycles: int) -> None:
    """No SYNC for some cycles, and then the path goes on where it was: no step back, none too far."""
    with Rig() as rig:
        rig.enabled()
        drive, image = rig.simulated.drives[1], rig.image
        commands = []
        for k in range(120):
            image.target_position[X] = 0.3 * k
            if k == 100:
                rig.master_alive = False
                for _ in range(cycles):
                    rig.cycle()
                    commands.append(drive.servo.command)
                rig.master_alive = True
            rig.cycle()
            commands.append(drive.servo.command)
        steps = [b - a for a, b in itertools.pairwise(commands)]
        assert min(steps) >= -1.0
        assert max(steps) <= STEP * INCREMENTS + 1.0
        assert rig.event_ids() == []


def test_a_set_point_that_jumps_never_reaches_the_drive() -> None:
    """The last guard of the master: more than one cycle's motion at the velocity limit is refused, the drive brakes."""
    with Rig() as rig:
        rig.enabled()
        drive, image = rig.simulated.drives[1], rig.image
        for k in range(50):
            image.target_position[X] = 0.3 * k
            rig.cycle()
        image.target_position[X] += 5.0
        before = drive.values[TARGET_POSITION, 0]
        rig.cycle(2)
        assert rig.event_ids() == [catalogue.SETPOINT_JUMP.id]
        assert abs(drive.values[TARGET_POSITION, 0] - before) <= STEP * INCREMENTS
        assert rig.run_until(lambda: not drive.moving)
        assert drive.transitions[-2:] == [11, 12]
        rig.cycle(20)
        assert rig.event_ids() == [catalogue.SETPOINT_JUMP.id]


@pytest.mark.parametrize(("repeat", "reorder"), [(0.05, 0.0), (0.0, 0.05), (0.05, 0.05)])
def test_repeated_and_reordered_frames_change_nothing(repeat: float, reorder: float) -> None:
    with Rig() as rig:
        rig.enabled()
        bus = BadBus(rig.bus, repeat=repeat, reorder=reorder)
        step = swing(rig, bus)
        assert bus.faults > 100
        assert rig.event_ids() == []
        assert step <= STEP + ROUNDING
        rig.cycle(200)
        assert rig.image.actual_position[X] == pytest.approx(rig.image.target_position[X], abs=1e-3)


def test_late_feedback_is_no_fault_until_it_is_too_late() -> None:
    """TPDOs of node 2 come a tenth of a second late, then not at all."""
    with Rig() as rig:
        rig.enabled()
        send = rig.simulated._network.send_message
        held: list[tuple[float, bytes]] = []
        delay = 0.1

        def late(can_id: int, data: bytes, remote: bool = False) -> None:
            if can_id == 0x182:
                held.append((rig.time + delay, data))
                while held and held[0][0] <= rig.time:
                    send(0x182, held.pop(0)[1])
            else:
                send(can_id, data, remote)

        rig.simulated._network.send_message = late  # type: ignore[method-assign]
        rig.cycle(1000)
        assert rig.event_ids() == []
        assert rig.image.state[Y] == ENABLED
        delay = 10.0
        assert rig.run_until(lambda: rig.image.state[Y] == DriveState.OFFLINE)
        assert rig.event_ids()[0] == catalogue.PROCESS_DATA_LOST.id


def test_a_babbling_node_is_read_in_bounded_portions() -> None:
    """More frames than a cycle takes: the cycle goes on, nothing is lost, nobody is called silent meanwhile."""
    with Rig() as rig, can.Bus(interface="virtual", channel=rig.machine.fieldbus.bus.channel) as babbler:
        rig.enabled()
        frame = can.Message(arbitration_id=0x7F0, data=bytes(8), is_extended_id=False)
        for _ in range(20):
            for _ in range(300):
                babbler.send(frame)
            rig.cycle()
        rig.cycle(100)
        assert rig.image.state[X] == ENABLED
        assert rig.event_ids() == []
