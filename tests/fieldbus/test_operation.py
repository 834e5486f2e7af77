"""The cycle of the master: set-points, feedback, units, I/O, and every fault while the machine runs."""

from __future__ import annotations

import errno
import math
from collections.abc import Iterator

import can
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.diagnostics.catalogue import CATALOGUE
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.diagnostics.errors import Reaction
from runtime.drives import DriveEvent, DriveState
from runtime.fieldbus import wire
from runtime.fieldbus.described import make_links
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.events import problem_of
from runtime.fieldbus.master import CanopenMaster
from runtime.fieldbus.simulator import Fault
from tests.fieldbus.rig import Rig, demo_description

X, Y, Z, S = range(4)  # axes
ENABLED = DriveState.OPERATION_ENABLED


@pytest.fixture
def rig() -> Iterator[Rig]:
    with Rig() as rig:
        yield rig.enabled()


def ids(*entries: object) -> list[int]:
    return [entry.id for entry in entries]  # type: ignore[attr-defined]


def move(rig: Rig, axis: int, velocity: float, cycles: int) -> None:
    """Move at a velocity in units/s, from where the target is."""
    for _ in range(cycles):
        rig.image.target_position[axis] += velocity * rig.machine.cycle.period
        rig.cycle()


def test_positions_and_velocities_come_back(rig: Rig) -> None:
    move(rig, X, 100.0, 200)
    assert rig.image.actual_velocity[X] == pytest.approx(100.0, rel=0.02)
    rig.cycle(100)
    assert rig.image.actual_position[X] == pytest.approx(20.0, abs=1e-3)
    assert rig.image.actual_position[Y] == 0.0
    assert rig.event_ids() == []


def test_the_spindle_turns_at_speed(rig: Rig) -> None:
    for speed in np.linspace(0.0, 36_000.0, 200):  # degrees/s, 6000 rev/min
        rig.image.target_velocity[S] = speed
        rig.cycle()
    rig.cycle(100)
    assert rig.image.actual_velocity[S] == pytest.approx(36_000.0, rel=1e-3)
    assert rig.image.actual_position[S] > 0.0


def test_enabling_makes_no_axis_jump() -> None:
    with Rig() as rig:
        rig.simulated.drives[1].servo.position = 1_234_567.0
        rig.started()
        assert rig.image.actual_position[X] == pytest.approx(123.4567)
        # the axis has not yet taken its position over: target 0
        rig.image.enable[:] = True
        lowest = 1_234_567.0
        while rig.image.state[X] != ENABLED:
            rig.cycle()
            lowest = min(lowest, rig.simulated.drives[1].servo.position)
        assert lowest == pytest.approx(1_234_567.0, abs=1.0)


def test_the_target_is_taken_over_only_when_enabled() -> None:
    with Rig() as rig:
        rig.started()
        rig.image.target_position[X] = 50.0
        rig.cycle(20)
        assert rig.simulated.drives[1].values[0x607A, 0] == 0
        assert rig.image.actual_position[X] == 0.0


def test_quick_stop_and_back(rig: Rig) -> None:
    move(rig, X, 200.0, 100)
    rig.image.quick_stop[X] = True
    rig.cycle(3)
    assert rig.image.state[X] == DriveState.QUICK_STOP_ACTIVE
    assert rig.run_until(lambda: rig.image.state[X] == DriveState.SWITCH_ON_DISABLED)
    assert rig.image.actual_velocity[X] == 0.0
    assert rig.image.state[Y] == ENABLED
    assert rig.event_ids() == []
    rig.image.target_position[X] = rig.image.actual_position[X]
    rig.image.quick_stop[X] = False
    assert rig.run_until(lambda: rig.image.state[X] == ENABLED)


def test_disabling_brakes_first(rig: Rig) -> None:
    move(rig, X, 200.0, 100)
    rig.image.enable[X] = False
    assert rig.run_until(lambda: rig.image.state[X] == DriveState.SWITCH_ON_DISABLED)
    assert rig.simulated.drives[1].transitions[-3:] == [5, 6, 7]
    assert not rig.simulated.drives[1].moving
    assert rig.event_ids() == []


def test_drive_fault_while_moving(rig: Rig) -> None:
    move(rig, X, 200.0, 100)
    rig.simulated.inject(1, Fault.DRIVE, 0x2310)
    rig.cycle(4)
    assert rig.event_ids() == ids(catalogue.EMERGENCY, catalogue.DRIVE_FAULT)
    emergency, fault = rig.problems()
    assert "axis X" in fault.text
    assert "continuous over-current at the motor (0x2310)" in fault.text
    assert emergency.text.startswith("node 1 (axis X) reports")
    assert rig.image.fault_code[X] == 0x2310
    assert rig.image.emcy_count == 1
    assert rig.run_until(lambda: rig.image.state[X] == DriveState.FAULT)
    assert rig.image.state[Y] == ENABLED  # the reaction is the CNC's matter
    rig.cycle(500)
    assert rig.image.state[X] == DriveState.FAULT  # stays until acknowledged
    rig.image.target_position[X] = rig.image.actual_position[X]
    rig.image.reset_fault[X] = True
    assert rig.run_until(lambda: rig.image.state[X] == ENABLED)
    assert rig.image.fault_code[X] == 0


def test_heartbeat_lost(rig: Rig) -> None:
    move(rig, Y, 100.0, 50)
    rig.simulated.inject(2, Fault.SILENT)
    before = rig.time
    assert rig.run_until(lambda: rig.image.state[Y] == DriveState.OFFLINE)
    assert rig.time - before <= 0.3 + 0.1 + 0.002
    assert rig.event_ids() in (ids(catalogue.HEARTBEAT_LOST), ids(catalogue.PROCESS_DATA_LOST))
    rig.cycle(100)
    assert rig.simulated.drives[2].state is DriveState.FAULT  # it heard no master either
    rig.simulated.heal(2)
    rig.cycle(300)
    assert rig.image.state[Y] != ENABLED  # it may be back, but nobody has acknowledged its fault


def test_only_the_heartbeat_lost(rig: Rig) -> None:
    send = rig.simulated._network.send_message

    def without_heartbeat(can_id: int, data: bytes, remote: bool = False) -> None:
        if can_id != 0x702:
            send(can_id, data, remote)

    rig.simulated._network.send_message = without_heartbeat  # type: ignore[method-assign]
    assert rig.run_until(lambda: rig.image.state[Y] == DriveState.OFFLINE)
    assert rig.event_ids() == ids(catalogue.HEARTBEAT_LOST)
    assert rig.problems()[0].text == "heartbeat of node 2 (axis Y) is lost"


def test_process_data_lost_while_the_heart_beats(rig: Rig) -> None:
    send = rig.simulated._network.send_message

    def without_pdo(can_id: int, data: bytes, remote: bool = False) -> None:
        if can_id != 0x181:
            send(can_id, data, remote)

    rig.simulated._network.send_message = without_pdo  # type: ignore[method-assign]
    assert rig.run_until(lambda: rig.image.state[X] == DriveState.OFFLINE)
    assert rig.event_ids() == ids(catalogue.PROCESS_DATA_LOST)


def test_a_node_restarts(rig: Rig) -> None:
    rig.simulated.inject(3, Fault.REBOOT)
    rig.cycle(3)
    assert rig.image.state[Z] == DriveState.OFFLINE
    assert rig.event_ids() == ids(catalogue.NODE_RESTARTED)
    rig.cycle(500)
    assert rig.event_ids() == ids(catalogue.NODE_RESTARTED, catalogue.NODE_REJOINED)


def test_a_node_leaves_the_operational_state(rig: Rig) -> None:
    rig.bus.send(can.Message(arbitration_id=0, data=[128, 3], is_extended_id=False))
    assert rig.run_until(lambda: rig.image.state[Z] == DriveState.OFFLINE)
    assert catalogue.NODE_LEFT_OPERATIONAL.id in rig.event_ids()
    assert any("pre-operational" in problem.text for problem in rig.problems())


def test_a_drive_disables_itself(rig: Rig) -> None:
    drive = rig.simulated.drives[1]
    drive.state = DriveState.SWITCH_ON_DISABLED  # safe torque off
    rig.cycle(10)
    assert rig.event_ids() == ids(catalogue.DRIVE_DISABLED)
    assert "switch on disabled" in rig.problems()[0].text
    assert rig.image.state[X] == DriveState.SWITCH_ON_DISABLED  # not enabled again by itself
    rig.image.enable[X] = False
    rig.cycle()
    rig.image.enable[X] = True
    assert rig.run_until(lambda: rig.image.state[X] == ENABLED)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_set_point_that_is_no_number(rig: Rig, value: float) -> None:
    move(rig, X, 100.0, 50)
    rig.image.target_position[X] = value
    assert rig.run_until(lambda: rig.image.state[X] == DriveState.SWITCH_ON_DISABLED)
    assert rig.event_ids() == ids(catalogue.SETPOINT_INVALID)
    assert rig.image.actual_position[X] < 10.0


@pytest.mark.parametrize("value", [1e300, -1e300, 1e12])
def test_a_set_point_beyond_all_bounds_raises_nothing(rig: Rig, value: float) -> None:
    rig.image.target_position[X] = value
    rig.image.target_velocity[S] = value
    rig.cycle(3)
    assert rig.simulated.drives[6].values[0x60FF, 0] == (2**31 - 1 if value > 0 else -(2**31))


def test_the_bus_is_gone(rig: Rig) -> None:
    rig.image.digital_out[0] = 1
    rig.cycle(400)
    assert rig.image.digital_in[0] & 1
    rig.bus.shutdown()
    rig.cycle(10)
    assert rig.event_ids() == ids(catalogue.BUS_GONE)
    assert set(rig.image.state.tolist()) == {DriveState.OFFLINE}
    assert not rig.image.digital_in.any()
    rig.cycle(1000)
    assert len(rig.events) == 1
    assert {drive.state for drive in rig.simulated.drives.values()} == {DriveState.FAULT}
    rig.master.stop()


class Failing:
    """A bus whose sending fails."""

    def __init__(self, bus: can.BusABC, error: Exception) -> None:
        self._bus, self.error, self.fails = bus, error, True

    def recv(self, timeout: float | None = None) -> can.Message | None:
        return self._bus.recv(timeout)

    def send(self, message: can.Message, timeout: float | None = None) -> None:
        if self.fails:
            raise self.error
        self._bus.send(message)


def test_an_interface_that_goes_down_is_gone_at_once(rig: Rig) -> None:
    failing = Failing(rig.bus, can.CanOperationError("Failed to transmit", errno.ENETDOWN))
    rig.master.frames.bus = failing  # type: ignore[assignment]
    rig.cycle(2)
    assert rig.event_ids() == ids(catalogue.BUS_GONE)
    assert "network is down" in rig.problems()[0].text


def test_a_full_queue_passes_by(rig: Rig) -> None:
    failing = Failing(rig.bus, can.CanOperationError("Transmit buffer full"))
    rig.master.frames.bus = failing  # type: ignore[assignment]
    rig.cycle(2)
    failing.fails = False
    rig.cycle(50)
    assert rig.event_ids() == []
    assert rig.image.state[X] == ENABLED
    failing.fails = True
    rig.cycle(5)
    assert rig.event_ids() == ids(catalogue.BUS_GONE)


def test_bus_off(rig: Rig) -> None:
    rig.node_bus.send(can.Message(arbitration_id=0x40, is_error_frame=True, is_extended_id=False, data=bytes(8)))
    rig.cycle()
    assert rig.event_ids() == ids(catalogue.BUS_OFF)
    assert set(rig.image.state.tolist()) == {DriveState.OFFLINE}


@pytest.mark.parametrize("bitrate", [500_000, 800_000])
def test_a_wire_too_slow_for_the_cycle_is_refused(bitrate: int) -> None:
    with Rig() as rig:
        slow = rig.machine.fieldbus.bus.model_copy(update={"interface": "socketcan", "bitrate": bitrate})
        machine = rig.machine.model_copy(update={"fieldbus": rig.machine.fieldbus.model_copy(update={"bus": slow})})
        master = CanopenMaster(machine, rig.bus, now=lambda: rig.time, idle=rig.idle)
        with pytest.raises(FieldbusError) as refusal:
            master.start()
        assert refusal.value.problem.entry is catalogue.BUS_TOO_SLOW
        planned = wire.planned_load(make_links(machine), slow, machine.cycle.period)
        assert f"{round(planned * 1000) - 1000} µs more than the cycle of 1000 µs" in refusal.value.problem.text


def test_a_wire_nearly_full_is_told() -> None:
    with Rig() as rig:
        full = rig.machine.fieldbus.bus.model_copy(update={"interface": "socketcan", "bitrate": 950_000})
        rig.master._config = rig.master.frames.config = full
        rig.machine = rig.machine.model_copy(update={"fieldbus": rig.machine.fieldbus.model_copy(update={"bus": full})})
        rig.master._machine = rig.machine
        rig.started()
        assert rig.event_ids() == ids(catalogue.BUS_OVERLOADED)
        assert "% of the bus" in rig.problems()[0].text
        assert CATALOGUE[rig.events[0].error_id].reaction is Reaction.NONE


def test_bus_load_is_measured(rig: Rig) -> None:
    rig.cycle(300)
    # four set-points and four feedbacks of 6 bytes, a SYNC: nearly all that 1 Mbit/s has in 1 ms
    assert 0.8 < rig.image.bus_load < 1.0
    planned = wire.planned_load(make_links(rig.machine), rig.machine.fieldbus.bus, rig.machine.cycle.period)
    assert rig.image.bus_load == pytest.approx(planned, rel=0.01)


def test_stop_disables_and_leaves(rig: Rig) -> None:
    move(rig, X, 200.0, 100)
    rig.image.digital_out[0] = 0b11
    rig.cycle(5)
    rig.master.stop()
    rig.idle()  # the last frames arrive
    for drive in rig.simulated.drives.values():
        assert drive.transitions[-3:] == [5, 6, 7]
        assert not drive.moving
        assert drive.local.nmt.state == "PRE-OPERATIONAL"
    assert not any(rig.simulated.ios[10].output_states().values())
    assert rig.event_ids() == []


def test_stop_with_a_silent_node_is_bounded(rig: Rig) -> None:
    rig.simulated.inject(1, Fault.SILENT)
    before = rig.time
    rig.master.stop()
    assert rig.time - before < 3.5


def test_killing_the_master_stops_all_drives(rig: Rig) -> None:
    move(rig, X, 200.0, 100)
    rig.image.target_velocity[S] = 6000.0
    rig.image.digital_out[0] = 0b10
    rig.cycle(100)
    rig.master_alive = False
    rig.cycle(400)
    for drive in rig.simulated.drives.values():
        assert drive.state is DriveState.FAULT
        assert not drive.moving
    assert not any(rig.simulated.ios[10].output_states().values())
    # a new master finds the cause
    rig.master_alive = True
    rig.events.clear()
    rig.image.enable[:] = False
    rig.started()
    assert rig.event_ids() == ids(catalogue.DRIVE_FAULT) * 4
    assert "heartbeat of the master lost" in rig.problems()[0].text
    rig.image.enable[:] = True
    rig.cycle(50)
    assert set(rig.image.state.tolist()) == {DriveState.FAULT}  # not without being acknowledged
    rig.image.reset_fault[:] = True
    assert rig.run_until(lambda: bool((rig.image.state == ENABLED).all()))


def test_an_axis_without_a_drive_follows_at_once() -> None:
    description = demo_description()
    del description["axes"][1]["drive"]
    with Rig(description) as rig:
        rig.enabled()
        rig.image.target_position[Y] = 7.0
        rig.cycle(2)
        assert rig.image.actual_position[Y] == 7.0


def test_io_bits_run_on_over_several_nodes() -> None:
    description = demo_description()
    description["fieldbus"]["io"] = [
        {"node": 10, "inputs": ["a", "b", "door_closed"], "outputs": ["p", "q", "r"]},
        {"node": 11, "inputs": ["coolant_pressure", "e_stop_ok"], "outputs": ["s", "coolant_pump"]},
    ]
    with Rig(description) as rig:
        rig.started()
        assert rig.image.digital_in[0] == 0b1_0100
        rig.image.digital_out[0] = 0b1_0101
        rig.cycle(300)
        assert rig.simulated.ios[10].output_states() == {"p": True, "q": False, "r": True}
        assert rig.simulated.ios[11].output_states() == {"s": False, "coolant_pump": True}
        assert rig.image.digital_in[0] == 0b1_1100


def test_the_inputs_of_a_lost_node_are_false(rig: Rig) -> None:
    assert rig.image.digital_in[0]
    rig.simulated.inject(10, Fault.SILENT)
    assert rig.run_until(lambda: not rig.image.digital_in.any())
    assert rig.events == [DriveEvent(catalogue.HEARTBEAT_LOST.id, -1, 10, 0)]
    assert "I/O node 0" in rig.problems()[0].text


def test_every_running_error_can_be_told() -> None:
    with Rig(nodes=False) as rig:
        for entry in CATALOGUE.values():
            if 303030 <= entry.id < 303100:
                event = DriveEvent(entry.id, 0 if entry.id < 303040 else -1, 1, 5)
                assert problem_of(event, rig.machine).explained()


frames = st.builds(
    can.Message,
    arbitration_id=st.one_of(
        st.sampled_from([0x000, 0x080, 0x081, 0x08A, 0x181, 0x186, 0x286, 0x18A, 0x581, 0x701, 0x70A, 0x77F]),
        st.integers(0, 0x7FF),
    ),
    data=st.binary(max_size=8),
    is_extended_id=st.booleans(),
    is_remote_frame=st.booleans(),
)


@settings(max_examples=12, deadline=None)
@given(st.lists(st.lists(frames, max_size=6), min_size=1, max_size=20))
def test_no_frames_make_the_cycle_raise_or_move_an_unfit_drive(sequence: list[list[can.Message]]) -> None:
    with Rig() as rig:
        rig.enabled()
        machine_states = set(DriveState)
        for messages in sequence:
            for message in messages:
                rig.node_bus.send(message)  # to the master
                rig.bus.send(message)  # and to the nodes
            rig.cycle()
            assert set(rig.image.state.tolist()) <= machine_states
            for link in rig.master._drives:
                word = int.from_bytes(link.message.data[:2], "little")
                assert word in (0x00, 0x02, 0x06, 0x07, 0x0F, 0x80)
                if word == 0x0F:
                    assert link.control.state in (DriveState.SWITCHED_ON, ENABLED)
                    assert not link.lost
        rig.master.stop()
