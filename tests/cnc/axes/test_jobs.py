"""Jobs of one axis: state diagram, buffer modes, superimposed motion, gear, and the limits that no sequence of jobs breaks."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from runtime.cnc.axes.axis_plan import Dynamics, Plan, State, plan_speed, proven
from runtime.cnc.axes.gear import MasterPlaces, surely_stops
from runtime.cnc.axes.job_values import AxisCycle, Followed
from runtime.cnc.axes.jobs import AxisJobs
from runtime.hli.axis_jobs import Job
from runtime.hli.layout import AxisFunction as F
from runtime.hli.layout import BufferMode, Direction, JobState, MotionState

LIMITS = Dynamics(velocity=100.0, acceleration=1000.0, jerk=20_000.0)
PERIOD = 0.001
LEAST, GREATEST = -200.0, 300.0


class Rig:
    """An ideal axis with its jobs; axis 1 is a master that the test moves."""

    def __init__(self) -> None:
        self.places = np.zeros(2)
        masters = MasterPlaces({1: 0, 2: 1}, self.places, self.places)
        self.jobs = AxisJobs("B", 0, LIMITS, PERIOD, LEAST, GREATEST, masters)
        self.cycle = AxisCycle(True, False, False, 0.0, 0.0, True)
        self.path = [0.0]
        self.master: Callable[[float], float] = lambda t: 0.0
        self.step()

    @property
    def time(self) -> float:
        return (len(self.path) - 1) * PERIOD

    def give(self, function: F, **values: object) -> Followed:
        return self.jobs.give(Job(function, **values), self.cycle)  # type: ignore[arg-type]

    def step(self, cycles: int = 1) -> None:
        for _ in range(cycles):
            place = self.jobs.step(self.cycle)
            if place is not None:
                self.places[0] = self.cycle.set_point = self.cycle.actual = place
            self.path.append(float(self.places[0]))
            self.places[1] = self.master(self.time)

    def until(self, condition: Callable[[], bool], limit: float = 30.0) -> None:
        for _ in range(round(limit / PERIOD)):
            if condition():
                return
            self.step()
        raise AssertionError(f"not within {limit} s: {self.jobs.state}, {self.places[0]}")

    def done(self, job: Followed) -> None:
        self.until(lambda: not job.open)
        assert outcome(job) is JobState.DONE, job.answer

    def state(self) -> MotionState:
        return self.jobs.state

    def velocity(self) -> float:
        return (self.path[-1] - self.path[-2]) / PERIOD

    def assert_limits(self) -> None:
        assert_limits(self.path)


def outcome(job: Followed) -> JobState:
    return job.answer.state


def assert_limits(path: list[float]) -> None:
    v = np.diff(path) / PERIOD
    a = np.diff(v) / PERIOD
    j = np.diff(a) / PERIOD
    assert np.abs(v).max(initial=0.0) <= LIMITS.velocity * 1.0001
    assert np.abs(a).max(initial=0.0) <= LIMITS.acceleration * 1.001
    assert np.abs(j).max(initial=0.0) <= LIMITS.jerk * 1.01 + 1.0
    assert min(path) >= LEAST - 1e-6
    assert max(path) <= GREATEST + 1e-6


def test_the_moves_of_plcopen_lead_where_they_say() -> None:
    rig = Rig()
    job = rig.give(F.MOVE_ABSOLUTE, position=50.0, velocity=80.0)
    assert rig.state() is MotionState.DISCRETE_MOTION
    rig.done(job)
    assert rig.path[-1] == 50.0
    rig.step(2)
    assert rig.state() is MotionState.STANDSTILL
    rig.done(rig.give(F.MOVE_RELATIVE, position=-20.0, velocity=80.0))
    assert rig.path[-1] == 30.0
    first = rig.give(F.MOVE_RELATIVE, position=100.0, velocity=50.0)
    rig.step(300)
    second = rig.give(F.MOVE_ADDITIVE, position=10.0, velocity=50.0)
    assert outcome(first) is JobState.ABORTED
    rig.done(second)
    assert rig.path[-1] == pytest.approx(140.0), "added to the target that was not reached"
    first = rig.give(F.MOVE_RELATIVE, position=-100.0, velocity=50.0)
    rig.step(300)
    here = rig.path[-1]
    rig.done(rig.give(F.MOVE_RELATIVE, position=10.0, velocity=50.0))
    assert rig.path[-1] == pytest.approx(here + 10.0), "from where it was: the job before is not completed"
    rig.assert_limits()


def test_endless_motion_halt_and_stop() -> None:
    rig = Rig()
    run = rig.give(F.MOVE_VELOCITY, velocity=40.0, direction=Direction.NEGATIVE)
    rig.until(lambda: run.answer.state is JobState.REACHED)
    assert rig.velocity() == pytest.approx(-40.0, abs=0.05)
    assert rig.state() is MotionState.CONTINUOUS_MOTION
    on = rig.give(F.MOVE_VELOCITY, velocity=20.0, direction=Direction.CURRENT)
    rig.until(lambda: on.answer.state is JobState.REACHED)
    assert rig.velocity() == pytest.approx(-20.0, abs=0.05)
    halt = rig.give(F.HALT)
    assert rig.state() is MotionState.DISCRETE_MOTION
    rig.done(halt)
    rig.give(F.MOVE_VELOCITY, velocity=40.0)
    rig.step(100)
    rig.cycle.stop_hold = True
    stop = rig.give(F.STOP)
    assert rig.state() is MotionState.STOPPING
    rig.done(stop)
    rig.step(10)
    assert rig.state() is MotionState.STOPPING, "until Execute falls"
    refused = rig.give(F.MOVE_RELATIVE, position=1.0, velocity=1.0)
    assert refused.answer == (JobState.ERROR, 308005, 0.0)
    rig.cycle.stop_hold = False
    rig.step(3)
    assert rig.state() is MotionState.STANDSTILL
    rig.assert_limits()


@pytest.mark.parametrize(
    ("job", "error"),
    [
        (Job(F.MOVE_ABSOLUTE, GREATEST + 1.0, 10.0), 308006),
        (Job(F.MOVE_RELATIVE, LEAST - 50.0, 10.0), 308006),
        (Job(F.MOVE_SUPERIMPOSED, GREATEST + 1.0, 10.0), 308006),
        (Job(F.MOVE_ABSOLUTE, 10.0, 0.0), 308008),
        (Job(F.MOVE_ABSOLUTE, math.nan, 10.0), 308008),
        (Job(F.MOVE_ABSOLUTE, 10.0, math.inf), 308008),
        (Job(F.MOVE_ABSOLUTE, 10.0, 1.0, direction=Direction.NEGATIVE), 308008),
        (Job(F.GEAR_IN, master=9), 308014),
        (Job(F.GEAR_IN, master=1), 308014),
        (Job(F.GEAR_IN, master=2, denominator=0.0), 308008),
        (Job(F.GEAR_OUT), 308011),
        (Job(F.PHASING, 1.0, 1.0), 308011),
        (Job(F.TOUCH_PROBE, mode=3, master=1), 308008),
    ],
)
def test_what_is_refused_moves_nothing_and_leaves_the_motion_alone(job: Job, error: int) -> None:
    for moving in (False, True):
        rig = Rig()
        run = rig.give(F.MOVE_VELOCITY, velocity=10.0) if moving else None
        rig.step(300)
        state = rig.jobs.state
        refused = rig.jobs.give(job, rig.cycle)
        assert (refused.answer.state, refused.answer.error) == (JobState.ERROR, error)
        assert rig.jobs.problems[-1].text
        assert rig.jobs.state is state
        assert run is None or run.open
        before = rig.velocity()
        rig.step(3)
        assert rig.velocity() == pytest.approx(before)


def test_an_endless_motion_comes_to_rest_at_the_software_limit() -> None:
    rig = Rig()
    run = rig.give(F.MOVE_VELOCITY, velocity=100.0)
    rig.until(lambda: not run.open)
    assert run.answer == (JobState.ERROR, 308007, 0.0)
    assert rig.path[-1] == GREATEST
    rig.step(3)
    assert rig.state() is MotionState.STANDSTILL
    rig.done(rig.give(F.MOVE_RELATIVE, position=-10.0, velocity=50.0))
    rig.assert_limits()


@pytest.mark.parametrize(
    ("mode", "speed"),
    [
        (BufferMode.BUFFERED, 0.0),
        (BufferMode.BLENDING_LOW, 30.0),
        (BufferMode.BLENDING_PREVIOUS, 60.0),
        (BufferMode.BLENDING_NEXT, 30.0),
        (BufferMode.BLENDING_HIGH, 60.0),
    ],
)
def test_buffer_modes_pass_the_first_target_with_their_velocity(mode: BufferMode, speed: float) -> None:
    rig = Rig()
    first = rig.give(F.MOVE_ABSOLUTE, position=60.0, velocity=60.0)
    second = rig.give(F.MOVE_ABSOLUTE, position=120.0, velocity=30.0, buffer_mode=mode)
    assert outcome(second) is JobState.BUSY
    full = rig.give(F.MOVE_ABSOLUTE, position=0.0, velocity=1.0, buffer_mode=mode)
    assert full.answer.error == 308009
    rig.until(lambda: not first.open)
    assert outcome(first) is JobState.DONE
    assert outcome(second) is JobState.ACTIVE
    passing = float(np.interp(60.0, rig.path[1:], np.diff(rig.path) / PERIOD))
    assert passing == pytest.approx(speed, abs=1.5)
    rig.done(second)
    assert rig.path[-1] == 120.0
    rig.assert_limits()


def test_a_blended_move_that_turns_round_stands_at_the_first_target() -> None:
    rig = Rig()
    first = rig.give(F.MOVE_ABSOLUTE, position=60.0, velocity=60.0)
    second = rig.give(F.MOVE_ABSOLUTE, position=0.0, velocity=30.0, buffer_mode=BufferMode.BLENDING_HIGH)
    rig.until(lambda: not first.open)
    rig.done(second)
    assert max(rig.path) == pytest.approx(60.0, abs=1e-9)
    rig.assert_limits()


def test_a_superimposed_way_is_added_and_the_motion_below_goes_on() -> None:
    rig = Rig()
    run = rig.give(F.MOVE_VELOCITY, velocity=30.0)
    rig.until(lambda: run.answer.state is JobState.REACHED)
    begin, start = rig.path[-1], rig.time
    added = rig.give(F.MOVE_SUPERIMPOSED, position=25.0, velocity=40.0)
    assert rig.state() is MotionState.CONTINUOUS_MOTION
    rig.until(lambda: not added.open)
    assert outcome(added) is JobState.DONE
    assert outcome(run) is JobState.REACHED, "InVelocity stays"
    assert rig.path[-1] == pytest.approx(begin + 25.0 + 30.0 * (rig.time - start), abs=1e-6)
    rig.done(rig.give(F.MOVE_ABSOLUTE, position=0.0, velocity=100.0))
    assert rig.path[-1] == 0.0
    rig.assert_limits()


def test_a_superimposed_way_needs_room() -> None:
    rig = Rig()
    rig.give(F.MOVE_VELOCITY, velocity=80.0)
    rig.step(500)
    assert rig.give(F.MOVE_SUPERIMPOSED, position=25.0, velocity=40.0).answer.error == 308012
    rig.done(rig.give(F.HALT))
    rig.done(rig.give(F.MOVE_SUPERIMPOSED, position=25.0, velocity=40.0))
    rig.assert_limits()


def smoothly(t: float, speed: float) -> float:
    """Place of a master that gets its speed within a second, with continuous acceleration."""
    u = min(t, 1.0)
    return speed * (u**3 - u**4 / 2.0 + max(t - 1.0, 0.0))


def test_a_gear_follows_its_master_and_lets_go_with_its_velocity() -> None:
    rig = Rig()
    rig.master = lambda t: smoothly(t, 30.0)
    gear = rig.give(F.GEAR_IN, master=2, numerator=-3.0, denominator=2.0)
    rig.step(2000)
    assert outcome(gear) is JobState.REACHED
    assert rig.state() is MotionState.SYNCHRONIZED_MOTION
    here, master = rig.path[-1], rig.master(rig.time - PERIOD)
    rig.step(1000)
    assert rig.path[-1] - here == pytest.approx(-1.5 * (rig.master(rig.time - PERIOD) - master))
    shift = rig.give(F.PHASING, position=5.0, velocity=20.0)
    here, master = rig.path[-1], rig.master(rig.time - PERIOD)
    rig.done(shift)
    assert rig.path[-1] - here == pytest.approx(5.0 - 1.5 * (rig.master(rig.time - PERIOD) - master), abs=0.1)
    out = rig.give(F.GEAR_OUT)
    assert outcome(out) is JobState.DONE
    assert outcome(gear) is JobState.ABORTED
    speed = rig.velocity()
    rig.master = lambda t: 0.0
    rig.step(100)
    assert rig.velocity() == pytest.approx(speed, rel=0.01)
    assert rig.state() is MotionState.CONTINUOUS_MOTION
    rig.assert_limits()


@pytest.mark.parametrize("ratio", [0.5, -1.0])
def test_an_axis_is_locked_to_a_master_that_gets_faster_without_leaving_its_jerk(ratio: float) -> None:
    rig = Rig()
    rig.master = lambda t: smoothly(t, 60.0)
    rig.step(200)  # the master is in the middle of its acceleration
    gear = rig.give(F.GEAR_IN, master=2, numerator=ratio)
    rig.until(lambda: gear.answer.state is JobState.REACHED, 1.0)
    here, master = rig.path[-1], rig.master(rig.time - PERIOD)
    rig.step(500)
    assert rig.path[-1] - here == pytest.approx(ratio * (rig.master(rig.time - PERIOD) - master), abs=1e-6)
    rig.assert_limits()


@pytest.mark.spec("isg.plcopen.mc-gearin")
@pytest.mark.parametrize("shift", [0.0, -40.0])
def test_automatic_phase_compensation_brings_the_slave_to_its_place(shift: float) -> None:
    rig = Rig()
    rig.master = lambda t: 5.0 + smoothly(t, 40.0)
    rig.done(rig.give(F.MOVE_ABSOLUTE, position=12.0, velocity=80.0))
    gear = rig.give(F.GEAR_IN, position=shift, master=2, numerator=2.0, mode=256)
    rig.until(lambda: gear.answer.state is not JobState.ACTIVE, 5.0)
    assert outcome(gear) is JobState.REACHED
    rig.step(200)
    assert rig.path[-1] == pytest.approx(2.0 * rig.master(rig.time - PERIOD) + shift, abs=1e-6)
    assert rig.give(F.PHASING, position=3.0, velocity=10.0, acceleration=200.0).answer.error == 0
    rig.assert_limits()


def test_while_the_phase_is_brought_about_there_is_no_room_for_more() -> None:
    rig = Rig()
    gear = rig.give(F.GEAR_IN, position=100.0, master=2, mode=256)
    rig.step(100)
    assert outcome(gear) is JobState.ACTIVE
    assert rig.give(F.PHASING, position=3.0, velocity=10.0).answer.error == 308012
    rig.done(rig.give(F.HALT))
    rig.assert_limits()


@pytest.mark.parametrize(
    ("master", "says"),
    [
        (lambda t: smoothly(t, 20.0), "software limit"),
        (lambda t: smoothly(t, 20.0) + 800.0 * max(t - 1.5, 0.0) ** 2, "more than it can"),
        (lambda t: smoothly(t, 60.0), "velocity"),
    ],
)
def test_a_slave_that_cannot_follow_stops_inside_its_limits(master: Callable[[float], float], says: str) -> None:
    rig = Rig()
    rig.master = master
    gear = rig.give(F.GEAR_IN, master=2, numerator=3.0 if says == "software limit" else 2.0)
    rig.until(lambda: not gear.open)
    assert gear.answer == (JobState.ERROR, 308013, 0.0)
    assert says in rig.jobs.problems[-1].text
    assert rig.state() is MotionState.ERROR_STOP
    rig.until(lambda: rig.jobs.standing)
    rig.assert_limits()
    assert rig.give(F.MOVE_RELATIVE, position=-1.0, velocity=1.0).answer.error == 308004
    rig.step(3)
    rig.give(F.RESET)
    rig.step()
    assert rig.state() is MotionState.STANDSTILL
    rig.done(rig.give(F.MOVE_RELATIVE, position=-1.0, velocity=1.0))


@pytest.mark.spec("hli.ax.cu.override")
def test_feed_hold_and_override_of_the_axis_act_on_its_jobs() -> None:
    rig = Rig()
    job = rig.give(F.MOVE_ABSOLUTE, position=50.0, velocity=50.0)
    rig.step(300)
    rig.cycle.hold = True
    rig.step(300)
    here = rig.path[-1]
    rig.step(300)
    assert rig.path[-1] == here
    assert outcome(job) is JobState.ACTIVE
    rig.cycle.hold, rig.cycle.override = False, 0.1
    rig.step(300)
    assert rig.velocity() == pytest.approx(5.0, abs=0.05)
    rig.cycle.override = 1.0
    rig.done(job)
    rig.assert_limits()


def test_an_axis_that_is_off_or_in_the_path_takes_no_job() -> None:
    rig = Rig()
    rig.cycle.in_path = True
    rig.step()
    assert rig.give(F.MOVE_RELATIVE, position=1.0, velocity=1.0).answer.error == 308003
    rig.cycle.in_path, rig.cycle.enabled = False, False
    rig.step()
    assert rig.state() is MotionState.DISABLED
    assert rig.give(F.MOVE_RELATIVE, position=1.0, velocity=1.0).answer.error == 308002
    rig.cycle.enabled = True
    rig.step()
    job = rig.give(F.MOVE_RELATIVE, position=50.0, velocity=50.0)
    rig.step(200)
    rig.cycle.enabled = False
    rig.step()
    assert outcome(job) is JobState.ABORTED
    assert rig.jobs.step(rig.cycle) is None, "the axis tracks"


def test_a_probe_records_the_place_of_its_edge() -> None:
    rig = Rig()
    probe = rig.give(F.TOUCH_PROBE, mode=2, master=3)
    assert rig.jobs.probe.input == 3
    for level, place in ((True, 1.0), (False, 2.0), (True, 3.5), (True, 4.0)):
        if rig.jobs.probe.edge(level):
            rig.jobs.latch(place)
    assert probe.answer == (JobState.DONE, 0, 3.5), "an input that is TRUE already has no edge"
    probe = rig.give(F.TOUCH_PROBE, mode=1, master=3)
    again = rig.give(F.TOUCH_PROBE, mode=1, master=3)
    assert outcome(probe) is JobState.ABORTED
    rig.give(F.ABORT_TRIGGER)
    assert outcome(again) is JobState.ABORTED
    assert rig.jobs.probe.input == 0


def test_an_added_way_beyond_the_limit_is_refused_with_any_buffer_mode() -> None:
    rig = Rig()
    rig.give(F.MOVE_VELOCITY, velocity=60.0, direction=Direction.NEGATIVE)
    rig.step(500)
    for mode in BufferMode:
        added = rig.give(F.MOVE_SUPERIMPOSED, position=LEAST, velocity=10.0, buffer_mode=mode)
        assert added.answer.error == 308006
        rig.step(10)
    rig.assert_limits()


# --------------------------------------------------------------------------------------------- laws


@given(st.floats(LEAST, GREATEST), st.floats(-110.0, 110.0), st.floats(-1100.0, 1100.0))
def test_the_quick_bound_is_never_more_hopeful_than_the_plan(p: float, v: float, a: float) -> None:
    if surely_stops(State(p, v, a), LIMITS, LEAST, GREATEST):
        plan = Plan()
        plan_speed(plan, State(p, v, a), 0.0, LIMITS)
        assert proven(plan, LIMITS, LEAST, GREATEST)


SPEED = st.sampled_from([5.0, 30.0, 60.0, 100.0, 500.0])
PLACE = st.floats(-260.0, 360.0)
RATE = st.sampled_from([None, 200.0, 1000.0, 5000.0])
JOBS = st.one_of(
    st.builds(
        Job,
        st.sampled_from(
            [F.MOVE_ABSOLUTE, F.MOVE_RELATIVE, F.MOVE_ADDITIVE, F.MOVE_SUPERIMPOSED, F.MOVE_VELOCITY, F.PHASING]
        ),
        position=PLACE,
        velocity=SPEED,
        acceleration=RATE,
        deceleration=RATE,
        direction=st.sampled_from([Direction.NEGATIVE, Direction.SHORTEST, Direction.CURRENT]),
        buffer_mode=st.sampled_from(list(BufferMode)),
    ),
    st.builds(Job, st.sampled_from([F.HALT, F.STOP, F.RESET, F.GEAR_OUT]), acceleration=RATE, deceleration=RATE),
    st.builds(
        Job,
        st.just(F.GEAR_IN),
        position=PLACE,
        master=st.just(2),
        numerator=st.floats(-4.0, 4.0),
        mode=st.sampled_from([0, 256]),
    ),
)


@given(st.lists(st.tuples(JOBS, st.integers(1, 900), st.booleans(), st.sampled_from([0.0, 0.5, 1.0, 2.0])), max_size=7))
@settings(max_examples=150, deadline=None, phases=[Phase.explicit, Phase.generate], report_multiple_bugs=False)
def test_no_sequence_of_jobs_leaves_the_limits_of_the_axis(orders: list[tuple[Job, int, bool, float]]) -> None:
    """Whatever comes when: velocity, acceleration, jerk and position stay what the axis can, and it comes to rest in the end."""
    rig = Rig()
    rig.master = lambda t: 10.0 * (t - math.sin(t))
    for job, cycles, hold, override in orders:
        rig.cycle.hold, rig.cycle.override = hold, override
        rig.jobs.give(job, rig.cycle)
        rig.step(cycles)
    rig.cycle.hold = False
    rig.jobs.stop("the test ends")
    rig.until(lambda: rig.jobs.standing, 5.0)
    rig.step(3)
    rig.assert_limits()
    assert not rig.jobs.owned
