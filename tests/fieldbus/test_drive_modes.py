"""What a drive can do beyond following positions, over the real protocol: modes, homing, probes, torque, inputs."""

from __future__ import annotations

import math
from typing import Any

import pytest

from runtime import drives
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.drives import DriveMode, DriveState, HomingState
from runtime.fieldbus import cia402
from runtime.fieldbus.described import CobIds
from runtime.fieldbus.drive_setup import Part
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.pdo import Direction, PdoPlan, find_variable
from runtime.fieldbus.simulator import Fault
from tests.fieldbus.rig import Rig, demo_description

X, Y, Z, S = 0, 1, 2, 3
ENABLED = DriveState.OPERATION_ENABLED
HOMING = {"fast": 50, "slow": 5, "position": 2.0}


def machine(homing: dict[str, Any] | None = None, **drive: Any) -> Rig:
    """The demo machine with this said of the drive of X."""
    description = demo_description()
    description["axes"][X]["drive"] |= drive
    if homing is not None:
        description["axes"][X]["homing"] = HOMING | homing
    return Rig(description)


def follow(rig: Rig, way: float, cycles: int) -> float:
    """X goes a way, evenly; the greatest following error meanwhile."""
    begin, worst = float(rig.image.target_position[X]), 0.0
    for k in range(cycles):
        rig.image.target_position[X] = begin + way * 0.5 * (1.0 - math.cos(math.pi * (k + 1) / cycles))
        rig.cycle()
        worst = max(worst, abs(float(rig.image.target_position[X] - rig.image.actual_position[X])))
    return worst


# -- modes -----------------------------------------------------------------------------------------------------------


def test_interpolated_position_is_a_mode_for_older_drives() -> None:
    with machine(mode="interpolated_position") as rig:
        rig.enabled()
        drive = rig.simulated.drives[1]
        assert drive.mode == DriveMode.INTERPOLATED_POSITION
        assert follow(rig, 20.0, 400) < 1.0
        rig.cycle(100)
        assert rig.image.actual_position[X] == pytest.approx(20.0, abs=1e-3)
        assert drive.values[cia402.TARGET_POSITION, 0] == 0  # never used
        assert rig.event_ids() == []


def test_in_velocity_mode_the_control_closes_the_position_loop() -> None:
    with machine(mode="cyclic_synchronous_velocity", position_gain=40) as rig:
        rig.enabled()
        assert rig.simulated.drives[1].mode == DriveMode.CYCLIC_SYNCHRONOUS_VELOCITY
        assert follow(rig, 20.0, 400) < 2.0
        rig.cycle(500)
        assert rig.image.actual_position[X] == pytest.approx(20.0, abs=2e-3)
        rig.simulated.drives[1].servo.position += 5000.0  # pushed off by half a millimetre
        rig.cycle(500)
        assert rig.image.actual_position[X] == pytest.approx(20.0, abs=2e-3)
        assert rig.event_ids() == []


def test_a_drive_goes_to_a_position_by_its_own_profile_and_comes_back_without_a_jump() -> None:
    with machine(modes=["profile_position"]) as rig:
        rig.enabled()
        image, drive = rig.image, rig.simulated.drives[1]
        image.mode[X] = DriveMode.PROFILE_POSITION
        image.profile_target[X] = 30.0
        rig.cycle(3)
        assert image.by_drive[X]
        assert rig.run_until(lambda: bool(image.target_reached[X]))
        rig.cycle(100)
        assert image.actual_position[X] == pytest.approx(30.0, abs=1e-3)
        image.profile_target[X] = 10.0  # a new one, in the middle of the way
        rig.cycle(60)
        image.profile_target[X] = 40.0
        rig.cycle(20)
        assert rig.run_until(lambda: bool(image.target_reached[X]))
        rig.cycle(100)
        assert image.actual_position[X] == pytest.approx(40.0, abs=1e-3)
        image.target_position[X] = image.actual_position[X]  # as the supervision tracks it
        image.mode[X] = DriveMode.CONFIGURED
        rig.cycle(5)
        assert not image.by_drive[X]
        assert drive.mode == DriveMode.CYCLIC_SYNCHRONOUS_POSITION
        rig.cycle(50)
        assert image.actual_position[X] == pytest.approx(40.0, abs=1e-3)
        assert rig.event_ids() == []


def test_profile_velocity_and_halt() -> None:
    with machine(modes=["profile_velocity"]) as rig:
        rig.enabled()
        image = rig.image
        image.mode[X], image.target_velocity[X] = DriveMode.PROFILE_VELOCITY, 50.0
        rig.cycle(200)
        assert image.actual_velocity[X] == pytest.approx(50.0, rel=0.01)
        image.halt[X] = True
        rig.cycle(100)
        assert image.actual_velocity[X] == 0.0
        assert image.target_reached[X]
        assert image.state[X] == ENABLED
        image.halt[X] = False
        image.target_velocity[X] = -50.0
        rig.cycle(200)
        assert image.actual_velocity[X] == pytest.approx(-50.0, rel=0.01)
        image.enable[X] = False
        assert rig.run_until(lambda: image.state[X] == DriveState.SWITCH_ON_DISABLED)
        assert rig.event_ids() == []


@pytest.mark.parametrize("name", ["profile_torque", "cyclic_synchronous_torque"])
def test_torque_modes_push_with_the_torque_that_is_asked_for(name: str) -> None:
    with machine(modes=[name], process_data=["torque"]) as rig:
        rig.enabled()
        image = rig.image
        image.mode[X], image.target_torque[X] = DriveMode[name.upper()], 0.01
        rig.cycle(20)
        assert image.actual_torque[X] == pytest.approx(0.01)
        assert image.actual_velocity[X] > 1.0
        image.target_torque[X] = math.nan  # never goes out
        rig.cycle(5)
        assert image.actual_torque[X] == 0.0
        assert rig.event_ids() == []


def test_the_halt_bit_stops_a_drive_in_every_mode() -> None:
    with machine(modes=["cyclic_synchronous_velocity"]) as rig:
        rig.enabled()
        image = rig.image
        image.mode[X], image.target_velocity[X] = DriveMode.CYCLIC_SYNCHRONOUS_VELOCITY, 80.0
        rig.cycle(200)
        assert image.actual_velocity[X] == pytest.approx(80.0, rel=0.01)
        image.halt[X] = True
        rig.cycle(100)
        assert not rig.simulated.drives[1].moving
        assert rig.simulated.drives[1].state is ENABLED


def test_a_mode_that_the_drive_does_not_have_is_refused_at_start() -> None:
    with machine(modes=["profile_torque"]) as rig:
        rig.simulated.power_on(0.0)
        rig.simulated.drives[1].values[cia402.SUPPORTED_MODES, 0] = 0x180
        with pytest.raises(Exception, match="does not know the profile torque mode"):
            rig.master.start()


def test_a_mode_that_is_not_shown_is_told_and_the_axis_stays_where_it_is() -> None:
    with machine(modes=["profile_velocity"]) as rig:
        rig.enabled()
        drive, image = rig.simulated.drives[1], rig.image
        drive._enter_mode = lambda: None  # type: ignore[method-assign]
        image.mode[X], image.target_velocity[X] = DriveMode.PROFILE_VELOCITY, 50.0
        rig.cycle(1100)
        assert rig.event_ids() == [catalogue.MODE_NOT_SHOWN.id]
        assert image.by_drive[X]
        assert not drive.moving


# -- feed-forward, torque, inputs ------------------------------------------------------------------------------------


def test_feed_forward_is_velocity_and_acceleration_of_the_set_points() -> None:
    with machine(velocity_feed_forward=1.0, torque_feed_forward=0.0005) as rig:
        rig.enabled()
        drive, image = rig.simulated.drives[1], rig.image
        speeds, torques = [], []
        for k in range(200):  # 1 m/s²
            image.target_position[X] = 0.5 * 1000.0 * (k * 0.001) ** 2
            rig.cycle()
            speeds.append(drive.values[cia402.VELOCITY_OFFSET, 0] / 10_000)
            torques.append(drive.values[cia402.TORQUE_OFFSET, 0] / 1000)
        assert speeds[150] == pytest.approx(149.5, abs=0.1)
        assert torques[150] == pytest.approx(0.5, abs=0.02)
        image.enable[X] = False
        rig.cycle(3)
        assert drive.values[cia402.VELOCITY_OFFSET, 0] == 0


def test_following_error_and_torque_come_in_one_frame_beside_the_plain_ones() -> None:
    with machine(process_data=["following_error", "torque"]) as rig:
        rig.enabled()
        image, drive = rig.image, rig.simulated.drives[1]
        before = image.frames_received
        rig.cycle(50)
        assert (
            image.frames_received - before <= 50 * 6 + 20
        )  # 4 drives, position of the spindle, one more; heartbeats, inputs
        torques, lags = set(), set()
        for k in range(50):
            image.target_position[X] = 0.001 * k * k
            told = drive.values[cia402.FOLLOWING_ERROR, 0], drive.values[cia402.TORQUE_ACTUAL, 0]
            rig.master.read()
            assert (image.drive_lag[X], image.actual_torque[X]) == (told[0] / 10_000, told[1] / 1000)
            rig.cycle()
            torques.add(told[1])
            lags.add(told[0])
        assert len(torques) > 10
        assert len(lags) > 10


def test_a_torque_limit_holds_the_motor_back() -> None:
    with machine(process_data=["torque_limit", "torque"], max_torque=2.0, torque_limits=[1.5, 1.2]) as rig:
        rig.enabled()
        drive, image = rig.simulated.drives[1], rig.image
        assert drive.values[cia402.MAX_TORQUE, 0] == 2000
        assert drive.values[cia402.POSITIVE_TORQUE_LIMIT, 0] == 1500
        assert drive.values[cia402.NEGATIVE_TORQUE_LIMIT, 0] == 1200
        image.torque_limit[X] = 0.05
        greatest = 0.0
        for k in range(100):
            image.target_position[X] = 0.02 * k
            rig.cycle()
            greatest = max(greatest, abs(float(image.actual_torque[X])))
        assert drive.values[cia402.MAX_TORQUE, 0] == 50
        assert greatest == pytest.approx(0.05, abs=0.001)
        image.torque_limit[X] = 9.0  # more than the drive may
        rig.cycle(2)
        assert drive.values[cia402.MAX_TORQUE, 0] == 2000


def test_inputs_of_a_drive_stand_behind_those_of_the_io_nodes() -> None:
    with machine(inputs={2: "home_x", 17: "touched"}, simulated={"home_switch": [-100, 5]}) as rig:
        rig.enabled()
        first = sum(len(io.inputs) for io in rig.machine.fieldbus.io)

        def bits() -> tuple[int, int]:
            value = int.from_bytes(rig.image.digital_in.tobytes(), "little") >> first
            return value & 1, value >> 1 & 1

        rig.cycle(5)
        assert bits() == (1, 0)
        assert rig.image.drive_inputs[X] == cia402.HOME_SWITCH_BIT
        follow(rig, 20.0, 400)
        rig.cycle(20)
        assert bits() == (0, 0)
        follow(rig, -20.0, 400)
        rig.cycle(20)
        assert bits() == (1, 0)
        rig.simulated.inject(1, Fault.SILENT)
        rig.cycle(400)
        assert bits() == (0, 0)  # of a lost node


# -- homing ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("method", "found"),
    [(21, -5.0), (17, -14.0), (35, 0.3), (37, 0.3), (33, 0.0), (34, 2.0), (1, -12.0), (5, -4.0)],
)
def test_the_drive_homes_and_counts_from_its_reference(method: int, found: float) -> None:
    """`found`: where the reference is, in mm of the encoder; the axis then stands as far from its position (2 mm)."""
    simulated = {"home_switch": [-10, -5], "limits": [-14, 700], "index_distance": 2}
    with machine({"method": method}, simulated=simulated) as rig:
        image, drive = rig.image, rig.simulated.drives[1]
        drive.servo.position = 3000.0  # 0.3 mm
        rig.enabled()
        image.homing_request[X] = True
        rig.cycle(2)
        assert image.by_drive[X]
        jumps = []
        while image.homing_state[X] != HomingState.DONE:
            assert image.homing_state[X] == HomingState.RUNNING
            before = float(drive.servo.position)
            rig.cycle()
            jumps.append(abs(drive.servo.position - before))
            image.target_position[X] = image.actual_position[X]  # as the supervision tracks it
            assert rig.time < 20.0
        assert (
            max(jumps) <= 50.0 * 10_000 * 0.001 * 1.2
        )  # never faster than the search speed, also at the change of modes
        place = drive.servo.position / 10_000
        assert image.actual_position[X] == pytest.approx(2.0 + place - found, abs=0.12)
        assert image.mode_shown[X] == DriveMode.CYCLIC_SYNCHRONOUS_POSITION
        assert not image.by_drive[X]
        image.homing_request[X] = False
        rig.cycle(5)
        assert image.homing_state[X] == HomingState.IDLE
        begin = float(image.target_position[X])
        follow(rig, 5.0, 200)
        rig.cycle(50)
        assert image.actual_position[X] == pytest.approx(begin + 5.0, abs=1e-3)
        assert drive.servo.position / 10_000 == pytest.approx(place + 5.0, abs=0.01)
        assert rig.event_ids() == []


def homing_rig(method: int = 21, **simulated: Any) -> Rig:
    return machine({"method": method}, simulated={"home_switch": [-15, -8], "limits": [-20, 700]} | simulated)


def test_an_unknown_method_is_a_homing_error_and_the_axis_stands() -> None:
    with homing_rig(-3) as rig:
        rig.enabled()
        rig.image.homing_request[X] = True
        assert rig.run_until(lambda: rig.image.homing_state[X] == HomingState.FAILED)
        assert not rig.simulated.drives[1].moving
        assert rig.image.state[X] == ENABLED
        assert not rig.image.by_drive[X]


def test_a_request_that_is_taken_back_brakes() -> None:
    with homing_rig() as rig:
        rig.enabled()
        image = rig.image
        image.homing_request[X] = True
        rig.cycle(60)
        assert image.actual_velocity[X] < -10.0
        image.homing_request[X] = False
        rig.cycle(2)
        assert image.homing_state[X] == HomingState.STOPPING
        assert rig.run_until(lambda: image.homing_state[X] == HomingState.IDLE)
        assert abs(image.actual_velocity[X]) < 0.1
        assert image.mode_shown[X] == DriveMode.CYCLIC_SYNCHRONOUS_POSITION
        assert not image.by_drive[X]


def test_halt_interrupts_homing_and_lets_it_go_on() -> None:
    with homing_rig() as rig:
        rig.enabled()
        image = rig.image
        image.homing_request[X] = True
        rig.cycle(60)
        image.halt[X] = True
        rig.cycle(300)
        assert not rig.simulated.drives[1].moving
        assert image.homing_state[X] == HomingState.RUNNING
        image.halt[X] = False
        assert rig.run_until(lambda: image.homing_state[X] == HomingState.DONE, 5.0)


def test_a_drive_fault_in_homing_fails_it() -> None:
    with homing_rig() as rig:
        rig.enabled()
        image = rig.image
        image.homing_request[X] = True
        rig.cycle(60)
        rig.simulated.inject(1, Fault.DRIVE, 0x8611)
        rig.cycle(200)
        assert image.homing_state[X] == HomingState.FAILED
        assert image.state[X] == DriveState.FAULT
        assert rig.event_ids()[-1] == catalogue.DRIVE_FAULT.id
        assert not rig.simulated.drives[1].moving
        image.homing_request[X] = image.enable[X] = False
        image.reset_fault[X] = True
        rig.cycle(50)
        image.target_position[X] = image.actual_position[X]
        image.enable[X] = True
        rig.cycle(50)
        assert image.state[X] == ENABLED
        assert not image.by_drive[X]


def test_a_disabled_drive_does_not_home() -> None:
    with homing_rig() as rig:
        rig.started()
        rig.image.homing_request[X] = True
        rig.cycle(3)
        assert rig.image.homing_state[X] == HomingState.FAILED
        rig.image.homing_request[X] = False
        rig.cycle(2)
        assert rig.image.homing_state[X] == HomingState.IDLE


def test_a_drive_without_homing_mode_is_refused_at_start() -> None:
    with homing_rig() as rig:
        rig.simulated.power_on(0.0)
        rig.simulated.drives[1].values[cia402.SUPPORTED_MODES, 0] = 0x80
        with pytest.raises(Exception, match="does not know the homing mode"):
            rig.master.start()


# -- touch probes ----------------------------------------------------------------------------------------------------


def test_the_probe_latches_the_place_of_the_edge_and_not_of_a_cycle() -> None:
    """At 200 mm/s a cycle is 0.2 mm; the latched position is exact."""
    with machine(process_data=["probe_1_rising", "probe_1_falling"], simulated={"probe": 12.3456}) as rig:
        rig.enabled()
        image = rig.image
        image.origin[X] += 1.0
        image.target_position[X] += 1.0  # the axis counts otherwise than the drive
        rig.cycle(3)
        image.probe_function[X] = drives.PROBE_ON | drives.PROBE_RISING | drives.PROBE_FALLING
        rig.cycle(3)
        assert image.probe_status[X] == drives.PROBE_IS_ON
        follow(rig, 30.0, 300)
        rig.cycle(20)
        assert image.probe_status[X] & drives.PROBE_HAS_RISEN
        assert not image.probe_status[X] & drives.PROBE_HAS_FALLEN
        assert image.probe_position[X, 0] == pytest.approx(13.3456, abs=1e-4)
        follow(rig, -30.0, 300)
        rig.cycle(20)
        assert image.probe_status[X] & drives.PROBE_HAS_FALLEN
        assert image.probe_position[X, 1] == pytest.approx(13.3456, abs=1e-4)
        image.probe_function[X] = 0
        rig.cycle(150)
        assert image.probe_status[X] == 0


ALL_PROBES = ["probe_1_falling", "probe_1_rising", "probe_2_rising", "probe_2_falling"]


def test_more_process_data_than_the_predefined_pdos_carry() -> None:
    """Beyond the fourth, a PDO gets an identifier that CiA 301 gives to nobody, another one in every node."""
    description = demo_description()
    description["axes"][X]["drive"] |= {"process_data": ALL_PROBES, "simulated": {"probe": 3.5}}
    description["axes"][Y]["drive"] |= {"process_data": [*ALL_PROBES, "torque"], "modes": ["profile_velocity"]}
    with Rig(description) as rig:
        rig.enabled()
        ids = [link.plan(Direction.TRANSMIT, 5).cob_id(link.node) for link in rig.master._drives[:2]]  # type: ignore[union-attr]
        assert ids == [0x680, 0x681]
        assert [rig.simulated.drives[node]._number(0x1804, 1) & 0x7FF for node in (1, 2)] == ids
        rig.image.probe_function[X] = drives.PROBE_ON | drives.PROBE_RISING
        follow(rig, 10.0, 300)
        assert rig.image.probe_position[X, 0] == pytest.approx(3.5, abs=1e-4)
        # the fifth comes too: that of probe 2, which is told here by hand
        rig.simulated.drives[1].motion.probes[1].positions[1] = 4.25 * 10_000
        rig.cycle(3)
        assert rig.image.probe_position[X, 3] == pytest.approx(4.25, abs=1e-4)
        assert rig.event_ids() == []


def test_a_pdo_that_a_device_has_beyond_the_fourth_and_nobody_uses_is_switched_off() -> None:
    with machine() as rig:
        drive = rig.simulated.drives[1]
        rig.idle()
        drive.local.data_store.setdefault(0x1804, {})[1] = (0x333).to_bytes(4, "little")
        boots = drive._boot
        drive._boot = lambda: (boots(), drive.local.data_store.setdefault(0x1804, {}).update({1: b"\x33\x03\0\0"}))  # type: ignore[method-assign,assignment]
        rig.started()
        assert drive._number(0x1804, 1) == 0x8000_0333


def test_there_are_no_more_identifiers_than_ninety_six() -> None:
    given, plans = CobIds(), tuple(PdoPlan(Direction.TRANSMIT, number, ()) for number in range(1, 101))
    assert given.given(plans, None, 1, "axis X")[99].cob_id(1) == 0x6DF
    assert given.given(plans[:8], "second", 1, "axis X")[4].cob_id(1) == 0x680  # another bus
    with pytest.raises(FieldbusError, match=r"303029.*no more than 96"):
        given.given(plans[:5], None, 2, "axis Y")


# -- units -----------------------------------------------------------------------------------------------------------


def test_the_factor_group_is_written() -> None:
    transmission = {"encoder": [131072, 1], "gear": [3, 1], "feed": "10 mm", "objects": "write"}
    with machine(transmission=transmission) as rig:
        rig.started()
        node = rig.simulated.drives[1]
        assert [node._number(0x608F, sub) for sub in (1, 2)] == [131072, 1]
        assert [node._number(0x6091, sub) for sub in (1, 2)] == [3, 1]
        assert [node._number(0x6092, sub) for sub in (1, 2)] == [100_000, 1]


def test_a_drive_that_counts_otherwise_is_refused() -> None:
    gear = {"gear": [3, 1], "feed": 10}
    with machine(transmission=gear) as rig, pytest.raises(Exception, match="0x6091 is 1:1, expected is 3:1"):
        rig.master.start()


def test_a_ratio_may_be_told_in_other_numbers() -> None:
    gear = Part(cia402.GEAR_RATIO, 2, 4)
    assert gear.agrees(1, 2)
    assert not gear.agrees(2, 1)
    assert not gear.agrees(1, 0)


def test_units_that_are_no_whole_numbers_are_refused() -> None:
    feed = {"feed": math.e, "objects": "write"}
    with (
        machine(increments_per_unit=math.pi, transmission=feed) as rig,
        pytest.raises(Exception, match="no ratio of whole"),
    ):
        rig.master.start()


# -- reactions -------------------------------------------------------------------------------------------------------


def test_option_codes_are_written() -> None:
    reactions = {"quick_stop": 6, "shutdown": 0, "disable": 0, "halt": 2, "fault": 1, "connection": 3}
    with machine(reactions=reactions, window=0.5, window_time="20 ms") as rig:
        rig.started()
        parameters = rig.simulated.drives[1].parameters
        codes = [parameters[index] for index in (0x605A, 0x605B, 0x605C, 0x605D, 0x605E, 0x6007)]
        assert codes == [6, 0, 0, 2, 1, 3]
        assert parameters[0x6065] == 5000
        assert parameters[0x6066] == 20


def test_an_sdo_abort_in_the_configuration_names_the_object() -> None:
    with machine(reactions={"quick_stop": 6}) as rig:
        find_variable(rig.simulated.drives[1].local.object_dictionary, 0x605A).max = 4
        with pytest.raises(Exception, match=r"node 1 \(axis X\) refuses to write object 0x605A: .*0x06090031"):
            rig.master.start()
