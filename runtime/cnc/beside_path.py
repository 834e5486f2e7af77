"""What axes do beside the path: moved by hand (G200, G201, G202), homed (G74), and taken over by the path afterwards.

    position of an axis = where the path has put it + its offset

The offset is the way by hand. It stays when the hand is taken away, until the path takes it over: after G200 and G74, at
#CHANNEL INIT, and at the next start of a program. Everything here happens in the cycle and is bounded by the number of axes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from runtime.cnc.axes.axis_plan import Dynamics
from runtime.cnc.axes.homing import AxisHoming, HomingDrive, HomingPhase
from runtime.cnc.axes.independent import IndependentAxes
from runtime.cnc.axes.manual import HandInputs, ManualAxis
from runtime.cnc.blocks import MANUAL_SHARE, ManualValue
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.motion_queue import ActionKind, GateReason
from runtime.cnc.path_ahead import path_ahead
from runtime.cnc.queue_record import QueueRecord
from runtime.config.machine import Axis, ChannelParameters
from runtime.diagnostics.catalogue import machine as alarms
from runtime.diagnostics.catalogue import plc as orders
from runtime.diagnostics.errors import Problem
from runtime.hli.layout import HANDWHEELS, KEY_PAIRS, ManualMode, StopCondition
from runtime.hli.manual import ManualCommands

Floats = npt.NDArray[np.float64]

RANK_BITS = 4
GATES = frozenset(
    {GateReason.MANUAL, GateReason.MANUAL_END, GateReason.HOMING, GateReason.TAKE_OVER, GateReason.SET_POSITION}
)
ACTIONS = frozenset({ActionKind.MANUAL_ON, ActionKind.MANUAL_PARAMETER})
_VALUES = tuple(ManualValue)
_LOOK_AHEAD = 512  # elements of the path that are looked at for software limits
_SMALL = 1e-6  # mm, degrees: what a position may lie beyond a limit by rounding


class AxisInputs(Protocol):
    """What is commanded to the path axes, in their order."""

    alone_override: float
    feed_hold: bool
    axis_holds: list[bool]
    blocked: list[int]
    limits: list[tuple[float, float] | None]


class Passage(NamedTuple):
    """What a gate says: whether the path may go on, and what it waits for if not."""

    open: bool
    stop: int = 0


class BesidePath:
    """Of one channel. `cam(k)` tells whether axis k stands on its reference cam, None if nobody tells."""

    def __init__(
        self,
        axes: Sequence[Axis],
        period: float,
        parameters: ChannelParameters,
        cam: Callable[[int], bool | None],
        shift: Callable[[int, float], None],
        drives: Sequence[HomingDrive],
    ) -> None:
        self._described = list(axes)
        self._parameters = parameters
        mask = parameters.suppress_soft_limit_monitoring_axes
        self._unwatched = [bool(mask >> k & 1) for k in range(len(axes))]  # P-CHAN-00459
        self._cam = cam
        self._shift = shift
        self.axes = [ManualAxis(axis, period, k + 1) for k, axis in enumerate(axes)]
        self._homing = [
            AxisHoming(axis, hand.motion, drive, period)
            for axis, hand, drive in zip(axes, self.axes, drives, strict=True)
        ]
        self.referenced = [axis.homing is None for axis in axes]
        self.by_hand: Floats = np.zeros(len(axes))  # the offsets of hand and homing
        self.alone = IndependentAxes(axes, period)
        self.coupled: Floats = np.zeros(len(axes))  # the ways of masters that axes follow
        # Slave, master, how far it is ahead, its place on the path.
        self._couplings: list[tuple[int, int, float, float]] = []
        self.offset: Floats = np.zeros(len(axes))  # all of them
        self.engaged = False  # an offset, or something that makes one
        self.commands: ManualCommands | None = None
        self._numbers = {axis.log_axis: k for k, axis in enumerate(axes)}
        self._released_at = [0.0] * len(axes)  # offset when the hand was let in
        self._reach = [(-math.inf, math.inf)] * len(axes)  # least and greatest offset by hand, in this cycle
        self._gate_begun = False
        self._leaving = False
        self._rank = 0
        self._told = False

    # ------------------------------------------------------------------ orders of the channel

    def begin(self) -> None:
        """A program starts where the axes are."""
        self._rest(0.0)
        self._told = False

    def drop(self) -> None:
        """The axes brake by themselves: nothing is known of where they end."""
        self._rest(0.0)

    def _rest(self, offset: float) -> None:
        for hand, homing in zip(self.axes, self._homing, strict=True):
            if not homing.over:
                homing.forget()
            hand.close(at_once=True)
            hand.restart(offset)
        self.by_hand[:] = offset
        self.alone.drop()
        self._couplings.clear()
        self.coupled[:] = 0.0
        self.offset[:] = offset
        self.engaged = False
        self._gate_begun = self._leaving = False

    def finish(self) -> None:
        """The program is at its end, as at G202: what was begun by hand is finished, or dropped (P-CHAN-00113)."""
        for hand in self.axes:
            if hand.released:
                hand.close(at_once=self._parameters.path_reject_std_manual_mode)

    def stop(self) -> None:
        """The program is aborted: everything brakes."""
        for hand, homing in zip(self.axes, self._homing, strict=True):
            if not homing.over:
                homing.cancel()
            if not hand.motion.standstill or hand.released:
                hand.close(at_once=True)
        self.alone.stop()

    @property
    def at_rest(self) -> bool:
        """Nothing moves beside the path."""
        return self.alone.at_rest and (
            not self.engaged
            or (all(hand.motion.standstill for hand in self.axes) and all(homing.over for homing in self._homing))
        )

    def act(self, record: QueueRecord) -> None:
        """The path has come to G201, or to parameters of manual mode."""
        if record.action is ActionKind.MANUAL_ON:
            for k, hand in enumerate(self.axes):
                if record.number >> k & 1:
                    self._release(k, hand, exclusive=False)
            return
        hand = self.axes[record.number]
        what = _VALUES[record.offset]
        if what is ManualValue.LIMITS:
            hand.relative = (record.value, record.seconds)
            return
        stage = hand.stages[record.size]
        if what is ManualValue.HANDWHEEL:
            stage.resolution = record.value
        elif what is ManualValue.CONTINUOUS:
            stage.velocity = record.value
        else:
            stage.width, stage.step_velocity = record.value, record.seconds

    def _release(self, k: int, hand: ManualAxis, *, exclusive: bool) -> None:
        self.engaged = True
        self._released_at[k] = hand.offset
        hand.release(exclusive=exclusive)

    # ------------------------------------------------------------------ gates

    def gate(self, gate: QueueRecord, path: Interpolator, pressed: bool, settled: bool) -> Passage:
        """The path stands at one of `GATES`. `settled`: the axes are where they were sent to."""
        if gate.reason is GateReason.MANUAL:
            return self._by_hand(gate, path, pressed, settled)
        if gate.reason is GateReason.MANUAL_END:
            return self._hand_away(gate)
        if gate.reason is GateReason.HOMING:
            return self._home(gate, path, settled)
        return self._passage(path, settled, StopCondition.EXACT_STOP)

    def _by_hand(self, gate: QueueRecord, path: Interpolator, pressed: bool, settled: bool) -> Passage:
        if not self._gate_begun:
            self._gate_begun = True
            for k, hand in enumerate(self.axes):
                if gate.number >> k & 1:
                    self._release(k, hand, exclusive=True)
        if pressed and not self._leaving:
            self._leaving = True
            for hand in self.axes:
                hand.close(at_once=self._parameters.path_reject_std_manual_mode)
        if not self._leaving:
            return Passage(False, StopCondition.MANUAL | StopCondition.WAIT_CONTINUE)
        return self._passage(path, settled, StopCondition.MANUAL)

    def _passage(self, path: Interpolator, settled: bool, stop: StopCondition) -> Passage:
        """The path takes over where the axes are, when they stand there."""
        if not (self.at_rest and path.standstill and settled):
            return Passage(False, stop)
        self._gate_begun = self._leaving = False
        return Passage(True)

    def take_over(self, path: Interpolator) -> Floats:
        """The path goes on from where the axes are: the offsets that it has taken, (n_axes,)."""
        taken = self.by_hand.copy()
        path.resume_at(path.position + taken)
        for hand in self.axes:
            hand.restart()
        self.by_hand[:] = 0.0
        self._sum()
        self.engaged = any(hand.released for hand in self.axes)
        return taken

    def set_position(self, gate: QueueRecord, path: Interpolator, *, locked: bool) -> None:
        """SET_POSITION, where everything stands and nothing is beside the path: no axis moves, it counts anew."""
        k, place = gate.number, path.position.copy()
        shift = gate.value if gate.offset else gate.value - float(place[k])
        place[k] += shift
        path.resume_at(place)
        if not locked:
            self._shift(k, shift)
            self.referenced[k] = True

    def couple(self, pairs: Sequence[tuple[int, int, float]], path: Interpolator) -> None:
        """Where the path stands: (slave, master, how far the slave is ahead) from here on; what no longer follows stays."""
        place = path.position + self.coupled
        path.resume_at(place)
        self._couplings = [(slave, master, ahead, float(place[slave])) for slave, master, ahead in pairs]
        self._follow(path)

    def _follow(self, path: Interpolator) -> None:
        """Where the masters lead their slaves in this cycle: where they are sent to, behind their filters."""
        self.coupled[:] = 0.0
        place = path.set_point
        for slave, master, ahead, begin in self._couplings:
            self.coupled[slave] = float(place[master]) + ahead - begin
        self._sum()

    def _sum(self) -> None:
        np.add(self.by_hand, self.alone.offset, out=self.offset)
        self.offset += self.coupled

    def _hand_away(self, gate: QueueRecord) -> Passage:
        """G202: what was begun by hand is finished, or dropped if the channel is configured so (P-CHAN-00113)."""
        chosen = [hand for k, hand in enumerate(self.axes) if gate.number >> k & 1]
        if not self._gate_begun:
            self._gate_begun = True
            for hand in chosen:
                hand.close(at_once=self._parameters.path_reject_std_manual_mode)
        if not all(hand.motion.standstill for hand in chosen):
            return Passage(False, StopCondition.MANUAL)
        self._gate_begun = False
        return Passage(True)

    def moving_at_end(self, gate: QueueRecord, pressed: bool) -> str:
        """The axis that is still moved by hand where manual mode ends, "" if there is none or it may (P-CHAN-00437)."""
        ends = (gate.reason is GateReason.MANUAL_END and not self._gate_begun) or (
            gate.reason is GateReason.MANUAL and pressed and not self._leaving
        )
        if not (ends and self._parameters.err_outp_manual_mode_move):
            return ""
        chosen = (k for k, hand in enumerate(self.axes) if gate.number >> k & 1 and not hand.motion.standstill)
        return next((self._described[k].name for k in chosen), "")

    def _home(self, gate: QueueRecord, path: Interpolator, settled: bool) -> Passage:
        """Rank by rank; the next one begins when every axis of the one before has its reference."""
        if not self._gate_begun:
            self._gate_begun, self._rank = True, 0
            self.engaged = True
        if all(homing.over for homing in self._homing):
            ranks = [gate.number >> RANK_BITS * k & (1 << RANK_BITS) - 1 for k in range(len(self.axes))]
            self._rank = min((rank for rank in ranks if rank > self._rank), default=0)
            if not self._rank:
                return self._passage(path, settled, StopCondition.HOMING)
            for k, rank in enumerate(ranks):
                if rank == self._rank:
                    if self._described[k].homing is not None:
                        self.referenced[k] = False
                    self._homing[k].begin(bool(self._cam(k)))
        return Passage(False, StopCondition.HOMING)

    # ------------------------------------------------------------------ the cycle

    def begin_alone(self, gate: QueueRecord, path: Interpolator, *, locked: bool) -> None:
        """An own motion of an axis begins where the path stands; the path counts it at the target."""
        k, place = gate.number, path.position.copy()
        begin, place[k] = float(place[k]), gate.value
        path.resume_at(place)
        if not locked:
            self.alone.start(k, begin, gate.value, Dynamics(gate.feed, gate.lead, gate.seconds))
            self._sum()

    def step(self, inputs: AxisInputs, path: Interpolator, actual: Floats, *, ready: bool = True) -> Problem | None:
        """One cycle; `actual` (n_axes,) measured positions. A problem that stops the path, None if there is none.

        `ready`: all axes may move; else those that move by themselves are held with the path.
        """
        if self.alone.moving:
            held = inputs.feed_hold or not ready
            self.alone.step(inputs.alone_override, [held or hold for hold in inputs.axis_holds])
            self._sum()
        if self._couplings:
            self._follow(path)
        if not self.engaged:
            return None
        problem = None
        for k, hand in enumerate(self.axes):
            homing = self._homing[k]
            hold = inputs.feed_hold or inputs.axis_holds[k]
            if homing.over:
                least, greatest = self._reach[k] = self._bounds(k, hand, path, inputs.limits[k])
                hand.step(self._hand(hand, inputs, k, hold), least, greatest)
            else:
                problem = self._step_homing(k, homing, inputs.alone_override, hold, path, actual) or problem
            self.by_hand[k] = hand.offset
        self._sum()
        return self._leaves(path) or problem

    def _hand(self, hand: ManualAxis, inputs: AxisInputs, k: int, hold: bool) -> HandInputs:
        wheel = hand.mode is ManualMode.HANDWHEEL
        commands = self.commands
        if commands is None or not hand.released:
            return HandInputs(0, 0, inputs.alone_override, hold, inputs.blocked[k])
        override = inputs.alone_override
        if wheel and not self._parameters.override_v_handwheel:
            override = 1.0
        return HandInputs(
            0 if wheel else commands.pressed[hand.element],
            commands.pulses[hand.element] if wheel else 0,
            override,
            hold,
            inputs.blocked[k],
        )

    def _step_homing(
        self, k: int, homing: AxisHoming, override: float, hold: bool, path: Interpolator, actual: Floats
    ) -> Problem | None:
        axis = self._described[k]
        cam = self._cam(k)
        if cam is None and not homing.by_drive:
            homing.cancel()
            return Problem(alarms.HOMING_NO_SIGNAL, {"axis": axis.name})
        shift = homing.step(bool(cam), float(actual[k]), float(path.position[k]), override, hold)
        if shift:
            self._shift(k, shift)
        if homing.phase is HomingPhase.DONE:
            self.referenced[k] = True
        elif homing.phase is HomingPhase.FAILED:
            homing.phase = HomingPhase.NONE
            if homing.by_drive:
                return Problem(
                    alarms.HOMING_BY_DRIVE, {"axis": axis.name, "method": axis.homing and axis.homing.method}
                )
            return Problem(alarms.HOMING_NO_CAM, {"axis": axis.name, "way": homing.way})
        elif homing.phase is HomingPhase.LATE:
            homing.phase = HomingPhase.STOPPING
            return Problem(alarms.HOMING_LATE, {"axis": axis.name, "seconds": axis.homing and axis.homing.timeout})
        return None

    def lose_reference(self, k: int) -> None:
        """The drive of axis k was gone: its encoder may count from somewhere else."""
        if self._described[k].homing is not None:
            self.referenced[k] = False

    def _software_limits(self, k: int) -> tuple[float, float]:
        """Of an axis that knows where it is."""
        axis = self._described[k]
        if not self.referenced[k]:
            return -math.inf, math.inf
        low = -math.inf if axis.position_min is None else axis.position_min
        return low, math.inf if axis.position_max is None else axis.position_max

    def _bounds(
        self, k: int, hand: ManualAxis, path: Interpolator, dynamic: tuple[float, float] | None
    ) -> tuple[float, float]:
        """Of the offset: the software limits as seen from the path, and the relative limits from where the hand was let in."""
        place, velocity = float(path.position[k]), float(path.velocity[k])
        low, high = self._software_limits(k)
        if not hand.exclusive and self._unwatched[k]:  # the relative limits bound the offset, where it has some
            low = -math.inf if math.isfinite(hand.relative[0]) else low
            high = math.inf if math.isfinite(hand.relative[1]) else high
        if dynamic is not None:
            low, high = max(low, dynamic[0]), min(high, dynamic[1])
        if not hand.exclusive and velocity:  # where the path would come to rest
            place += math.copysign(stopping_way(self._described[k], abs(velocity), 1.0 - MANUAL_SHARE), velocity)
        sent = float(path.set_point[k])  # a filter keeps it behind the path
        least, greatest = low - min(place, sent), high - max(place, sent)
        if not hand.exclusive or self._parameters.rel_offset_limits_std_manual_mode:
            begin = self._released_at[k]
            least, greatest = max(least, begin + hand.relative[0]), min(greatest, begin + hand.relative[1])
        return least, greatest

    def _leaves(self, path: Interpolator) -> Problem | None:
        """The path will take an axis with its offset over a software limit, and has just the way left to brake before it."""
        if self._told or not self.by_hand.any():
            return None
        ahead = path_ahead(path, _LOOK_AHEAD)
        if ahead is None:
            return None
        slowest = min(self._described, key=lambda axis: axis.acceleration)
        near = (
            ahead.distance
            <= 2.0 * stopping_way(slowest, path.path_velocity, 1.0 - MANUAL_SHARE) + path.path_velocity * 0.01
        )
        for k, axis in enumerate(self._described):
            hand = self.axes[k].motion
            offset = hand.position + math.copysign(stopping_way(axis, abs(hand.velocity), MANUAL_SHARE), hand.velocity)
            offset = max(self._reach[k][0], min(offset, self._reach[k][1]))  # it brakes before the bounds by itself
            low, high = (-math.inf, math.inf) if self._unwatched[k] else self._software_limits(k)
            beyond = (ahead.lowest[:, k] + offset < low - _SMALL) | (ahead.highest[:, k] + offset > high + _SMALL)
            if self.by_hand[k] != 0.0 and bool((beyond & near).any()):
                self._told = True
                return Problem(alarms.OFFSET_LEAVES, {"axis": axis.name, "offset": float(self.by_hand[k])})
        return None

    # ------------------------------------------------------------------ orders of operator and PLC

    def take_orders(self) -> Problem | None:
        """Parameters and activations of this cycle, whether a program runs or not; a refused one as a problem."""
        commands = self.commands
        if commands is None or not (commands.activations or commands.parameters):
            return None
        for name, values in commands.parameters:
            k = self._numbers.get(int(values.log_ax_n), -1)
            if k >= 0:
                self._set_parameter(self.axes[k], name, values.width * 1e-4, values.velocity * 1e-3)
        for order in commands.activations:
            k = self._numbers.get(int(order.log_ax_n), -1)
            refused = self._activate(k, order.control_element, order.operation_mode, order.parameter_set)
            if refused is not None:
                return refused
        return None

    def _set_parameter(self, hand: ManualAxis, unit: str, width: float, velocity: float) -> None:
        stage = hand.stages[0]
        if unit == "handwheel_parameter":
            stage.resolution = width if width > 0.0 else stage.resolution
        elif unit == "continuous_parameter":
            stage.velocity = velocity if velocity > 0.0 else stage.velocity
        else:
            stage.width = width if width > 0.0 else stage.width
            stage.step_velocity = velocity if velocity > 0.0 else stage.step_velocity

    def _activate(self, k: int, element: int, mode: int, stage: int) -> Problem | None:
        name = self._described[k].name if k >= 0 else "?"
        most = HANDWHEELS if mode == ManualMode.HANDWHEEL else KEY_PAIRS
        for what, value, good in (
            ("logical axis", k, k >= 0),
            ("operation mode", mode, mode in list(ManualMode)),
            ("control element", element, element <= most),
            ("parameter set", stage, stage <= 3),
        ):
            if not good:
                return Problem(orders.MANUAL_VALUE, {"axis": name, "what": what, "value": value})
        hand = self.axes[k]
        if not hand.released:
            return Problem(orders.MANUAL_NOT_NOW, {"axis": name})
        hand.link(ManualMode(mode), element if mode else 0, stage)
        return None


def stopping_way(axis: Axis, speed: float, share: float = 1.0) -> float:
    """Greatest way of an axis until it stands, from a steady speed, with a share of its acceleration and jerk; mm, degrees."""
    acceleration, jerk = axis.acceleration * share, axis.jerk * share
    return speed * speed / (2.0 * acceleration) + speed * acceleration / (2.0 * jerk)
