"""The decoder: a program file → blocks. `load_program` checks the whole file, `Decoder` executes it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from runtime.cnc.decoder.decoder import Decoder
from runtime.cnc.decoder.locate import located
from runtime.cnc.decoder.setup import DecoderSetup, DecoderSetupError, SpindleSetup, parse_synch
from runtime.cnc.language.errors import ProgramError, ProgramErrors
from runtime.cnc.language.isg.loader import load
from runtime.cnc.language.isg.program import Program
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import Place

DIALECTS = ("isg",)

__all__ = [
    "DIALECTS",
    "Decoder",
    "DecoderSetup",
    "DecoderSetupError",
    "Program",
    "ProgramError",
    "ProgramErrors",
    "SpindleSetup",
    "expect_dialect",
    "load_program",
    "located",
    "parse_synch",
]


def load_program(
    path: Path,
    channel_setup: DecoderSetup,
    dialect: str = "isg",
    progress: Callable[[int, int], None] | None = None,
) -> Program:
    """Read a program and everything it calls, and check all of it before anything is executed.

    `progress(bytes done, bytes in all)` is told now and then. Raises ProgramError (a file) or ProgramErrors (up to 20
    problems of its blocks).
    """
    expect_dialect(dialect, str(path))
    return load(path, channel_setup.addresses, channel_setup.program_paths, progress)


def expect_dialect(dialect: str, file: str = "") -> None:
    """Raises ProgramError for a dialect that is not known; `file` is the program that was to be read."""
    if dialect not in DIALECTS:
        supported = ", ".join(DIALECTS)
        raise ProgramError(catalogue.DIALECT_UNSUPPORTED, Place(file=file), dialect=dialect, supported=supported)
