"""The frame of a program, skipped blocks, functions and their order, subprograms and jumps."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from runtime.cnc.blocks import SearchMark, StopKind, Synch
from runtime.cnc.decoder import DecoderSetup, ProgramErrors, load_program, look_through
from runtime.cnc.decoder.memory import ChannelMemory
from runtime.cnc.decoder.nct.decoder import NctDecoder
from runtime.cnc.decoder.nct.program import NctProgram
from runtime.cnc.decoder.nct.registry import Group
from runtime.cnc.search_target import BlockSearch, SearchKind
from runtime.config.nct import NctParameters
from runtime.diagnostics.catalogue import language
from runtime.diagnostics.catalogue import nct as C  # noqa: N812
from runtime.diagnostics.errors import Severity
from tests.cnc.decoder.nct.programs import SETUP, Run, decode


def xs(run: Run) -> list[float]:
    """The X of all targets."""
    assert run.problem is None, run.problem
    return [end[0] for end in run.ends]


# -- frame ---------------------------------------------------------------------------------------------------------


@pytest.mark.spec("nct.lexis.program-format")
@pytest.mark.parametrize(
    "text",
    [
        "%O1234(NAME)\nG0 X1\nX2\nM30\n%\n",
        "%\nO1234 (SIXTEEN LETTERS)\nG0 X1\nX2\n%\n",
        "%\r\nO1234\r\nG0 X1\r\nX2\r\nM2\r\n%\r\n",
        "G0 X1\nX2\n",
        "(a comment first)\n\nG0 X1 (in between) X2\nX2",
        "O1234\nG0 X1\nX2\nO1235\nX3\n",
        "%O1234\nG0 X1\nX2\n%\ntrailer\n%O1235\nX3\n%",
    ],
)
def test_frames(text: str) -> None:
    if "in between" in text:
        text = text.replace(" X2\n", "\n", 1)
    assert xs(decode(text)) == [1, 2]


@pytest.mark.spec("nct.lexis.block-skip")
def test_blocks_are_skipped_by_their_switch() -> None:
    text = "G0 X1\n/1 X2\n/ X3\n/2N40X4\n/9 X5\nX6\n"
    assert xs(decode(text)) == [1, 2, 3, 4, 5, 6]
    assert xs(decode(text, skip=1)) == [1, 4, 5, 6]
    assert xs(decode(text, skip=2)) == [1, 2, 3, 5, 6]
    assert xs(decode(text, skip=1 << 8)) == [1, 2, 3, 4, 6]


def test_a_program_of_any_length_is_not_read_ahead(tmp_path: Path) -> None:
    path = tmp_path / "long.nc"
    path.write_text("G0 X1\n" * 60_000 + "X?\n")
    program = load_program(path, SETUP, "nct")
    assert isinstance(program, NctProgram)
    blocks = NctDecoder(program, SETUP, start=np.zeros(3)).blocks()
    next(blocks)
    program.close()
    path.write_text("G0 X1\nX?\n")  # a short one is looked through before it starts
    with pytest.raises(ProgramErrors):
        load_program(path, SETUP, "nct")


def test_lines_across_the_parts_that_are_read() -> None:
    """Parts of 64 kB are read at a time; lines lie across their borders."""
    count = 9000
    run = decode("".join(f"G0 X{number % 1000} (comment)\n" for number in range(count)), idle_limit=None)
    assert xs(run) == [number % 1000 for number in range(count)]


# -- functions -----------------------------------------------------------------------------------------------------


def order(run: Run) -> list[str]:
    assert run.problem is None, run.problem
    names = []
    for row in run.rows:
        kind = str(row["type"])
        if kind in "mhst":
            names.append(f"{kind.upper()}{row['number']}")
        elif kind in ("line", "stop"):
            names.append(kind if kind == "line" else str(row["kind"]))
    return names


@pytest.mark.spec("nct.mh.execution-sequence", "nct.tool.t-code")
def test_functions_come_in_the_order_of_the_control() -> None:
    run = decode("G0 X1 M20 M8 S500 M3 T7 M11 M6\nM30\n")
    assert order(run) == ["M6", "T7", "M11", "S3", "M8", "M20", "line", "M30", "M30"]
    assert run.of_type("s")[0]["value"] == 500


def test_functions_stand_where_their_synchronisation_says() -> None:
    setup = replace(SETUP, m_synch={**SETUP.m_synch, 21: Synch.MNS_SNS})
    assert order(decode("G0 X1 M21\nM30\n", setup)) == ["line", "M21", "M30", "M30"]


def test_speeds() -> None:
    rows = decode("S1000 M3\nS2000\nM5\nM4\nM30\n").of_type("s")
    assert [(row["number"], row["value"]) for row in rows] == [(3, 1000), (0, 2000), (5, 2000), (4, 2000)]
    problem = decode("S1000\n", replace(SETUP, spindles=())).problem
    assert problem is not None
    assert problem.entry is language.SPINDLE_MISSING


@pytest.mark.spec("nct.spindle.orientation-m19")
def test_the_spindle_stands_at_its_zero_with_m19() -> None:
    spindle = replace(SETUP.spindles[0], m=dict.fromkeys((3, 4, 5, 19), Synch.MOS))
    setup = replace(SETUP, spindles=(spindle,))
    rows = decode("S100 M3\nM19\nM3\nM30\n", setup).of_type("s")
    assert [(row["number"], row.get("angle", 0.0)) for row in rows] == [(3, 0.0), (19, 0.0), (3, 0.0)]


def test_functions_that_the_channel_does_not_have() -> None:
    problem = decode("M99 P1\nN1 M21 M5\nM77\n").problem
    assert problem is not None
    assert (problem.entry, problem.place.line) == (language.M_UNDEFINED, 3)


def test_stops_and_ends() -> None:
    assert order(decode("G0 X1 M0\nX2 M1\nM2\nX3\n")) == ["M0", "line", "M00", "M1", "line", "M01", "M2", "M30"]
    assert order(decode("G0 X1\n")) == ["line", "M30"]
    run = decode("G91 G0 X1 M0\nX1\n")  # all that is modal stays
    assert xs(run) == [1, 2]
    assert run.of_type("stop")[0]["kind"] == StopKind.PROGRAMMED.value


@pytest.mark.spec("nct.mh.auxiliary-a-b-c")
def test_addresses_that_are_functions() -> None:
    setup = replace(
        SETUP,
        axes=("X", "Y", "Z", "A"),
        linear=(True, True, True, False),
        nct=NctParameters(miscel={"A": 20, "C": 21}),
    )
    rows = decode("G0 X1 C5 A90 M8\nM30\n", setup).of_type("h", "m")
    assert [(row["type"], row["number"], row.get("value", 0)) for row in rows] == [
        ("m", 8, 0),
        ("h", 20, 90),
        ("h", 21, 5),
        ("m", 30, 0),
    ]
    for text, entry in (("A1000\n", C.VALUE_EXCESS), ("A-1\n", C.VALUE_EXCESS), ("AI5\n", C.ADDRESS_RIGHT)):
        problem = decode(text, setup).problem
        assert problem is not None
        assert problem.entry is entry


# -- subprograms ---------------------------------------------------------------------------------------------------

SUB = "O0011\nG91 G0 X1\nG90\nM99\n"


@pytest.mark.spec("nct.sub.call-m98")
def test_subprograms_in_the_file_and_in_files_beside_it() -> None:
    text = "O0010\nG0 X10 M98 P11\nX5\nM98 P11 L3\nM30\n"
    expected = [10, 11, 5, 6, 7, 8]
    assert xs(decode(text + SUB)) == expected
    for name in ("O0011.nc", "O0011", "0011.NC", "o0011.nct"):
        assert xs(decode(text, files={name: SUB})) == expected
    assert xs(decode(text, files={"O0011.nc": "G91 G0 X1\nG90\n"})) == expected  # one without a number, without M99
    assert xs(decode(text, files={"sub/O0011.nc": SUB}, setup=folders("sub"))) == expected


def folders(name: str) -> DecoderSetup:
    return replace(SETUP, program_paths=(Path(name),))


@pytest.mark.spec("nct.sub.call-m98")
def test_subprograms_lie_four_deep() -> None:
    def nested(levels: int) -> str:
        subs = "".join(f"O{n:04d}\nM98 P{n + 1}\nG0 X{n}\nM99\n" for n in range(1, levels))
        return f"O1000\nM98 P1\nM30\n{subs}O{levels:04d}\nG0 X{levels}\nM99\n"

    assert xs(decode(nested(4))) == [4, 3, 2, 1]
    problem = decode(nested(5)).problem
    assert problem is not None
    assert problem.entry is C.LEVEL_EXCESS


@pytest.mark.spec("nct.sub.return-m99")
def test_a_return_may_lead_to_a_block_and_change_the_count() -> None:
    main = "O0010\nM98 P11{}\nG0 X50\nN250 X60\nM30\n"
    assert xs(decode(main.format("") + "O0011\nG0 X1\nM99 P250\n")) == [1, 60]
    assert xs(decode(main.format(" L20") + "O0011\nG91 G0 X1\nG90\nM99 L5\n")) == [1, 2, 3, 4, 5, 6, 50, 60]
    assert xs(decode(main.format(" L2") + "O0011\nG91 G0 X1\nG90\nM99 L0\n")) == [1, 50, 60]
    assert xs(decode(main.format("") + "O0011\nG91 G0 X1\nG90\nM99 P250 L2\n")) == [1, 2, 3, 60]
    problem = decode(main.format("") + "O0011\nG0 X1\nM99 P251\n").problem
    assert problem is not None
    assert (problem.entry, problem.place.line) == (C.NO_BLOCK, 8)
    problem = decode(main.format("") + "O0011\nG0 X1\nM99 L10000\n").problem
    assert problem is not None
    assert problem.entry is C.VALUE_EXCESS


@pytest.mark.spec("nct.sub.main-jump-m99", "nct.lexis.sequence-number")
def test_jumps_in_the_main_program() -> None:
    assert xs(decode("G0 X1\nM99 P128\nN225 X4\nM30\nN128 X2\nM99 P225\n")) == [1, 2, 4]
    # forward first, then from the start; a number that is not first is none
    assert xs(decode("N5 G0 X1\nM99 P5\nX2\nN5 X3\nM30\n")) == [1, 3]
    run = decode("N1 G91 G0 X1\n/1 M99\nM30\n", skip=1)
    assert xs(run) == [1]
    left = iter(range(50))
    run = decode("N1 G91 G0 X1\n/1 M99\nM30\n", interrupted=lambda: next(left, None) is None)
    assert run.problem is None  # it goes on for ever: who drives it has to end it
    assert len(run.ends) > 50


def test_a_loop_without_output_does_not_hold_anybody() -> None:
    problem = decode("N1 G90\nM99\n", idle_limit=1000).problem
    assert problem is not None
    assert problem.entry is language.ENDLESS_LOOP


# -- what holds at the start ---------------------------------------------------------------------------------------


@pytest.mark.spec("nct.lexis.g-code-groups", "nct.config.initial-state")
def test_what_holds_at_program_start() -> None:
    active = decode("M30\n", replace(SETUP, nct=NctParameters())).decoder.execution.active
    marked = {  # the starred codes of the table; where several have a star, those of `codes`
        Group.MOTION: 0, Group.PLANE: 170, Group.DIMENSION: 900, Group.FEED_MODE: 940, Group.UNIT: 210,
        Group.COMPENSATION: 400, Group.LENGTH: 490, Group.CYCLE: 800, Group.RETURN_LEVEL: 980, Group.SCALING: 500,
        Group.WORK_OFFSET: 540, Group.FEED_CONTROL: 640, Group.ROTATION: 690, Group.POLAR: 150, Group.MIRROR: 501,
    }  # fmt: skip
    assert {group: active.get(group) for group in marked} == marked
    chosen = NctParameters(codes=("G01", "G18", "G20", "G91", "G95"), feed=5.0)
    x = decode("M30\n", replace(SETUP, nct=chosen)).decoder.execution
    groups = (Group.MOTION, Group.PLANE, Group.UNIT, Group.DIMENSION, Group.FEED_MODE)
    assert [x.active[group] for group in groups] == [10, 180, 200, 910, 950]


@pytest.mark.spec("nct.config.initial-state")
def test_what_a_program_leaves_behind() -> None:
    """Shifts, compensation, cycles and modal codes end with M30; offsets, #500 and the unit of the input stay, #100 too."""
    memory = ChannelMemory(SETUP)
    first = (
        "G20 G10 L2 P1 X1\nG52 X5\nG92 Y3\nG91 G16 G61 G95 F1 S100\n#100=7\n#500=8\n#3003=1\n#3004=3\n"
        "G98 G81 G90 X1 Y2 Z-1 R1 F0.1\nM30\n"
    )
    assert decode(first, memory=memory).problem is None
    run = decode("#1=#3003+#3004\nG0 X2 Y[#100+#500+#1]\nX3\nM30\n", memory=memory)
    assert run.problem is None
    inch = 25.4
    assert run.ends == [pytest.approx([3 * inch, 15 * inch, 0]), pytest.approx([4 * inch, 15 * inch, 0])]  # G54 X1 inch
    assert not run.of_type("dwell")
    missing = decode("G1 X1\nM30\n", memory=memory).problem  # the feed begins anew
    assert missing is not None
    assert missing.entry is language.FEED_MISSING


# -- search, look through ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "value", "passes", "line"),
    [
        (SearchKind.LINE, 3, 1, 3),
        (SearchKind.BLOCK_NUMBER, 20, 1, 2),
        (SearchKind.FILE_OFFSET, 7, 1, 2),
        (SearchKind.BLOCK_NUMBER, 7, 2, 6),
    ],
)
def test_block_search_marks_the_place(kind: SearchKind, value: int, passes: int, line: int) -> None:
    text = "G0 X1\nN20 X2\nX3\nM98 P2 L3\nO0002\nN7 X4\nM99\n"
    run = decode(text, search=BlockSearch(kind, value, passes, "O1000.nc"))
    assert run.problem is None
    marks = [block.source.line for block in run.blocks if isinstance(block, SearchMark)]
    assert marks == [line]


def test_what_may_be_passed_over_is_a_warning(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    path.write_text("G0 X1\n/1 X?\nX2 Y(\nM99 P3\nX?\nN3 M30\n")
    found = [(p.entry, p.place.line, p.entry.severity) for p in look_through(path, SETUP, dialect="nct")]
    assert [(line, severity) for _, line, severity in found] == [
        (2, Severity.WARNING),
        (3, Severity.ERROR),
        (5, Severity.WARNING),
    ]
