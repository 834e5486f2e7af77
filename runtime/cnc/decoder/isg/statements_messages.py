"""#MSG, #MSG INFO, #MSG SAVE, #ADD: messages of a program (programming manual 13305–13575).

A message goes out when it is decoded, or (SYN) when the path is there. Whoever waits for the receiver is the decoder with ACK,
the path with SYN_ACK.
"""

from __future__ import annotations

from runtime.cnc.blocks import Message, Receiver
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.file_access import in_folder, report_folder, report_name, require_free
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.decoder.isg.variables_stamps import stamp
from runtime.cnc.decoder.message_text import composed, marks_of
from runtime.cnc.decoder.report_file import append
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.expressions import literal_text
from runtime.cnc.language.isg.syntax import Form
from runtime.diagnostics.catalogue import language as catalogue

MODES = ("SYN", "SYN_ACK", "ACK")
RECEIVERS = {receiver.value: receiver for receiver in Receiver} | {"DIAG": Receiver.DIAGNOSIS}
_FORMAT = "isg.add.msg-format"
_SYNTAX = '#MSG [SYN | SYN_ACK | ACK] [<receiver>] ["text", <value> ...]'


def message_text(x: Execution, call: StatementCall) -> str:
    """The text with its values. LineError at the argument that does not fit."""
    title = "#" + call.syntax.name
    arguments = call.values()
    text, values = arguments[0][1], [value for _, value in arguments[1:]]
    try:
        marks = marks_of(text)
        for place, (argument, value) in enumerate(arguments[1:]):
            name = literal_text(argument.value) if argument.value is not None else None
            content = x.environment.macro(name) if name is not None else None
            if content is not None:
                wants_text = place < len(marks) and marks[place] == "s"
                values[place] = x.expand(content) if wants_text else _computed(x, content, argument.column)
            else:
                values[place] = value
        return composed(text, values, title)
    except CalculationError as error:
        raise LineError(error.entry, arguments[0][0].column, **error.values) from None


def _computed(x: Execution, content: str, column: int) -> object:
    """The value of a macro's content as an expression."""
    try:
        source = x.parser.expression(x.expand(content), 1).source
    except LineError as error:
        raise LineError(error.entry, column, **error.values) from None
    return eval(source, x.environment.namespace)


def _mode_and_receiver(call: StatementCall, syntax: str) -> tuple[str, Receiver]:
    """Mode and receiver, each at most once and in this order."""
    mode, receiver = "", None
    for argument, _ in call:
        word = argument.text
        if argument.name or not word:
            continue
        if word in MODES and not mode and receiver is None:
            mode = word
        elif word in RECEIVERS and receiver is None:
            receiver = RECEIVERS[word]
        else:
            title = "#" + call.syntax.name
            raise LineError(catalogue.MESSAGE_MODE, argument.column, word=word, statement=title, syntax=syntax)
    return mode, receiver or Receiver.DIAGNOSIS


def _send(x: Execution, call: StatementCall, information: bool) -> None:
    mode, receiver = _mode_and_receiver(call, call.syntax.syntax[0])
    waiting = x.waiting
    if isinstance(waiting, _Told):  # executed again: whether the receiver has taken it
        if not x.outside.taken(waiting.number) and not x.outside.waits_in_vain():
            x.repeat("acknowledgement of a message")
            return
        x.waiting = None
        return
    text = message_text(x, call)
    if mode in ("SYN", "SYN_ACK"):
        x.emit(Message(x.source, text, receiver, mode == "SYN_ACK", information))
        return
    if not x.outside.room():
        x.repeat("room for a message")
        return
    number = x.outside.tell(Message(x.source, text, receiver, mode == "ACK", information))
    if mode == "ACK" and not x.outside.taken(number):
        x.waiting = _Told(number)
        x.repeat("acknowledgement of a message")
        if x.again is None:
            x.waiting = None


class _Told:
    """A message that waits for its receiver."""

    __slots__ = ("number",)

    def __init__(self, number: int) -> None:
        self.number = number


@statement("MSG", "isg.add.msg", _FORMAT, syntax=_SYNTAX, form=Form.MESSAGE, words=(*MODES, *RECEIVERS))
def message(x: Execution, call: StatementCall) -> None:
    _send(x, call, False)


@statement(
    "MSG INFO",
    "isg.add.msg-info",
    _FORMAT,
    syntax=_SYNTAX.replace("#MSG", "#MSG INFO"),
    form=Form.MESSAGE,
    words=(*MODES, *RECEIVERS),
)
def information(x: Execution, call: StatementCall) -> None:
    """The receiver decodes the text itself."""
    _send(x, call, True)


@statement(
    "ADD",
    "isg.add.add",
    _FORMAT,
    syntax='<words> #ADD [<receiver>] ["text", <value> ...]',
    form=Form.MESSAGE,
    words=tuple(RECEIVERS),
)
def addition(x: Execution, call: StatementCall) -> None:
    """A message at the end of its block, always when the path is there."""
    _, receiver = _mode_and_receiver(call, call.syntax.syntax[0])
    x.emit(Message(x.source, message_text(x, call), receiver))


@statement(
    "MSG SAVE",
    "isg.add.msg-save",
    _FORMAT,
    syntax='#MSG SAVE [EXCLUSIVE] [CONTINUE] ["text", <value> ...]',
    form=Form.MESSAGE,
    words=("EXCLUSIVE", "CONTINUE"),
)
def save(x: Execution, call: StatementCall) -> None:
    """Behind the end of the report file, when the block is decoded. A check writes nothing."""
    words = call.words()
    for argument, _ in call:
        if argument.text in words and words.count(argument.text) > 1:
            raise LineError(
                catalogue.MESSAGE_MODE,
                argument.column,
                word=argument.text,
                statement="#MSG SAVE",
                syntax=call.syntax.syntax[0],
            )
    text = message_text(x, call)
    if "EXCLUSIVE" not in words:
        text = f"{stamp(x.outside.now())} {text}"
    if "CONTINUE" not in words:
        text += "\n"
    name = report_name(x)
    path = in_folder(x, report_folder(x), name, call.column)
    require_free(x, path, name, call.column)
    if not x.outside.changes_files():
        return
    try:
        append(path, text, x.report_backups, x.memory)
    except OSError as error:
        reason = error.strerror or "cannot be written"
        raise LineError(catalogue.FILE_REFUSED, call.column, file=name, reason=reason) from None
