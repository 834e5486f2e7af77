"""The drilling cycles G73 to G89 and their end G80, the return level G98 and G99 (programmer's manual lines 4977–5831).

`drilling` tells what a cycle does; here its steps become motions, dwells and orders to the spindle.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace

from runtime.cnc.blocks import Block, ExactStop, ManualKind, ManualMotion, Synch, TechnologyFunction, Wait
from runtime.cnc.decoder.block_functions import Functions
from runtime.cnc.decoder.feed import require_feed
from runtime.cnc.decoder.modal import FeedMode, Motion, Plane
from runtime.cnc.decoder.motion import expect_in_range, straight
from runtime.cnc.decoder.nct import drilling
from runtime.cnc.decoder.nct.cycle_data import Level, tool_length
from runtime.cnc.decoder.nct.drilling import (
    Approach,
    Cycle,
    DwellHere,
    Feed,
    Hole,
    OperatorStop,
    Rapid,
    Release,
    Shift,
    Spindle,
    Step,
    StepHere,
    Tap,
    Turn,
)
from runtime.cnc.decoder.nct.execution import TO_INITIAL, NctExecution
from runtime.cnc.decoder.nct.g_motion import dwell_here
from runtime.cnc.decoder.nct.goals import goal
from runtime.cnc.decoder.nct.registry import GCall, Group, g_code
from runtime.cnc.decoder.outside import WaitForOutside
from runtime.cnc.decoder.places import begin_where_axes_are
from runtime.cnc.decoder.setup import SpindleSetup
from runtime.cnc.decoder.spindles import SpindleWords
from runtime.cnc.decoder.threads import TURN, expect_stroke, stroke
from runtime.cnc.language.errors import LineError
from runtime.diagnostics.catalogue import nct_macros as catalogue

DATA = "RQEPIJKL"
DRILLING_AXES = {Plane.XY: ("Z", "W"), Plane.ZX: ("Y", "V"), Plane.YZ: ("X", "U")}  # the main axis, the parallel one
SHIFT_LETTERS = {Plane.XY: "IJ", Plane.ZX: "KI", Plane.YZ: "JK"}
SHIFT_AXES = {"I": 0, "J": 1, "K": 2}
MOST_STEPS = 20_000  # cuts and holes of a block: more is a mistake in Q or L


@g_code("80", Group.CYCLE, "nct.cycle.cancel-g80", meaning="end of the drilling cycles")
def cancel(x: NctExecution, call: GCall) -> None:
    """Axis words beside it are moved by the path condition."""
    x.end_of_cycle()


@g_code("98", Group.RETURN_LEVEL, "nct.cycle.return-level-g98-g99", meaning="drilling cycles end at the initial point")
def to_initial(x: NctExecution, call: GCall) -> None:
    """The state itself is the active code of the group."""


@g_code("99", Group.RETURN_LEVEL, "nct.cycle.return-level-g98-g99", meaning="drilling cycles end at point R")
def to_r(x: NctExecution, call: GCall) -> None:
    """The state itself is the active code of the group."""


def _register(number: float, *spec: str, meaning: str) -> None:
    @g_code(
        f"{number:g}", Group.CYCLE, "nct.cycle.framework", "nct.cycle.modal-data", *spec,
        meaning=meaning, takes=DATA, moves=drill, functions_within=True,
    )  # fmt: skip
    def cycle(x: NctExecution, call: GCall) -> None:
        x.cycle.mode = True


# ---------------------------------------------------------------------------------------------------- a block


def drill(x: NctExecution) -> None:
    """A block in which a cycle is active: holes, if it has an axis word or R (line 5791)."""
    cycle = drilling.cycle_of(x.active[Group.CYCLE] / 10, x.setup.nct.orient1)
    assert cycle is not None
    words = x.words
    if not x.axis_words and words.of_mover("R") is None:
        _functions(x)
        return
    column = words.all[0][0].column
    if x.modal.compensation_side:
        raise LineError(catalogue.CYCLE_COMPENSATED, column)
    axis = _choose_axis(x, column)
    _store(x, axis, column)
    times = words.of_mover("L")
    count = 1 if times is None else round(times)
    if count == 0:
        _functions(x)
        return
    require_feed(x, words)
    if x.cycle.by_hand is None:
        _check(x, cycle, column)
    if count * (drilling.cuts(_hole(x, cycle, axis)) if cycle.cuts else 1) > MOST_STEPS:
        raise LineError(catalogue.TOO_MANY_CUTS, column, limit=MOST_STEPS)
    hole, _ = x.cycle.by_hand or (0, 0)
    for index in range(hole, count):
        _carry_out(x, cycle, axis, index, last=index == count - 1)


def _functions(x: NctExecution) -> None:
    """What else stands in the block."""
    for block in x.block_functions.leading():
        x.emit(block)
    for block in x.block_functions.trailing():
        x.emit(block)


def drilling_axis(x: NctExecution, column: int) -> int:
    """The axis that the block in work drills with: the one that it names, else that of the block before, else that of the plane.
    LineError for two, and for none."""
    names = [name for name in DRILLING_AXES[x.modal.plane] if name in x.axis_of]
    named = [x.axis_of[name] for name in names if x.axis_of[name] in x.axis_words]
    if len(named) > 1:
        raise LineError(catalogue.TWO_DRILLING_AXES, x.words.place(names[1]), first=names[0], second=names[1])
    possible = [x.axis_of[name] for name in names]
    if not possible:
        raise LineError(catalogue.NO_DRILLING_AXIS, column, axis=DRILLING_AXES[x.modal.plane][0])
    return named[0] if named else x.cycle.axis if x.cycle.axis in possible else possible[0]


def _choose_axis(x: NctExecution, column: int) -> int:
    """The axis that a block drills with; with another one than before the initial point is taken anew."""
    data, axis = x.cycle, drilling_axis(x, column)
    if axis != data.axis:
        if data.axis >= 0 and x.words.of_mover("R") is None:
            raise LineError(catalogue.NO_BOTTOM_OR_R, column)
        if data.axis >= 0:
            data.z = None
        data.axis = axis
        data.initial = x.coordinates.position[axis] - x.length_before[axis]
    return axis


def _store(x: NctExecution, axis: int, column: int) -> None:
    """The data of a block that drills stay for those behind it."""
    words, data = x.words, x.cycle
    letters = SHIFT_LETTERS[x.modal.plane]
    r = words.of_mover("R")
    if r is not None:
        data.r = Level(x.axis_value(axis, r), x.modal.incremental or words.incremental("R"))
    if axis in x.axis_words:
        data.z = Level(x.axis_value(axis, x.axis_words[axis]), x.incremental_words.get(axis, x.modal.incremental))
    for address, name in (("Q", "cut"), ("E", "lift")):
        value = words.of_mover(address)
        if value is not None:
            if value < 0 or (address == "Q" and value == 0):
                raise LineError(catalogue.CUT_NEGATIVE, words.place(address), address=address, value=value)
            setattr(data, name, x.axis_value(axis, value))
    dwell = words.of_mover("P")
    if dwell is not None:
        data.dwell = dwell
    for letter in "IJK":
        value = words.of_mover(letter)
        if value is None:
            continue
        if letter not in letters:
            raise LineError(catalogue.SHIFT_LETTER, words.place(letter), letter=letter, letters=", ".join(letters))
        data.shift[letter] = x.length(value)
    if data.r is None or data.z is None:
        raise LineError(catalogue.NO_BOTTOM_OR_R, column)


def _check(x: NctExecution, cycle: Cycle, column: int) -> None:
    """LineError before anything moves, for what the cycle needs and does not have."""
    data, name = x.cycle, f"G{cycle.code:g}"
    if cycle.orients and not x.setup.nct.orient1:
        raise LineError(catalogue.NO_ORIENTATION, column, name=name)
    if cycle.rigid:
        _rigid(x, cycle, column)
    if cycle.cuts and not data.cut:
        raise LineError(catalogue.CUT_MISSING, column, name=name)
    if cycle.turning:
        spindle = x.spindles.main_programmed if x.spindles.programmed else None
        if spindle is None or spindle.command != cycle.turning or spindle.positioned or spindle.speed <= 0:
            raise LineError(catalogue.SPINDLE_STANDS, column, name=name, command=cycle.turning)
    if cycle is drilling.BACK_BORING:
        if not any(data.shift.values()):
            raise LineError(catalogue.SHIFT_MISSING, column, name=name)
        hole = _hole(x, cycle, data.axis)
        if (hole.initial - hole.z) * (hole.z - hole.r) <= 0:
            raise LineError(catalogue.BACK_BORING_LEVELS, column)


def _rigid(x: NctExecution, cycle: Cycle, column: int) -> tuple[SpindleSetup, float, float]:
    """Of rigid tapping: the spindle, the feed in mm/min and the pitch in mm. LineError where something is missing."""
    name = f"G{cycle.code:g}"
    if not x.setup.nct.index1:
        raise LineError(catalogue.NOT_RIGID, column, name=name)
    feed, speed = x.modal.feed or 0.0, x.modal.speed
    if speed <= 0:
        raise LineError(catalogue.SPEED_MISSING, column, name=name)
    per_revolution = x.modal.feed_mode is FeedMode.PER_REVOLUTION
    pitch = feed if per_revolution else feed / speed
    way = [0.0] * len(x.setup.axes)
    hole = _hole(x, cycle, x.cycle.axis)
    way[x.cycle.axis] = hole.z - hole.r
    return expect_stroke(x, name, column, way, pitch * speed, speed), pitch * speed, pitch


def _machine_level(x: NctExecution, axis: int, level: Level, base: float) -> float:
    """A level in machine coordinates; an incremental one counts from `base`."""
    if level.incremental:
        return base + level.value * x.coordinates.gain[axis]
    return x.coordinates.target({axis: level.value}, False)[axis]


def _hole(x: NctExecution, cycle: Cycle, axis: int) -> Hole:
    data, chosen = x.cycle, x.setup.nct
    assert data.r is not None
    assert data.z is not None
    initial = data.initial + tool_length(x, axis)
    r = _machine_level(x, axis, data.r, initial)
    lift = data.lift
    if lift is None:
        lift = chosen.retg73 if cycle.code == 73 else chosen.cleg83
    return Hole(
        initial=initial,
        r=r,
        z=_machine_level(x, axis, data.z, r),
        cut=data.cut or 0.0,
        lift=lift,
        dwell=bool(data.dwell),
        to_initial=x.active.get(Group.RETURN_LEVEL, TO_INITIAL) == TO_INITIAL,
        dwells_in_thread=chosen.tapdwell,
    )


# ---------------------------------------------------------------------------------------------------- a hole


@contextmanager
def _moving(x: NctExecution, motion: Motion) -> Iterator[None]:
    before, x.modal.motion = x.modal.motion, motion
    try:
        yield
    finally:
        x.modal.motion = before


def _to(x: NctExecution, end: list[float], motion: Motion) -> None:
    """A straight move to a machine position."""
    if end == x.coordinates.position:
        return
    expect_in_range(x, x.words, end)
    with _moving(x, motion):
        straight(x, x.words, end, None)
    x.coordinates.moved(end)


def _along(x: NctExecution, places: Mapping[int, float], motion: Motion) -> None:
    """Some axes go to machine places."""
    end = x.coordinates.position.copy()
    for axis, place in places.items():
        end[axis] = place
    _to(x, end, motion)


def _carry_out(x: NctExecution, cycle: Cycle, axis: int, count: int, *, last: bool) -> None:
    """Hole number `count` of the block. Behind the last one single block stops as behind any block with motion."""
    hole = _hole(x, cycle, axis)
    threads = False
    steps = list(cycle.steps(hole))
    _, begun = x.cycle.by_hand or (0, 0)
    for index, step in enumerate(steps):
        if index < begun:
            continue
        if threads is not _in_thread(step):
            threads = not threads
            _suppress(x, threads)
        if isinstance(step, Approach):
            _approach(x, axis)
            if count == 0:
                _functions(x)
        elif isinstance(step, StepHere):
            if index < len(steps) - 1 or not last:
                x.block_end()
        elif isinstance(step, OperatorStop):
            _by_hand(x, cycle, count, index)
        else:
            _carry_out_step(x, cycle, axis, step)
    if threads:
        _suppress(x, False)


def _by_hand(x: NctExecution, cycle: Cycle, count: int, index: int) -> None:
    """The operator moves the axes until START. The block is executed once more then, from this step on, where they stand."""
    x.cycle.by_hand = (count, index)
    axes = tuple(range(len(x.setup.axes)))
    begin_where_axes_are(x, ManualMotion(x.source, ManualKind.EXCLUSIVE, axes), f"G{cycle.code:g}")
    if x.again is not None:
        raise WaitForOutside(x.again)
    x.cycle.by_hand = None


def _approach(x: NctExecution, axis: int) -> None:
    """Operation 1: every axis that is programmed but the drilling one."""
    words = x.axis_words
    x.axis_words = {other: value for other, value in words.items() if other != axis}
    try:
        if x.axis_words:
            _to(x, goal(x).end, Motion.RAPID)
    finally:
        x.axis_words = words


def _carry_out_step(x: NctExecution, cycle: Cycle, axis: int, step: Step) -> None:
    if isinstance(step, Rapid):
        _along(x, {axis: step.level}, Motion.RAPID)
    elif isinstance(step, Feed):
        _along(x, {axis: step.level}, Motion.LINEAR)
    elif isinstance(step, Tap):
        column = x.words.all[0][0].column
        setup, feed, pitch = _rigid(x, cycle, column)
        end = x.coordinates.position.copy()
        end[axis] = step.level
        expect_in_range(x, x.words, end)
        stroke(x, setup, end, feed, math.copysign(TURN / pitch, 1.0 if step.clockwise else -1.0))
    elif isinstance(step, Release):
        x.sections.close(x)
    elif isinstance(step, Shift):
        sense = 1.0 if step.away else -1.0
        position = x.coordinates.position
        shift = {SHIFT_AXES[letter]: value for letter, value in x.cycle.shift.items()}
        _along(x, {other: position[other] + sense * value for other, value in shift.items()}, Motion.RAPID)
    elif isinstance(step, DwellHere):
        assert x.cycle.dwell is not None
        dwell_here(x, x.cycle.dwell, x.words.place("P"))
    elif isinstance(step, Turn):
        _turn(x, step.order)


def _in_thread(step: Step) -> bool:
    return isinstance(step, Feed | DwellHere | Turn) and step.threads


def _suppress(x: NctExecution, threads: bool) -> None:
    """Stop and override have no effect in a thread. The path stands where it begins, so that a stop before keeps it out."""
    if threads:
        x.emit(ExactStop(x.source))
    x.tell_suppression(threads)


def _turn(x: NctExecution, order: Spindle) -> None:
    """An order to the main spindle; the path waits until it is carried out, whatever the machine has chosen for its M code."""
    functions = Functions(x.source)
    words = SpindleWords(x.words.all[0][0].column)
    if order is Spindle.ORIENT:
        words.position, words.angle = True, 0.0
    else:
        words.command = order.value
    x.spindles.order(x, functions, x.spindles.main, words)
    for block in (*functions.before, *functions.after):
        x.emit(_waited_for(block))
    x.emit(Wait(x.source, Synch.MVS_SVS))


def _waited_for(block: Block) -> Block:
    if not isinstance(block, TechnologyFunction):
        return block
    return replace(block, synch=Synch.MVS_SVS | block.synch.flags, lead=0.0)


for _cycle in (*drilling.CYCLES.values(), drilling.MANUAL_BORING):
    _more = (drilling.BACK_BORING.spec,) if _cycle is drilling.MANUAL_BORING else ()
    _register(_cycle.code, _cycle.spec, *_more, meaning=f"drilling cycle: {_cycle.meaning}")
