"""Moving one drive by hand: the law of its set-points, and a session with a simulated drive on the real protocol."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import can
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.diagnostics.catalogue import commissioning as errors
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.drives import DriveState
from runtime.fieldbus.cia402 import TARGET_POSITION
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.jog import (
    DeadMan,
    DriveSession,
    JogLaw,
    Sample,
    Swing,
    drive_of,
    figures,
    jog_velocity,
    window,
)
from runtime.fieldbus.simulator import Fault
from tests.fieldbus.rig import Rig, demo_description

DT = 0.001


@settings(max_examples=60, deadline=None)
@given(
    velocity=st.floats(0.1, 1000.0),
    ramp=st.floats(0.0005, 0.1),
    low=st.floats(0.0, 50.0),
    high=st.floats(0.0, 50.0),
    orders=st.lists(st.tuples(st.sampled_from([-1, 0, 1]), st.integers(1, 200)), max_size=6),
)
def test_law_of_the_jog(velocity: float, ramp: float, low: float, high: float, orders: list[tuple[int, int]]) -> None:
    """Law: within the window, the velocity and the acceleration, whatever is ordered; without orders it comes to rest."""
    acceleration = velocity / ramp
    law = JogLaw(0.0, velocity, acceleration, -low, high)
    place, speed = 0.0, 0.0
    for direction, cycles in [*orders, (0, math.ceil(velocity / acceleration / DT) + 2)]:
        for _ in range(cycles):
            following = law.step(direction, DT)
            new_speed = (following - place) / DT
            assert -low - 1e-9 <= following <= high + 1e-9
            assert abs(new_speed) <= velocity * (1 + 1e-9) + 1e-6
            assert abs(new_speed - speed) <= acceleration * DT * (1 + 1e-6) + 1e-6
            place, speed = following, new_speed
    assert law.velocity == 0.0


def test_a_direction_dies_with_the_hand() -> None:
    hand = DeadMan(0.5)
    assert hand.direction(0.0) == 0
    hand.give(-1, 1.0)
    assert [hand.direction(t) for t in (1.0, 1.5, 1.51, 9.0)] == [-1, -1, 0, 0]


class Script:
    """Orders by the time: `(from, direction)`; the end after the last."""

    def __init__(self, rig: Rig, *orders: tuple[float, int | None]) -> None:
        self._orders = orders
        self._begin: float | None = None
        self.rig = rig
        self.then: Callable[[float], None] = lambda elapsed: None

    def order(self, now: float, position: float) -> int | None:
        self._begin = now if self._begin is None else self._begin
        elapsed = now - self._begin
        self.then(elapsed)
        return [direction for begin, direction in self._orders if elapsed >= begin][-1]


def session(rig: Rig, axis: str = "X") -> DriveSession:
    rig.idle()
    return DriveSession(rig.machine, drive_of(rig.machine, axis), rig.bus, now=lambda: rig.time, idle=rig.idle)


def law_of(running: DriveSession, *, velocity: float = 50.0, travel: float = 10.0) -> JogLaw:
    low, high = window(running.axis, running.position, travel)
    return JogLaw(running.position, velocity, running.axis.acceleration, low, high)


def test_an_axis_moves_as_ordered_and_is_left_at_rest_and_off() -> None:
    with Rig() as rig:
        drive = rig.simulated.drives[1]
        samples: list[Sample] = []
        with session(rig) as running:
            running.move(law_of(running), Script(rig, (0.0, 1), (0.1, 0), (0.3, -1), (0.4, None)), samples.append)
        assert max(sample.actual for sample in samples) == pytest.approx(5.0, abs=0.5)
        assert samples[-1].target_velocity == 0.0
        assert drive.state is DriveState.SWITCH_ON_DISABLED
        assert drive.servo.velocity == 0.0
        assert not rig.simulated.drives[2].operational  # the others are none of its business
        found = figures(samples)
        assert found.velocity == pytest.approx(50.0, rel=0.2)
        assert 0.0 < found.following_error_rms < found.following_error < 1.0
        # its servo feeds the velocity forward: set-points and feedback that are paired one cycle off would show 1 ms
        assert abs(found.delay) < 0.0003


def test_figures_are_those_of_the_samples() -> None:
    velocities = [100.0 * math.sin(0.1 * k) for k in range(200)]
    samples = [Sample(0.001 * k, 0.01 * v, 0.0, v, 1.05 * v, 10.0 * k) for k, v in enumerate(velocities)]
    found = figures(samples)
    assert found.delay == pytest.approx(0.01)
    assert found.overshoot == pytest.approx(0.05)
    assert found.following_error == pytest.approx(1.0, abs=0.01)
    assert found.following_error_rms == pytest.approx(1.0 / math.sqrt(2.0), rel=0.02)
    assert found.torque == 1990.0
    rest = figures([Sample(0.0, 1.0, 0.9, 0.0, 0.0, math.nan)])
    assert math.isnan(rest.delay)
    assert math.isnan(rest.torque)


def test_the_window_is_not_left_however_long_the_key_is_held() -> None:
    with Rig() as rig, session(rig) as running:
        increments, targets = 10_000, []
        drive = rig.simulated.drives[1]
        law = law_of(running, velocity=200.0, travel=3.0)
        running.move(
            law,
            Script(rig, (0.0, 1), (0.3, -1), (0.6, None)),
            lambda _: targets.append(drive.values[TARGET_POSITION, 0]),
        )
        assert max(targets) == 3 * increments
        assert min(targets) == -3 * increments


def test_swinging_goes_to_and_fro() -> None:
    with Rig() as rig, session(rig) as running:
        ends = []
        law = JogLaw(0.0, 100.0, running.axis.acceleration, 0.0, 2.0)
        swing = Swing(Script(rig, (0.0, 1), (1.0, None)), 0.0, 2.0)
        running.move(law, swing, lambda sample: ends.append(round(sample.target, 3)))
        turns = [a for a, b in itertools.pairwise(ends) if a != b and (a in (0.0, 2.0))]
        assert turns[:3] == [0.0, 2.0, 0.0]


def test_a_spindle_turns() -> None:
    with Rig() as rig, session(rig, "S") as running:
        seen: list[float] = []
        law = JogLaw(0.0, 360.0, running.axis.acceleration)
        running.move(law, Script(rig, (0.0, 1), (0.5, None)), lambda sample: seen.append(sample.velocity))
        assert max(seen) == pytest.approx(360.0, rel=0.02)


@pytest.mark.parametrize(
    ("fault", "entry"),
    [
        (Fault.DRIVE, catalogue.DRIVE_FAULT),
        (Fault.REBOOT, catalogue.NODE_RESTARTED),
        (Fault.SILENT, errors.DRIVE_AWAY),  # before its heartbeat is missed
        (Fault.ENCODER_FREEZE, errors.DRIVE_AWAY),
    ],
)
def test_what_befalls_the_drive_ends_the_motion(fault: Fault, entry: Any) -> None:
    description = demo_description()
    description["axes"][0]["following_error"] = 0.5
    with Rig(description) as rig:
        hand = Script(rig, (0.0, 1), (5.0, None))
        hand.then = lambda elapsed: rig.simulated.inject(1, fault) if 0.1 <= elapsed < 0.101 else None
        with pytest.raises(FieldbusError) as end, session(rig) as running:
            running.move(law_of(running, travel=100.0), hand, lambda _: None)
        assert end.value.problem.entry is entry
        for _ in range(10_000):
            rig.idle()
        assert rig.simulated.drives[1].servo.velocity < 0.01 * 50.0 * 10_000  # without current it coasts
        assert rig.simulated.drives[1].state is not DriveState.OPERATION_ENABLED


def test_a_process_that_dies_stops_the_drive() -> None:
    """The dead-man's switch below all others: the heartbeat."""
    with Rig() as rig:
        running = session(rig).__enter__()

        class DiedError(Exception):
            pass

        def die(elapsed: float) -> None:
            if elapsed > 0.2:
                raise DiedError

        hand = Script(rig, (0.0, 1))
        hand.then = die
        with pytest.raises(DiedError):
            running.move(law_of(running, travel=100.0), hand, lambda _: None)
        running.image.enable[:] = True  # what the end would have taken away was never sent
        drive = rig.simulated.drives[1]
        assert drive.servo.velocity > 0.0
        for _ in range(8_000):
            rig.idle()
        assert (drive.servo.velocity, drive.state) == (0.0, DriveState.FAULT)


def test_it_refuses_while_a_machine_runs() -> None:
    with Rig() as rig, can.Bus(interface="virtual", channel=rig.machine.fieldbus.bus.channel) as visitor:
        rig.enabled()
        axis = drive_of(rig.machine, "X")
        with (
            pytest.raises(FieldbusError) as refusal,
            DriveSession(rig.machine, axis, visitor, now=lambda: rig.time, idle=rig.cycle),
        ):
            pass
        assert refusal.value.problem.entry is catalogue.OTHER_MASTER
        assert rig.event_ids() == []


def test_limits_are_those_of_the_axis() -> None:
    description = demo_description()
    description["axes"][0] |= {"position_min": -1.0, "position_max": 4.0}
    description["axes"][1] |= {"position_min": -1.0, "homing": {"fast": 50.0, "slow": 5.0, "switch": "home_y"}}
    with Rig() as rig:
        x = drive_of(rig.machine, "X").model_copy(update={"position_min": -1.0, "position_max": 4.0})
        assert window(x, 0.0, 10.0) == (-1.0, 4.0)
        assert window(x, 6.0, 10.0) == (-1.0, 6.0)  # who stands outside may come back, and no further out
        assert jog_velocity(x, None) == x.velocity / 10.0
        with pytest.raises(FieldbusError) as refusal:
            jog_velocity(x, x.velocity * 1.01)
        assert refusal.value.problem.entry is errors.JOG_LIMIT
        with pytest.raises(FieldbusError) as refusal:
            drive_of(rig.machine, "W")
        assert refusal.value.problem.entry is errors.NO_SUCH_DRIVE
        assert "X, Y, Z, S" in refusal.value.problem.hint


def test_a_drive_that_does_not_get_enabled() -> None:
    with Rig() as rig, session(rig) as running:
        rig.simulated.drives[1].set_points_taken = lambda: None  # type: ignore[method-assign]
        with pytest.raises(FieldbusError) as refusal:
            running.move(law_of(running), Script(rig, (0.0, 1)), lambda _: None)
        assert refusal.value.problem.entry is errors.DRIVE_NOT_ENABLED
        assert "switch on disabled" in refusal.value.problem.text
