"""Faults of the bus itself on the real protocol: two nodes with one id, foreign SYNC, late SYNC, floods, and its recovery."""

from __future__ import annotations

import errno
import math
from collections.abc import Iterator

import can
import pytest

from runtime.diagnostics.catalogue import CATALOGUE
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.diagnostics.errors import Reaction
from runtime.drives import DriveState
from runtime.fieldbus.cia402 import TARGET_POSITION
from runtime.fieldbus.described import DRIVE_EDS, eds_path
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.simulator import Fault
from runtime.fieldbus.simulator.drive import SimulatedDrive
from runtime.fieldbus.simulator.nodes import NodeNetwork
from runtime.fieldbus.simulator.servo import Motor
from tests.fieldbus.rig import Rig, demo_description
from tests.fieldbus.test_operation import ENABLED, Failing, X, Y, ids
from tests.fieldbus.test_rejoin import back

VELOCITY = 400.0  # mm/s, the limit of X
INCREMENTS = 10_000  # per mm


@pytest.fixture
def rig() -> Iterator[Rig]:
    with Rig() as rig:
        yield rig.enabled()


class Twin:
    """A second node 2, on a socket of its own."""

    def __init__(self, rig: Rig) -> None:
        self.bus = can.Bus(interface="virtual", channel=rig.machine.fieldbus.bus.channel)
        self.network = NodeNetwork(self.bus)
        servo = rig.machine.axes[Y].drive
        assert servo is not None
        self.drive = SimulatedDrive(
            2, eds_path(None, DRIVE_EDS), self.network, servo.simulated, 0.0, Motor(INCREMENTS, 8_000.0 * INCREMENTS)
        )
        step = rig.simulated.step

        def step_both(now: float) -> None:
            step(now)
            while (message := self.bus.recv(0)) is not None:
                self.network.receive(message)
            self.network.step(now)
            self.drive.step(now)

        rig.simulated.step = step_both  # type: ignore[method-assign]


def test_two_nodes_with_one_id_are_refused_at_the_start() -> None:
    with Rig() as rig:
        twin = Twin(rig)
        rig.idle()
        twin.drive.power_on(rig.time)
        with pytest.raises(FieldbusError) as refusal:
            rig.master.start()
        assert refusal.value.problem.entry is catalogue.NODE_DOUBLE
        assert "node id 2 (axis Y)" in refusal.value.problem.text
        twin.bus.shutdown()


def test_a_node_that_is_just_being_switched_on_is_no_second_one() -> None:
    with Rig() as rig:
        rig.idle()
        send = rig.master._network.send_message

        def and_boots(can_id: int, data: bytes, remote: bool = False) -> None:
            send(can_id, data, remote)
            if can_id == 0 and data[0] == 130 and rig.time < 1.0:
                rig.master._network.send_message = send  # type: ignore[method-assign]
                rig.simulated.inject(2, Fault.REBOOT)

        rig.master._network.send_message = and_boots  # type: ignore[method-assign]
        rig.started()
        assert rig.event_ids() == []


def test_a_second_node_that_is_switched_on_while_the_machine_runs(rig: Rig) -> None:
    twin = Twin(rig)
    twin.drive.power_on(rig.time)
    rig.cycle(20)
    assert rig.event_ids()[0] == catalogue.NODE_RESTARTED.id
    assert CATALOGUE[rig.event_ids()[0]].reaction is Reaction.STOP_ON_PATH
    assert (rig.image.state[Y], rig.image.state[X]) == (DriveState.OFFLINE, ENABLED)
    assert rig.run_until(lambda: catalogue.REJOIN_REFUSED.id in rig.event_ids(), 5.0)
    told = next(problem.text for problem in rig.problems() if problem.entry is catalogue.REJOIN_REFUSED)
    assert "more than one node answers with node id 2 (axis Y)" in told
    twin.drive.silent = True
    twin.network.silent.add(2)
    assert rig.run_until(lambda: back(rig, 2), 6.0)
    twin.bus.shutdown()


def test_a_foreign_sync_stops_the_path_and_is_told_once_a_second(rig: Rig) -> None:
    with can.Bus(interface="virtual", channel=rig.machine.fieldbus.bus.channel) as other:
        for _ in range(1500):
            other.send(can.Message(arbitration_id=0x80, is_extended_id=False))
            rig.cycle()
    assert rig.event_ids() == ids(catalogue.FOREIGN_SYNC) * 2
    assert CATALOGUE[rig.event_ids()[0]].reaction is Reaction.STOP_ON_PATH


@pytest.mark.parametrize("pause", [0.005, 0.05, 0.2])
def test_a_sync_that_comes_late_makes_no_jump(rig: Rig, pause: float) -> None:
    """The master's cycle overran: the set-points go on where they were, since they count in cycles."""
    drive, image = rig.simulated.drives[1], rig.image
    period = rig.machine.cycle.period
    before, worst = drive.values[TARGET_POSITION, 0], 0
    for cycle in range(2000):
        image.target_position[X] = 50.0 * (1.0 - math.cos(4.0 * cycle * period))
        if cycle == 700:
            end = rig.time + pause
            while rig.time < end:
                rig.idle()
        rig.cycle()
        after = drive.values[TARGET_POSITION, 0]
        worst, before = max(worst, abs(after - before)), after
    assert worst / INCREMENTS <= VELOCITY * period
    assert rig.event_ids() == []
    assert image.state[X] == ENABLED


def test_several_syncs_in_a_row_make_no_jump(rig: Rig) -> None:
    """Cycles that were late and are caught up with at once: each SYNC has its set-points."""
    drive, image = rig.simulated.drives[1], rig.image
    period = rig.machine.cycle.period
    before, worst = drive.values[TARGET_POSITION, 0], 0
    for cycle in range(1500):
        image.target_position[X] = 50.0 * (1.0 - math.cos(4.0 * cycle * period))
        rig.master.read()
        rig.master.write()
        rig.simulated.poll(rig.time)
        if cycle % 100 >= 5:  # five without any time between them
            rig.time += period
            rig.simulated.step(rig.time)
        after = drive.values[TARGET_POSITION, 0]
        worst, before = max(worst, abs(after - before)), after
    assert worst / INCREMENTS <= VELOCITY * period
    assert rig.event_ids() == []


def test_a_node_that_babbles_without_end_stops_the_path(rig: Rig) -> None:
    """Nobody can be watched any more: that is told, once, and nothing grows in the cycle meanwhile."""
    frame = can.Message(arbitration_id=0x7F0, data=bytes(8), is_extended_id=False)
    with can.Bus(interface="virtual", channel=rig.machine.fieldbus.bus.channel) as babbler:
        rig.simulated.step = lambda now: None  # type: ignore[method-assign]
        for _ in range(400):
            for _ in range(260):
                babbler.send(frame)
            rig.cycle()
    assert rig.event_ids() == ids(catalogue.BUS_FLOODED)
    assert CATALOGUE[catalogue.BUS_FLOODED.id].reaction is Reaction.STOP_ON_PATH


def test_frames_that_have_come_while_no_cycle_ran_are_no_flood(rig: Rig) -> None:
    """The host has held the cycle for longer than the heartbeat timeout: more waits than a cycle takes, and it is no fault."""
    frame = can.Message(arbitration_id=0x7F0, data=bytes(8), is_extended_id=False)
    with can.Bus(interface="virtual", channel=rig.machine.fieldbus.bus.channel) as other:
        for _ in range(1000):
            other.send(frame)
        rig.time += 2.0 * rig.machine.fieldbus.bus.heartbeat_timeout
        rig.cycle(10)
    assert catalogue.BUS_FLOODED.id not in rig.event_ids()


def recovering(**policy: object) -> Rig:
    description = demo_description()
    description["fieldbus"]["bus"] |= policy
    return Rig(description)


def outage(rig: Rig, seconds: float = 1.0) -> None:
    """The interface is down for a while."""
    failing = Failing(rig.bus, can.CanOperationError("Failed to transmit", errno.ENETDOWN))
    rig.master.frames.bus = failing  # type: ignore[assignment]
    assert rig.run_until(lambda: catalogue.BUS_GONE.id in rig.event_ids(), 0.1)
    rig.cycle(round(seconds / rig.machine.cycle.period))
    failing.fails = False


def count(rig: Rig, entry_id: int) -> int:
    return rig.event_ids().count(entry_id)


def test_recovery_by_hand_waits_for_the_reset() -> None:
    with recovering(recovery="manual") as rig:
        rig.enabled()
        outage(rig)
        rig.cycle(2000)
        assert count(rig, catalogue.BUS_BACK.id) == 0
        assert count(rig, catalogue.BUS_WAITS.id) == 1
        sent = rig.image.frames_sent
        rig.cycle(1000)
        assert rig.image.frames_sent == sent  # nothing is put on it
        rig.master.tell_again()
        assert rig.run_until(lambda: count(rig, catalogue.BUS_BACK.id) == 1, 1.0)
        assert rig.run_until(lambda: back(rig, 1) and back(rig, 10), 6.0)


def test_recovery_so_often_by_itself_and_no_more() -> None:
    with recovering(recovery_count=2) as rig:
        rig.enabled()
        for times in (1, 2):
            outage(rig, 0.1)
            assert rig.run_until(lambda times=times: count(rig, catalogue.BUS_BACK.id) == times, 2.0)  # type: ignore[misc]
            rig.cycle(100)
        rig.events.clear()
        outage(rig, 0.1)
        rig.cycle(2000)
        assert count(rig, catalogue.BUS_BACK.id) == 0
        assert "came back 2 times" in next(p.text for p in rig.problems() if p.entry is catalogue.BUS_WAITS)
        rig.master.tell_again()
        assert rig.run_until(lambda: count(rig, catalogue.BUS_BACK.id) == 1, 2.0)
        outage(rig, 0.1)  # the reset begins the count anew
        assert rig.run_until(lambda: count(rig, catalogue.BUS_BACK.id) == 2, 2.0)
        # it was gone while the nodes were being reset: they have no heartbeat, and are found all the same
        assert rig.run_until(lambda: all(back(rig, node) for node in (1, 2, 3, 6, 10)), 12.0)


def test_a_node_whose_boot_up_message_was_lost_is_taken_in(rig: Rig) -> None:
    """It was reset and has no heartbeat any more; nothing would ever be heard of it."""
    rig.simulated.inject(2, Fault.REBOOT)
    rig.cycle(2)
    rig.simulated.nodes[2].power_on(rig.time)
    rig.simulated.inject(2, Fault.SILENT)  # the cable, for a moment
    rig.cycle(4000)
    rig.simulated.heal(2)
    assert not rig.simulated.nodes[2].operational
    assert rig.run_until(lambda: back(rig, 2), 10.0)


def test_the_pause_before_a_bus_is_tried_again() -> None:
    with recovering(recovery_pause="1.5 s") as rig:
        rig.enabled()
        outage(rig, 0.0)
        begin = rig.time
        assert rig.run_until(lambda: count(rig, catalogue.BUS_BACK.id) == 1, 5.0)
        assert 1.4 < rig.time - begin < 1.8
