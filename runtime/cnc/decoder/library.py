"""The program files of a running program: found by the search paths, opened when they are called, each once."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from runtime.cnc.language.addresses import Addresses
from runtime.cnc.language.errors import ProgramError
from runtime.cnc.language.isg.index import Unit
from runtime.cnc.language.text import ProgramText
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import Place


class Library:
    """`folders` in the order of their priority. Relative names count from them; an absolute name is taken as it is."""

    def __init__(self, addresses: Addresses, folders: Sequence[Path]) -> None:
        self.addresses = addresses
        self.folders = list(dict.fromkeys(folders))
        self._units: dict[Path, Unit] = {}
        self._names: dict[str, Unit] = {}

    def open(self, path: Path, name: str) -> Unit:
        """A file as a unit, read up to the first block of its main program. ProgramError if there is none."""
        key = path.resolve()
        unit = self._units.get(key)
        if unit is None:
            unit = self._units[key] = Unit(name, ProgramText(path), self.addresses)
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

    def units(self) -> list[Unit]:
        """The files that are open."""
        return list(self._units.values())

    def close(self) -> None:
        """Give the files back."""
        for unit in self._units.values():
            unit.text.close()
