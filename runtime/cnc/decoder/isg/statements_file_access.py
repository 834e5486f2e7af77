"""#FILE RENAME, DELETE, EXIST: files in the folders of the channel (programming manual 16156–16353).

Errors come before anything is changed; a check changes nothing.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path

from runtime.cnc.decoder import file_access
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement, variable
from runtime.cnc.decoder.report_file import Backups
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.cnc.language.isg.words import ValueKind
from runtime.diagnostics.catalogue import language as catalogue

_EXIST = "isg.add.file-exist"
_MOST = 2**31 - 1


def _path(call: StatementCall, key: str) -> tuple[str, int]:
    return call.text(key) or "", call.columns(key)


def _writable(path: Path, name: str, column: int) -> None:
    """LineError for a file without write permission for anybody: the mark of a protected one, which even root keeps to."""
    if not path.stat().st_mode & (stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH) or not os.access(path, os.W_OK):
        raise LineError(catalogue.FILE_PROTECTED, column, file=name)


def _change(x: Execution, action: Callable[[], object], name: str, column: int) -> None:
    if not x.outside.changes_files():
        return
    try:
        action()
    except OSError as error:
        reason = error.strerror or "cannot be changed"
        raise LineError(catalogue.FILE_REFUSED, column, file=name, reason=reason) from None


@statement(
    "FILE RENAME",
    "isg.add.file-rename",
    syntax='#FILE RENAME [PATHOLD="<file>" PATHNEW="<file>" OVRMODE=0|1]',
    form=Form.KEYS,
    keys=(
        Key("PATHOLD", KeyKind.STRING, needed=True),
        Key("PATHNEW", KeyKind.STRING, needed=True),
        Key("OVRMODE", needed=True),
    ),
)
def rename(x: Execution, call: StatementCall) -> None:
    """A relative new name counts from the folder of the old file."""
    (old, at_old), (new, at_new) = _path(call, "PATHOLD"), _path(call, "PATHNEW")
    mode = call.needed("OVRMODE")
    if round_half_up(mode) not in (0, 1):
        raise call.error(catalogue.OVERWRITE_MODE, "OVRMODE", value=mode)
    source = file_access.found(x, old, at_old)
    target = file_access.in_folder(x, source.parent, new, at_new)
    file_access.require_free(x, source, old, at_old)
    file_access.require_free(x, target, new, at_new)
    _writable(source, old, at_old)
    if not target.parent.is_dir():
        raise LineError(catalogue.FILE_TARGET_FOLDER, at_new, file=new)
    if target.exists():
        if not target.is_file():
            raise LineError(catalogue.FILE_NAME_INVALID, at_new, file=new)
        if round_half_up(mode) == 0:
            raise LineError(catalogue.FILE_THERE, at_new, file=new)
        _writable(target, new, at_new)
    _change(x, lambda: source.replace(target), old, at_old)


@statement(
    "FILE DELETE",
    "isg.add.file-delete",
    syntax='#FILE DELETE [PATH="<file>"]',
    form=Form.KEYS,
    keys=(Key("PATH", KeyKind.STRING, needed=True),),
)
def delete(x: Execution, call: StatementCall) -> None:
    name, column = _path(call, "PATH")
    path = file_access.found(x, name, column)
    file_access.require_free(x, path, name, column)
    _writable(path, name, column)
    _change(x, path.unlink, name, column)


@statement(
    "FILE EXIST",
    _EXIST,
    syntax='#FILE EXIST [PATH="<file>"]',
    form=Form.KEYS,
    keys=(Key("PATH", KeyKind.STRING, needed=True),),
)
def exist(x: Execution, call: StatementCall) -> None:
    """Whether a file is there and can be opened; kept until the next question."""
    name, column = _path(call, "PATH")
    path = file_access.find(x, name, column)
    x.found_file = path if path is not None and os.access(path, os.R_OK) else None


@variable("V.G.FILE_EXIST", _EXIST, "1 if the last #FILE EXIST has found its file")
def file_exists(x: Execution) -> float:
    return float(x.found_file is not None)


@variable("V.G.FILE_EXIST_PATH_NAME", _EXIST, "path and name of the file found", kind=ValueKind.STRING)
def found_path(x: Execution) -> str:
    return "" if x.found_file is None else str(x.found_file)


@variable(
    "V.G.FILE_EXIST_DIRECTORY", _EXIST, "path of the file found, with a separator at its end", kind=ValueKind.STRING
)
def found_folder(x: Execution) -> str:
    return "" if x.found_file is None else f"{x.found_file.parent}{os.sep}"


# ---------------------------------------------------------------------------------------------------- #FILE NAME

BACKUP_KEYS = (Key("BACKUP_LINES_MAX"), Key("BACKUP_COUNT_MAX"))
"""Keys of #FILE NAME beside the names; `set_backups` obeys them."""


def set_backups(x: Execution, call: StatementCall) -> None:
    """Backups of the report file as #FILE NAME gives them.

    They are on as long as both limits are above 0; naming a report file without limits switches them off (line 16405).
    """
    if call.given("MSG") or call.given("BACKUP_LINES_MAX") or call.given("BACKUP_COUNT_MAX"):
        x.report_backups = Backups(_limit(call, "BACKUP_LINES_MAX"), _limit(call, "BACKUP_COUNT_MAX"))


def _limit(call: StatementCall, key: str) -> int:
    value = call.number(key, 0.0)
    assert value is not None
    if not -0.5 <= value < _MOST:
        raise call.error(catalogue.BACKUP_COUNT, key, key=key, value=value)
    return round_half_up(value)
