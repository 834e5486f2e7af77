"""What each drilling cycle does, as data: the ten operations of the frame as a list of steps (manual lines 4977–5831).

    1 to the hole, rapid          ─┐ single block stops behind 1, 3 and 10
    2 what is done there           │
    3 to point R, rapid           ─┘            initial point ──────── 9, 10
    4 what is done there                        R ──────────────── 4 ─ 7, 8
    5 drilling to Z, with feed                  │ 5
    6 what is done at the bottom                Z ──────────────── 6
    7 back to R
    8 what is done there
    9 to the initial point, rapid  ─┐ with G98 only
    10 what is done there          ─┘

Places along the drilling axis are machine coordinates, mm or degrees. Nothing here knows of axes, planes or spindles.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum

Steps = Iterator["Step"]


@dataclass(frozen=True, slots=True)
class Hole:
    """A hole: its levels along the drilling axis, and the data of the cycle.

    `initial`, `r`, `z`: levels. `cut`: Q, depth of a cut, above 0 for G73 and G83; `lift`: E, or the default of the channel.
    `dwell`: whether P was given. `to_initial`: G98. `dwells_in_thread`: TAPDWELL.
    """

    initial: float
    r: float
    z: float
    cut: float = 0.0
    lift: float = 0.0
    dwell: bool = False
    to_initial: bool = True
    dwells_in_thread: bool = False

    @property
    def sense(self) -> float:
        """+1 or -1: the sense from R to Z."""
        return math.copysign(1.0, self.z - self.r)


def cuts(hole: Hole) -> int:
    """How many cuts G73 and G83 make of a hole; a last one of no depth is none."""
    return max(1, math.ceil(abs(hole.z - hole.r) / hole.cut - 1e-9))


# -- steps ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Approach:
    """Operation 1: to the hole in the plane, rapid; behind it comes what else stands in the block."""


@dataclass(frozen=True, slots=True)
class Rapid:
    """Along the drilling axis to a level, rapid. `first`: the move to R, in which a new length compensation is taken up."""

    level: float
    first: bool = False


@dataclass(frozen=True, slots=True)
class Feed:
    """Along the drilling axis to a level, with feed. `threads`: feed at 100 %, and no stop (operations 5 to 7 of G74 and G84)."""

    level: float
    threads: bool = False


@dataclass(frozen=True, slots=True)
class Shift:
    """The tool off the wall by I, J, K in the plane, rapid (`away`), or back."""

    away: bool


@dataclass(frozen=True, slots=True)
class DwellHere:
    """The dwell P."""

    threads: bool = False


@dataclass(frozen=True, slots=True)
class Tap:
    """Along the drilling axis to a level, with the spindle turning by the pitch: clockwise, or the other way round."""

    level: float
    clockwise: bool


@dataclass(frozen=True, slots=True)
class Release:
    """The spindle and the drilling axis no longer move together; the spindle stands."""


class Spindle(Enum):
    """What the spindle does; by its M function."""

    CLOCKWISE = 3
    COUNTER_CLOCKWISE = 4
    STOP = 5
    ORIENT = 19


@dataclass(frozen=True, slots=True)
class Turn:
    """An order to the spindle, which the path waits for."""

    order: Spindle
    threads: bool = False


@dataclass(frozen=True, slots=True)
class OperatorStop:
    """The path stands, the operator moves the tool by hand, START goes on from where it stands then."""


@dataclass(frozen=True, slots=True)
class StepHere:
    """Single block stops here."""


Step = Approach | Rapid | Feed | Tap | Release | Shift | DwellHere | Turn | OperatorStop | StepHere


# -- parts that cycles share ---------------------------------------------------------------------------------------


def _to_r(hole: Hole) -> Steps:
    """Operations 1 and 3."""
    yield Approach()
    yield StepHere()
    yield Rapid(hole.r, first=True)
    yield StepHere()


def _out_from_bottom(hole: Hole) -> Steps:
    """Operations 7 and 9 in one rapid move: G99 to R, G98 to the initial point."""
    yield Rapid(hole.initial if hole.to_initial else hole.r)


def _out_from_r(hole: Hole) -> Steps:
    """Operation 9 behind an operation 7 with feed."""
    if hole.to_initial:
        yield Rapid(hole.initial)


def _dwell(hole: Hole) -> Steps:
    if hole.dwell:
        yield DwellHere()


def _pecks(hole: Hole) -> Iterator[float]:
    """The depths that are cut to, one after the other, the last one is Z."""
    for count in range(1, cuts(hole)):
        yield hole.r + hole.sense * count * hole.cut
    yield hole.z


# -- the cycles ----------------------------------------------------------------------------------------------------


def high_speed_peck(hole: Hole) -> Steps:
    """G73: lifted by E between the cuts; each cut is Q further than the one before."""
    yield from _to_r(hole)
    for level in _pecks(hole):
        yield Feed(level)
        if level != hole.z:
            yield Rapid(level - hole.sense * min(hole.lift, abs(level - hole.r)))
    yield from _out_from_bottom(hole)
    yield StepHere()


def peck(hole: Hole) -> Steps:
    """G83: out to R after each cut, and back in rapid until E before the depth that was reached."""
    yield from _to_r(hole)
    for level in _pecks(hole):
        yield Feed(level)
        if level != hole.z:
            yield Rapid(hole.r)
            yield Rapid(level - hole.sense * min(hole.lift, abs(level - hole.r)))
    yield from _out_from_bottom(hole)
    yield StepHere()


def drill(hole: Hole) -> Steps:
    """G81."""
    yield from _to_r(hole)
    yield Feed(hole.z)
    yield from _out_from_bottom(hole)
    yield StepHere()


def counter_bore(hole: Hole) -> Steps:
    """G82."""
    yield from _to_r(hole)
    yield Feed(hole.z)
    yield from _dwell(hole)
    yield from _out_from_bottom(hole)
    yield StepHere()


def _tap(hole: Hole, into: Spindle, out: Spindle) -> Steps:
    yield from _to_r(hole)
    yield Feed(hole.z, threads=True)
    if hole.dwell and hole.dwells_in_thread:
        yield DwellHere(threads=True)
    yield Turn(out, threads=True)
    yield Feed(hole.r, threads=True)
    yield Turn(into)
    yield from _out_from_r(hole)
    yield StepHere()


def tap(hole: Hole) -> Steps:
    """G84: in with M3, out with M4; the tap floats."""
    yield from _tap(hole, Spindle.CLOCKWISE, Spindle.COUNTER_CLOCKWISE)


def counter_tap(hole: Hole) -> Steps:
    """G74: in with M4, out with M3."""
    yield from _tap(hole, Spindle.COUNTER_CLOCKWISE, Spindle.CLOCKWISE)


def _rigid_tap(hole: Hole, clockwise: bool) -> Steps:
    yield from _to_r(hole)
    yield Turn(Spindle.ORIENT)
    yield Tap(hole.z, clockwise)
    yield Tap(hole.r, not clockwise)
    yield Release()
    yield Turn(Spindle.STOP)
    yield from _out_from_r(hole)
    yield StepHere()


def rigid_tap(hole: Hole) -> Steps:
    """G84.2: without a floating tap, right-hand."""
    yield from _rigid_tap(hole, True)


def rigid_counter_tap(hole: Hole) -> Steps:
    """G84.3: left-hand."""
    yield from _rigid_tap(hole, False)


def bore(hole: Hole) -> Steps:
    """G85: in and out with feed."""
    yield from _to_r(hole)
    yield Feed(hole.z)
    yield Feed(hole.r)
    yield from _out_from_r(hole)
    yield StepHere()


def bore_and_dwell(hole: Hole) -> Steps:
    """G89: as G85 with a dwell at the bottom."""
    yield from _to_r(hole)
    yield Feed(hole.z)
    yield from _dwell(hole)
    yield Feed(hole.r)
    yield from _out_from_r(hole)
    yield StepHere()


def bore_and_stop(hole: Hole) -> Steps:
    """G86: the spindle stands while the tool leaves the hole."""
    yield from _to_r(hole)
    yield Feed(hole.z)
    yield Turn(Spindle.STOP)
    yield from _out_from_bottom(hole)
    yield Turn(Spindle.CLOCKWISE)
    yield StepHere()


def fine_bore(hole: Hole) -> Steps:
    """G76: the tool leaves the hole oriented, and off the wall."""
    yield from _to_r(hole)
    yield Feed(hole.z)
    yield from _dwell(hole)
    yield Turn(Spindle.ORIENT)
    yield Shift(away=True)
    yield from _out_from_bottom(hole)
    yield Shift(away=False)
    yield Turn(Spindle.CLOCKWISE)
    yield StepHere()


def bore_by_hand(hole: Hole) -> Steps:
    """G87 without orientation: at the bottom the operator moves the tool."""
    yield from _to_r(hole)
    yield Feed(hole.z)
    yield Turn(Spindle.STOP)
    yield OperatorStop()
    yield from _out_from_bottom(hole)
    yield Turn(Spindle.CLOCKWISE)
    yield StepHere()


def bore_dwell_by_hand(hole: Hole) -> Steps:
    """G88: as G87 without orientation, with a dwell before the spindle stops."""
    yield from _to_r(hole)
    yield Feed(hole.z)
    yield from _dwell(hole)
    yield Turn(Spindle.STOP)
    yield OperatorStop()
    yield from _out_from_bottom(hole)
    yield Turn(Spindle.CLOCKWISE)
    yield StepHere()


def back_bore(hole: Hole) -> Steps:
    """G87 with orientation: through the hole with the tool off the wall, then from R below up to Z with feed."""
    yield Approach()
    yield StepHere()
    yield Turn(Spindle.ORIENT)
    yield Shift(away=True)
    yield Rapid(hole.r, first=True)
    yield StepHere()
    yield Shift(away=False)
    yield Turn(Spindle.CLOCKWISE)
    yield Feed(hole.z)
    yield Turn(Spindle.ORIENT)
    yield Shift(away=True)
    yield Rapid(hole.initial)
    yield Shift(away=False)
    yield Turn(Spindle.CLOCKWISE)
    yield StepHere()


@dataclass(frozen=True, slots=True)
class Cycle:
    """A cycle by its G code. `orients`: the spindle has to be able to go to an angle. `turning`: M3 or M4 that it needs
    before it starts, 0 for none. `cuts`: it needs Q. `rigid`: the spindle follows the axis."""

    code: float
    spec: str
    meaning: str
    steps: Callable[[Hole], Steps]
    orients: bool = False
    turning: int = 0
    cuts: bool = False
    rigid: bool = False


CYCLES = {
    cycle.code: cycle
    for cycle in (
        Cycle(
            73, "nct.cycle.high-speed-peck-g73", "fast, with short retraction between cuts", high_speed_peck, cuts=True
        ),
        Cycle(74, "nct.cycle.counter-tapping-g74", "left-hand thread with a floating tap", counter_tap, turning=4),
        Cycle(
            76,
            "nct.cycle.fine-boring-g76",
            "fine boring, out oriented and off the wall",
            fine_bore,
            orients=True,
            turning=3,
        ),
        Cycle(81, "nct.cycle.drill-g81", "drilling", drill),
        Cycle(82, "nct.cycle.counter-bore-g82", "counter boring, with a dwell", counter_bore),
        Cycle(83, "nct.cycle.peck-g83", "deep hole, out to R between cuts", peck, cuts=True),
        Cycle(84, "nct.cycle.tapping-g84", "thread with a floating tap", tap, turning=3),
        Cycle(84.2, "nct.cycle.rigid-tapping-g84-2-g84-3", "right-hand thread, rigid tap", rigid_tap, rigid=True),
        Cycle(
            84.3, "nct.cycle.rigid-tapping-g84-2-g84-3", "left-hand thread, rigid tap", rigid_counter_tap, rigid=True
        ),
        Cycle(85, "nct.cycle.boring-g85", "boring, out with feed", bore),
        Cycle(86, "nct.cycle.boring-g86", "boring, out in rapid with the spindle standing", bore_and_stop, turning=3),
        Cycle(
            88,
            "nct.cycle.manual-boring-g88",
            "boring, dwell, stop for the operator",
            bore_dwell_by_hand,
            turning=3,
        ),
        Cycle(89, "nct.cycle.boring-g89", "boring with a dwell, out with feed", bore_and_dwell),
    )
}
# G87 is one of two cycles: whether the machine can orient its spindle decides (ORIENT1)
MANUAL_BORING = Cycle(
    87,
    "nct.cycle.manual-boring-g87a",
    "boring, stop for the operator; or back boring",
    bore_by_hand,
    turning=3,
)
BACK_BORING = Cycle(87, "nct.cycle.back-boring-g87b", "back boring", back_bore, orients=True, turning=3)


def cycle_of(code: float, can_orient: bool) -> Cycle | None:
    """The cycle of a G code, None for another code."""
    if code == 87:
        return BACK_BORING if can_orient else MANUAL_BORING
    return CYCLES.get(code)
