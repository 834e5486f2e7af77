"""The function blocks against the timing diagrams and bodies of IEC 61131-3."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.plc_logic import CTD, CTU, CTUD, F_TRIG, R_TRIG, RS, SR, TOF, TON, TP, cycle_at
from runtime.plc_logic.function_blocks import INT_MAX, INT_MIN

Timer = TON | TOF | TP


def diagram(timer: Timer, pins: str, pt: float = 0.3, cycle: float = 0.1) -> tuple[str, list[float]]:
    """Call the timer once per cycle with the level of `pins` ("_" FALSE, "#" TRUE): Q as a line like it, and ET."""
    q, et = "", []
    for i, level in enumerate(pins):
        with cycle_at(1000.0 + i * cycle):
            timer(IN=level == "#", PT=pt)
        q += "#" if timer.Q else "_"
        et.append(round(timer.ET, 6))
    return q, et


@pytest.mark.parametrize(
    ("make", "pins", "q"),
    [
        # on-delay: after PT; a shorter input gives nothing; falls with the input
        (TON, "__######__##__", "_____###______"),
        (TON, "####____####", "___#_______#"),
        # off-delay: rises at once, falls PT after; a new input in between keeps it
        (TOF, "__##______", "__#####___"),
        (TOF, "##__##____", "#########_"),
        (TOF, "__________", "__________"),
        # pulse: PT long whatever the input does; not restarted by an edge inside; needs a new edge afterwards
        (TP, "_#________", "_###______"),
        (TP, "_########_", "_###______"),
        (TP, "_#_#______", "_###______"),
        (TP, "_######_#___", "_###____###_"),
        (TP, "_#___#__#___", "_###_######_"),
    ],
)
def test_timing_diagrams(make: Callable[[], Timer], pins: str, q: str) -> None:
    assert diagram(make(), pins)[0] == q


def test_elapsed_time_of_each_timer() -> None:
    assert diagram(TON(), "_#####_")[1] == [0, 0, 0.1, 0.2, 0.3, 0.3, 0]
    assert diagram(TOF(), "#____#_")[1] == [0, 0, 0.1, 0.2, 0.3, 0, 0]
    assert diagram(TP(), "_#####_")[1] == [0, 0, 0.1, 0.2, 0.3, 0.3, 0]
    assert diagram(TP(), "_#____")[1] == [0, 0, 0.1, 0.2, 0, 0]


def test_a_delay_of_0_follows_at_once() -> None:
    assert diagram(TON(), "_##_", pt=0)[0] == "_##_"
    assert diagram(TOF(), "_##_", pt=0)[0] == "_##_"
    assert diagram(TP(), "_##_", pt=0)[0] == "____"


@given(st.integers(1, 50), st.integers(1, 2000))
def test_a_timer_of_n_cycles_takes_n_cycles(cycle_ms: int, cycles: int) -> None:
    """Not one more: 75 cycles of 4 ms are 0.3 s although the sum of the floats is a little less."""
    timer = TON()
    pt = cycle_ms * cycles / 1000
    for i in sorted({0, cycles - 1, cycles}):
        with cycle_at(i * cycle_ms / 1000):
            timer(IN=True, PT=pt)
        assert (i >= cycles) is timer.Q


def test_pins_keep_their_values_and_the_call_gives_the_block() -> None:
    timer = TON(PT=0.2)
    with cycle_at(0.0):
        assert not timer(IN=True).Q
    with cycle_at(0.2):
        assert timer().Q
    with cycle_at(0.3):
        assert timer(PT=5.0).Q, "reached is reached"


def test_a_timer_outside_of_a_cycle_says_what_to_do() -> None:
    with pytest.raises(RuntimeError, match="cycle_at"):
        TON()(IN=True, PT=1.0)


def levels(block: R_TRIG | F_TRIG, pins: str) -> str:
    return "".join("#" if block(CLK=level == "#").Q else "_" for level in pins)


def test_edges() -> None:
    assert levels(R_TRIG(), "__##_#__") == "__#__#__"
    assert levels(R_TRIG(), "##_#") == "#__#", "TRUE at the first call is an edge: the memory begins FALSE"
    assert levels(F_TRIG(), "##__#_") == "__#__#"
    assert levels(F_TRIG(), "__#_") == "#__#", "FALSE at the first call is one for F_TRIG, by its body"


@pytest.mark.parametrize(
    ("s", "r", "q", "sr", "rs"),
    [
        (False, False, False, False, False),
        (False, False, True, True, True),
        (True, False, False, True, True),
        (False, True, True, False, False),
        (True, True, False, True, False),
        (True, True, True, True, False),
    ],
)
def test_bistables(s: bool, r: bool, q: bool, sr: bool, rs: bool) -> None:
    set_dominant, reset_dominant = SR(), RS()
    set_dominant(S1=q)
    reset_dominant(S=q)
    assert set_dominant(S1=s, R=r).Q1 is sr
    assert reset_dominant(S=s, R1=r).Q1 is rs


def count(block: CTU | CTD | CTUD, calls: Sequence[dict[str, bool]]) -> list[int]:
    return [block(**call).CV for call in calls]


def test_up_counter() -> None:
    counter = CTU(PV=2)
    edge, rest = {"CU": True}, {"CU": False}
    assert count(counter, [edge, edge, rest, edge]) == [1, 1, 1, 2]
    assert counter.Q
    assert count(counter, [rest, {"CU": True, "R": True}, {"CU": True, "R": False}, rest, edge]) == [2, 0, 0, 0, 1]
    assert not counter.Q
    counter.CV = INT_MAX
    assert count(counter, [rest, edge]) == [INT_MAX, INT_MAX]


def test_down_counter() -> None:
    counter = CTD()
    assert counter(CD=False, LD=True, PV=2).CV == 2
    assert not counter.Q
    edge, rest = {"CD": True, "LD": False}, {"CD": False, "LD": False}
    assert count(counter, [edge, rest, edge]) == [1, 1, 0]
    assert counter.Q
    assert count(counter, [rest, edge]) == [0, -1]
    counter.CV = INT_MIN
    assert count(counter, [rest, edge]) == [INT_MIN, INT_MIN]


def test_up_down_counter() -> None:
    counter = CTUD(PV=2)
    assert counter(CU=False).QD
    assert counter(CU=True).CV == 1
    assert (counter.QU, counter.QD) == (False, False)
    assert counter(CU=False, CD=False).CV == 1
    assert counter(CU=True, CD=True).CV == 1, "both edges together cancel"
    assert counter(CU=False, CD=False, LD=True).CV == 2
    assert counter.QU
    assert counter(R=True, LD=True).CV == 0, "reset before load"
    assert counter(R=False, LD=False, CD=True).CV == -1


@given(st.text("_#", max_size=60))
def test_laws_of_the_timers(pins: str) -> None:
    """TON and TOF are each other's mirror; a pulse is never longer than PT and never shorter."""
    mirrored = pins.translate(str.maketrans("_#", "#_"))
    on, _ = diagram(TON(), "_" + pins)
    off_timer = TOF()
    off, _ = diagram(off_timer, "#" + mirrored)
    assert off.translate(str.maketrans("_#", "#_")) == on
    pulses = diagram(TP(), pins + "____")[0].strip("_").split("_")
    assert all(len(pulse) % 3 == 0 for pulse in pulses)
