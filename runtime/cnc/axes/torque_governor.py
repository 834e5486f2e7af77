"""The torque of an axis whose drive is in a torque mode, so that its velocity stays below the one that is allowed.

A drive in a torque mode keeps no velocity: where nothing resists, it runs up to a limit of its own that every maker puts into
another object. So the control closes the loop:

    torque = gain * (allowed - actual velocity) + share        from -brake to +most in the direction of the order

The share grows while the axis is slower than allowed, up to the torque that is ordered: an axis that stands against a stop
presses with that torque, whatever the allowed velocity. An axis that is faster loses what pushes it within some milliseconds.

Velocities in mm/s or degrees/s, torques as shares of the rated one.
"""

from __future__ import annotations

from typing import Final

GROWS: Final = 0.1  # s in which the share grows by what the gain makes of the same difference
SHRINKS: Final = 0.005  # s in which a share that pushes falls to 1/e while the axis is too fast
LOOP: Final = 40.0  # 1/s: how fast the velocity is corrected, if rated torque accelerates as `usual_gain` takes it
USUAL: Final = 2.0  # times the acceleration of the axis, at rated torque


def usual_gain(acceleration: float) -> float:
    """Share of the rated torque per mm/s or degree/s, for an axis of which no more than its acceleration is known.

    The torque acts some three cycles after the velocity was measured. A motor that is eight times stronger than taken here
    closes the loop at 320/s, of which these are 1 rad at 1 ms: it still is stable.
    """
    return LOOP / (USUAL * acceleration)


class TorqueGovernor:
    """`begin` with the torque that the axis has, then `step` in every cycle. `gain`: share per mm/s or degree/s."""

    def __init__(self, gain: float, period: float) -> None:
        self._gain, self._period = gain, period
        self._share = 0.0
        self.saturated = False  # the torque is the ordered one: the velocity does not limit it

    def begin(self, torque: float) -> None:
        """Go on with the torque that holds the axis."""
        self._share = torque
        self.saturated = False

    def step(
        self, allowed: float, actual: float, direction: float, most: float, brake: float, slope: float = 0.0
    ) -> float:
        """The torque of this cycle. `direction`: 1 or -1, that of the order; `most` pushes in it, `brake` against it.

        `slope`: of the allowed velocity where it is a ramp to be followed, mm/s² or degrees/s²: what it takes goes out at once,
        so that the share has not to grow, and then to shrink behind the end of the ramp.
        """
        too_slow = direction * (allowed - actual)
        share = direction * self._share
        push = self._gain * (too_slow + direction * slope / LOOP)
        if too_slow < 0.0 < share:
            share -= share * min(self._period / SHRINKS, 1.0)
        torque = push + share
        # what is at a limit grows no further
        if (too_slow > 0.0 and torque < most) or (too_slow < 0.0 and torque > -brake):
            share += self._gain * too_slow * self._period / GROWS
        share = max(-brake, min(most, share))
        torque = push + share
        self.saturated = torque >= most
        self._share = direction * share
        return direction * max(-brake, min(most, torque))
