"""Moving one drive by hand while no machine runs: the drive boots, gets enabled and follows cyclic set-points as in operation.

    hand ─ direction ─▶ JogLaw ─ set-point ─▶ CanopenMaster ─▶ drive        hand: a key that is held, or nothing
                          window, velocity, acceleration

Every motion ends by itself: no sign of life of the hand for the dead-man's time brakes the axis, so does the end of the window,
and a process that dies takes its heartbeat along, by which the drive stops. The axis is at rest before the drive is switched off.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import can
import numpy as np

from runtime.config.machine import Axis, AxisType, Bus, Machine
from runtime.diagnostics.catalogue import commissioning as errors
from runtime.diagnostics.errors import Place, Severity
from runtime.drives import DriveState
from runtime.fieldbus.dialogue import Access, has
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.events import problem_of
from runtime.fieldbus.master import CanopenMaster

ENABLE_LIMIT: Final = 3.0  # s
TORQUE: Final = 0x6077  # per mille of the rated torque
FIRST_CYCLES: Final = 5  # until the drive has told where it is


class Hand(Protocol):
    """Whoever orders a motion."""

    def order(self, now: float, position: float) -> int | None:
        """-1, 0 or 1 at the time `now` (s), with the set-point at `position`; None: it is over."""


class DeadMan:
    """A direction that holds as long as it is given again and again."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self._direction = 0
        self._given = -math.inf

    def give(self, direction: int, now: float) -> None:
        self._direction, self._given = direction, now

    def direction(self, now: float) -> int:
        return self._direction if now - self._given <= self.seconds else 0


class Swing:
    """To and fro between two places as long as the hand gives signs of life, with a pause at each end."""

    PAUSE: Final = 0.2  # s, in which the axis settles

    def __init__(self, hand: Hand, low: float, high: float) -> None:
        self._hand = hand
        self._ends = low, high
        self._forward = True
        self._wait_until = -math.inf

    def order(self, now: float, position: float) -> int | None:
        """As `Hand`; the direction of the hand does not count."""
        order = self._hand.order(now, position)
        if not order:
            return order
        low, high = self._ends
        end = high if self._forward else low
        if abs(end - position) <= 1e-6 * (high - low):
            self._forward = not self._forward
            self._wait_until = now + self.PAUSE
        if now < self._wait_until:
            return 0
        return 1 if self._forward else -1


@dataclass(slots=True)
class JogLaw:
    """Set-points that never leave the window, and never ask for more than velocity and acceleration; units and s."""

    position: float
    velocity_limit: float
    acceleration: float
    low: float = -math.inf
    high: float = math.inf
    velocity: float = 0.0

    def step(self, direction: int, dt: float) -> float:
        """The set-point `dt` later."""
        goal = direction * self.velocity_limit
        step = self.acceleration * dt
        velocity = self.velocity + max(-step, min(step, goal - self.velocity))
        # v·dt + v²/2a is the way to rest from a step with v, and from then on at most v·dt shorter in every step
        velocity = min(velocity, self._stopping(self.high - self.position, dt))
        velocity = max(velocity, -self._stopping(self.position - self.low, dt))
        self.velocity = velocity
        self.position = max(self.low, min(self.high, self.position + velocity * dt))
        return self.position

    def _stopping(self, way: float, dt: float) -> float:
        if math.isinf(way):
            return way
        a = self.acceleration
        return a * (math.sqrt(dt * dt + 2.0 * max(way, 0.0) / a) - dt)


@dataclass(frozen=True, slots=True)
class Sample:
    """One cycle of the drive; units and s. `torque` in per mille of the rated one, as last heard; NaN if it tells none."""

    time: float
    target: float
    actual: float
    target_velocity: float
    velocity: float
    torque: float

    @property
    def following_error(self) -> float:
        return self.target - self.actual


@dataclass(frozen=True, slots=True)
class TuneFigures:
    """How a drive followed; units and s. What it does not tell is NaN."""

    following_error: float  # greatest
    following_error_rms: float
    delay: float  # s: the part of the following error that is proportional to the velocity
    velocity: float  # greatest, of the drive
    overshoot: float  # of the velocity over the greatest set-point, as a share of it
    torque: float  # greatest, per mille of the rated torque


def figures(samples: Sequence[Sample]) -> TuneFigures:
    """Of at least one sample."""
    table = np.array([(s.following_error, s.target_velocity, s.velocity, s.torque) for s in samples])
    error, target, velocity, torque = table.T
    heard = torque[~np.isnan(torque)]
    peak, asked = float(np.abs(velocity).max()), float(np.abs(target).max())
    moving = float(target @ target)
    return TuneFigures(
        following_error=float(np.abs(error).max()),
        following_error_rms=float(np.sqrt(np.mean(error**2))),
        delay=float(error @ target) / moving if moving else math.nan,
        velocity=peak,
        overshoot=max(0.0, peak / asked - 1.0) if asked else math.nan,
        torque=float(np.abs(heard).max()) if len(heard) else math.nan,
    )


def one_drive(machine: Machine, axis: Axis) -> Machine:
    """The machine reduced to one axis, so that nobody else is configured or moved."""
    assert axis.drive is not None
    drive = axis.drive.model_copy(update={"bus": None})
    fieldbus = machine.fieldbus.model_copy(update={"io": (), "buses": {}, "bus": bus_of(machine, axis)})
    alone = axis.model_copy(update={"drive": drive})
    return machine.model_copy(update={"axes": (alone,), "fieldbus": fieldbus})


def bus_of(machine: Machine, axis: Axis) -> Bus:
    """The bus on which the drive of an axis is."""
    return machine.fieldbus.all_buses()[(axis.drive and axis.drive.bus) or ""]


def drive_of(machine: Machine, name: str) -> Axis:
    """The axis of this name; raises FieldbusError if there is none, or none with a drive."""
    known = [axis for axis in machine.axes if axis.drive]
    for axis in known:
        if axis.name == name:
            return axis
    names = ", ".join(axis.name for axis in known) or "none"
    raise FieldbusError(errors.NO_SUCH_DRIVE, axis=name, machine=machine.name, known=names)


def jog_velocity(axis: Axis, wanted: float | None) -> float:
    """Units/s: what was asked for, or the axis' velocity by hand. Raises FieldbusError if it is too much."""
    if wanted is None:
        return axis.jog_velocity or axis.velocity / 10.0
    if not 0.0 < wanted <= axis.velocity:
        unit = "mm/s" if axis.type is AxisType.LINEAR else "degrees/s"
        raise FieldbusError(
            errors.JOG_LIMIT, what="a velocity", value=wanted, limit=axis.velocity, axis=axis.name, unit=unit
        )
    return wanted


def window(axis: Axis, position: float, travel: float) -> tuple[float, float]:
    """From where to where it may move: `travel` to both sides, and within the software limits if the encoder is absolute."""
    low, high = position - travel, position + travel
    if axis.homing is None:
        low = low if axis.position_min is None else max(low, min(axis.position_min, position))
        high = high if axis.position_max is None else min(high, max(axis.position_max, position))
    return low, high


class DriveSession:
    """One drive in operation, alone. `now()` in s; `idle()` lets it go forward.

    With `with`: at the end the axis is at rest and the drive switched off, whatever happened.
    """

    def __init__(
        self, machine: Machine, axis: Axis, bus: can.BusABC, *, now: Callable[[], float], idle: Callable[[], None]
    ) -> None:
        self.axis = axis
        self._machine = one_drive(machine, axis)
        self._period = machine.cycle.period
        self._now = now
        self._idle = idle
        self._spindle = axis.type is AxisType.SPINDLE
        self.master = CanopenMaster(self._machine, bus, now=now, idle=idle)
        self.image = self.master.image
        self.torque = math.nan
        self._next = 0.0
        # Set-points of the cycle before, and of the one before that. The feedback that a cycle reads is of the SYNC in which
        # the drive took the former over; it should have reached the latter then.
        self._targets = 0.0, 0.0
        self._reached = 0.0

    def __enter__(self) -> DriveSession:
        """Boot and configure the drive. Raises FieldbusError; another master on the bus is a refusal."""
        self.master.start()
        self._next = self._now()
        for _ in range(FIRST_CYCLES):
            self._cycle()
        return self

    def __exit__(self, *_: object) -> None:
        self.master.stop()

    @property
    def position(self) -> float:
        """Where the drive stands, in units."""
        return float(self.image.actual_position[0])

    def move(self, law: JogLaw, hand: Hand, watch: Callable[[Sample], None]) -> None:
        """Enable the drive and follow the hand until it says that it is over; then brake. `watch` is told every cycle.

        Raises FieldbusError if the drive does not get enabled, is lost, goes into fault or does not follow.
        """
        self._enable(law)
        try:
            over = False
            while not (over and law.velocity == 0.0):
                order = None if over else hand.order(self._now(), law.position)
                over = over or order is None
                self._set(law, law.step(order or 0, self._period))
                self._cycle()
                watch(self._sample(law))
        finally:
            self.image.enable[:] = False  # the drive brakes on its own ramp if it still moves

    def _enable(self, law: JogLaw) -> None:
        self._set(law, law.position)
        self.image.enable[:] = True
        end = self._now() + ENABLE_LIMIT
        while self.image.state[0] != DriveState.OPERATION_ENABLED:
            if self._now() > end:
                self.image.enable[:] = False
                state = DriveState(int(self.image.state[0])).name.lower().replace("_", " ")
                raise FieldbusError(errors.DRIVE_NOT_ENABLED, axis=self.axis.name, seconds=ENABLE_LIMIT, state=state)
            self._cycle()

    def _set(self, law: JogLaw, position: float) -> None:
        self.image.target_position[0] = position
        self.image.target_velocity[0] = law.velocity if self._spindle else 0.0

    def _cycle(self) -> None:
        """One cycle in its raster. Raises FieldbusError for what befalls the drive."""
        image = self.image
        self.master.read()
        self._ask_torque()
        enabled = bool(image.enable[0]) and image.state[0] == DriveState.OPERATION_ENABLED
        self._reached = self._targets[1]
        error = self._reached - float(image.actual_position[0])
        if enabled and not self._spindle and abs(error) > self.axis.following_error:
            image.quick_stop[:] = True
            self.master.write()
            raise FieldbusError(
                errors.DRIVE_AWAY, axis=self.axis.name, error=abs(error), limit=self.axis.following_error
            )
        actual = float(image.actual_position[0])
        self._targets = (float(image.target_position[0]), self._targets[0]) if enabled else (actual, actual)
        self.master.write()
        self._raise_events()
        self._next += self._period
        if self._next < self._now() - self._period:  # late: no catching up with several set-points at once
            self._next = self._now()
        while self._now() < self._next:
            self._idle()

    def _raise_events(self) -> None:
        events = list(self.image.events)
        self.image.events.clear()
        for event in events:
            problem = problem_of(event, self._machine)
            if problem.entry.severity >= Severity.ERROR:
                raise FieldbusError(problem.entry, Place(), **problem.values)

    def _ask_torque(self) -> None:
        """One SDO access after the other: a cycle sends one frame more, at most."""
        link = self.master.drive(0)
        if link.lost or not has(link, TORQUE):
            return
        questions = self.master.questions(link)
        try:
            answer = questions.poll(self._now())
        except FieldbusError:
            return  # the drive does not tell it now
        if answer is not None:
            self.torque = float(answer)
        if questions.open is None:
            try:
                questions.ask(Access(TORQUE), self._now())
            except (can.CanError, OSError):
                questions.forget()  # the master finds out itself that the bus is gone

    def _sample(self, law: JogLaw) -> Sample:
        image = self.image
        target = float(image.actual_position[0]) if self._spindle else self._reached
        velocity = float(image.actual_velocity[0])
        return Sample(self._now(), target, float(image.actual_position[0]), law.velocity, velocity, self.torque)
