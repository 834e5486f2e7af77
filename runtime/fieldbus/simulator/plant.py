"""The machine around the I/O: which input follows from which output, and when.

The table is that of the demo machine. Rules whose names a machine does not have do nothing, so other machines may use
the same names for the same things.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Follow:
    """`input` becomes TRUE `on` s after `output`, FALSE `off` s after it; `inverted`: of the output's opposite."""

    output: str
    input: str
    on: float
    off: float
    inverted: bool = False


@dataclass(frozen=True, slots=True)
class Interrupt:
    """`input` is TRUE, but FALSE from `begin` to `end` s after a rising edge of `output`."""

    output: str
    input: str
    begin: float
    end: float


@dataclass(frozen=True, slots=True)
class Always:
    """`input` is TRUE unless it is forced."""

    input: str


Rule = Follow | Interrupt | Always
MARGIN: Final = 0.01  # s

DEMO_PLANT: Final[tuple[Rule, ...]] = (
    Follow("clamp_valve", "clamp_closed", on=0.3, off=0.05),
    Follow("clamp_valve", "clamp_open", on=0.3, off=0.05, inverted=True),
    Follow("coolant_pump", "coolant_pressure", on=0.2, off=0.1),
    Follow("tool_unlock", "tool_unlocked", on=0.15, off=0.15),
    # a step of the magazine takes the old tool out and brings the new one in, however long the output stays on
    Interrupt("magazine_step", "tool_in_spindle", begin=0.1, end=0.5),
    Always("door_closed"),
    Always("e_stop_ok"),
)


def _longest(rule: Rule) -> float:
    """Time after a change of its output from which a rule is at rest, s."""
    match rule:
        case Follow():
            return max(rule.on, rule.off)
        case Interrupt():
            return rule.end
        case Always():
            return 0.0


class SimulatedPlant:
    """Steps the rules; `force` overrides an input, as a hand on the door would."""

    def __init__(self, rules: tuple[Rule, ...] = DEMO_PLANT) -> None:
        self._rules = rules
        self.values: dict[str, float] = {}  # analogue inputs, in their unit; 0 where nothing else is said
        self.values_out: dict[str, float] = {}  # analogue outputs, as they have come
        self._slowest = max((_longest(rule) for rule in rules), default=0.0)  # s
        self._forced: dict[str, bool] = {}
        self._before: dict[str, bool] = {}
        self._changed: dict[str, float] = {}  # output → time of its last change
        self._rose: dict[str, float] = {}  # output → time of its last rising edge
        self._inputs: dict[str, bool] = {}
        self._last_change = 0.0
        self._at_rest = False  # all rules: nothing changes until an output does

    def force(self, name: str, value: bool | None) -> None:
        """Hold an input at a value; None lets it go."""
        if value is None:
            self._forced.pop(name, None)
        else:
            self._forced[name] = value
        self._at_rest = False

    def step(self, now: float, outputs: Mapping[str, bool]) -> dict[str, bool]:
        """The inputs at the time `now` (s)."""
        if outputs != self._before:
            self._switch(now, outputs)
        if not self._at_rest:
            self._inputs = {rule.input: self._state(rule, now) for rule in self._rules} | self._forced
            self._at_rest = now - self._last_change > self._slowest + MARGIN
        return self._inputs

    def _switch(self, now: float, outputs: Mapping[str, bool]) -> None:
        self._last_change, self._at_rest = now, False
        for name, state in outputs.items():
            if state != self._before.get(name, False):
                self._changed[name] = now
                if state:
                    self._rose[name] = now
            self._before[name] = state

    def _state(self, rule: Rule, now: float) -> bool:
        long_ago = float("-inf")
        match rule:
            case Follow():
                target = self._before.get(rule.output, False) != rule.inverted
                delay = rule.on if target else rule.off
                # before its time has come the input still is what it was
                return target == (now - self._changed.get(rule.output, long_ago) >= delay)
            case Interrupt():
                elapsed = now - self._rose.get(rule.output, long_ago)
                return not rule.begin <= elapsed < rule.end
            case Always():
                return True
