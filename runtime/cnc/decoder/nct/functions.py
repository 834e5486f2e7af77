"""The functions of a block: M, S and T in the order of the control, with their synchronisation (manual lines 2762–2927).

M06 ─ T ─ M11…M18 ─ S ─ M03 M04 M05 M19 ─ M07 M08 M09 ─ other M ─ A B C ─ program control
"""

from __future__ import annotations

from runtime.cnc.blocks import Block, Technology
from runtime.cnc.decoder.block_functions import Functions, put_out, put_out_tool
from runtime.cnc.decoder.nct.auxiliary import put_out_auxiliary
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.surface_speed import TURNING
from runtime.cnc.decoder.nct.words import BlockWords
from runtime.cnc.decoder.spindles import SpindleWords
from runtime.cnc.language.errors import LineError
from runtime.cnc.language.motion_words import WordKind
from runtime.diagnostics.catalogue import language
from runtime.diagnostics.catalogue import nct as catalogue

CHANGE = 1e-4  # share by which a speed has to change to be ordered anew
MOST_M = 5  # in a block (line 2846)
TOOL_CHANGE, ORIENTATION = 6, 19
GEARS = range(11, 19)
SPINDLE = (3, 4, 5)
COOLANT = (7, 8, 9)
PROGRAM_CONTROL = (0, 1, 2, 30, 96, 97, 98, 99)
ENDS = (2, 30)


def group_of(number: int) -> int:
    """The group of an M code, 1 to 7: groups are executed in this order, and only one code of each stands in a block."""
    if number == TOOL_CHANGE:
        return 1
    if number in GEARS:
        return 2
    if number in (*SPINDLE, ORIENTATION):
        return 3
    if number in COOLANT:
        return 4
    return 7 if number in PROGRAM_CONTROL else 5


def m_numbers(words: BlockWords) -> list[tuple[int, int]]:
    """M codes of a block with their columns, in the order in which they are executed. LineError for conflicting ones."""
    found = [(round(value), word.column) for word, value in words.all if word.address == "M" and value is not None]
    groups: dict[int, int] = {}
    for number, column in found:
        group = group_of(number)
        if group in groups:
            raise LineError(catalogue.CONFLICTING_M, column, number=number, other=groups[group])
        groups[group] = number
    if len(found) > MOST_M:
        raise LineError(catalogue.TOO_MANY_M, found[MOST_M][1], most=MOST_M)
    return sorted(found, key=lambda m: group_of(m[0]))


def functions_of(x: NctExecution, words: BlockWords, numbers: list[tuple[int, int]]) -> Functions:
    """What is put out before and behind the motion of the block; what is modal of the spindle is entered. Raises LineError.

    The M code that ends the program is not among them: it is put out when everything else is done.
    """
    functions = Functions(x.source)
    spindle = SpindleWords(words.place("S"))
    speed = words.number("S")
    if speed is not None and not x.speed_taken:
        if x.surface.on:
            x.surface.take_velocity(x, speed)
            spindle.speed = x.surface.speed(x) if x.surface.acts(x) else None
        else:
            spindle.speed = speed
    for number, column in numbers:
        if number in SPINDLE or number == ORIENTATION:
            if not x.spindles.programmed:
                raise LineError(language.SPINDLE_MISSING, column, word=f"M{number}")
            spindle.column = column
            if number == ORIENTATION:
                spindle.position, spindle.angle = True, 0.0
            else:
                spindle.command = number
                if number in TURNING and x.surface.on and x.surface.settings.velocity:
                    spindle.speed = x.surface.speed(x)
    for group in range(1, 7):
        if group == 2:
            _tool(x, functions, words)
        if group == 3 and spindle.any:
            if not x.spindles.programmed:
                raise LineError(language.SPINDLE_MISSING, words.place("S"), word="S")
            x.spindles.order(x, functions, x.spindles.main, spindle)
        for number, column in numbers:
            if group_of(number) == group and group != 3:
                _miscellaneous(x, functions, number, column)
    put_out_auxiliary(x, functions)
    for number, column in numbers:
        if number in PROGRAM_CONTROL and number not in ENDS and number in x.memory.m_synch:
            put_out(x, functions, Technology.M, number, 0.0, column)
    return functions


def speed_of_end(x: NctExecution) -> list[Block]:
    """What is put out in front of a rapid motion that was decoded: with G96 the speed that belongs to its end."""
    state = x.spindles.main_programmed
    speed = x.surface.speed(x)
    if abs(speed - state.speed) <= CHANGE * state.speed:
        return []
    functions = Functions(x.source)
    x.spindles.order(x, functions, x.spindles.main, SpindleWords(x.words.column(WordKind.AXIS), speed=speed))
    return [*functions.leading(), *functions.trailing()]


def _tool(x: NctExecution, functions: Functions, words: BlockWords) -> None:
    tool = words.number("T")
    if tool is not None:
        put_out_tool(x, functions, round(tool))


def _miscellaneous(x: NctExecution, functions: Functions, number: int, column: int) -> None:
    if number not in x.memory.m_synch:
        if number == TOOL_CHANGE:
            return  # the machine changes at T
        raise LineError(language.M_UNDEFINED, column, number=number)
    put_out(x, functions, Technology.M, number, 0.0, column)
