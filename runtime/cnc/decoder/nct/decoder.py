"""Executes an NCT program: block by block as the file has them → blocks of motion, functions and actions.

A frame per program level, which stands at an offset of its file; jumps and calls set the offset.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress

from runtime.cnc.blocks import Block, Floats, Flush, FlushKind, Hold, SearchMark, Source
from runtime.cnc.decoder.corners import Corners
from runtime.cnc.decoder.decoder import HANDED_OVER, POLL
from runtime.cnc.decoder.geometry_error import GeometryError
from runtime.cnc.decoder.memory import ChannelMemory
from runtime.cnc.decoder.modal import ModalState
from runtime.cnc.decoder.motion import PLANES
from runtime.cnc.decoder.nct import codes  # noqa: F401 - registers the dialect
from runtime.cnc.decoder.nct.block import WordBlocks
from runtime.cnc.decoder.nct.corners import with_corners
from runtime.cnc.decoder.nct.execution import NctExecution, OutOfStepError
from runtime.cnc.decoder.nct.flow import SearchInterrupted
from runtime.cnc.decoder.nct.frames import Frame
from runtime.cnc.decoder.nct.g_skip import end_of_skip
from runtime.cnc.decoder.nct.levels import Levels
from runtime.cnc.decoder.nct.program import NctProgram
from runtime.cnc.decoder.nct.search import TargetFinder
from runtime.cnc.decoder.nct.start import begin_program
from runtime.cnc.decoder.outside import Offline, Outside, WaitForOutside
from runtime.cnc.decoder.radius_compensation import expect_none
from runtime.cnc.decoder.setup import DecoderSetup
from runtime.cnc.language.errors import CalculationError, LineError, ProgramError
from runtime.cnc.language.motion_words import WordKind
from runtime.cnc.language.nct.compiler import CompiledBlock
from runtime.cnc.search_target import BlockSearch
from runtime.cnc.tools.offset_table import OffsetTableError
from runtime.diagnostics.catalogue import language
from runtime.diagnostics.errors import ErrorEntry, Place, Problem


class NctDecoder:
    """Executes one program once, as `runtime.cnc.decoder.Decoder` does for the other dialect; the arguments are the same."""

    def __init__(
        self,
        program: NctProgram,
        setup: DecoderSetup,
        *,
        start: Floats,
        memory: ChannelMemory | None = None,
        outside: Outside | None = None,
        skip_levels: Callable[[], int] = lambda: 0,
        interrupted: Callable[[], bool] = lambda: False,
        idle_limit: int | None = None,
        search: BlockSearch | None = None,
    ) -> None:
        self.executed = 0  # blocks so far
        x = NctExecution(
            setup, memory or ChannelMemory(setup), outside or Offline(), program.library, start, skip_levels
        )
        self.execution = self._x = x
        self._levels = Levels(x)
        self._words = WordBlocks(x)
        self._interrupted = x.flow.interrupted = interrupted
        self._idle_limit = idle_limit
        self._idle = 0
        self._in_order = not setup.nct.sbstm  # macro blocks wait for the motion before them
        self._ahead = False  # something was handed over since the path was where the decoder is
        section = program.unit.main
        x.stack.append(Frame(program.unit, section, section.begin, section.line))
        x.source = Source(program.unit.name, section.line)
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
        """P parameters: the dialect has none."""
        return {}

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
        return with_corners(self._blocks(), corners)

    def _blocks(self) -> Iterator[Block]:
        x = self._x
        repeating = False  # the block is executed once more: nothing came between, the interpolator is where it was
        try:
            begin_program(x)
            while x.stack:
                frame = x.stack[-1]
                offset, line, before = frame.offset, frame.line, frame.work
                text = frame.unit.block(offset, line)
                if text is None:
                    self._levels.end_of_text()
                    yield from self._handed_over()
                    continue
                self.executed += 1
                self._idle += 1
                if self.executed % HANDED_OVER == 0:
                    yield from self._handed_over()
                    if self.executed % POLL == 0:
                        self._keep()
                        if self._interrupted():
                            return
                if self._idle_limit is not None and self._idle > self._idle_limit:
                    raise ProgramError(language.ENDLESS_LOOP, frame.unit.place(line), count=self._idle_limit)
                search = self._search
                if search is not None and search.pending and not repeating and search.reached(frame, text):
                    x.flush_run()
                    x.out.append(SearchMark(Source(frame.unit.name, line)))
                frame.work, frame.offset, frame.line = text, text.following, line + 1
                block = x.compiled_block(frame.unit, text)
                if block.empty or (block.skip and x.skip_levels() >> (block.skip - 1) & 1):
                    if block.number >= 0:
                        x.sequence_number = block.number
                    continue
                x.in_step = repeating
                if self._ahead and self._in_order and not repeating and x.macros.is_macro(block):
                    yield from self._flushed(Source(frame.unit.name, line))
                    x.in_step = True
                try:
                    self._execute(frame, block)
                except OutOfStepError:
                    self._expect_no_compensation(frame, block)
                    yield from self._flushed(Source(frame.unit.name, line))
                    x.in_step = True
                    self._execute(frame, block)
                repeating = x.again is not None
                if x.again is not None:
                    yield from self._handed_over()
                    frame.work, frame.offset, frame.line = before, offset, line
                    reason, x.again = x.again, None
                    yield Hold(x.source, reason)
                    if self._interrupted():
                        return
                    continue
                x.assigned = 0
                if x.measuring.pending is not None:
                    yield from self._handed_over()
                    end_of_skip(x)
                if x.out:
                    yield from self._handed_over()
            self._keep()
        except SearchInterrupted:
            return
        except ProgramError:
            yield from self._handed_over()
            raise
        finally:
            with suppress(OffsetTableError):  # the program is over, told or aborted
                x.memory.keep_variables()
        yield from self._handed_over()

    def _handed_over(self) -> Iterator[Block]:
        """Everything that was emitted."""
        x = self._x
        x.flush_run()
        if x.out:
            out, x.out = x.out, []
            self._idle = 0
            self._ahead = True
            yield from out

    def _flushed(self, source: Source) -> Iterator[Block]:
        """The path comes to the block in work."""
        yield from self._handed_over()
        self._ahead = False
        self._keep()
        yield Flush(source, FlushKind.WAIT)

    def _keep(self) -> None:
        """Common variables that have changed outlive the machine from now on."""
        try:
            self._x.memory.keep_variables()
        except OffsetTableError as error:
            unit = self._x.stack[-1].unit if self._x.stack else None
            place = Place() if unit is None else unit.place(self._x.source.line)
            raise ProgramError(error.problem.entry, place, **error.problem.values) from None

    def _execute(self, frame: Frame, block: CompiledBlock) -> None:
        """One block by its compiled form."""
        x = self._x
        x.work = block
        number = None if block.number < 0 else block.number
        if x.again is None and not x.in_step:
            x.number_before = x.sequence_number
        if number is not None:
            x.sequence_number = number
        try:
            if block.simple and x.fast and self._words.simple(frame, block):
                return
            x.source = frame.shown or Source(frame.unit.name, block.source.line, number)
            since = len(x.out)
            if block.control is not None and not x.flow.execute(block):
                return
            for assign in block.assigns[x.assigned :]:
                assign()
                x.assigned += 1
            if block.words:
                self._words.execute(block, block.values())
            if x.setup.single_step >= 0 and x.again is None:
                x.step_end(min(since, len(x.out)))
        except WaitForOutside as wait:
            x.repeat(str(wait))
        except LineError as error:
            raise self._error(frame, error.column, block, error.entry, error.values) from None
        except GeometryError as error:
            given = {**error.values, "letters": ", ".join(PLANES[x.modal.plane][1])}
            raise self._error(frame, x.words.column(WordKind.AXIS), block, error.entry, given) from None
        except CalculationError as error:
            column = block.source.text.upper().find(error.name.upper()) + 1
            raise self._error(frame, column or 1, block, error.entry, error.values) from None

    def _expect_no_compensation(self, frame: Frame, block: CompiledBlock) -> None:
        """No block that reads something of the cycle may stand between compensated ones."""
        try:
            expect_none(self._x, "reading a value of the cycle", 1)
        except LineError as error:
            raise self._error(frame, error.column, block, error.entry, error.values) from None

    def _error(
        self, frame: Frame, column: int, block: CompiledBlock, entry: ErrorEntry, values: dict[str, object]
    ) -> ProgramError:
        line, column, text = block.source.place(column)
        return ProgramError(entry, frame.unit.place(line, column, text), **values)
