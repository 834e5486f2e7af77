"""Executes a parsed program: modal state, parameters, flow and calls → blocks.

A frame per program level, an index into the entries of its unit; control statements set the index. Nothing is looked
ahead.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from runtime.cnc.blocks import (
    Block,
    BlockEnd,
    Floats,
    Source,
    Stop,
    StopKind,
)
from runtime.cnc.decoder import circles
from runtime.cnc.decoder.motion import INCH, PLANES, POSITION_LIMIT, MotionWords
from runtime.cnc.decoder.plain import NeedsFull, PlainRuns
from runtime.cnc.decoder.setup import DecoderSetup
from runtime.cnc.decoder.technology import SUBPROGRAM_END, functions_of
from runtime.cnc.language.errors import CalculationError, ProgramError
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock, Parameters, Values
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.modal import ModalState
from runtime.cnc.language.isg.program import Program, Section, Unit
from runtime.cnc.language.isg.words import Control, WordKind
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import ErrorEntry, Problem

MAX_LEVELS = 50  # program levels, the main program is the first (channel parameters line 7555)
POLL = 256  # executed entries between two questions whether to go on
TRUE_FROM = 0.5  # conditions: |value| from here on is true (programming manual line 8355)
_NUMBER_LIMIT = 2**31


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
        self._motion = MotionWords(setup, start)
        self._skip_levels = skip_levels
        self._interrupted = interrupted
        self._idle_limit = idle_limit
        self._idle = 0
        self._plain = PlainRuns(setup.axes, POSITION_LIMIT)
        self._frames = [_Frame(program.unit, program.main, program.main.begin)]

    @property
    def parameters(self) -> dict[int, float]:
        """The P parameters by number, as they are now."""
        return dict(self._parameters)

    @property
    def position(self) -> Floats:
        """End of the last decoded motion in machine coordinates, shape (n_axes,)."""
        return self._motion.position.copy()

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
        for part in self._plain.run(
            unit, entry, self.modal, self._motion.position, self._motion.factor(self.modal), offset
        ):
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
            given = {**error.values, "letters": ", ".join(PLANES[self.modal.plane][1])}
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
            feed = values[block.feed] * (INCH if modal.inch else 1.0)
            if not 0 <= feed < math.inf:
                raise LineError(catalogue.FEED_INVALID, block.column(WordKind.FEED), value=values[block.feed])
            modal.feed = feed
        if block.radius >= 0:
            modal.radius = values[block.radius] * (INCH if modal.inch else 1.0)
        functions = functions_of(block, values, source, self._setup, unit.addresses, modal)
        if block.dwell >= 0:
            motion: list[Block] = [self._motion.dwell(block, values, source, modal)]
        elif block.axes or block.interpolation:
            motion = [self._motion.move(block, values, source, modal)]
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


def _true(value: float) -> bool:
    return abs(value) >= TRUE_FROM


def _beyond(value: float, end: float, step: float) -> bool:
    """Whether a counter has passed the end of its loop."""
    return value > end if step >= 0 else value < end
