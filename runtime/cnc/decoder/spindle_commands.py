"""What stands in the bracket of a spindle or an axis, and the G functions whose argument the S word is.

    S[M3 REV500 M19 POS45 M18 H20]   S[G74]   S[G167 REV1000]   S[G130=70]   S[G135 G136=90]   S[OVERRIDE SPEED_FACT=20]
    X[M20 H12=7]                     G74 S1   G167 S1000        G112 S2

M and H functions in a bracket are put out on the interface of the spindle or axis, whatever is configured for their numbers.
"""

from __future__ import annotations

from runtime.cnc.blocks import SpindleValue, Technology
from runtime.cnc.decoder.block_functions import Functions, extra_of, number_of, put_out
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.spindles import STOPPED, TURNING, SpindleWords, free_number
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import BracketSlots, FunctionSlots, Values
from runtime.cnc.language.isg.parser import GEAR_M, POSITIONING_M, SPINDLE_M
from runtime.cnc.language.isg.words import WordKind
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.catalogue import technology as errors

HOMING_G, OVERRIDE_G, GEAR_G = 74, 167, 112
ACCELERATION_G, FEED_FORWARD_ON, FEED_FORWARD_WEIGHT, FEED_FORWARD_OFF = 130, 135, 136, 137
_UNSUPPORTED = (
    "CALLAX", "PUTAX", "GET_DYNAMIK_DATA", "GET_DYNAMIC_DATA", "DEFAULT_DYNAMIC_DATA", "DEFAULT_DYNAMIK_DATA", "FEED_LINK",
)  # fmt: skip


def bracket_commands(x: Execution, functions: Functions, bracket: BracketSlots, values: Values) -> None:
    """Everything in one bracket. Raises LineError."""
    word = bracket.word
    if word.index >= 0:
        area = x.setup.areas.get(x.setup.axes[word.index], -1)
        for slots in bracket.commands:
            _technology(x, functions, slots, values, area)
        return
    index = x.spindles.index_of(word.name, word.column)
    words = SpindleWords(word.column, word="REV")
    settings = [slots for slots in bracket.commands if not _word_of(x, words, slots, values)]
    if settings:
        _settings(x, index, bracket, settings, values, words)
    setup = x.setup.spindles[index]
    for slots in bracket.commands:
        if slots.word.kind in (WordKind.M, WordKind.H) and not _is_spindle_m(x, slots, values):
            if setup.plc:
                raise LineError(errors.PLC_SPINDLE, slots.word.column, name=setup.name)
            _technology(x, functions, slots, values, setup.area)
    if words.override_off and setup.plc:
        raise LineError(errors.PLC_SPINDLE, words.column, name=setup.name)
    if words.any:
        x.spindles.order(x, functions, index, words)


def _technology(x: Execution, functions: Functions, slots: FunctionSlots, values: Values, area: int) -> None:
    kind = Technology.M if slots.word.kind is WordKind.M else Technology.H
    number = number_of(slots, values, x.setup.addresses)
    if kind is Technology.M and (number not in x.memory.m_synch or _is_spindle_m(x, slots, values)):
        raise LineError(catalogue.M_UNDEFINED, slots.word.column, number=number)
    put_out(x, functions, kind, number, extra_of(slots, values), slots.word.column, area)


def _is_spindle_m(x: Execution, slots: FunctionSlots, values: Values) -> bool:
    if slots.word.kind is not WordKind.M:
        return False
    number = number_of(slots, values, x.setup.addresses)
    return number in (*SPINDLE_M, POSITIONING_M) and not free_number(x, number)


def _word_of(x: Execution, words: SpindleWords, slots: FunctionSlots, values: Values) -> bool:
    """Enter a command into the words of the spindle; FALSE if it is a setting."""
    word = slots.word
    if word.kind is WordKind.H:
        return True
    if word.kind is WordKind.M:
        number = number_of(slots, values, x.setup.addresses)
        if number in GEAR_M and x.setup.gear_change:
            raise LineError(errors.BRACKET_UNSUPPORTED, word.column, word=f"M{number} in the bracket")
        if _is_spindle_m(x, slots, values):
            enter_spindle_m(words, number, word.column, slots.extra >= 0)
        return True
    if word.kind is WordKind.G and word.index == OVERRIDE_G:
        words.override_off = True
        return True
    if word.name in ("REV", "POS"):
        if slots.number < 0:
            raise LineError(errors.BRACKET_VALUE_MISSING, word.column, word=word.name)
        if word.name == "REV":
            words.speed = values[slots.number]
        else:
            words.angle = values[slots.number]
        return True
    return False


def enter_spindle_m(words: SpindleWords, number: int, column: int, extra: bool) -> None:
    """M3, M4, M5 or M19 among the words of a spindle."""
    if extra:
        raise LineError(catalogue.VALUE_NOT_ALLOWED, column, number=number)
    words.column = column
    if number == POSITIONING_M:
        words.position = True
    elif words.command >= 0:
        raise LineError(catalogue.SPINDLE_M_TWICE, column, number=number, other=words.command)
    else:
        words.command = number


def _settings(
    x: Execution,
    index: int,
    bracket: BracketSlots,
    settings: list[FunctionSlots],
    values: Values,
    words: SpindleWords,
) -> None:
    """Homing, override, acceleration, feed-forward: each of them alone in its bracket, but for a value that belongs to it."""
    first = settings[0].word
    name = first.name or f"G{first.index}"
    if name in _UNSUPPORTED:
        raise LineError(errors.BRACKET_UNSUPPORTED, first.column, word=name)
    if first.kind is WordKind.G and first.index == HOMING_G and words.any:
        raise LineError(errors.HOMING_WITH_M, first.column)
    if len(settings) != len(bracket.commands):
        raise LineError(errors.BRACKET_ALONE, first.column, word=name)
    if first.kind is WordKind.KEY:
        if name != "OVERRIDE" or len(settings) != 2 or settings[1].word.name != "SPEED_FACT":
            raise LineError(errors.BRACKET_COMMAND, first.column, text=name)
        factor = _percent(settings[1], values, 0.1, 200.0)
        x.spindles.set(x, index, SpindleValue.SPEED, factor, first.column)
        return
    numbers = [slots.word.index for slots in settings]
    if numbers == [HOMING_G]:
        x.spindles.home(x, index, first.column)
    elif numbers == [ACCELERATION_G]:
        x.spindles.set(x, index, SpindleValue.ACCELERATION, _percent(settings[0], values, 1.0, 1000.0), first.column)
    elif set(numbers) <= {FEED_FORWARD_ON, FEED_FORWARD_WEIGHT, FEED_FORWARD_OFF} and len(set(numbers)) == len(numbers):
        state = x.spindles.programmed[index]
        for slots in settings:
            if slots.word.index == FEED_FORWARD_WEIGHT:
                state.feed_forward = _percent(slots, values, 0.0, 100.0)
            else:
                state.feeds_forward = slots.word.index == FEED_FORWARD_ON
        x.spindles.set(
            x, index, SpindleValue.FEED_FORWARD, state.feed_forward if state.feeds_forward else 0.0, first.column
        )
    else:
        raise LineError(errors.BRACKET_COMMAND, first.column, text=name)


def _percent(slots: FunctionSlots, values: Values, least: float, greatest: float) -> float:
    """The value of a command as a share; raises LineError."""
    word = slots.word
    name = word.name or f"G{word.index}"
    if slots.number < 0:
        raise LineError(errors.BRACKET_VALUE_MISSING, word.column, word=name)
    value = float(values[slots.number])
    if not least <= value <= greatest:
        shown = f"{least:g} to {greatest:g} %"
        raise LineError(errors.BRACKET_VALUE, word.column, word=name, value=value, range=shown)
    return value / 100.0


def argument_of_main(x: Execution, words: SpindleWords, value: float) -> None:
    """The S word as the argument of G74, G112 or G167. Raises LineError."""
    spindles, column = x.spindles, words.column
    setup, state = x.setup.spindles[spindles.main], spindles.main_programmed
    if x.speed_argument == OVERRIDE_G:  # the value has no meaning (line 24423)
        if setup.plc:
            raise LineError(errors.PLC_SPINDLE, column, name=setup.name)
        words.override_off = True
    elif x.speed_argument == HOMING_G:
        if words.any:
            raise LineError(errors.HOMING_WITH_M, column)
        spindles.home(x, spindles.main, column)
    else:
        if state.command in TURNING and not state.positioned:
            raise LineError(errors.GEAR_TURNING, column, name=setup.name)
        if words.command not in (-1, STOPPED) or words.position:
            raise LineError(errors.GEAR_TURNING, column, name=setup.name)
        if value not in range(1, setup.stages + 1):
            raise LineError(errors.GEAR_DATA, column, name=setup.name, stage=value)
        x.memory.gear_data[spindles.main] = int(value) - 1
        spindles.set(x, spindles.main, SpindleValue.GEAR, value - 1.0, column)
