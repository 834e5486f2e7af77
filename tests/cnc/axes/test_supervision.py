from __future__ import annotations

import numpy as np
import pytest

from runtime.cnc.axes.supervision import FAULT_DRIVE, FAULT_DROPPED, FAULT_LAG, FAULT_OFFLINE, AxisSupervision
from runtime.config import load_machine
from runtime.drives import DriveImage, DriveState

pytestmark = pytest.mark.uncompiled


@pytest.fixture
def image() -> DriveImage:
    return DriveImage(4)


@pytest.fixture
def axes(image: DriveImage) -> AxisSupervision:
    return AxisSupervision(load_machine(None), image)


WANTED = np.ones(4, dtype=np.bool_)


def enable(axes: AxisSupervision) -> None:
    axes.image.state[:] = DriveState.SWITCH_ON_DISABLED
    assert axes.monitor(WANTED) == []
    axes.image.state[:] = DriveState.OPERATION_ENABLED
    assert axes.monitor(WANTED) == []


def test_an_axis_that_is_not_enabled_tracks_its_actual_position(axes: AxisSupervision) -> None:
    axes.image.actual_position[0] = 123.4
    axes.image.state[:] = DriveState.SWITCH_ON_DISABLED
    axes.monitor(WANTED)
    assert axes.image.target_position[0] == 123.4
    assert axes.image.enable.all()


@pytest.mark.parametrize(
    ("state", "kind"),
    [
        (DriveState.FAULT, FAULT_DRIVE),
        (DriveState.FAULT_REACTION_ACTIVE, FAULT_DRIVE),
        (DriveState.OFFLINE, FAULT_OFFLINE),
        (DriveState.SWITCHED_ON, FAULT_DROPPED),
    ],
)
def test_what_a_drive_can_do_wrong_is_told_once_and_disables_it(
    axes: AxisSupervision, state: DriveState, kind: int
) -> None:
    enable(axes)
    axes.image.state[1] = state
    axes.image.fault_code[1] = 0x2310
    (fault,) = axes.monitor(WANTED)
    assert (fault.axis, fault.kind) == (1, kind)
    assert axes.monitor(WANTED) == []
    assert not axes.image.enable[1]
    assert axes.image.enable[0]


def test_following_error_above_the_limit(axes: AxisSupervision) -> None:
    enable(axes)
    axes.image.target_position[2] = 5.1
    (fault,) = axes.monitor(WANTED)
    assert (fault.axis, fault.kind) == (2, FAULT_LAG)
    assert fault.value == pytest.approx(5.1)


def test_a_spindle_has_no_following_error(axes: AxisSupervision) -> None:
    enable(axes)
    axes.image.actual_position[3] = 1e6
    assert axes.monitor(WANTED) == []


def test_reset_gives_the_drives_time_before_they_are_judged_again(axes: AxisSupervision) -> None:
    enable(axes)
    axes.image.state[0] = DriveState.FAULT
    axes.monitor(WANTED)
    axes.reset(3)
    assert axes.image.reset_fault.all()
    for _ in range(3):
        assert axes.monitor(WANTED) == []
    assert not axes.image.reset_fault.any()
    (fault,) = axes.monitor(WANTED)  # the cause is still there
    assert fault.kind == FAULT_DRIVE


def test_reset_does_not_blind_the_axes_that_run(axes: AxisSupervision) -> None:
    enable(axes)
    axes.reset(500)
    assert axes.monitor(WANTED) == []
    assert not axes.image.reset_fault.any()
    axes.image.target_position[1] = 6.0
    (fault,) = axes.monitor(WANTED)
    assert (fault.axis, fault.kind) == (1, FAULT_LAG)


def test_an_axis_reset_at_once_leaves_the_enabled_state_before_it_runs_again(axes: AxisSupervision) -> None:
    enable(axes)
    axes.image.target_position[0] = 6.0
    axes.monitor(WANTED)
    axes.reset(100)
    axes.monitor(WANTED)
    assert not axes.image.enable[0], "its set-point is still 6 mm away from it"
    axes.image.state[0] = DriveState.SWITCHED_ON
    axes.monitor(WANTED)
    assert axes.image.enable[0]
    assert axes.image.target_position[0] == 0.0


def test_a_quick_stop_that_was_ordered_is_no_fault_of_the_drives(axes: AxisSupervision) -> None:
    enable(axes)
    axes.quick_stop()
    axes.image.state[:] = DriveState.QUICK_STOP_ACTIVE
    assert axes.monitor(WANTED) == []
