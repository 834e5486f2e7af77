"""M, H, S and T of a block: which functions are put out, with which synchronisation, before or behind the motion."""

from __future__ import annotations

from runtime.cnc.blocks import StopKind, Technology
from runtime.cnc.decoder.block_functions import VALUE_LIMIT, Functions, extra_of, number_of, put_out, put_out_tool
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.modal import TAPPING
from runtime.cnc.decoder.spindle_commands import HOMING_G, argument_of_main, bracket_commands, enter_spindle_m
from runtime.cnc.decoder.spindles import FIRST_GEAR, SpindleWords, free_number
from runtime.cnc.decoder.threads import take_offset, take_speed
from runtime.cnc.decoder.turning import LIMIT_G
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock, FunctionSlots, Values
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.parser import GEAR_M, INTERNAL_M, POSITIONING_M, SPINDLE_M, TOOL_CHANGE_M
from runtime.cnc.language.isg.words import WordKind
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.catalogue import spindle

STOPS = {0: StopKind.PROGRAMMED, 1: StopKind.OPTIONAL}
PROGRAM_END = (2, 30)
SUBPROGRAM_END = (17, 29)


def functions_of(block: CompiledBlock, values: Values, x: Execution) -> Functions:
    """The functions of a block: T, spindles, M, H, whatever their order in the text, so that a tool change knows its
    tool.

    What is modal of spindles is entered. Raises LineError.
    """
    addresses = x.setup.addresses
    functions = Functions(x.source)
    if block.tool >= 0:
        _tool(x, functions, block, values)
    numbers = [number_of(slots, values, addresses) for slots in block.m]
    words = SpindleWords(block.column(WordKind.SPEED))
    gear = -1
    others: list[tuple[FunctionSlots, int]] = []
    for slots, number in zip(block.m, numbers, strict=True):
        if number in (*SPINDLE_M, POSITIONING_M) and not free_number(x, number):
            enter_spindle_m(words, number, slots.word.column, slots.extra >= 0)
        elif number in GEAR_M and x.setup.gear_change:
            gear, words.column = number - FIRST_GEAR, slots.word.column
        else:
            others.append((slots, number))
    _main_spindle(x, functions, block, values, words, gear)
    for slots, number in others:
        if number in STOPS:
            functions.stops.append(STOPS[number])
        elif number in PROGRAM_END or number in SUBPROGRAM_END:
            functions.ending = number
        if number == TOOL_CHANGE_M and x.levels.file_of("M6"):
            if slots.extra >= 0:
                raise LineError(catalogue.VALUE_NOT_ALLOWED, slots.word.column, number=number)
            functions.tool_change = True
            continue
        if number not in x.memory.m_synch and number not in INTERNAL_M:
            raise LineError(catalogue.M_UNDEFINED, slots.word.column, number=number)
        put_out(x, functions, Technology.M, number, extra_of(slots, values), slots.word.column)
    for slots in block.h:
        number = number_of(slots, values, addresses)
        put_out(x, functions, Technology.H, number, extra_of(slots, values), slots.word.column)
    for bracket in block.brackets:
        bracket_commands(x, functions, bracket, values)
    return functions


def _tool(x: Execution, functions: Functions, block: CompiledBlock, values: Values) -> None:
    tool = values[block.tool]
    if not 0 <= tool <= VALUE_LIMIT:
        raise LineError(catalogue.FUNCTION_NEGATIVE, block.column(WordKind.TOOL), value=tool, address="T")
    put_out_tool(x, functions, round_half_up(tool))


def _main_spindle(
    x: Execution, functions: Functions, block: CompiledBlock, values: Values, words: SpindleWords, gear: int
) -> None:
    """The words outside of brackets: they belong to the main spindle."""
    spindles = x.spindles
    for word in block.words:
        if word.kind in (WordKind.SPEED, WordKind.SPINDLE_POSITION) and word.name:
            spindles.expect_main(word.name, word.column)
    if block.speed >= 0:
        if any(slots.word.index == HOMING_G for slots in block.g):
            x.speed_argument = HOMING_G
        if x.modal.motion in TAPPING and not x.speed_argument:
            take_speed(x, values[block.speed], words.column)
        elif x.speed_argument == LIMIT_G:
            x.turning.take_limit(x, values[block.speed], words.column)
        elif x.turning.cutting and not x.speed_argument:
            words.speed = x.turning.take_velocity(x, values[block.speed], words.column)
        elif x.speed_argument:
            argument_of_main(x, words, values[block.speed])
        else:
            words.speed = values[block.speed]
    if block.spindle_offset >= 0:
        take_offset(x, block)
    if block.spindle_position >= 0:
        words.angle = values[block.spindle_position]
    if x.modal.motion in TAPPING and (words.command >= 0 or words.position):
        told = f"M{POSITIONING_M if words.position else words.command}"
        raise LineError(
            spindle.TAPPING_SPINDLE, words.column, word=told, name=x.setup.spindles[spindles.main].name,
            motion=f"G{int(x.modal.motion)}",
        )  # fmt: skip
    if x.setup.gear_change and (gear >= 0 or words.any):
        stage = spindles.select_gear(x, gear, words)
        if stage >= 0:
            spindles.change_gear(x, stage)
            put_out(x, functions, Technology.M, FIRST_GEAR + stage, 0.0, words.column)
    if words.any:
        spindles.order(x, functions, spindles.main, words)
