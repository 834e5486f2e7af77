"""Program levels: subprograms by M98, returns and jumps by M99, the end of the program (manual lines 2951–3170)."""

from __future__ import annotations

from runtime.cnc.blocks import Block, Source, Stop, StopKind
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.frames import Frame, Level
from runtime.cnc.language.errors import LineError, ProgramError
from runtime.cnc.language.nct.program_file import Section, Unit
from runtime.diagnostics.catalogue import nct as catalogue

MOST_SUBPROGRAMS = 4  # nested (line 3024)


class Levels:
    """Enters and leaves the program levels of one execution. All calls raise LineError at the block in work."""

    def __init__(self, execution: NctExecution) -> None:
        self._x = execution
        execution.levels = self

    def find(self, number: int, column: int) -> tuple[Unit, Section]:
        """The program of a number."""
        x = self._x
        found = x.programs.find(number, x.level.unit)
        if found is None:
            raise LineError(catalogue.NO_PROGRAM, column, number=number, folders=x.programs.folders)
        return found

    def enter(self, number: int, column: int, passes: int = 1, level: Level = Level.SUBPROGRAM) -> Frame:
        """A new level at the beginning of a program, which runs `passes` times (1 or more)."""
        x = self._x
        subprograms = sum(frame.level is Level.SUBPROGRAM for frame in x.stack)
        if level is Level.SUBPROGRAM and subprograms >= MOST_SUBPROGRAMS:
            raise LineError(catalogue.LEVEL_EXCESS, column, limit=MOST_SUBPROGRAMS)
        unit, section = self.find(number, column)
        caller = x.level
        frame = Frame(unit, section, section.begin, section.line, level, passes)
        frame.locals, frame.modal_calls = caller.locals, caller.modal_calls
        x.stack.append(frame)
        return frame

    def leave(self, block_number: int | None = None, passes: int | None = None, column: int = 1) -> None:
        """The program of the level has come to its end (M99): once more, or back behind the call, or to a block of the caller.

        `passes`: how often it runs in all from now on.
        """
        x = self._x
        frame = x.level
        if passes is not None:
            frame.passes = passes
        frame.done += 1
        if frame.done < frame.passes:
            frame.begin()
            if frame.arguments is not None:
                frame.locals = list(frame.arguments)
            return
        if block_number is None:
            x.stack.pop()
            return
        self.jump(x.stack[-2], block_number, column)
        x.stack.pop()

    def jump(self, frame: Frame, number: int, column: int) -> None:
        """The level goes on at the block with a number: looked for behind the block in work first, then from the start."""
        assert frame.work is not None
        self._x.flow.go_to(frame, frame.work, number, column)

    def restart(self) -> None:
        """M99 in the main program: its first block comes next."""
        self._x.level.begin()

    def finish(self, last: list[Block]) -> None:
        """M02, M30 or the end of the main program: `last` is put out, then nothing comes."""
        x = self._x
        for block in last:
            x.emit(block)
        x.stack.clear()
        x.memory.came_to_end = True
        x.emit(Stop(x.source, StopKind.PROGRAM_END))

    def end_of_text(self) -> None:
        """The last block of a program without M99 or M30: back to the caller, or the end."""
        x = self._x
        frame = x.level
        line = frame.work.line if frame.work is not None else frame.section.line
        if frame.work is None and frame.level is Level.MAIN:
            raise ProgramError(catalogue.PROGRAM_MISSING, frame.unit.place(0), file=frame.unit.text.name)
        x.source = Source(frame.unit.name, line)
        try:
            if frame.level is Level.MAIN:
                self.finish([])
            else:
                self.leave()
        except LineError as error:
            raise ProgramError(error.entry, frame.unit.place(line), **error.values) from None
