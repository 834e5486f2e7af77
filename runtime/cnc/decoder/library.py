"""The program files of a running program: found by the search paths, opened when they are called, each once.

A program reaches the files in its folders and below them. Where a name leads elsewhere, by `..`, as an absolute path or through a
link, it is refused; only the configuration of the channel may name programs anywhere.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Sequence
from pathlib import Path

from runtime.cnc.language.addresses import Addresses
from runtime.cnc.language.errors import ProgramError
from runtime.cnc.language.isg.index import Rules, Unit
from runtime.cnc.language.text import ProgramText
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import ErrorEntry, Place, Problem

SEPARATORS = '\r\n\x03\t\0 (;"],#$'  # they end a name (programming manual line 1073)
NAME_LENGTH = 83


def wrong_name(name: str) -> tuple[ErrorEntry, dict[str, object]] | None:
    """What is wrong with the name of a file or subprogram, None if nothing is."""
    if len(name) > NAME_LENGTH:
        return catalogue.NAME_LENGTH, {"name": name[:20] + "…", "limit": NAME_LENGTH}
    wrong = next((character for character in name if character in SEPARATORS), None)
    return None if wrong is None else (catalogue.NAME_CHARACTER, {"name": name, "character": wrong})


def _leads_away(name: str, folders: Sequence[Path]) -> bool:
    """Whether a name, as it is written, leads out of every folder."""
    written = [Path(os.path.normpath(folder.absolute() / name)) for folder in folders]
    return not any(path.is_relative_to(folder.absolute()) for path, folder in zip(written, folders, strict=True))


class Library:
    """`folders` in the order of their priority. Relative names count from them, absolute ones have to lie in one of them, unless
    they are `configured`."""

    def __init__(
        self,
        addresses: Addresses,
        folders: Sequence[Path],
        rules: Rules = Rules(),  # noqa: B008
        configured: Collection[str] = (),
    ) -> None:
        self.addresses = addresses
        self._configured = frozenset(configured)
        self.rules = rules
        self.folders = list(dict.fromkeys(folders))
        self._units: dict[Path, Unit] = {}
        self._names: dict[str, Unit] = {}
        self._anew: dict[ProgramText, Unit] = {}

    def open(self, path: Path, name: str) -> Unit:
        """A file as a unit, read up to the first block of its main program. ProgramError if there is none."""
        key = path.resolve()
        unit = self._units.get(key)
        if unit is None:
            unit = self._units[key] = Unit(name, ProgramText(path), self.addresses, self.rules)
            unit.open()
        if unit.main is None:
            fault = next(iter(unit.faults.values()), None)
            if fault is not None:
                raise ProgramError(fault.entry, unit.place(fault.line, fault.column, fault.text), **fault.values)
            raise ProgramError(catalogue.MAIN_MISSING, unit.place(0), file=unit.text.name)
        return unit

    def find(self, name: str, place: Place) -> Path | Problem:
        """The first file of this name along the search paths; what is wrong at `place` if there is none, or it lies outside."""
        paths = ", ".join(str(folder) for folder in self.folders)
        folders = [Path()] if Path(name).is_absolute() else self.folders
        try:
            path = next((folder / name for folder in folders if (folder / name).is_file()), None)
            real = path and path.resolve()
        except (OSError, RuntimeError):  # a name that no file can have, links in a circle
            path = real = None
        if path is None or real is None:
            # nothing is told about files outside, not even whether they are there
            if name not in self._configured and _leads_away(name, self.folders):
                return Problem(catalogue.FILE_OUTSIDE, {"file": name, "folders": paths}, place)
            return Problem(catalogue.GLOBAL_MISSING, {"name": name, "paths": paths}, place)
        if name not in self._configured and not any(real.is_relative_to(folder.resolve()) for folder in self.folders):
            return Problem(catalogue.FILE_OUTSIDE, {"file": name, "folders": paths}, place)
        return path

    def global_program(self, name: str, place: Place) -> Unit:
        """The unit of a global subprogram; ProgramError at `place` if it is not found or lies outside of the folders."""
        unit = self._names.get(name)
        if unit is None:
            path = self.find(name, place)
            if isinstance(path, Problem):
                raise ProgramError(path.entry, path.place, **path.values)
            unit = self._names[name] = self.open(path, name)
        return unit

    def anew(self, unit: Unit) -> Unit:
        """The same file with an index that forgets nothing; made once."""
        made = self._anew.get(unit.text)
        if made is None:
            made = self._anew[unit.text] = unit.anew()
            made.open()
        return made

    def units(self) -> list[Unit]:
        """The files that are open."""
        return list(self._units.values())

    def close(self) -> None:
        """Give the files back."""
        for unit in self._units.values():
            unit.text.close()
