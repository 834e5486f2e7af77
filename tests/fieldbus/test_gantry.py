"""An axis with a drive at each end: coupled, enabled without a jump, stopped when the ends are apart or one fails."""

from __future__ import annotations

from typing import Any

import pytest

from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.drives import DriveState
from runtime.fieldbus.simulator import Fault
from tests.fieldbus.rig import Rig, demo_description

Y, FIRST, SECOND = 1, 2, 20
ENABLED = DriveState.OPERATION_ENABLED
SCALES = {FIRST: 10_000, SECOND: 5_000}


def gantry(first: float = 0.0, second: float = 0.0, **settings: Any) -> Rig:
    """Y has two drives that stand at these places, mm."""
    description = demo_description()
    axis = description["axes"][Y]
    axis["drive"] |= {"gantry": {"node": SECOND, "increments_per_unit": 5000, "difference": 0.5} | settings}
    rig = Rig(description)
    for node, place in ((FIRST, first), (SECOND, second)):
        rig.simulated.drives[node].servo.position = place * SCALES[node]
    return rig


def place(rig: Rig, node: int) -> float:
    return rig.simulated.drives[node].servo.position / SCALES[node]


def run(rig: Rig, way: float, cycles: int) -> None:
    begin = float(rig.image.target_position[Y])
    for k in range(cycles):
        rig.image.target_position[Y] = begin + way * (k + 1) / cycles
        rig.cycle()


def take_over(rig: Rig) -> None:
    """What the supervision does with a drive that is not enabled."""
    rig.image.enable[Y] = False
    rig.cycle(100)
    rig.image.target_position[Y] = rig.image.actual_position[Y]
    rig.image.enable[:] = True
    assert rig.run_until(lambda: rig.image.state[Y] == ENABLED)


def test_both_ends_follow_the_axis() -> None:
    with gantry(first=3.0, second=103.0) as rig:
        rig.started()
        take_over(rig)
        assert rig.image.target_position[Y] == pytest.approx(3.0)
        run(rig, 40.0, 400)
        assert place(rig, FIRST) - 3.0 == pytest.approx(40.0, abs=0.5)
        assert place(rig, SECOND) - place(rig, FIRST) == pytest.approx(100.0, abs=0.001)
        rig.cycle(100)
        assert place(rig, SECOND) == pytest.approx(143.0, abs=0.001)
        assert rig.event_ids() == []


def test_the_axis_is_enabled_when_both_ends_are() -> None:
    with gantry() as rig:
        rig.started()
        second = rig.simulated.drives[SECOND]
        second.set_points_taken = lambda: None  # type: ignore[method-assign]
        rig.image.enable[Y] = True
        rig.cycle(50)
        assert rig.simulated.drives[FIRST].state is ENABLED
        assert rig.image.state[Y] == DriveState.SWITCH_ON_DISABLED
        rig.image.target_position[Y] = 5.0
        rig.cycle(50)
        assert place(rig, FIRST) == pytest.approx(0.0)


def test_enabling_moves_neither_end_at_once_and_squares_the_axis_slowly() -> None:
    with gantry(second=0.3, offset=0.0) as rig:
        rig.started()
        take_over(rig)
        rig.cycle(10)
        assert place(rig, SECOND) == pytest.approx(0.3, abs=0.01)
        before, fastest = place(rig, SECOND), 0.0
        for _ in range(1200):
            rig.cycle()
            fastest = max(fastest, abs(place(rig, SECOND) - before))
            before = place(rig, SECOND)
        assert place(rig, SECOND) == pytest.approx(0.0, abs=0.001)
        assert fastest < 0.001  # mm per cycle
        assert rig.event_ids() == []


def test_ends_that_are_too_far_apart_are_not_enabled() -> None:
    with gantry(second=0.7, offset=0.0) as rig:
        rig.started()
        rig.image.enable[Y] = True
        rig.cycle(200)
        assert rig.image.state[Y] == DriveState.SWITCH_ON_DISABLED
        assert rig.event_ids() == []  # nothing has happened: it is refused, and told when the axis is judged


def test_an_end_that_is_held_back_stops_the_axis() -> None:
    with gantry() as rig:
        rig.started()
        take_over(rig)
        rig.simulated.inject(SECOND, Fault.FOLLOWING_ERROR)
        run(rig, 1.5, 150)
        assert rig.event_ids()[0] == catalogue.GANTRY_SKEWED.id
        assert rig.event_ids().count(catalogue.GANTRY_SKEWED.id) == 1
        assert "axis Y" in rig.problems()[0].text
        assert rig.image.state[Y] != ENABLED  # at twice the difference both drives have braked by themselves
        rig.cycle(300)
        assert abs(place(rig, FIRST) - place(rig, SECOND)) < 1.3


@pytest.mark.parametrize("node", [FIRST, SECOND])
def test_a_fault_of_one_end_stops_the_other(node: int) -> None:
    with gantry() as rig:
        rig.started()
        take_over(rig)
        run(rig, 20.0, 100)
        rig.simulated.inject(node, Fault.DRIVE, 0x2310)
        for k in range(60):
            rig.image.target_position[Y] = 20.0 + 0.2 * (k + 1)
            rig.cycle()
        rig.cycle(300)
        assert catalogue.DRIVE_FAULT.id in rig.event_ids()
        assert rig.image.state[Y] == DriveState.FAULT
        other = rig.simulated.drives[SECOND if node == FIRST else FIRST]
        assert 11 in other.transitions[-3:]
        assert not other.moving
        assert abs(place(rig, FIRST) - place(rig, SECOND)) < 1.0


@pytest.mark.parametrize("node", [FIRST, SECOND])
def test_a_lost_end_stops_the_other_and_comes_back(node: int) -> None:
    with gantry() as rig:
        rig.started()
        take_over(rig)
        rig.simulated.inject(node, Fault.SILENT)
        rig.cycle(400)
        assert rig.image.state[Y] == DriveState.OFFLINE
        other = rig.simulated.drives[SECOND if node == FIRST else FIRST]
        assert other.state is not ENABLED
        rig.simulated.heal(node)
        rig.image.enable[Y] = False
        assert rig.run_until(
            lambda: rig.image.state[Y] == DriveState.FAULT, 5.0
        )  # it has missed the master's heartbeat
        rig.image.reset_fault[Y] = True
        assert rig.run_until(lambda: rig.image.state[Y] == DriveState.SWITCH_ON_DISABLED, 1.0)
        rig.image.reset_fault[Y] = False
        take_over(rig)
        run(rig, 5.0, 100)
        rig.cycle(50)
        assert place(rig, SECOND) == pytest.approx(place(rig, FIRST), abs=0.001)


def test_a_node_of_a_gantry_is_used_once() -> None:
    with pytest.raises(Exception, match="node"):
        gantry(node=FIRST)
