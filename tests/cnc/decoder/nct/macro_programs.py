"""NCT programs as text in, variables and motions out. Axes X Y Z, no offsets; a spindle S."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from runtime.cnc.blocks import Arc, Block, Hold, Line, Polyline, Synch
from runtime.cnc.decoder import ChannelMemory, DecoderSetup, Outside, ProgramError, SpindleSetup
from runtime.cnc.decoder.dialects import load_program
from runtime.cnc.decoder.nct.decoder import NctDecoder
from runtime.cnc.decoder.nct.program import NctProgram
from runtime.config.nct import NctParameters
from runtime.diagnostics.errors import ErrorEntry, Problem

SETUP = DecoderSetup(
    axes=("X", "Y", "Z"),
    linear=(True, True, True),
    spindles=(SpindleSetup("S", Synch.MVS_SVS, {3: Synch.MVS_SVS, 4: Synch.MOS, 5: Synch.MNS_SNS, 19: Synch.MVS_SVS}),),
    m_synch={8: Synch.MOS, 9: Synch.MOS, 20: Synch.MOS, 21: Synch.MOS, 50: Synch.MOS},
    tool_synch=Synch.MOS,
)


def with_parameters(**chosen: object) -> DecoderSetup:
    """The setup with other parameters of the dialect."""
    return replace(SETUP, nct=NctParameters.model_validate(chosen))


class Run:
    """A program that was decoded, up to its error if it had one."""

    def __init__(self, decoder: NctDecoder, blocks: list[Block], problem: Problem | None) -> None:
        self.decoder = decoder
        self.blocks = blocks
        self.problem = problem

    @property
    def ends(self) -> list[tuple[float, ...]]:
        """Ends of all motions."""
        ends: list[tuple[float, ...]] = []
        for block in self.blocks:
            if isinstance(block, Line | Arc):
                ends.append(tuple(round(float(v), 6) for v in block.end))
            elif isinstance(block, Polyline):
                ends += [tuple(round(float(v), 6) for v in point) for point in block.points[1:]]
        return ends

    @property
    def numbers(self) -> list[int | None]:
        """Block numbers of all motions."""
        numbers: list[int | None] = []
        for block in self.blocks:
            if isinstance(block, Line | Arc):
                numbers.append(block.source.n)
            elif isinstance(block, Polyline):
                numbers += [int(n) for n in block.numbers]
        return numbers

    def axis(self, name: str) -> list[float]:
        """Where one axis was sent to by each motion."""
        return [end["XYZ".index(name)] for end in self.ends]

    def value(self, number: int) -> float | None:
        """A common variable at the end."""
        return self.decoder.execution.memory.common.read(number)

    @property
    def place(self) -> tuple[ErrorEntry, int, int]:
        """The error: what, line, column."""
        assert self.problem is not None
        return self.problem.entry, self.problem.place.line, self.problem.place.column


def decode(
    text: str,
    setup: DecoderSetup = SETUP,
    *,
    files: Mapping[str, str] | None = None,
    memory: ChannelMemory | None = None,
    outside: Outside | None = None,
    start: tuple[float, ...] = (0.0, 0.0, 0.0),
    idle_limit: int = 20_000,
    most: int = 100_000,
) -> Run:
    """Decode a program, `most` blocks of it; `files` lie beside it."""
    with TemporaryDirectory() as directory:
        folder = Path(directory)
        for name, content in (files or {}).items():
            (folder / name).write_text(content)
        path = folder / "test.nc"
        path.write_text(text)
        program = load_program(path, setup, "nct")
        assert isinstance(program, NctProgram)
        decoder = NctDecoder(
            program, setup, start=np.array(start), memory=memory, outside=outside, idle_limit=idle_limit
        )  # fmt: skip
        blocks: list[Block] = []
        problem = None
        try:
            blocks.extend(block for block in islice(decoder.blocks(), most) if not isinstance(block, Hold))
        except ProgramError as error:
            problem = error.problem
        finally:
            program.close()
        return Run(decoder, blocks, problem)


def values(
    text: str, *numbers: int, setup: DecoderSetup = SETUP, files: Mapping[str, str] | None = None
) -> list[float | None]:
    """Common variables behind a program without errors."""
    run = decode(f"{text}\nM30", setup, files=files)
    assert run.problem is None, run.problem
    return [run.value(number) for number in numbers]
