"""Where the programs of numbers are: in the file of the main program, then in files of the folders named after their number."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from runtime.cnc.language.nct.program_file import Section, Unit
from runtime.cnc.language.text import ProgramText

ENDINGS = ("", ".nc", ".NC", ".nct", ".NCT", ".txt")
BEGINNINGS = ("O{0:04d}", "o{0:04d}", "{0:04d}")


class Library:
    """`folders` in the order of their priority. A file that leads out of them through a link is not taken."""

    def __init__(self, folders: Sequence[Path]) -> None:
        self._folders = list(dict.fromkeys(folders))
        self._units: dict[Path, Unit] = {}

    @property
    def folders(self) -> str:
        """Where files are looked for, for messages."""
        return ", ".join(str(folder) for folder in self._folders)

    def open(self, path: Path, name: str) -> Unit:
        """A file, opened once. ProgramError if that fails."""
        key = path.resolve()
        unit = self._units.get(key)
        if unit is None:
            unit = self._units[key] = Unit(name, ProgramText(path))
        return unit

    def find(self, number: int, caller: Unit) -> tuple[Unit, Section] | None:
        """A program by its number, None if there is none: in the file of the caller, in the main file, in the folders."""
        for unit in dict.fromkeys((caller, *self._units.values())):
            section = unit.program(number)
            if section is not None:
                return unit, section
        for folder in self._folders:
            for beginning in BEGINNINGS:
                for ending in ENDINGS:
                    path = folder / (beginning.format(number) + ending)
                    if not path.is_file() or not path.resolve().is_relative_to(folder.resolve()):
                        continue
                    unit = self.open(path, path.name)
                    section = unit.program(number)
                    if section is None and unit.single:
                        section = unit.main
                    if section is not None:
                        return unit, section
        return None

    def units(self) -> list[Unit]:
        """The files that are open."""
        return list(self._units.values())

    def close(self) -> None:
        """Give the files back."""
        for unit in self._units.values():
            unit.text.close()
