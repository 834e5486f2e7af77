"""Axes that turn without end in programs of the NCT dialect: the tables of the manual."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import pytest

from runtime.config.nct import NctParameters
from tests.cnc.decoder.nct.programs import SETUP, decode

C = replace(
    SETUP,
    axes=("X", "Y", "Z", "C"),
    linear=(True, True, True, False),
    zero_offsets={},
    position_limits=((None, None),) * 4,
)
LINEAR = replace(C, position_limits=((None, None),) * 3 + ((-10_000.0, 10_000.0),))
SHORT = replace(C, nct=NctParameters(abshort=("C",)))
ROUND = replace(C, nct=NctParameters(relround=("C",)))


def way(text: str, setup: object = C) -> tuple[list[float], float]:
    """The ways of C, and its position at the end as it is shown."""
    run = decode(text, setup)  # type: ignore[arg-type]
    assert run.problem is None, run.problem
    places = [0.0, *(end[3] for end in run.ends)]
    x = run.decoder.execution
    return [b - a for a, b in pairwise(places)], x.counted(3, places[-1])


@pytest.mark.spec("nct.axes.rotary-rollover")
@pytest.mark.parametrize(
    ("setup", "word", "before", "expected", "shown"),
    [
        (C, "C450", 0, 90, 90), (C, "C0", 90, 270, 0), (C, "C-90", 0, -90, 270), (C, "C-360", 270, -270, 0),
        (SHORT, "C450", 0, 90, 90), (SHORT, "C0", 90, -90, 0), (SHORT, "C-90", 0, -90, 270), (SHORT, "C-360", 270, 90, 0),
    ],
)  # fmt: skip
def test_absolute_positions(setup: object, word: str, before: int, expected: float, shown: float) -> None:
    ways, there = way(f"G90 G0 C{before}\n{word}", setup)
    assert ways[-1] == pytest.approx(expected)
    assert there == pytest.approx(shown)


@pytest.mark.spec("nct.axes.rotary-rollover")
def test_a_motion_never_reaches_a_whole_turn() -> None:
    assert way("G0 C90\nC450")[0][-1] == 0
    assert way("G0 C90\nC-270")[0][-1] == 0
    assert way("G0 C10\nC9.999")[0][-1] == pytest.approx(359.999)


@pytest.mark.spec("nct.axes.rotary-rollover")
@pytest.mark.parametrize(
    ("setup", "word", "expected", "shown"),
    [
        (C, "C450", 450, 90), (C, "C0", 0, 0), (C, "C-90", -90, 270), (C, "C-360", -360, 0),
        (ROUND, "C450", 90, 90), (ROUND, "C0", 0, 0), (ROUND, "C-90", -90, 270), (ROUND, "C-360", 0, 0),
    ],
)  # fmt: skip
def test_incremental_ways(setup: object, word: str, expected: float, shown: float) -> None:
    ways, there = way(f"G91 G0 {word}", setup)
    assert sum(ways) == pytest.approx(expected)
    assert there == pytest.approx(shown)
    assert sum(way(f"G90 G0 {word.replace('C', 'CI')}", setup)[0]) == pytest.approx(expected)


@pytest.mark.spec("nct.axes.rotary-rollover")
def test_an_axis_with_limits_counts_as_a_linear_one() -> None:
    assert way("G90 G0 C450\nC0", LINEAR)[0] == [450, -450]


@pytest.mark.spec("nct.axes.rotary-rollover")
def test_inch_does_not_convert_it() -> None:
    assert way("G20 G90 G0 C90")[0] == [90]


@pytest.mark.spec("nct.axes.rotary-rollover")
def test_behind_many_turns_positions_are_as_before() -> None:
    ways, shown = way("G91 G0 C720\nC10\nG90 C20\nG92 C0\nC5\nG53 C0\nG28 C5")
    assert ways[:4] == pytest.approx([720, 10, 10, 5])
    assert all(abs(w) < 360 for w in ways[4:])
    assert shown == pytest.approx(0)
