"""The decoder: a program file → blocks. `load_program` checks the whole file, `Decoder` executes it."""

from __future__ import annotations

from pathlib import Path

import runtime.cnc.decoder.isg.functions  # noqa: F401 - registers the dialect
from runtime.cnc.decoder.decoder import Decoder
from runtime.cnc.decoder.locate import located
from runtime.cnc.decoder.memory import ChannelMemory
from runtime.cnc.decoder.outside import Offline, Outside
from runtime.cnc.decoder.program import Program, look_through, open_program
from runtime.cnc.decoder.setup import DecoderSetup, DecoderSetupError, SpindleSetup, parse_synch
from runtime.cnc.language.errors import ProgramError, ProgramErrors
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import Place

DIALECTS = ("isg",)

__all__ = [
    "DIALECTS",
    "ChannelMemory",
    "Decoder",
    "DecoderSetup",
    "DecoderSetupError",
    "Offline",
    "Outside",
    "Program",
    "ProgramError",
    "ProgramErrors",
    "SpindleSetup",
    "expect_dialect",
    "load_program",
    "located",
    "look_through",
    "parse_synch",
]


def load_program(path: Path, channel_setup: DecoderSetup, dialect: str = "isg") -> Program:
    """Open a program. A short one is looked through first; a long one is read while it is executed.

    Raises ProgramError (a file) or ProgramErrors (up to 20 problems of its blocks).
    """
    expect_dialect(dialect, str(path))
    return open_program(path, channel_setup)


def expect_dialect(dialect: str, file: str = "") -> None:
    """Raises ProgramError for a dialect that is not known; `file` is the program that was to be read."""
    if dialect not in DIALECTS:
        supported = ", ".join(DIALECTS)
        raise ProgramError(catalogue.DIALECT_UNSUPPORTED, Place(file=file), dialect=dialect, supported=supported)
