"""What a drive is told by SDO before it runs, from the machine description: reactions, limits, units, homing.

The start-up list of the description comes behind it and can say otherwise.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Final, NamedTuple

from runtime.config.drive import Transmission
from runtime.config.machine import Axis
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.drives import DriveMode
from runtime.fieldbus import cia402
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.links import DriveLink

GREATEST: Final = 0xFFFF_FFFF
GREATEST_DIVISOR: Final = 10_000  # of the feed, in search of a ratio of whole numbers
PER_MILLE: Final = 1000.0
TORQUE_SLOPE: Final = 100.0  # shares of the rated torque per second: in profile torque mode the control makes the ramps

Write = tuple[int, int, int]
"""Index, sub-index, value."""


def drive_writes(axis: Axis, link: DriveLink, interpolation: tuple[int, int]) -> Iterator[Write]:
    """What is written where the drive has the object. `interpolation`: value and power of ten of the cycle."""
    drive = axis.drive
    assert drive is not None
    scale = link.increments_per_unit
    reactions = drive.reactions
    yield cia402.ABORT_CONNECTION_OPTION, 0, reactions.connection
    yield cia402.QUICK_STOP_OPTION, 0, reactions.quick_stop
    yield cia402.SHUTDOWN_OPTION, 0, reactions.shutdown
    yield cia402.DISABLE_OPERATION_OPTION, 0, reactions.disable
    yield cia402.HALT_OPTION, 0, reactions.halt
    yield cia402.FAULT_REACTION_OPTION, 0, reactions.fault
    # What the axis is said to be able to do, it may do when it must stop, or when the drive moves it.
    ramp = _within(axis.acceleration * scale)
    for index in (cia402.QUICK_STOP_DECELERATION, cia402.PROFILE_ACCELERATION, cia402.PROFILE_DECELERATION):
        yield index, 0, ramp
    if not link.spindle:
        # The second line of defence, behind the runtime's own watch.
        window = drive.window or 2.0 * axis.following_error
        yield cia402.FOLLOWING_ERROR_WINDOW, 0, _within(window * scale)
        # Set-points that were lost are made up for no faster than the axis may go.
        yield cia402.MAX_PROFILE_VELOCITY, 0, _within(axis.velocity * scale)
    if DriveMode.PROFILE_TORQUE in link.modes:
        yield cia402.TORQUE_SLOPE, 0, _within(TORQUE_SLOPE * PER_MILLE)
    yield cia402.PROFILE_VELOCITY, 0, _within(axis.velocity * scale)
    for subindex, value in enumerate(interpolation, 1):
        yield cia402.INTERPOLATION_PERIOD, subindex, value
    if drive.window_time is not None:
        yield cia402.FOLLOWING_ERROR_TIMEOUT, 0, min(round(drive.window_time * 1000.0), 0xFFFF)


def needed_writes(axis: Axis, link: DriveLink) -> Iterator[Write]:
    """What the description asks for by name: a drive that lacks the object is refused."""
    drive, scale = axis.drive, link.increments_per_unit
    assert drive is not None
    if drive.max_torque is not None:
        yield cia402.MAX_TORQUE, 0, round(drive.max_torque * PER_MILLE)
    if drive.torque_limits is not None:
        for index, limit in zip(
            (cia402.POSITIVE_TORQUE_LIMIT, cia402.NEGATIVE_TORQUE_LIMIT), drive.torque_limits, strict=True
        ):
            yield index, 0, round(limit * PER_MILLE)
    homing = axis.homing
    if homing is not None and homing.method is not None:
        yield cia402.HOMING_METHOD, 0, homing.method
        yield cia402.HOMING_SPEEDS, 1, _within(homing.fast * scale)
        yield cia402.HOMING_SPEEDS, 2, _within(homing.slow * scale)
        yield cia402.HOMING_ACCELERATION, 0, _within(axis.acceleration * scale)
        # Makers count the offset with one sign or the other: the axis keeps it itself.
        yield cia402.HOME_OFFSET, 0, 0
    yield cia402.MODES_OF_OPERATION, 0, link.mode


def _within(value: float) -> int:
    return max(1, min(round(value), GREATEST))


class Part(NamedTuple):
    """One object of the factor group: a ratio."""

    object: int
    first: int
    second: int

    def agrees(self, first: int, second: int) -> bool:
        """Whether what the drive has is the same ratio."""
        return second != 0 and self.second * first == self.first * second


def parts(transmission: Transmission, link: DriveLink) -> Iterator[Part]:
    """The factor group that the description asks for. Raises FieldbusError if it cannot be told in whole numbers."""
    if transmission.encoder is not None:
        yield Part(cia402.ENCODER_RESOLUTION, *transmission.encoder)
    if transmission.gear is not None:
        yield Part(cia402.GEAR_RATIO, *transmission.gear)
    way = transmission.feed * link.increments_per_unit
    feed = Fraction(way).limit_denominator(GREATEST_DIVISOR)
    if abs(float(feed) - way) > 1e-9 * way or feed.numerator > GREATEST:
        raise FieldbusError(
            catalogue.UNITS_NOT_WHOLE,
            node=link.node,
            owner=link.owner,
            feed=transmission.feed,
            increments=link.increments_per_unit,
        )
    yield Part(cia402.FEED_CONSTANT, feed.numerator, feed.denominator)
