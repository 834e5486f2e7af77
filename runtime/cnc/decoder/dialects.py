"""The dialects: which ones there are, and a program of each with the decoder that executes it.

Behind the decoder nobody knows in which one a program is written.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, overload

import runtime.cnc.decoder.isg.functions  # noqa: F401 - registers the dialect
from runtime.cnc.decoder import program as isg
from runtime.cnc.decoder.decoder import Decoder
from runtime.cnc.decoder.nct import program as nct
from runtime.cnc.decoder.nct.decoder import NctDecoder
from runtime.cnc.decoder.nct.program import NctProgram
from runtime.cnc.decoder.program import Program, Progress
from runtime.cnc.decoder.setup import DecoderSetup
from runtime.cnc.language.errors import ProgramError
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.catalogue import motion, nct_offsets
from runtime.diagnostics.errors import Place, Problem

DIALECTS = ("isg", "nct")

AnyProgram = Program | NctProgram
AnyDecoder = Decoder | NctDecoder


@overload
def load_program(path: Path, channel_setup: DecoderSetup, dialect: Literal["isg"] = "isg") -> Program: ...


@overload
def load_program(path: Path, channel_setup: DecoderSetup, dialect: str) -> AnyProgram: ...


def load_program(path: Path, channel_setup: DecoderSetup, dialect: str = "isg") -> AnyProgram:
    """Open a program. A short one is looked through first; a long one is read while it is executed.

    Raises ProgramError (a file) or ProgramErrors (up to 20 problems of its blocks).
    """
    expect_dialect(dialect, str(path))
    return nct.open_program(path, channel_setup) if dialect == "nct" else isg.open_program(path, channel_setup)


def decoder_of(program: AnyProgram, setup: DecoderSetup, **arguments: Any) -> AnyDecoder:
    """The decoder that executes a program; see `Decoder` for the arguments."""
    if isinstance(program, NctProgram):
        return NctDecoder(program, setup, **arguments)
    return Decoder(program, setup, **arguments)


def look_through(
    path: Path, setup: DecoderSetup, progress: Progress | None = None, dialect: str = "isg"
) -> Iterator[Problem]:
    """What is wrong with the blocks of a file, in the order of its lines, without executing any."""
    return (nct.look_through if dialect == "nct" else isg.look_through)(path, setup, progress)


def told(program: AnyProgram, problem: Problem) -> Problem:
    """A problem that was found behind the decoder, with the entry under which the dialect of the program tells it."""
    if isinstance(program, NctProgram) and problem.entry is motion.SOFTWARE_LIMIT:
        return replace(problem, entry=nct_offsets.LIMIT)
    return problem


def expect_dialect(dialect: str, file: str = "") -> None:
    """Raises ProgramError for a dialect that is not known; `file` is the program that was to be read."""
    if dialect not in DIALECTS:
        supported = ", ".join(DIALECTS)
        raise ProgramError(catalogue.DIALECT_UNSUPPORTED, Place(file=file), dialect=dialect, supported=supported)
