"""Compensation registers, tool length and tool offset: programs in, machine positions out."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.cnc.decoder import ChannelMemory
from runtime.cnc.tools.offset_table import MemoryOffsets, Register, SqliteOffsets
from runtime.diagnostics.catalogue import nct, nct_offsets
from tests.cnc.decoder.nct.programs import SETUP, decode, found
from tests.cnc.decoder.nct.test_offsets import ends, numbers

H = {("H", 1): Register(10.0), ("H", 2): Register(830.5, -0.102), ("H", 3): Register(20.0), ("H", 4): Register(-7.0)}
D = {("D", 1): Register(30.0), ("D", 2): Register(5.0), ("D", 3): Register(-5.0), ("D", 4): Register(12.0)}


def memory() -> ChannelMemory:
    return ChannelMemory(SETUP, offsets=MemoryOffsets({**H, **D}))


def path(text: str) -> list[list[float]]:
    return ends(text, memory=memory())


# ---------------------------------------------------------------------------------------------------- registers


@pytest.mark.spec("nct.tool.compensation-memory-h-d")
def test_geometry_and_wear_are_added() -> None:
    assert path("G43 G0 Z0 H2") == [[0, 0, 830.398]]


@pytest.mark.spec("nct.tool.compensation-memory-h-d", "nct.tool.set-compensation-g10")
def test_a_register_is_read_when_it_is_programmed() -> None:
    text = "G43 G0 Z0 H1\nG10 R15 L10 P1\nZ1\nH1 Z1"
    assert path(text) == [[0, 0, 10], [0, 0, 11], [0, 0, 16]]


@pytest.mark.spec("nct.tool.compensation-memory-h-d")
def test_registers_outlive_the_runtime(tmp_path: Path) -> None:
    first = ChannelMemory(SETUP, offsets=SqliteOffsets(tmp_path / "offsets.db"))
    assert decode("G10 R-32.12 L10 P1\nG10 R0.012 L11 P1\nG10 R52.328 L12 P1", memory=first).problem is None
    again = ChannelMemory(SETUP, offsets=SqliteOffsets(tmp_path / "offsets.db"))
    assert ends("G43 G0 Z0 H1", memory=again) == [[0, 0, -32.108]]
    assert again.offsets.register("D", 1) == (52.328, 0)


@pytest.mark.spec("nct.tool.compensation-memory-h-d")
def test_number_zero_and_one_that_was_never_set_are_zero() -> None:
    assert path("G43 G0 Z5 H999\nZ6 H0") == [[0, 0, 5], [0, 0, 6]]


@pytest.mark.spec("nct.tool.set-compensation-g10")
@pytest.mark.parametrize(
    ("number", "kind", "wear"), [(10, "H", False), (11, "H", True), (12, "D", False), (13, "D", True)]
)
def test_g10_sets_or_adds(number: int, kind: str, wear: bool) -> None:
    def stored(text: str) -> float:
        there = memory()
        assert decode(text, memory=there).problem is None
        return there.offsets.register(kind, 7)[wear]

    assert stored(f"G10 R3.5 L{number} P7") == 3.5
    assert stored(f"G10 R3.5 L{number} P7\nG10 RI1 L{number} P7") == 4.5
    assert stored(f"G10 R3.5 L{number} P7\nG91 G10 R-1 L{number} P7") == 2.5
    assert stored(f"G20 G10 R0.5 L{number} P7") == pytest.approx(12.7)


@pytest.mark.spec("nct.tool.set-compensation-g10", "nct.tool.compensation-memory-h-d")
@pytest.mark.parametrize(
    ("text", "entry", "line", "column"),
    [
        ("G10 R10000 L10 P1", nct.VALUE_EXCESS, 1, 5),
        ("G10 R16.381 L11 P1", nct.VALUE_EXCESS, 1, 5),
        ("G10 R-16.381 L13 P1", nct.VALUE_EXCESS, 1, 5),
        ("G10 R9 L13 P1\nG10 RI9 L13 P1", nct.VALUE_EXCESS, 2, 5),
        ("G10 R1 L10 P0", nct.FAULTY_P, 1, 12),
        ("G10 R1 L10 P1000", nct.FAULTY_P, 1, 12),
        ("G10 R1 L10", nct.FAULTY_P, 1, 1),
        ("G10 L10 P1", nct_offsets.VALUE_MISSING, 1, 1),
        ("G0 X1 H1000", nct.VALUE_EXCESS, 1, 7),
    ],
)
def test_errors(text: str, entry: object, line: int, column: int) -> None:
    assert found(text) == (entry, line, column)


# ---------------------------------------------------------------------------------------------------- length


@pytest.mark.spec("nct.tool.length-g43-g44-g49")
def test_g43_adds_and_g44_subtracts() -> None:
    """The example: Z100 with 10 and with 20."""
    assert path("G90 G0\nG43 Z100 H1\nG43 Z100 H3") == [[0, 0, 110], [0, 0, 120]]
    assert path("G44 G0 Z100 H1") == [[0, 0, 90]]
    assert path("G43 G0 Z100 H4") == [[0, 0, 93]]


@pytest.mark.spec("nct.tool.length-g43-g44-g49")
@pytest.mark.parametrize(("code", "z"), [("G43", 10), ("G44", -10)])
def test_an_incremental_zero_moves_by_the_length(code: str, z: float) -> None:
    run = decode(f"G0 {code} G91 Z0 H1", memory=memory())
    assert run.ends == [[0, 0, z]]
    assert numbers(run) == [0, 0, 0]  # the tip is shown where it was


@pytest.mark.spec("nct.tool.length-g43-g44-g49")
def test_several_axes_each_with_its_own() -> None:
    assert path("G0 G43 Z0 H1\nG43 X0 H3\nX0 Z0") == [[0, 0, 10], [20, 0, 10], [20, 0, 10]]
    assert path("G44 G0 X1 Z2 H1") == [[-9, 0, -8]]


@pytest.mark.spec("nct.tool.length-g43-g44-g49")
def test_a_new_h_replaces_the_value() -> None:
    assert path("G0 G43 Z0 H1\nH3 Z0\nH1\nZ0") == [[0, 0, 10], [0, 0, 20], [0, 0, 10]]
    run = decode("G0 G43 Z0 H1\nH3", memory=memory())
    assert run.ends == [[0, 0, 10]]
    assert numbers(run) == [0, 0, -10]  # nothing moves, the position counts anew


@pytest.mark.spec("nct.tool.length-g43-g44-g49")
@pytest.mark.parametrize("word", ["G49", "H0"])
def test_they_cancel_in_every_axis_with_motion_or_without(word: str) -> None:
    moved = f"G0 G43 Z0 H1\nG43 X0 H1\n{word} Z0 X0"
    assert path(moved)[-1] == [0, 0, 0]
    still = decode(f"G0 G43 Z0 H1\nG43 X0 H1\n{word}\nG91 Z1", memory=memory())
    assert still.ends[-1] == [10, 0, 11]
    assert numbers(still) == [10, 0, 11]


@pytest.mark.spec("nct.tool.length-g43-g44-g49")
def test_h0_leaves_the_mode_and_g49_does_not() -> None:
    assert path("G0 G43 Z0 H1\nH0 Z0\nH3 Z0")[-1] == [0, 0, 20]
    assert path("G0 G43 Z0 H1\nG49 Z0\nH3 Z0")[-1] == [0, 0, 0]


@pytest.mark.spec("nct.tool.length-g43-g44-g49")
def test_the_drilling_example_of_the_manual() -> None:
    text = "N1 G90 G0 X500 Y600\nN2 G43 Z410 H5\nN3 G1 Z100 F180\nN4 G4 P2\nN5 G0 Z1100 H0\nN6 X-800 Y-300"
    there = ChannelMemory(SETUP, offsets=MemoryOffsets({("H", 5): Register(400.0)}))
    zs = [end[2] for end in ends(text, memory=there)]
    assert zs == [0, 810, 500, 1100, 1100]


@pytest.mark.spec("nct.tool.length-g43-g44-g49")
def test_it_needs_an_axis() -> None:
    assert found("N1 G43 H1") == (nct_offsets.AXIS_WANTED, 1, 4)


# ---------------------------------------------------------------------------------------------------- offset


@pytest.mark.parametrize(
    ("code", "way", "register", "expected"),
    [
        ("G45", 20, 2, 25), ("G45", 20, 3, 15), ("G45", -20, 2, -25), ("G45", -20, 3, -15),
        ("G46", 20, 2, 15), ("G46", -20, 2, -15), ("G46", 20, 3, 25),
        ("G47", 20, 2, 30), ("G47", -20, 2, -30), ("G48", 20, 2, 10), ("G48", -20, 2, -10),
    ],
)  # fmt: skip
@pytest.mark.parametrize("dimension", ["G90", "G91"])
def test_a_way_is_made_longer_or_shorter(code: str, way: int, register: int, expected: int, dimension: str) -> None:
    assert path(f"G0 X100\nG92 X0\n{dimension} {code} X{way} D{register}")[-1] == [100 + expected, 0, 0]


def test_every_axis_by_itself() -> None:
    """The example: 100 and 40 with 30."""
    assert path("G91 G45 G1 X100 Y40 D1 F100") == [[130, 70, 0]]


@pytest.mark.parametrize(
    ("code", "word", "x"), [("G45", "XI0", 12), ("G46", "XI0", -12), ("G45", "XI-0", -12), ("G46", "XI-0", 12)]
)
def test_the_sign_of_an_incremental_zero_counts(code: str, word: str, x: int) -> None:
    assert path(f"G0 {code} {word} D4") == [[x, 0, 0]]


def test_it_stays_until_it_is_taken_back() -> None:
    assert path("G91 G45 G0 X10 D2\nX10\nG49 X10\nD0 X10\nD2 G46 X10") == [
        [15, 0, 0],
        [25, 0, 0],
        [35, 0, 0],
        [45, 0, 0],
        [50, 0, 0],
    ]


def test_another_register_meanwhile_is_an_error() -> None:
    run = decode("G91 G45 G0 X10 D2\nG45 X10 D1", memory=memory())
    assert run.problem is not None
    assert (run.problem.entry, run.problem.place.line) == (nct_offsets.OFFSET_ERRONEOUS, 2)
    assert path("G91 G45 G0 X10 D2\nG46 X10 D2\nG45 X10 D1")[-1] == [60, 0, 0]


@pytest.mark.parametrize("text", ["G2 G45 X10 I5 F100", "G68 R30\nG45 X1", "N1 G45 D1"])
def test_where_it_cannot_be(text: str) -> None:
    problem = decode(text, memory=memory()).problem
    assert problem is not None
    assert problem.entry in (nct.NOT_SUPPORTED, nct_offsets.AXIS_WANTED)
