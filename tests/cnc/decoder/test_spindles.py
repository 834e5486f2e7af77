"""Spindles in programs: both ways to write them, what is modal, the main spindle, gear stages, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import pytest

from runtime.cnc.blocks import Block, Line, SpindleSetting, Synch, Technology, TechnologyFunction, Wait
from runtime.cnc.decoder import ChannelMemory, SpindleSetup
from runtime.cnc.decoder.setup import GearRange
from runtime.diagnostics.catalogue import language as C  # noqa: N812 - a table of constants
from runtime.diagnostics.catalogue import technology as T  # noqa: N812
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.programs import SETUP as PLAIN
from tests.cnc.decoder.programs import decode, problems

ALL = {3: Synch.MOS, 4: Synch.MOS, 5: Synch.MOS, 19: Synch.MOS}
RANGES = ((50, 560), (400, 800), (700, 3500), (3501, 4000), (3800, 5500), (5400, 7000))  # of the manual, line 22900
GEARS = tuple(GearRange(*speeds) for speeds in RANGES)
SETUP = replace(
    PLAIN,
    spindles=(
        SpindleSetup("S1", Synch.MOS, ALL, area=3, log_axis=6, stages=2),
        SpindleSetup("S2", Synch.MOS, ALL, area=4, log_axis=11),
        SpindleSetup("S3", Synch.MOS, ALL, area=5, log_axis=30, plc=True),
    ),
    log_spindles=(6, 11, 30),
    main_name="S",
    areas={"X": 0, "Y": 1, "Z": 2},
    m_synch={**PLAIN.m_synch, **dict.fromkeys(range(40, 46), Synch.MVS_SVS)},
)


def word(block: Block) -> str:
    """S0.3=1000: M3 of the first spindle with 1000 rev/min; M10@4: on the interface of axis 4; set0 GEAR=1."""
    if isinstance(block, SpindleSetting):
        return f"set{block.spindle} {block.what.name}={block.value:g}"
    if not isinstance(block, TechnologyFunction):
        return type(block).__name__
    if block.kind is Technology.S:
        who = f"S{block.spindle}" if block.spindle >= 0 else f"PLC{block.plc_spindle}"
        angle = f"@{block.angle:g}" if block.number == 19 else ""
        sense = f"/{block.sense}" if block.sense else ""
        return f"{who}.{block.number}={block.value:g}{angle}{sense}{' free' if block.override_off else ''}"
    area = f"@{block.area}" if block.area >= 0 else ""
    value = f"={block.value:g}" if block.value else ""
    return f"{block.kind.name}{block.number}{value}{area}"


def stream(text: str, setup: object = SETUP, memory: ChannelMemory | None = None) -> list[str]:
    run = decode(text, setup, memory=memory)  # type: ignore[arg-type]
    assert run.problem is None, run.problem
    return [word(block) for block in run.blocks[:-1]]


def refused(text: str, setup: object = SETUP) -> ErrorEntry:
    found = problems(text, setup)  # type: ignore[arg-type]
    assert found[0].explained()
    return found[0].entry


@pytest.mark.spec("isg.spdl.m3-m4-m5", "isg.spdl.s-word")
def test_the_example_of_the_manual() -> None:
    text = "S1000\nM03\nM04\nS500\nM05 S300\nM04\nM05\nM03 S1000\nM30"
    assert stream(text) == [
        "S0.0=1000", "S0.3=1000", "S0.4=1000", "S0.0=500", "S0.5=300", "S0.4=300", "S0.5=300", "S0.3=1000",
    ]  # fmt: skip


@pytest.mark.spec("isg.spdl.specific-m3-m4-m5", "isg.spdl.specific-rev")
def test_two_spindles_in_one_block() -> None:
    text = "S[M03 REV1000] S2[M04 REV2000]\nS[M05] S2[REV1500.5]\ns[M04]\nS2[M05]\nS[m05 rev=300]\nX[10] G00 S1[M04] S2[M4]\nM30"
    assert stream(text) == [
        "S0.3=1000", "S1.4=2000", "S0.5=1000", "S1.0=1500.5", "S0.4=1000", "S1.5=1500.5", "S0.5=300",
        "S0.4=300", "S1.4=1500.5", "Line", "BlockEnd",
    ]  # fmt: skip


def test_a_bracket_goes_on_in_the_next_line_and_takes_expressions() -> None:
    assert stream("P1=250\nS[M3 \\\nREV[2*P1] \\\nM19 POS=P1-205]\nM30") == ["S0.19=500@45/3"]
    assert stream("S[2 * 100] M3\nM30") == ["S0.3=200"]  # an expression, no commands


@pytest.mark.spec("isg.spdl.m19-pos")
def test_positioning_and_what_is_modal_of_it() -> None:
    text = (
        "M03 S100\nM19 S.POS 90\nM04\nM19 S200 S.POS=180\nM05 S150\nM19 S1.POS=135\nM03 S300\nM19 S200 S.POS270\n"
        "M03 S400 S.POS45\nM19\nM30"
    )
    assert stream(text) == [
        "S0.3=100", "S0.19=100@90", "S0.4=100", "S0.19=200@180", "S0.5=150", "S0.19=150@135", "S0.3=300", "S0.19=200@270",
        "S0.3=400", "S0.19=400@45",
    ]  # fmt: skip
    assert stream("S100 M19\nM30") == ["S0.19=100@0"]


@pytest.mark.spec("isg.spdl.specific-m19")
def test_positioning_in_brackets() -> None:
    text = (
        "S[REV100 POS45 M19 M3]\nS[M03 REV1000]\nS[M19 M4 REV150]\nS[M05]\nS[M19]\nS[REV200 M19 POS90]\n"
        "S2[POS0 REV10 M19]\nM30"
    )
    assert stream(text) == [
        "S0.19=100@45/3", "S0.3=1000", "S0.19=150@45/4", "S0.5=150", "S0.19=150@45", "S0.19=200@90", "S1.19=10@0",
    ]  # fmt: skip


@pytest.mark.spec("isg.spdl.specific-m19")
def test_behind_m19_a_speed_turns_again_in_the_modal_sense() -> None:
    """The example of line 24640: S[M03 REV200 M19 POS45], then S[REV1000] turns clockwise with 1000."""
    text = "S[M03 REV200 M19 POS45] S2[M04 REV200 POS45 M19]\nS[REV1000] S2[REV1500]\nS[REV1100]\nS[M5]\nS[M19]\nS[REV50]\nM30"
    assert stream(text) == [
        "S0.19=200@45/3", "S1.19=200@45/4", "S0.0=1000/3", "S1.0=1500/4", "S0.0=1100", "S0.5=1100", "S0.19=1100@45",
        "S0.0=50",
    ]  # fmt: skip


@pytest.mark.spec(
    "isg.spdl.specific-mh", "isg.mh.axis-specific-bracket", "isg.mh.additive-value", "hli.tech.axis-specific"
)
def test_functions_in_brackets_go_to_that_interface() -> None:
    setup = replace(SETUP, m_synch={**SETUP.m_synch, 20: Synch.MOS}, h_synch={12: Synch.MOS, 10: Synch.MOS})
    text = "S1000 M3 X100 G00 X[M20 H12=7] Y[H10] M20=-3\nS2[M3 REV300 M10 M20=5]\nS[M10] S2[M10]\nM30"
    assert stream(text, setup) == [
        "S0.3=1000", "M20=-3", "M20@0", "H12=7@0", "H10@1", "Line", "BlockEnd",
        "M10@4", "M20=5@4", "S1.3=300", "M10@3", "M10@4",
    ]  # fmt: skip


@pytest.mark.spec("isg.mh.axis-specific-default", "chan.mh.axis-specific")
def test_a_number_may_belong_to_an_axis_and_a_bracket_wins() -> None:
    setup = replace(SETUP, m_area={10: 2}, h_area={20: 4})
    assert stream("M10 H20\nS[M10]\nX[M10]\nM30", setup) == ["M10@2", "H20@4", "M10@3", "M10@0"]


@pytest.mark.spec("isg.spdl.main-spindle-change", "chan.spindle.main", "isg.spdl.config")
def test_another_main_spindle() -> None:
    text = (
        "S100 M3 S2[REV200 M3]\n#MAIN SPINDLE [S2]\nP1=V.SPDL_PROG.SPEED.S\nS110 M3 S1[REV210 M3]\n#MAIN SPINDLE [11]\nS2=120\n"
        "#MAIN SPINDLE\nS150 M3\nP2=V.SPDL_PROG.SPEED.S2 P3=V.SPDL_PROG.SPEED.S\nM30"
    )
    run = decode(text, SETUP)
    assert run.problem is None, run.problem
    assert [word(block) for block in run.blocks[:-1]] == [
        "S0.3=100", "S1.3=200", "S1.3=110", "S0.3=210", "S1.0=120", "S0.3=150",
    ]  # fmt: skip
    assert run.parameters == {1: 200, 2: 120, 3: 150}


@pytest.mark.spec("chan.spindle.plc", "hli.sp.plc-spindle")
def test_a_spindle_of_the_plc_is_told_on_the_channel() -> None:
    text = "S3[M3 REV500]\nS3[M19 POS=90]\nS3[REV100]\n#MAIN SPINDLE [S3]\nS700 M4\nP1=V.SPDL.PLC_CONTROL.S3\nM30"
    assert stream(text) == ["PLC30.3=500", "PLC30.19=500@90", "PLC30.0=100/3", "PLC30.4=700"]
    assert refused("S3[G130=50]\nM30") is T.PLC_SPINDLE
    assert refused("S3[M3 REV5 M10]\nM30") is T.PLC_SPINDLE
    assert refused("S3[G167 REV5]\nM30") is T.PLC_SPINDLE


@pytest.mark.spec("isg.spdl.sync-priority", "chan.spindle.sync")
def test_of_several_words_one_synchronisation_counts() -> None:
    spindle = SpindleSetup("S", Synch.MNS_SNS, {3: Synch.MVS_SVS, 5: Synch.MOS, 19: Synch.MVS_SNS}, area=3)
    setup = replace(PLAIN, spindles=(spindle,))

    def synch(text: str) -> list[Synch]:
        return [b.synch for b in decode(text, setup).blocks if isinstance(b, TechnologyFunction)]

    assert synch("S100\nM30") == [Synch.MNS_SNS]
    assert synch("S100 M3\nM30") == [Synch.MVS_SVS]
    assert synch("S100 M3 M19\nM30") == [Synch.MVS_SNS]
    assert refused("S100 M4\nM30", setup) is C.SPINDLE_NO_SYNCH


@pytest.mark.spec("isg.spdl.override-g167", "isg.spdl.specific-g167")
def test_override_off() -> None:
    text = "M3 S1000\nG167 S1\nS3000\nS2[G167 REV1000]\nM30"
    assert stream(text) == ["S0.3=1000", "S0.0=1000 free", "S0.0=3000", "S1.0=1000 free"]


@pytest.mark.spec("isg.spdl.override-prog", "isg.spdl.acc-g130")
def test_settings_of_a_spindle() -> None:
    text = "S[OVERRIDE SPEED_FACT=20]\nS[G130=70]\nS2[G135 G136=90]\nS2[G137]\nS2[G135]\nS2[G136=0]\nM30"
    assert stream(text) == [
        "set0 SPEED=0.2", "set0 ACCELERATION=0.7", "set1 FEED_FORWARD=0.9", "set1 FEED_FORWARD=0", "set1 FEED_FORWARD=0.9",
        "set1 FEED_FORWARD=0",
    ]  # fmt: skip


@pytest.mark.spec("isg.spdl.specific-g74")
def test_homing_of_spindles_at_the_same_time() -> None:
    assert stream("M3 S100\nS[G74] S2[G74]\nS200\nM30") == ["S0.3=100", "set0 HOMING=0", "set1 HOMING=0", "S0.0=200"]
    assert refused("S[G74 M3]\nM30") is T.HOMING_WITH_M


def test_gear_data() -> None:
    assert stream("G112 S2\nM3 S9000\nM5\nG112 S1\nM30") == ["set0 GEAR=1", "S0.3=9000", "S0.5=9000", "set0 GEAR=0"]
    assert refused("M3 S100\nG112 S1\nM30") is T.GEAR_TURNING
    assert refused("G112 S3\nM30") is T.GEAR_DATA
    assert refused("G112\nM30") is T.SPINDLE_WORD_NEEDED


def geared(*, automatic: bool, top: bool = False) -> object:
    first = replace(SETUP.spindles[0], gears=GEARS, automatic_gear=automatic, gears_from_top=top)
    return replace(SETUP, spindles=(first,), gear_change=True)


def gears(text: str, setup: object, memory: ChannelMemory | None = None) -> list[str]:
    return [w for w in stream(text, setup, memory) if w.startswith("M4")]


@pytest.mark.spec("isg.spdl.gear-m40-m45", "chan.spindle.gear")
def test_the_stage_follows_from_the_speed() -> None:
    setup = geared(automatic=True)
    assert gears("S650 M03\nS750\nS950\nS1050\nS750\nS500\nM30", setup) == ["M41", "M42", "M40"]
    assert gears("S750 M3\nM30", geared(automatic=True, top=True)) == ["M42"]
    assert gears("M41 S750\nM42 S780\nM30", setup) == ["M41"]  # the present one covers it: no change
    assert refused("S8000\nM30", setup) is T.GEAR_NONE
    assert refused("M40 S750\nM30", setup) is T.GEAR_UNSUITABLE


@pytest.mark.spec("isg.spdl.gear-m40-m45", "chan.spindle.gear")
def test_the_stage_is_programmed() -> None:
    setup = geared(automatic=False)
    text = "M41 S650 M03\nM41 S750\nM42 S950\nM42 S1050\nM41 S750\nM41 S500\nM30"
    assert gears(text, setup) == ["M41", "M42", "M41"]
    assert refused("M41 S650 M3\nM41 S200\nM30", setup) is T.GEAR_UNSUITABLE
    assert refused("M41 S650 M3\nS950\nM30", setup) is T.GEAR_MISSING
    assert refused("S950 M3\nM30", setup) is T.GEAR_MISSING


@pytest.mark.spec("isg.spdl.gear-m40-m45")
def test_a_change_is_told_and_waited_for_before_the_spindle_turns_and_lasts() -> None:
    setup = geared(automatic=True)
    memory = ChannelMemory(setup)  # type: ignore[arg-type]
    assert stream("S650 M3\nM30", setup, memory) == ["set0 GEAR=1", "M41", "S0.3=650", "Wait"]
    assert stream("S700\nM30", setup, memory) == ["S0.0=700"]  # the next program
    assert stream("M41\nM30", SETUP) == ["M41", "Wait"]  # without gear change a function like any other


@pytest.mark.spec("chan.spindle.m-free")
def test_free_functions() -> None:
    setup = replace(SETUP, m_synch={**SETUP.m_synch, 3: Synch.MOS}, spindle_m_free=True)
    assert stream("M3=7\nV.SPDL.M_FCT_FREE = 0\nS10 M3\nV.SPDL.M_FCT_FREE = 1\nM3\nM30", setup) == [
        "M3=7",
        "S0.3=10",
        "M3",
    ]


@pytest.mark.spec("isg.spdl.late-sync-explicit", "chan.mh.mvs-slp")
def test_explicit_synchronisation_waits_for_that_type_only() -> None:
    (wait,) = [block for block in decode("#EXPL SYN\nM30", SETUP).blocks if isinstance(block, Wait)]
    assert wait.kinds == Synch.MVS_SLP


@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("M3 M4 S100\nM30", C.SPINDLE_M_TWICE),
        ("S[M3 M4]\nM30", C.SPINDLE_M_TWICE),
        ("S[M19 M5 REV10]\nM30", C.SPINDLE_M_TWICE),
        ("M19\nM30", T.POSITIONING_SPEED),
        ("S[M19]\nM30", T.POSITIONING_SPEED),
        ("S[REV-1]\nM30", C.SPEED_NEGATIVE),
        ("S9[M3]\nM30", T.BRACKET_NAME),
        ("S[M3 REV]\nM30", T.BRACKET_VALUE_MISSING),
        ("S[M3\nM30", T.BRACKET_OPEN),
        ("X[G74]\nM30", T.AXIS_BRACKET),
        ("S[FEED_LINK ON AUTO]\nM30", T.BRACKET_UNSUPPORTED),
        ("S[CALLAX]\nM30", T.BRACKET_UNSUPPORTED),
        ("S[GET_DYNAMIK_DATA]\nM30", T.BRACKET_UNSUPPORTED),
        ("S[G135 M3]\nM30", T.BRACKET_ALONE),
        ("S[G999]\nM30", T.BRACKET_COMMAND),
        ("S[OVERRIDE SPEED_FACT=201]\nM30", T.BRACKET_VALUE),
        ("S[G136=101]\nM30", T.BRACKET_VALUE),
        ("S[M77]\nM30", C.M_UNDEFINED),
        ("S2=100\nM30", T.NOT_MAIN_SPINDLE),
        ("#MAIN SPINDLE [S9]\nM30", C.SPINDLE_UNKNOWN),
        ("#MAIN SPINDLE [7]\nM30", C.SPINDLE_UNKNOWN),
        ("M3=5 S1\nM30", C.VALUE_NOT_ALLOWED),
        ("S[M3=5]\nM30", C.VALUE_NOT_ALLOWED),
    ],
)
def test_what_is_refused(text: str, entry: ErrorEntry) -> None:
    assert refused(text) is entry


def test_motion_stays_between_its_functions() -> None:
    run = decode("G01 X10 F100 S2[M3 REV10] M13\nM30", SETUP)
    assert [word(b) for b in run.blocks[:-1]] == ["S1.3=10", "Line", "M13", "Wait", "BlockEnd"]
    assert isinstance(run.blocks[1], Line)


@pytest.mark.spec("chan.mh.faw-sync")
def test_a_stop_of_decoding_is_barred_under_radius_compensation() -> None:
    setup = replace(SETUP, m_synch={**SETUP.m_synch, 15: Synch.MVS_SNS | Synch.FAW_SYNCH})
    assert stream("M15\nM30", setup) == ["M15", "Wait", "Flush"]
    assert refused("G41 G01 X10 F100\nX20 M15\nG40 X30\nM30", setup) is T.FLUSH_BARRED


# ---------------------------------------------------------------------------------------------------- both ways to write them


@pytest.mark.spec("isg.spdl.command-scope")
def test_several_spindles_in_a_block_and_one_of_them_without_brackets() -> None:
    assert stream("S1000 M3 S2[M4 REV500]\nM30") == ["S0.3=1000", "S1.4=500"]
    assert stream("S[M3 REV700] S2[REV500 M4] S3[M3 REV100]\nM30") == ["S0.3=700", "S1.4=500", "PLC30.3=100"]
    assert refused("S2=100 M3\nM30") is T.NOT_MAIN_SPINDLE
    assert refused("M19 S2.POS=10 S100\nM30") is T.NOT_MAIN_SPINDLE
    assert stream("#MAIN SPINDLE [S2]\nS2=100 M3\nS1[M3 REV50]\nM30") == ["S1.3=100", "S0.3=50"]


@pytest.mark.spec("isg.spdl.command-scope", "isg.spdl.specific-syntax")
@pytest.mark.parametrize(
    ("inside", "entry"),
    [
        ("G33", T.BRACKET_COMMAND),
        ("G63", T.BRACKET_COMMAND),
        ("G95", T.BRACKET_COMMAND),
        ("G96", T.BRACKET_COMMAND),
        ("G97", T.BRACKET_COMMAND),
        ("G196=500", T.BRACKET_COMMAND),
        ("G112", T.BRACKET_COMMAND),
        ("G331", T.BRACKET_COMMAND),
        ("G01", T.BRACKET_COMMAND),
        ("CALLAX", T.BRACKET_UNSUPPORTED),
        ("PUTAX", T.BRACKET_UNSUPPORTED),
        ("GET_DYNAMIK_DATA", T.BRACKET_UNSUPPORTED),
        ("FEED_LINK ON", T.BRACKET_UNSUPPORTED),
        ("M3 X10", C.ADDRESS_UNKNOWN),
        ("M3 M4", C.SPINDLE_M_TWICE),
        ("M3 REV", T.BRACKET_VALUE_MISSING),
    ],
)
def test_what_no_bracket_takes(inside: str, entry: ErrorEntry) -> None:
    assert refused(f"S2[{inside}]\nM30") is entry


@pytest.mark.spec("isg.spdl.command-scope")
def test_gear_stages_are_for_the_main_spindle_alone() -> None:
    assert refused("S[M41 REV600]\nM30", geared(automatic=True)) is T.BRACKET_UNSUPPORTED


@pytest.mark.spec("isg.spdl.specific-syntax")
def test_a_bracket_in_its_forms() -> None:
    setup = replace(SETUP, m_synch={**SETUP.m_synch, 18: Synch.MOS}, h_synch={20: Synch.MOS})
    together = ["M18@3", "H20@3", "S0.19=500@45/3", "S1.4=5000"]
    assert stream("S[M3 REV500 M19 POS45 M18 H20] S2[M4 REV5000]\nM30", setup) == together
    assert stream("s[m3 rev=500 m19 pos=45 m18 h20] s2[M4 Rev5000]\nM30", setup) == together
    assert stream("S[M3 REV500 \\\nM19 POS45 \\\nM18 H20] S2[M4 \\\nREV5000]\nM30", setup) == together
    assert stream("S1[M3 REV[2 * 250]] G00 X1\nM30", setup) == ["S0.3=500", "Line", "BlockEnd"]
    assert stream("#MAIN SPINDLE [S2]\nS[M3 REV1]\nS2[M4 REV2]\nM30", setup) == ["S1.3=1", "S1.4=2"]
    assert refused("S4[M3 REV1]\nM30", setup) is T.BRACKET_NAME
    assert refused("S[M3 REV1\nM30", setup) is T.BRACKET_OPEN


@pytest.mark.spec("isg.var.spindle-data")
def test_what_variables_tell_of_each_spindle() -> None:
    text = (
        "S300 M3 S2[M4 REV500 POS30]\nG04 S10\nP1=V.SPDL_PROG.SPEED.S P2=V.SPDL_PROG.SPEED.S2 P3=V.SPDL_PROG.SPEED[1]\n"
        "P4=V.SPDL_PROG.MOVE_CMD.S P5=V.SPDL_PROG.MOVE_CMD.S2 P6=V.SPDL_PROG.MOVE_CMD.S3\n"
        "P7=V.SPDL_PROG.POSITION.S2 P8=V.SPDL_PROG.DWELL_ROT_COUNT.S P9=V.SPDL_PROG.GEAR_LINK_ACTIVE.S\n"
        "P10=V.SPDL.LOG_AX_NR.S2 P11=V.SPDL.LOG_AX_NR[2] P12=V.SPDL.PLC_CONTROL.S2 P13=V.SPDL.PLC_CONTROL.S3\n"
        "P14=V.SPDL.NBR_IN_CHANNEL P15=V.SPDL.M_FCT_FREE P16=EXIST[V.SPDL_PROG.SPEED.S2] P17=EXIST[V.SPDL_PROG.SPEED.S9]\n"
        "M5\nG112 S2\nP18=V.SPDL_PROG.MOVE_CMD.S P19=V.SPDL_PROG.GEAR_DATA_STEP.S\n"
        "#MAIN SPINDLE [S2]\nP20=V.SPDL_PROG.SPEED.S P21=V.SPDL_PROG.SPEED.S1\nM30"
    )
    run = decode(text, SETUP)
    assert run.problem is None, run.problem
    assert run.parameters == {
        1: 300, 2: 500, 3: 500, 4: 3, 5: 4, 6: 5, 7: 30, 8: 10, 9: 0, 10: 11, 11: 30, 12: 0, 13: 1, 14: 3, 15: 0, 16: 1, 17: 0,
        18: 5, 19: 2, 20: 500, 21: 300,
    }  # fmt: skip
    for name in ("MAX_SPEED", "CONST_CUT_SPEED", "DWELL_ROT_COUNT"):
        assert refused(f"P1=V.SPDL_PROG.{name}.S2\nM30") is C.VARIABLE_UNSUPPORTED
    assert refused("V.SPDL_PROG.SPEED.S=5\nM30") is C.VARIABLE_READ_ONLY
