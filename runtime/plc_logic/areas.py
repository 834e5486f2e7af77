"""Channels, axes and spindles as the PLC program sees them: what it commands, and what is in force.

A control value is an attribute. Assigning it commands, and claims the unit for the PLC: from then on the operator's
wish stands in `operator` and acts only if the program copies it. Reading gives what the CNC has put in force. `del`
gives the unit back to the operator. Units: mm or degrees, seconds, percent, rev/min.
"""

from __future__ import annotations

from collections import deque

from runtime.hli.axis_jobs import JobGiver
from runtime.hli.error_messages import ErrorMessage, ErrorTaker
from runtime.hli.layout import (
    KEYS,
    MAX_AXES,
    Axis,
    AxisControl,
    AxisState,
    BoolUnit,
    Channel,
    ChannelControl,
    ManualControl,
    ManualMode,
    Mode,
    MotionState,
    SearchState,
    Sgn32Unit,
    SpindleCommandKind,
    SpindleWay,
    State,
    StopCondition,
    Uns32Unit,
)
from runtime.hli.memory import get_text, put_text
from runtime.hli.messages import LIMIT, MessageTaker, Offered
from runtime.hli.modes import Wish
from runtime.hli.spindle_commands import SpindleCall, SpindleCaller
from runtime.hli.tools import ToolStore
from runtime.hli.units import LENGTH, PERCENT, REV_PER_MIN, SPEED, to_int32


class _Area:
    """A channel or axis with control units. Its fields are read as they stand: ctypes gives numbers of Python already."""

    def __init__(self, control: ChannelControl | AxisControl) -> None:
        self._control = control
        self._units: dict[str, BoolUnit | Uns32Unit | Sgn32Unit] = {}  # views are made once
        self._flags: dict[str, memoryview[bool]] = {}  # of units of BOOL, element by element

    def _unit(self, name: str) -> BoolUnit | Uns32Unit | Sgn32Unit:
        unit = self._units.get(name)
        if unit is None:
            unit = self._units[name] = getattr(self._control, name)
        return unit

    def _flags_of(self, name: str) -> memoryview[bool]:
        """The elements of a unit of BOOL; a flag is written through them in half the time that its structure takes."""
        flags = self._flags[name] = memoryview(self._unit(name)).cast("B").cast("?")
        return flags


class _Command:
    """A control value: an attribute of an area that stands for one of its control units."""

    def __init__(self, unit: str, doc: str) -> None:
        self._name = unit
        self.__doc__ = doc

    def __delete__(self, area: _Area) -> None:
        area._unit(self._name).enable_w = False


_COMMAND, _ENABLE = BoolUnit.command_w.offset, BoolUnit.enable_w.offset
# Members by their numbers: making one from a number costs ten times as much as looking it up.
_MODES = {int(mode): mode for mode in Mode}
_STATES = {int(state): state for state in State}
_MOTION_STATES = {int(state): state for state in MotionState}
_SEARCH_STATES = {int(state): state for state in SearchState}
_RUNS = (int(State.ACTIVE), int(State.HOLD))
_AXIS_STATES = {0: AxisState.HOLD} | {int(state): state for state in AxisState}


class BoolCommand(_Command):
    """A control value that is TRUE or FALSE."""

    def __get__(self, area: _Area, owner: type[_Area]) -> bool:
        return bool(area._unit(self._name).state_r)

    def __set__(self, area: _Area, value: bool) -> None:
        try:
            flags = area._flags[self._name]
        except KeyError:
            flags = area._flags_of(self._name)
        flags[_COMMAND] = value  # TRUE or FALSE, whatever it is
        flags[_ENABLE] = True


class PercentCommand(_Command):
    """A control value in percent."""

    def __get__(self, area: _Area, owner: type[_Area]) -> float:
        return float(area._unit(self._name).state_r) * PERCENT

    def __set__(self, area: _Area, value: float) -> None:
        unit = area._units.get(self._name) or area._unit(self._name)  # a call less
        unit.command_w = 0 if value <= 0.0 else round(value / PERCENT)
        unit.enable_w = True


class MaskCommand(_Command):
    """A control value that is a mask of bits."""

    def __get__(self, area: _Area, owner: type[_Area]) -> int:
        return int(area._unit(self._name).state_r)

    def __set__(self, area: _Area, value: int) -> None:
        unit = area._unit(self._name)
        unit.command_w = int(value)
        unit.enable_w = True


class LengthCommand(_Command):
    """A control value in mm or degrees. Reading gives the state: 0 no limit, 1 inside, 2 at it, -1 beyond it."""

    def __get__(self, area: _Area, owner: type[_Area]) -> int:
        return int(area._unit(self._name).state_r)

    def __set__(self, area: _Area, value: float) -> None:
        unit = area._unit(self._name)
        unit.command_w = to_int32(value, LENGTH)
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


class Keys:
    """Key pairs of manual mode that the program presses; a press stands until it is taken back.

    A unit is claimed only until its press is taken, so the operator's keys go on beside it.
    """

    def __init__(self, control: ManualControl) -> None:
        self._units = [control.key[i] for i in range(KEYS)]
        self._wanted: dict[int, int] = {}
        self._given: dict[int, int] = {}
        self._claimed = False  # a unit may be

    def press(self, key: int, direction: int) -> None:
        """`direction` 1 or -1 is pressed, 0 released; to be called in every cycle, or when it changes."""
        self._wanted[key] = max(-1, min(direction, 1))

    def update(self) -> None:
        """End of a PLC cycle: hand over what has changed, pass on what the operator has pressed in a claimed unit."""
        changed = [(key, wanted) for key, wanted in self._wanted.items() if self._given.get(key, 0) != wanted]
        if not (changed or self._claimed):
            return
        self._claimed = False
        for unit in self._units:
            if unit.command_semaphor_rw:
                self._claimed = True
                continue  # not taken yet
            if changed:
                self._claimed = True
                key, direction = changed.pop()
                unit.command_w.key, unit.command_w.direction, unit.command_w.hold_time = key, direction, 0
                unit.enable_w = unit.command_semaphor_rw = True
                self._given[key] = direction
            elif unit.enable_w and not unit.request_semaphor_rw:
                unit.enable_w = False
            elif unit.request_semaphor_rw:
                self._claimed = True
                unit.command_w = unit.request_r
                unit.request_semaphor_rw = False
                unit.enable_w = unit.command_semaphor_rw = True


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
    time_override = PercentCommand("time_override", "Share of the time in which the path runs, percent; 200 at most.")
    single_block = BoolCommand("single_block", "Wait for continue_motion() after each block.")
    optional_stop = BoolCommand("optional_stop", "M01 stops.")
    machine_lock = BoolCommand("machine_lock", "From the next program start on no axis moves.")
    read_disable = BoolCommand("read_disable", "Keep the interpolator from taking blocks.")
    backward_motion = BoolCommand(
        "backward_motion", "Drive the path backward, as far as it is kept; FALSE: forward again."
    )
    backward_storage_off = BoolCommand("backward_storage_off", "From the next program start on nothing is kept.")
    simulate_motion = BoolCommand("simulate_motion", "Leave out the sections of #OPTIONAL EXECUTION.")
    simulate_motion_mask = MaskCommand("simulate_motion_mask", "Which of those with SIMULATE MASK.")
    stop_level = MaskCommand("stop_level", "Which marks of #STOP REVERSIBLE stop, by the bits of their LEVEL.")
    block_search_on = BoolCommand("block_search_on", "Agrees to a block search; FALSE again: what it put out is done.")

    def __init__(self, channel: Channel) -> None:
        super().__init__(channel.control)
        self._channel = channel
        self._status = channel.status
        self._modes = channel.control.mode_and_state
        self._continue = _OneShot(channel.control.continue_motion)
        self._reset = _OneShot(channel.control.reset)
        self._delete = _OneShot(channel.control.delete_distance_to_go)
        self.keys = Keys(channel.control.manual)
        self._handwheels = channel.control.manual.handwheel_w
        self._activations: deque[tuple[int, int, int, int]] = deque(maxlen=MAX_AXES)
        self._messages = MessageTaker(channel)
        self._errors = ErrorTaker(channel)
        self._told: deque[tuple[str, bool]] = deque()  # messages that the CNC has still to take
        self.tools = ToolStore(channel)  # for an external tool management: requests, answers, tool life
        self._waiting: Wish | None = None
        self.claims_modes = False  # TRUE: the mode changes only after agree_mode()
        self.claims_orders = False  # TRUE: the operator's orders (start, stop) wait for allow_order or refuse_order
        self.operator = OperatorWishes(channel.control)
        self.name = get_text(channel, "name_r")

    # ------------------------------------------------------------------ orders

    def start(self, program: str) -> None:
        """Start an NC program in AUTOMATIC. A newer order replaces one that the CNC has not yet taken."""
        self._waiting = Wish(Mode.AUTOMATIC, State.ACTIVE, program)

    def execute(self, blocks: str) -> None:
        """Execute NC blocks in MDI."""
        self._waiting = Wish(Mode.MDI, State.ACTIVE, blocks)

    def manual(self, blocks: str = "") -> None:
        """Select MANUAL: the axes are moved by keys and handwheels, until `stop`. `blocks` go before, G200 as the last."""
        self._waiting = Wish(Mode.MANUAL, State.ACTIVE, blocks)

    def home(self, blocks: str = "") -> None:
        """Home the axes that the NC blocks name ("G74 Z1 X2 Y2"); without any the program rpf.nc does."""
        self._waiting = Wish(Mode.HOMING, State.ACTIVE, blocks)

    def stop(self) -> None:
        """Stop on the path and end the program."""
        self._waiting = Wish(self.mode, State.SELECTED)

    # ------------------------------------------------------------------ manual mode

    def link(self, axis: int, element: int, mode: ManualMode, stage: int = 0) -> None:
        """Link a key pair or handwheel to the axis with a logical number; takes effect while the axis is released."""
        self._activations.append((axis, element, int(mode), stage))

    def turn(self, handwheel: int, pulses: int) -> None:
        """A handwheel (from 1) was turned by so many pulses since the last call."""
        counts = self._handwheels
        counts[handwheel - 1] = (counts[handwheel - 1] + pulses + 2**31) % 2**32 - 2**31

    def delete_distance_to_go(self) -> None:
        """Drop the rest of the motion block; the path goes on straight to the target of the next one."""
        self._delete.give()

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

    @property
    def wanted_mode(self) -> Mode | None:
        """The mode that waits for agree_mode(); needs `claims_modes`. A reset takes the question back."""
        unit = self._channel.lc_mode
        return Mode(unit.mode_r) if self.claims_modes and unit.please_rw else None

    def agree_mode(self) -> None:
        """The mode may change."""
        unit = self._channel.lc_mode
        if unit.please_rw:
            unit.done_w = True
            unit.please_rw = False

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

    def take_error(self) -> ErrorMessage | None:
        """The next error, warning or notice of the CNC, oldest first; None if there is none. 32 wait for a program that takes
        none, later ones are in the alarm history only."""
        return self._errors.take()

    def tell(self, text: str, *, information: bool = False) -> bool:
        """A message for whoever operates the channel, in journal and trace; `information`: it is no text for people.

        They go out in their order, one per PLC cycle. FALSE: too many wait already, and this one does not.
        """
        if len(self._told) >= LIMIT:
            return False
        self._told.append((text, information))
        return True

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
    def block_search(self) -> SearchState:
        """Where a block search is: at WAIT_FOR_PLC_ON set `block_search_on` TRUE, at WAIT_FOR_PLC_OFF FALSE when all that was
        put out meanwhile is done. A program that never sets it is not waited for."""
        return _SEARCH_STATES[self._status.block_search_state_r]

    @property
    def distance_to_geometry_end(self) -> tuple[float, ...]:
        """What each axis of the channel has still to go within #DIST TO GO, mm or degrees; 0 outside, and until it is known."""
        return tuple(self._status.dist_to_geom_end_r[k] * LENGTH for k in range(self._channel.axis_count_r))

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
        self._delete.update()
        self.keys.update()
        self._channel.lc_mode.enable_w = self.claims_modes
        self._update_activation()
        if self._told and self._messages.send(self._told[0][0], information=self._told[0][1]):
            self._told.popleft()
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

    def _update_activation(self) -> None:
        unit = self._channel.control.manual.activation
        if unit.command_semaphor_rw:
            return
        if self._activations:
            order = unit.command_w
            order.log_ax_n, order.control_element, order.operation_mode, order.parameter_set = (
                self._activations.popleft()
            )
            unit.enable_w = unit.command_semaphor_rw = True
        elif unit.request_semaphor_rw:
            unit.command_w = unit.request_r
            unit.request_semaphor_rw = False
            unit.enable_w = unit.command_semaphor_rw = True
        else:
            unit.enable_w = False


class AxisPort(_Area):
    """One axis: mm or degrees, and seconds."""

    drive_on = BoolCommand("drive_on", "The drive is to be enabled.")
    release = BoolCommand(
        "release_feedhold", "Feed enable: without it the axis, and every path it takes part in, stands."
    )
    feed_hold = BoolCommand("feedhold", "Hold this axis.")
    torque_permission = BoolCommand("torque_permission", "The drive may have torque; it is enabled with drive_on only.")
    follow_up = BoolCommand("follow_up", "Tracking: the drive is off, the set-point follows the actual position.")
    parked = BoolCommand("parked", "Out of use: programs start without the axis; taken over while none runs.")
    reference_cam = BoolCommand("reference_cam", "The axis is on its reference cam.")
    lag_monitoring_off = BoolCommand("lag_monitoring_off", "The following error raises no alarm.")
    blocked = MaskCommand("directional_feedhold", "Directions (Blocked) in which the axis may not go.")
    lowest = LengthCommand("dyn_pos_limit_low", "Dynamic position limit.")
    highest = LengthCommand("dyn_pos_limit_high", "Dynamic position limit.")
    torque_limit = PercentCommand("torque_limit", "Torque limit, percent of the rated one, while torque_limited.")
    torque_limited = BoolCommand("torque_limit_valid", "The torque limit counts.")
    override = PercentCommand("override", "Override of an axis that moves alone, or of a spindle; percent.")

    def __init__(self, axis: Axis) -> None:
        super().__init__(axis.control)
        self._axis = axis
        self._status = axis.status
        self._reset = _OneShot(axis.control.reset)
        self.jobs = JobGiver(axis)  # of the motion blocks
        self.name = get_text(axis, "name_r")

    def reset(self) -> None:
        """Acknowledge an error of the axis or its drive."""
        self._reset.give()

    @property
    def state(self) -> AxisState:
        return _AXIS_STATES[self._status.axis_state_r]

    @property
    def motion_state(self) -> MotionState:
        """State in the diagram of PLCopen."""
        return _MOTION_STATES[self._axis.job.motion_state_r]

    @property
    def error_id(self) -> int:
        """Why the axis is in ErrorStop, 0 it is not."""
        value: int = self._axis.job.error_id_r
        return value

    @property
    def enabled(self) -> bool:
        """The drive takes set-points."""
        value: bool = self._status.ready_for_control_loop_on_r
        return value

    @property
    def number(self) -> int:
        """Logical axis number."""
        value: int = self._axis.log_ax_n_r
        return value

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
    def drive_mode(self) -> int:
        """Mode of operation that the drive shows (0x6061), 0 if it does not tell it: 8 follows positions, 10 and 4 torques."""
        return int(self._status.drive_mode_r)

    @property
    def torque(self) -> float:
        """Actual torque, percent of the rated one; 0 if the drive does not tell it (`process_data`)."""
        return float(self._status.actual_torque_r) * PERCENT

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

    stops_at_program_end = BoolCommand("spdl_stop_at_prog_end", "The end of a program stops the spindle.")
    failed = BoolCommand("spdl_error", "An error of the spindle: it stops, takes no order, and the machine is told.")

    def __init__(self, axis: Axis) -> None:
        super().__init__(axis)
        self._spindle = axis.spindle
        self._spindle_reset = _OneShot(axis.control.spdl_reset)
        self._caller = SpindleCaller(axis)

    def order(
        self,
        kind: SpindleCommandKind,
        speed: float = 0.0,
        angle: float = 0.0,
        way: SpindleWay = SpindleWay.ABSOLUTE,
        value: float = 0.0,
    ) -> bool:
        """What a program can order of a spindle; FALSE if the order before was not taken yet: try again in the next cycle.

        `speed` in rev/min, 0 for the one that is programmed; `angle` in degrees, of M19; `value`: a share (ACCELERATION,
        FEED_FORWARD, SPEED_FACTOR) or the gear stage from 1. `order_error` tells why it was refused.
        """
        return self._caller.give(SpindleCall(kind, speed / REV_PER_MIN * SPEED, angle, way, value))

    @property
    def order_taken(self) -> bool:
        """The CNC has taken what was ordered."""
        return self._caller.taken

    @property
    def order_error(self) -> int:
        """Id of why the last order was refused, 0 it was not."""
        return self._caller.error

    def reset_spindle(self) -> None:
        """It stops and forgets what was ordered; the channel goes on."""
        self._spindle_reset.give()

    @property
    def resets(self) -> bool:
        """Its reset still runs."""
        value: bool = self._axis.control.spdl_reset.state_r
        return value

    def update(self) -> None:
        """End of a PLC cycle. Called by the host."""
        super().update()
        self._spindle_reset.update()

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
