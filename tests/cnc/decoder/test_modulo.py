"""Axes that turn without end: direction and position of a word, the shorter way, other ranges (manual, line 29123)."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.blocks import IndependentMotion, LimitBehaviour, SoftwareLimitChange
from runtime.cnc.decoder.modulo import modulo_end, wrapped
from runtime.diagnostics.catalogue import axes as errors
from runtime.diagnostics.catalogue import language
from tests.cnc.decoder.programs import SETUP, Run, decode, problems

SETTINGS = replace(
    SETUP,
    axes=("X", "Y", "C"),
    zero_offsets={54: np.array([0.0, 0.0, 30.0])},
    linear=(True, True, False),
    position_limits=((None, None), (None, None), (None, None)),
)
SHORTEST = replace(SETTINGS, always_shortest=True)


def turned(words: str, begin: float = 0.0, setup: object = SETTINGS) -> list[float]:
    """Where C stands behind each motion, in the count of the machine."""
    run = decode(f"G90 F1000\n{words}\nM30", setup, start=(0.0, 0.0, begin))  # type: ignore[arg-type]
    assert run.problem is None, run.problem
    return [end[2] for end in run.ends]


@pytest.mark.spec("isg.modulo.absolute-sign-programming")
@pytest.mark.parametrize("motion", ["G00", "G01", "N10 G01 X5"])
@pytest.mark.parametrize(
    ("word", "begin", "end"),
    [
        ("C+200", 0.0, 200.0),
        ("C-200", 0.0, -160.0),
        ("C+-200", 0.0, 160.0),
        ("C+[-200]", 0.0, 160.0),
        ("C--200", 0.0, -200.0),
        ("C-[-200]", 0.0, -200.0),
        ("C200", 0.0, -160.0),
        ("C[+200]", 0.0, -160.0),
        ("C[-200]", 0.0, 160.0),
        ("C=+200", 0.0, 200.0),
        ("C+560", 0.0, 200.0),
        ("C-P1", 0.0, -350.0),
        ("C+P1", 0.0, 10.0),
        ("C+0", 90.0, 360.0),
        ("C-0", 90.0, 0.0),
        ("C+450", 90.0, 90.0),
        ("C-450", 90.0, 90.0),
        ("C0", 200.0, 360.0),
        ("C10", -350.0, -350.0),
        ("C200", 3600.0, 3440.0),
    ],
)
def test_the_first_sign_is_the_direction_and_the_rest_the_position(
    motion: str, word: str, begin: float, end: float
) -> None:
    assert turned(f"P1=-350\n{motion} {word}", begin)[-1] == pytest.approx(end, abs=1e-9)


@pytest.mark.spec("isg.modulo.absolute-sign-programming")
@pytest.mark.parametrize("sign", ["+", "-", ""])
@given(st.floats(-2000, 2000), st.floats(-1000, 1000).map(lambda v: round(v, 3)))
def test_one_absolute_block_never_turns_more_than_once(sign: str, begin: float, position: float) -> None:
    end = modulo_end(begin, position, 360.0, {"+": 1, "-": -1, "": 0}[sign])
    way = end - begin
    assert math.remainder(end - position, 360.0) == pytest.approx(0.0, abs=2e-6)
    assert abs(way) <= (360.0 if sign else 180.0 + 1e-9)
    assert way >= -2e-6 if sign == "+" else way <= 2e-6 if sign == "-" else True


def test_plain_lines_and_single_blocks_turn_alike() -> None:
    """The fast road of plain lines and the decoder of single blocks read the same program."""
    words = ["C+10", "C-350.5", "C270", "C-0", "C+0", "X5 C90", "C-90", "C+450"]
    plain = "\n".join(f"G01 {word}" for word in words)
    slow = "\n".join(f"G01 {word} P1=1" for word in words)
    ends = turned(plain)
    assert ends == pytest.approx(turned(slow), abs=1e-9)
    assert ends == pytest.approx([10, -9.5, -90, -360, -360, -270, -270, -270], abs=1e-9)
    assert turned("G91\n" + plain) == pytest.approx(turned("G91\n" + slow), abs=1e-9)
    mirrored = "G351 C-1\nG54\n"
    assert turned(mirrored + plain) == pytest.approx(turned(mirrored + slow), abs=1e-9)
    assert turned(plain, setup=SHORTEST) == pytest.approx(turned(slow, setup=SHORTEST), abs=1e-9)


@pytest.mark.spec("isg.modulo.absolute-sign-programming")
def test_a_mirrored_axis_turns_the_other_way() -> None:
    assert turned("G351 C-1\nG01 C+100") == pytest.approx([-100.0])
    assert turned("G54\nG01 C+100\nC+20") == pytest.approx([130.0, 410.0])


@pytest.mark.spec("isg.modulo.absolute-sign-programming")
def test_two_signs_on_another_axis_are_refused() -> None:
    run = decode("G01 F100 X+-5\nM30", SETTINGS)
    assert run.problem is not None
    assert run.problem.entry is errors.TWO_SIGNS
    assert decode("G01 F100 X+5 Y-[-5]\nM30", SETTINGS).ends == [[5.0, 5.0, 0.0]]


@pytest.mark.spec("isg.modulo.incremental-programming")
def test_incremental_amounts_are_not_reduced() -> None:
    run = decode("G91 G01 F100 C+560 \nP1=V.A.ABS.C\nC-800\nC200\nP2=V.A.ABS.C P3=V.A.PROG.C\nM30", SETTINGS)
    assert run.problem is None, run.problem
    assert [end[2] for end in run.ends] == pytest.approx([560.0, -240.0, -40.0])
    assert run.parameters == pytest.approx({1: 200.0, 2: 320.0, 3: 320.0})


@pytest.mark.spec("isg.modulo.incremental-programming")
@pytest.mark.parametrize("word", ["C+-200", "C--200", "C-[P1]", "C+P1"])
def test_a_negative_way_behind_the_sign_is_refused(word: str) -> None:
    run = decode(f"P1=-1\nG91 G01 F100 {word}\nM30", SETTINGS)
    assert run.problem is not None
    assert run.problem.entry is errors.MODULO_NEGATIVE


@pytest.mark.spec("isg.modulo.incremental-programming")
def test_an_endless_count_has_no_end() -> None:
    """215 000 degrees and more, which no other axis may have."""
    ends = turned("$FOR P1 = 1, 3, 1\nG91 G01 C+100000\n$ENDFOR\nG90 C10")
    assert ends[-1] == pytest.approx(300_000 + math.remainder(10 - 300_000, 360.0))


@pytest.mark.spec("isg.modulo.shortest-way-mode", "chan.modulo-shortest")
@pytest.mark.parametrize(
    ("word", "begin", "end"),
    [
        ("C200", 0.0, -160.0),
        ("C+200", 0.0, -160.0),
        ("C-200", 0.0, 160.0),
        ("C--200", 0.0, -160.0),
        ("C+-200", 0.0, 160.0),
        ("C-+200", 0.0, 160.0),
        ("C++200", 0.0, -160.0),
        ("G91 C+200", 60.0, 260.0),
        ("G91 C-200", 60.0, -140.0),
    ],
)
def test_signs_are_arithmetic_where_the_shorter_way_is_always_taken(word: str, begin: float, end: float) -> None:
    assert turned(f"G01 {word}", begin, SHORTEST)[-1] == pytest.approx(end)


@pytest.mark.spec("isg.modulo.variables")
def test_mode_and_range_of_an_axis() -> None:
    run = decode("P1=V.A.MODE[2] P2=V.A.MODULO_VALUE[2] P3=V.A.MODE.X P4=V.A.MODULO_VALUE.X\nM30", SETTINGS)
    assert run.parameters == {1: 4.0, 2: 360.0, 3: 1.0, 4: 0.0}


# ---------------------------------------------------------------------------------------------------- MODULO


@pytest.mark.spec("isg.axis.modulo-command")
def test_the_examples_of_the_manual() -> None:
    first = (
        "G90 G01 F1000\nN100 C[MODULO ON MIN=0 MAX=360]\nN110 C-+700\nP1=V.A.ABS.C\nN120 C[MODULO DEFAULT]\n"
        "N200 C[MODULO OFF]\nN210 X100 C2000\nP2=V.A.ABS.C\nN220 C[MODULO ON MIN=0 MAX=360]\nP3=V.A.ABS.C\n"
        "N230 C-+700\nP4=V.A.ABS.C\nM30"
    )
    run = decode(first, SETTINGS)
    assert run.problem is None, run.problem
    assert [end[2] for end in run.ends] == pytest.approx([-20.0, 1640.0, 1420.0])
    assert run.parameters == pytest.approx({1: 340.0, 2: 2000.0, 3: 200.0, 4: 340.0})
    second = (
        "G90 G01 F1000\nN10 C[MODULO OFF]\nN20 X100 C2000\nN30 C[MODULO SHIFT MIN=0 MAX=360]\nP1=V.A.ABS.C\n"
        "N40 X500 C2000\nP2=V.A.ABS.C\nM30"
    )
    run = decode(second, SETTINGS)
    assert run.problem is None, run.problem
    assert [end[2] for end in run.ends] == pytest.approx([2000.0, 3800.0])
    assert run.parameters == pytest.approx({1: 200.0, 2: 2000.0})


@pytest.mark.spec("isg.axis.modulo-command")
def test_other_ranges_are_kept_until_the_default_and_until_the_end() -> None:
    text = (
        "G90 G01 F1000\nC[MODULO ON MIN=-180 MAX 180]\nC-270\nP1=V.A.ABS.C P2=V.A.MODULO_VALUE.C\n"
        "C[MODULO OFF]\nP3=V.A.ABS.C P4=V.A.MODULO_VALUE.C\nC[MODULO ON]\nC+170\nP5=V.A.ABS.C\n"
        "C[MODULO ON MAX=20]\nP6=V.A.ABS.C P7=V.A.MODULO_VALUE.C\nC[MODULO DEFAULT]\nP8=V.A.MODULO_VALUE.C\nM30"
    )
    run = decode(text, SETTINGS)
    assert run.problem is None, run.problem
    assert run.parameters == pytest.approx({1: -90, 2: 360, 3: -90, 4: 0, 5: 170, 6: -30, 7: 200, 8: 360})
    again = decode("P1=V.A.MODULO_VALUE.C\nM30", SETTINGS)
    assert again.parameters == {1: 360.0}


@pytest.mark.spec("isg.axis.modulo-command")
def test_an_axis_with_limits_can_count_in_turns() -> None:
    limited = replace(SETTINGS, position_limits=((None, None), (None, None), (-900.0, 900.0)))
    text = (
        "G90 G01 F1000\nC700\nC[MODULO ON MIN=0 MAX=360]\nP1=V.A.ABS.C\nC10\nC[MODULO DEFAULT]\nC20\nP2=V.A.ABS.C\nM30"
    )
    run = decode(text, limited)
    assert run.problem is None, run.problem
    assert [end[2] for end in run.ends] == pytest.approx([700.0, 730.0, 740.0])
    assert run.parameters == pytest.approx({1: 340.0, 2: 20.0})


@pytest.mark.spec("isg.axis.modulo-command")
def test_off_with_the_position_of_the_axis() -> None:
    text = "G90 G01 F1000\nC+300\nC+100\nC[MODULO OFF_POS_INIT]\nP1=V.A.ABS.C\nC500\nM30"
    run = decode(text, SETTINGS)
    assert run.problem is None, run.problem
    assert run.parameters == pytest.approx({1: 100.0})
    assert run.ends[-1][2] == pytest.approx(860.0)
    limited = replace(SETTINGS, position_limits=((None, None), (None, None), (-900.0, 900.0)))
    text = "G90 G01 F1000\nC700\nC[MODULO ON]\nC[MODULO OFF_POS_INIT]\nP1=V.A.ABS.C\nM30"
    assert decode(text, limited).parameters == pytest.approx({1: 700.0})


def refused(line: str) -> object:
    run = decode(f"{line}\nM30", SETTINGS)
    assert run.problem is not None, line
    return run.problem.entry


@pytest.mark.spec("isg.axis.modulo-command", "isg.axis.pos-limit", "isg.axis.set-position")
@pytest.mark.parametrize(
    ("line", "entry"),
    [
        ("C[MODULO ON MIN=10 MAX=10]", errors.MODULO_RANGE),
        ("C[MODULO ON OFF]", language.KEY_MISSING),
        ("C[MODULO]", language.KEY_MISSING),
        ("C[MODULO OFF MIN=10]", language.STATEMENT_ARGUMENTS),
        ("C[MODULO ON] X5", language.NOT_ALONE),
        ("C[POS_LIMIT MIN=3]", language.KEY_MISSING),
        ("C[POS_LIMIT ON MIN=3 MAX=2]", language.LIMITS_REVERSED),
        ("X[SET_POSITION]", language.KEY_MISSING),
        ("X[SET_POSITION POS=1 OFFSET=2]", language.KEY_MISSING),
        ("X[SET_POSITION POS=1000000]", language.POSITION_RANGE),
    ],
)
def test_what_is_refused(line: str, entry: object) -> None:
    assert refused(line) is entry


# ---------------------------------------------------------------------------------------------------- POS_LIMIT


def limits_of(run: Run) -> list[tuple[tuple[float, float], LimitBehaviour]]:
    return [(block.limits[2], block.behaviour[2]) for block in run.blocks if isinstance(block, SoftwareLimitChange)]


@pytest.mark.spec("isg.axis.pos-limit")
def test_limits_of_a_program() -> None:
    limited = replace(SETTINGS, position_limits=((None, None), (None, None), (-90.0, 900.0)))
    text = (
        "C[POS_LIMIT ON MIN=-135 MAX=135 BEHAVIOUR=WARNING]\nC[POS_LIMIT DEFAULT]\nC[POS_LIMIT OFF]\n"
        "C[POS_LIMIT ON MAX=100 BEHAVIOUR=ERROR_LR]\nC[POS_LIMIT ON MIN -1]\nM30"
    )
    run = decode(text, limited)
    assert run.problem is None, run.problem
    assert limits_of(run) == [
        ((-135.0, 135.0), LimitBehaviour.WARNING),
        ((-90.0, 900.0), LimitBehaviour.ERROR),
        ((-math.inf, math.inf), LimitBehaviour.ERROR),
        ((-135.0, 100.0), LimitBehaviour.ERROR_LR),
        ((-1.0, 100.0), LimitBehaviour.ERROR),
    ]


@given(st.floats(-1e5, 1e5), st.floats(-1000, 1000), st.floats(0.5, 1000))
def test_a_wrapped_position_is_the_same_place(value: float, low: float, size: float) -> None:
    inside = wrapped(value, low, low + size)
    assert low <= inside < low + size
    turns = (value - inside) / size
    assert turns == pytest.approx(round(turns), abs=1e-6)


@pytest.mark.spec("isg.axis.bracket-syntax")
def test_a_bracket_of_an_axis_in_its_forms() -> None:
    """Case, a missing equals sign, several of them beside words, lines that go on; the keyword stands first."""
    forms = (
        "X[INDP_SYN POS=50 FEED=100] Y[INDP_SYN POS=20 FEED=200] G00 Z5",
        "x[indp_syn pos50 feed100] y[Indp_Syn Pos20 Feed200] G00 Z5",
        "X[INDP_SYN POS=50 \\\n FEED=100] Y[INDP_SYN \\\nPOS=20 FEED=200] G00 Z5",
    )
    told = []
    for text in forms:
        run = decode(f"{text}\nM30")
        assert run.problem is None, run.problem
        told.append(
            [(b.axis, b.target, round(b.velocity * 60.0, 6)) for b in run.blocks if isinstance(b, IndependentMotion)]
        )
    assert told == [[(0, 50.0, 100.0), (1, 20.0, 200.0)]] * 3
    assert decode("G00 X[2 * 5] Y[3]\nM30").ends == [[10.0, 3.0, 0.0]]  # coordinates, and no bracket of commands
    for wrong in ("X[POS=5 INDP_SYN FEED=100]", "X[FEED=100 INDP_SYN POS=5]", "X[INDP_SYN POS=5 FEED=100"):
        assert problems(f"{wrong}\nM30"), wrong
