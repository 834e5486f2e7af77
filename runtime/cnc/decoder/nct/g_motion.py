"""The path conditions: G00, G01, G02, G03, and the dwell G04 (manual lines 952–1164, 2139–2154)."""

from __future__ import annotations

from runtime.cnc.decoder.modal import INCH, FeedMode, Motion
from runtime.cnc.decoder.motion import dwell_time
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.motion import arc, line
from runtime.cnc.decoder.nct.registry import GCall, Group, Stage, g_code, word
from runtime.cnc.language.errors import LineError
from runtime.diagnostics.catalogue import language
from runtime.diagnostics.catalogue import nct as catalogue

LONGEST_DWELL = 99_999.999

# mm/min or mm/rev by increment (lines 1909–1981): least and greatest F
PER_MINUTE = {"IS-A": (0.001, 250_000.0), "IS-B": (0.0001, 25_000.0), "IS-C": (0.00001, 2_500.0)}
PER_REVOLUTION = {"IS-A": (0.0001, 5_000.0), "IS-B": (0.00001, 500.0), "IS-C": (0.000001, 50.0)}
FEEDS = (PER_MINUTE, PER_REVOLUTION)


@g_code(
    "0",
    Group.MOTION,
    "nct.motion.positioning-g00",
    meaning="positioning in rapid traverse",
    takes=(",A", ",C", ",R"),
    moves=line,
)
def rapid(x: NctExecution, call: GCall) -> None:
    x.modal.motion = Motion.RAPID


@g_code(
    "1", Group.MOTION, "nct.motion.linear-g01", meaning="straight line at feed", takes=(",A", ",C", ",R"), moves=line
)
def linear(x: NctExecution, call: GCall) -> None:
    x.modal.motion = Motion.LINEAR


@g_code(
    "2", Group.MOTION, "nct.motion.circular-g02-g03", "nct.motion.spiral", "nct.motion.helical",
    meaning="arc, clockwise", takes=("I", "J", "K", "R", ",C", ",R"), moves=arc,
)  # fmt: skip
def clockwise(x: NctExecution, call: GCall) -> None:
    x.modal.motion = Motion.CIRCLE_CW


@g_code(
    "3", Group.MOTION, "nct.motion.circular-g02-g03", "nct.motion.spiral", "nct.motion.helical",
    meaning="arc, counter-clockwise", takes=("I", "J", "K", "R", ",C", ",R"), moves=arc,
)  # fmt: skip
def counter_clockwise(x: NctExecution, call: GCall) -> None:
    x.modal.motion = Motion.CIRCLE_CCW


@g_code(
    "4",
    Group.ONE_SHOT,
    "nct.motion.dwell-g04",
    meaning="dwell: P in s, with G95 in revolutions",
    stage=Stage.MOVE,
    takes="P",
)
def dwell(x: NctExecution, call: GCall) -> None:
    """G04 P: seconds, with G95 revolutions of the spindle."""
    value = x.words.needed("P", catalogue.FAULTY_P, call.column)
    if not 0 < value <= LONGEST_DWELL:
        raise LineError(catalogue.FAULTY_P, x.words.place("P"))
    if x.axis_words:
        raise LineError(catalogue.WORD_WITHOUT_MEANING, x.words.place(x.words.left[0].address), address="an axis word")
    dwell_here(x, value, x.words.place("P"))


def dwell_here(x: NctExecution, value: float, column: int) -> None:
    """A dwell as P says it: seconds, with G95 revolutions of the spindle."""
    if x.nct.second or x.modal.feed_mode is not FeedMode.PER_REVOLUTION:
        dwell_time(x, value, column)
        return
    if x.modal.speed <= 0:
        raise LineError(language.DWELL_SPEED, column)
    dwell_time(x, value / x.modal.speed * 60.0, column)


@word(
    "F",
    "nct.feed.cutting-g94-g95",
    meaning="feed along the path, mm/min or inch/min (G94), mm or inch per revolution (G95)",
)
def feed(x: NctExecution, value: float, column: int) -> None:
    unit = INCH if x.modal.inch else 1.0
    revolution = x.modal.feed_mode is FeedMode.PER_REVOLUTION
    least, most = (number / unit for number in FEEDS[revolution][x.nct.increment])
    if value and not least <= value <= most:
        raise LineError(catalogue.VALUE_EXCESS, column, address="F", value=value, least=least, most=most)
    x.modal.feed = value * unit
