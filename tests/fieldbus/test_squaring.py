"""An axis whose two drives home by themselves: each end stops at its own reference, and then the axis is square."""

from __future__ import annotations

from typing import Any

import pytest

from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.drives import DriveMode, DriveState, HomingState
from runtime.fieldbus import cia402
from runtime.fieldbus.simulator import Fault
from runtime.fieldbus.squaring import Squaring
from tests.fieldbus.rig import Rig, demo_description

Y, FIRST, SECOND = 1, 2, 20
SCALES = {FIRST: 10_000, SECOND: 5_000}
LIMIT = 0.5
ENABLED = DriveState.OPERATION_ENABLED


def gantry(first: float = -5.0, second: float = -4.7, *, homing: dict[str, Any] | None = None, **settings: Any) -> Rig:
    """Y with two drives that home off the positive end of a switch, which stands there, mm of the encoder."""
    description = demo_description()
    axis = description["axes"][Y]
    axis["homing"] = {"method": 21, "fast": 50, "slow": 5, "position": 2.0} | (homing or {})
    axis["drive"]["simulated"] = {"home_switch": [-40, first]}
    axis["drive"]["gantry"] = {
        "node": SECOND,
        "increments_per_unit": SCALES[SECOND],
        "difference": LIMIT,
        "simulated": {"home_switch": [-40, second]},
    } | settings
    return Rig(description)


def place(rig: Rig, node: int) -> float:
    """mm of the encoder since power-on."""
    return rig.simulated.drives[node].servo.position / SCALES[node]


def apart(rig: Rig) -> float:
    return place(rig, SECOND) - place(rig, FIRST)


def track(rig: Rig) -> None:
    """A cycle; what the supervision does with an axis that its drive moves."""
    rig.cycle()
    if rig.image.by_drive[Y] or rig.image.state[Y] != ENABLED:
        rig.image.target_position[Y] = rig.image.actual_position[Y]


def home(rig: Rig, until: HomingState = HomingState.DONE) -> float:
    """The greatest distance between the ends on the way."""
    rig.image.homing_request[Y] = True
    worst, end = 0.0, rig.time + 20.0
    while rig.image.homing_state[Y] != until or rig.image.by_drive[Y]:
        assert rig.time < end, HomingState(int(rig.image.homing_state[Y]))
        track(rig)
        worst = max(worst, abs(apart(rig)))
    return worst


def go(rig: Rig, way: float, cycles: int) -> None:
    begin = float(rig.image.target_position[Y])
    for k in range(cycles):
        rig.image.target_position[Y] = begin + way * (k + 1) / cycles
        rig.cycle()


@pytest.mark.parametrize(("second", "offset"), [(-4.7, 0.0), (-5.3, 0.0), (-5.0, 0.0), (-4.9, 0.3), (-5.1, -0.3)])
def test_each_end_stops_at_its_own_reference_and_the_axis_is_square(second: float, offset: float) -> None:
    with gantry(second=second, offset=offset) as rig:
        rig.enabled()
        worst = home(rig)
        # both have braked from the slow speed behind their references, and nothing has gone further apart than these are
        assert worst <= abs(second + 5.0) + 0.1
        assert apart(rig) == pytest.approx(second + 5.0, abs=0.06)
        rig.image.homing_request[Y] = False
        moved, before = 0.0, place(rig, SECOND)
        for _ in range(2500):  # what is not square by then is taken away slowly
            rig.cycle()
            moved = max(moved, abs(place(rig, SECOND) - before))
            before = place(rig, SECOND)
        assert moved < 0.001
        assert rig.image.homing_state[Y] == HomingState.IDLE
        assert apart(rig) == pytest.approx(second + 5.0 + offset, abs=2e-3)
        # the reference of the first end is 2 mm of the axis
        assert rig.image.actual_position[Y] == pytest.approx(2.0 + place(rig, FIRST) + 5.0, abs=0.1)
        go(rig, 60.0, 600)
        rig.cycle(200)
        assert apart(rig) == pytest.approx(second + 5.0 + offset, abs=2e-3)
        assert rig.event_ids() == []
        for node in (FIRST, SECOND):
            assert rig.simulated.drives[node].mode == DriveMode.CYCLIC_SYNCHRONOUS_POSITION


def test_the_end_that_is_there_first_holds_its_place_for_the_other() -> None:
    with gantry(second=-4.6) as rig:
        rig.enabled()
        rig.image.homing_request[Y] = True
        first = rig.simulated.drives[FIRST]
        assert rig.run_until(lambda: bool(first.mode == DriveMode.HOMING), 1.0)
        rig.simulated.drives[SECOND].homing_speeds[1] = 2500  # it leaves its switch at 0.5 mm/s
        while first.mode == DriveMode.HOMING:
            track(rig)
        # it waits in its own mode
        targets = []
        for _ in range(300):
            track(rig)
            assert rig.image.homing_state[Y] == HomingState.RUNNING
            assert rig.image.by_drive[Y]
            targets.append(first.values[cia402.TARGET_POSITION, 0])
        assert len(set(targets[3:])) == 1
        home(rig)


def test_both_begin_in_the_same_cycle_however_late_one_changes_its_mode() -> None:
    with gantry() as rig:
        rig.enabled()
        second = rig.simulated.drives[SECOND]
        real = second._enter_mode
        second._enter_mode = lambda: None  # type: ignore[method-assign]
        rig.image.homing_request[Y] = True
        for _ in range(100):
            track(rig)
        assert rig.simulated.drives[FIRST].mode == DriveMode.HOMING
        assert abs(place(rig, FIRST)) < 1e-3
        second._enter_mode = real  # type: ignore[method-assign]
        words = set()
        for _ in range(20):
            track(rig)
            words.add(tuple(rig.simulated.drives[n].controlword & cia402.NEW_SET_POINT for n in (FIRST, SECOND)))
        assert words == {(0, 0), (cia402.NEW_SET_POINT, cia402.NEW_SET_POINT)}


def test_references_that_are_too_far_apart_stop_both_ends() -> None:
    with gantry(second=-7.0) as rig:
        rig.enabled()
        worst = home(rig, HomingState.FAILED)
        rig.image.homing_request[Y] = False
        for _ in range(300):
            track(rig)
            worst = max(worst, abs(apart(rig)))
        assert rig.event_ids() == [catalogue.GANTRY_SKEWED.id]
        assert "axis Y" in rig.problems()[0].text
        # beyond the limit by what the drives need to see it, and to stop from the search speed
        assert worst < LIMIT + 0.5
        assert rig.image.homing_state[Y] == HomingState.IDLE
        # how far the ends are apart is not forgotten: they go slowly back to how they stood before
        assert abs(apart(rig)) > LIMIT
        before, fastest = apart(rig), 0.0
        for _ in range(4500):
            track(rig)
            fastest = max(fastest, abs(apart(rig) - before))
            before = apart(rig)
        assert fastest < 0.001
        assert apart(rig) == pytest.approx(0.0, abs=2e-3)


@pytest.mark.parametrize("node", [FIRST, SECOND])
def test_an_error_of_one_end_stops_the_other(node: int) -> None:
    with gantry() as rig:
        rig.enabled()
        rig.image.homing_request[Y] = True
        for _ in range(60):
            track(rig)
        rig.simulated.drives[node].motion.homing.error = True
        rig.simulated.drives[node].motion.homing.running = False
        home(rig, HomingState.FAILED)
        stands = place(rig, FIRST), place(rig, SECOND)
        rig.image.homing_request[Y] = False
        for _ in range(300):
            track(rig)
        assert (place(rig, FIRST), place(rig, SECOND)) == pytest.approx(stands, abs=LIMIT)
        assert rig.image.homing_state[Y] == HomingState.IDLE
        assert rig.image.state[Y] == ENABLED
        assert home(rig) <= LIMIT  # it may be tried again
        assert apart(rig) == pytest.approx(0.3, abs=0.06)


@pytest.mark.parametrize("node", [FIRST, SECOND])
def test_a_drive_fault_of_one_end_stops_the_other(node: int) -> None:
    with gantry() as rig:
        rig.enabled()
        rig.image.homing_request[Y] = True
        for _ in range(60):
            track(rig)
        rig.simulated.inject(node, Fault.DRIVE, 0x2310)
        for _ in range(300):
            track(rig)
        assert catalogue.DRIVE_FAULT.id in rig.event_ids()
        assert rig.image.homing_state[Y] == HomingState.FAILED
        assert all(not rig.simulated.drives[n].moving for n in (FIRST, SECOND))
        assert abs(apart(rig)) < LIMIT


def test_halt_stops_both_ends_and_lets_them_go_on() -> None:
    with gantry(first=-20.0, second=-19.8) as rig:
        rig.enabled()
        rig.image.homing_request[Y] = True
        for _ in range(150):
            track(rig)
        rig.image.halt[Y] = True
        for _ in range(200):
            track(rig)
        stands = place(rig, FIRST), place(rig, SECOND)
        for _ in range(200):
            track(rig)
        assert (place(rig, FIRST), place(rig, SECOND)) == pytest.approx(stands, abs=1e-3)
        assert rig.image.homing_state[Y] == HomingState.RUNNING
        rig.image.halt[Y] = False
        home(rig)
        assert apart(rig) == pytest.approx(0.2, abs=0.06)


def test_a_homing_that_is_taken_back_keeps_the_difference() -> None:
    with gantry(first=-20.0, second=-20.0) as rig:
        rig.simulated.drives[SECOND].servo.position = 100.0 * SCALES[SECOND]
        rig.enabled()
        rig.image.homing_request[Y] = True
        for _ in range(150):
            track(rig)
        rig.image.homing_request[Y] = False
        end = rig.time + 5.0
        while rig.image.by_drive[Y] or rig.image.homing_state[Y] != HomingState.IDLE:
            assert rig.time < end
            track(rig)
        go(rig, 5.0, 100)
        rig.cycle(200)
        assert apart(rig) == pytest.approx(100.0, abs=2e-3)
        assert rig.event_ids() == []


def test_an_offset_beyond_the_allowed_difference_is_refused() -> None:
    with pytest.raises(Exception, match="`offset` is greater than `difference`"):
        gantry(offset=0.6)


class End:
    def __init__(self, at: float) -> None:
        self.place, self.by_drive, self.homing, self.homing_error = at, True, HomingState.RUNNING, False


def test_an_end_that_begins_to_count_anew_has_gone_no_way() -> None:
    """The ways: +0.05, +0.05, a count of -300 (a way of 0.05 stands for it), +0.05; the other end stands."""
    squaring = Squaring(LIMIT, 0.0, 50.0)
    first, second = End(10.0), End(30.2)
    assert squaring.step(True, first, second, 20.0) == 20.0
    assert squaring.skew == pytest.approx(0.2)
    for way in (0.05, 0.05, -300.0, 0.05):
        squaring.went(False, way, 0.1)
        squaring.went(True, 0.0, 0.1)
    assert squaring.skew == pytest.approx(0.0)
    # it fails, both stand, and the offset is such that the difference is still there
    first.homing = HomingState.FAILED
    first.place, second.place = -289.8, 30.2
    assert squaring.step(True, first, second, 20.0) == 20.0
    assert squaring.state == HomingState.FAILED
    assert not squaring.wanted
    first.by_drive = second.by_drive = False
    offset = squaring.step(True, first, second, 20.0)
    assert second.place - first.place - offset == pytest.approx(0.0)
    squaring.step(False, first, second, offset)
    assert squaring.state.name == "IDLE"
