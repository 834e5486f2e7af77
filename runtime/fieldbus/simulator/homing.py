"""Homing of a simulated drive, by the method numbers of CiA 402: each method is a row of stretches.

A stretch goes in one direction with one of the two homing speeds until something is seen. Methods that are not in the table end
in a homing error, as does a limit switch that is met on the way to something else.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto
from typing import Final

from runtime.fieldbus.cia402 import HOME_SWITCH_BIT, NEGATIVE_LIMIT_BIT, POSITIVE_LIMIT_BIT
from runtime.fieldbus.simulator.profile import Profile
from runtime.fieldbus.simulator.switches import Switches


class Until(Enum):
    """What ends a stretch."""

    ON = auto()  # the switch is active
    OFF = auto()  # it is not
    INDEX = auto()  # the index pulse is passed


@dataclass(frozen=True, slots=True)
class Stretch:
    direction: int
    until: Until
    switch: int = 0  # bit of 0x60FD
    slow: bool = False


def _off_the(switch: int, direction: int) -> tuple[Stretch, Stretch]:
    """To the switch in a direction, and slowly back off it."""
    return Stretch(direction, Until.ON, switch), Stretch(-direction, Until.OFF, switch, slow=True)


METHODS: Final[dict[int, tuple[Stretch, ...]]] = {
    1: (*_off_the(NEGATIVE_LIMIT_BIT, -1), Stretch(1, Until.INDEX, slow=True)),
    2: (*_off_the(POSITIVE_LIMIT_BIT, 1), Stretch(-1, Until.INDEX, slow=True)),
    3: (*_off_the(HOME_SWITCH_BIT, 1), Stretch(-1, Until.INDEX, slow=True)),
    5: (*_off_the(HOME_SWITCH_BIT, -1), Stretch(1, Until.INDEX, slow=True)),
    17: _off_the(NEGATIVE_LIMIT_BIT, -1),
    18: _off_the(POSITIVE_LIMIT_BIT, 1),
    19: _off_the(HOME_SWITCH_BIT, 1),
    21: _off_the(HOME_SWITCH_BIT, -1),
    33: (Stretch(-1, Until.INDEX, slow=True),),
    34: (Stretch(1, Until.INDEX, slow=True),),
    35: (),
    37: (),
}


class Homing:
    """`begin`, then `step` in every cycle; `attained` and `error` are bits 12 and 13 of the status word."""

    def __init__(self, switches: Switches) -> None:
        self._switches = switches
        self._rest: list[Stretch] = []
        self.running = self.attained = self.error = False

    def begin(self, method: int) -> None:
        self.attained, self.error = False, method not in METHODS
        self._rest = list(METHODS.get(method, ()))
        self.running = not self.error

    def stop(self) -> None:
        self.running = False

    def step(
        self, profile: Profile, before: float, after: float, speeds: tuple[float, float], ramp: float, dt: float
    ) -> float | None:
        """One cycle of the command, after the motor went from `before` to `after`; the reference, when it is found."""
        if not self.running:
            profile.at(0.0, ramp, ramp, dt)
            return None
        if not self._rest:
            self.running, self.attained = False, True
            profile.at(0.0, ramp, ramp, dt)
            return after
        stretch = self._rest[0]
        bits = self._switches.bits(after)
        found = self._seen(stretch, bits, before, after)
        if found is not None:
            del self._rest[0]
            if not self._rest:
                self.running, self.attained = False, True
                profile.at(0.0, ramp, ramp, dt)
                return found
        elif bits & (NEGATIVE_LIMIT_BIT if stretch.direction < 0 else POSITIVE_LIMIT_BIT) & ~stretch.switch:
            self.running, self.error = False, True
        profile.at(stretch.direction * speeds[1 if stretch.slow else 0], ramp, ramp, dt)
        return None

    def _seen(self, stretch: Stretch, bits: int, before: float, after: float) -> float | None:
        match stretch.until:
            case Until.INDEX:
                return self._switches.index_between(before, after)
            case Until.ON:
                return after if bits & stretch.switch else None
            case Until.OFF:
                return None if bits & stretch.switch else after
