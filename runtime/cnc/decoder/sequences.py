"""L SEQUENCE: a part of a program, executed once or several times as a level of its own (programming manual 7602–8053)."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.frames import Level, Sequence
from runtime.cnc.decoder.isg.registry import StatementCall
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.index import Section, Unit
from runtime.diagnostics.catalogue import language as catalogue

Position = tuple[int, int]  # entry, and row in a plain run


def call_sequence(x: Execution, call: StatementCall) -> None:
    """Enter the sequence; inside of it the same call is passed over, or ends the pass with ENDTAG. Raises LineError."""
    own = (x.unit.text, x.unit.offset(x.frame.index - 1))
    for frame in reversed(x.frames):
        if frame.sequence is not None and frame.sequence.call == own:
            if frame is x.frame and frame.sequence.end_at_call:
                next_pass(x)
            return
    repeat = round_half_up(call.number("REPEAT", 1.0) or 0.0)
    if repeat < 1:
        raise call.error(catalogue.SEQUENCE_REPEAT, "REPEAT", value=repeat)
    unit, section, name = _program(x, call)
    at_mark, at_call = call.given("BEGIN"), call.given("ENDTAG")
    marks = _marks(unit, section, call, name)
    begin = marks[0]
    end: Position | None = marks[-1]
    if at_mark or (at_call and len(marks) == 1):
        end = None
    frame = x.levels.enter(unit, section, name, call.column, Level.SEQUENCE)
    frame.index, frame.row = begin
    frame.sequence = Sequence(begin, end, repeat, own, at_call, at_mark)


def next_pass(x: Execution) -> None:
    """The end of a pass is reached: begin anew, or return."""
    frame = x.frame
    sequence = frame.sequence
    assert sequence is not None
    sequence.repeat -= 1
    if sequence.repeat > 0:
        frame.loops.clear()
        frame.index, frame.row = sequence.begin
    else:
        x.levels.leave()


def end_mark(x: Execution) -> None:
    """#SEQUENCE END: ends the pass of a sequence that was called with BEGIN, and does nothing otherwise."""
    if x.frame.sequence is not None and x.frame.sequence.end_at_mark:
        next_pass(x)
        x.levels.entered = True  # a return is no block that a modal cycle follows


def _program(x: Execution, call: StatementCall) -> tuple[Unit, Section, str]:
    """Where the sequence is looked for: the current program, or a file; from its start, whatever was forgotten of it."""
    unit, section = x.unit, x.frame.section
    name = call.text("NAME") or ""
    if name and name not in (unit.name, unit.text.path.name, section.name):
        unit, section = x.levels.program(x.frame, False, name, call.columns("NAME"))
    if not unit.complete:
        unit = x.library.anew(unit)
        assert unit.main is not None
        section = unit.main
    return unit, section, name or section.name or unit.name


def _marks(unit: Unit, section: Section, call: StatementCall, name: str) -> list[Position]:
    """Positions of the first block and, if it is given, of the last one."""
    numbers = sorted(round_half_up(value) for argument, value in call if argument.name == "N")
    labels = [argument.text for argument, _ in call if argument.name == "LABEL"]
    count = len(numbers) + len(labels)
    if bool(numbers) == bool(labels) or count > 2 or (count == 2 and call.given("BEGIN")):
        raise call.error(catalogue.SEQUENCE_LIMITS)
    if labels:
        found = [(f"[{label}]", unit.find_name(section, label)) for label in labels]
        marks = [(what, (entry, 0) if entry >= 0 else None) for what, entry in found]
    else:
        marks = [(f"N{number}", unit.numbered((section.begin, 0), section, number)) for number in numbers]
    positions: list[Position] = []
    for what, position in marks:
        if position is None:
            raise call.error(catalogue.SEQUENCE_MISSING, what=what, program=name)
        positions.append(position)
    if positions[-1] < positions[0]:
        raise call.error(catalogue.SEQUENCE_ORDER, first=marks[0][0], last=marks[-1][0])
    return positions
