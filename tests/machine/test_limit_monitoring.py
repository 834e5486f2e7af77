"""How the channel watches software limits on the path (P-CHAN-00120, P-CHAN-00147, P-CHAN-00459, P-CHAN-00498)."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import axes, language, motion
from runtime.hli.layout import ManualMode, State
from tests.machine.driven import Driven
from tests.machine.scripted_plc import ScriptedPlc
from tests.machine.test_modes import Hand, with_channel

BEYOND = 660.0  # mm: the limit of X is 650


def make(machine: Machine, folder: Path, **parameters: object) -> Driven:
    described = with_channel(machine, **parameters)
    tolerant = tuple(axis.model_copy(update={"limit_tolerance": 0.5}) for axis in described.axes)
    described = described.model_copy(update={"axes": tolerant})
    return Driven(described, folder, ideal_axes=True, partner=lambda memory: ScriptedPlc(memory, {}))


def run(driven: Driven, text: str) -> list[int]:
    """A program to its end, or its error; ids of what it has told."""
    driven.forget()
    driven.start(text)
    driven.until_done()
    return [event.number for event in driven.errors]


def place(driven: Driven) -> list[float]:
    return [round(float(p), 6) + 0.0 for p in driven.channel.interpolator.position[:3]]


@pytest.mark.spec("chan.sls.command-side")
def test_a_target_beyond_a_limit_stops_the_program_until_reset(demo: Machine, tmp_path: Path) -> None:
    driven = make(demo, tmp_path)
    text = f"%T\nG90 G01 F9000 X600\nY5\nX{BEYOND}\nY0\nM30\n"
    assert run(driven, text) == [motion.SOFTWARE_LIMIT.id]
    assert place(driven) == [600, 5, 0]
    assert driven.state() is State.ERROR
    driven.start("%U\nG90 G01 F9000 X500\nM30\n")
    driven.watch(500)
    assert place(driven) == [600, 5, 0]
    driven.reset()
    driven.watch(10)
    assert run(driven, "%U\nG90 G01 F9000 X500\nM30\n") == []
    assert place(driven) == [500, 5, 0]


@pytest.mark.spec("chan.sls.command-side")
def test_an_axis_that_only_warns_goes_on(demo: Machine, tmp_path: Path) -> None:
    driven = make(demo, tmp_path, soft_limit_warning_axes=0x1)
    assert run(driven, f"%T\nG90 G01 F9000 X{BEYOND}\nY5\nX0\nM30\n") == [
        axes.LIMIT_WARNING.id,  # of the two blocks that end there
        axes.LIMIT_WARNING.id,
        axes.LIMIT_PASSED.id,
    ]
    assert place(driven) == [0, 5, 0]
    assert run(driven, "%T\nG90 G01 F9000 X0\nY705\nM30\n") == [motion.SOFTWARE_LIMIT.id]


@pytest.mark.spec("chan.sls.command-side")
def test_an_axis_without_monitoring_goes_on_in_silence(demo: Machine, tmp_path: Path) -> None:
    driven = make(demo, tmp_path, suppress_soft_limit_monitoring_axes=0x1)
    assert run(driven, f"%T\nG90 G01 F9000 X{BEYOND}\nG99 X100\nX200\nM30\n") == []
    assert place(driven) == [200, 0, 0]
    assert run(driven, "%T\nG90 G01 F9000 Y705\nM30\n") == [motion.SOFTWARE_LIMIT.id]


@pytest.mark.spec("chan.sls.command-side")
@pytest.mark.parametrize(("tolerant", "at", "good"), [(True, 650.4, True), (True, 650.6, False), (False, 650.4, False)])
def test_an_axis_that_stands_a_little_beyond(
    demo: Machine, tmp_path: Path, tolerant: bool, at: float, good: bool
) -> None:
    """It may stay there while others move, with the tolerance; it may not be moved but back."""
    driven = make(demo, tmp_path, soft_limit_tolerance=tolerant)
    assert run(driven, f"%S\nX[SET_POSITION POS={at}]\nM30\n") == []
    assert run(driven, "%T\nG90 G01 F9000 Y5\nM30\n") == ([] if good else [motion.SOFTWARE_LIMIT.id])
    assert place(driven) == [at, 5 if good else 0, 0]
    if good:
        assert run(driven, "%T\nG90 G01 F9000 X650.3\nM30\n") == [motion.SOFTWARE_LIMIT.id]
        driven.reset()
        driven.watch(10)
        assert run(driven, "%T\nG90 G01 F9000 X640 Y0\nM30\n") == []
        assert place(driven) == [640, 0, 0]


@pytest.mark.spec("chan.sls.command-side")
@pytest.mark.parametrize(("relative", "mask", "furthest"), [(True, 0x2, 60.0), (True, 0x0, 50.0), (False, 0x2, 50.0)])
def test_without_monitoring_the_hand_beside_the_path_has_its_relative_limits(
    demo: Machine, tmp_path: Path, relative: bool, mask: int, furthest: float
) -> None:
    """Y stands at 0, its software limit is -50; without relative limits that one stays."""
    driven = make(demo, tmp_path, suppress_soft_limit_monitoring_axes=mask)
    hand = Hand(driven)
    limits = "#MANUAL LIMITS [AX=Y NEGATIVE=-60 POSITIVE=60]\n" if relative else ""
    driven.start(f"%T\n{limits}G90 G01 F1000 X1\nG201 Y1\nX400\nM30\n")
    driven.until_x(2.0)
    hand.parameter("continuous_parameter", 2, velocity=100.0)
    hand.link(2, 2, ManualMode.CONTINUOUS)
    hand.press(2, 0)
    hand.press(2, -1)
    driven.watch(3000)
    assert place(driven)[0] < 100
    assert driven.channel.beside.by_hand[1] == pytest.approx(-furthest, abs=1e-3)
    assert driven.alarms == []


@pytest.mark.spec("chan.sls.programmed")
@pytest.mark.parametrize("clamped", [False, True])
def test_programmed_limits_beyond_those_of_the_axis(demo: Machine, tmp_path: Path, clamped: bool) -> None:
    """They hold, or the configured ones do."""
    driven = make(demo, tmp_path, range_check_prog_soft_limits=clamped)
    told = run(driven, f"%T\nG99 X{BEYOND}\nG98 Y-60\nG90 G01 F9000 X{BEYOND - 1} Y-55\nM30\n")
    kept = [language.LIMIT_CLAMPED_POSITIVE.id, language.LIMIT_CLAMPED_NEGATIVE.id]
    assert told == ([*kept, motion.SOFTWARE_LIMIT.id] if clamped else [])
    assert place(driven) == ([0, 0, 0] if clamped else [BEYOND - 1, -55, 0])


@pytest.mark.spec("chan.sls.programmed")
@pytest.mark.parametrize("clamped", [False, True])
def test_programmed_limits_within_those_of_the_axis_hold_always(demo: Machine, tmp_path: Path, clamped: bool) -> None:
    driven = make(demo, tmp_path, range_check_prog_soft_limits=clamped)
    assert run(driven, "%T\nG99 X100\nG90 G01 F9000 X101\nM30\n") == [motion.SOFTWARE_LIMIT.id]
