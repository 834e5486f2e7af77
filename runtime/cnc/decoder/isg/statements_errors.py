"""#ERROR: errors of the program's own (programming manual 15332–15460)."""

from __future__ import annotations

from runtime.cnc.blocks import Flush, FlushKind, UserError
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.functions import as_number, round_half_up
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import language as catalogue

VALUES, FURTHER = 5, 4  # PV1…PV5, PIV1…PIV4
MOST_CHARACTERS = 23  # of a string in PV
MOST_MEANING = 21
LIMIT_VALUE = 1  # meaning of a value without PM
WARNING = 0
CLASSES = (WARNING, 2, 7)
_MOST = 2**31 - 1


@statement(
    "ERROR",
    "isg.add.error",
    syntax="#ERROR [ID=.. RC=.. MID=.. PV1..5=.. PM1..5=.. PIV1..4=..]",
    form=Form.KEYS,
    keys=(
        Key("ID"),
        Key("RC"),
        Key("MID"),
        Key("PIV", KeyKind.NUMBER, indexed=(1, FURTHER)),
        Key("PV", KeyKind.VALUE, indexed=(1, VALUES)),
        Key("PM", KeyKind.NUMBER, indexed=(1, VALUES)),
    ),
)
def user_error(x: Execution, call: StatementCall) -> None:
    """A warning is told at once and the program goes on. An error stops the path when it is there, and nothing behind it is done
    ahead of time."""
    number = _whole(call, "ID", 1, 1, 1000)
    remedy_class = _whole(call, "RC", WARNING, 0, 7)
    if remedy_class not in CLASSES:
        allowed = ", ".join(str(known) for known in CLASSES)
        raise call.error(catalogue.ERROR_VALUE, "RC", key="RC", value=remedy_class, allowed=allowed)
    multiple = _whole(call, "MID", 0, 0, _MOST)
    values: list[float | str] = [0.0] * VALUES
    meanings, further = [LIMIT_VALUE] * VALUES, [0.0] * FURTHER
    used = 0
    for argument, value in call:
        key, place = f"{argument.name}{argument.index}", argument.index - 1
        if argument.name == "PV":
            if isinstance(value, str) and len(value) > MOST_CHARACTERS:
                allowed = f"a string of {MOST_CHARACTERS} characters"
                raise LineError(catalogue.ERROR_VALUE, argument.column, key=key, value=repr(value), allowed=allowed)
            values[place] = value if isinstance(value, str) else _number(value, key, argument.column)
            used = max(used, place + 1)
        elif argument.name == "PM":
            meanings[place] = _between(value, key, 0, MOST_MEANING, argument.column)
            used = max(used, place + 1)
        elif argument.name == "PIV":
            further[place] = _number(value, key, argument.column)
    error = UserError(
        x.source, number, remedy_class, multiple, tuple(values[:used]), tuple(meanings[:used]), _given(call, further)
    )
    if remedy_class == WARNING:
        if not x.outside.room():
            x.repeat("room for a warning")
            return
        x.outside.error(error)
        return
    x.emit(error)
    x.emit(Flush(x.source, FlushKind.WAIT))


def _given(call: StatementCall, further: list[float]) -> tuple[float, ...]:
    """The further values up to the last one that is programmed."""
    return tuple(further[: max((a.index for a, _ in call if a.name == "PIV"), default=0)])


def _number(value: object, key: str, column: int) -> float:
    try:
        return as_number(value, key)
    except CalculationError as error:
        raise LineError(error.entry, column, **error.values) from None


def _whole(call: StatementCall, key: str, default: int, least: int, most: int) -> int:
    value = call.number(key)
    return default if value is None else _between(value, key, least, most, call.columns(key))


def _between(value: object, key: str, least: int, most: int, column: int) -> int:
    number = _number(value, key, column)
    if not least - 0.5 <= number < most + 0.5:
        allowed = f"{least} to {most}"
        raise LineError(catalogue.ERROR_VALUE, column, key=key, value=f"{number:.9g}", allowed=allowed)
    return round_half_up(number)
