"""M, H, S and T: what is put out, where it stands around the motion, and where the path waits."""

from __future__ import annotations

from dataclasses import replace

import pytest

from runtime.cnc.blocks import Block, Stop, StopKind, Synch, Technology, TechnologyFunction
from tests.cnc.decoder.programs import SETUP, decode


def stream(text: str) -> list[str]:
    """The blocks as short words: "M10", "S3=500", "Line"."""

    def word(block: Block) -> str:
        if not isinstance(block, TechnologyFunction):
            return block.kind.value if isinstance(block, Stop) else type(block).__name__
        value = f"={block.value:g}" if block.value else ""
        return f"{block.kind.name}{block.number}{value}"

    run = decode(text)
    assert run.problem is None, run.problem
    return [word(block) for block in run.blocks[:-1]]  # without the end of the program


@pytest.mark.spec("chan.mh.mos", "chan.mh.mvs-svs", "chan.mh.mvs-sns", "chan.mh.mns-sns", "isg.mh.user-functions")
@pytest.mark.parametrize(
    ("words", "blocks"),
    [
        ("M10", ["M10", "Line", "BlockEnd"]),
        ("M11", ["M11", "Wait", "Line", "BlockEnd"]),
        ("M12", ["M12", "Line", "Wait", "BlockEnd"]),
        ("M13", ["Line", "M13", "Wait", "BlockEnd"]),
        ("M14", ["Line", "BlockEnd"]),
        ("M13 M12 M11 M10", ["M12", "M11", "M10", "Wait", "Line", "M13", "Wait", "BlockEnd"]),
        ("H20 H21", ["H20", "Line", "H21", "Wait", "BlockEnd"]),
    ],
)
def test_the_synchronisation_decides_the_place(words: str, blocks: list[str]) -> None:
    assert stream(f"G00 X[1] {words}\nM30") == blocks
    assert stream(f"{words} X[1] G00\nM30") == blocks
    assert stream(f"{words}\nM30") == [block for block in blocks if block not in ("Line", "BlockEnd")]


@pytest.mark.spec("isg.mh.user-functions")
def test_numbers_are_rounded_expressions() -> None:
    assert stream("P1 = 10\nMP1\nM[P1 + 0.5]\nH[2 * P1]\nM30") == ["M10", "M11", "Wait", "H20"]


@pytest.mark.spec("isg.mh.additive-value")
def test_additional_values() -> None:
    assert stream("P1 = 7\nM10=-345\nH20=[P1 + 1]\nM10=P1 H20\nM30") == ["M10=-345", "H20=8", "M10=7", "H20"]


@pytest.mark.spec("isg.mh.m00-programmed-stop", "isg.mh.m01-optional-stop")
def test_stops_stand_behind_the_motion() -> None:
    assert stream("G00 X[1] M00\nM01\nM30") == ["Line", "M00", "BlockEnd", "M01"]


def test_reserved_functions_are_put_out_if_configured() -> None:
    setup = replace(SETUP, m_synch={0: Synch.MVS_SNS, 30: Synch.MOS, 17: Synch.MOS})
    run = decode("%L A\nM17\n%M\nLL A\nM00\nM30=5", setup)
    assert [(block.number, block.value) for block in run.blocks if isinstance(block, TechnologyFunction)] == [
        (17, 0),
        (0, 0),
        (30, 5),
    ]
    assert [block.kind for block in run.blocks if isinstance(block, Stop)] == [
        StopKind.PROGRAMMED,
        StopKind.PROGRAM_END,
    ]


def test_spindle_functions() -> None:
    text = "S1000\nM03\nM4\nS500\nM05 S300\nM04\nS[2 * 100] M3\nS=50\nM30"
    assert stream(text) == [
        "S0=1000",
        "S3=1000",
        "Wait",
        "S4=1000",
        "S0=500",
        "S5=300",
        "Wait",
        "S4=300",
        "S3=200",
        "Wait",
        "S0=50",
    ]


def test_spindle_functions_carry_spindle_and_plc_info() -> None:
    (function, *_) = decode("S100 M3\nM30").blocks
    assert isinstance(function, TechnologyFunction)
    assert (function.kind, function.spindle) == (Technology.S, 0)
    assert function.synch == Synch.MVS_SVS | Synch.PLC_INFO


@pytest.mark.spec("isg.mh.tool-select-t", "chan.tool.t-sync")
def test_the_tool_is_told_before_the_tool_change() -> None:
    assert stream("T5 M6\nM6 T[2 + 1]\nM30") == ["T5", "M6", "Wait", "T3", "M6", "Wait"]
    run = decode("T5\nM30", replace(SETUP, tool_synch=Synch.NO_SYNCH))
    assert len(run.blocks) == 1
