"""How a simulated drive moves while it is enabled: one method per mode of operation, halt, and what its inputs see."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Final

from runtime.drives import DriveMode
from runtime.fieldbus import cia402 as objects
from runtime.fieldbus.cia402 import (
    CHANGE_AT_ONCE,
    HALT,
    LIMIT_ACTIVE,
    MODE_BIT_12,
    MODE_BIT_13,
    NEW_SET_POINT,
    TARGET_REACHED,
    Stop,
)
from runtime.fieldbus.links import wrap32
from runtime.fieldbus.simulator.homing import Homing
from runtime.fieldbus.simulator.profile import Profile
from runtime.fieldbus.simulator.setpoints import SetPoints
from runtime.fieldbus.simulator.switches import Switches, TouchProbe

if TYPE_CHECKING:
    from runtime.fieldbus.simulator.drive import SimulatedDrive

PER_MILLE: Final = 1000.0  # torques on the wire
STANDS: Final = 10.0  # increments/s

MODES: Final = tuple(mode for mode in DriveMode if mode)
_POSITION_MODES: Final = (DriveMode.CYCLIC_SYNCHRONOUS_POSITION, DriveMode.INTERPOLATED_POSITION)
_CYCLIC: Final = (*_POSITION_MODES, DriveMode.CYCLIC_SYNCHRONOUS_VELOCITY, DriveMode.CYCLIC_SYNCHRONOUS_TORQUE)


class DriveMotion:
    """The motion of one drive. Positions are those of the encoder, not as the drive counts them."""

    def __init__(self, drive: SimulatedDrive, switches: Switches, probes: list[float | None]) -> None:
        self._drive = drive
        self.switches = switches
        self.probes = [TouchProbe(k, place) for k, place in enumerate(probes, 1)]
        self.blind = (
            switches.home is None and switches.limits is None and not any(place is not None for place in probes)
        )
        self.points = SetPoints()
        self.homing = Homing(switches)
        self._profile = Profile()
        self._target: float | None = None  # of profile position
        self._next: float | None = None  # taken when the first is reached
        self._acknowledged = False
        self._reached = False
        self._bit_before = False  # bit 4 of the control word
        self._before = 0.0  # position of the motor a step ago
        self._pushed = 0.0  # torque of profile torque mode, 0.1 %
        self._steps: dict[int, Callable[[float], None]] = {
            DriveMode.PROFILE_POSITION: self._profile_position,
            DriveMode.PROFILE_VELOCITY: self._profile_velocity,
            DriveMode.PROFILE_TORQUE: self._profile_torque,
            DriveMode.CYCLIC_SYNCHRONOUS_VELOCITY: self._cyclic_velocity,
            DriveMode.CYCLIC_SYNCHRONOUS_TORQUE: self._torque,
            DriveMode.HOMING: self._home,
        }

    def reset(self) -> None:
        """Power-on."""
        self.begin()
        self.homing.attained = self.homing.error = False

    def begin(self) -> None:
        """The drive was enabled, or its mode has changed: on from where the motor stands, or moves."""
        servo = self._drive.servo
        self.points.take_over(servo.command if self._drive.mode in _POSITION_MODES else servo.position)
        self._profile.take_over(servo.position, servo.velocity)
        self._target = self._next = None
        self._acknowledged = self._reached = False
        self._pushed = servo.torque * PER_MILLE
        self.homing.stop()
        self._bit_before = False

    def look(self, before: float, after: float) -> None:
        """The motor has moved, by itself or not: what the probes see."""
        self._before = before
        function = self._drive.values[objects.PROBE_FUNCTION, 0]
        if self.blind:
            if not function:
                return
            self.blind = False  # a probe that nothing touches is switched on all the same
        for probe in self.probes:
            probe.step(function, before, after)

    def touch(self, touched: bool, place: float) -> None:
        """Touch probe 1 has met the workpiece, or left it, where the motor was at `place`."""
        self.blind = False
        self.probes[0].touch(touched, place)

    # -- the modes ---------------------------------------------------------------------------------------------------

    def step(self, dt: float, *, synchronised: bool) -> None:
        """Move for `dt` s in the mode of operation."""
        drive = self._drive
        values = drive.values
        most = values[objects.MAX_TORQUE, 0]
        drive.servo.strongest = min(most, values[objects.POSITIVE_TORQUE_LIMIT, 0]) / PER_MILLE * drive.servo.rated
        drive.servo.weakest = -min(most, values[objects.NEGATIVE_TORQUE_LIMIT, 0]) / PER_MILLE * drive.servo.rated
        if drive.controlword & HALT:
            drive.servo.brake(drive.ramp(Stop(drive.parameters[objects.HALT_OPTION])), dt)
            self._profile.take_over(drive.servo.position, drive.servo.velocity)
            self.points.take_over(drive.servo.position)
            return
        if drive.mode in self._steps:
            self._steps[drive.mode](dt)
        elif drive.mode in _POSITION_MODES:
            self._follow(dt, synchronised)
        else:
            drive.servo.brake(drive.ramp(Stop.QUICK_STOP_RAMP), dt)

    def _limit(self) -> float:
        return float(self._drive.parameters[objects.MAX_PROFILE_VELOCITY])

    def _follow(self, dt: float, synchronised: bool) -> None:
        drive, servo = self._drive, self._drive.servo
        interpolated = drive.mode == DriveMode.INTERPOLATED_POSITION
        if interpolated and not drive.controlword & NEW_SET_POINT:
            self.points.take_over(servo.command)
            servo.follow_position(servo.command, dt)
            return
        key = (objects.INTERPOLATION_DATA, 1) if interpolated else (objects.TARGET_POSITION, 0)
        # the target is 32 bits of an endless axis: the nearest position that looks like it
        counted = round(servo.command) - drive.zero
        target = drive.zero + counted + wrap32(drive.values[key] - counted)
        command = self.points.next(servo.command, target, dt, self._limit(), synchronised=synchronised)
        servo.follow_position(command, dt)

    def _cyclic_velocity(self, dt: float) -> None:
        values = self._drive.values
        velocity = values[objects.TARGET_VELOCITY, 0] + values[objects.VELOCITY_OFFSET, 0]
        self._drive.servo.follow_velocity(velocity, dt)

    def _torque(self, dt: float) -> None:
        values = self._drive.values
        torque = values[objects.TARGET_TORQUE, 0] + values[objects.TORQUE_OFFSET, 0]
        self._drive.servo.push(torque / PER_MILLE, dt)

    def _profile_torque(self, dt: float) -> None:
        """On the ramp of 0x6087 to the target."""
        most = self._drive.parameters[objects.TORQUE_SLOPE] * dt
        change = self._drive.values[objects.TARGET_TORQUE, 0] - self._pushed
        self._pushed += max(-most, min(most, change))
        self._drive.servo.push(self._pushed / PER_MILLE, dt)

    def _ramps(self) -> tuple[float, float]:
        parameters = self._drive.parameters
        return (
            float(max(1, parameters[objects.PROFILE_ACCELERATION])),
            float(max(1, parameters[objects.PROFILE_DECELERATION])),
        )

    def _profile_velocity(self, dt: float) -> None:
        target = self._drive.values[objects.TARGET_VELOCITY, 0]
        limit = self._limit()
        self._reached = self._profile.at(max(-limit, min(limit, target)), *self._ramps(), dt)
        self._drive.servo.follow_velocity(self._profile.velocity, dt)
        self._profile.position = self._drive.servo.position

    def _profile_position(self, dt: float) -> None:
        """Set-points by the handshake of bit 4 and bit 12; a second one waits unless bit 5 asks to change at once."""
        drive, word = self._drive, self._drive.controlword
        bit = bool(word & NEW_SET_POINT)
        if bit and not self._bit_before and self._next is None:
            target = drive.values[objects.TARGET_POSITION, 0] + drive.zero
            self._acknowledged = True
            if self._target is None or self._reached or word & CHANGE_AT_ONCE:
                self._target, self._reached = target, False
            else:
                self._next = target
        elif not bit and self._next is None:
            self._acknowledged = False
        self._bit_before = bit
        if self._target is None:
            drive.servo.follow_position(drive.servo.command, dt)
            return
        speed = min(float(drive.values[objects.PROFILE_VELOCITY, 0]), self._limit())
        if self._profile.towards(self._target, speed, *self._ramps(), dt):
            if self._next is not None:
                self._target, self._next = self._next, None
            else:
                self._reached = True
        drive.servo.follow_position(self._profile.position, dt)

    def _home(self, dt: float) -> None:
        """Bit 4 starts, and its fall interrupts."""
        drive = self._drive
        bit = bool(drive.controlword & NEW_SET_POINT)
        if bit and not self._bit_before:
            self.homing.begin(drive.parameters[objects.HOMING_METHOD])
        elif not bit:
            self.homing.stop()
        self._bit_before = bit
        ramp = float(max(1, drive.parameters[objects.HOMING_ACCELERATION]))
        fast, slow = drive.homing_speeds
        found = self.homing.step(self._profile, self._before, drive.servo.position, (fast, slow), ramp, dt)
        if found is not None:
            drive.zero = round(found) - drive.parameters[objects.HOME_OFFSET]
        drive.servo.follow_position(self._profile.position, dt)

    # -- what the status word tells ----------------------------------------------------------------------------------

    def status_bits(self, *, lagging: bool) -> int:
        """Bits 10 to 13 of the status word, which depend on the mode."""
        drive, mode = self._drive, self._drive.mode
        stands = abs(drive.servo.velocity) < STANDS
        bits = LIMIT_ACTIVE if self.points.limited and mode in _POSITION_MODES else 0
        if drive.controlword & HALT:
            bits |= TARGET_REACHED if stands else 0
        elif mode == DriveMode.HOMING:
            if not self.homing.running and stands:
                bits |= TARGET_REACHED
        elif self._reached and mode in (DriveMode.PROFILE_POSITION, DriveMode.PROFILE_VELOCITY):
            bits |= TARGET_REACHED
        if mode == DriveMode.HOMING:
            bits |= MODE_BIT_12 if self.homing.attained else 0
            bits |= MODE_BIT_13 if self.homing.error else 0
        elif mode == DriveMode.PROFILE_POSITION:
            bits |= MODE_BIT_12 if self._acknowledged else 0
        elif mode == DriveMode.PROFILE_VELOCITY:
            bits |= MODE_BIT_12 if stands else 0
        elif mode in _CYCLIC:
            bits |= MODE_BIT_12
        if lagging and mode in (*_POSITION_MODES, DriveMode.PROFILE_POSITION):
            bits |= MODE_BIT_13
        return bits
