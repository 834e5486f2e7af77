"""What the PLC orders of spindles: the orders of a program, a stop at its end, reset, error (hli.sp.cu).

Orders of the channel and of the PLC are done as they arrive: the last one holds. A spindle with an error that the PLC reports
stops, and takes no order as long as it is reported.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np
import numpy.typing as npt

from runtime.cnc.axes.spindle import DEGREES_PER_SECOND, TURN, Spindle, SpindleOrder
from runtime.diagnostics.catalogue import axis_jobs as errors
from runtime.diagnostics.errors import Problem
from runtime.hli.layout import Hli, SpindleCommandKind, SpindleWay
from runtime.hli.spindle_commands import KINDS, SpindleCall, SpindleSlot, shown

Kind = SpindleCommandKind
_RANGES: Mapping[Kind, tuple[float, float]] = {
    Kind.ACCELERATION: (0.01, 10.0),
    Kind.FEED_FORWARD: (0.0, 1.0),
    Kind.SPEED_FACTOR: (0.001, 2.0),
}


class SpindleUnits(Protocol):
    """What the control units of a spindle say in this cycle."""

    spindle_reset: bool
    spindle_error: bool
    spindle_stops_at_end: bool

    def show_spindle_reset(self, runs: bool) -> None:
        """Whether the reset of the spindle still runs."""


class _Ordered:
    """One spindle."""

    def __init__(self, spindle: Spindle, slot: SpindleSlot, units: SpindleUnits) -> None:
        self.spindle = spindle
        self.slot = slot
        self.units = units
        self.resets = False
        self.error = False


class SpindleOrders:
    """Of all spindles of the channel; `step` is called once per cycle, before they are moved."""

    def __init__(
        self, hli: Hli, spindles: Sequence[Spindle], units: Mapping[int, SpindleUnits], plc: frozenset[int]
    ) -> None:
        """`units` by the index of the spindle in the machine; `plc`: indices of those that the PLC moves itself."""
        self._all = [_Ordered(s, SpindleSlot(hli.axes[s.index]), units[s.index]) for s in spindles]
        self._plc = plc
        self._active = False
        self.problems: list[tuple[int, Problem]] = []  # with the index of the spindle; taken by the controller

    def step(self, enabled: Sequence[bool], speeds: npt.NDArray[np.float64], *, active: bool) -> None:
        """`speeds`: actual ones, degrees/s, by the index in the machine; `active`: a program runs."""
        ended, self._active = self._active and not active, active
        for ordered in self._all:
            spindle, units = ordered.spindle, ordered.units
            if ended and units.spindle_stops_at_end:
                spindle.stop()
            if units.spindle_error:
                self._fail(ordered)
            elif ordered.error:
                ordered.error = False
            if units.spindle_reset:
                spindle.reset()
                ordered.resets = True
            if ordered.resets:
                ordered.resets = not spindle.standing(float(speeds[spindle.index]))
                units.show_spindle_reset(ordered.resets)
            call = ordered.slot.take()
            if call is not None:
                what = self._refusal(ordered, call, enabled[spindle.index])
                ordered.slot.answer(errors.SPINDLE_ORDER.id if what else 0)
                if what:
                    values = {"spindle": spindle.axis.name, "order": shown(call.kind), "what": what}
                    self.problems.append((spindle.index, Problem(errors.SPINDLE_ORDER, values)))
                else:
                    _obey(spindle, call)

    def _fail(self, ordered: _Ordered) -> None:
        spindle = ordered.spindle
        spindle.stop()
        if not ordered.error:
            ordered.error = True
            self.problems.append((spindle.index, Problem(errors.SPINDLE_ERROR, {"spindle": spindle.axis.name})))

    def _refusal(self, ordered: _Ordered, call: SpindleCall, enabled: bool) -> str:
        """Why an order is not done, "" if it is."""
        spindle = ordered.spindle
        if spindle.index in self._plc:
            return "the PLC moves it itself"
        if call.kind not in KINDS:
            return "there is no such order"
        kind = Kind(call.kind)
        if spindle.follows:
            return "it follows the path (tapping)"
        if ordered.error:
            return "the PLC reports an error of it"
        turns = kind in (Kind.M3, Kind.M4, Kind.M19, Kind.SPEED, Kind.OVERRIDE_OFF)
        if turns and not enabled:
            return "its drive is off"
        if call.speed < 0.0:
            return "the speed is negative"
        if kind is Kind.M19:
            if not (call.speed or spindle.programmed_speed) > 0.0:
                return "M19 has no speed"
            if not call.way & SpindleWay.ABSOLUTE and abs(call.angle) >= TURN:
                return "a way has to be less than a turn"
        if kind is Kind.GEAR and call.value not in range(1, spindle.stages + 1):
            return f"gear stage {call.value:g}: it has {spindle.stages}"
        least, greatest = _RANGES.get(kind, (-math.inf, math.inf))
        if not least <= call.value <= greatest:
            return f"{call.value:g} is outside of {least:g} to {greatest:g}"
        return ""


def _obey(spindle: Spindle, call: SpindleCall) -> None:
    """What is done at once, from the next step on."""
    kind = Kind(call.kind)
    speed = (call.speed or spindle.programmed_speed) / DEGREES_PER_SECOND
    if kind is Kind.HOMING:
        spindle.home()
    elif kind is Kind.GEAR:
        spindle.select_stage(int(call.value) - 1)
    elif kind is Kind.ACCELERATION:
        spindle.weigh(acceleration=call.value)
    elif kind is Kind.SPEED_FACTOR:
        spindle.weigh(speed=call.value)
    elif kind is Kind.FEED_FORWARD:
        spindle.feed_forward = call.value
    elif kind is Kind.OVERRIDE_OFF:
        spindle.command(SpindleOrder(0, speed, override_off=True))
    elif kind is Kind.SPEED:
        spindle.command(SpindleOrder(0, call.speed / DEGREES_PER_SECOND))
    elif kind is Kind.M19:
        angle, sense = call.angle, 0
        if not call.way & SpindleWay.ABSOLUTE:
            angle = spindle.angle + call.angle
            if not call.way & SpindleWay.SHORTEST:
                sense = 3 if call.angle >= 0.0 else 4
        spindle.command(SpindleOrder(19, speed, angle, sense))
    else:
        spindle.command(SpindleOrder(int(kind), speed))
