"""Measuring blocks of a program: G100 and what it leaves behind (programming manual 3234–3675).

The block is decoded once. Behind it the decoder waits until the path stands; then it counts from there, and the values are known.
What was measured is kept in machine coordinates, with the programmed ones as they were under what was selected then.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from runtime.cnc.blocks import (
    DynamicsChange,
    Flush,
    FlushKind,
    LimitBehaviour,
    Line,
    Measurement,
    MeasurementEnd,
    PathRestart,
    Probe,
    ProbeSignal,
    StepEnd,
)
from runtime.cnc.decoder.additions import corner_of, expect_no_line
from runtime.cnc.decoder.couplings import expect_uncoupled
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.feed import feed_of, group_ratio, require_feed
from runtime.cnc.decoder.independent import wait_for
from runtime.cnc.decoder.measuring_state import Measured, Run
from runtime.cnc.decoder.modal import PLANE_AXES, FeedMode, Motion
from runtime.cnc.decoder.motion import pcs_gain, programmed_at, target
from runtime.cnc.decoder.radius_compensation import expect_none
from runtime.cnc.dynamic_settings import DynamicSettings, HoldUse
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock
from runtime.cnc.language.isg.words import WordKind
from runtime.diagnostics.catalogue import measuring as catalogue

MAIN_AXES = 3
NO_WAY = 1e-6  # mm or degrees
_STRAIGHT = (Motion.RAPID, Motion.LINEAR)
TYPES = (1, 2, 3, 4)  # that G100 measures with
INTERRUPTING = 5  # type of G310


def measure(x: Execution, block: CompiledBlock, jump: Callable[[], None] | None = None) -> bool:
    """The measuring run of the block; whether anything moves. `jump`: what G310 does behind a signal. Raises LineError."""
    state, column = x.measuring, x.measuring.column
    if not column:
        raise LineError(catalogue.G106_ALONE, state.through_column)
    _expect_possible(x, block, column)
    axes = _axes_of(x, block)
    probes = _probes_of(x, block, axes)
    start = x.coordinates.position
    end = target(x, block)
    state.done.difference_update(axes)
    if all(abs(e - s) <= NO_WAY for s, e in zip(start, end, strict=True)):
        if x.setup.measuring.error_no_way:
            raise LineError(catalogue.NO_WAY, column)
        return False
    rapid = bool(state.interrupts_column) and x.modal.motion is Motion.RAPID
    feed = math.inf if rapid else _feed(x, block, start, end)
    limited, driven = _within_limits(x, start, end) if x.setup.measuring.within_limits else (False, end)
    if all(abs(e - s) <= NO_WAY for s, e in zip(start, driven, strict=True)):
        raise LineError(catalogue.LIMIT_WITHOUT_SIGNAL, column)
    usual = x.dynamics
    settings = _dynamics(x)
    x.emit(Flush(x.source, FlushKind.CONTINUE))  # nothing before it is smoothed into the run
    x.emit(
        Measurement(
            x.source,
            probes,
            through=bool(state.through_column),
            may_be_deflected=x.setup.measuring.may_be_deflected,
            signal_needed=_signal_needed(x),
            limited=limited,
        )
    )
    if settings != usual:
        x.emit(DynamicsChange(x.source, settings))
    x.emit(
        Line(
            x.source,
            np.array(start),
            np.array(driven),
            feed,
            rapid,
            np.array(programmed_at(x, driven)),
            PLANE_AXES[x.modal.plane],
            None,
            None,
            x.override_off,
            pcs_gain(x),
        )
    )
    x.emit(MeasurementEnd(x.source))
    if settings != usual:
        x.emit(DynamicsChange(x.source, usual))
    x.coordinates.moved(driven)
    state.pending = Run(axes, start, end, column, bool(state.interrupts_column), jump)
    return True


def wait_for_values(x: Execution) -> None:
    """The end of the block: the decoder goes on when the path stands, and the values are known.

    Single block stops at a gate of its own, as the path stands already where the block ends.
    """
    if x.call_shown is None and x.steps.ends(x.source.n):
        x.emit(StepEnd(x.source))
    x.emit(Flush(x.source, FlushKind.WAIT))


def take_values(x: Execution) -> Callable[[], None] | None:
    """The path stands at the end of the run: the decoder counts from there. The jump that is to be made, None without."""
    state = x.measuring
    run, state.pending = state.pending, None
    assert run is not None
    measured, position = x.outside.measured(), x.outside.command_position()
    if position is None or measured is None:  # without a machine a run ends at its target
        measured = {} if run.interrupts else dict(enumerate(x.coordinates.machine(run.end)))
    else:
        x.coordinates.moved_to([float(p) for p in position])
        x.emit(PathRestart(x.source))
    by_hand = x.outside.manual_offsets()
    found = {axis: measured[axis] for axis in run.axes if axis in measured}
    offsets = [0.0] * len(run.end) if by_hand is None else [float(p) for p in by_hand]
    _note_point(x, run, found, offsets)
    for axis, place in found.items():
        state.places[axis] = place
        state.done.add(axis)
    return run.jump if found else None


# ---------------------------------------------------------------------------------------------------- what may be measured


def _expect_possible(x: Execution, block: CompiledBlock, column: int) -> None:
    """LineError for what no measuring run goes with."""
    expect_none(x, "G310" if x.measuring.interrupts_column else "G100", column)
    smoothing = x.smoothing
    for active, what in (
        (x.modal.contouring, "polynomial contouring"),
        (smoothing.spline_on, "a spline"),
        (smoothing.hsc_on, "HSC"),
        (x.modal.feed_mode is FeedMode.PER_REVOLUTION, "a feed per revolution (G95)"),
        (x.modal.diameter, "diameter programming (G51)"),
    ):
        if active:
            raise LineError(catalogue.BARRED, column, what=what)
    expect_uncoupled(x, "G100", column)
    expect_no_line(x)
    for given, what in (
        (block.dwell >= 0, "a dwell"),
        (bool(x.letters), "I, J or K"),
        (bool(x.additions) or corner_of(x, block) is not None, "an addition to the contour"),
        (x.feed_change is not None, "a linear feed change"),
        (x.end_feed is not None, "E"),
        (bool(x.axes_taken), "a function with axis words as arguments"),
        (bool(x.measuring.interrupts_column) and x.modal.motion not in _STRAIGHT, "a circle"),
    ):
        if given:
            raise LineError(catalogue.BESIDE, column, what=what)
    x.expect_path_start(column)
    wait_for(x, tuple(x.independent.running))


def _axes_of(x: Execution, block: CompiledBlock) -> tuple[int, ...]:
    """The axes that measure: those of the block, and those that turn with one of them, if they can. P-CHAN-00327: in a coordinate
    system all that can."""
    axes = set(x.axis_words)
    if not axes:
        raise LineError(catalogue.AXES_MISSING, x.measuring.column)
    for axis in sorted(axes):
        if x.measuring.probes[axis] is None:
            raise LineError(catalogue.NOT_MEASURING, block.column(WordKind.AXIS, axis), axis=x.setup.axes[axis])
    with_them = _together(x)
    everything = x.setup.measuring.all_axes and bool(x.systems.chain)
    if everything:
        with_them = set(range(len(x.setup.axes)))
    if everything or axes & with_them:
        axes |= {axis for axis in with_them if x.measuring.probes[axis] is not None}
    return tuple(sorted(axes))


def _probes_of(x: Execution, block: CompiledBlock, axes: tuple[int, ...]) -> tuple[Probe, ...]:
    state, column = x.measuring, x.measuring.column
    if state.type not in ((INTERRUPTING,) if state.interrupts_column else TYPES):
        raise LineError(catalogue.TYPE_UNSUPPORTED, column, value=state.type)
    if state.through_column and state.type != 3:
        raise LineError(catalogue.G106_ALONE, state.through_column)
    if state.type == 2 and len(x.axis_words) != 1:
        raise LineError(catalogue.ONE_AXIS, column, count=len(x.axis_words))
    probes = []
    for axis in axes:
        at, name = block.column(WordKind.AXIS, axis), x.setup.axes[axis]
        if state.type == 4 and axis >= MAIN_AXES:
            raise LineError(catalogue.MAIN_AXES_ONLY, at, axis=name)
        probe = state.probes[axis]
        assert probe is not None
        if probe.signal is ProbeSignal.DRIVE and (probe.number, probe.rising) not in probe.latched:
            edge = "rising" if probe.rising else "falling"
            raise LineError(catalogue.PROBE_UNKNOWN, at, axis=name, edge=edge, number=probe.number)
        probes.append(Probe(axis, probe.signal, probe.number, probe.level, probe.rising))
    return tuple(probes)


def _signal_needed(x: Execution) -> bool:
    state = x.measuring
    if state.interrupts_column:
        return False  # without a signal the next block follows
    if state.signal_needed is not None:
        return state.signal_needed or state.type == 2
    return state.type == 2 or x.setup.measuring.error_no_signal


def _feed(x: Execution, block: CompiledBlock, start: list[float], end: list[float]) -> float:
    """mm/min along the path: F, or that of the axis with type 2."""
    if x.measuring.type != 2:
        require_feed(x, block)
        return feed_of(x, block, start, end, None)
    axis = next(iter(x.axis_words))
    probe = x.measuring.probes[axis]
    if probe is None or probe.feed is None:
        raise LineError(catalogue.FEED_MISSING, x.measuring.column, axis=x.setup.axes[axis])
    return probe.feed * group_ratio(x, block, start, end, None)


def _within_limits(x: Execution, start: list[float], end: list[float]) -> tuple[bool, list[float]]:
    """Whether the run would leave the software limits, and how far it may go in its direction (P-CHAN-00268)."""
    share = 1.0
    on_machine = zip(x.coordinates.machine(start), x.coordinates.machine(end), strict=True)
    for axis, (s, e) in enumerate(on_machine):
        if x.limit_behaviour[axis] is not LimitBehaviour.ERROR:
            continue
        low, high = x.soft_limits[axis]
        if e > high and e > s:
            share = min(share, (high - s) / (e - s))
        elif e < low and e < s:
            share = min(share, (low - s) / (e - s))
    if share >= 1.0:
        return False, end
    share = max(share, 0.0)
    return True, [s + share * (e - s) for s, e in zip(start, end, strict=True)]


def _dynamics(x: Execution) -> DynamicSettings:
    """What a run is planned and braked with (channel parameters 2887–2955)."""
    setup, usual = x.setup.measuring, x.dynamics
    if setup.as_feed:
        return replace(usual, hold_use=HoldUse.RAMP)
    unweighted = replace(usual.feed, acceleration=(), ramp_time=())
    return replace(
        usual,
        feed=unweighted,
        path_weights=0,
        hold_acceleration=(),
        hold_ramp_time=(),
        hold_use=HoldUse.AS_ELSE if setup.brakes_as_rapid else HoldUse.CONFIGURED,
    )


# ---------------------------------------------------------------------------------------------------- programmed coordinates


def _note_point(x: Execution, run: Run, found: Mapping[int, float], by_hand: list[float]) -> None:
    """The measured point in the active system, as it would be programmed, and seen from the target; `found`: axis → machine
    coordinate. Axes that turn with each other count together: all of them have a value, or none."""
    setup, c, state = x.setup.measuring, x.coordinates, x.measuring
    start, end = c.machine(run.start), c.machine(run.end)
    known = set(found)
    together = _together(x)
    if known & together:
        missing = together - known
        if setup.command_counts:
            missing = {axis for axis in missing if abs(end[axis] - start[axis]) > NO_WAY}
        for axis in sorted(missing):
            x.warn(catalogue.NO_PCS_VALUE, run.column, axis=x.setup.axes[axis])
        known = known - together if missing else known | together
    machine = [found.get(axis, end[axis]) for axis in range(len(end))]
    with_hand = c.of_machine(machine)
    point = c.of_machine([place - by_hand[axis] for axis, place in enumerate(machine)])
    if setup.includes_ball and x.tools.radius:
        way = [run.end[axis] - run.start[axis] for axis in range(min(MAIN_AXES, len(run.end)))]
        length = math.hypot(*way)
        if length > NO_WAY:
            for axis, part in enumerate(way):
                point[axis] += x.tools.radius * part / length
    programmed = c.programmed_of(point)
    for axis in known:
        state.programmed[axis] = programmed[axis]
    for axis in known if c.frame is not None else set(found):
        below = c.lower[axis] if axis < MAIN_AXES else 0.0
        state.values[axis] = Measured(with_hand[axis] - below, with_hand[axis] - run.end[axis])
        (state.turned.add if c.frame is not None and axis < MAIN_AXES else state.turned.discard)(axis)


def _together(x: Execution) -> set[int]:
    """Axes of which a programmed coordinate needs the machine coordinates of all."""
    if x.coordinates.frame is not None:
        return set(range(MAIN_AXES))
    return set() if x.coordinates.rotation is None else set(x.coordinates.rotation.plane)
