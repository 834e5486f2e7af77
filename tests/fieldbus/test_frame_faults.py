"""A bus that loses, repeats and reorders frames: what the axes do, and that no set-point jumps because of it."""

from __future__ import annotations

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
    """X swings with up to 200 mm/s; the largest step of the set-point that the drive took over, mm per cycle."""
    rig.master._bus = bus  # type: ignore[assignment]
    drive, image = rig.simulated.drives[1], rig.image
    before, worst = drive.values[TARGET_POSITION, 0], 0
    for cycle in range(cycles):
        if image.state[X] == ENABLED:
            image.target_position[X] = 50.0 * (1.0 - math.cos(4.0 * cycle * rig.machine.cycle.period))
        rig.cycle()
        after = drive.values[TARGET_POSITION, 0]
        if drive.state is ENABLED:
            worst = max(worst, abs(after - before))
        before = after
    return worst / INCREMENTS


@pytest.mark.parametrize(("loss", "cycles"), [(0.001, 1), (0.01, 2)])
def test_lost_frames_are_made_up_for_by_the_next(loss: float, cycles: int) -> None:
    """The master steps as ever; a drive that missed frames in a row goes the way of `cycles` at once."""
    with Rig() as rig:
        rig.enabled()
        bus = BadBus(rig.bus, loss=loss)
        step = swing(rig, bus)
        assert bus.faults > 0.5 * loss * CYCLES * 9
        assert rig.event_ids() == []
        assert rig.image.state[X] == ENABLED
        assert step <= cycles * VELOCITY * rig.machine.cycle.period


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
        assert step <= VELOCITY * rig.machine.cycle.period * 3


@pytest.mark.parametrize(("repeat", "reorder"), [(0.05, 0.0), (0.0, 0.05), (0.05, 0.05)])
def test_repeated_and_reordered_frames_change_nothing(repeat: float, reorder: float) -> None:
    with Rig() as rig:
        rig.enabled()
        bus = BadBus(rig.bus, repeat=repeat, reorder=reorder)
        step = swing(rig, bus)
        assert bus.faults > 100
        assert rig.event_ids() == []
        assert step <= VELOCITY * rig.machine.cycle.period
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
