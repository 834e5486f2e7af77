"""Program levels: calls, returns, the configured programs at start and end (programming manual lines 7036–7296, 6636–6721)."""

from __future__ import annotations

from pathlib import Path

from runtime.cnc.blocks import Block, BlockEnd, Source, Stop, StopKind
from runtime.cnc.decoder.dynamics import after_cycle, set_dynamics
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.frames import Frame, Level
from runtime.cnc.decoder.library import Library, wrong_name
from runtime.cnc.decoder.modal import ModalState
from runtime.cnc.decoder.selection import restore_modal
from runtime.cnc.language.errors import ProgramError
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.index import Section, Unit
from runtime.cnc.language.isg.words import Word, WordKind
from runtime.diagnostics.catalogue import language as catalogue


class Levels:
    """Enters and leaves the program levels of one execution.

    All calls raise LineError at the block in work; a file that is missing or faulty is a ProgramError.
    """

    def __init__(self, execution: Execution) -> None:
        self._x = execution
        self.entered = False  # a level was entered since somebody set this to False
        self._last: list[Block] = []  # what M30 puts out behind the final program
        execution.levels = self

    # ------------------------------------------------------------------ start and end of the program

    def begin(self) -> None:
        """The configured program that every program start begins with (P-CHAN-00119)."""
        if self._x.setup.start_program:
            self._configured(self._x.setup.start_program, Level.START)

    def _configured(self, name: str, level: Level) -> None:
        """Enter a program that the configuration names: no block is there that its errors could belong to."""
        x = self._x
        try:
            unit, section = self.program(x.frame, False, name, 1)
            self.enter(unit, section, name, 1, level)
        except LineError as error:
            raise ProgramError(error.entry, x.unit.place(x.source.line), **error.values) from None

    def finish(self, last: list[Block]) -> None:
        """M02, M30 or the end of the text: the configured last program (P-CHAN-00252), then `last`, then the end."""
        x = self._x
        for frame in x.frames:
            _expect_no_section(frame)
        x.sections.close(x)
        name = x.setup.final_program
        if not name or any(frame.level is Level.FINAL for frame in x.frames):
            self._end(last or self._last)
            return
        self._last = last
        while len(x.frames) > 1:
            self._pop()
        self._configured(name, Level.FINAL)

    def _end(self, last: list[Block]) -> None:
        x = self._x
        for block in last:
            x.emit(block)
        x.frames.clear()
        x.memory.came_to_end = True
        x.emit(Stop(x.source, StopKind.PROGRAM_END))

    # ------------------------------------------------------------------ calls

    def call(self, word: Word, name: str) -> None:
        """LL or L: a new level. `name` is the text of the word, or what the variable in it gave."""
        unit, section = self.program(self._x.frame, word.kind is WordKind.CALL_LOCAL, name, word.column)
        self.enter(unit, section, name, word.column)

    def file_of(self, function: str) -> str:
        """The program that M6, D or a G number calls: of #FILE NAME, else configured; "" for none."""
        named = self._x.file_names.get(function)
        if named is not None:
            return named
        setup = self._x.setup
        if function.startswith("G"):
            return setup.g_programs.get(int(function[1:]), "")
        return {"M6": setup.tool_change_program, "D": setup.tool_data_program}.get(function, "")

    def call_file(self, function: str, column: int, hidden: bool = False) -> None:
        """The program of M6, D or a G function, as a subprogram; `hidden`: its blocks are not shown (P-CHAN-00211)."""
        name = self.file_of(function)
        unit, section = self.program(self._x.frame, False, name, column)
        self.enter(unit, section, name, column, hidden=hidden)

    def program(self, frame: Frame, local: bool, name: str, column: int) -> tuple[Unit, Section]:
        """Unit and section of a subprogram."""
        wrong = wrong_name(name)
        if wrong is not None:
            raise LineError(wrong[0], column, **wrong[1])
        if local:
            section = frame.unit.local_programs.get(name)
            if section is None:
                raise LineError(catalogue.LOCAL_MISSING, column, name=name)
            return frame.unit, section
        line, at, text = self._x.place(column)
        unit = self._x.library.global_program(name, frame.unit.place(line, at, text))
        assert unit.main is not None
        return unit, unit.main

    def enter(
        self,
        unit: Unit,
        section: Section,
        name: str,
        column: int,
        level: Level = Level.SUBPROGRAM,
        hidden: bool = False,
    ) -> Frame:
        """A new level at the start of a section; LineError if there are too many."""
        x = self._x
        if len(x.frames) >= x.setup.limits.levels:
            raise LineError(catalogue.CALL_DEPTH, column, limit=x.setup.limits.levels, name=name)
        shown = x.frames[-1].shown
        if shown is None and hidden and x.setup.hide_cycles:
            x.flush_run()
            shown = x.source
        frame = Frame(unit, section, section.begin, level, name=name, shown=shown)
        x.frames.append(frame)
        self.entered = True
        return frame

    def enter_cycle(
        self, unit: Unit, section: Section, name: str, column: int, transfer: dict[int, float | str]
    ) -> Frame:
        """A level with transfer parameters of its own, behind which the modal state is as before (lines 7389–7426)."""
        x = self._x
        saved = x.modal.copy()
        frame = self.enter(unit, section, name, column, Level.CYCLE, hidden=True)
        frame.transfer = dict(transfer)
        frame.given = frozenset(transfer)
        frame.saved = saved
        frame.dynamics = x.dynamics
        return frame

    # ------------------------------------------------------------------ returns

    def leave(self) -> None:
        """The current level ends, and what it had of its own with it; behind the last program comes the end."""
        _expect_no_section(self._x.frames[-1])
        frame = self._pop()
        if frame.level is Level.FINAL:
            self._end(self._last)

    def _pop(self) -> Frame:
        x = self._x
        shown = x.frames[-1].shown
        if shown is not None and x.frames[-2].shown is None:
            x.flush_run()
            x.emit(BlockEnd(shown))  # the whole call is one step
        frame = x.frames.pop()
        x.declaring = False
        if frame.saved is not None and not frame.retain and not x.keep_cycle_changes:
            restore(x, frame.saved)
            if frame.dynamics is not None:
                set_dynamics(x, after_cycle(frame.dynamics, x.dynamics))
        return frame

    def end_of_section(self) -> None:
        """The last block of a program without M17 or M30: back to the caller, or the end of the program."""
        x = self._x
        frame = x.frames[-1]
        unit, end = frame.unit, frame.section.end
        line = unit.line(end - 1) if end > frame.section.begin else frame.section.line
        if frame.sequence is not None:
            raise ProgramError(catalogue.SEQUENCE_OPEN, unit.place(line), program=frame.name or unit.name)
        try:
            if len(x.frames) > 1:
                self.leave()
                return
            x.source = Source(unit.name, line)
            self.finish([])
        except LineError as error:
            raise ProgramError(error.entry, unit.place(line), **error.values) from None


def _expect_no_section(frame: Frame) -> None:
    """LineError if the level ends within #OPTIONAL EXECUTION (programming manual line 16819)."""
    if frame.optional is not None:
        raise LineError(catalogue.SECTION_OPEN, 1)


def restore(x: Execution, saved: ModalState) -> None:
    """The modal state as it was before a cycle; the spindle speed stays."""
    saved.speed = x.modal.speed
    restore_modal(x, saved)


def path_number(library: Library, unit: Unit) -> int:
    """Number of the search path that a file was found in, from 1 on; 0 if it lies in none of them."""
    folder = Path(unit.text.path).parent.resolve()
    return next((i for i, known in enumerate(library.folders, 1) if known.resolve() == folder), 0)
