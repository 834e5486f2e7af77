"""Executes a program: blocks by their index, modal state, calls → blocks of motion, functions and actions.

A frame per program level, an index into the entries of its unit; control statements, jumps and calls set the index. The file is
read no further than the execution needs it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from runtime.cnc.blocks import Block, Floats, Flush, FlushKind, Hold, SearchMark, Source
from runtime.cnc.decoder import additions
from runtime.cnc.decoder.block import WordBlocks
from runtime.cnc.decoder.corners import Corners
from runtime.cnc.decoder.cycles import after_block
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.flow import Flow, OutOfStepError
from runtime.cnc.decoder.frames import Frame, Level
from runtime.cnc.decoder.geometry_error import GeometryError
from runtime.cnc.decoder.independent import wait_for
from runtime.cnc.decoder.levels import Levels
from runtime.cnc.decoder.measuring import take_values
from runtime.cnc.decoder.memory import ChannelMemory
from runtime.cnc.decoder.modal import ModalState
from runtime.cnc.decoder.motion import PLANES, POSITION_LIMIT
from runtime.cnc.decoder.outside import Offline, Outside, WaitForOutside
from runtime.cnc.decoder.plain import NeedsFull, PlainRuns
from runtime.cnc.decoder.program import Program
from runtime.cnc.decoder.radius_compensation import expect_none
from runtime.cnc.decoder.search import TargetFinder
from runtime.cnc.decoder.sequences import next_pass
from runtime.cnc.decoder.setup import DecoderSetup
from runtime.cnc.decoder.tool_management import ToolWait
from runtime.cnc.language.errors import CalculationError, ProgramError
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock, Values
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.index import MIDDLE, Unit
from runtime.cnc.language.isg.words import WordKind
from runtime.cnc.search_target import BlockSearch
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.catalogue.control_areas import SPACE_OPEN
from runtime.diagnostics.errors import ErrorEntry, Problem

POLL = 256  # executed entries between two questions whether to go on
HANDED_OVER = 64  # executed entries after which collected moves are handed over at the latest
_NUMBER_LIMIT = 2**31


def _never() -> bool:
    return False


def _no_levels() -> int:
    return 0


def _reached_from_above(block: CompiledBlock) -> bool:
    """Whether the block is the head of a branch: as a block of its own it only leads out, its condition is not asked."""
    return block.control is not None and block.control.control in MIDDLE


def _values(x: Execution, block: CompiledBlock) -> Values:
    """The values of a block; of one that waits for its tool those that it had: its assignments are not executed twice."""
    waiting = x.waiting
    return waiting.values if isinstance(waiting, ToolWait) and waiting.block is block else block.values()


class Decoder:
    """Executes one program once. Use a new one for the next start: parameters and modal state begin anew.

    `start` (n_axes,) is the position of the channel's axes in machine coordinates. `memory` is what outlives programs;
    `outside` the machine around. `skip_levels()` gives the switched-on skip levels as bits (bit 0: `/` and `/1`).
    `interrupted()` is asked every POLL executed blocks; when it is true the generator ends, so that a loop without motion
    cannot hold anybody. With `idle_limit` a program that executes so many blocks without any output is an error instead.
    `search`: a `SearchMark` tells where the execution comes to the block at which the program is to be entered.
    """

    def __init__(
        self,
        program: Program,
        setup: DecoderSetup,
        *,
        start: Floats,
        memory: ChannelMemory | None = None,
        outside: Outside | None = None,
        skip_levels: Callable[[], int] = _no_levels,
        interrupted: Callable[[], bool] = _never,
        idle_limit: int | None = None,
        search: BlockSearch | None = None,
    ) -> None:
        self.executed = 0  # entries so far
        self.execution = x = Execution(
            setup, memory or ChannelMemory(setup), outside or Offline(), program.library, start, skip_levels
        )
        self._x = x
        self._flow = Flow(x)
        self._levels = Levels(x)
        self._words = WordBlocks(x, self._flow)
        self._interrupted = interrupted
        self._idle_limit = idle_limit
        self._idle = 0
        self._plain = PlainRuns(setup.axes, POSITION_LIMIT)
        main = program.unit.main
        assert main is not None
        x.frames.append(Frame(program.unit, main, main.begin, Level.MAIN, name=main.name))
        x.source = Source(program.unit.name, main.line)
        self._search = None if search is None else TargetFinder(search, program.unit)

    @property
    def modal(self) -> ModalState:
        """The modal state as it is now."""
        return self._x.modal

    @property
    def warnings(self) -> list[Problem]:
        """Warnings so far."""
        return self._x.warnings

    @property
    def parameters(self) -> dict[int, float]:
        """The P parameters by number, as they are now."""
        return dict(self._x.parameters)

    @property
    def position(self) -> Floats:
        """End of the last decoded motion in machine coordinates, shape (n_axes,)."""
        return self._x.coordinates.array()

    def blocks(self) -> Iterator[Block]:
        """The blocks of the program in order. ProgramError where something is wrong; what came before stays valid.

        A `Hold` among them says that the program waits for the outside: go on asking later.
        """
        corners = Corners(self._x.setup.axes)
        corners.warnings = self._x.warnings
        return corners(self._blocks())

    def _blocks(self) -> Iterator[Block]:
        x = self._x
        repeating = False  # the block is executed once more: nothing came between, the interpolator is where it was
        try:
            self._words.begin_program()
            self._levels.begin()
            while x.frames:
                frame = x.frames[-1]
                entry, unit = frame.index, frame.unit
                if frame.sequence is not None and frame.sequence.over((entry, frame.row)):
                    next_pass(x)
                    continue
                if not unit.has(entry, frame.section):
                    if len(x.frames) == 1 and x.line_waits:
                        self._expect_no_line(unit)
                    if len(x.frames) == 1 and x.open_area is not None:
                        place = unit.place(x.open_area.line)
                        number = x.open_area.number
                        raise ProgramError(SPACE_OPEN, place, number=number, what="#CONTROL AREA END is missing")
                    self._levels.end_of_section()
                    yield from self._handed_over()
                    continue
                if unit.notes:
                    self._tell_notes(unit)
                self.executed += 1
                self._idle += 1
                if self.executed % HANDED_OVER == 0:
                    if x.collected and not self._corner_ahead(frame, unit, entry):
                        yield from self._handed_over()
                    if self.executed % POLL == 0:
                        if self._interrupted():
                            return
                        if len(x.frames) == 1:
                            unit.forget(entry)
                if self._idle_limit is not None and self._idle > self._idle_limit:
                    raise ProgramError(catalogue.ENDLESS_LOOP, unit.place(unit.line(entry)), count=self._idle_limit)
                if self._search is not None and self._search.pending and not repeating:
                    self._look_for_target(self._search, frame, unit, entry)
                frame.index = entry + 1
                if unit.count(entry):
                    if unit.corner_follows(entry, frame.section):  # the last motion has to stay at hand
                        x.flush_run()
                        parts = list(
                            self._run(frame, unit, entry)
                        )  # it hands over x.out too, so not into x.out at once
                        x.out.extend(parts)
                        continue
                    yield from self._handed_over()
                    for part in self._run(frame, unit, entry):
                        self._idle = 0
                        yield part
                        if self._interrupted():
                            return
                    continue
                if unit.faults:
                    self._tell_fault(unit, entry)
                block = x.compiled(unit, entry)
                if block.skip_level and x.skip_levels() >> (block.skip_level - 1) & 1:
                    continue
                flushes = block.flush and not _reached_from_above(block)
                if flushes and not repeating and not x.line_waits:
                    yield from self._flushed(unit, block)
                self._flow.in_step = flushes
                try:
                    self._execute(frame, entry, block)
                except OutOfStepError:
                    self._expect_no_line(unit)
                    yield from self._flushed(unit, block)
                    self._flow.in_step = True
                    self._execute(frame, entry, block)
                repeating = x.again is not None
                if x.again is not None:
                    yield from self._handed_over()
                    frame.index, reason, x.again = entry, x.again, None
                    yield Hold(x.source, reason)
                    if self._interrupted():
                        return
                elif x.measuring.pending is not None:
                    yield from self._handed_over()
                    self._jump(unit, block, take_values(x))
                elif x.out and not unit.corner_follows(entry, frame.section):
                    yield from self._handed_over()
        except ProgramError:
            x.sections.close(x)
            yield from self._handed_over()
            raise
        yield from self._handed_over()

    def _look_for_target(self, search: TargetFinder, frame: Frame, unit: Unit, entry: int) -> None:
        """Mark the place of a block search; in a plain run it is marked where the run comes to it."""
        rows = self._plain.rows(unit, entry) if unit.count(entry) else None
        row = search.row(frame, unit, entry, rows)
        if row > frame.row:
            frame.target_row = row
        elif row >= 0:
            self._mark(unit, unit.line(entry) + row)

    def _mark(self, unit: Unit, line: int) -> None:
        self._x.flush_run()
        self._x.out.append(SearchMark(Source(unit.name, line)))

    def _corner_ahead(self, frame: Frame, unit: Unit, entry: int) -> bool:
        """Whether the entry is, or comes shortly before, a block that gives a corner to the last motion."""
        return entry in unit.corner_blocks or unit.corner_follows(entry, frame.section)

    def _handed_over(self) -> Iterator[Block]:
        """Everything that was emitted; nothing while a contour line waits for the next one."""
        x = self._x
        if x.line_waits:
            return
        x.flush_run()
        if x.out:
            out, x.out = x.out, []
            self._idle = 0
            yield from out

    def _flushed(self, unit: Unit, block: CompiledBlock) -> Iterator[Block]:
        """The preparation comes into step with the interpolator before a block that reads something of it."""
        self._expect_no_compensation(unit, block)
        if block.statement is not None:  # it asks for the place of the axes, or where they are
            wait_for(self._x, tuple(self._x.independent.running))
        yield from self._handed_over()
        yield Flush(Source(unit.name, block.source.line), FlushKind.WAIT)

    def _expect_no_compensation(self, unit: Unit, block: CompiledBlock) -> None:
        """No block that reads something of the cycle may stand between compensated ones."""
        command = "reading a value of the cycle"
        if block.statement is not None:
            command = "#" + block.statement.statement.syntax.name
        try:
            expect_none(self._x, command, 1)
        except LineError as error:
            raise self._error(unit, error.column, block, error.entry, error.values) from None

    def _expect_no_line(self, unit: Unit) -> None:
        """The program is over, or flushes: no contour line may be waiting. The place is the block in work."""
        x = self._x
        try:
            additions.expect_no_line(x)
        except GeometryError as error:
            raise ProgramError(error.entry, unit.place(*x.place(1)), **error.values) from None

    def _jump(self, unit: Unit, block: CompiledBlock, jump: Callable[[], None] | None) -> None:
        """What a block does when its run is over."""
        if jump is None:
            return
        try:
            jump()
        except LineError as error:
            raise self._error(unit, error.column, block, error.entry, error.values) from None

    def _tell_fault(self, unit: Unit, entry: int) -> None:
        fault = unit.faults.get(entry)
        if fault is not None:
            raise ProgramError(fault.entry, unit.place(fault.line, fault.column, fault.text), **fault.values)

    def _tell_notes(self, unit: Unit) -> None:
        """Warnings of the index."""
        for note in unit.notes:
            place = unit.place(note.line, note.column, note.text)
            self._x.warnings.append(Problem(note.entry, note.values, place))
        unit.notes.clear()

    # -- entries

    def _run(self, frame: Frame, unit: Unit, entry: int) -> Iterator[Block]:
        """A run of plain blocks, from the row on that a jump has led to."""
        x = self._x
        first, frame.row = frame.row, 0
        end = frame.sequence.end if frame.sequence is not None else None
        behind = end[1] + 1 if end is not None and end[0] == entry else unit.count(entry)
        target, frame.target_row = frame.target_row, -1
        if first <= target < behind:
            yield from self._rows_of(frame, unit, entry, first, target, behind)
            if x.frames[-1] is not frame:  # a modal cycle comes first
                frame.target_row = target
                return
            self._mark(unit, unit.line(entry) + target)
            yield from self._handed_over()
            first = target
        yield from self._rows_of(frame, unit, entry, first, behind, behind)

    def _rows_of(self, frame: Frame, unit: Unit, entry: int, first: int, behind: int, last: int) -> Iterator[Block]:
        """The rows `first` to before `behind` of a run that goes on to before `last`."""
        x = self._x
        for part in self._plain.run(unit, entry, x, first, behind):
            if isinstance(part, NeedsFull):
                self._execute(None, entry, x.compile(unit, unit.text_at(part.offset, part.line)))
                if x.frames[-1] is not frame:  # a modal cycle: the rest of the run comes behind it
                    frame.row = part.line - unit.line(entry) + 1
                    if frame.row < last:
                        frame.index = entry
                    else:
                        frame.row = 0
                    yield from self._handed_over()
                    return
                yield from self._handed_over()
            else:
                yield part

    def _execute(self, frame: Frame | None, entry: int, block: CompiledBlock) -> None:
        """One block by its compiled form; `frame` is None for a line of a plain run."""
        x = self._x
        x.block, x.entry = block, entry
        unit, shown = x.frames[-1].unit, x.frames[-1].shown
        try:
            if block.macros:
                for name, content in block.macros:
                    self._words.define_macro(name, content)
            if block.assigned and block.number < 0:
                block.values()
                if x.setup.single_step > 0:
                    x.source = Source(unit.name, block.source.line)
                    x.step_end(len(x.out))
                after_block(x, False)
                return
            values = block.values() if x.waiting is None else _values(x, block)
            if block.control is not None:
                if block.flush and not _reached_from_above(block):
                    additions.expect_no_line(x)
                if frame is not None:
                    self._flow.control(frame, entry, block, values)
                    if x.setup.single_step > 0:
                        x.source = Source(unit.name, block.source.line)
                        x.step_end(len(x.out))
                return
            number = -1
            if block.number >= 0:
                number = self._number(block, values[block.number])
            if block.simple and x.fast and self._words.simple(block, values, unit, number):
                return
            x.source = shown or Source(unit.name, block.source.line, None if number < 0 else number)
            if block.flush:
                additions.expect_no_line(x)
            since = len(x.out)
            self._words.execute(frame, entry, block, values)
            told = bool(block.words or block.statement or block.declarations or block.macros)  # else it is a comment
            if x.setup.single_step >= 0 and x.again is None and told:
                x.step_end(min(since, len(x.out)))
            if x.again is not None:
                additions.expect_no_line(x)
        except WaitForOutside as wait:
            x.repeat(str(wait))
        except LineError as error:
            raise self._error(unit, error.column, block, error.entry, error.values) from None
        except GeometryError as error:
            given = {**error.values, "letters": ", ".join(PLANES[x.modal.plane][1])}
            raise self._error(unit, block.column(WordKind.AXIS), block, error.entry, given) from None
        except CalculationError as error:
            column = block.text.upper().find(error.name.upper()) + 1
            raise self._error(unit, column or 1, block, error.entry, error.values) from None

    def _number(self, block: CompiledBlock, value: float) -> int:
        if not 0 <= value <= _NUMBER_LIMIT:
            column = max(1, block.text.upper().find("N") + 1)
            raise LineError(catalogue.RESULT_RANGE, column, value=value, name="N")
        number = self._x.block_number = round_half_up(value)
        return number

    def _error(
        self, unit: Unit, column: int, block: CompiledBlock, entry: ErrorEntry, values: dict[str, object]
    ) -> ProgramError:
        line, column, text = block.source.place(column)
        return ProgramError(entry, unit.place(line, column, text), **values)
