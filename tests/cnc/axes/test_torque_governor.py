"""A torque that the velocity limits, on a motor of which the control knows little."""

from __future__ import annotations

from collections import deque

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.axes.torque_governor import TorqueGovernor, usual_gain

PERIOD = 0.001
DELAY = 3  # cycles from a measurement to its torque
ACCELERATION = 700.0  # of the axis


class Motor:
    """A mass that a torque accelerates, with friction (shares of the rated torque); torques come `DELAY` cycles late."""

    def __init__(self, rated: float, friction: float = 0.0) -> None:
        self.rated, self.friction = rated, friction
        self.velocity = 0.0
        self.held = False
        self._coming = deque([0.0] * DELAY)

    def step(self, torque: float) -> None:
        self._coming.append(torque)
        push = self._coming.popleft()
        if self.held:
            self.velocity = 0.0
            return
        self.velocity += self.rated * push * PERIOD
        rub = self.rated * self.friction * PERIOD
        self.velocity -= max(-rub, min(rub, self.velocity))


@settings(max_examples=60, deadline=None)
@given(
    stronger=st.floats(0.3, 8.0),  # than the control takes it to be
    most=st.floats(0.02, 1.0),
    allowed=st.floats(1.0, 400.0),
    friction=st.floats(0.0, 0.01),
    sign=st.sampled_from([-1.0, 1.0]),
)
def test_the_torque_is_reached_against_a_stop_and_the_velocity_is_kept_without(
    stronger: float, most: float, allowed: float, friction: float, sign: float
) -> None:
    rated = 2.0 * ACCELERATION * stronger
    governor, motor = TorqueGovernor(usual_gain(ACCELERATION), PERIOD), Motor(rated, friction)
    motor.held = True
    torque, last = 0.0, 0.0
    # the share needs 0.1 s for each allowed velocity times gain
    cycles = round(most / (usual_gain(ACCELERATION) * allowed) * 100) + 100
    for _ in range(cycles):
        torque = governor.step(sign * allowed, motor.velocity, sign, most, 1.0)
        motor.step(torque)
        assert sign * torque >= sign * last - 1e-12  # never less than before
        assert abs(torque) <= most
        last = torque
    assert torque == pytest.approx(sign * most)
    assert governor.saturated
    motor.held = False  # what it pressed against gives way
    fastest, late = 0.0, []
    for k in range(1500):
        motor.step(governor.step(sign * allowed, motor.velocity, sign, most, 1.0))
        fastest = max(fastest, sign * motor.velocity)
        if k > 1000:
            late.append(sign * motor.velocity)
    # seen three cycles late; then what pushes goes within 5 ms, and the gain brakes too
    assert fastest <= allowed + most * rated * (DELAY * PERIOD + 2 * 0.005)
    assert max(late) <= 1.1 * allowed + 0.01 * rated * 0.01
    assert min(late) >= 0.0


def test_it_begins_with_the_torque_that_holds_the_axis() -> None:
    """A vertical axis: the torque before is -0.2, the velocity allowed 0."""
    governor = TorqueGovernor(0.01, PERIOD)
    governor.begin(-0.2)
    assert governor.step(0.0, 0.0, 1.0, 0.5, 1.0) == pytest.approx(-0.2)


def test_what_drives_it_on_is_braked_with_all_that_it_may() -> None:
    governor = TorqueGovernor(0.01, PERIOD)
    torques = [governor.step(10.0, 30.0, 1.0, 0.3, 0.8) for _ in range(2000)]
    assert torques[0] == pytest.approx(-0.2 - 0.01 * 20 * PERIOD / 0.1)
    assert torques == sorted(torques, reverse=True)
    assert torques[-1] == -0.8
