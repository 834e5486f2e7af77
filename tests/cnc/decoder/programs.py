"""Programs as text in, blocks out: the ground of the decoder's tests."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from runtime.cnc.block_json import Row, rows
from runtime.cnc.blocks import Block, Hold, Synch
from runtime.cnc.decoder import (
    ChannelMemory,
    Decoder,
    DecoderSetup,
    Outside,
    ProgramError,
    SpindleSetup,
    load_program,
)
from runtime.diagnostics.errors import ErrorEntry, Problem
from tests.cnc.decoder.scripted_outside import Machine

SETUP = DecoderSetup(
    axes=("X", "Y", "Z"),
    linear=(True, True, True),
    spindles=(SpindleSetup("S", Synch.MOS, {3: Synch.MVS_SVS | Synch.PLC_INFO, 4: Synch.MOS, 5: Synch.MVS_SNS}),),
    zero_offsets={
        54: np.array([100.0, 10.0, 1.0]),
        55: np.array([200.0, 20.0, 2.0]),
        56: np.array([300.0, 30.0, 3.0]),
        57: np.array([400.0, 40.0, 4.0]),
        58: np.array([500.0, 50.0, 5.0]),
        59: np.array([600.0, 60.0, 6.0]),
    },
    m_synch={
        10: Synch.MOS,
        11: Synch.MVS_SVS,
        12: Synch.MVS_SNS,
        13: Synch.MNS_SNS,
        14: Synch.NO_SYNCH,
        6: Synch.MVS_SVS,
    },
    h_synch={20: Synch.MOS, 21: Synch.MNS_SNS},
    tool_synch=Synch.MOS,
)


class Run:
    """A program that was decoded: its blocks up to the error, if there was one."""

    def __init__(self, decoder: Decoder, blocks: list[Block], problem: Problem | None) -> None:
        self.decoder = decoder
        self.blocks = blocks
        self.problem = problem

    @property
    def rows(self) -> list[Row]:
        return [row for block in self.blocks for row in rows(block, self.decoder.execution.setup.axes)]

    @property
    def ends(self) -> list[list[float]]:
        """Ends of all motions in machine coordinates."""
        return [list(to.values()) for row in self.rows if isinstance(to := row.get("to"), dict)]

    def value(self, variable: str) -> object:
        """A V.P variable at the end."""
        return self.decoder.execution.program_scope.read(variable)

    @property
    def parameters(self) -> dict[int, float]:
        return self.decoder.parameters


def decode(
    text: str | bytes,
    setup: DecoderSetup = SETUP,
    files: Mapping[str, str] | None = None,
    start: tuple[float, ...] = (0.0, 0.0, 0.0),
    skip: int | Callable[[], int] = 0,
    idle_limit: int | None = 100_000,
    outside: Outside | None = None,
    memory: ChannelMemory | None = None,
    name: str = "test.nc",
) -> Run:
    """Decode a program; an error of the decoder ends the blocks, an error of the check is raised.

    `outside` is the machine around, `memory` what an earlier program has left.
    """
    with tempfile.TemporaryDirectory() as directory:
        folder = Path(directory)
        for file, content in (files or {}).items():
            (folder / file).parent.mkdir(parents=True, exist_ok=True)
            (folder / file).write_text(content)
        path = folder / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        program = load_program(path, setup)
        levels = skip if callable(skip) else (lambda: skip)
        decoder = Decoder(
            program,
            setup,
            start=np.array(start),
            memory=memory,
            outside=outside,
            skip_levels=levels,
            idle_limit=idle_limit,
        )
        blocks: list[Block] = []
        problem = None
        try:
            for block in decoder.blocks():
                blocks.append(block)
                if isinstance(block, Hold) and isinstance(outside, Machine):
                    outside.each_hold(outside)
        except ProgramError as error:
            problem = error.problem
        finally:
            program.close()
        return Run(decoder, blocks, problem)


def problems(text: str | bytes, setup: DecoderSetup = SETUP, files: Mapping[str, str] | None = None) -> list[Problem]:
    """All problems of a program, of its check or its execution."""
    try:
        run = decode(text, setup, files)
    except ProgramError as error:
        return list(error.problems)
    return [run.problem] if run.problem else []


def found(text: str | bytes, setup: DecoderSetup = SETUP) -> Iterator[tuple[ErrorEntry, int, int]]:
    """Entry, line and column of each problem."""
    for problem in problems(text, setup):
        yield problem.entry, problem.place.line, problem.place.column


def without_spindle() -> DecoderSetup:
    return replace(SETUP, spindles=())
