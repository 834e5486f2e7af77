"""Where a program level goes next: control statements and jumps (programming manual lines 8241–8949)."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.frames import Frame, Loop
from runtime.cnc.decoder.passed_over import check_passed
from runtime.cnc.language.errors import CalculationError, ProgramError
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock, Values
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.index import LOOPS, MIDDLE, Unit
from runtime.cnc.language.isg.words import Control, Word
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import Problem

TRUE_FROM = 0.5  # conditions: |value| from here on is true (programming manual line 8355)
CASE_EQUAL = 0.001  # $CASE: values that are nearer to each other are equal (line 8465)


class OutOfStepError(Exception):
    """The condition of a branch reads something of the interpolator, and the block at which it is asked for has not flushed."""


def true(value: float) -> bool:
    """Whether a condition holds."""
    return abs(value) >= TRUE_FROM


class Flow:
    """Control of one execution. All calls raise LineError or CalculationError at the block in work, ProgramError elsewhere."""

    def __init__(self, execution: Execution) -> None:
        self._x = execution
        self._passed: set[tuple[int, int]] = set()  # branches whose blocks were looked at
        self.in_step = False  # whether the preparation has flushed for the block in work

    # ------------------------------------------------------------------ control statements

    def control(self, frame: Frame, entry: int, block: CompiledBlock, values: Values) -> None:
        """A control statement: sets the index of the frame."""
        statement = block.control
        assert statement is not None
        control = statement.control
        if control is Control.IF and statement.goto is not None:
            if true(values[0]):
                self.jump(frame, entry, block, statement.goto, values)
            return
        link = frame.unit.link(entry)
        if control is Control.IF:
            self._choose(frame, entry, values)
        elif control in (Control.ELSEIF, Control.ELSE):
            frame.index = self._behind(frame, entry)  # reached from the branch before it
        elif control is Control.SWITCH:
            self._switch(frame, entry, values)
        elif control in (Control.WHILE, Control.DO, Control.REPEAT):
            if control is Control.WHILE and not true(values[0]):
                frame.loops.pop(entry, None)
                frame.index = self._behind(frame, entry)
                self._pass_over(frame, entry + 1, frame.index)
            else:
                frame.loops[entry] = Loop()
        elif control is Control.FOR:
            self._start_counting(frame, entry, block, values)
        elif control is Control.ENDWHILE:
            if link.first in frame.loops:  # not if the loop's first block was skipped
                frame.index = link.first
        elif control is Control.ENDFOR:
            if link.first in frame.loops:
                self._count(frame, link.first)
        elif control in (Control.ENDDO, Control.UNTIL):
            if link.first in frame.loops and true(values[0]) is (control is Control.ENDDO):
                frame.index = link.first + 1
            else:
                frame.loops.pop(link.first, None)
        elif control in (Control.CASE, Control.DEFAULT):  # reached from the branch before it
            self._x.warn(catalogue.CASE_OPEN, statement.column, statement=control.value)
            frame.index = self._behind(frame, entry)
        elif control in (Control.BREAK, Control.CONTINUE):
            self._leave(frame, control, link.outer, statement.column)

    def _behind(self, frame: Frame, entry: int) -> int:
        """The entry behind a structure; LineError if it is not closed."""
        last = frame.unit.last(entry)
        if last < 0:
            self._not_closed(frame, entry)
        return last + 1

    def _not_closed(self, frame: Frame, entry: int) -> None:
        unit = frame.unit
        fault = unit.faults.get(entry) or unit.faults.get(unit.link(entry).first)
        if fault is not None:
            raise ProgramError(fault.entry, unit.place(fault.line, fault.column, fault.text), **fault.values)
        raise LineError(catalogue.CONTROL_OPEN, 1, statement=unit.link(entry).control.value, end="its end")

    def _following(self, frame: Frame, entry: int) -> int:
        following = frame.unit.following(entry)
        if following < 0:
            self._not_closed(frame, entry)
        return following

    def _choose(self, frame: Frame, entry: int, values: Values) -> None:
        """Go to the first branch of an `$IF` whose condition is true, else behind its end."""
        unit = frame.unit
        while not true(values[0]):
            begin = entry
            entry = self._following(frame, entry)
            self._pass_over(frame, begin + 1, entry)
            if unit.link(entry).control is not Control.ELSEIF:
                break
            values = self.values_at(unit, entry)
        frame.index = entry + 1

    def _switch(self, frame: Frame, entry: int, values: Values) -> None:
        """`$SWITCH`: the first `$CASE` with an equal value, else `$DEFAULT`, else behind the end."""
        unit, default = frame.unit, -1
        while unit.link(entry).control is not Control.ENDSWITCH:
            following = self._following(frame, entry)
            self._pass_over(frame, entry + 1, following)
            entry = following
            control = unit.link(entry).control
            if control is Control.DEFAULT:
                default = entry
            elif control is Control.CASE and abs(self.values_at(unit, entry)[0] - values[0]) < CASE_EQUAL:
                frame.index = entry + 1
                return
        frame.index = (default if default >= 0 else entry) + 1

    def values_at(self, unit: Unit, entry: int) -> Values:
        """The values of another block of the unit; its errors carry its own place. OutOfStepError: flush, then once more."""
        block = self._x.compiled(unit, entry)
        if block.flush and not self.in_step:
            raise OutOfStepError
        self._x.entry = entry
        try:
            return block.values()
        except CalculationError as error:
            column = block.text.upper().find(error.name.upper()) + 1
            line, column, text = block.source.place(column or 1)
            raise ProgramError(error.entry, unit.place(line, column, text), **error.values) from None

    def _start_counting(self, frame: Frame, entry: int, block: CompiledBlock, values: Values) -> None:
        """`$FOR`: start, end and step are computed once."""
        start, end, step = values[:3]
        assert block.counter is not None
        block.counter.write(start)
        if step == 0:
            place = frame.unit.place(frame.unit.line(entry), block.control.column if block.control else 1, block.text)
            if not any(warning.place == place for warning in self._x.warnings):
                self._x.warnings.append(Problem(catalogue.STEP_ZERO, {}, place))
        if _beyond(start, end, step):
            frame.index = self._behind(frame, entry)
            self._pass_over(frame, entry + 1, frame.index)
        else:
            frame.loops[entry] = Loop(end, step)

    def _count(self, frame: Frame, first: int) -> None:
        """`$ENDFOR`: next pass, or leave the loop with the counter beyond the end."""
        loop, counter = frame.loops[first], self._x.compiled(frame.unit, first).counter
        assert counter is not None
        value = counter.read() + loop.step
        counter.write(value)
        if _beyond(value, loop.end, loop.step):
            del frame.loops[first]
        else:
            frame.index = first + 1

    def _leave(self, frame: Frame, control: Control, outer: tuple[int, ...], column: int) -> None:
        """`$BREAK` and `$CONTINUE`: the innermost loop (or `$SWITCH`) around."""
        links = frame.unit.links
        for first in reversed(outer):
            kind = links[first].control
            if kind in LOOPS:
                last = self._behind(frame, first) - 1
                if control is Control.BREAK:
                    frame.loops.pop(first, None)
                    frame.index = last + 1
                else:
                    frame.index = last
                return
            if kind is Control.SWITCH and control is Control.BREAK:
                frame.index = self._behind(frame, first)
                return
        where = "a loop or $SWITCH" if control is Control.BREAK else "a loop"
        raise LineError(catalogue.OUTSIDE_LOOP, column, statement=control.value, where=where)

    def _pass_over(self, frame: Frame, begin: int, end: int) -> None:
        """Look at block numbers and control statements of blocks that are passed over (lines 8241–8326)."""
        unit = frame.unit
        if (id(unit), begin) in self._passed:
            return
        self._passed.add((id(unit), begin))
        for entry in range(begin, end):
            if unit.count(entry):
                continue
            fault = unit.faults.get(entry)
            if fault is not None:
                raise ProgramError(fault.entry, unit.place(fault.line, fault.column, fault.text), **fault.values)
            text = unit.block_text(entry)
            try:
                check_passed(self._x, text.text)
            except LineError as error:
                line, column, source = text.place(error.column)
                raise ProgramError(error.entry, unit.place(line, column, source), **error.values) from None

    # ------------------------------------------------------------------ jumps

    def jump(self, frame: Frame, entry: int, block: CompiledBlock, goto: Word, values: Values) -> None:
        """`$GOTO`: to an expression label or a string label of the same program level."""
        unit, section = frame.unit, frame.section
        if goto.value is not None:
            value = values[block.goto_slot]
            if isinstance(value, str):
                label, target = f"[{value}]", unit.find_name(section, value.strip().upper())
            else:
                label, target = f"N{round_half_up(value)}", unit.find_number(section, round_half_up(value))
        else:
            label, target = f"[{goto.name}]", unit.find_name(section, goto.name)
        if target < 0:
            raise LineError(catalogue.LABEL_MISSING, goto.column, label=label)
        self.go_to(frame, entry, target, goto.column)

    def go_to(self, frame: Frame, entry: int, target: int, column: int) -> None:
        """Go on at `target`: loops that do not contain it end; a jump into the body of a loop is an error."""
        unit = frame.unit
        around = set(unit.around(target))
        within = set(unit.around(entry)) if entry >= 0 else set()
        for first in around - within:
            if unit.links[first].control in LOOPS:
                raise LineError(catalogue.JUMP_INTO_LOOP, column, line=unit.line(first))
        frame.loops = {first: loop for first, loop in frame.loops.items() if first in around}
        link = unit.links.get(target)
        # A jump to $ELSE or $CASE enters that branch, as if its condition were true (line 8566).
        frame.index = target + 1 if link is not None and link.control in MIDDLE else target
        frame.row = 0


def _beyond(value: float, end: float, step: float) -> bool:
    """Whether a counter has passed the end of its loop."""
    return value > end if step >= 0 else value < end
