"""# statements of files (programming manual lines 16058–16300)."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.g_calls import CALLS
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.decoder.isg.statements_file_access import BACKUP_KEYS, set_backups
from runtime.cnc.decoder.library import wrong_name
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind

_FUNCTIONS = ("MSG", "M6", "D", *(f"G{number}" for number in CALLS))


@statement(
    "FILE NAME",
    "isg.add.file-name",
    "isg.add.file-backup",
    syntax='#FILE NAME [MSG="<file>" M6="<file>" D="<file>" G80="<file>" … BACKUP_LINES_MAX=.. BACKUP_COUNT_MAX=..]',
    form=Form.KEYS,
    keys=(*(Key(name, KeyKind.NAME) for name in _FUNCTIONS), *BACKUP_KEYS),
)
def file_name(x: Execution, call: StatementCall) -> None:
    """Names of files that functions use, until the program ends."""
    set_backups(x, call)
    for argument, _ in call:
        if argument.name not in _FUNCTIONS:
            continue
        name = call.text(argument.name) or ""
        wrong = wrong_name(name)
        if wrong is not None:
            raise LineError(wrong[0], argument.column, **wrong[1])
        x.file_names[argument.name] = name
