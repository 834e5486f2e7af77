"""Block search: programs are entered in the middle, the state is restored, the axes go back to the contour."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from runtime.cnc.search_target import SearchKind
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import block_search as errors
from runtime.diagnostics.catalogue import plc
from runtime.diagnostics.errors import ErrorEntry
from runtime.diagnostics.events import EventKind
from runtime.hli.layout import Activation, KeyPress, ManualMode, Mode, SearchOrder, SearchState, State, StopCondition
from runtime.scheduler.keeping import interruption_in, retained_of
from runtime.scheduler.retained import RetainedStore
from tests.machine.driven import Driven
from tests.machine.scripted_plc import ScriptedPlc

M = 1

PART = """%PART
N10 G90 G17 G00 X10 Y10 Z5 S500 M3
N20 M8
N30 G01 Z-2 F6000
N40 X60
N50 M20
N60 G03 X60 Y50 I0 J20
N70 M9
N80 G01 X10
N90 Y10
N100 G00 Z20 M5
N110 M30
"""
SMOOTH = """%SMOOTH
N10 G90 G17 G00 X10 Y10 Z0 F9000
N20 #CONTOUR MODE ON [DEV, PATH_DEV 0.5]
N30 G01 X40
N40 Y30 M20
N50 G02 X70 Y60 I30 J0
N60 G01 X20 Z-3
#CONTOUR MODE OFF
N70 G41 D1 G01 X10 Y40
N80 X5 Y10
N90 X40 Y8
N100 G40 X50 Y20
N110 M30
"""
LOOP = """%L SUB
N500 G91 G01 X5
N510 Y1
N520 G90 M17
%LOOP
N10 G90 G01 F6000 X0 Y0
$FOR P1 = 1, 4, 1
N20 LL SUB
N30 Z[-P1]
$ENDFOR
N40 M30
"""


def make(machine: Machine, folder: Path, delays: dict[tuple[int, int], float | None] | None = None) -> Driven:
    return Driven(machine, folder, ideal_axes=True, partner=lambda memory: ScriptedPlc(memory, delays or {}))


@pytest.fixture
def driven(demo: Machine, tmp_path: Path) -> Driven:
    return make(demo, tmp_path)


def search(driven: Driven, text: str, kind: SearchKind, value: int = 0, **more: object) -> None:
    """Order a search and start; without other words nobody is asked before the axes move."""
    order = SearchOrder(type=int(kind), value=value)
    for name, given in {"automatic_return": True, "no_hold": True, **more}.items():
        if name == "ranks":
            order.ranks[:] = given
        else:
            setattr(order, name, given)
    driven.operator.block_search.data_w = order
    driven.operator.block_search.semaphor_rw = True
    driven.start(text)


def place(driven: Driven) -> list[float]:
    return [round(float(p), 6) for p in driven.channel.interpolator.position]


def state(driven: Driven) -> SearchState:
    return SearchState(driven.hli.channels[0].status.block_search_state_r)


def until(driven: Driven, wanted: SearchState) -> None:
    driven.until(lambda: state(driven) is wanted or bool(driven.alarms))
    assert driven.alarms == []
    assert state(driven) is wanted


def put_out(driven: Driven) -> list[tuple[str, int]]:
    """M and spindle functions so far, in their order."""
    kinds = {EventKind.M_OUT: "M", EventKind.SPINDLE: "S"}
    return [(kinds[event.kind], event.number) for event in driven.simulation.log if event.kind in kinds]


def refused(driven: Driven, entry: ErrorEntry) -> str:
    """The search has ended with this error, and no axis was moved."""
    driven.until(lambda: bool(driven.alarms) and not driven.channel.active)
    assert place(driven) == [0.0, 0.0, 0.0]
    assert not np.ptp(np.array(driven.targets)[:, :3], axis=0).any()
    assert state(driven) is SearchState.INACTIVE
    return driven.alarm(entry).text


# ---------------------------------------------------------------------------------------------------- where


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        (SearchKind.BLOCK_NUMBER, 80),
        (SearchKind.LINE, 9),
        (SearchKind.FILE_OFFSET, PART.index("N80") + 2),
        (SearchKind.BLOCK_COUNTER, 4),
    ],
)
def test_a_program_is_entered_at_a_block(driven: Driven, kind: SearchKind, value: int) -> None:
    search(driven, PART, kind, value)
    until(driven, SearchState.RETURNING)
    assert put_out(driven) == [("S", 3), ("M", 8), ("M", 20), ("M", 9)]
    assert float(np.abs(driven.image.target_velocity[3])) == pytest.approx(3000.0)  # 500 rev/min, before anything moves
    assert place(driven) == [0.0, 0.0, 0.0]
    until(driven, SearchState.INACTIVE)
    assert place(driven) == [60.0, 50.0, -2.0]
    driven.until_done()
    assert place(driven) == [10.0, 10.0, 20.0]
    assert put_out(driven)[4:] == [("S", 5)]
    driven.assert_no_jump()


def test_the_functions_of_the_block_itself_belong_to_what_goes_on(driven: Driven) -> None:
    search(driven, PART, SearchKind.BLOCK_NUMBER, 50)
    until(driven, SearchState.RETURNING)
    assert put_out(driven) == [("S", 3), ("M", 8)]
    driven.until_done()
    assert put_out(driven)[2:] == [("M", 20), ("M", 9), ("S", 5)]


@pytest.mark.parametrize(
    ("kind", "value", "passes", "x", "z"),
    [
        (SearchKind.BLOCK_NUMBER, 30, 3, 15.0, -2.0),
        (SearchKind.BLOCK_NUMBER, 510, 4, 20.0, -3.0),
        (SearchKind.LINE, 2, 2, 5.0, -1.0),
        (SearchKind.LINE, 8, 4, 15.0, -3.0),
    ],
)
def test_passes_of_loops_and_subprograms_are_counted(
    driven: Driven, kind: SearchKind, value: int, passes: int, x: float, z: float
) -> None:
    search(driven, LOOP, kind, value, passes=passes)
    until(driven, SearchState.RETURNING)
    until(driven, SearchState.INACTIVE)
    assert (place(driven)[0], place(driven)[2]) == (x, z)
    driven.until_done()
    assert place(driven) == [20.0, 4.0, -4.0]


@pytest.mark.parametrize(
    ("kind", "value"), [(SearchKind.BLOCK_NUMBER, 300), (SearchKind.LINE, 301), (SearchKind.BLOCK_COUNTER, 299)]
)
def test_in_a_run_of_short_lines(driven: Driven, kind: SearchKind, value: int) -> None:
    lines = [f"N{i} X{i * 0.1:.1f} Y{(i % 7) * 0.1:.1f}" for i in range(2, 400)]
    search(driven, "\n".join(["%RUN", "N1 G90 G01 F6000 X0.1 Y0.1", *lines, "M30", ""]), kind, value)
    until(driven, SearchState.RETURNING)
    until(driven, SearchState.INACTIVE)
    assert place(driven)[:2] == pytest.approx([29.9, (299 % 7) * 0.1])
    driven.watch(2)
    assert driven.hli.channels[0].status.block_counter_r >= 299
    driven.until_done()
    assert place(driven)[0] == pytest.approx(39.9)


def test_a_share_of_the_first_motion_is_left_out_too(driven: Driven) -> None:
    search(driven, PART, SearchKind.BLOCK_NUMBER, 60, covered=500)
    until(driven, SearchState.RETURNING)
    until(driven, SearchState.INACTIVE)
    assert place(driven) == [80.0, 30.0, -2.0]  # half of the half circle
    driven.until_done()
    assert place(driven) == [10.0, 10.0, 20.0]


def test_without_an_order_programs_start_at_their_beginning(driven: Driven) -> None:
    search(driven, PART, SearchKind.BLOCK_NUMBER, 80)
    driven.until_done()
    driven.start(PART)
    assert state(driven) is SearchState.INACTIVE
    driven.until_x(59.0)  # N40
    assert place(driven)[1] == 10.0


# ---------------------------------------------------------------------------------------------------- the way back


@pytest.mark.parametrize(
    ("ranks", "last"), [((0,) * 8, 2), ((2, 2, 1, 0, 0, 0, 0, 0), 0), ((1, 2, 3, 0, 0, 0, 0, 0), 2)]
)
def test_the_axes_go_back_in_their_order(driven: Driven, ranks: tuple[int, ...], last: int) -> None:
    search(driven, PART, SearchKind.BLOCK_NUMBER, 80, ranks=ranks, return_feed=50_000)
    until(driven, SearchState.RETURNING)
    driven.forget()
    until(driven, SearchState.INACTIVE)
    moved = np.abs(np.diff(np.array(driven.targets)[:, :3], axis=0)) > 0.0
    first, end = moved.argmax(axis=0), len(moved) - moved[::-1].argmax(axis=0)
    others = [axis for axis in range(3) if axis != last and (ranks[last] != ranks[axis] or not any(ranks))]
    assert all(end[axis] <= first[last] + 1 for axis in others)  # one cycle may pass the corner
    path = np.array(driven.targets)[:, :3]
    speeds = np.linalg.norm(np.diff(path, axis=0), axis=1) / driven.simulation.period
    assert speeds.max() == pytest.approx(50.0, abs=0.1)


def test_away_from_the_workpiece_the_tool_axis_goes_first(driven: Driven) -> None:
    driven.start("%DOWN\nG90 G01 F6000 X50 Y5 Z-10\nM30\n")
    driven.until_done()
    driven.watch(2)
    search(driven, PART, SearchKind.BLOCK_NUMBER, 80)
    until(driven, SearchState.RETURNING)
    driven.forget()
    until(driven, SearchState.INACTIVE)
    path = np.array(driven.targets)[:, :3]
    assert set(path[path[:, 0] != 50.0, 2]) == {-2.0}


def test_nobody_moves_without_being_told_to_and_the_hand_may_help(driven: Driven) -> None:
    operator = driven.operator
    search(driven, PART, SearchKind.BLOCK_NUMBER, 80, automatic_return=False, no_hold=False)
    until(driven, SearchState.WAIT_FOR_RETURN)
    driven.watch(300)
    wanted = StopCondition.MANUAL | StopCondition.WAIT_CONTINUE | StopCondition.RETURN_TO_CONTOUR
    assert StopCondition(driven.channel.stop_condition) == wanted
    assert place(driven) == [0.0, 0.0, 0.0]
    operator.activation.data_w = Activation(int(driven.hli.axes[2].log_ax_n_r), 3, int(ManualMode.CONTINUOUS), 0)
    operator.activation.semaphor_rw = True
    driven.watch(2)
    for direction in (1, 0):
        operator.key.data_w = KeyPress(3, direction, 0)
        operator.key.semaphor_rw = True
        driven.watch(400)
    driven.until(lambda: driven.channel.beside.at_rest)
    lifted = float(driven.image.target_position[2])
    assert lifted > 1.0
    driven.forget()
    operator.continue_motion_rw = True
    until(driven, SearchState.RETURNING)
    assert place(driven) == [0.0, 0.0, round(lifted, 6)]
    until(driven, SearchState.WAIT_TO_CONTINUE)
    driven.watch(200)
    assert place(driven) == [60.0, 50.0, -2.0]
    assert StopCondition(driven.channel.stop_condition) == StopCondition.WAIT_CONTINUE | StopCondition.RETURN_TO_CONTOUR
    operator.continue_motion_rw = True
    driven.until_done()
    assert place(driven) == [10.0, 10.0, 20.0]
    driven.assert_no_jump()
    assert driven.alarms == []


def test_feed_hold_and_single_block_on_the_way_back(driven: Driven) -> None:
    driven.operator.single_block_w = True
    search(driven, PART, SearchKind.BLOCK_NUMBER, 80)
    until(driven, SearchState.RETURNING)
    driven.until(lambda: place(driven)[0] > 20.0)
    driven.operator.feedhold_w = True
    driven.watch(500)
    held = place(driven)
    driven.watch(100)
    assert place(driven) == held
    assert driven.state() is State.HOLD
    driven.operator.feedhold_w = False
    driven.until(lambda: bool(driven.channel.stop_condition & StopCondition.SINGLE_BLOCK))
    assert place(driven) == [60.0, 50.0, 0.0]
    driven.operator.continue_motion_rw = True
    driven.until(lambda: place(driven)[2] == -2.0)
    driven.operator.single_block_w = False
    driven.until_done()
    assert place(driven) == [10.0, 10.0, 20.0]
    driven.assert_no_jump()


# ---------------------------------------------------------------------------------------------------- the PLC


def test_the_plc_agrees_to_begin_and_to_end(driven: Driven) -> None:
    channel = driven.hli.channels[0]
    unit, status = channel.control.block_search_on, channel.status
    unit.enable_w = True
    search(driven, PART, SearchKind.BLOCK_NUMBER, 80)
    until(driven, SearchState.WAIT_FOR_PLC_ON)
    driven.watch(200)
    assert (state(driven), unit.request_r, put_out(driven)) == (SearchState.WAIT_FOR_PLC_ON, True, [])
    assert not status.block_search_active_r
    assert driven.channel.stop_condition & StopCondition.BLOCK_SEARCH
    unit.command_w = True
    until(driven, SearchState.WAIT_FOR_PLC_OFF)
    driven.watch(200)
    assert state(driven) is SearchState.WAIT_FOR_PLC_OFF
    assert (status.block_search_active_r, unit.request_r) == (True, True)
    assert len(put_out(driven)) == 4
    assert place(driven) == [0.0, 0.0, 0.0]
    unit.command_w = False
    until(driven, SearchState.RETURNING)
    assert not status.block_search_active_r
    driven.until_done()
    assert place(driven) == [10.0, 10.0, 20.0]


@pytest.mark.parametrize("delay", [0.3, None])
def test_a_function_is_waited_for_before_the_search_goes_on(demo: Machine, tmp_path: Path, delay: float | None) -> None:
    driven = make(demo, tmp_path, {(M, 8): delay})
    search(driven, PART, SearchKind.BLOCK_NUMBER, 80)
    driven.watch(250)
    assert put_out(driven) == [("S", 3), ("M", 8)]  # one after the other
    assert state(driven) is SearchState.ACTIVE
    assert driven.hli.channels[0].status.wait_techno_acknowledge_r
    if delay is None:
        driven.reset()
        driven.until_done()
        assert state(driven) is SearchState.INACTIVE
        assert place(driven) == [0.0, 0.0, 0.0]
        driven.start(PART)  # and the next one begins at the top
        driven.watch(200)
        assert state(driven) is SearchState.INACTIVE
        return
    until(driven, SearchState.RETURNING)
    assert len(put_out(driven)) == 4
    driven.until_done()
    assert place(driven) == [10.0, 10.0, 20.0]


def test_the_plc_may_order_it_and_the_operator_only_ask(driven: Driven) -> None:
    unit = driven.hli.channels[0].control.block_search
    unit.enable_w = True
    search(driven, PART, SearchKind.BLOCK_NUMBER, 80)
    assert (unit.request_r.type, unit.request_r.value) == (4, 80)
    driven.until_x(59.0)
    assert state(driven) is SearchState.INACTIVE
    driven.reset()
    driven.until_done()
    driven.watch(2)
    unit.command_w.type, unit.command_w.value = int(SearchKind.BLOCK_NUMBER), 90
    unit.command_w.automatic_return = unit.command_w.no_hold = True
    driven.start(PART)
    until(driven, SearchState.RETURNING)
    until(driven, SearchState.INACTIVE)
    assert place(driven) == [10.0, 50.0, -2.0]


def test_a_search_belongs_to_one_start_also_where_that_is_refused(driven: Driven) -> None:
    order = SearchOrder(type=int(SearchKind.BLOCK_NUMBER), value=80, automatic_return=True, no_hold=True)
    driven.operator.block_search.data_w, driven.operator.block_search.semaphor_rw = order, True
    driven.simulation.order(Mode.AUTOMATIC, State.ACTIVE, "")  # no program is loaded
    driven.watch(2)
    assert driven.operator.answer_r == plc.MODE_NO_PROGRAM.id
    assert not driven.operator.block_search.semaphor_rw
    driven.start(PART)
    assert driven.channel.active
    assert state(driven) is SearchState.INACTIVE, "the next program begins at its beginning"


@pytest.mark.parametrize(("hands_on", "found"), [(True, SearchState.WAIT_FOR_RETURN), (False, SearchState.INACTIVE)])
def test_a_search_goes_with_the_order_that_the_plc_hands_on(driven: Driven, hands_on: bool, found: SearchState) -> None:
    unit = driven.hli.channels[0].control.mode_and_state
    unit.enable_w = True
    order = SearchOrder(type=int(SearchKind.BLOCK_NUMBER), value=80)
    driven.operator.block_search.data_w, driven.operator.block_search.semaphor_rw = order, True
    driven.start(PART)
    assert unit.request_semaphor_rw
    assert not driven.channel.active, "the PLC decides"
    unit.request_semaphor_rw = False
    unit.command_w = unit.request_r
    if not hands_on:  # a program of its own
        unit.command_w.parameter = str(driven.program(LOOP)).encode()
    unit.command_semaphor_rw = True
    driven.watch(2)
    assert driven.channel.active
    driven.watch(100)
    assert state(driven) is found


def test_the_program_knows_that_it_is_searched(driven: Driven) -> None:
    text = """%KNOWS
N10 G90 G01 F6000 X10
$IF V.G.BLOCK_SEARCH_ACTIVE == 0
N20 M20
$ENDIF
N30 #FLUSH WAIT
N35 P1 = V.A.ABS.X
N40 X50
N50 #FLUSH WAIT
$IF V.G.BLOCK_SEARCH_ACTIVE == 0
N60 M21
$ENDIF
N70 YP1
N80 M30
"""
    search(driven, text, SearchKind.BLOCK_NUMBER, 40)
    driven.until_done()
    assert driven.alarms == []
    assert put_out(driven) == [("M", 21)]
    assert place(driven) == [50.0, 10.0, 0.0]  # where the axis would have been


# ---------------------------------------------------------------------------------------------------- refused


@pytest.mark.parametrize(
    ("kind", "value", "words"),
    [
        (SearchKind.BLOCK_NUMBER, 85, "block N85"),
        (SearchKind.LINE, 400, "line 400"),
        (SearchKind.BLOCK_COUNTER, 50, "block 50"),
    ],
)
def test_a_place_that_is_not_there(driven: Driven, kind: SearchKind, value: int, words: str) -> None:
    search(driven, PART, kind, value)
    assert words in refused(driven, errors.SEARCH_NOT_FOUND)


@pytest.mark.parametrize("block", ["G74 X1", "G200", "X[MC_MoveAbsolute Position=5 Velocity=100]"])
def test_no_search_goes_over_motion_of_somebody_else(driven: Driven, block: str) -> None:
    search(driven, f"%OTHER\nG90 G01 F6000 X10\n{block}\nN20 X50\nM30\n", SearchKind.BLOCK_NUMBER, 20)
    if "MC_" in block:
        driven.until(lambda: bool(driven.alarms))
        assert place(driven) == [0.0, 0.0, 0.0]
        return
    assert "no block search goes over" in refused(driven, errors.SEARCH_STOPS_HERE)


def test_a_locked_area_is_not_entered(driven: Driven) -> None:
    text = "%LOCKED\nN10 G90 G01 F6000 X10\n#BLOCKSEARCH LOCKED\nN20 X20\nN30 X30\n#BLOCKSEARCH RELEASED\nN40 X40\nN50 M30\n"
    search(driven, text, SearchKind.BLOCK_NUMBER, 40)
    driven.until_done()
    assert driven.alarms == []
    driven.forget()
    search(driven, text, SearchKind.BLOCK_NUMBER, 30)
    driven.until(lambda: bool(driven.alarms))
    assert "N30" in driven.alarm(errors.SEARCH_LOCKED).text
    assert place(driven)[0] == 40.0


def test_orders_that_make_no_sense(driven: Driven) -> None:
    for kind, entry in ((7, errors.SEARCH_KIND), (6, errors.SEARCH_NO_POINT)):
        order = SearchOrder(type=kind)
        driven.operator.block_search.data_w = order
        driven.operator.block_search.semaphor_rw = True
        driven.start(PART)
        assert not driven.channel.active
        assert driven.alarm(entry)
        assert not driven.operator.block_search.semaphor_rw


# ---------------------------------------------------------------------------------------------------- interruption

Curve = npt.NDArray[np.float64]


def driven_path(driven: Driven) -> Curve:
    """Way of the program and positions in each cycle until the program ends, (cycles, 1 + n_axes)."""
    rows = []
    while driven.channel.active:
        driven.simulation.cycle()
        point = driven.channel.search.point
        assert point is not None
        if state(driven) is SearchState.INACTIVE and driven.channel.active:
            rows.append([point.way, *driven.channel.interpolator.position])
    return np.array(rows)


def wait_for_way(driven: Driven, way: float) -> None:
    driven.until(lambda: driven.channel.search.point is not None and driven.channel.search.point.way >= way)


@pytest.mark.parametrize("text", [PART, SMOOTH], ids=["part", "smooth"])
def test_an_interrupted_program_goes_on_where_it_was(demo: Machine, tmp_path: Path, text: str) -> None:
    whole = make(demo, tmp_path)
    whole.start(text)
    reference = driven_path(whole)
    assert whole.alarms == []
    assert whole.channel.search.point is not None
    assert not whole.channel.search.point.valid
    length = reference[-1, 0]
    driven = make(demo, tmp_path)
    driven.start(text)
    for share in (0.1, 0.37, 0.5, 0.71, 0.9):
        wait_for_way(driven, share * length)
        driven.reset()
        driven.until_done()
        driven.watch(2)
        point = driven.hli.channels[0].status.interruption
        assert point.valid_r
        stood = point.way_r * 1e-4
        search(driven, text, SearchKind.INTERRUPTION)
        until(driven, SearchState.RETURNING)
        until(driven, SearchState.INACTIVE)
        expected = [np.interp(stood, reference[:, 0], reference[:, k]) for k in (1, 2, 3)]
        assert place(driven) == pytest.approx(expected, abs=2e-3)
    rest = driven_path(driven)
    assert driven.alarms == []
    assert rest[-1, 0] == pytest.approx(length, abs=1e-6)
    for k in (1, 2, 3):
        assert np.abs(rest[:, k] - np.interp(rest[:, 0], reference[:, 0], reference[:, k])).max() < 2e-3
    driven.assert_no_jump()


def test_the_place_outlives_the_machine(demo: Machine, tmp_path: Path) -> None:
    driven = make(demo, tmp_path)
    driven.start(PART)
    wait_for_way(driven, 90.0)
    store = RetainedStore(tmp_path / "state")
    store.save(retained_of(demo, driven.hli))  # the power goes in the middle of the motion
    kept, problems = store.load()
    assert problems == []
    other = make(demo, tmp_path)
    other.channel.search.point = interruption_in(kept, 3)
    other.watch(1)
    search(other, PART, SearchKind.INTERRUPTION)
    until(other, SearchState.RETURNING)
    until(other, SearchState.INACTIVE)
    assert other.channel.search.point is not None
    assert other.channel.search.point.way == pytest.approx(kept.interruption["way"], abs=0.2)
    other.until_done()
    assert place(other) == [10.0, 10.0, 20.0]


def test_a_search_that_is_aborted_keeps_the_place_that_was_known(driven: Driven) -> None:
    driven.start(PART)
    wait_for_way(driven, 60.0)
    driven.reset()
    driven.until_done()
    before = driven.channel.search.point
    search(driven, PART, SearchKind.BLOCK_NUMBER, 90, automatic_return=False)
    until(driven, SearchState.WAIT_FOR_RETURN)
    driven.reset()
    driven.until_done()
    assert driven.channel.search.point is before
    driven.watch(2)
    changed = PART.replace("N40 X60\n", "N40 X61\nN41 X60\n(1)\n(2)\n").replace("N30 G01 Z-2", "(3)\nN30 G01 Z-2")
    driven.forget()
    search(driven, changed, SearchKind.INTERRUPTION)
    driven.until(lambda: bool(driven.alarms))
    assert driven.alarm(errors.SEARCH_CHANGED)


def test_a_program_with_locked_axes_is_nowhere(driven: Driven) -> None:
    driven.start(PART)
    wait_for_way(driven, 60.0)
    driven.reset()
    driven.until_done()
    before = driven.channel.search.point
    driven.operator.machine_lock_w = True
    driven.watch(2)
    driven.start(PART)
    driven.watch(300)
    driven.reset()
    driven.until_done()
    assert driven.channel.search.point is before
    assert before is not None
    assert before.valid
