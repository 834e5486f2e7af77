"""Threads and tapping in a program: G33, G63, G331, G332 (programming manual 23300–23768).

The pitch along an axis becomes an angle of the spindle per mm of path: 360° · (share of the axis in the path) / pitch.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from runtime.cnc.blocks import Corner, DynamicsChange, Flush, FlushKind, Line, SpindleRole, SpindleTurn
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.feed_group import queue_length
from runtime.cnc.decoder.modal import PLANE_AXES, FeedMode, Motion
from runtime.cnc.decoder.motion import pcs_gain, programmed_at, target
from runtime.cnc.decoder.radius_compensation import expect_none
from runtime.cnc.decoder.setup import SpindleSetup
from runtime.cnc.decoder.spindles import TURNING
from runtime.cnc.dynamic_settings import DynamicSettings
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock
from runtime.cnc.language.isg.words import WordKind
from runtime.diagnostics.catalogue import spindle as errors

TURN = 360.0  # degrees
DEGREES_PER_SECOND = 6.0  # per rev/min
PLAN_SHARE = 0.7  # of the spindle's acceleration that the path uses in tapping; the rest corrects its angle
_NO_WAY = 1e-9  # mm


def thread(x: Execution, block: CompiledBlock, corner: Corner | None) -> None:
    """G33: the path follows the angle of the spindle, which turns."""
    name = "G33"
    setup = _spindle(x, block, corner, name)
    sections, state = x.sections, x.spindles.main_programmed
    pitch = _pitch(x, block, name)
    if pitch is not None:
        if not 0.0 < pitch[1] < math.inf:
            raise LineError(errors.THREAD_PITCH, _letter(block), letter="IJK"[pitch[0]], value=pitch[1])
        sections.pitch = pitch
    if sections.pitch is None:
        raise LineError(errors.THREAD_PITCH_MISSING, block.column(WordKind.AXIS))
    if state.command not in TURNING or state.positioned or not state.speed > 0.0:
        raise LineError(errors.SPINDLE_STANDS, block.column(WordKind.AXIS), name=setup.name)
    axis, per_turn = sections.pitch
    end = target(x, block)
    way = [e - s for s, e in zip(x.coordinates.position, end, strict=True)]
    length = queue_length(way)
    share = abs(way[axis]) / length if axis < len(way) and length > _NO_WAY else 0.0
    if share < 1e-6:
        raise _no_way(x, block, name, axis)
    velocity = state.speed / 60.0 * per_turn / share
    _expect_possible(x, _speed_column(block), name, setup, way, length, velocity, state.speed)
    sections.open(x, SpindleRole.THREAD, x.spindles.main)
    x.emit(SpindleTurn(x.source, TURN * share / per_turn))
    x.emit(_line(x, end, velocity * 60.0))
    x.coordinates.moved(end)
    if not sections.chain:
        sections.close(x)


def tap(x: Execution, block: CompiledBlock, corner: Corner | None) -> None:
    """G63, G331, G332: the spindle, which stands before, follows the path."""
    name = f"G{int(x.modal.motion)}"
    setup = _spindle(x, block, corner, name)
    sections, state = x.sections, x.spindles.main_programmed
    if not sections.tapping and state.command in TURNING and not state.positioned:
        raise LineError(errors.SPINDLE_TURNS, block.column(WordKind.G), motion=name, name=setup.name)
    end = target(x, block)
    way = [e - s for s, e in zip(x.coordinates.position, end, strict=True)]
    length = queue_length(way)
    if x.modal.motion is Motion.TAPPING:
        speed, feed, turn = _by_feed(x, block)
    else:
        speed, feed, turn = _by_pitch(x, block, name, way)
    if length <= _NO_WAY:
        x.coordinates.moved(end)
        return
    _expect_possible(x, _speed_column(block), name, setup, way, length, feed / 60.0, abs(speed))
    stroke(x, setup, end, feed, turn)


def stroke(x: Execution, setup: SpindleSetup, end: list[float], feed: float, turn: float) -> None:
    """A straight move that the main spindle follows with `turn` degrees per mm; `feed` in mm/min. It opens a section."""
    x.sections.open(x, SpindleRole.TAPPING, x.spindles.main)
    x.emit(SpindleTurn(x.source, turn))
    x.emit(DynamicsChange(x.source, _limited(x, setup, abs(turn))))
    x.emit(_line(x, end, feed))
    x.emit(Flush(x.source, FlushKind.STOP))  # the spindle stands where it begins to turn the other way
    x.emit(DynamicsChange(x.source, x.dynamics))
    x.coordinates.moved(end)


def expect_stroke(x: Execution, motion: str, column: int, way: list[float], feed: float, speed: float) -> SpindleSetup:
    """The main spindle for a `stroke` of this way. LineError if it cannot be followed, or one of both cannot go so fast."""
    setup = expect_follower(x, motion, column)
    _expect_possible(x, column, motion, setup, way, queue_length(way), feed / 60.0, speed)
    return setup


def take_speed(x: Execution, value: float, column: int) -> None:
    """The S word of a block of tapping: it turns nothing by itself."""
    name = f"G{int(x.modal.motion)}"
    if value == 0.0 or not abs(value) < math.inf:
        raise LineError(errors.TAPPING_ZERO, column, motion=name, word="S")
    if x.modal.motion is Motion.TAPPING_OUT:
        x.sections.retract_speed = abs(value)
        return
    x.sections.speed = value
    x.spindles.main_programmed.speed = x.modal.speed = abs(value)


def _by_feed(x: Execution, block: CompiledBlock) -> tuple[float, float, float]:
    """G63: speed (rev/min), feed (mm/min) and turn (degrees per mm) of the last F and S."""
    if x.modal.feed_mode is not FeedMode.PER_MINUTE:
        raise LineError(errors.TAPPING_FEED_MODE, block.column(WordKind.G), mode=int(x.modal.feed_mode))
    feed = x.modal.feed or 0.0
    speed = _programmed_speed(x)
    for word, value, kind in (("F", feed, WordKind.FEED), ("S", speed, WordKind.SPEED)):
        if value == 0.0:
            raise LineError(errors.TAPPING_ZERO, block.column(kind), motion="G63", word=word)
    return speed, feed, TURN * speed / feed


def _by_pitch(x: Execution, block: CompiledBlock, name: str, way: list[float]) -> tuple[float, float, float]:
    """G331, G332: the same of pitch and speed."""
    sections, tapped = x.sections, x.sections.tapped
    pitch = _pitch(x, block, name)
    inward = x.modal.motion is Motion.TAPPING_IN
    if inward:
        if pitch is not None:
            sections.tapped = pitch
        sections.retract_speed = None
    elif pitch is not None and tapped is not None and pitch != tapped:
        raise LineError(errors.RETRACT_PITCH, _letter(block), value=pitch[1], before=tapped[1])
    used = pitch or tapped
    if used is None:
        raise LineError(errors.TAPPING_PITCH_MISSING, block.column(WordKind.G), motion=name)
    axis, per_turn = used
    if per_turn == 0.0 or not abs(per_turn) < math.inf:
        raise LineError(errors.TAPPING_ZERO, _letter(block), motion=name, word="a pitch")
    others = [k for k, w in enumerate(way) if abs(w) > _NO_WAY and k != axis]
    if others:
        raise LineError(
            errors.PITCH_AXIS, _letter(block), motion=name, letter="IJK"[axis], axis=_axis_name(x, axis),
            what=f"has to move alone: {x.setup.axes[others[0]]} moves",
        )  # fmt: skip
    speed = abs(_programmed_speed(x))
    if not inward and sections.retract_speed is not None:
        speed = sections.retract_speed
    if speed == 0.0:
        raise LineError(errors.TAPPING_ZERO, block.column(WordKind.SPEED), motion=name, word="S")
    feed = abs(per_turn) * speed
    x.modal.feeds[FeedMode.PER_MINUTE] = feed  # it stays (line 23660)
    return speed, feed, TURN / per_turn * (1.0 if inward else -1.0)


def _programmed_speed(x: Execution) -> float:
    """The last S, with its sign if it was one of tapping."""
    speed = x.modal.speed
    return math.copysign(speed, x.sections.speed) if abs(x.sections.speed) == speed else speed


def _limited(x: Execution, setup: SpindleSetup, turn: float) -> DynamicSettings:
    """The dynamic settings with what the spindle can as limits along the path; `turn` in degrees per mm."""
    can, moves = setup.dynamics, x.dynamics.feed
    vector = replace(
        moves.vector,
        velocity=min(moves.vector.velocity, can.velocity / turn),
        acceleration=min(moves.vector.acceleration, PLAN_SHARE * can.acceleration / turn),
        deceleration=min(moves.vector.deceleration, PLAN_SHARE * can.acceleration / turn),
        jerk=min(moves.vector.jerk, PLAN_SHARE * can.jerk / turn),
    )
    return replace(x.dynamics, feed=replace(moves, vector=vector))


# ---------------------------------------------------------------------------------------------------- in common


def expect_follower(x: Execution, motion: str, column: int) -> SpindleSetup:
    """The main spindle; LineError if nobody can be followed, or can follow."""
    if not x.setup.spindles:
        raise LineError(errors.SPINDLE_NEEDED, column, what=motion, reason="the channel has none")
    setup = x.setup.spindles[x.spindles.main]
    if setup.plc:
        reason = f"the PLC moves {setup.name}"
        raise LineError(errors.SPINDLE_NEEDED, column, what=motion, reason=reason)
    expect_none(x, motion, column)
    return setup


def _spindle(x: Execution, block: CompiledBlock, corner: Corner | None, motion: str) -> SpindleSetup:
    """The main spindle; LineError if it cannot be followed, or for what cannot be beside it."""
    column = block.column(WordKind.AXIS)
    setup = expect_follower(x, motion, column)
    for word, beside in (
        ("a chamfer or rounding", corner is not None),
        ("E", x.end_feed is not None),
        ("G166", x.override_off),
        ("a linear change of the feed", x.feed_change is not None),
        ("#SPLINE or #HSC", x.smoothing.spline_on or x.smoothing.hsc_on),
        ("#FILTER", x.smoothing.filter.on),
        ("manual mode (G201)", bool(x.manual_axes)),
        ("an own motion of an axis", bool(x.independent.running)),
        ("R", block.radius >= 0),
    ):
        if beside:
            raise LineError(errors.BESIDE, column, word=word, motion=motion)
    return setup


def _pitch(x: Execution, block: CompiledBlock, motion: str) -> tuple[int, float] | None:
    """Axis and pitch (mm) of the letter in the block, None without."""
    if len(x.letters) > 1:
        letters = " and ".join("IJK"[index] for index in sorted(x.letters))
        raise LineError(errors.PITCH_TWICE, _letter(block), motion=motion, letters=letters)
    return next(((index, x.length(value)) for index, value in x.letters.items()), None)


def take_offset(x: Execution, block: CompiledBlock) -> None:
    """The S.OFFSET word: where the threads from here on begin."""
    value, column = x.values[block.spindle_offset], block.column(WordKind.SPINDLE_OFFSET)
    name = next(word.name for word in block.words if word.kind is WordKind.SPINDLE_OFFSET)
    x.spindles.expect_main(name, column)
    if not 0.0 <= value < TURN:
        raise LineError(errors.OFFSET_RANGE, column, name=name, value=value)
    x.sections.offset = float(value)


def _letter(block: CompiledBlock) -> int:
    return block.column(WordKind.INTERPOLATION if block.interpolation else WordKind.AXIS)


def _axis_name(x: Execution, axis: int) -> str:
    return x.setup.axes[axis] if axis < len(x.setup.axes) else "an axis that the channel does not have"


def _no_way(x: Execution, block: CompiledBlock, motion: str, axis: int) -> LineError:
    return LineError(
        errors.PITCH_AXIS, _letter(block), motion=motion, letter="IJK"[axis], axis=_axis_name(x, axis),
        what="does not move in this block",
    )  # fmt: skip


def _speed_column(block: CompiledBlock) -> int:
    return block.column(WordKind.SPEED if block.speed >= 0 else WordKind.AXIS)


def _expect_possible(
    x: Execution,
    column: int,
    motion: str,
    setup: SpindleSetup,
    way: list[float],
    length: float,
    velocity: float,
    speed: float,
) -> None:
    """LineError if an axis or the spindle cannot go so fast: `velocity` in mm/s for `speed` in rev/min."""
    name = setup.name
    fastest = setup.dynamics.velocity / DEGREES_PER_SECOND
    if speed > fastest * (1.0 + 1e-9):
        raise LineError(errors.TOO_FAST, column, motion=motion, what=name, speed=speed, name=name, limit=fastest)
    for axis, (w, most) in enumerate(zip(way, x.setup.axis_velocity or [math.inf] * len(way), strict=True)):
        needed = abs(w) / length * velocity
        if needed > most * (1.0 + 1e-9):
            limit = speed * most / needed
            what = x.setup.axes[axis]
            raise LineError(errors.TOO_FAST, column, motion=motion, what=what, speed=speed, name=name, limit=limit)


def _line(x: Execution, end: list[float], feed: float) -> Line:
    """The straight move, at a feed in mm/min along the path."""
    start = x.take_path_start()
    programmed = np.array(programmed_at(x, end))
    plane = PLANE_AXES[x.modal.plane]
    return Line(x.source, np.array(start), np.array(end), feed, False, programmed, plane, pcs_gain=pcs_gain(x))
