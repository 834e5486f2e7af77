"""Executes a parsed program: modal state, parameters, flow and calls → blocks.

A frame per program level, an index into the entries of its unit; control statements set the index. Nothing is looked
ahead.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from runtime.cnc.blocks import (
    Arc,
    Block,
    BlockEnd,
    Dwell,
    Floats,
    Line,
    Source,
    Stop,
    StopKind,
)
from runtime.cnc.decoder import circles
from runtime.cnc.decoder.plain import NeedsFull, PlainRuns
from runtime.cnc.decoder.setup import DecoderSetup
from runtime.cnc.decoder.technology import SUBPROGRAM_END, functions_of
from runtime.cnc.language.errors import CalculationError, ProgramError
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock, Parameters, Values
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.modal import ModalState, Motion, Plane
from runtime.cnc.language.isg.program import Program, Section, Unit
from runtime.cnc.language.isg.words import Control, WordKind
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import ErrorEntry, Problem

POSITION_LIMIT = 214_000.0  # mm or degrees (programming manual line 1974)
MAX_LEVELS = 50  # program levels, the main program is the first (channel parameters line 7555)
POLL = 256  # executed entries between two questions whether to go on
TRUE_FROM = 0.5  # conditions: |value| from here on is true (programming manual line 8355)
_INCH = 25.4
_NUMBER_LIMIT = 2**31

# The axes of a plane (indices of main axes) and the letters of its centre and of the pitch (lines 2216–2230, 2480).
_PLANES = {
    Plane.XY: ((0, 1), "IJ", "K"),
    Plane.ZX: ((2, 0), "KI", "J"),
    Plane.YZ: ((1, 2), "JK", "I"),
}


@dataclass(slots=True)
class _Frame:
    """One program level. `loops` holds the running loops: entry → (counter, end, step) of `$FOR`,
    None of `$WHILE`."""

    unit: Unit
    section: Section
    index: int
    loops: dict[int, tuple[int, float, float] | None] = field(default_factory=dict)


def _never() -> bool:
    return False


def _no_levels() -> int:
    return 0


class Decoder:
    """Executes one program once. Use a new one for the next start: parameters and modal state begin anew.

    `start` (n_axes,) is the position of the channel's axes in machine coordinates. `skip_levels()` gives the
    switched-on skip levels as bits (bit 0: `/` and `/1`). `interrupted()` is asked every POLL executed blocks; when
    it is true the generator ends, so that a loop without motion cannot hold anybody. With `idle_limit` a program that
    executes so many blocks without any output is an error instead.
    """

    def __init__(
        self,
        program: Program,
        setup: DecoderSetup,
        *,
        start: Floats,
        skip_levels: Callable[[], int] = _no_levels,
        interrupted: Callable[[], bool] = _never,
        idle_limit: int | None = None,
    ) -> None:
        self.modal = ModalState(feed=setup.feed if setup.feed > 0 else None)
        self.warnings: list[Problem] = []
        self.executed = 0  # entries so far
        self._program = program
        self._setup = setup
        self._parameters = Parameters()
        self._position = np.array(start, dtype=np.float64)
        self._skip_levels = skip_levels
        self._interrupted = interrupted
        self._idle_limit = idle_limit
        self._idle = 0
        self._plain = PlainRuns(setup.axes, POSITION_LIMIT)
        self._frames = [_Frame(program.unit, program.main, program.main.begin)]
        self._factors: tuple[bool, Floats] = (False, setup.inch_factors(False))

    @property
    def parameters(self) -> dict[int, float]:
        """The P parameters by number, as they are now."""
        return dict(self._parameters)

    @property
    def position(self) -> Floats:
        """End of the last decoded motion in machine coordinates, shape (n_axes,)."""
        return self._position.copy()

    def blocks(self) -> Iterator[Block]:
        """The blocks of the program in order. ProgramError where something is wrong; what came before stays valid."""
        while self._frames:
            frame = self._frames[-1]
            if frame.index >= frame.section.end:
                yield from self._end_of_section()
                continue
            self.executed += 1
            self._idle += 1
            if self.executed % POLL == 0 and self._interrupted():
                return
            entry, unit = frame.index, frame.unit
            line = unit.lines[entry]
            if self._idle_limit is not None and self._idle > self._idle_limit:
                raise ProgramError(catalogue.ENDLESS_LOOP, unit.place(line), count=self._idle_limit)
            frame.index += 1
            if unit.counts[entry]:
                for block in self._run(unit, entry):
                    self._idle = 0
                    yield block
                    if self._interrupted():
                        return
                continue
            for block in self._execute(frame, entry, unit.offsets[entry], line):
                self._idle = 0
                yield block

    # -- entries

    def _run(self, unit: Unit, entry: int) -> Iterator[Block]:
        """A run of plain blocks."""
        offset = self._setup.zero_offset(self.modal.zero_offset)
        for part in self._plain.run(unit, entry, self.modal, self._position, self._factor(), offset):
            if isinstance(part, NeedsFull):
                yield from self._execute(None, entry, part.offset, part.line)
            else:
                yield part

    def _execute(self, frame: _Frame | None, entry: int, offset: int, line: int) -> list[Block]:
        """One block by its compiled form; `frame` is None for a line of a plain run."""
        unit = self._frames[-1].unit
        block = unit.block(offset, line)
        if block.skip_level and self._skip_levels() >> (block.skip_level - 1) & 1:
            return []
        try:
            values = block.values(self._parameters)
            if block.control is not None:
                if frame is not None:
                    self._control(frame, entry, block, values)
                return []
            return self._words(unit, block, values, line)
        except LineError as error:
            raise self._error(unit, line, error.column, block, error.entry, error.values) from None
        except circles.CircleError as error:
            given = {**error.values, "letters": ", ".join(_PLANES[self.modal.plane][1])}
            raise self._error(unit, line, block.column(WordKind.AXIS), block, error.entry, given) from None
        except CalculationError as error:
            column = block.text.upper().find(error.name.upper()) + 1
            raise self._error(unit, line, column or 1, block, error.entry, error.values) from None

    def _error(
        self, unit: Unit, line: int, column: int, block: CompiledBlock, entry: ErrorEntry, values: dict[str, object]
    ) -> ProgramError:
        return ProgramError(entry, unit.place(line, column, block.text), **values)

    # -- flow

    def _control(self, frame: _Frame, entry: int, block: CompiledBlock, values: Values) -> None:
        """A control statement: sets the index of the frame."""
        assert block.control is not None
        link = frame.unit.links[entry]
        control = link.control
        if control is Control.IF:
            self._choose(frame, entry, values)
        elif control in (Control.ELSEIF, Control.ELSE):
            frame.index = link.last + 1  # reached from the branch before it
        elif control is Control.WHILE:
            if _true(values[0]):
                frame.loops[entry] = None
            else:
                frame.loops.pop(entry, None)
                frame.index = link.last + 1
        elif control is Control.FOR:
            self._start_counting(frame, entry, block, values)
        elif control is Control.ENDWHILE:
            if link.first in frame.loops:  # not if the loop's first block was skipped
                frame.index = link.first
        elif control is Control.ENDFOR and link.first in frame.loops:
            self._count(frame, link.first)

    def _choose(self, frame: _Frame, entry: int, values: Values) -> None:
        """Go to the first branch of an `$IF` whose condition is true, else behind its end."""
        links, unit = frame.unit.links, frame.unit
        while not _true(values[0]):
            entry = links[entry].following
            if links[entry].control is not Control.ELSEIF:
                break
            branch = unit.block(unit.offsets[entry], unit.lines[entry])
            try:
                values = branch.values(self._parameters)
            except CalculationError as error:
                column = branch.text.upper().find(error.name.upper()) + 1
                line = unit.lines[entry]
                raise self._error(unit, line, column or 1, branch, error.entry, error.values) from None
        frame.index = entry + 1

    def _start_counting(self, frame: _Frame, entry: int, block: CompiledBlock, values: Values) -> None:
        """`$FOR`: start, end and step are computed once."""
        start, end, step = values[:3]
        counter = int(values[block.counter])
        self._parameters[counter] = start
        if step == 0:
            place = frame.unit.place(frame.unit.lines[entry], block.control.column if block.control else 1, block.text)
            if not any(warning.place == place for warning in self.warnings):
                self.warnings.append(Problem(catalogue.STEP_ZERO, {}, place))
        if _beyond(start, end, step):
            frame.index = frame.unit.links[entry].last + 1
        else:
            frame.loops[entry] = (counter, end, step)

    def _count(self, frame: _Frame, first: int) -> None:
        """`$ENDFOR`: next pass, or leave the loop with the counter beyond the end."""
        running = frame.loops[first]
        assert running is not None
        counter, end, step = running
        value = self._parameters[counter] + step
        self._parameters[counter] = value
        if _beyond(value, end, step):
            del frame.loops[first]
        else:
            frame.index = first + 1

    def _call(self, frame: _Frame, block: CompiledBlock, line: int) -> None:
        """LL or L: a new level."""
        word = block.call
        assert word is not None
        if len(self._frames) >= MAX_LEVELS:
            place = frame.unit.place(line, word.column, block.text)
            raise ProgramError(catalogue.CALL_DEPTH, place, limit=MAX_LEVELS, name=word.name)
        if word.kind is WordKind.CALL_LOCAL:
            unit, section = frame.unit, frame.unit.local_programs[word.name]
        else:
            unit = frame.unit.global_programs[word.name]
            assert unit.main is not None
            section = unit.main
        self._frames.append(_Frame(unit, section, section.begin))

    def _end_of_section(self) -> list[Block]:
        """The last block of a program without M17 or M30: back to the caller, or the end of the program."""
        frame = self._frames.pop()
        if self._frames:
            return []
        line = frame.unit.lines[frame.section.end - 1] if frame.section.end else frame.section.line
        return [Stop(Source(frame.unit.name, line), StopKind.PROGRAM_END)]

    # -- words

    def _words(self, unit: Unit, block: CompiledBlock, values: Values, line: int) -> list[Block]:
        """A block of words."""
        modal = self.modal
        for function in block.g:
            function.apply(modal)
        number = None
        if block.number >= 0:
            if not 0 <= values[block.number] <= _NUMBER_LIMIT:
                raise LineError(
                    catalogue.RESULT_RANGE,
                    max(1, block.text.upper().find("N") + 1),
                    value=values[block.number],
                    name="N",
                )
            number = round_half_up(values[block.number])
        source = Source(unit.name, line, number)
        if block.feed >= 0:
            feed = values[block.feed] * (_INCH if modal.inch else 1.0)
            if not 0 <= feed < math.inf:
                raise LineError(catalogue.FEED_INVALID, block.column(WordKind.FEED), value=values[block.feed])
            modal.feed = feed
        if block.radius >= 0:
            modal.radius = values[block.radius] * (_INCH if modal.inch else 1.0)
        functions = functions_of(block, values, source, self._setup, unit.addresses, modal)
        if block.dwell >= 0:
            motion: list[Block] = [self._dwell(block, values, source)]
        elif block.axes or block.interpolation:
            motion = [self._motion(block, values, source)]
        else:
            motion = []
        out = functions.in_order(source, motion)
        out += [Stop(source, kind) for kind in functions.stops]
        if functions.ending >= 0:
            out += self._ending(functions.ending, unit, block, line, source)
        elif block.call is not None:
            self._call(self._frames[-1], block, line)
        if motion:
            out.append(BlockEnd(source))
        return out

    def _ending(self, number: int, unit: Unit, block: CompiledBlock, line: int, source: Source) -> list[Block]:
        """M17, M29: back to the caller. M02, M30, or M17 in the main program: the end of the program."""
        if number in SUBPROGRAM_END and len(self._frames) > 1:
            self._frames.pop()
            return []
        if len(self._frames) > 1:
            name = self._frames[-1].section.name or unit.name
            place = unit.place(line, block.column(WordKind.M), block.text)
            self.warnings.append(Problem(catalogue.END_IN_SUBPROGRAM, {"number": number, "name": name}, place))
        self._frames.clear()
        return [Stop(source, StopKind.PROGRAM_END)]

    def _dwell(self, block: CompiledBlock, values: Values, source: Source) -> Dwell:
        value = values[block.dwell]
        if not 0 <= value < math.inf:
            raise LineError(catalogue.DWELL_NEGATIVE, block.column(WordKind.DWELL), value=value)
        if not block.dwell_revolutions:
            return Dwell(source, value)
        if self.modal.speed <= 0:
            raise LineError(catalogue.DWELL_SPEED, block.column(WordKind.DWELL))
        return Dwell(source, value / self.modal.speed * 60.0)

    def _motion(self, block: CompiledBlock, values: Values, source: Source) -> Line | Arc:
        """The motion of the axis words; the position moves along."""
        modal = self.modal
        shift = self._setup.zero_offset(modal.zero_offset)
        factor = self._factor()
        start = self._position.copy()
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
            result = self._arc(block, values, source, start, end, feed, shift)
        elif block.interpolation:
            letter = "IJK"[block.interpolation[0][0]]
            column = block.column(WordKind.INTERPOLATION)
            raise LineError(catalogue.CENTRE_WITHOUT_CIRCLE, column, letter=letter, motion=int(modal.motion))
        else:
            result = Line(source, start, end, feed, modal.motion is Motion.RAPID, end - shift)
        self._position[:] = end
        return result

    def _arc(
        self,
        block: CompiledBlock,
        values: Values,
        source: Source,
        start: Floats,
        end: Floats,
        feed: float,
        shift: Floats,
    ) -> Arc:
        modal = self.modal
        plane, letters, pitch_letter = _PLANES[modal.plane]
        if max(plane) >= len(start):
            raise LineError(
                catalogue.PLANE_UNAVAILABLE,
                block.column(WordKind.AXIS),
                plane=int(modal.plane),
                needed=max(plane) + 1,
                axes=len(start),
            )
        factor = _INCH if modal.inch else 1.0
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

    def _factor(self) -> Floats:
        """What programmed coordinates are multiplied with, (n_axes,)."""
        if self._factors[0] != self.modal.inch:
            self._factors = (self.modal.inch, self._setup.inch_factors(self.modal.inch))
        return self._factors[1]


def _true(value: float) -> bool:
    return abs(value) >= TRUE_FROM


def _beyond(value: float, end: float, step: float) -> bool:
    """Whether a counter has passed the end of its loop."""
    return value > end if step >= 0 else value < end
