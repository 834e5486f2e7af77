"""How a drive comes to rest, by its option codes, and what the master orders meanwhile: every way, over the real protocol."""

from __future__ import annotations

from typing import Any

import pytest

from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.drives import DriveState
from runtime.fieldbus.simulator import Fault
from tests.fieldbus.rig import Rig, demo_description

X, NODE = 0, 1
ENABLED = DriveState.OPERATION_ENABLED
SLOW, QUICK = 4_000_000, 16_000_000  # ramps, increments/s²: 400 and 1600 mm/s²


def moving(**reactions: int) -> Rig:
    """X moves with 200 mm/s."""
    description = demo_description()
    sdo = {"0x6084": SLOW, "0x6085": QUICK}
    description["axes"][X]["drive"] |= {"reactions": reactions, "sdo": sdo}
    rig = Rig(description)
    rig.enabled()
    for k in range(60):
        rig.image.target_position[X] = 0.2 * k
        rig.cycle()
    return rig


def time_to_rest(rig: Rig) -> float:
    """ms until the motor stands; one that coasts takes longer than is waited for."""
    begin = rig.time
    rig.run_until(lambda: not rig.simulated.drives[NODE].moving, 1.1)
    return (rig.time - begin) * 1000.0


RAMP = {1: 500.0, 2: 125.0, 3: 12.5, 4: 12.5}  # ms from 200 mm/s
COASTS = 1000.0


@pytest.mark.parametrize("code", range(9))
def test_quick_stop(code: int) -> None:
    with moving(quick_stop=code) as rig:
        drive, image = rig.simulated.drives[NODE], rig.image
        image.quick_stop[X] = True
        time = time_to_rest(rig)
        if code == 0:
            assert time > COASTS
        else:
            assert time == pytest.approx(RAMP[code - 4 if code > 4 else code], rel=0.05, abs=8.0)
        assert 11 in drive.transitions
        rig.cycle(30)
        if code < 5:
            assert image.state[X] == DriveState.SWITCH_ON_DISABLED
            assert drive.transitions[-1] == 12
            return
        assert image.state[X] == DriveState.QUICK_STOP_ACTIVE
        rig.cycle(100)
        image.target_position[X] = image.actual_position[X]
        image.quick_stop[X] = False  # transition 16: on from where it stands
        rig.cycle(5)
        assert image.state[X] == ENABLED
        assert drive.transitions[-1] == 16
        before = drive.servo.position
        rig.cycle(50)
        assert drive.servo.position == pytest.approx(before, abs=2.0)
        assert rig.event_ids() == []


def test_a_drive_that_stays_after_a_quick_stop_is_disabled_when_it_stands() -> None:
    with moving(quick_stop=6) as rig:
        drive, image = rig.simulated.drives[NODE], rig.image
        image.quick_stop[X] = True
        rig.cycle(5)
        image.enable[X] = image.quick_stop[X] = False
        rig.cycle(100)
        assert image.state[X] == DriveState.QUICK_STOP_ACTIVE  # it brakes, and nothing interrupts it
        assert drive.moving
        assert rig.run_until(lambda: image.state[X] == DriveState.SWITCH_ON_DISABLED)
        assert drive.transitions[-1] == 12
        assert not drive.moving


@pytest.mark.parametrize("code", [0, 1])
def test_disable_operation(code: int) -> None:
    with moving(disable=code) as rig:
        rig.image.enable[X] = False
        rig.cycle(3)
        drive = rig.simulated.drives[NODE]
        assert (drive.state is ENABLED) is bool(code)
        time = time_to_rest(rig)
        assert time == pytest.approx(RAMP[1], rel=0.05) if code else time > COASTS
        rig.cycle(10)
        assert drive.transitions[-3:] == [5, 6, 7]


@pytest.mark.parametrize("code", range(5))
def test_fault_reaction(code: int) -> None:
    with moving(fault=code) as rig:
        rig.simulated.inject(NODE, Fault.DRIVE, 0x2310)
        drive = rig.simulated.drives[NODE]
        assert drive.state is (DriveState.FAULT_REACTION_ACTIVE if code else DriveState.FAULT)
        time = time_to_rest(rig)
        if code == 0:
            assert time > COASTS
        else:
            assert time == pytest.approx(RAMP[code], rel=0.05, abs=8.0)
        rig.cycle(3)
        assert drive.transitions[-2:] == [13, 14]
        assert rig.event_ids() == [catalogue.EMERGENCY.id, catalogue.DRIVE_FAULT.id]


@pytest.mark.parametrize("code", [1, 2, 3])
def test_halt(code: int) -> None:
    with moving(halt=code) as rig:
        drive = rig.simulated.drives[NODE]
        drive.controlword |= 0x100
        taken = drive.set_points_taken

        def halted() -> None:
            taken()
            drive.controlword |= 0x100

        drive.set_points_taken = halted  # type: ignore[method-assign]
        assert time_to_rest(rig) == pytest.approx(RAMP[code], rel=0.05, abs=8.0)
        assert drive.state is ENABLED


@pytest.mark.parametrize(
    ("code", "end", "number"),
    [(1, DriveState.FAULT, 14), (2, DriveState.SWITCH_ON_DISABLED, 9), (3, DriveState.SWITCH_ON_DISABLED, 12)],
)
def test_the_master_falls_silent(code: int, end: DriveState, number: int) -> None:
    with moving(connection=code) as rig:
        rig.master_alive = False
        drive = rig.simulated.drives[NODE]
        assert rig.run_until(lambda: drive.state is end, 3.0)
        assert number in drive.transitions


STATES: dict[DriveState, Any] = {
    DriveState.SWITCH_ON_DISABLED: (False, False),
    ENABLED: (True, False),
    DriveState.QUICK_STOP_ACTIVE: (True, True),
}


@pytest.mark.parametrize("state", STATES)
def test_a_drive_fault_in_each_state_is_told_and_can_be_acknowledged(state: DriveState) -> None:
    with moving(quick_stop=6) as rig:
        drive, image = rig.simulated.drives[NODE], rig.image
        image.enable[X], image.quick_stop[X] = STATES[state]
        rig.cycle(600)
        assert drive.state is state
        image.target_position[X] = image.actual_position[X]
        rig.simulated.inject(NODE, Fault.DRIVE, 0x4310)
        rig.cycle(400)
        assert image.state[X] == DriveState.FAULT
        assert image.fault_code[X] == 0x4310
        assert rig.event_ids() == [catalogue.EMERGENCY.id, catalogue.DRIVE_FAULT.id]
        image.enable[X] = image.quick_stop[X] = False
        image.reset_fault[X] = True
        rig.cycle(20)
        assert image.state[X] == DriveState.SWITCH_ON_DISABLED
        image.reset_fault[X] = False
        image.target_position[X] = image.actual_position[X]
        image.enable[X] = True
        assert rig.run_until(lambda: image.state[X] == ENABLED)
        assert image.fault_code[X] == 0


@pytest.mark.parametrize("word", [0x06, 0x07])
def test_a_drive_fault_on_the_way_to_enabled(word: int) -> None:
    """READY_TO_SWITCH_ON and SWITCHED_ON: the drive is held there by a master that orders no more."""
    with Rig() as rig:
        rig.started()
        drive, image = rig.simulated.drives[NODE], rig.image
        obey = drive._obey
        drive._obey = lambda controlword: obey(min(controlword, word))  # type: ignore[method-assign]
        image.enable[X] = True
        rig.cycle(20)
        held = {0x06: DriveState.READY_TO_SWITCH_ON, 0x07: DriveState.SWITCHED_ON}[word]
        assert image.state[X] == held
        rig.simulated.inject(NODE, Fault.DRIVE, 0x4310)
        rig.cycle(10)
        drive._obey = obey  # type: ignore[method-assign]
        assert rig.event_ids() == [catalogue.EMERGENCY.id, catalogue.DRIVE_FAULT.id]
        assert image.state[X] == DriveState.FAULT
