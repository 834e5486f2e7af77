"""Which files a program may reach: those in the folders of its channel, and nothing outside of them.

Names count from the folders of main program, subprograms and reports, in this order (programming manual 16188). Whatever a name
leads to, by `..`, as an absolute path or through a link, has to lie in one of them.
"""

from __future__ import annotations

import re
from pathlib import Path

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.report_file import DEFAULT_NAME
from runtime.cnc.language.isg.comments import LineError
from runtime.diagnostics.catalogue import language as catalogue

_DRIVE = re.compile(r"[A-Za-z]:")


def report_folder(x: Execution) -> Path:
    """Where report files go: the first folder configured for messages, else that of the main program."""
    paths = x.setup.message_paths
    return x.library.folders[0] / paths[0] if paths else x.library.folders[0]


def report_name(x: Execution) -> str:
    """The report file as #FILE NAME [MSG=..] has named it."""
    return x.file_names.get("MSG", DEFAULT_NAME)


def folders(x: Execution) -> list[Path]:
    """Folders in the order in which a name is looked for."""
    return list(dict.fromkeys([*x.library.folders, report_folder(x)]))


def inside(x: Execution, path: Path, name: str, column: int) -> Path:
    """The path if it leads into a folder of the channel, all links followed; LineError otherwise."""
    if not name.strip() or "\0" in name or name.strip() in (".", ".."):
        raise LineError(catalogue.FILE_NAME_INVALID, column, file=name)
    real = path.resolve()
    allowed = [folder.resolve() for folder in folders(x)]
    if _DRIVE.match(name) or not any(real != folder and real.is_relative_to(folder) for folder in allowed):
        raise LineError(catalogue.FILE_OUTSIDE, column, file=name, folders=_listed(x))
    return real


def in_folder(x: Execution, folder: Path, name: str, column: int) -> Path:
    """A file of this name in a folder, there or not; LineError if it would lie outside of the channel's folders."""
    return inside(x, folder / name, name, column)


def find(x: Execution, name: str, column: int) -> Path | None:
    """The first regular file of this name, None if there is none; LineError if the name leads outside."""
    if Path(name).is_absolute() or _DRIVE.match(name):
        real = inside(x, Path(name), name, column)
        return real if real.is_file() else None
    for folder in folders(x):
        real = inside(x, folder / name, name, column)
        if real.is_file():
            return real
    return None


def found(x: Execution, name: str, column: int) -> Path:
    """As `find`; LineError if there is none."""
    path = find(x, name, column)
    if path is None:
        raise LineError(catalogue.FILE_NOT_FOUND, column, file=name, folders=_listed(x))
    return path


def require_free(x: Execution, path: Path, name: str, column: int) -> None:
    """LineError for a file that the running program executes."""
    if any(unit.text.path.resolve() == path for unit in x.library.units()):
        raise LineError(catalogue.FILE_IN_USE, column, file=name)


def _listed(x: Execution) -> str:
    return ", ".join(str(folder) for folder in folders(x))
