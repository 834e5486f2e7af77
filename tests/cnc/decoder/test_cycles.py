"""Cycles: transfer parameters, modal calls, what is restored behind them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from runtime.cnc.decoder import ProgramError
from runtime.diagnostics.catalogue import language as C  # noqa: N812 - a table of constants
from tests.cnc.decoder.programs import SETUP, decode
from tests.cnc.decoder.test_levels import problem_of, warned, xs

DRILL = "%L DRILL\nG91 G00 Z[@P1]\nM17\n"


@pytest.mark.spec("isg.sub.cycle-call", "isg.lex.line-continuation")
@pytest.mark.parametrize(
    "call",
    [
        "LL CYCLE [NAME=C @P1=1 @P2=P5 @P200=2 * [P5 + 1]]",
        'LL CYCLE [@P200=2*[P5+1] @P2=P5 NAME="C" @P1=1]',
        "N10 LL CYCLE [NAME=C, @P1 1, @P2P5, \\\nN20 @P200=2 * [P5 + 1]] (two lines)",
    ],
)
def test_a_cycle_gets_its_transfer_parameters_in_any_order(call: str) -> None:
    text = f"%L C\nP1 = @P1 P2 = @P2 P3 = @P[100 * 2] P4 = V.G.CYCLE_ACTIVE\nM17\n%M\nP5 = 7\n{call}\nP6 = V.G.CYCLE_ACTIVE\nM30"
    run = decode(text)
    assert run.problem is None, run.problem
    assert run.parameters == {1: 1, 2: 7, 3: 16, 4: 1, 5: 7, 6: 0}


@pytest.mark.spec("isg.sub.cycle-call")
def test_a_global_cycle_and_its_mistakes() -> None:
    files = {"c.nc": "G00 X[@P1]\nM17"}
    assert xs("L CYCLE [NAME=c.nc @P1=3]\nM30", files=files) == [3]
    for text, entry in (
        ("G00 X1 L CYCLE [NAME=c.nc]\nM30", C.NOT_ALONE),
        ("L CYCLE [NAME=c.nc] X1\nM30", C.STATEMENT_ARGUMENTS),
        ("L CYCLE [NAME=d.nc]\nM30", C.GLOBAL_MISSING),
        ("LL CYCLE [NAME=c.nc]\nM30", C.LOCAL_MISSING),
        ("L CYCLE [@P1=1]\nM30", C.KEY_MISSING),
        ("L CYCLE [NAME=c.nc @P201=1]\nM30", C.KEY_UNKNOWN),
        ("L CYCLE [NAME=c.nc @P1=1 @P1=2]\nM30", C.KEY_TWICE),
    ):
        with pytest.raises(ProgramError) as caught:
            decode(text, files=files)
        assert caught.value.problem.entry is entry, text
    assert problem_of("L CYCLE [NAME=c.nc MODAL_MOVE MODAL_BLOCK]\nM30", files=files) is C.CYCLE_MODAL
    assert problem_of("P1 = @P1\nM30") is C.TRANSFER_OUTSIDE
    assert problem_of("P1 = V.G.@P[1].VALID\nM30") is C.TRANSFER_OUTSIDE


@pytest.mark.spec("isg.sub.cycle-parameters", "chan.cycles.params")
def test_what_was_not_given() -> None:
    cycle = (
        "%L C\nP2 = V.G.@P[2].VALID P3 = @P2 P4 = V.G.@P[2].VALID P5 = V.G.@P[1].VALID\n@P1 = @P1 + 1\nP6 = @P1\nM17\n"
    )
    run = decode(f"{cycle}%M\nLL CYCLE [NAME=C @P1=5 @P9=1]\nM30")
    assert run.parameters == {2: 0, 3: 0, 4: 0, 5: 1, 6: 6}
    run = decode(f"{cycle}%M\nLL CYCLE [NAME=C @P1=5]\nM30", replace(SETUP, create_transfer=False))
    assert run.problem is not None
    assert (run.problem.entry, run.problem.entry.id) == (C.TRANSFER_MISSING, 20394)


@pytest.mark.spec("isg.sub.cycle-parameters")
def test_transfer_parameters_are_strings_too_and_end_with_the_cycle() -> None:
    text = '%L C\nP1 = IS_STRING[@P1] P2 = IS_NUMBER[@P2] P3 = IS_NUMBER[@P1] P4 = @P1 == "AB"\nM17\n%M\n'
    run = decode(f'{text}LL CYCLE [NAME=C @P1="AB" @P2=12.34]\nM30')
    assert run.problem is None, run.problem
    assert run.parameters == {1: 1, 2: 1, 3: 0, 4: 1}
    assert problem_of(f'{text}LL CYCLE [NAME=C @P1="AB" @P2=12.34]\nP1 = @P2\nM30') is C.TRANSFER_OUTSIDE


def zs(text: str) -> list[tuple[float, float]]:
    run = decode(text)
    assert run.problem is None, run.problem
    return [(end[0], end[2]) for end in run.ends]


@pytest.mark.spec("isg.sub.cycle-modal")
@pytest.mark.parametrize("first", ["X1\nX2", "X[1]\nX[2]"])
def test_a_modal_cycle_follows_each_block_with_motion(first: str) -> None:
    moves = f"G00 X0\nLL CYCLE [NAME=DRILL MODAL_MOVE @P1=-1]\n{first}\nP1 = 1\nM10\n\n(comment)\n#DISABLE MODAL CYCLE\nX3\nM30"
    assert zs(f"{DRILL}%M\n{moves}") == [(0, 0), (0, -1), (1, -1), (1, -2), (2, -2), (2, -3), (3, -3)]
    assert zs(f"{DRILL}%M\n{moves.replace('MODAL_MOVE', 'MODAL')}") == zs(f"{DRILL}%M\n{moves}")


@pytest.mark.spec("isg.sub.cycle-modal")
def test_a_block_modal_cycle_follows_each_block_but_calls_and_control() -> None:
    text = (
        f"%L S\nX9\nM17\n{DRILL}%M\nG00 F1 LL S\nLL CYCLE [NAME=DRILL MODAL_BLOCK @P1=-1]\nX1\nM10\n(nothing)\n\nN5\n"
        "P1 = 1\n$IF P1\n$ENDIF\nLL S\n$GOTO [ON]\n[ON] X2\n#DISABLE MODAL CYCLE\nX3\nM30"
    )
    assert [z for _, z in zs(text)] == [0, -1, -1, -2, -3, -4, -4, -4, -5, -5]


@pytest.mark.spec("isg.sub.cycle-modal")
def test_a_modal_cycle_ends_with_its_level() -> None:
    text = f"{DRILL}%L S\nLL CYCLE [NAME=DRILL MODAL_MOVE @P1=-1]\nX1\nM17\n%M\nG00 LL S\nX2\nX3\nM30"
    assert zs(text) == [(0, -1), (1, -1), (1, -2), (2, -2), (3, -2)]


@pytest.mark.spec("isg.sub.cycle-modal", "isg.add.hash-syntax")
def test_disable_modal_cycle_stands_alone() -> None:
    with pytest.raises(ProgramError) as caught:
        decode("X1 #DISABLE MODAL CYCLE\nM30")
    assert (caught.value.problem.entry, caught.value.problem.place.column) == (C.NOT_ALONE, 4)


@pytest.mark.spec("isg.sub.cycle-modal-state", "chan.cycles.modal")
@pytest.mark.parametrize(
    ("cycle", "main", "setup", "stays"),
    [
        ("", "", SETUP, False),
        ("", "", replace(SETUP, keep_cycle_changes=True), True),
        ("", "V.G.CYCLE_CHANGES_MODAL = TRUE", SETUP, True),
        ("", "V.G.CYCLE_CHANGES_MODAL = FALSE", replace(SETUP, keep_cycle_changes=True), False),
        ("#RETAIN CYCLE CHANGES", "", SETUP, True),
    ],
)
def test_what_a_cycle_leaves_behind(cycle: str, main: str, setup: object, stays: bool) -> None:
    changes = f"%L C\n{cycle}\nG01 G54 G91 G70 F2 X1\nS50 T3\nM17\n"
    text = f"{changes}%M\n{main}\nG00 X10 F100\nLL CYCLE [NAME=C]\nX[1] Y[1]\nM30"
    run = decode(text, setup)  # type: ignore[arg-type]
    assert run.problem is None, run.problem
    x, y, _ = run.ends[-1]
    modal = run.decoder.modal
    assert (x, y) == (pytest.approx((10 + 2 * 25.4, 25.4)) if stays else (1, 1))
    assert (modal.feed, modal.inch, modal.zero_offset) == ((2 * 25.4, True, 1) if stays else (100, False, 0))
    assert (modal.speed, run.decoder.execution.tools.id.basic) == (50, 3)


@pytest.mark.spec("isg.sub.cycle-modal-state")
def test_changes_are_handed_to_the_next_level_only() -> None:
    outer = "%L OUT\nLL CYCLE [NAME=IN]\nX1\nX1\nM17\n%M\nG00\nLL CYCLE [NAME=OUT]\nX1\nM30"
    text = f"%L IN\n#RETAIN CYCLE CHANGES\nG91\nM17\n{outer}"
    assert xs(text) == [1, 2, 1]
    run = decode("#RETAIN CYCLE CHANGES\nM30")
    assert warned(run) == [C.RETAIN_OUTSIDE]
    with pytest.raises(ProgramError):
        decode("#RETAIN CYCLE CHANGES X1\nM30")


@pytest.mark.spec("isg.sub.cycle-neutral-axes")
def test_neutral_names_fit_every_channel() -> None:
    cycle = "%L C\nG91 @X=@P1 @Y@P2 @Z[@P3] F1000 G01\nG02 @X=2 @Y=0 @I=1 @J=0\nG18 G02 @Z=2 @K=1 @S=500\nM17\n%M\n"
    setup = replace(SETUP, axes=("U", "V", "W"))
    run = decode(f"{cycle}LL CYCLE [NAME=C @P1=1 @P2=2 @P3=3]\nM30", setup)
    assert run.problem is None, run.problem
    assert [list(row["to"].values()) for row in run.rows if "to" in row] == [[1, 2, 3], [3, 2, 3], [3, 2, 5]]  # type: ignore[attr-defined]
    assert run.decoder.modal.speed == 500
