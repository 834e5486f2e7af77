"""The motion of a block: axis words, circle words and dwell → Line, Arc, Dwell."""

from __future__ import annotations

import math

import numpy as np

from runtime.cnc.blocks import Arc, Dwell, Floats, Line, Source
from runtime.cnc.decoder import circles
from runtime.cnc.decoder.setup import DecoderSetup
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock, Values
from runtime.cnc.language.isg.modal import ModalState, Motion, Plane
from runtime.cnc.language.isg.words import WordKind
from runtime.diagnostics.catalogue import language as catalogue

POSITION_LIMIT = 214_000.0  # mm or degrees (programming manual line 1974)
INCH = 25.4  # mm

# The axes of a plane (indices of main axes) and the letters of its centre and of the pitch (lines 2216–2230, 2480).
PLANES = {
    Plane.XY: ((0, 1), "IJ", "K"),
    Plane.ZX: ((2, 0), "KI", "J"),
    Plane.YZ: ((1, 2), "JK", "I"),
}


class MotionWords:
    """Turns the words of blocks into motion; `position` (n_axes,) in machine coordinates moves along.

    Both calls raise LineError, circles also CircleError.
    """

    def __init__(self, setup: DecoderSetup, start: Floats) -> None:
        self.position = np.array(start, dtype=np.float64)
        self._setup = setup
        self._factors = (setup.inch_factors(False), setup.inch_factors(True))

    def factor(self, modal: ModalState) -> Floats:
        """What programmed coordinates are multiplied with, (n_axes,)."""
        return self._factors[modal.inch]

    def dwell(self, block: CompiledBlock, values: Values, source: Source, modal: ModalState) -> Dwell:
        """G04: seconds, or revolutions of the main spindle."""
        value = values[block.dwell]
        if not 0 <= value < math.inf:
            raise LineError(catalogue.DWELL_NEGATIVE, block.column(WordKind.DWELL), value=value)
        if not block.dwell_revolutions:
            return Dwell(source, value)
        if modal.speed <= 0:
            raise LineError(catalogue.DWELL_SPEED, block.column(WordKind.DWELL))
        return Dwell(source, value / modal.speed * 60.0)

    def move(self, block: CompiledBlock, values: Values, source: Source, modal: ModalState) -> Line | Arc:
        """The motion of the axis words; the position moves along."""
        shift = self._setup.zero_offset(modal.zero_offset)
        factor = self.factor(modal)
        start = self.position.copy()
        end = start.copy()
        for axis, slot in block.axes:
            programmed = values[slot] * factor[axis]
            end[axis] = end[axis] + programmed if modal.incremental else programmed + shift[axis]
            if not (abs(end[axis]) <= POSITION_LIMIT and abs(programmed) <= POSITION_LIMIT):
                target = programmed if abs(programmed) > POSITION_LIMIT else float(end[axis])
                name = self._setup.axes[axis]
                column = block.column(WordKind.AXIS, axis)
                raise LineError(catalogue.POSITION_RANGE, column, value=target, axis=name, limit=POSITION_LIMIT)
        feed = math.inf
        if modal.motion is not Motion.RAPID:
            if modal.feed is None:
                column = block.column(WordKind.AXIS if block.axes else WordKind.INTERPOLATION)
                raise LineError(catalogue.FEED_MISSING, column, motion=int(modal.motion))
            if modal.feed <= 0:
                raise LineError(catalogue.FEED_INVALID, block.column(WordKind.FEED), value=modal.feed)
            feed = modal.feed
        result: Line | Arc
        if modal.motion in (Motion.CIRCLE_CW, Motion.CIRCLE_CCW):
            result = self._arc(block, values, source, modal, start, end, feed, shift)
        elif block.interpolation:
            letter = "IJK"[block.interpolation[0][0]]
            column = block.column(WordKind.INTERPOLATION)
            raise LineError(catalogue.CENTRE_WITHOUT_CIRCLE, column, letter=letter, motion=int(modal.motion))
        else:
            result = Line(source, start, end, feed, modal.motion is Motion.RAPID, end - shift)
        self.position[:] = end
        return result

    def _arc(
        self,
        block: CompiledBlock,
        values: Values,
        source: Source,
        modal: ModalState,
        start: Floats,
        end: Floats,
        feed: float,
        shift: Floats,
    ) -> Arc:
        plane, letters, pitch_letter = PLANES[modal.plane]
        if max(plane) >= len(start):
            raise LineError(
                catalogue.PLANE_UNAVAILABLE,
                block.column(WordKind.AXIS),
                plane=int(modal.plane),
                needed=max(plane) + 1,
                axes=len(start),
            )
        factor = INCH if modal.inch else 1.0
        given = {"IJK"[index]: values[slot] * factor for index, slot in block.interpolation}
        by_centre = any(letter in given for letter in letters)
        first, second = plane
        begin = (float(start[first]), float(start[second]))
        target = (float(end[first]), float(end[second]))
        clockwise = modal.motion is Motion.CIRCLE_CW
        if by_centre:
            if block.radius >= 0:
                raise LineError(catalogue.CENTRE_AND_RADIUS, block.column(WordKind.RADIUS))
            modal.radius = None  # a centre ends the radius (line 2374)
            origin = (float(shift[first]), float(shift[second])) if modal.centre_absolute else begin
            centre = (origin[0] + given.get(letters[0], 0.0), origin[1] + given.get(letters[1], 0.0))
            bounds = (self._setup.centre_shift, self._setup.centre_shift_share)
            circle = circles.by_centre(begin, target, centre, clockwise, *bounds)
        elif modal.radius is not None:
            circle = circles.by_radius(begin, target, modal.radius, clockwise)
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
            third = 3 - first - second
            height = float(end[third] - start[third]) if third < len(start) else 0.0
            angle = circles.turns_with_pitch(angle, height, pitch)
        return Arc(source, start, end, feed, end - shift, plane, np.array(circle.centre), circle.radius, angle)
