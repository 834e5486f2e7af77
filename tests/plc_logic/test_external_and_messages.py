"""What a PLC program shares with NC programs: external variables and messages."""

from __future__ import annotations

import math

import pytest

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.hli.external import ExternalVariable, external_area, read_external, size_of, write_external
from runtime.plc_logic import PlcFailure, Program
from runtime.plc_logic.bench import Bench


def variable(path: str, kind: str, offset: int, *dims: int, size: int = 0) -> ExternalVariable:
    size = size or size_of(kind)
    strides = tuple(size * math.prod(dims[i + 1 :]) for i in range(len(dims)))
    return ExternalVariable(path, kind, offset, size, dims, strides, "read_write", False)


VARIABLES = [
    variable("COUNT", "SGN32", 0),
    variable("LENGTH", "REAL64", 24),
    variable("READY", "BOOLEAN", 48),
    variable("NAME", "STRING", 72, size=12),
    variable("GRID[][]", "SGN16", 96, 3, 4),
    variable("TOOL.RADIUS", "REAL64", 120),
    variable("TOOL.EDGE.WEAR[]", "UNS08", 128, 2),
    ExternalVariable("PALLET[].LOADED", "BOOLEAN", 144, 1, (3,), (4,), "read", False),
    ExternalVariable("PALLET[].PARTS[]", "UNS08", 145, 1, (3, 2), (4, 1), "read", False),
]


class Shares(Program):
    """Runs `todo` in every cycle."""

    def setup(self) -> None:
        self.seen: list[object] = []

    def cycle(self) -> None:
        e = self.external
        self.seen = [e.COUNT, e.LENGTH, e.READY, e.NAME, e.GRID[2][3], e.TOOL.RADIUS, e.TOOL.EDGE.WEAR[1]]
        self.seen += [pallet.PARTS[1] for pallet in e.PALLET]
        e.COUNT += 1
        e.LENGTH = 12.5
        e.READY = not e.READY
        e.NAME = "grün"
        e.GRID[1][2] = -7
        e.TOOL.EDGE.WEAR[0] = 300
        e.PALLET[1].LOADED = True


@pytest.mark.spec("hli.area.external-variables")
def test_variables_arrays_and_structures_are_reached_by_name() -> None:
    bench = Bench(Shares, external=VARIABLES)
    area = external_area(bench.hli)
    for offset, kind, value in ((0, "SGN32", -5), (24, "REAL64", 0.1), (96 + 2 * 11, "SGN16", 9), (120, "REAL64", 4.0)):
        assert write_external(area, offset, kind, 8, value)
    area[129] = 17
    area[146], area[150], area[154] = 1, 2, 3
    bench.cycle()
    assert bench.program.seen == [-5, 0.1, False, "", 9, 4.0, 17, 1, 2, 3]
    assert read_external(area, 0, "SGN32", 4) == -4
    assert read_external(area, 24, "REAL64", 8) == 12.5
    assert area[48] == 1
    assert read_external(area, 72, "STRING", 12) == "grün"
    assert read_external(area, 96 + 2 * (1 * 4 + 2), "SGN16", 2) == -7
    assert area[128] == 255
    assert (area[144], area[148], area[152]) == (0, 1, 0)
    bench.cycle()
    assert bench.program.seen[:4] == [-4, 12.5, True, "grün"]


MISTAKES = {
    "CUONT": ("self.external.CUONT = 1", catalogue.PLC_EXTERNAL_NAME, "V.E.CUONT; known: COUNT"),
    "TOOL.RADUIS": ("self.external.TOOL.RADUIS", catalogue.PLC_EXTERNAL_NAME, "V.E.TOOL.RADUIS; known: RADIUS"),
    "index": (
        "self.external.GRID[3]",
        catalogue.PLC_EXTERNAL_INDEX,
        "V.E.GRID has no element 3; indices go from 0 to 2",
    ),
    "inner index": ("self.external.GRID[2][-1] = 0", catalogue.PLC_EXTERNAL_INDEX, "V.E.GRID[2] has no element -1"),
    "text": ("self.external.COUNT = 'x'", catalogue.PLC_EXTERNAL_VALUE, "V.E.COUNT of type SGN32 cannot be 'x'"),
    "number": ("self.external.NAME = 1", catalogue.PLC_EXTERNAL_VALUE, "V.E.NAME of type STRING cannot be 1"),
    "nan": (
        "self.external.PALLET[0].PARTS[1] = float('nan')",
        catalogue.PLC_EXTERNAL_VALUE,
        "V.E.PALLET[0].PARTS[1] of",
    ),
    "whole": ("self.external.TOOL = 1", catalogue.PLC_EXTERNAL_VALUE, "V.E.TOOL of type structure cannot be 1"),
    "whole array": (
        "self.external.PALLET[2].PARTS = 1",
        catalogue.PLC_EXTERNAL_VALUE,
        "V.E.PALLET[2].PARTS of type array",
    ),
    "array": ("self.external.PALLET[0] = 1", catalogue.PLC_EXTERNAL_VALUE, "V.E.PALLET[0] of type structure cannot"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes_tell_what_is_right(mistake: str) -> None:
    code, entry, text = MISTAKES[mistake]

    class Wrong(Program):
        def cycle(self) -> None:
            exec(code, {"self": self})

    bench = Bench(Wrong, external=VARIABLES)
    with pytest.raises(PlcFailure) as caught:
        bench.cycle()
    problem = caught.value.problem
    assert text in f"{problem.text} {caught.value.trace}"
    assert str(entry.id) in f"{problem} {caught.value.trace}"


class Reads(Program):
    """Takes a message when it may."""

    def setup(self) -> None:
        self.may = False
        self.texts: list[tuple[str, bool]] = []

    def cycle(self) -> None:
        message = self.channel.message
        if message is not None and self.may:
            self.texts.append((message.text, message.information))
            message.acknowledge()


def test_messages_wait_until_the_program_acknowledges_them() -> None:
    bench = Bench(Reads)
    bench.message("Text_1")
    bench.message("RED,20,BOLD", information=True)
    bench.run(0.1)
    assert bench.program.texts == []
    assert bench.untaken_messages == 2
    bench.program.may = True
    bench.run(0.02)
    assert bench.program.texts == [("Text_1", False), ("RED,20,BOLD", True)]
    assert bench.untaken_messages == 0


def test_a_reset_withdraws_messages() -> None:
    bench = Bench(Reads)
    bench.message("old")
    bench.run(0.01)
    bench.reset()
    bench.program.may = True
    bench.run(0.01)
    assert bench.program.texts == []
