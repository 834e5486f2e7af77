"""INDP_SYN, INDP_ASYN and #WAIT INDP on the whole machine in virtual time (programming manual 29533–29772)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from runtime.cnc.blocks import Arc, IndependentMotion, IndependentWait, Line, Polyline
from runtime.cnc.decoder.independent import ramp_time, speed_for
from runtime.cnc.decoder.setup import AxisDynamics, DecoderSetup
from runtime.cnc.dynamic_settings import Slope
from runtime.cnc.language.errors import ProgramErrors
from runtime.cnc.search_target import SearchKind
from runtime.config import load_machine
from runtime.config.loader import DEMO_MACHINE
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import axes as errors
from runtime.diagnostics.catalogue import block_search, language, motion
from runtime.diagnostics.errors import ErrorEntry
from runtime.hli.layout import SearchOrder, StopCondition
from tests.cnc.decoder.programs import SETUP, decode
from tests.machine.driven import Driven

X, Y, Z = 0, 1, 2


@pytest.fixture
def machine(tmp_path: Path) -> Driven:
    return Driven(load_machine(DEMO_MACHINE), tmp_path, ideal_axes=True)


def with_parameters(folder: Path, *, ideal: bool = True, **parameters: object) -> Driven:
    demo = load_machine(DEMO_MACHINE)
    channel = demo.channels[0]
    changed = channel.model_copy(update={"parameters": channel.parameters.model_copy(update=parameters)})
    return Driven(demo.model_copy(update={"channels": (changed,)}), folder, ideal_axes=ideal)


def run(driven: Driven, text: str) -> np.ndarray:
    """Set-points (cycles, axes) until the program is over."""
    driven.forget()
    driven.start(text)
    driven.until_done()
    assert_smooth(driven)
    return np.array(driven.targets)


def assert_smooth(driven: Driven) -> None:
    """No axis jumps, and every one keeps to its velocity and acceleration."""
    described: Machine = driven.machine
    path, period = np.array(driven.targets), driven.simulation.period
    v = np.diff(path, axis=0) / period
    a = np.diff(v, axis=0) / period
    for k in (X, Y, Z):
        axis = described.axes[k]
        assert np.abs(v[:, k]).max(initial=0.0) <= axis.velocity * 1.001
        assert np.abs(a[:, k]).max(initial=0.0) <= axis.acceleration * 1.01 + axis.velocity_step / period, "corners"


def first(path: np.ndarray, condition: Callable[[np.ndarray], np.ndarray]) -> int:
    """The first cycle in which the condition holds."""
    (found,) = np.nonzero(condition(path))
    return int(found[0])


@pytest.mark.spec("isg.posax.indp-syn")
@pytest.mark.parametrize("ideal", [True, False])
def test_the_next_block_waits_for_all_axes_of_the_block(tmp_path: Path, ideal: bool) -> None:
    driven = with_parameters(tmp_path, ideal=ideal)
    path = run(driven, "%A\nN5 G90 G01 F6000\nN10 X10 Y11 Z[INDP_SYN POS-20 G01 FEED1200 G90]\nN20 X20\nM30\n")
    assert not driven.simulation.problems
    begin, there = first(path, lambda p: p[:, Z] < 0.0), first(path, lambda p: p[:, Z] <= -20.0)
    beside = first(path, lambda p: p[:, X] > 0.0)
    assert abs(begin - beside) <= 5, "both begin together"
    assert path[there, X] == pytest.approx(10.0)
    assert path[there, Y] == pytest.approx(11.0)
    assert first(path, lambda p: p[:, X] > 10.0001) >= there
    assert np.abs(np.diff(path[:, Z])).max() / driven.simulation.period == pytest.approx(20.0, rel=1e-6)
    assert path[-1, [X, Y, Z]].tolist() == pytest.approx([20.0, 11.0, -20.0])


@pytest.mark.spec("isg.posax.indp-asyn", "isg.posax.wait-indp")
def test_an_asynchronous_axis_goes_on_through_the_blocks(machine: Driven) -> None:
    path = run(
        machine,
        "%B\nN5 G90 G01 F6000\nN30 X5 Y10 Z[INDP_ASYN POS-20 G01 FEED600 G90]\nN40 X20 Y30\nN45 X25\n"
        "N50 #WAIT INDP[Z]\nN60 X30 Y40 Z-30\nM30\n",
    )
    at_25 = first(path, lambda p: p[:, X] > 24.9999)
    there = first(path, lambda p: p[:, Z] <= -20.0)
    assert -20.0 < path[at_25, Z] < -1.0, "the path has gone on beside the axis"
    assert first(path, lambda p: p[:, X] > 25.0001) >= there
    together = path[path[:, X] > 25.1]
    share = (together[:, X] - 25.0) / 5.0
    np.testing.assert_allclose(together[:, Z], -20.0 - 10.0 * share, atol=1e-6)


@pytest.mark.spec("isg.posax.wait-indp")
def test_all_axes_can_be_waited_for(machine: Driven) -> None:
    path = run(
        machine,
        "%C\nN5 G90 G01 F6000\nN10 Y[INDP_ASYN POS=20 FEED=900] Z[INDP_ASYN POS=-20 FEED=600]\nN20 X5\n#WAIT INDP ALL\n"
        "N30 X10\nM30\n",
    )
    slowest = max(first(path, lambda p: p[:, Y] >= 20.0), first(path, lambda p: p[:, Z] <= -20.0))
    assert first(path, lambda p: p[:, X] > 5.0001) >= slowest
    assert first(path, lambda p: p[:, X] > 4.9999) < slowest


@pytest.mark.spec("isg.posax.wait-indp", "isg.posax.indp-asyn")
@pytest.mark.parametrize("block", ["Z-25", "Z[INDP_SYN POS-25 G00]", "G91 Z-5", "G02 X10 I2.5 Z-25"])
def test_an_axis_that_moves_is_waited_for_where_it_is_moved_again(machine: Driven, block: str) -> None:
    path = run(machine, f"%D\nN5 G90 G01 F6000\nN10 Z[INDP_ASYN POS-20 FEED600]\nN20 X5\nN30 {block}\nM30\n")
    assert path[-1, Z] == pytest.approx(-25.0)
    assert np.all(np.diff(path[:, Z]) <= 1e-12)
    waited = path[:, Z]
    rests = np.isclose(waited, -20.0, atol=1e-9).sum()
    assert rests >= 1, "it has come to its first target before"


@pytest.mark.parametrize("named", [0, 1])
def test_naming_an_axis_waits_for_it_only_where_that_is_chosen(tmp_path: Path, named: int) -> None:
    driven = with_parameters(tmp_path, mode_implicite_sync_indp_asyn_axis=named)
    path = run(driven, "%E\nN5 G90 G01 F6000\nN10 Z[INDP_ASYN POS-20 FEED600]\nN20 X5\nN30 X10 Z-20\nM30\n")
    there = first(path, lambda p: p[:, Z] <= -20.0)
    went_on = first(path, lambda p: p[:, X] > 5.0001)
    assert (went_on >= there) is bool(named)
    assert path[-1, Z] == pytest.approx(-20.0), "the program ends when the axis is there"


@pytest.mark.parametrize(
    ("mode", "block", "exact"),
    [(0, "#WAIT INDP [Z]", False), (2, "#WAIT INDP [Z]", True), (1, "G60 X6 Z-20", True), (0, "G60 X6 Z-20", False)],
)
def test_exact_stop_of_what_is_waited_for(mode: int, block: str, exact: bool) -> None:
    setup = replace(SETUP, independent_exact_stop=mode)
    run_ = decode(f"G90 G01 F100\nZ[INDP_ASYN POS-20 FEED600]\nX5\n{block}\nM30", setup)
    waits = [found for found in run_.blocks if isinstance(found, IndependentWait)]
    assert run_.problem is None, run_.problem
    if mode == 0 and "G60" in block:
        assert not waits
    else:
        assert [(found.axes, found.exact) for found in waits] == [((2,), exact)]


def test_an_exact_wait_looks_at_the_axis(tmp_path: Path) -> None:
    """With drives that lag behind: the path goes on only when Z is in its window."""
    driven = with_parameters(tmp_path, ideal=False, mode_exact_stop_indp_axis=2)
    driven.start("%F\nN5 G90 G01 F6000\nN10 Z[INDP_ASYN POS-5 G00]\nN20 #WAIT INDP [Z]\nN30 X5\nM30\n")
    driven.until(lambda: driven.image.target_position[X] > 0.0)
    window = driven.machine.axes[Z].in_position
    assert abs(driven.image.actual_position[Z] + 5.0) <= window * 1.001


@pytest.mark.spec("isg.posax.indp-incl-offsets")
def test_offsets_count_only_where_they_are_asked_for(machine: Driven) -> None:
    path = run(machine, "%G\nN10 G90 G00 X0\nN20 G92 X20\nN30 X[INDP_SYN POS50 G01 FEED6000 G90 INCL_OFFSETS]\nM30\n")
    assert path[-1, X] == pytest.approx(70.0)
    path = run(machine, "%H\nN10 G90\nN20 G92 X20\nN30 X[INDP_SYN POS50 G01 FEED6000 G90]\nP1=V.A.ABS.X\nM30\n")
    assert path[-1, X] == pytest.approx(50.0)


@pytest.mark.spec("isg.posax.indp-syn")
@pytest.mark.parametrize(
    ("words", "velocity", "share"),
    [
        ("G00", 400.0, 1.0),
        ("G01 FEED_MAX_WEIGHT=75", 300.0, 1.0),
        ("G01 FEED=9000 ACC_WEIGHT=10", 150.0, 0.1),
        ("G00 RAPID_ACC_WEIGHT 50", 400.0, 0.5),
    ],
)
def test_speed_and_acceleration_of_an_own_motion(machine: Driven, words: str, velocity: float, share: float) -> None:
    path = run(machine, f"%I\nN10 G90 X[INDP_SYN POS=190 {words}]\nM30\n")
    axis, period = machine.machine.axes[X], machine.simulation.period
    v = np.abs(np.diff(path[:, X])) / period
    assert axis.velocity == 400.0
    assert v.max() == pytest.approx(velocity, rel=1e-3)
    assert np.abs(np.diff(v)).max() / period == pytest.approx(axis.acceleration * share, rel=0.02)


@pytest.mark.spec("isg.posax.indp-syn")
def test_a_motion_in_a_time(machine: Driven) -> None:
    path = run(machine, "%J\nN10 G90 X[INDP_SYN POS=100 G01 TIME=1.5]\nM30\n")
    moving = np.nonzero(np.diff(path[:, X]))[0]
    assert (moving[-1] - moving[0] + 1) * machine.simulation.period == pytest.approx(1.5, abs=0.003)


@pytest.mark.parametrize("seconds", [0.01, 0.2, 0.5, 3.0, 40.0])
@pytest.mark.parametrize("way", [0.001, 1.0, 100.0, 5000.0])
def test_the_speed_for_a_time(seconds: float, way: float) -> None:
    can = AxisDynamics(400.0, 4000.0, 60000.0)
    v = speed_for(seconds, way, can)
    assert 0.0 < v <= can.velocity
    if v < can.velocity:
        assert way / v + ramp_time(v, can) == pytest.approx(seconds, rel=1e-9)


@pytest.mark.spec("isg.posax.general-restrictions")
def test_hold_override_and_reset(machine: Driven) -> None:
    machine.forget()
    machine.start("%K\nN5 G90 G01 F6000\nN10 Z[INDP_ASYN POS-40 G01 FEED1200]\nN20 X100\nM30\n")
    machine.until(lambda: machine.image.target_position[Z] < -10.0)
    machine.operator.override_w = 0
    machine.watch(300)
    held = machine.image.target_position.copy()
    machine.watch(50)
    assert machine.image.target_position.tolist() == held.tolist(), "both stand"
    machine.operator.override_w = 1000
    machine.until(lambda: machine.image.target_position[Z] < -20.0)
    machine.reset()
    machine.until_done()
    machine.watch(50)
    rest = machine.image.target_position.copy()
    assert -40.0 < rest[Z] < -20.0
    machine.watch(20)
    assert machine.image.target_position.tolist() == rest.tolist()
    assert_smooth(machine)
    machine.start("%L\nN10 G90 G01 F6000 Z-1\nM30\n")
    machine.until_done()
    assert machine.image.target_position[Z] == pytest.approx(-1.0), "the next program begins where the axis stands"
    assert_smooth(machine)


@pytest.mark.spec("isg.posax.indp-asyn")
def test_what_asks_for_positions_waits_for_the_axis(machine: Driven) -> None:
    run(
        machine, "%M\nN5 G90 G01 F6000\nN10 Z[INDP_ASYN POS-20 FEED900]\nN20 #CHANNEL INIT [CMDPOS]\nN30 X5 Z-21\nM30\n"
    )
    assert machine.image.target_position[Z] == pytest.approx(-21.0)
    machine.start("%N\nN5 G90 G01 F6000\nN10 Z[INDP_ASYN POS-1 FEED300]\nN20 X1\n#WAIT INDP ALL\nM30\n")
    machine.until(lambda: bool(machine.channel.stop_condition & StopCondition.AXIS_JOB))
    machine.until_done()


@pytest.mark.spec("isg.posax.indp-mh")
@pytest.mark.parametrize("keyword", ["INDP_SYN", "INDP_ASYN"])
def test_functions_of_the_bracket_go_to_the_axis(keyword: str) -> None:
    setup = replace(SETUP, areas={"X": 0, "Y": 1, "Z": 5})
    run_ = decode(f"G90 G01 F100\nZ[{keyword} M10 M11 H20]\nX5 Z[{keyword} POS=5 FEED=100 M12]\nM30", setup)
    assert run_.problem is None, run_.problem
    kinds = [type(found).__name__ for found in run_.blocks]
    functions = [found for found in run_.blocks if type(found).__name__ == "TechnologyFunction"]
    assert {found.area for found in functions} == {5}  # type: ignore[union-attr]
    assert [found.number for found in functions] == [10, 11, 20, 12]  # type: ignore[union-attr]
    assert kinds.index("Wait") < kinds.index("IndependentMotion"), "MVS_SVS is waited for before anything moves"
    last = len(kinds) - 1 - kinds[::-1].index("Wait")
    motion_at = next(i for i, found in enumerate(run_.blocks) if isinstance(found, Line | Polyline | Arc))
    assert last > motion_at, "MVS_SNS at the end of the block"
    waits = [i for i, found in enumerate(run_.blocks) if isinstance(found, IndependentWait)]
    assert bool(waits) is (keyword == "INDP_SYN")
    assert all(motion_at < i < last for i in waits)


@pytest.mark.spec("isg.posax.indp-syn", "isg.posax.indp-asyn")
@pytest.mark.parametrize(
    ("words", "channel", "share"),
    [
        ("", Slope.TRAPEZ, 1.0),
        ("", Slope.SIN2, 2.0 / math.pi),
        ("SLOPE_TYPE=SIN2", Slope.TRAPEZ, 2.0 / math.pi),
        ("SLOPE_PROFIL=2", Slope.TRAPEZ, 2.0 / math.pi),
        ("SLOPE_TYPE=STEP", Slope.SIN2, 1.0),
        ("SLOPE_PROFIL 3", Slope.SIN2, 1.0),
    ],
)
def test_the_slope_of_an_own_motion(words: str, channel: Slope, share: float) -> None:
    can = AxisDynamics(400.0, 4000.0, 60000.0)
    setup = replace(SETUP, axis_dynamics=(can,) * 3, dynamics=replace(SETUP.dynamics, slope=channel))
    found = decode(f"X[INDP_SYN POS=5 FEED=600 {words} \\\n  G90]\nM30", setup)
    assert found.problem is None, found.problem
    (own,) = (block for block in found.blocks if isinstance(block, IndependentMotion))
    assert (own.velocity, own.acceleration, own.jerk) == pytest.approx((10.0, 4000.0, 60000.0 * share))


def refusal(text: str, setup: DecoderSetup = SETUP) -> int:
    """The error of a program, found before its start or on the way."""
    try:
        found = decode(f"G90 G01 F100\n{text}\nM30", setup)
    except ProgramErrors as errors_before:
        return errors_before.problems[0].entry.id
    assert found.problem is not None
    return found.problem.entry.id


BARRED: list[tuple[str, ErrorEntry]] = [
    ("X[INDP_SYN POS=5 G01]", errors.INDEPENDENT_FEED),
    ("X[INDP_SYN POS=5 FEED_MAX_WEIGHT=100]", errors.INDEPENDENT_VALUE),
    ("X[INDP_SYN POS=5 FEED=0]", errors.INDEPENDENT_VALUE),
    ("X[INDP_SYN POS=5 G00 RAPID_ACC_WEIGHT=120]", errors.INDEPENDENT_VALUE),
    ("X[INDP_SYN G100 POS=5 FEED=100]", errors.INDEPENDENT_UNSUPPORTED),
    ("X[INDP_SYN POS=5 FEED=100 DRY_RUN]", errors.INDEPENDENT_UNSUPPORTED),
    ("X[INDP_SYN POS=5 FEED=100 SLOPE_PROFIL=4]", errors.INDEPENDENT_VALUE),
    ("X[INDP_SYN POS=5 FEED=100 SLOPE_TYPE=CUBIC]", language.WORD_UNKNOWN),
    ("X[INDP_SYN FEED=100]", language.KEY_MISSING),
    ("X[INDP_SYN POS=5 FEED=100 TIME=3]", language.KEY_TWICE),
    ("X[INDP_SYN G90 G91 POS=5 FEED=100]", language.KEY_TWICE),
    ("X5 X[INDP_SYN POS=5 FEED=100]", language.WORD_TWICE),
    ("X[INDP_SYN M14]", errors.INDEPENDENT_SYNCH),
    ("X[INDP_ASYN POS=5 FEED=100 M13]", errors.INDEPENDENT_SYNCH),
    ("X[INDP_SYN M99]", language.M_UNDEFINED),
    ("M10 X[INDP_SYN POS=5 FEED=100]", errors.INDEPENDENT_FUNCTION),
    ("G261\nX[INDP_SYN POS=5 FEED=100]", errors.INDEPENDENT_BARRED),
    ("Q[INDP_SYN POS=5 FEED=100]", language.AXIS_UNKNOWN),
]


@pytest.mark.spec("isg.posax.general-restrictions", "isg.posax.indp-syn", "isg.posax.indp-mh")
@pytest.mark.parametrize(("text", "entry"), BARRED)
def test_what_is_refused(text: str, entry: ErrorEntry) -> None:
    setup = replace(SETUP, areas={"X": 0, "Y": 1, "Z": 2}, m_area={10: 0})
    assert refusal(text, setup) == entry.id


@pytest.mark.spec("isg.posax.general-restrictions")
def test_no_own_motion_under_radius_compensation() -> None:
    assert refusal("V.G.WZ_AKT.R=2\nG41 X10\nX20 Z[INDP_SYN POS=5 FEED=100]") == 20651


@pytest.mark.spec("isg.posax.general-restrictions")
def test_no_block_search_goes_over_it_and_no_limit_is_passed(machine: Driven) -> None:
    machine.start("%O\nN10 G90 X[INDP_SYN POS=99999 G00]\nM30\n")
    machine.until(lambda: bool(machine.alarms))
    machine.alarm(motion.SOFTWARE_LIMIT)
    assert machine.image.target_position[X] == 0.0
    machine.reset()
    machine.until(lambda: not machine.channel.active)
    search = machine.operator.block_search
    search.data_w = SearchOrder(type=int(SearchKind.BLOCK_NUMBER), value=30, automatic_return=True, no_hold=True)
    search.semaphor_rw = True
    machine.start("%P\nN10 G90 G01 F1000 X[INDP_SYN POS=9 G00]\nN20 X10\nN30 X20\nM30\n")
    machine.until(lambda: not machine.channel.active)
    machine.alarm(block_search.SEARCH_STOPS_HERE)
    assert machine.image.target_position[X] == 0.0


@pytest.mark.spec("isg.posax.general-restrictions")
def test_a_turntable_takes_the_shorter_way() -> None:
    setup = replace(
        SETUP,
        axes=("X", "Y", "C"),
        zero_offsets={},
        linear=(True, True, False),
        position_limits=((None, None), (None, None), (None, None)),
    )
    found = decode("G90\nC[INDP_SYN POS=270 G00]\nC[INDP_SYN POS=0 G00]\nG91 C[INDP_SYN POS=400 G00]\nM30", setup)
    assert found.problem is None, found.problem
    targets = [block.target for block in found.blocks if isinstance(block, IndependentMotion)]
    assert targets == pytest.approx([-90.0, 0.0, 400.0])
