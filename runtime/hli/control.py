"""The CNC's side of the control units: what holds in this cycle, from the PLC where it has claimed the unit, else the
operator.

A unit is the PLC's if the area's `plc_present_w` and the unit's `enable_w` are both TRUE; then the operator's wish
only lands in `request_r`, for the PLC to copy or to ignore. Otherwise the operator acts directly, and without an
operator the defaults hold: override 100 %, no feed hold, axes released (hli.mech.operation-without-plc).
"""

from __future__ import annotations

import ctypes
import math
from dataclasses import dataclass, replace

from runtime.diagnostics.errors import Problem
from runtime.hli.block_search import SearchOrders
from runtime.hli.layout import (
    Axis,
    AxisControl,
    Blocked,
    BoolUnit,
    Channel,
    ChannelControl,
    ModeState,
    ModeStateUnit,
    OperatorUnit,
    Uns32Unit,
    Uns64Unit,
)
from runtime.hli.memory import get_text, put_text
from runtime.hli.modes import Wish
from runtime.hli.units import LENGTH, SPEED

FULL_OVERRIDE = 1000  # 0.1 %
GREATEST_OVERRIDE = 2000  # 0.1 %
NO_TORQUE_LIMIT = 0xFFFF_FFFF


def sample_bool(unit: BoolUnit, present: bool, operator: bool) -> bool:
    """The value in force in this cycle; `operator` is the operator's value, or the default where there is none."""
    unit.request_r = operator
    value = bool(unit.command_w) if present and unit.enable_w else operator
    unit.state_r = value
    return value


def sample_uns32(unit: Uns32Unit | Uns64Unit, present: bool, operator: int) -> int:
    """The same for whole numbers."""
    unit.request_r = operator
    value = int(unit.command_w) if present and unit.enable_w else operator
    unit.state_r = value
    return value


class OneShot:
    """A command that acts once per rising edge (reset, continue). `state_r` follows: the PLC takes its command back
    then.

    The operator's flag is lowered when it is taken. Routed to the PLC it stays visible in `request_r` until the PLC
    commands, or until `withdraw`.
    """

    def __init__(self, unit: BoolUnit, operator: OperatorUnit | None = None, flag: str = "") -> None:
        self._unit = unit
        self._operator = operator
        self._flag = flag
        self._before = False

    def sample(self, present: bool) -> bool:
        """Whether the command is given in this cycle."""
        unit = self._unit
        claimed = present and bool(unit.enable_w)
        asked = self._operator is not None and bool(getattr(self._operator, self._flag))
        if asked:
            setattr(self._operator, self._flag, False)
            unit.request_r = True
        command = claimed and bool(unit.command_w)
        edge = (command and not self._before) or (asked and not claimed)
        self._before = command
        unit.state_r = command
        if edge or not claimed:
            unit.request_r = False
        return edge

    def withdraw(self) -> None:
        """What was asked for is no longer of any use (nothing waits, nothing to reset)."""
        self._unit.request_r = False


class ModeAgreement:
    """The CNC asks the PLC before it changes the mode, and waits until it agrees. Who is not there, or has not claimed the unit,
    has nothing against it."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel
        self._unit = channel.lc_mode
        self._asked = False

    def given(self, mode: int) -> bool:
        """Whether the mode may change now; asks if nobody has asked yet."""
        unit = self._unit
        if not (self._channel.plc_present_w and unit.enable_w):
            self.withdraw()
            return True
        if not self._asked:
            self._asked = True
            unit.mode_r = mode
            unit.done_w = False
            unit.please_rw = True
            return False
        if unit.please_rw or not unit.done_w:
            return False
        self._asked = False
        return True

    def withdraw(self) -> None:
        """The mode is no longer wanted."""
        if self._asked:
            self._asked = False
            self._unit.please_rw = False


@dataclass(frozen=True, slots=True)
class Order:
    """An order of the mode unit; `by_operator`: he waits for the answer; `asked`: it is his, also where the PLC hands it on."""

    wish: Wish
    by_operator: bool
    asked: bool = True


class ModeOrders:
    """The mode unit of a channel, with usage check: orders are taken one by one."""

    def __init__(self, unit: ModeStateUnit, operator: OperatorUnit) -> None:
        self._unit = unit
        self._operator = operator
        self._order: Order | None = None
        self._handed_over: Wish | None = None  # to the PLC

    def take(self, present: bool) -> Order | None:
        """The next order, or None. Each order must be closed by `answer` before the next one is taken."""
        unit, operator = self._unit, self._operator
        claimed = present and bool(unit.enable_w)
        if not present:
            unit.request_semaphor_rw = False  # who had claimed it is gone: nothing may start because of that
        if claimed and operator.order_semaphor_rw and not unit.request_semaphor_rw:
            unit.request_r = operator.order_w
            unit.request_semaphor_rw = True
            self._handed_over = _wish(unit.request_r)
            self._tell_operator(None)
        if self._order is not None:
            return None
        if claimed and unit.command_semaphor_rw:
            wish = _wish(unit.command_w)
            self._order = Order(wish, by_operator=False, asked=_same(wish, self._handed_over))
            self._handed_over = None
            unit.command_semaphor_rw = False
        elif unit.request_semaphor_rw and not claimed:  # the PLC has given the unit back with a request in it
            self._order = Order(_wish(unit.request_r), by_operator=False)
            unit.request_semaphor_rw = False
        elif operator.order_semaphor_rw and not claimed:
            self._order = Order(_wish(operator.order_w), by_operator=True)
        return self._order

    def answer(self, refusal: Problem | None = None) -> None:
        """Close the order that was taken: accepted, or refused because of a problem."""
        order, self._order = self._order, None
        if order is not None and order.by_operator:
            self._tell_operator(refusal)

    def _tell_operator(self, refusal: Problem | None) -> None:
        operator = self._operator
        operator.answer_r = refusal.entry.id if refusal else 0
        put_text(operator, "answer_text_r", refusal.text if refusal else "")
        operator.order_semaphor_rw = False


def _wish(order: ModeState) -> Wish:
    return Wish(order.to_mode, order.to_state, get_text(order, "parameter"), order.from_mode, order.from_state)


def _same(order: Wish, asked: Wish | None) -> bool:
    """The PLC hands on what the operator has asked for; where from it may have left out."""
    return asked is not None and replace(order, from_mode=0, from_state=0) == replace(asked, from_mode=0, from_state=0)


class Changes:
    """Tells cheaply whether anybody has written into a run of elements since the last look.

    Look first, sample then: what is written in between is a change at the next look, so nothing is lost. The sampler's own
    writes are one too; then it samples once more than it had to.
    """

    def __init__(self, structure: ctypes.Structure, first: str, last: str) -> None:
        """Looks at the elements from `first` to `last`."""
        begin, end = getattr(type(structure), first), getattr(type(structure), last)
        self._raw = memoryview(structure).cast("B")[begin.offset : end.offset + end.size]
        self._before = b""

    def look(self) -> bool:
        """Whether anything is other than at the last look; TRUE at the first one."""
        now = self._raw.tobytes()
        if now == self._before:
            return False
        self._before = now
        return True


class ChannelCommands:
    """All control units of a channel; `sample` once per cycle, then read the attributes."""

    def __init__(self, channel: Channel, operator: OperatorUnit, max_override: int = FULL_OVERRIDE) -> None:
        """`max_override` is P-CHAN-00056, 0.1 %."""
        control: ChannelControl = channel.control
        self._channel = channel
        self._status = channel.status
        self._control = control
        self._operator = operator
        self._changes = Changes(control, "feedhold", "stop_level")
        self._operator_changes = Changes(operator, "override_w", "simulate_motion_w")
        self._flags_before = (False, False)
        self._max_override = max_override
        self._continue = OneShot(control.continue_motion, operator, "continue_motion_rw")
        self._reset = OneShot(control.reset, operator, "reset_rw")
        self.modes = ModeOrders(control.mode_and_state, operator)
        self.search = SearchOrders(control, operator)
        self.feed_hold = False
        self.override = 1.0  # share of the programmed feed
        self.rapid_override = 1.0
        self.external_feed = -1.0  # mm/s, in place of the programmed feed; negative: there is none
        self.feeds_backward = False  # it is one below 0: the path is driven backward
        self.time_override = 1.0
        self.single_block = False
        self.optional_stop = False
        self.skip_levels = 0  # bit n-1 = level n
        self.continue_motion = False  # TRUE in one cycle only
        self.reset = False  # TRUE in one cycle only
        self.machine_lock = False
        self.read_disable = False
        self.delete_distance = False  # TRUE in one cycle only
        self.backward = False
        self.backward_storage_off = False
        self.simulate_motion = False
        self.simulate_mask = 0
        self.stop_level = 0
        self._delete = OneShot(control.delete_distance_to_go)

    def sample(self) -> None:
        """Read what is commanded in this cycle and report it in the `state_r` of the units."""
        present, waits = self._channel.plc_present_w, self._status.wait_continue_r
        flags = (present, waits)
        changed = self._changes.look() | self._operator_changes.look()
        if flags == self._flags_before and not changed:
            self.continue_motion = self.reset = self.delete_distance = False
            return
        self._flags_before = flags
        control, operator = self._control, self._operator
        self.feed_hold = sample_bool(control.feedhold, present, bool(operator.feedhold_w))
        override = min(sample_uns32(control.override, present, int(operator.override_w)), self._max_override)
        if not sample_bool(control.override_valid, present, True):
            override = FULL_OVERRIDE
        control.override.state_r = override
        self.override = override / FULL_OVERRIDE
        rapid = min(sample_uns32(control.rapid_override, present, FULL_OVERRIDE), self._max_override)
        if not sample_bool(control.rapid_override_valid, present, True):
            rapid = FULL_OVERRIDE
        control.rapid_override.state_r = rapid
        self.rapid_override = rapid / FULL_OVERRIDE
        self.external_feed = self._external_feed(control, present)
        time_override = min(sample_uns32(control.time_override, present, FULL_OVERRIDE), GREATEST_OVERRIDE)
        if not sample_bool(control.time_override_valid, present, True):
            time_override = FULL_OVERRIDE
        control.time_override.state_r = time_override
        self.time_override = time_override / FULL_OVERRIDE
        self.single_block = sample_bool(control.single_block, present, bool(operator.single_block_w))
        self.optional_stop = sample_bool(control.optional_stop, present, bool(operator.optional_stop_w))
        self.skip_levels = sample_uns32(control.program_block_ignore, present, int(operator.program_block_ignore_w))
        self.continue_motion = self._continue.sample(present)
        if not waits:
            self._continue.withdraw()
        self.reset = self._reset.sample(present)
        self.machine_lock = sample_bool(control.machine_lock, present, bool(operator.machine_lock_w))
        self.read_disable = sample_bool(control.read_disable, present, False)
        self.delete_distance = self._delete.sample(present)
        backward = sample_bool(control.backward_motion, present, bool(operator.backward_motion_w))
        self.backward = backward or self.feeds_backward
        self.backward_storage_off = sample_bool(control.backward_storage_off, present, False)
        self.simulate_motion = sample_bool(control.simulate_motion, present, bool(operator.simulate_motion_w))
        self.stop_level = sample_uns32(control.stop_level, present, 0)
        self.simulate_mask = sample_uns32(control.simulate_motion_mask, present, 0) & 2**63 - 1

    def _external_feed(self, control: ChannelControl, present: bool) -> float:
        """A feed of the PLC in mm/s, -1 for none; one below 0 drives the path backward with its amount."""
        valid = sample_bool(control.ext_command_speed_valid, present, False)
        unit = control.ext_command_speed
        speed = int(unit.command_w) if valid and unit.enable_w else 0
        unit.state_r = speed
        self.feeds_backward = speed < 0
        return abs(speed) * SPEED if valid and unit.enable_w else -1.0


class AxisCommands:
    """All control units of an axis or spindle; `sample` once per cycle, then read the attributes."""

    def __init__(self, axis: Axis, max_override: int = 2 * FULL_OVERRIDE) -> None:
        control: AxisControl = axis.control
        self._axis = axis
        self._control = control
        self._max_override = max_override
        self._changes = Changes(control, "drive_on", "torque_limit_valid")
        self._present_before: bool | None = None
        self._reset = OneShot(control.reset)
        self.drive_on = True  # with torque permission, and no follow-up
        self.release = True  # feed enable
        self.feed_hold = False
        self.parked = False  # wanted; taken over while no program runs
        self.blocked = 0  # Blocked
        self.reference_cam: bool | None = None  # None: the PLC does not tell
        self.limits: tuple[float, float] | None = None  # dynamic ones, mm or degrees
        self.lag_monitored = True
        self.override = 1.0  # spindles and axes moved alone
        self.torque_limit = math.inf  # share of the rated torque
        self.reset = False  # TRUE in one cycle only
        self._spindle_reset = OneShot(control.spdl_reset)
        self.spindle_reset = False  # TRUE in one cycle only
        self.spindle_error = False
        self.spindle_stops_at_end = False

    def sample(self) -> bool:
        """Read what is commanded in this cycle; without a PLC drives are on, axes released, override 100 %.

        FALSE if nobody has written since the last cycle: everything is as it was, and `reset` is FALSE.
        """
        present = self._axis.plc_present_w
        changed = self._changes.look()
        if present == self._present_before and not changed:
            self.reset = self.spindle_reset = False
            return False
        self._present_before = present
        control = self._control
        self.spindle_reset = self._spindle_reset.sample(present)
        self.spindle_error = sample_bool(control.spdl_error, present, False)
        self.spindle_stops_at_end = sample_bool(control.spdl_stop_at_prog_end, present, False)
        self.parked = sample_bool(control.parked, present, False)
        on = sample_bool(control.drive_on, present, True)
        torque = sample_bool(control.torque_permission, present, True)
        self.drive_on = on and torque and not sample_bool(control.follow_up, present, False)
        self.release = sample_bool(control.release_feedhold, present, True)
        self.feed_hold = sample_bool(control.feedhold, present, False)
        self.blocked = sample_uns32(control.directional_feedhold, present, 0) & (Blocked.PLUS | Blocked.MINUS)
        cam = sample_bool(control.reference_cam, present, False)
        self.reference_cam = cam if present and control.reference_cam.enable_w else None
        self.lag_monitored = not sample_bool(control.lag_monitoring_off, present, False)
        self.limits = self._dynamic_limits(present)
        override = min(sample_uns32(control.override, present, FULL_OVERRIDE), self._max_override)
        if not sample_bool(control.override_valid, present, True):
            override = FULL_OVERRIDE
        control.override.state_r = override
        self.override = override / FULL_OVERRIDE
        limited = sample_bool(control.torque_limit_valid, present, False)
        most = sample_uns32(control.torque_limit, present, NO_TORQUE_LIMIT) if limited else NO_TORQUE_LIMIT
        control.torque_limit.state_r = most
        self.torque_limit = math.inf if most == NO_TORQUE_LIMIT else most / FULL_OVERRIDE
        self.reset = self._reset.sample(present)
        return True

    def show_spindle_reset(self, runs: bool) -> None:
        """Whether the reset of the spindle still runs."""
        if self._control.spdl_reset.state_r != runs:
            self._control.spdl_reset.state_r = runs

    def show_parked(self, parked: bool) -> None:
        """Whether the axis is really out of use."""
        unit = self._control.parked
        if unit.state_r != parked:
            unit.state_r = parked

    def show_limits(self, state: int) -> None:
        """How the axis stands to its dynamic limits."""
        for unit in (self._control.dyn_pos_limit_low, self._control.dyn_pos_limit_high):
            if unit.state_r != state:
                unit.state_r = state

    def _dynamic_limits(self, present: bool) -> tuple[float, float] | None:
        low, high = self._control.dyn_pos_limit_low, self._control.dyn_pos_limit_high
        if not present or not (low.enable_w or high.enable_w):
            low.state_r = high.state_r = 0
            return None
        return (
            low.command_w * LENGTH if low.enable_w else -math.inf,
            high.command_w * LENGTH if high.enable_w else math.inf,
        )
