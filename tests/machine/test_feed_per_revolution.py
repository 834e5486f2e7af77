"""G95 on the whole machine: the path is as fast as the spindle turns, at every moment."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from runtime.config.machine import Machine
from runtime.hli.layout import StopCondition
from tests.machine.test_spindles import Run
from tests.machine.with_spindle import Followed, assert_within_limits

SPEC = "isg.turn.feed-per-rev-g95"


def feed(run: Followed) -> float:
    """mm/min along the path."""
    return run.path.path_velocity * 60.0


@pytest.mark.spec(SPEC)
def test_the_example_of_the_manual(demo: Machine, tmp_path: Path) -> None:
    text = "N10 F1000 G01 X0 Z50 M3 S1200\nN20 G95 F1.5\nN30 Z0\nN40 G94 X50\nN50 G93 F2 X20\nN60 G95 Y100 S2000\nN70 M30\n"
    run = Followed(demo, text, tmp_path)
    feeds: dict[int, list[float]] = {}
    while run.channel.active:
        run.cycle()
        feeds.setdefault(run.path.n, []).append(feed(run))
    steady = {n: float(np.median(of)) for n, of in feeds.items()}
    assert steady[10] == pytest.approx(1000.0)
    assert steady[30] == pytest.approx(1800.0)
    assert steady[40] == pytest.approx(1000.0)
    assert steady[50] == pytest.approx(900.0)  # 30 mm in 2 s
    assert steady[60] == pytest.approx(3000.0)


@pytest.mark.spec(SPEC)
def test_the_path_follows_the_spindle_within_the_limits_of_the_axes(demo: Machine, tmp_path: Path) -> None:
    run = Followed(demo, "G90 G95 F0.5\nM3 S2000\nG01 X100\nG94 F600 X120\nM30\n", tmp_path)
    unit = run.hli.axes[3].control.override
    run.until(lambda: run.x > 10.0)
    assert feed(run) == pytest.approx(1000.0)
    unit.enable_w, unit.command_w = True, 500
    run.until(lambda: run.x > 30.0)
    assert feed(run) == pytest.approx(500.0)
    unit.command_w = 1500
    run.until(lambda: run.x > 60.0)
    assert feed(run) == pytest.approx(1500.0)
    run.hli.operator[0].override_w = 500  # that of the path counts too
    run.until(lambda: run.x > 80.0)
    assert feed(run) == pytest.approx(750.0)
    run.until(lambda: run.x > 110.0)
    assert feed(run) == pytest.approx(300.0)  # G94 does not know of the spindle
    told = run.told
    assert_within_limits(run.machine, told, run.simulation.period)


@pytest.mark.spec(SPEC)
def test_a_spindle_that_stands_keeps_the_path_and_says_why(demo: Machine, tmp_path: Path) -> None:
    run = Followed(demo, "G90 G01 F3000 X5\nS1000\nG95 F1\nX10\nX20\nM30\n", tmp_path)
    run.until(lambda: run.path.standstill and run.x >= 5.0)
    run.cycle(300)
    assert run.x == pytest.approx(5.0)
    assert run.channel.stop_condition & StopCondition.WAIT_SPINDLE
    run.spindles[0].mode = type(run.spindles[0].mode).M3  # somebody lets it turn
    run.spindles[0].change_speed(0.0, 0.0)
    run.spindles[0].change_speed(6000.0, 0.0)
    run.until(lambda: run.x > 12.0)
    run.spindles[0].stop()
    run.cycle(500)
    assert run.path.standstill
    assert 12.0 < run.x < 20.0
    assert run.channel.stop_condition & StopCondition.WAIT_SPINDLE


@pytest.mark.spec(SPEC)
def test_each_block_follows_its_own_main_spindle(demo: Machine, tmp_path: Path) -> None:
    text = "G90 G95 F1\nS2[M3 REV600]\n#MAIN SPINDLE [S2]\nG01 X10\n#MAIN SPINDLE\nM3 S900\nX20\nG00 X40\nM30\n"
    run = Followed(demo, text, tmp_path)
    run.until(lambda: run.x > 6.0)
    assert feed(run) == pytest.approx(600.0)
    run.until(lambda: run.x > 16.0)
    assert feed(run) == pytest.approx(900.0)
    fastest = 0.0
    while run.channel.active:
        run.cycle()
        fastest = max(fastest, feed(run))
    assert fastest > 5000.0  # rapid


@pytest.mark.spec(SPEC)
def test_of_a_spindle_of_the_plc_only_what_is_programmed_counts(demo: Machine, tmp_path: Path) -> None:
    spindles = tuple(s.model_copy(update={"plc_control": True}) for s in demo.channels[0].parameters.spindel)
    parameters = demo.channels[0].parameters.model_copy(update={"spindel": spindles})
    machine = demo.model_copy(update={"channels": (demo.channels[0].model_copy(update={"parameters": parameters}),)})
    path = tmp_path / "t.nc"
    path.write_text("%T\nG90 G95 F1\nM3 S600\nG01 X10\nM30\n")
    run = Run(machine, path, {(3, 3): 0.01})
    run.until(lambda: run.x > 5.0)
    assert run.speed(0) == 0.0
    assert run.path.path_velocity * 60.0 == pytest.approx(600.0)
