"""The motion of a block: axis words, circle words and dwell → blocks."""

from __future__ import annotations

import math

import numpy as np

from runtime.cnc.blocks import Arc, Corner, Dwell, Floats, Line
from runtime.cnc.decoder import circles
from runtime.cnc.decoder.arcs import radius_transition
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.feed import feed_of, group_ratio, require_feed
from runtime.cnc.decoder.feed_change import changing_arc, changing_line
from runtime.cnc.decoder.independent import wait_before_motion
from runtime.cnc.decoder.modal import PLANE_AXES, Motion, Plane
from runtime.cnc.decoder.modulo import modulo_end
from runtime.cnc.decoder.turning import halved
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock, Values
from runtime.cnc.language.motion_words import MotionBlock, WordKind
from runtime.diagnostics.catalogue import axes
from runtime.diagnostics.catalogue import language as catalogue

POSITION_LIMIT = 214_000.0  # mm or degrees (programming manual line 1974)

# The axes of a plane (indices of main axes) and the letters of its centre and of the pitch (lines 2216–2230, 2480).
PLANES = {
    Plane.XY: (PLANE_AXES[Plane.XY], "IJ", "K"),
    Plane.ZX: (PLANE_AXES[Plane.ZX], "KI", "J"),
    Plane.YZ: (PLANE_AXES[Plane.YZ], "JK", "I"),
}


def dwell(x: Execution, block: CompiledBlock, values: Values) -> None:
    """G04: seconds, or revolutions of the main spindle."""
    value, column = values[block.dwell], block.column(WordKind.DWELL)
    if not block.dwell_revolutions:
        dwell_time(x, value, column)
        return
    if x.modal.speed <= 0:
        raise LineError(catalogue.DWELL_SPEED, column)
    x.dwell_revolutions = value
    dwell_time(x, value / x.modal.speed * 60.0, column)


def dwell_time(x: Execution, seconds: float, column: int) -> None:
    """Dwell for a time in s."""
    if not 0 <= seconds < math.inf:
        raise LineError(catalogue.DWELL_NEGATIVE, column, value=seconds)
    x.emit(Dwell(x.source, seconds))


def target(x: Execution, block: MotionBlock) -> list[float]:
    """Machine position that the axis words of the block lead to; LineError beyond the range of positions.

    With G90 an axis that turns without end goes to the position in the direction of the sign behind its name, less than a
    turn; without a sign it takes the shorter way (line 29123).
    """
    words = {axis: x.axis_value(axis, value) for axis, value in x.axis_words.items()}
    halved(x, words)
    directions = x.turn_directions(words)
    if directions is None:
        directions = _directions(x, block, words) if block.signs or x.modulo.ranges else {}
    end = x.coordinates.target(words, x.incremental_words or x.modal.incremental)
    for axis, programmed in words.items():
        if not abs(programmed) <= POSITION_LIMIT:
            raise _out_of_range(x, block, axis, programmed)
    expect_in_range(x, block, end)
    for axis, direction in directions.items():
        turned = direction if x.coordinates.gain[axis] > 0.0 else -direction  # a mirrored axis turns the other way
        end[axis] = modulo_end(x.coordinates.position[axis], end[axis], x.modulo.size(axis), turned)
    wait_before_motion(x, end)
    return end


def _directions(x: Execution, block: MotionBlock, words: dict[int, float]) -> dict[int, int]:
    """Of the axes that turn without end and get an absolute word: 1, -1, or 0 for the shorter way. The first sign of a word is
    taken out of its value in `words`, since it is the direction alone."""
    signs = dict(block.signs)
    directions = {}
    for axis, value in words.items():
        given = signs.get(axis, "")
        sign = 0 if not given else -1 if given[0] == "-" else 1
        if axis not in x.modulo.ranges:
            if len(given) > 1:
                raise LineError(axes.TWO_SIGNS, block.column(WordKind.AXIS, axis), axis=x.setup.axes[axis])
        elif not x.incremental_words.get(axis, x.modal.incremental):
            if x.modulo.always_shortest:
                sign = 0
            directions[axis] = sign
            words[axis] = value * sign if sign else value
        elif sign and value * sign < 0.0:
            column = block.column(WordKind.AXIS, axis)
            raise LineError(axes.MODULO_NEGATIVE, column, axis=x.setup.axes[axis], value=value * sign)
    return directions


def expect_in_range(x: Execution, block: MotionBlock, end: list[float]) -> None:
    """LineError for a machine position beyond the range of positions."""
    for axis, value in enumerate(end):
        if not abs(value) <= POSITION_LIMIT and axis not in x.modulo.ranges:
            raise _out_of_range(x, block, axis, value)


def _out_of_range(x: Execution, block: MotionBlock, axis: int, value: float) -> LineError:
    column = block.column(WordKind.AXIS, axis if axis in x.axis_words else -1)
    return LineError(catalogue.POSITION_RANGE, column, value=value, axis=x.setup.axes[axis], limit=POSITION_LIMIT)


def move(x: Execution, block: MotionBlock, corner: Corner | None) -> None:
    """The motion of the axis and circle words of the block; the position moves along."""
    modal, coordinates = x.modal, x.coordinates
    circle = modal.motion in (Motion.CIRCLE_CW, Motion.CIRCLE_CCW)
    if x.letters and not circle:
        letter = "IJK"[next(iter(x.letters))]
        column = block.column(WordKind.INTERPOLATION)
        raise LineError(catalogue.CENTRE_WITHOUT_CIRCLE, column, letter=letter, motion=int(modal.motion))
    end = target(x, block)
    if circle:
        if x.setup.modal_centre:
            _keep_centre(x)
        require_feed(x, block)
        _arc(x, block, end, corner)
    else:
        straight(x, block, end, corner)
    coordinates.moved(end)


def _keep_centre(x: Execution) -> None:
    """I, J and K of the centre hold for the circles behind, too, until a radius is programmed (P-CHAN-00159)."""
    kept = x.modal.centre
    letters = ["IJK".index(letter) for letter in PLANES[x.modal.plane][1]]
    given = {index: x.length(x.letters[index]) for index in letters if index in x.letters}
    if not given and x.modal.radius is not None:
        kept.clear()
        return
    kept |= given
    x.letters |= {index: x.shown_length(kept[index]) for index in letters if index in kept and index not in given}


def straight(x: Execution, block: MotionBlock, end: list[float], corner: Corner | None, faster: float = 1.0) -> None:
    """A straight move to a machine position; the position is not moved along. `faster`: than F says."""
    rapid = x.modal.motion is Motion.RAPID
    feed = math.inf
    if not rapid:
        require_feed(x, block)
    start = x.take_path_start()
    ratio = 1.0
    if not rapid:
        feed = feed_of(x, block, start, end, None) * faster
        ratio = group_ratio(x, block, start, end, None)
    programmed = programmed_at(x, end)
    line = Line(
        x.source,
        np.array(start),
        np.array(end),
        feed,
        rapid,
        np.array(programmed),
        PLANE_AXES[x.modal.plane],
        corner,
        None if x.end_feed is None else x.end_feed * ratio,
        x.override_off,
        pcs_gain(x),
    )
    if x.feed_change is None or rapid:
        x.emit(line)
        return
    expect_bare(x, block, corner)
    change, before = x.feed_change
    x.emit(changing_line(line, change, before * ratio))


def expect_bare(x: Execution, block: MotionBlock, corner: Corner | None) -> None:
    """LineError for what cannot stand beside a linear feed change."""
    for word, given in (
        ("chamfer or rounding", corner is not None),
        ("E", x.end_feed is not None),
        ("G166", x.override_off),
    ):
        if given:
            raise LineError(catalogue.FEED_CHANGE_BESIDE, block.column(WordKind.G), word=word)


def pcs_gain(x: Execution) -> Floats | None:
    """Machine way per programmed way, None for 1 in all axes."""
    return None if x.coordinates.unit_gain else np.array(x.coordinates.gain)


def programmed_at(x: Execution, end: list[float]) -> list[float]:
    """Programmed coordinates of a machine position under what is selected now, mapped onto the machine axes."""
    c = x.coordinates
    return [(p - s) / g for p, g, s in zip(end, c.gain, c.shift, strict=True)]


def plane_of(x: Execution, block: MotionBlock) -> tuple[tuple[int, int], str, str]:
    """Axes and letters of the active plane; LineError if the channel has not so many axes."""
    plane, letters, pitch_letter = PLANES[x.modal.plane]
    if max(plane) >= len(x.setup.axes):
        raise LineError(
            catalogue.PLANE_UNAVAILABLE,
            block.column(WordKind.AXIS),
            plane=int(x.modal.plane),
            needed=max(plane) + 1,
            axes=len(x.setup.axes),
        )
    return plane, letters, pitch_letter


def clockwise(x: Execution) -> bool:
    """The sense of the circle on the machine: mirroring one axis of the plane turns it around."""
    first, second = PLANES[x.modal.plane][0]
    gain = x.coordinates.gain
    turned = max(first, second) < len(gain) and gain[first] * gain[second] < 0
    return (x.modal.motion is Motion.CIRCLE_CW) != turned


def centre_point(x: Execution, plane: tuple[int, int], letters: str) -> circles.Point:
    """The programmed centre in machine coordinates of the plane."""
    c, modal = x.coordinates, x.modal
    given = {"IJK"[index]: x.length(value) for index, value in x.letters.items()}
    values = (given.get(letters[0], 0.0), given.get(letters[1], 0.0))
    if c.rotation is not None and c.rotation.plane == plane:
        turned = c.rotation.turned(values[0] * c.scale_of(plane[0]), values[1] * c.scale_of(plane[1]))
        mirrored = [turned[i] * c.mirror(plane[i]) for i in (0, 1)]
        shift = [c.rotation.centre[i] * c.mirror(plane[i]) + c.shift[plane[i]] for i in (0, 1)]
    else:
        mirrored = [values[i] * c.gain[plane[i]] for i in (0, 1)]
        shift = [c.shift[plane[i]] for i in (0, 1)]
    origin = shift if modal.centre_absolute else [c.position[plane[0]], c.position[plane[1]]]
    return (origin[0] + mirrored[0], origin[1] + mirrored[1])


def size_scale(x: Execution, plane: tuple[int, int]) -> float:
    """What radii, and sizes of chamfers and roundings, are scaled with: the factor of X if it lies in the plane (line 17367)."""
    return x.coordinates.scale_of(0 if 0 in plane else plane[0])


def _arc(x: Execution, block: MotionBlock, end: list[float], corner: Corner | None) -> None:
    modal, start = x.modal, x.coordinates.position
    plane, letters, pitch_letter = plane_of(x, block)
    given = {"IJK"[index]: x.length(value) for index, value in x.letters.items()}
    by_centre = any(letter in given for letter in letters)
    begin = (start[plane[0]], start[plane[1]])
    goal = (end[plane[0]], end[plane[1]])
    sense = clockwise(x)
    if by_centre:
        if block.radius >= 0:
            raise LineError(catalogue.CENTRE_AND_RADIUS, block.column(WordKind.RADIUS))
        modal.radius = None  # a centre ends the radius (line 2374)
        centre = centre_point(x, plane, letters)
        if modal.centre_correction:
            circle = circles.by_centre(begin, goal, centre, sense, x.setup.centre_shift, x.setup.centre_shift_share)
        else:
            bounds = (x.setup.radius_change, x.setup.radius_change_share)
            circle = circles.by_kept_centre(begin, goal, centre, sense, *bounds)
        note_circle(x, plane, circle, centre)
    elif modal.radius is not None:
        circle = circles.by_radius(begin, goal, modal.radius * size_scale(x, plane), sense)
        note_circle(x, plane, circle, circle.centre)
    else:
        column = block.column(WordKind.AXIS)
        letters_text = ", ".join(letters)
        raise LineError(catalogue.CENTRE_MISSING, column, motion=int(modal.motion), letters=letters_text)
    angle = circle.angle
    if pitch_letter in given:
        pitch = given[pitch_letter]
        if not pitch > 0:
            column = block.column(WordKind.INTERPOLATION, "IJK".index(pitch_letter))
            raise LineError(catalogue.PITCH_INVALID, column, letter=pitch_letter, value=pitch)
        third = 3 - plane[0] - plane[1]
        if third < len(start):
            height = end[third] - start[third]
            angle = circles.turns_with_pitch(angle, height, pitch * x.coordinates.scale_of(third))
    emit_arc(x, block, end, plane, circles.Circle(circle.centre, circle.radius, angle), corner)


def emit_arc(
    x: Execution,
    block: MotionBlock,
    end: list[float],
    plane: tuple[int, int],
    circle: circles.Circle,
    corner: Corner | None,
    faster: float = 1.0,
) -> None:
    """An arc to a machine position; the position is not moved along. `faster`: than F says."""
    x.expect_path_start(block.column(WordKind.AXIS if block.axes else WordKind.INTERPOLATION))
    start = x.coordinates.position
    feed = feed_of(x, block, start, end, (plane, circle)) * faster
    ratio = group_ratio(x, block, start, end, (plane, circle))
    arc = Arc(
        x.source,
        np.array(start),
        np.array(end),
        feed,
        np.array(programmed_at(x, end)),
        plane,
        np.array(circle.centre),
        circle.radius,
        circle.angle,
        corner,
        None if x.end_feed is None else x.end_feed * ratio,
        x.override_off,
        pcs_gain(x),
    )
    if x.feed_change is not None:
        expect_bare(x, block, corner)
    arcs = [arc] if x.modal.centre_correction else radius_transition(arc)
    for piece in arcs:
        if x.feed_change is None:
            x.emit(piece)
        else:
            change, before = x.feed_change
            for part in changing_arc(piece, change, before * ratio):
                x.emit(part)


def note_circle(x: Execution, plane: tuple[int, int], circle: circles.Circle, programmed: circles.Point) -> None:
    """What V.G.I, J, K, V.G.R and V.G.MERR tell: the centre relative to the start, and how far it was moved."""
    start = x.coordinates.position
    centre = [0.0, 0.0, 0.0]
    for place, axis in enumerate(plane):
        centre[axis] = circle.centre[place] - start[axis]
    moved = [circle.centre[0] - programmed[0], circle.centre[1] - programmed[1]]
    x.circle = (centre, moved, circle.radius)
