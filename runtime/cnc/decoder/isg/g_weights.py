"""Weights of velocity, acceleration and ramp time: G127…G134, G230…G233, G333…G339 (programming manual 5004–5256).

A weight always counts from what the machine description gives, so the same one twice changes nothing. An axis that was never
named has 100 %.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from runtime.cnc.decoder.dynamics import change_dynamics, set_dynamics
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import GCall, g_function
from runtime.cnc.dynamic_settings import DynamicSettings, Shares, with_share
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.syntax import Group, Values
from runtime.cnc.language.isg.words import WordKind
from runtime.diagnostics.catalogue import language as catalogue

_VELOCITY, _RAPID = "isg.g.velocity-weight-g127-g128", "isg.g.rapid-weight-g129"
_ACCELERATION, _RAMP = "isg.g.acceleration-weight", "isg.g.ramp-time-weight"


@dataclass(frozen=True, slots=True)
class _Weight:
    """Which field of the settings a function weights: `moves` is "feed", "rapid", or "" for a field of its own."""

    moves: str
    field: str

    @property
    def name(self) -> str:
        return f"{self.moves}.{self.field}" if self.moves else self.field

    def of(self, settings: DynamicSettings) -> Shares:
        held: Shares = getattr(getattr(settings, self.moves) if self.moves else settings, self.field)
        return held

    def put(self, settings: DynamicSettings, shares: Shares) -> DynamicSettings:
        fields: dict[str, Any] = {self.field: shares}
        if not self.moves:
            return replace(settings, **fields)
        chosen: dict[str, Any] = {self.moves: replace(getattr(settings, self.moves), **fields)}
        return replace(settings, **chosen)


def share(value: float, column: int) -> float:
    """A programmed percentage as a factor; LineError for one below 0."""
    if not 0.0 <= value < float("inf"):
        raise LineError(catalogue.WEIGHT_INVALID, column, value=value)
    return value / 100.0


def _by_axis(number: int, spec: str, *weights: _Weight) -> None:
    @g_function(
        number, Group.ARGUMENTS, spec, syntax=f"G{number} <axis><percent> {{<axis><percent>}}", axis_arguments=True
    )
    def weight(x: Execution, call: GCall) -> None:
        """Axes that are not named keep their weights."""
        assert x.block is not None
        chosen = {
            axis: share(value, x.block.column(WordKind.AXIS, axis))
            for axis, value in x.raw_arguments(number, call.column).items()
        }
        settings = x.dynamics
        for one in weights:
            settings = one.put(settings, with_share(one.of(settings), len(x.setup.axes), chosen))
        set_dynamics(x, replace(settings, by_axis=settings.by_axis | {one.name for one in weights}))


def _for_all(number: int, spec: str, *weights: _Weight) -> None:
    @g_function(number, Group.NONE, spec, syntax=f"G{number}=<percent>", values=Values.EQUALS)
    def weight(x: Execution, call: GCall) -> None:
        """Axis words beside it are positions."""
        assert call.value is not None
        factor = share(call.value, call.column)
        shares: Shares = () if factor == 1.0 else (factor,) * len(x.setup.axes)
        settings = x.dynamics
        for one in weights:
            settings = one.put(settings, shares)
        set_dynamics(x, replace(settings, by_axis=settings.by_axis - {one.name for one in weights}))


_by_axis(127, _VELOCITY, _Weight("", "velocity"))
_for_all(128, _VELOCITY, _Weight("", "velocity"))
_by_axis(130, _ACCELERATION, _Weight("feed", "acceleration"))
_for_all(131, _ACCELERATION, _Weight("feed", "acceleration"))
_by_axis(230, _ACCELERATION, _Weight("rapid", "acceleration"))
_for_all(231, _ACCELERATION, _Weight("rapid", "acceleration"))
_by_axis(333, _ACCELERATION, _Weight("", "hold_acceleration"))
_for_all(334, _ACCELERATION, _Weight("", "hold_acceleration"))
_by_axis(132, _RAMP, _Weight("feed", "ramp_time"))
_for_all(133, _RAMP, _Weight("feed", "ramp_time"))
_for_all(233, _RAMP, _Weight("rapid", "ramp_time"))
_by_axis(338, _RAMP, _Weight("", "hold_ramp_time"))
_for_all(339, _RAMP, _Weight("", "hold_ramp_time"))


@g_function(129, Group.NONE, _RAPID, syntax="G129=<percent>", values=Values.EQUALS)
def rapid_velocity(x: Execution, call: GCall) -> None:
    assert call.value is not None
    factor = share(call.value, call.column)
    change_dynamics(x, rapid_velocity=factor)


@g_function(134, Group.NONE, _RAMP, syntax="G134=<percent>", values=Values.EQUALS)
def geometric_ramp_time(x: Execution, call: GCall) -> None:
    """How fast the acceleration across the path may change."""
    assert call.value is not None
    change_dynamics(x, geometric_ramp_time=share(call.value, call.column))
