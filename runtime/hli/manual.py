"""The control units of manual mode: keys that are pressed, pulses of handwheels, what links them to axes."""

from __future__ import annotations

from runtime.hli.control import Changes
from runtime.hli.jobs import Jobs
from runtime.hli.layout import (
    HANDWHEELS,
    KEY_PAIRS,
    Activation,
    Channel,
    JogParameter,
    KeyPress,
    OperatorUnit,
)

_WRAP = 1 << 32  # of a handwheel's counter


class ManualCommands:
    """Of one channel. `sample` once per cycle, then read the attributes."""

    def __init__(self, channel: Channel, operator: OperatorUnit) -> None:
        control = channel.control.manual
        self._control = control
        self._operator = operator
        self._changes = Changes(channel.control, "manual", "manual")
        self._operator_changes = Changes(operator, "activation", "handwheel_w")
        self._activations = Jobs[Activation]([control.activation], operator.activation)
        self._parameters = {
            name: Jobs[JogParameter]([getattr(control, name)], getattr(operator, name))
            for name in ("handwheel_parameter", "continuous_parameter", "jog_parameter")
        }
        self._keys = Jobs[KeyPress](control.key, operator.key)
        self._present = False
        self._release_at: dict[int, float] = {}  # key → when it is released by itself
        self._counts = self._count()
        self.pressed = [0] * (KEY_PAIRS + 1)  # by logical key pair: 1, -1, or 0
        self.pulses = [0] * (HANDWHEELS + 1)  # by logical handwheel, in this cycle
        self.activations: list[Activation] = []  # ordered in this cycle
        self.parameters: list[tuple[str, JogParameter]] = []  # unit and values, given in this cycle

    def sample(self, present: bool, time: float) -> None:
        """Take the jobs of this cycle at `time` (s). A PLC that goes releases every key."""
        if self._present and not present:
            self._release_all()
        changed = self._changes.look() | self._operator_changes.look() | (present != self._present)
        self._present = present
        self.activations, self.parameters = [], []
        if self._release_at:
            self._expire(time)
        if not changed:
            if any(self.pulses):
                self.pulses = [0] * (HANDWHEELS + 1)
            return
        self.activations = self._activations.take(present)
        self.parameters = [(name, job) for name, unit in self._parameters.items() for job in unit.take(present)]
        for press in self._keys.take(present):
            self._press(press, time)
        counts, before = self._count(), self._counts
        self._counts = counts
        self.pulses = [0, *(_difference(now, then) for now, then in zip(counts, before, strict=True))]

    def _press(self, press: KeyPress, time: float) -> None:
        if not 1 <= press.key <= KEY_PAIRS:
            return
        self.pressed[press.key] = max(-1, min(int(press.direction), 1))
        self._release_at.pop(press.key, None)
        if press.direction and press.hold_time:
            self._release_at[press.key] = time + press.hold_time * 1e-6

    def _expire(self, time: float) -> None:
        for key in [key for key, end in self._release_at.items() if time >= end]:
            self.pressed[key] = 0
            del self._release_at[key]

    def _release_all(self) -> None:
        self.pressed = [0] * (KEY_PAIRS + 1)
        self._release_at.clear()

    def _count(self) -> list[int]:
        mine, his = self._control.handwheel_w, self._operator.handwheel_w
        return [mine[i] + his[i] for i in range(HANDWHEELS)]


def _difference(now: int, before: int) -> int:
    """Pulses between two readings of a counter that may have gone through its overflow."""
    way = (now - before) % _WRAP
    return way - _WRAP if way >= _WRAP // 2 else way
