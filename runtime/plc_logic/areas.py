"""Channels, axes and spindles as the PLC program sees them: what it commands, and what is in force.

A control value is an attribute. Assigning it commands, and claims the unit for the PLC: from then on the operator's
wish stands in `operator` and acts only if the program copies it. Reading gives what the CNC has put in force. `del`
gives the unit back to the operator. Units: mm or degrees, seconds, percent, rev/min.
"""

from __future__ import annotations

from runtime.hli.layout import (
    Axis,
    AxisControl,
    AxisState,
    BoolUnit,
    Channel,
    ChannelControl,
    Mode,
    State,
    StopCondition,
    Uns32Unit,
)
from runtime.hli.memory import get_text, put_text
from runtime.hli.messages import MessageTaker, Offered
from runtime.hli.modes import Wish
from runtime.hli.tools import ToolStore
from runtime.hli.units import LENGTH, PERCENT, REV_PER_MIN, SPEED


class _Area:
    """A channel or axis with control units. Its fields are read as they stand: ctypes gives numbers of Python already."""

    def __init__(self, control: ChannelControl | AxisControl) -> None:
        self._control = control
        self._units: dict[str, BoolUnit | Uns32Unit] = {}  # views are made once

    def _unit(self, name: str) -> BoolUnit | Uns32Unit:
        unit = self._units.get(name)
        if unit is None:
            unit = self._units[name] = getattr(self._control, name)
        return unit


class _Command:
    """A control value: an attribute of an area that stands for one of its control units."""

    def __init__(self, unit: str, doc: str) -> None:
        self._name = unit
        self.__doc__ = doc

    def __delete__(self, area: _Area) -> None:
        area._unit(self._name).enable_w = False


# Members by their numbers: making one from a number costs ten times as much as looking it up.
_MODES = {int(mode): mode for mode in Mode}
_STATES = {int(state): state for state in State}
_RUNS = (int(State.ACTIVE), int(State.HOLD))
_AXIS_STATES = {0: AxisState.HOLD} | {int(state): state for state in AxisState}


class BoolCommand(_Command):
    """A control value that is TRUE or FALSE."""

    def __get__(self, area: _Area, owner: type[_Area]) -> bool:
        return bool(area._unit(self._name).state_r)

    def __set__(self, area: _Area, value: bool) -> None:
        unit = area._unit(self._name)
        unit.command_w = bool(value)
        unit.enable_w = True


class PercentCommand(_Command):
    """A control value in percent."""

    def __get__(self, area: _Area, owner: type[_Area]) -> float:
        return float(area._unit(self._name).state_r) * PERCENT

    def __set__(self, area: _Area, value: float) -> None:
        unit = area._unit(self._name)
        unit.command_w = max(round(value / PERCENT), 0)
        unit.enable_w = True


class _OneShot:
    """A command that the CNC confirms in `state_r`; the PLC takes it back then."""

    def __init__(self, unit: BoolUnit) -> None:
        self._unit = unit
        self._given = False

    def give(self) -> None:
        self._unit.command_w = True
        self._unit.enable_w = True
        self._given = True

    def update(self) -> None:
        if self._given and self._unit.state_r:
            self._unit.command_w = False
            self._unit.enable_w = False  # the unit is the operator's again
            self._given = False


class OperatorWishes:
    """What the operator asks of a channel, for programs that have claimed the unit."""

    def __init__(self, control: ChannelControl) -> None:
        self._control = control

    @property
    def feed_hold(self) -> bool:
        return bool(self._control.feedhold.request_r)

    @property
    def override(self) -> float:
        """Percent."""
        return float(self._control.override.request_r) * PERCENT

    @property
    def single_block(self) -> bool:
        return bool(self._control.single_block.request_r)

    @property
    def optional_stop(self) -> bool:
        return bool(self._control.optional_stop.request_r)


class NcMessage:
    """A message of the NC program for the PLC (#MSG PLC). It waits until `acknowledge` is called."""

    def __init__(self, taker: MessageTaker, message: Offered) -> None:
        self._taker = taker
        self._message = message

    @property
    def text(self) -> str:
        return self._message.text

    @property
    def information(self) -> bool:
        """#MSG INFO: the text is no text for people, but for this program."""
        return self._message.information

    def acknowledge(self) -> None:
        """It was read: the next one may come, and an NC program that waits for this goes on."""
        self._taker.take(self._message)


class ChannelPort(_Area):
    """One NC channel."""

    feed_hold = BoolCommand("feedhold", "Stop on the path, and go on when it is taken back.")
    override = PercentCommand("override", "Feed override, percent.")
    single_block = BoolCommand("single_block", "Wait for continue_motion() after each block.")
    optional_stop = BoolCommand("optional_stop", "M01 stops.")

    def __init__(self, channel: Channel) -> None:
        super().__init__(channel.control)
        self._channel = channel
        self._status = channel.status
        self._modes = channel.control.mode_and_state
        self._continue = _OneShot(channel.control.continue_motion)
        self._reset = _OneShot(channel.control.reset)
        self._messages = MessageTaker(channel)
        self.tools = ToolStore(channel)  # for an external tool management: requests, answers, tool life
        self._waiting: Wish | None = None
        self.claims_orders = False  # TRUE: the operator's orders (start, stop) wait for allow_order or refuse_order
        self.operator = OperatorWishes(channel.control)
        self.name = get_text(channel, "name_r")

    # ------------------------------------------------------------------ orders

    def start(self, program: str) -> None:
        """Start an NC program in AUTOMATIC. A newer order replaces one that the CNC has not yet taken."""
        self._waiting = Wish(Mode.AUTOMATIC, State.ACTIVE, program)

    def stop(self) -> None:
        """Stop on the path and end the program."""
        self._waiting = Wish(self.mode, State.SELECTED)

    @property
    def requested_order(self) -> Wish | None:
        """The operator's order that waits for the program's decision; needs `claims_orders`."""
        request = self._modes.request_r
        if not (self.claims_orders and self._modes.request_semaphor_rw):
            return None
        return Wish(request.to_mode, request.to_state, get_text(request, "parameter"))

    def allow_order(self) -> None:
        """Carry the operator's order out."""
        self._waiting = self.requested_order or self._waiting
        self._modes.request_semaphor_rw = False

    def refuse_order(self) -> None:
        """Forget the operator's order."""
        self._modes.request_semaphor_rw = False

    def reset(self) -> None:
        """Stop, end the program, clear errors, drop the technology functions that wait."""
        self._reset.give()

    def continue_motion(self) -> None:
        """Go on after M00, M01 or single block; without effect while nothing waits for it."""
        if self.waits_for_continue:
            self._continue.give()

    # ------------------------------------------------------------------ messages

    @property
    def message(self) -> NcMessage | None:
        """The message of the NC program that waits for this program. After ten that nobody takes the path stops."""
        offered = self._messages.offered()
        return None if offered is None else NcMessage(self._messages, offered)

    # ------------------------------------------------------------------ status

    @property
    def mode(self) -> Mode:
        return _MODES[self._modes.mode_r]

    @property
    def state(self) -> State:
        return _STATES[self._modes.state_r]

    @property
    def running(self) -> bool:
        """A program is ACTIVE or in HOLD."""
        return self._modes.state_r in _RUNS

    @property
    def error(self) -> int:
        """Id of the error that stopped the channel, 0 none."""
        value: int = self._status.error_id_r
        return value

    @property
    def program(self) -> str:
        return get_text(self._status, "program_name_r")

    @property
    def line(self) -> int:
        """Program line of the block that is moving."""
        value: int = self._status.line_r
        return value

    @property
    def block_number(self) -> int:
        """N word of that block, -1 if it has none."""
        value: int = self._status.block_number_r
        return value

    @property
    def feed(self) -> float:
        """Active path feed, mm/s."""
        value: float = self._status.active_feed_r * SPEED
        return value

    @property
    def path_position(self) -> float:
        """Path since program start, mm."""
        value: float = self._status.path_position_r * LENGTH
        return value

    @property
    def waits_for_continue(self) -> bool:
        value: bool = self._status.wait_continue_r
        return value

    @property
    def stop_condition(self) -> StopCondition:
        """Why the path does not move although a program is active."""
        return StopCondition(self._status.stop_condition_r)

    def update(self) -> None:
        """End of a PLC cycle: hand over orders, take confirmed commands back. Called by the host."""
        self._reset.update()
        self._continue.update()
        modes = self._modes
        if modes.command_semaphor_rw:
            return  # not taken yet
        if self._waiting is not None:
            wish, self._waiting = self._waiting, None
            order = modes.command_w
            order.from_mode = 0
            order.from_state = 0
            order.to_mode = wish.to_mode
            order.to_state = wish.to_state
            put_text(order, "parameter", wish.parameter)
            modes.enable_w = True
            modes.command_semaphor_rw = True
        elif not self.claims_orders and modes.request_semaphor_rw:
            # the operator ordered while our own order held the unit: pass it on before giving the unit back
            modes.command_w = modes.request_r
            modes.request_semaphor_rw = False
            modes.command_semaphor_rw = True
        else:
            modes.enable_w = self.claims_orders


class AxisPort(_Area):
    """One axis: mm or degrees, and seconds."""

    drive_on = BoolCommand("drive_on", "The drive is to be enabled.")
    release = BoolCommand(
        "release_feedhold", "Feed enable: without it the axis, and every path it takes part in, stands."
    )
    feed_hold = BoolCommand("feedhold", "Hold this axis.")
    override = PercentCommand("override", "Override of an axis that moves alone, or of a spindle; percent.")

    def __init__(self, axis: Axis) -> None:
        super().__init__(axis.control)
        self._axis = axis
        self._status = axis.status
        self._reset = _OneShot(axis.control.reset)
        self.name = get_text(axis, "name_r")

    def reset(self) -> None:
        """Acknowledge an error of the axis or its drive."""
        self._reset.give()

    @property
    def state(self) -> AxisState:
        return _AXIS_STATES[self._status.axis_state_r]

    @property
    def position(self) -> float:
        """Actual position."""
        value: float = self._status.actual_position_r * LENGTH
        return value

    @property
    def commanded_position(self) -> float:
        value: float = self._status.command_position_r * LENGTH
        return value

    @property
    def target(self) -> float:
        """Where the present move ends."""
        value: float = self._status.target_position_r * LENGTH
        return value

    @property
    def lag(self) -> float:
        """Following error."""
        value: float = self._status.position_lag_r * LENGTH
        return value

    @property
    def velocity(self) -> float:
        value: float = self._status.actual_velocity_r * SPEED
        return value

    @property
    def in_position(self) -> bool:
        value: bool = self._status.in_position_r
        return value

    @property
    def referenced(self) -> bool:
        value: bool = self._status.referenced_r
        return value

    @property
    def error(self) -> bool:
        value: bool = self._axis.error_r
        return value

    def update(self) -> None:
        """End of a PLC cycle. Called by the host."""
        self._reset.update()


class SpindlePort(AxisPort):
    """One spindle: speeds in rev/min."""

    def __init__(self, axis: Axis) -> None:
        super().__init__(axis)
        self._spindle = axis.spindle

    @property
    def speed(self) -> float:
        """Actual speed."""
        value: float = self._spindle.actual_speed_r * REV_PER_MIN
        return value

    @property
    def commanded_speed(self) -> float:
        """Speed after override and ramp."""
        value: float = self._spindle.command_speed_r * REV_PER_MIN
        return value

    @property
    def programmed_speed(self) -> float:
        """S word."""
        value: float = self._spindle.programmed_speed_r * REV_PER_MIN
        return value

    @property
    def at_speed(self) -> bool:
        value: bool = self._spindle.rev_erreicht_r
        return value

    @property
    def standing(self) -> bool:
        value: bool = self._spindle.rev_null_r
        return value
