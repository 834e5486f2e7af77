"""L SEQUENCE: parts of programs, executed as levels of their own."""

from __future__ import annotations

from dataclasses import replace

import pytest

from runtime.cnc.decoder import ProgramError
from runtime.diagnostics.catalogue import language as C  # noqa: N812 - a table of constants
from tests.cnc.decoder.programs import SETUP, decode
from tests.cnc.decoder.test_levels import problem_of, xs

PLAIN = "G00 X0\nN10 X1\nN20 X2\nN30 X3\nN40 X4\n{}\nN90 X9\nM30"
FULL = "G00 X0\nN10 X[1]\nN20 X[2]\nN30 X[3]\nN40 X[4]\n{}\nN90 X9\nM30"


@pytest.mark.spec("isg.sub.sequence-numbers")
@pytest.mark.parametrize("text", [PLAIN, FULL])
@pytest.mark.parametrize(
    ("call", "between"),
    [
        ("L SEQUENCE [N20 N40]", [2, 3, 4]),
        ("L SEQUENCE [N40 N20]", [2, 3, 4]),
        ("L SEQUENCE [N20]", [2]),
        ("L SEQUENCE [N30 N30]", [3]),
        ("L SEQUENCE [N20 REPEAT=3]", [2, 2, 2]),
        ("N50 L SEQUENCE[N[5 * 4], N30, REPEAT 2]", [2, 3, 2, 3]),
        ("L SEQUENCE [N10 N40 REPEAT=2 ENDTAG]", [1, 2, 3, 4, 1, 2, 3, 4]),
        ('L SEQUENCE [NAME="test.nc" N20 N30]', [2, 3]),
        ("L SEQUENCE [N90]", [9]),
    ],
)
def test_sequences_between_block_numbers(text: str, call: str, between: list[float]) -> None:
    assert xs(text.format(call)) == [0, 1, 2, 3, 4, *between, 9]


@pytest.mark.spec("isg.sub.sequence-numbers", "isg.sub.sequence-context")
def test_sequences_of_a_file_and_nested_ones() -> None:
    files = {"sub.nc": "%L A\nX90\nM17\n%SUB\nV.L.GONE = 1\nN50 X5\nN55 LL A\nN60 X6\nN70 X[V.L.GONE]\nM17"}
    assert xs('G00 X0\nL SEQUENCE [NAME="sub.nc" N50 N60 REPEAT=2]\nX1\nM30', files=files) == [0, 5, 90, 6, 5, 90, 6, 1]
    assert problem_of("G00 X0\nL SEQUENCE [NAME=sub.nc N70]\nM30", files=files) is C.VARIABLE_UNSET
    nested = (
        "G00 X0\nN40 L SEQUENCE [N60 N150 REPEAT=2]\nN60 X6\nN90 X9\nN120 X12\n"
        "N130 L SEQUENCE [N90 N120 REPEAT=2]\nN150 X15\nM30"
    )
    once = [6, 9, 12, 9, 12, 9, 12, 15]
    assert xs(nested) == [0, *once, *once, *once]


@pytest.mark.spec("isg.sub.sequence-labels")
@pytest.mark.parametrize(
    ("call", "between"),
    [
        ("L SEQUENCE [[FIRST] [LAST]]", [1, 2, 3]),
        ("L SEQUENCE [[first]]", [1]),
        ("L SEQUENCE [[FIRST] [FIRST] REPEAT=2]", [1, 1]),
        ("L SEQUENCE [[FIRST] [LAST] REPEAT=2 ENDTAG]", [1, 2, 3, 1, 2, 3]),
        ('L SEQUENCE [NAME="sub.nc" [SUP1] [EUP1]]', [21, 22]),
    ],
)
def test_sequences_between_labels(call: str, between: list[float]) -> None:
    text = f"G00 X0\nN20 [FIRST] X1\nX2\n[LAST] X3\n{call}\nX9\nM30"
    assert xs(text, files={"sub.nc": "X20\n[SUP1] X21\n[EUP1] X22\nX23"}) == [0, 1, 2, 3, *between, 9]


@pytest.mark.spec("isg.sub.sequence-endtag")
@pytest.mark.parametrize(
    ("call", "expected"),
    [
        ("L SEQUENCE [N20 N80]", [2, 3, 2, 3, 7, 8, 7, 8, 9]),
        ("L SEQUENCE [N20 N80 ENDTAG]", [2, 3, 2, 3, 7, 8, 9]),
        ("L SEQUENCE [N20 ENDTAG REPEAT=2]", [2, 3, 2, 3, 2, 3, 7, 8, 9]),
        ("L SEQUENCE [N20 N30 ENDTAG]", [2, 3, 2, 3, 7, 8, 9]),
    ],
)
def test_a_sequence_that_contains_its_own_call(call: str, expected: list[float]) -> None:
    assert xs(f"G00 F1\nN20 X2\nN30 X3\nN40 {call}\nN70 X7\nN80 X8\nX9\nM30") == expected


@pytest.mark.spec("isg.sub.sequence-end-command")
@pytest.mark.parametrize(
    ("call", "between"),
    [
        ("L SEQUENCE [N20 BEGIN]", [2, 3]),
        ("L SEQUENCE [[LBL] BEGIN REPEAT=2]", [3, 3]),
        ("L SEQUENCE [N20 N60]", [2, 3, 6]),
        ("L SEQUENCE [N60 BEGIN ENDTAG]", [6]),
        ('L SEQUENCE [NAME="sub.nc" N50 BEGIN REPEAT=2]', [5, 5]),
    ],
)
def test_a_sequence_to_the_end_mark(call: str, between: list[float]) -> None:
    text = f"G00 F1\nN20 X2\nN30 [LBL] X3\nN50 #SEQUENCE END\nN60 X6\n{call}\nX9\nM30"
    assert xs(text, files={"sub.nc": "N50 X5\n#SEQUENCE END\nX4"}) == [2, 3, 6, *between, 9]


@pytest.mark.spec("isg.sub.sequence-numbers", "isg.sub.sequence-labels", "isg.sub.sequence-end-command")
def test_sequences_that_cannot_be() -> None:
    for call, entry in (
        ("L SEQUENCE [N20 N99]", C.SEQUENCE_MISSING),
        ("L SEQUENCE [[NO]]", C.SEQUENCE_MISSING),
        ("L SEQUENCE [N20 REPEAT=0]", C.SEQUENCE_REPEAT),
        ("L SEQUENCE [N20 [A]]", C.SEQUENCE_LIMITS),
        ("L SEQUENCE [N20 N40 BEGIN]", C.SEQUENCE_LIMITS),
        ("L SEQUENCE [REPEAT=2]", C.SEQUENCE_LIMITS),
        ("L SEQUENCE [N20 N30]", C.SEQUENCE_ORDER),
    ):
        assert problem_of(f"G00 X0\nN30 X3\n[A] X1\nN20 X2\nN40 X4\n{call}\nM30") is entry, call
    assert (
        problem_of("L SEQUENCE [NAME=sub.nc N1 BEGIN]\nM30", files={"sub.nc": "N1 P1 = 1\nN2 P1 = 2"})
        is C.SEQUENCE_OPEN
    )
    for text in ("X1 #SEQUENCE END\nM30", "#SEQUENCE END X1\nM30", "X1 L SEQUENCE [N20]\nM30"):
        with pytest.raises(ProgramError):
            decode(text)


@pytest.mark.spec("isg.sub.sequence-context")
def test_loops_and_levels_in_sequences() -> None:
    text = (
        "%L A\nP2 = V.G.PROG_LEVEL\nM17\n%M\nG00 F1\nN20 $FOR P1 = 1, 2, 1\nX[P1]\nN25 LL A\nN30 $ENDFOR\n"
        "L SEQUENCE [N20 N30]\nM30"
    )
    run = decode(text)
    assert [end[0] for end in run.ends] == [1, 2, 1, 2]
    assert run.parameters[2] == 3
    two = replace(SETUP, limits=replace(SETUP.limits, levels=2))
    nested = "N10 L SEQUENCE [{}]\nM30\nN20 L SEQUENCE [N30]\nN30 P1 = 1"
    assert problem_of(nested.format("N30"), two) is None
    assert problem_of(nested.format("N20"), two) is C.CALL_DEPTH


@pytest.mark.spec("isg.sub.sequence-numbers")
def test_a_sequence_goes_back_behind_what_the_index_has_forgotten() -> None:
    text = "G00 X0\nN7 X7\n" + "X[1]\n" * 17_000 + "L SEQUENCE [N7]\nX9\nM30"
    assert xs(text)[-3:] == [1, 7, 9]
