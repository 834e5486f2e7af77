"""System variables of the program: alarm, stop with message, timer, suppression, modal information (manual lines 6932–7142).

Modal information is told of the block before (#4001 to #4130), and of the block in work (#4201 to #4330). What is written in the
block in work holds for the latter, whatever its place in the block.
"""

from __future__ import annotations

from collections.abc import Callable

from runtime.cnc.blocks import Flush, FlushKind, Message, Receiver, Stop, StopKind, UserError
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.registry import system_variable, tenths_of, writes
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.nct.functions import Value, number, whole
from runtime.diagnostics.catalogue import nct_macros as catalogue

ALARM, STOP = 4000, 5000  # what the programmed number is added to
MOST_NUMBER = 999
MOST_TEXT = 25
TIMER_OVERFLOW = 65_536  # ms
FEED_STOP, OVERRIDE, EXACT_STOP = 1, 2, 4  # bits of #3004
WORDS = {
    1: "A", 2: "B", 3: "C", 7: "D", 8: "E", 9: "F", 11: "H", 13: "M", 14: "N", 15: "O", 19: "S", 20: "T",
}  # fmt: skip


def _whole(variable: int, value: Value, most: int) -> int:
    """A whole number from 0 to `most`; CalculationError for another one."""
    given = number(value)
    if not (0 <= given <= most and given == whole(given)):
        allowed = f"whole numbers from 0 to {most}"
        raise CalculationError(
            catalogue.VALUE_REFUSED, f"#{variable}", number=variable, value=f"{given:g}", allowed=allowed
        )
    return whole(given)


def _message(x: NctExecution, variable: int, value: Value, base: int) -> tuple[int, str]:
    """Number and text of an alarm or a message; the text stands in the comment of the block."""
    assert x.work is not None
    text = x.work.comment.strip()
    if len(text) > MOST_TEXT:
        raise CalculationError(catalogue.TEXT_TOO_LONG, f"#{variable}", number=variable, limit=MOST_TEXT)
    return base + _whole(variable, value, MOST_NUMBER), text


# ---------------------------------------------------------------------------------------------------- alarm, stop


@writes(
    3000, spec=("nct.sysvar.alarm-3000",), meaning="alarm: number and text, the program stops with error 4000 + number"
)
def alarm(x: NctExecution, variable: int, value: Value) -> None:
    """The blocks before are executed; a reset clears the error."""
    code, text = _message(x, variable, value, ALARM)
    x.emit(UserError(x.source, code, 2, 0, text=f"{code} {text}".rstrip()))
    x.emit(Flush(x.source, FlushKind.WAIT))


@writes(
    3006, spec=("nct.sysvar.stop-message-3006",), meaning="stop with a message: 5000 + number and text, until START"
)
def stop(x: NctExecution, variable: int, value: Value) -> None:
    """The message is told, then the path stands as with M00."""
    code, text = _message(x, variable, value, STOP)
    x.emit(Message(x.source, f"{code} {text}".rstrip(), Receiver.HMI))
    x.emit(Stop(x.source, StopKind.PROGRAMMED))


# ---------------------------------------------------------------------------------------------------- timer


def _milliseconds(x: NctExecution) -> float:
    return x.outside.cycle() * x.setup.period * 1000.0


@system_variable(
    3001, None, "nct.sysvar.timers-3001-3002", meaning="timer, ms from power-on; begins anew at 65536", in_step=True
)
def timer(x: NctExecution, variable: int) -> Value:
    return float(int(_milliseconds(x) - x.memory.timer_begin) % TIMER_OVERFLOW)


@writes(3001)
def set_timer(x: NctExecution, variable: int, value: Value) -> None:
    """It counts on from this value; when the path has come here."""
    x.expect_in_step()
    x.memory.timer_begin = _milliseconds(x) - _whole(variable, value, TIMER_OVERFLOW - 1)


# ---------------------------------------------------------------------------------------------------- suppression


@system_variable(3003, None, "nct.sysvar.suppression-3003-3004", meaning="1: single block does not stop")
def single_block(x: NctExecution, variable: int) -> Value:
    return float(x.steps.locked)


@writes(3003)
def suppress_single_block(x: NctExecution, variable: int, value: Value) -> None:
    x.steps.locked = bool(_whole(variable, value, 1))
    x.modal_changed()


@system_variable(
    3004,
    None,
    "nct.sysvar.suppression-3003-3004",
    meaning="sum of 1 feed stop, 2 override, 4 exact stop: without effect",
)
def suppressed(x: NctExecution, variable: int) -> Value:
    now = x.suppressed
    return float(FEED_STOP * now.feed_stop + OVERRIDE * now.override + EXACT_STOP * now.exact_stop)


@writes(3004)
def suppress(x: NctExecution, variable: int, value: Value) -> None:
    """Stop and override from this place of the path on; exact stops of the blocks behind."""
    bits, now = _whole(variable, value, 7), x.suppressed
    now.feed_stop, now.override, now.exact_stop = bool(bits & FEED_STOP), bool(bits & OVERRIDE), bool(bits & EXACT_STOP)
    x.tell_suppression()


@system_variable(3007, None, "nct.sysvar.status-and-counters", meaning="mirrored axes: bit 0 is the first axis")
def mirrored(x: NctExecution, variable: int) -> Value:
    return float(sum(1 << axis for axis in x.coordinates.transformations.mirrors))


# ---------------------------------------------------------------------------------------------------- modal information


def _code(x: NctExecution, group: int) -> Value:
    """The code of a G group that holds; vacant for a group that has none."""
    if group == 0:
        return None
    tenths = next((tenths for known, tenths in x.active.items() if known.value == group), None)
    return None if tenths is None else tenths / 10


def _code_of_block(x: NctExecution, group: int) -> Value:
    """As `_code`, with the codes of the block in work."""
    for word in x.work.words if x.work is not None else ():
        if (
            word.address == "G"
            and word.value.constant is not None
            and x.group_of(tenths_of(word.value.constant)) == group
        ):
            return word.value.constant
    return _code(x, group)


def _word(x: NctExecution, address: str) -> Value:
    """The last value of a word; block and program number of the block before."""
    if address == "O":
        return float(x.level.number)
    if address == "N":
        return float(x.number_before) if x.number_before else None
    if address == "F":
        feed = x.modal.feed
        return None if feed is None else x.shown_length(feed)
    return x.last_words.get(address)


def _word_of_block(x: NctExecution, address: str) -> Value:
    """As `_word`, with the words of the block in work."""
    if address == "N":
        return float(x.sequence_number) if x.sequence_number else None
    for word in x.work.words if x.work is not None else ():
        if word.address == address and word.value.constant is not None:
            return word.value.constant
    return _word(x, address)


def _register(
    first: int, code: Callable[[NctExecution, int], Value], word: Callable[[NctExecution, str], Value], of: str
) -> None:
    @system_variable(first + 1, first + 20, "nct.sysvar.modal-information", meaning=f"G code of group 1 to 20, of {of}")
    def codes(x: NctExecution, variable: int) -> Value:
        return code(x, variable - first)

    for place, address in WORDS.items():

        @system_variable(first + 100 + place, None, "nct.sysvar.modal-information", meaning=f"{address}, of {of}")
        def words(x: NctExecution, variable: int, address: str = address) -> Value:
            return word(x, address)


_register(4000, _code, _word, "the block before")
_register(4200, _code_of_block, _word_of_block, "the block in work")
