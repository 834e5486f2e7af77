"""What is mounted at the axis of a simulated drive: limit and home switches, index pulse, touch probes.

Places are in increments of the encoder since power-on, whatever the drive counts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from runtime.config.machine import SimulatedServo
from runtime.drives import (
    PROBE_2_SHIFT,
    PROBE_CONTINUOUS,
    PROBE_FALLING,
    PROBE_HAS_FALLEN,
    PROBE_HAS_RISEN,
    PROBE_IS_ON,
    PROBE_ON,
    PROBE_RISING,
)
from runtime.fieldbus.cia402 import HOME_SWITCH_BIT, NEGATIVE_LIMIT_BIT, POSITIVE_LIMIT_BIT

PROBE_BITS = (0x1_0000, 0x2_0000)  # of 0x60FD: level of probe 1 and 2


@dataclass(frozen=True, slots=True)
class Switches:
    """Where they are; None: there is none."""

    index_distance: float
    home: tuple[float, float] | None
    limits: tuple[float, float] | None

    @staticmethod
    def of(servo: SimulatedServo, increments_per_unit: float) -> Switches:
        def scaled(pair: tuple[float, float] | None) -> tuple[float, float] | None:
            return None if pair is None else (pair[0] * increments_per_unit, pair[1] * increments_per_unit)

        return Switches(servo.index_distance * increments_per_unit, scaled(servo.home_switch), scaled(servo.limits))

    def bits(self, position: float) -> int:
        """The switches as object 0x60FD has them."""
        bits = 0
        if self.home is not None and self.home[0] <= position <= self.home[1]:
            bits |= HOME_SWITCH_BIT
        if self.limits is not None:
            bits |= NEGATIVE_LIMIT_BIT if position <= self.limits[0] else 0
            bits |= POSITIVE_LIMIT_BIT if position >= self.limits[1] else 0
        return bits

    def index_between(self, before: float, after: float) -> float | None:
        """The index pulse that was passed, None if there was none."""
        first, second = math.floor(before / self.index_distance), math.floor(after / self.index_distance)
        return None if first == second else max(first, second) * self.index_distance


class TouchProbe:
    """One probe of a drive. Its signal is high beyond `place`; the drive latches its position at the edge itself."""

    def __init__(self, number: int, place: float | None) -> None:
        self.place = place
        self.status = 0
        self.positions = [0.0, 0.0]  # rising, falling
        self._shift = PROBE_2_SHIFT * (number - 1)
        self._function = 0
        self.touched = False  # it has met the simulated workpiece

    def level(self, position: float) -> bool:
        return self.touched or (self.place is not None and position >= self.place)

    def step(self, function: int, before: float, after: float) -> None:
        """The motor has moved; `function`: object 0x60B8."""
        function = function >> self._shift & 0xFF
        if function != self._function:
            self._function = function
            self.status = PROBE_IS_ON if function & PROBE_ON else 0
        if self.place is not None and self.level(before) is not self.level(after):
            self._store(self.level(after), self.place)

    def touch(self, touched: bool, place: float) -> None:
        """It has met the workpiece, or left it, at `place`."""
        if touched is not self.touched:
            self.touched = touched
            self._store(touched, place)

    def _store(self, rises: bool, place: float) -> None:
        """An edge: latched if the probe is on and waits for it."""
        function = self._function
        if not function & PROBE_ON:
            return
        edge, stored = (PROBE_RISING, PROBE_HAS_RISEN) if rises else (PROBE_FALLING, PROBE_HAS_FALLEN)
        if function & edge and (function & PROBE_CONTINUOUS or not self.status & stored):
            self.positions[0 if rises else 1] = place
            self.status |= stored

    @property
    def bits(self) -> int:
        """Its part of object 0x60B9."""
        return self.status << self._shift
