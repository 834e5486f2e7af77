"""Drilling cycles of the NCT dialect on the machine: single block, and the operator's stop in a thread."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.cnc.axes.spindle import SpindleMode
from runtime.config.machine import Machine
from runtime.diagnostics.events import EventKind
from runtime.hli.layout import StopCondition
from tests.machine.driven import Driven
from tests.machine.scripted_plc import ScriptedPlc
from tests.machine.test_modes import Hand, place
from tests.machine.test_spindles import Run, machine_with
from tests.machine.test_tapping import off_the_thread
from tests.machine.with_spindle import TYPES, Followed

DRILL = "%O0001(DRILL)\nG90 G17 G0 X0 Y0 Z60\nG81 X10 Z45 R50 F3000\nX20\nG80\nM30\n"
TAP = "%O0002(TAP)\nG90 G17 G0 X0 Y0 Z60\nS600 M3\nG99 G84 X10 Z20 R50 F900\nG80 X20\nM30\n"  # 1.5 mm


def driven_by(machine: Machine, folder: Path) -> Driven:
    return Driven(machine, folder, dialect="nct", plc=False)


def z_of(driven: Driven) -> float:
    """Z as the program counts it: G54 of the demo machine lies at -120."""
    return float(driven.channel.interpolator.position[2]) - driven.machine.channels[0].zero_offsets["G54"]["Z"]


@pytest.mark.spec("nct.cycle.interaction-rules")
def test_single_block_stops_behind_operations_1_3_and_10(demo: Machine, tmp_path: Path) -> None:
    driven = driven_by(demo, tmp_path)
    driven.operator.single_block_w = True
    driven.start(DRILL)
    places: list[tuple[float, float]] = []
    for _ in range(40_000):
        driven.watch(1)
        if not driven.channel.active:
            break
        if driven.channel.stop_condition & StopCondition.SINGLE_BLOCK:
            x = float(driven.channel.interpolator.position[0]) - driven.machine.channels[0].zero_offsets["G54"]["X"]
            places.append((round(x, 3), round(z_of(driven), 3)))
            driven.operator.continue_motion_rw = True
            driven.watch(1)
    hole = [(10.0, 60.0), (10.0, 50.0), (10.0, 60.0)]
    assert places == [(0.0, 60.0), *hole, *((x + 10.0, z) for x, z in hole)]
    assert driven.alarms == []


@pytest.mark.spec("nct.cycle.tapping-g84")
def test_a_stop_in_the_thread_waits_for_point_r(demo: Machine, tmp_path: Path) -> None:
    driven = driven_by(demo, tmp_path)
    driven.start(TAP)
    driven.until(lambda: driven.channel.interpolator.line == 4 and z_of(driven) < 45.0)
    driven.operator.feedhold_w = True
    driven.operator.override_w = 500
    lowest = z_of(driven)
    speeds = []
    while not driven.channel.held:
        driven.watch(1)
        lowest = min(lowest, z_of(driven))
        speeds.append(driven.channel.interpolator.path_velocity)
    assert lowest == pytest.approx(20.0, abs=1e-6)
    assert max(speeds) == pytest.approx(15.0, rel=1e-3)  # 900 mm/min, whatever the override says
    assert z_of(driven) == pytest.approx(50.0, abs=1e-6)
    driven.operator.feedhold_w = False
    driven.until_done()
    assert driven.alarms == []


@pytest.mark.spec("nct.cycle.tapping-g84")
def test_a_stop_before_the_thread_keeps_the_tool_out(demo: Machine, tmp_path: Path) -> None:
    driven = driven_by(demo, tmp_path)
    driven.start(TAP)
    driven.until(lambda: driven.channel.interpolator.line == 4 and 50.0 < z_of(driven) < 52.0)
    driven.operator.feedhold_w = True
    driven.watch(1000)
    assert driven.channel.held
    assert z_of(driven) >= 50.0 - 1e-6
    driven.operator.feedhold_w = False
    driven.until_done()
    assert driven.alarms == []


MANUAL = "%O0003(BY HAND)\nG90 G17 G0 X0 Y0 Z60\nS600 M3\n{cycle} X10 Z40 R50 F3000 M8\nX30\nG80\nM30\n"


@pytest.mark.parametrize(
    ("cycle", "level"),
    [
        pytest.param("G88 P0.1", 60.0, marks=pytest.mark.spec("nct.cycle.manual-boring-g88")),
        pytest.param("G99 G88", 50.0, marks=pytest.mark.spec("nct.cycle.manual-boring-g88")),
        pytest.param("G87", 60.0, marks=pytest.mark.spec("nct.cycle.manual-boring-g87a")),
        pytest.param("G99 G87", 50.0, marks=pytest.mark.spec("nct.cycle.manual-boring-g87a")),
    ],
)
def test_the_operator_moves_the_tool_at_the_bottom(demo: Machine, tmp_path: Path, cycle: str, level: float) -> None:
    driven = Driven(
        demo, tmp_path, ideal_axes=True, dialect="nct", partner=lambda memory: ScriptedPlc(memory, {})
    )  # fmt: skip
    hand = Hand(driven)
    spindle = driven.channel.spindles[0]
    x_zero = driven.machine.channels[0].zero_offsets["G54"]["X"]
    driven.start(MANUAL.format(cycle=cycle))
    for hole in (10.0, 30.0):
        driven.until(lambda: bool(driven.channel.stop_condition & StopCondition.MANUAL))
        driven.watch(2)
        assert z_of(driven) == pytest.approx(40.0, abs=1e-6)
        assert place(driven) - x_zero == pytest.approx(hole, abs=1e-6)
        assert spindle.mode is SpindleMode.M5
        hand.press(1, 1)  # X away from the wall
        driven.watch(100)
        hand.press(1, 0)
        hand.rest()
        moved = place(driven)
        assert moved - x_zero > hole + 0.5
        driven.operator.continue_motion_rw = True
        driven.until(lambda: z_of(driven) >= level - 1e-6)
        assert place(driven) == pytest.approx(moved)
        driven.until(lambda: spindle.mode is SpindleMode.M3)
        assert z_of(driven) == pytest.approx(level, abs=1e-6)
    driven.until_done()
    assert driven.alarms == []
    driven.assert_no_jump()
    coolant = [event for event in driven.simulation.log if event.kind is EventKind.M_OUT and event.number == 8]
    assert len(coolant) == 1  # M8 stands in the block of the cycle, which is executed twice


RIGID = "%O0004(RIGID)\nG90 G17 G0 X0 Y0 Z60\n{mode} S{speed}\n{cycle} X10 Z40 R50 F{feed}\nX20\nG80 X0\nM30\n"


class Rigid(Followed):
    """A run of a program of the dialect with a spindle that can follow the path."""

    def __init__(self, demo: Machine, text: str, folder: Path) -> None:
        machine = machine_with(demo, TYPES)
        channel = machine.channels[0]
        parameters = channel.nct.model_copy(update={"index1": True})
        changed = channel.model_copy(update={"dialect": "nct", "nct": parameters})
        self.machine = machine.model_copy(update={"channels": (changed,)})
        path = folder / "o0004.nc"
        path.write_text(text)
        self._rows: list[tuple[float, ...]] = []
        Run.__init__(self, self.machine, path)


@pytest.mark.spec("nct.cycle.rigid-tapping-g84-2-g84-3")
@pytest.mark.parametrize(
    ("cycle", "mode", "feed", "pitch"),
    [("G84.2", "G94", 900, 1.5), ("G99 G84.3", "G94", 900, -1.5), ("G84.2", "G95", 2, 2.0)],
)
def test_the_spindle_follows_the_drilling_axis(
    demo: Machine, tmp_path: Path, cycle: str, mode: str, feed: float, pitch: float
) -> None:
    """Also through an override and a feed hold in the hole; at the end it stands."""
    run = Rigid(demo, RIGID.format(cycle=cycle, mode=mode, feed=feed, speed=600), tmp_path)
    run.until(lambda: run.channel.together.tapping)
    run.hli.operator[0].override_w = 600
    run.cycle(100)
    run.hli.operator[0].feedhold_w = True
    run.cycle(200)
    assert run.channel.held
    run.hli.operator[0].feedhold_w = False
    run.until(lambda: not run.channel.active, 60.0)
    told = run.told
    assert len(told.sections) == 2
    for section in told.sections:
        assert off_the_thread(told, section, pitch) <= 1e-6
        depths = told.axes[section, 2]
        assert depths.max() - depths.min() == pytest.approx(10.0, abs=1e-6)
    assert run.spindles[0].mode is SpindleMode.M5
    assert run.ids() == []
