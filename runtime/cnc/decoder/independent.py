"""Own motions of axes of the channel in a program: where they begin, and where the path waits for them (manual, line 29533).

    block with INDP_SYN:   functions in front ─ own motions begin ─ path motion ─ wait for them ─ functions behind
    block with INDP_ASYN:  functions in front ─ own motions begin ─ path motion ─ functions behind … #WAIT INDP

An axis that still moves is waited for before the path or an own motion moves it again, and where a statement asks for positions.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from runtime.cnc.blocks import IndependentWait, Synch
from runtime.cnc.decoder.block_functions import Functions, put_out
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.modal import PLANE_AXES, Motion
from runtime.cnc.decoder.setup import AxisDynamics
from runtime.cnc.language.isg.comments import LineError
from runtime.diagnostics.catalogue import axes as errors

ALLOWED = (Synch.MOS, Synch.MVS_SVS, Synch.MVS_SNS, Synch.MNS_SNS)
EXACT_AT_G60, EXACT_AT_WAIT = 1, 2  # P-CHAN-00297
_HALVINGS = 60
_SAME = 1e-9


def ramp_time(velocity: float, can: AxisDynamics) -> float:
    """Seconds from rest to a velocity."""
    if velocity * can.jerk >= can.acceleration * can.acceleration:
        return velocity / can.acceleration + can.acceleration / can.jerk
    return 2.0 * math.sqrt(velocity / can.jerk)


def speed_for(seconds: float, way: float, can: AxisDynamics) -> float:
    """The velocity at which a motion over `way` takes that long; the axis' own where it cannot be so quick. mm, degrees, s.

    From rest to rest the ramps take the way v t(v) together, t the time of one, so the motion takes way / v + t(v), which falls
    as long as the ramps fit into the way.
    """

    def halved(low: float, high: float, is_high: Callable[[float], bool]) -> float:
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if is_high(middle) else (middle, high)
        return high

    peak = halved(0.0, can.velocity, lambda v: v * ramp_time(v, can) >= way)
    if way <= 0.0 or way / peak + ramp_time(peak, can) >= seconds:
        return can.velocity
    return halved(0.0, peak, lambda v: way / v + ramp_time(v, can) <= seconds)


def wait_for(x: Execution, axes: Iterable[int], *, exact: bool = False) -> None:
    """The path waits here for own motions of these axes that it has not waited for yet."""
    state = x.independent
    waited = state.running & set(axes)
    if waited:
        state.running -= waited
        x.emit(IndependentWait(x.source, tuple(sorted(waited)), exact))
        x.modal_changed()


def wait_before_motion(x: Execution, end: list[float]) -> None:
    """In front of a motion of the path to `end` (n_axes,): axes that it moves, or (P-CHAN-00451) names, are waited for."""
    state = x.independent
    if not state.running:
        return
    begin = x.coordinates.position
    moved = {axis for axis in state.running if abs(end[axis] - begin[axis]) > _SAME}
    if x.modal.motion not in (Motion.RAPID, Motion.LINEAR):
        moved |= set(PLANE_AXES[x.modal.plane])
    if x.setup.independent_waits_named:
        moved |= x.axis_words.keys()
    wait_for(x, moved)


def begin_own_motions(x: Execution, functions: Functions) -> None:
    """Functions of the brackets join those of the block. Raises LineError."""
    for own in x.independent.of_block:
        area = x.setup.areas.get(x.setup.axes[own.axis], -1)
        for block in (*functions.before, *functions.after):
            if getattr(block, "area", -1) == area >= 0 and own.motion is not None:
                raise LineError(errors.INDEPENDENT_FUNCTION, own.column, axis=x.setup.axes[own.axis])
    for own in x.independent.of_block:
        area = x.setup.areas.get(x.setup.axes[own.axis], -1)
        for function in own.functions:
            put_out(x, functions, function.kind, function.number, 0.0, function.column, area)


def emit_own_motions(x: Execution) -> None:
    """The own motions of the block begin here."""
    for own in x.independent.of_block:
        if own.motion is None:
            continue
        x.emit(own.motion)
        position = x.coordinates.position.copy()
        position[own.axis] = own.motion.target
        x.coordinates.position = position
        x.independent.running.add(own.axis)
    x.modal_changed()


def end_own_motions(x: Execution, *, exact_stop: bool) -> None:
    """Behind the motion of the block: INDP_SYN is waited for; with G60 also what the block names (P-CHAN-00297)."""
    own = x.independent.of_block
    if own:
        wait_for(x, [one.axis for one in own if one.waits])
        own.clear()
    if exact_stop and x.setup.independent_exact_stop == EXACT_AT_G60:
        wait_for(x, x.axis_words, exact=True)
