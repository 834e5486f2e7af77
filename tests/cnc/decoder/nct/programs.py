"""NCT programs as text in, blocks out."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from runtime.cnc.block_json import Row, rows
from runtime.cnc.blocks import Block, Hold, Synch
from runtime.cnc.decoder import ChannelMemory, DecoderSetup, Outside, ProgramError, load_program
from runtime.cnc.decoder.nct.decoder import NctDecoder
from runtime.cnc.decoder.nct.program import NctProgram
from runtime.cnc.search_target import BlockSearch
from runtime.config.nct import NctParameters
from runtime.diagnostics.errors import ErrorEntry, Problem
from tests.cnc.decoder.programs import SETUP as ISG_SETUP

SETUP = replace(
    ISG_SETUP,
    zero_offsets={},
    m_synch=dict.fromkeys((0, 1, 2, 6, 7, 8, 9, 10, 11, 12, 20, 21, 30), Synch.MOS),
    tool_synch=Synch.MOS,
    nct=NctParameters(codes=("G00",)),
)


class Run:
    """A program that was decoded: its blocks up to the error, if there was one."""

    def __init__(self, decoder: NctDecoder | None, blocks: list[Block], problem: Problem | None) -> None:
        self._decoder = decoder
        self.blocks = blocks
        self.problem = problem

    @property
    def decoder(self) -> NctDecoder:
        assert self._decoder is not None
        return self._decoder

    @property
    def rows(self) -> list[Row]:
        return [row for block in self.blocks for row in rows(block, self.decoder.execution.setup.axes)]

    @property
    def ends(self) -> list[list[float]]:
        """Ends of all motions in machine coordinates."""
        return [list(to.values()) for row in self.rows if isinstance(to := row.get("to"), dict)]

    def of_type(self, *kinds: str) -> list[Row]:
        """Rows of some types."""
        return [row for row in self.rows if row["type"] in kinds]


def decode(
    text: str,
    setup: DecoderSetup = SETUP,
    files: Mapping[str, str] | None = None,
    *,
    start: tuple[float, ...] = (),
    skip: int = 0,
    memory: ChannelMemory | None = None,
    outside: Outside | None = None,
    search: BlockSearch | None = None,
    interrupted: Callable[[], bool] = lambda: False,
    idle_limit: int | None = 10_000,
) -> Run:
    """Decode a program; a program that waits for the outside is asked again until it stops waiting."""
    with tempfile.TemporaryDirectory() as folder:
        for name, content in {"O1000.nc": text, **(files or {})}.items():
            (Path(folder) / name).parent.mkdir(exist_ok=True)
            (Path(folder) / name).write_text(content, encoding="latin-1")
        blocks: list[Block] = []
        decoder = None
        try:
            program = load_program(Path(folder) / "O1000.nc", setup, "nct")
            assert isinstance(program, NctProgram)
            decoder = NctDecoder(
                program,
                setup,
                start=np.array(start or (0.0,) * len(setup.axes)),
                memory=memory,
                outside=outside,
                skip_levels=lambda: skip,
                interrupted=interrupted,
                idle_limit=idle_limit,
                search=search,
            )
            try:
                blocks.extend(block for block in decoder.blocks() if not isinstance(block, Hold))
            finally:
                program.close()
        except ProgramError as error:
            return Run(decoder, blocks, error.problems[0])
        return Run(decoder, blocks, None)


def found(
    text: str, setup: DecoderSetup = SETUP, files: Mapping[str, str] | None = None
) -> tuple[ErrorEntry, int, int]:
    """The first error of a program with its line and column."""
    problem = decode(text, setup, files).problem
    assert problem is not None
    return problem.entry, problem.place.line, problem.place.column
