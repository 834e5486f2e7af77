"""The dynamic settings of the program in work: every change goes into the block stream at its place."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from runtime.cnc.blocks import DynamicsChange
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.dynamic_settings import DynamicSettings


def set_dynamics(x: Execution, settings: DynamicSettings) -> None:
    """These settings hold from here on."""
    if settings != x.dynamics:
        x.dynamics = settings
        x.emit(DynamicsChange(x.source, settings))


def change_dynamics(x: Execution, **fields: Any) -> None:
    """Some fields of the settings get other values."""
    set_dynamics(x, replace(x.dynamics, **fields))


def after_cycle(before: DynamicSettings, left: DynamicSettings) -> DynamicSettings:
    """What holds behind a cycle: G functions as `before` it, statements and what was programmed for single axes as it has `left`
    them (programming manual lines 7389–7392)."""
    back: dict[str, Any] = {}
    for name in ("rapid_velocity", "geometric_ramp_time", "late_braking", "look_ahead", "corner"):
        back[name] = getattr(before, name)
    for name in ("velocity", "hold_acceleration", "hold_ramp_time"):
        if name not in left.by_axis:
            back[name] = getattr(before, name)
    for name in ("feed", "rapid"):
        was, moves = getattr(before, name), getattr(left, name)
        weights = {
            kind: getattr(was, kind) for kind in ("acceleration", "ramp_time") if f"{name}.{kind}" not in left.by_axis
        }
        back[name] = replace(moves, **weights)
    if before.look_ahead != left.look_ahead:
        back["free_corners"] = before.free_corners
    return replace(left, **back)
