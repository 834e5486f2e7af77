"""Finding the PLC program that the machine description names: "file.py" beside it, or "package.module", each with
":Class"."""

from __future__ import annotations

import importlib
import importlib.util
import os
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import ModuleType

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.diagnostics.errors import ErrorEntry, Place
from runtime.plc_logic.errors import PlcError, PlcFailure
from runtime.plc_logic.program import Program

_OWN_FILES = str(Path(__file__).parent)
TRACE_LINES = 12  # the last ones tell what happened


def load_program(reference: str, directory: Path, *, anew: bool = False) -> type[Program]:
    """The program class of `reference`; files are looked for in `directory` (that of the machine description).

    `anew`: from what the files contain now, those that the program imports from its folder included; after a failure
    the modules are what they were.

    Raises PlcFailure: missing, syntax error with its line, an error while importing, no or several programs.
    """
    if anew:
        with _forgotten(reference.partition(":")[0], directory):
            return load_program(reference, directory)
    module_name, _, class_name = reference.partition(":")
    module = _load_module(module_name, reference, directory)
    programs = _programs_in(module)
    if class_name:
        program = vars(module).get(class_name)
        if not (isinstance(program, type) and issubclass(program, Program) and program is not Program):
            what = f"has no program class {class_name}; known: {', '.join(sorted(programs)) or 'none'}"
            raise PlcFailure(catalogue.PLC_MODULE_MISSING, Place(reference), "", program=reference, what=what)
        return program
    if not programs:
        raise PlcFailure(catalogue.PLC_NO_PROGRAM, Place(module.__file__ or ""), "", program=reference)
    if len(programs) > 1:
        names = sorted(programs)
        raise PlcFailure(
            catalogue.PLC_SEVERAL_PROGRAMS,
            Place(module.__file__ or ""),
            "",
            program=reference,
            names=", ".join(names),
            first=names[0],
        )
    return next(iter(programs.values()))


def failure(entry: ErrorEntry, program: str, error: BaseException) -> PlcFailure:
    """The failure that an exception of the user's code is: its place, one line of text, and the end of the
    traceback."""
    frames = _user_frames(error)
    place = Place(frames[-1].filename, frames[-1].lineno or 0, text=frames[-1].line or "") if frames else Place()
    what = traceback.format_exception_only(error)[-1].strip()
    if isinstance(error, PlcError):
        what = error.problem.text
    if frames:
        what += f" ({Path(place.file).name}:{place.line}, in {frames[-1].name})"
    lines = [*traceback.format_list(frames), *traceback.format_exception_only(error)]
    trace = "\n".join("".join(lines).rstrip().splitlines()[-TRACE_LINES:])
    return PlcFailure(entry, place, trace, program=program, what=what)


def _user_frames(error: BaseException) -> list[traceback.FrameSummary]:
    """The frames of the user's code and of what it calls, without the library's in front and behind."""
    frames = list(traceback.extract_tb(error.__traceback__))
    while frames and frames[0].filename.startswith((_OWN_FILES, "<frozen importlib")):
        frames.pop(0)
    while frames and frames[-1].filename.startswith((_OWN_FILES, "<frozen importlib")):
        frames.pop()
    return frames


def _load_module(name: str, reference: str, directory: Path) -> ModuleType:
    missing: str
    try:
        if not name.endswith(".py"):
            return importlib.import_module(name)
        file = (directory / name).resolve()
        if file.is_file():
            return _import_file(file)
        missing = f"there is no file {file}"
    except SyntaxError as error:
        place = Place(error.filename or name, error.lineno or 0, error.offset or 0, (error.text or "").rstrip("\n"))
        what = f"{error.msg} in line {place.line}"
        raise PlcFailure(catalogue.PLC_SYNTAX, place, "", program=reference, what=what) from error
    except ModuleNotFoundError as error:
        if name.endswith(".py") or not error.name or not (name == error.name or name.startswith(error.name + ".")):
            raise failure(catalogue.PLC_IMPORT_RAISED, reference, error) from error
        missing = f"there is no module {error.name}"
    except PlcError as error:  # two handlers for one function
        raise PlcFailure(error.problem.entry, Place(reference), "", **error.problem.values) from error
    except (Exception, SystemExit) as error:
        raise failure(catalogue.PLC_IMPORT_RAISED, reference, error) from error
    raise PlcFailure(catalogue.PLC_MODULE_MISSING, Place(reference), "", program=reference, what=missing)


def _import_file(file: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    try:
        code = compile(file.read_bytes(), str(file), "exec", dont_inherit=True)
    except ValueError as error:  # null bytes: no Python text at all
        raise SyntaxError(str(error), (str(file), 1, 1, "")) from error
    with _importing(module, file):
        exec(code, module.__dict__)
    return module


@contextmanager
def _importing(module: ModuleType, file: Path) -> Iterator[None]:
    """While the file is executed, it can be found by its name (dataclasses need that) and import its neighbours."""
    before = sys.modules.get(module.__name__)
    sys.modules[module.__name__] = module
    sys.path.insert(0, str(file.parent))
    try:
        yield
    finally:
        sys.path.remove(str(file.parent))
        if before is not None:
            sys.modules[module.__name__] = before


def _beside(key: str, name: str, directory: Path) -> bool:
    """Whether a module is one that a program file has imported from its folder; installed packages are none."""
    file = str(getattr(sys.modules[key], "__file__", None) or "")
    own = name.endswith(".py") and file.startswith(str(directory.resolve()) + os.sep)
    return own and not key.startswith("runtime.") and "site-packages" not in file and not file.startswith(sys.prefix)


@contextmanager
def _forgotten(name: str, directory: Path) -> Iterator[None]:
    """The modules of the program are imported anew inside; if that fails the old ones are there again.

    Compiled files are not trusted: they know their source by size and by seconds, and somebody may be faster than that.
    """
    before = {key: sys.modules[key] for key in list(sys.modules) if key == name or _beside(key, name, directory)}
    for key in before:
        del sys.modules[key]
    for module in before.values():
        with suppress(OSError, AttributeError, NotImplementedError):
            Path(importlib.util.cache_from_source(str(module.__file__))).unlink()
    importlib.invalidate_caches()
    try:
        yield
    except BaseException:
        for key in [key for key in sys.modules if key in before]:
            del sys.modules[key]
        sys.modules.update(before)
        raise


def _programs_in(module: ModuleType) -> dict[str, type[Program]]:
    """The programs of a module: its own before imported ones, and of a family only the last descendants."""
    found = {
        name: member
        for name, member in vars(module).items()
        if isinstance(member, type) and issubclass(member, Program) and member is not Program
    }
    own = {name: member for name, member in found.items() if member.__module__ == module.__name__}
    candidates = own or found
    return {
        member.__name__: member
        for member in candidates.values()
        if not any(other is not member and issubclass(other, member) for other in candidates.values())
    }
