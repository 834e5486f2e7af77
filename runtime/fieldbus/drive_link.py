"""Drives with which more than set-point and position is exchanged: modes, torque, feed-forward, inputs, probes, a second end.

    DriveLink           control word and set-point out, status word and position in (runtime.fieldbus.links)
    ExtendedDriveLink   whatever the machine description asks for beside them

Each object has a value for the next cycle in `_out`; the PDOs pack what they carry.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

import can

from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.drives import DriveImage, DriveMode, DriveState
from runtime.fieldbus import cia402
from runtime.fieldbus.gantry import GantryEnd
from runtime.fieldbus.links import DriveLink, Receiver, wrap32
from runtime.fieldbus.mode_control import ModeControl
from runtime.fieldbus.network import fill
from runtime.fieldbus.pdo import Direction, ObjectKey, PdoPlan

PER_MILLE: Final = 1000.0  # torques on the wire
NO_TORQUE_LIMIT: Final = 0xFFFF
GREATEST_SPEED: Final = 1.2  # of the axis, that the position loop of the control asks for
_CONTROLWORD: Final = (cia402.CONTROLWORD, 0)
_POSITION: Final = (cia402.TARGET_POSITION, 0)
_INTERPOLATED: Final = (cia402.INTERPOLATION_DATA, 1)
_VELOCITY: Final = (cia402.TARGET_VELOCITY, 0)
_TORQUE: Final = (cia402.TARGET_TORQUE, 0)
_MODE: Final = (cia402.MODES_OF_OPERATION, 0)
_PROBE_FUNCTION: Final = (cia402.PROBE_FUNCTION, 0)
_MAX_TORQUE: Final = (cia402.MAX_TORQUE, 0)
_VELOCITY_OFFSET: Final = (cia402.VELOCITY_OFFSET, 0)
_TORQUE_OFFSET: Final = (cia402.TORQUE_OFFSET, 0)
_PROBES: Final = (cia402.PROBE_1_RISING, cia402.PROBE_1_FALLING, cia402.PROBE_2_RISING, cia402.PROBE_2_FALLING)


@dataclass(slots=True)
class ExtendedDriveLink(DriveLink):
    """A drive with more than the plain exchange. `velocity_limit`: of the axis, units/s."""

    velocity_limit: float = math.inf
    position_gain: float = 0.0  # 1/s, in velocity mode
    velocity_feed_forward: float = 0.0  # share
    torque_feed_forward: float = 0.0  # share of the rated torque per unit/s²
    inputs: tuple[int, ...] = ()  # bits of 0x60FD that are inputs of the image, in their order
    first_input: int = 0
    home_position: float = 0.0  # of the axis where the drive counts 0 after homing
    torque_limit: int = NO_TORQUE_LIMIT  # per mille, while the axis gives none
    end: GantryEnd | None = None  # of an axis with two drives
    input_value: int = 0
    mode_control: ModeControl = field(init=False)
    _out: dict[ObjectKey, int] = field(default_factory=dict)
    _rows: list[tuple[can.Message, Callable[..., bytes], tuple[ObjectKey, ...]]] = field(default_factory=list)
    _probes: bool = False  # which objects are exchanged
    _limits_torque: bool = False
    _image: DriveImage | None = None
    _target: float = 0.0  # set-point of the cycle before, units; that of the axis
    _speed: float = 0.0  # units/s, of the cycle before
    _followed: bool = False  # the cycle before had a set-point of the axis
    _held: int | None = None  # increments, where an end of a gantry waits for the other

    def __post_init__(self) -> None:
        available = self.modes | {self.mode}
        self.mode_control = ModeControl(self.mode, available, self.period)
        for plan, layout in self.layouts.items():
            if plan.direction is Direction.RECEIVE:
                message = self._frame(plan)
                self._rows.append((message, layout.codec.pack, plan.objects))
                self._out |= dict.fromkeys(plan.objects, 0)
        self._probes, self._limits_torque = _PROBE_FUNCTION in self._out, _MAX_TORQUE in self._out
        self.message, *others = (message for message, _, _ in self._rows)
        self.further = tuple(others)

    # -- feedback ----------------------------------------------------------------------------------------------------

    def receivers(self) -> dict[int, Receiver]:
        return {
            plan.cob_id(self.node): self._receiver(plan)
            for plan in self.layouts
            if plan.direction is Direction.TRANSMIT
        }

    def _receiver(self, plan: PdoPlan) -> Receiver:
        codec = self.layouts[plan].codec
        takers = [self._taker(index) for index, _ in plan.objects]
        probe = next((k for k, index in enumerate(_PROBES) if (index, 0) in plan.objects), None)

        def receive(data: bytearray) -> None:
            if len(data) < codec.size:
                return
            values = codec.unpack_from(data)
            if probe is not None:
                self._take_probe(probe, *values)
                return
            for take, value in zip(takers, values, strict=True):
                take(value)
            if plan.number == 1:
                self.fresh = True

        return receive

    def _taker(self, index: int) -> Callable[[int], None]:
        """Who takes an object's value."""
        takers: dict[int, Callable[[int], Any]] = {
            cia402.STATUSWORD: self._take_status,
            cia402.POSITION_ACTUAL: self._move_to if self.spindle else self._take_value,
            cia402.VELOCITY_ACTUAL: self._take_value,
            cia402.MODE_DISPLAY: self._take_mode,
            cia402.TORQUE_ACTUAL: self._take_torque,
            cia402.FOLLOWING_ERROR: self._take_lag,
            cia402.DIGITAL_INPUTS: self._take_inputs,
        }
        return takers.get(index, _ignore)

    def _take_status(self, value: int) -> None:
        self._status = value

    def _take_value(self, value: int) -> None:
        self._value = value

    def _take_mode(self, value: int) -> None:
        self.mode_control.shown = value

    def _take_torque(self, value: int) -> None:
        if self._image is not None and (self.end is None or not self.end.second):
            self._image.actual_torque[self.axis] = value / PER_MILLE

    def _take_lag(self, value: int) -> None:
        if self._image is not None and (self.end is None or not self.end.second):
            self._image.drive_lag[self.axis] = value / self.increments_per_unit

    def _take_inputs(self, value: int) -> None:
        self.input_value = 0
        for k, bit in enumerate(self.inputs):
            self.input_value |= (value >> bit & 1) << k
        if self._image is not None and (self.end is None or not self.end.second):
            self._image.drive_inputs[self.axis] = value

    @property
    def has_inputs(self) -> bool:
        return bool(self.inputs)

    def input_bits(self) -> int:
        """The inputs at their place among all of the image; a lost node's inputs are FALSE."""
        return 0 if self.lost else self.input_value << self.first_input

    def _take_probe(self, number: int, status: int, position: int) -> None:
        """A latched position of the axis: the nearest to where the drive is that looks so on the wire."""
        image = self._image
        if image is None:
            return
        increments = self._increments + wrap32(position - self._raw_position)
        image.probe_position[self.axis, number] = self._place(image, increments)
        image.probe_status[self.axis] = status

    def _place(self, image: DriveImage, increments: int) -> float:
        """The position of the axis, units."""
        i = self.axis
        return float(increments / self.increments_per_unit + image.origin[i] - image.correction[i])

    def begin(self, status: int, raw_position: int, image: DriveImage) -> None:
        self._image = image
        self._status = status
        self.mode_control.lose()
        if self.end is not None:
            self.end.begin(raw_position / self.increments_per_unit)
        DriveLink.begin(self, status, raw_position, image)

    def feedback(self, image: DriveImage, period: float) -> None:
        before = self._increments
        cycles = self._cycles + 1
        DriveLink.feedback(self, image, period)
        i, status = self.axis, self._status
        if self.end is not None:
            self._watch_ends(self.end, image, cycles)
            if self.end.second:
                return
        image.mode_shown[i] = self.mode_control.shown
        image.target_reached[i] = bool(status & cia402.TARGET_REACHED)
        image.limited[i] = bool(status & cia402.LIMIT_ACTIVE)
        if self.mode_control.by_drive:
            farthest = GREATEST_SPEED * self.velocity_limit * period * cycles * self.increments_per_unit
            if abs(self._increments - before) > farthest:  # the drive has begun to count anew
                image.actual_velocity[i] = 0.0

    def _publish(self, image: DriveImage, state: DriveState, velocity: float) -> None:
        end = self.end
        if end is None:
            DriveLink._publish(self, image, state, velocity)
            return
        end.state = state
        if not end.second:
            DriveLink._publish(self, image, end.joint_state, velocity)
            return
        image.state[self.axis] = end.joint_state

    def _watch_ends(self, end: GantryEnd, image: DriveImage, cycles: int) -> None:
        """Where this end is; `cycles` since it was told last."""
        end.ready = self.mode_control.ready_to_home
        if self._cycles:
            return  # nothing has come
        end.goes_to(self._increments / self.increments_per_unit, cycles, self.increments_per_unit)
        if end.second and end.found_skewed():
            text = f"{end.difference:+.3f}"
            image.events.append(self.event(catalogue.GANTRY_SKEWED.id, 0, text))

    def lose(self) -> None:
        DriveLink.lose(self)
        self.mode_control.lose()
        if self.end is not None:
            self.end.state = DriveState.OFFLINE
            self.end.homing, self.end.by_drive = self.mode_control.homing, False
            self.end.ready = self.end.homing_error = False

    # -- set-points --------------------------------------------------------------------------------------------------

    def command(self, image: DriveImage, target: float, enable: bool, quick_stop: bool, reset_fault: bool) -> None:
        """Fill the messages of this cycle."""
        i, out, end, modes = self.axis, self._out, self.end, self.mode_control
        if not math.isfinite(target):
            quick_stop = self._refuse(image, catalogue.SETPOINT_INVALID.id)
            target = self._target
        elif self.control.state is not DriveState.OPERATION_ENABLED:
            self.invalid = False
        if end is not None:
            enable, quick_stop = end.orders(enable, quick_stop, self.control.state)
        word = self.control.order(enable, quick_stop or self.invalid, reset_fault)
        enabled = word == cia402.ENABLE_OPERATION and self.control.state is DriveState.OPERATION_ENABLED
        goal = round((float(image.profile_target[i]) - float(image.origin[i])) * self.increments_per_unit)
        home, together = bool(image.homing_request[i]), True
        if end is not None:
            home, together = end.homes(home), end.other.ready
        out[_CONTROLWORD] = word | modes.order(
            int(image.mode[i]), home, bool(image.halt[i]), enabled, self._status, goal, together=together
        )
        follows = enabled and not modes.by_drive
        if end is not None:
            end.homing, end.homing_error, end.by_drive = modes.homing, modes.homing_error, modes.by_drive
            follows = follows and end.both_enabled and not end.waits
        self._set_points(image, target, goal, enabled, follows)
        out[_MODE] = modes.ordered
        if self._probes:
            out[_PROBE_FUNCTION] = int(image.probe_function[i])
        if self._limits_torque:
            limit = float(image.torque_limit[i])
            out[_MAX_TORQUE] = (
                max(0, min(round(limit * PER_MILLE), self.torque_limit)) if math.isfinite(limit) else self.torque_limit
            )
        self._tell_modes(image)
        for message, pack, objects in self._rows:
            fill(message, pack(*[out[key] for key in objects]))

    def _set_points(self, image: DriveImage, target: float, goal: int, enabled: bool, follows: bool) -> None:
        out, scale = self._out, self.increments_per_unit
        stand = self._raw_position
        if self.end is not None and enabled and self.end.waits:
            stand = self._held = stand if self._held is None else self._held
        else:
            self._held = None
        out[_POSITION] = out[_INTERPOLATED] = stand
        out[_VELOCITY] = out[_TORQUE] = 0
        speed = acceleration = 0.0
        if follows and not self.spindle:
            if self.end is not None and self.end.second:
                target = self.end.own(target, stand_still=not self._followed, here=self._increments / scale)
            if self._followed:
                speed = (target - self._target) / self.period
                acceleration = (speed - self._speed) / self.period
            self._follow(image, target, speed)
        elif follows:
            out[_VELOCITY] = clamp32(round(target * scale))
        else:
            self._sent = stand
            if enabled:
                self._let_drive(image, goal)
        self._target, self._speed, self._followed = target, speed, follows
        if self.velocity_feed_forward:
            share = self.velocity_feed_forward * float(image.feed_forward[self.axis])
            out[_VELOCITY_OFFSET] = clamp32(round(share * speed * scale))
        if self.torque_feed_forward:
            share = self.torque_feed_forward * float(image.feed_forward[self.axis])
            torque = round(share * acceleration * PER_MILLE)
            out[_TORQUE_OFFSET] = max(-0x8000, min(0x7FFF, torque))

    def _follow(self, image: DriveImage, target: float, speed: float) -> None:
        """The set-point of an axis, unless it jumps."""
        out, scale = self._out, self.increments_per_unit
        wanted = wrap32(round(target * scale))
        if self.invalid or (self._followed and abs(wrap32(wanted - self._sent)) > self.longest):
            self._refuse(image, catalogue.SETPOINT_JUMP.id)
            wanted = self._sent
            speed = 0.0
        self._sent = wanted
        out[_POSITION] = out[_INTERPOLATED] = wanted
        if self.mode is DriveMode.CYCLIC_SYNCHRONOUS_VELOCITY:
            # The position that has come is that of the set-point before: it went out with the last SYNC.
            before = self._target if self._followed else target
            lag = before - self._increments / scale
            most = GREATEST_SPEED * self.velocity_limit
            out[_VELOCITY] = clamp32(round(max(-most, min(most, speed + self.position_gain * lag)) * scale))

    def _let_drive(self, image: DriveImage, goal: int) -> None:
        """The set-points of a mode in which the drive moves by itself.

        Velocities and torques go out with the order of their mode: a drive that changes its mode in motion finds them there.
        """
        out, i = self._out, self.axis
        match self.mode_control.ordered:
            case DriveMode.PROFILE_POSITION if self.mode_control.settled:
                given = self.mode_control.profile_target
                out[_POSITION] = wrap32(goal if given is None else given)
            case DriveMode.PROFILE_VELOCITY | DriveMode.CYCLIC_SYNCHRONOUS_VELOCITY:
                velocity = float(image.target_velocity[i])
                if math.isfinite(velocity):
                    velocity = max(-self.velocity_limit, min(self.velocity_limit, velocity))
                    out[_VELOCITY] = clamp32(round(velocity * self.increments_per_unit))
            case DriveMode.PROFILE_TORQUE | DriveMode.CYCLIC_SYNCHRONOUS_TORQUE:
                torque = float(image.target_torque[i])
                if math.isfinite(torque):
                    most = min(self.torque_limit, 0x7FFF)
                    out[_TORQUE] = max(-most, min(most, round(torque * PER_MILLE)))
            case _:
                pass

    def _tell_modes(self, image: DriveImage) -> None:
        modes, i, end = self.mode_control, self.axis, self.end
        if modes.attained:  # the drive has its reference and counts from it, as the frame with the status word tells
            self._increments = self._raw_position
        if end is not None and end.second:
            return
        if modes.attained:
            image.origin[i] = self.home_position
            image.actual_position[i] = self._place(image, self._increments)
        if modes.refused:
            image.events.append(self.event(catalogue.MODE_NOT_SHOWN.id, int(modes.ordered)))
        squaring = end.squaring if end is not None else None
        image.homing_state[i] = modes.homing if squaring is None else squaring.state
        image.by_drive[i] = modes.by_drive or (squaring is not None and squaring.watches)


def clamp32(value: int) -> int:
    """`value` within what 32 bits with a sign hold."""
    return max(-0x8000_0000, min(0x7FFF_FFFF, value))


def _ignore(value: int) -> None:
    """Nobody asks for this object."""
