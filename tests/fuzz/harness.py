"""One input through the decoder: bytes → program → blocks. Anything but a ProgramError is a find."""

from __future__ import annotations

import tempfile
from pathlib import Path
from types import TracebackType

import numpy as np

from runtime.cnc.blocks import Arc, Block, Line, Polyline
from runtime.cnc.decoder import Decoder, ProgramError, load_program
from tests.cnc.decoder.programs import SETUP

EXECUTED_LIMIT = 2000  # entries, so that loops end
BLOCK_LIMIT = 5000
NAME = "fuzz.nc"


class Harness:
    """Runs inputs, one after the other, as a file in a folder of its own; use it in a `with` block."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix="fuzz-")
        self._path = Path(self._folder.name) / NAME

    def __enter__(self) -> Harness:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._folder.cleanup()

    def run(self, data: bytes) -> int:
        """Check and decode `data`; the count of blocks. Program errors are what is to be: they must be explainable."""
        self._path.write_bytes(data)
        count = 0
        try:
            program = load_program(self._path, SETUP)
            try:
                decoder = Decoder(
                    program,
                    SETUP,
                    start=np.zeros(len(SETUP.axes)),
                    interrupted=lambda: decoder.executed > EXECUTED_LIMIT or count > BLOCK_LIMIT,
                )
                for block in decoder.blocks():
                    count += 1
                    _require_finite(block)
                    if count > BLOCK_LIMIT:
                        break
            finally:
                program.close()
        except ProgramError as error:
            for problem in error.problems:
                if not problem.explained() or not str(problem):
                    raise AssertionError(f"{problem!r} says nothing") from error
        return count


def _require_finite(block: Block) -> None:
    """No number that is none may become a position."""
    if isinstance(block, Polyline):
        positions = block.points
    elif isinstance(block, Line | Arc):
        positions = block.end
    else:
        return
    if not np.isfinite(positions).all():
        raise AssertionError(f"a position that is no number: {block}")
