"""Exact stop: G60, G360, G359."""

from __future__ import annotations

from dataclasses import replace

import pytest

from runtime.cnc.blocks import Arc, BlockEnd, Dwell, ExactStop, Line, Polyline, TechnologyFunction, Wait
from runtime.cnc.decoder import ProgramError
from runtime.diagnostics.catalogue import language as catalogue
from tests.cnc.decoder.programs import SETUP, decode, problems

pytestmark = pytest.mark.spec("isg.g.exact-stop")


def stops(text: str, **options: object) -> list[list[float]]:
    """The place of each exact stop: X and Y where the path has come to."""
    run = decode(text, **options)  # type: ignore[arg-type]
    assert run.problem is None, run.problem
    places, place = [], [0.0, 0.0]
    for row in run.rows:
        if isinstance(to := row.get("to"), dict):
            place = [to["X"], to["Y"]]
        if row["type"] == "exact stop":
            places.append(place)
    return places


def test_g60_holds_for_its_block() -> None:
    program = "N10 G1 F1000 X0 Y0\nN20 G1 G60 X10\nN30 G1 X20\nN40 G60 Y20\nN50 G1 X30"
    assert stops(program) == [[10, 0], [20, 20]]
    (first, _) = [block for block in decode(program).blocks if isinstance(block, ExactStop)]
    assert (first.source.line, first.source.n) == (2, 20)


def test_g360_holds_until_g359() -> None:
    assert stops("G360\nG1 F1000 X1\nX2\nG0 X3\nG2 X5 I1\nG359 G1 X6\nX7") == [[1, 0], [2, 0], [3, 0], [5, 0]]
    assert stops("G1 F1000 X1\nG360 X2\nX3\nG359\nX4") == [[2, 0], [3, 0]]
    assert stops("G360\nG1 F1000 X1\nG0 X2", setup=replace(SETUP, start_g=(360,))) == [[1, 0], [2, 0]]
    assert stops("G1 F1000 X1", setup=replace(SETUP, start_g=(360,))) == [[1, 0]]


def test_no_move_is_collected_with_the_next_one_and_many_are_again_afterwards() -> None:
    moves = "".join(f"X{x}\n" for x in range(1, 40))
    run = decode("G1 F1000 G360\n" + moves + "G359\n" + moves)
    assert sum(isinstance(block, ExactStop) for block in run.blocks) == 39
    assert sum(isinstance(block, Line) for block in run.blocks) == 39
    assert [len(block.feeds) for block in run.blocks if isinstance(block, Polyline)] == [39]


def test_the_stop_lies_between_the_motion_and_what_comes_behind_it() -> None:
    run = decode("G1 F1000 G60 X1 M11 M13")
    assert [type(block) for block in run.blocks[:7]] == [
        TechnologyFunction, Wait, Line, ExactStop, TechnologyFunction, Wait, BlockEnd,
    ]  # fmt: skip


@pytest.mark.parametrize("corner", ["X10 G301=1\nY10", "X10 #RND=2\nY10", "X10\nG302 I2\nY10"])
def test_a_corner_belongs_to_the_motion_before_it(corner: str) -> None:
    run = decode(f"G1 F1000 G60 {corner}")
    assert run.problem is None, run.problem
    motions = [type(block) for block in run.blocks if isinstance(block, Line | Arc | Polyline | ExactStop)]
    insert = Line if "301" in corner else Arc
    assert motions[:3] == [Line, insert, ExactStop]
    assert len(motions) == 4


def test_a_contour_line_stops_at_its_corner() -> None:
    assert stops("G1 F1000 G60 #ANG=0\n#ANG=90 X10 Y10") == [[pytest.approx(10), pytest.approx(0)]]


def test_blocks_without_motion_do_not_stop_under_g360() -> None:
    run = decode("G360\nG1 F1000\nG92 X5\nM10\nP1 = 1\nG04 1")
    assert not any(isinstance(block, ExactStop) for block in run.blocks)
    assert any(isinstance(block, Dwell) for block in run.blocks)


def test_a_cycle_leaves_the_state_as_it_was() -> None:
    program = "%M\nG1 F1000 X1\nL CYCLE [NAME=C]\nX4\nX5\nM30"
    files = {"C": "G360 X2\nX3\nM17"}
    assert stops(program, files=files) == [[2, 0], [3, 0]]


@pytest.mark.parametrize("block", ["G60", "G60 M10", "G360\nG60", "G92 X1 G60", "G60 F100", "N10 G60 G90"])
def test_g60_without_motion_is_an_error(block: str) -> None:
    (problem,) = problems(f"G1 F1000 X1\n{block}")
    assert problem.entry is catalogue.EXACT_STOP_ALONE
    assert problem.entry.id == 20003
    assert problem.place.column == block.split("\n")[-1].find("G60") + 1


def test_the_functions_exclude_each_other() -> None:
    with pytest.raises(ProgramError) as caught:
        decode("G1 F1000 X1 G60 G360")
    assert caught.value.problem.entry is catalogue.G_GROUP_TWICE
