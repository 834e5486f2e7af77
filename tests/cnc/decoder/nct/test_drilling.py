"""The operations of each drilling cycle against the tables of the manual (lines 5198–5786), as data."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.decoder.nct.drilling import (
    CYCLES,
    Approach,
    Cycle,
    DwellHere,
    Feed,
    Hole,
    OperatorStop,
    Rapid,
    Release,
    Shift,
    StepHere,
    Tap,
    Turn,
    cuts,
    cycle_of,
)

HOLE = Hole(initial=100.0, r=3.0, z=-40.0, cut=10.0, lift=2.0, dwell=True)


def told(code: float, hole: Hole = HOLE, can_orient: bool = False) -> str:
    """A cycle in short: r rapid, f feed, t feed of a thread, M spindle, p dwell, < > shifts, stop, | step."""
    cycle = cycle_of(code, can_orient)
    assert cycle is not None
    words = []
    for step in cycle.steps(hole):
        match step:
            case Approach():
                words.append("hole")
            case StepHere():
                words.append("|")
            case Rapid(level):
                words.append(f"r{level:g}")
            case Feed(level, threads):
                words.append(f"{'t' if threads else 'f'}{level:g}")
            case Tap(level, clockwise):
                words.append(f"{'c' if clockwise else 'a'}{level:g}")
            case Release():
                words.append("free")
            case Turn(order):
                words.append(f"M{order.value}")
            case DwellHere():
                words.append("p")
            case Shift(away):
                words.append("<" if away else ">")
            case OperatorStop():
                words.append("stop")
    return " ".join(words)


WITH_G98 = {
    73: "hole | r3 | f-7 r-5 f-17 r-15 f-27 r-25 f-37 r-35 f-40 r100 |",
    74: "hole | r3 | t-40 M3 t3 M4 r100 |",
    76: "hole | r3 | f-40 p M19 < r100 > M3 |",
    81: "hole | r3 | f-40 r100 |",
    82: "hole | r3 | f-40 p r100 |",
    83: "hole | r3 | f-7 r3 r-5 f-17 r3 r-15 f-27 r3 r-25 f-37 r3 r-35 f-40 r100 |",
    84: "hole | r3 | t-40 M4 t3 M3 r100 |",
    84.2: "hole | r3 | M19 c-40 a3 free M5 r100 |",
    84.3: "hole | r3 | M19 a-40 c3 free M5 r100 |",
    85: "hole | r3 | f-40 f3 r100 |",
    86: "hole | r3 | f-40 M5 r100 M3 |",
    87: "hole | r3 | f-40 M5 stop r100 M3 |",
    88: "hole | r3 | f-40 p M5 stop r100 M3 |",
    89: "hole | r3 | f-40 p f3 r100 |",
}
WITH_G99 = {
    73: WITH_G98[73].replace("r100", "r3"),
    74: "hole | r3 | t-40 M3 t3 M4 |",
    76: "hole | r3 | f-40 p M19 < r3 > M3 |",
    81: "hole | r3 | f-40 r3 |",
    82: "hole | r3 | f-40 p r3 |",
    83: WITH_G98[83].replace("r100", "r3"),
    84: "hole | r3 | t-40 M4 t3 M3 |",
    84.2: "hole | r3 | M19 c-40 a3 free M5 |",
    84.3: "hole | r3 | M19 a-40 c3 free M5 |",
    85: "hole | r3 | f-40 f3 |",
    86: "hole | r3 | f-40 M5 r3 M3 |",
    87: "hole | r3 | f-40 M5 stop r3 M3 |",
    88: "hole | r3 | f-40 p M5 stop r3 M3 |",
    89: "hole | r3 | f-40 p f3 |",
}


@pytest.mark.parametrize("code", sorted(WITH_G98))
def test_to_the_initial_point(code: float) -> None:
    assert told(code) == WITH_G98[code]


@pytest.mark.parametrize("code", sorted(WITH_G99))
def test_to_point_r(code: float) -> None:
    assert told(code, replace(HOLE, to_initial=False)) == WITH_G99[code]


def test_back_boring_goes_through_the_hole_off_the_wall() -> None:
    below = replace(HOLE, r=-45.0, z=-20.0)
    assert told(87, below, can_orient=True) == "hole | M19 < r-45 | > M3 f-20 M19 < r100 > M3 |"


def test_the_dwell_of_a_thread_has_to_be_allowed() -> None:
    assert told(84, replace(HOLE, dwells_in_thread=True)) == "hole | r3 | t-40 p M4 t3 M3 r100 |"


def test_without_p_nothing_dwells() -> None:
    assert told(82, replace(HOLE, dwell=False)) == WITH_G98[81]
    assert told(89, replace(HOLE, dwell=False)) == WITH_G98[85]


def test_cuts_upward_too() -> None:
    assert told(73, Hole(0.0, 10.0, 25.0, cut=10.0, lift=1.0)) == "hole | r10 | f20 r19 f25 r0 |"


def test_a_clearance_greater_than_the_depth_ends_at_r() -> None:
    assert told(83, replace(HOLE, z=-10.0, lift=50.0)) == "hole | r3 | f-7 r3 r3 f-10 r100 |"


holes = st.builds(
    Hole,
    initial=st.floats(50.0, 100.0),
    r=st.floats(0.0, 40.0),
    z=st.floats(-100.0, -1.0),
    cut=st.floats(0.05, 50.0),
    lift=st.floats(0.0, 20.0),
    dwell=st.booleans(),
    to_initial=st.booleans(),
)
OUT = [cycle for code, cycle in CYCLES.items()]


@given(holes, st.sampled_from(OUT))
def test_laws_of_a_hole(hole: Hole, cycle: Cycle) -> None:
    """Rapid moves stay in what is cut already, feed starts at R, Z is reached, not passed, the end is as G98 or G99 says."""
    place, reached = hole.initial, hole.r
    for step in cycle.steps(hole):
        if isinstance(step, Rapid):
            assert step.level >= reached - 1e-9
            place = step.level
        elif isinstance(step, Feed | Tap):
            assert hole.z - 1e-9 <= step.level <= hole.r + 1e-9
            assert place <= hole.r + 1e-9
            place = step.level
            reached = min(reached, place)
    assert reached == hole.z
    assert place == (hole.initial if hole.to_initial else hole.r)


@given(holes)
def test_every_cut_is_q_but_the_last(hole: Hole) -> None:
    for code in (73, 83):
        levels = [step.level for step in CYCLES[code].steps(hole) if isinstance(step, Feed)]
        depths = [a - b for a, b in zip([hole.r, *levels], levels, strict=False)]
        assert len(levels) == cuts(hole)
        assert all(depth == pytest.approx(hole.cut, abs=1e-6) for depth in depths[:-1])
        assert 0 < depths[-1] <= hole.cut + 1e-6
