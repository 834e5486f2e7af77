"""The program files of a running program: found by the search paths, opened when they are called, each once."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from runtime.cnc.language.addresses import Addresses
from runtime.cnc.language.errors import ProgramError
from runtime.cnc.language.isg.index import Rules, Unit
from runtime.cnc.language.text import ProgramText
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import ErrorEntry, Place

SEPARATORS = '\r\n\x03\t\0 (;"],#$'  # they end a name (programming manual line 1073)
NAME_LENGTH = 83


def wrong_name(name: str) -> tuple[ErrorEntry, dict[str, object]] | None:
    """What is wrong with the name of a file or subprogram, None if nothing is."""
    if len(name) > NAME_LENGTH:
        return catalogue.NAME_LENGTH, {"name": name[:20] + "…", "limit": NAME_LENGTH}
    wrong = next((character for character in name if character in SEPARATORS), None)
    return None if wrong is None else (catalogue.NAME_CHARACTER, {"name": name, "character": wrong})


class Library:
    """`folders` in the order of their priority. Relative names count from them; an absolute name is taken as it is."""

    def __init__(self, addresses: Addresses, folders: Sequence[Path], rules: Rules = Rules()) -> None:  # noqa: B008
        self.addresses = addresses
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

    def find(self, name: str) -> Path | None:
        """The first file of this name along the search paths."""
        if Path(name).is_absolute():
            return Path(name) if Path(name).is_file() else None
        return next((folder / name for folder in self.folders if (folder / name).is_file()), None)

    def global_program(self, name: str, place: Place) -> Unit:
        """The unit of a global subprogram; ProgramError at `place` if it is not found."""
        unit = self._names.get(name)
        if unit is None:
            path = self.find(name)
            if path is None:
                paths = ", ".join(str(folder) for folder in self.folders)
                raise ProgramError(catalogue.GLOBAL_MISSING, place, name=name, paths=paths)
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
