"""System variables of the NCT dialect on the machine: alarm, stop with a message, timer, positions, suppression."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import machine as alarms
from runtime.diagnostics.events import EventKind
from runtime.hli.layout import StopCondition
from tests.machine.driven import Driven


@pytest.fixture
def driven(demo: Machine, tmp_path: Path) -> Driven:
    return Driven(demo, tmp_path, dialect="nct", plc=False)


def common(driven: Driven, number: int) -> float | None:
    decoder = driven.simulation.preparation.decoder
    assert decoder is not None
    return decoder.execution.memory.common.read(number)


def x_of(driven: Driven) -> float:
    """X as the program counts it."""
    return float(driven.channel.interpolator.position[0]) - driven.machine.channels[0].zero_offsets["G54"]["X"]


@pytest.mark.spec("nct.sysvar.alarm-3000")
def test_the_alarm_ends_the_program_behind_the_block_before(driven: Driven) -> None:
    driven.start("%O0001(ALARM)\nG90 G0 X20\nX30\n#3000=17(CLAMP IS OPEN)\nX40\nM30\n")
    driven.until_done()
    assert x_of(driven) == pytest.approx(30.0)
    told = [problem for problem in driven.simulation.problems if problem.entry is alarms.USER_ERROR]
    assert [problem.text for problem in told] == ["4017 CLAMP IS OPEN"]
    assert told[0].place.line == 4
    assert driven.channel.error is not None  # until a reset
    driven.reset()
    assert driven.channel.error is None


@pytest.mark.spec("nct.sysvar.stop-message-3006")
def test_the_stop_waits_for_start(driven: Driven) -> None:
    driven.start("%O0001(STOP)\nG90 G0 X20\n#3006=5(TURN THE PART)\nX40\nM30\n")
    driven.until(lambda: bool(driven.channel.stop_condition & StopCondition.WAIT_CONTINUE))
    driven.watch(200)
    assert x_of(driven) == pytest.approx(20.0)
    texts = [event.text for event in driven.simulation.log if event.kind is EventKind.MESSAGE]
    assert texts == ["5005 TURN THE PART"]
    driven.operator.continue_motion_rw = True
    driven.until_done()
    assert x_of(driven) == pytest.approx(40.0)


def test_the_timer_measures_what_moves(driven: Driven) -> None:
    driven.start("%O0001(TIME)\nG90 G0 X20\n#3001=0\nG4 P0.5\n#100=#3001\nM30\n")
    driven.until_done()
    assert common(driven, 100) == pytest.approx(500.0, abs=20.0)  # the accuracy that is promised


def test_positions_are_those_of_the_axes_that_stand(driven: Driven) -> None:
    text = "G90 G0 X20\n#100=#5001\n#101=#5021\n#102=#5041\n#103=#5101\nX50\n#104=#5041\nM30\n"
    driven.start(f"%O0001(PLACES)\n{text}")
    driven.until_done()
    offset = driven.machine.channels[0].zero_offsets["G54"]["X"]
    found = [common(driven, number) for number in range(100, 105)]
    assert found[:3] == pytest.approx([20.0, 20.0 + offset, 20.0], abs=1e-3)
    assert found[3] == pytest.approx(0.0, abs=0.05)
    assert found[4] == pytest.approx(50.0, abs=1e-3)


@pytest.mark.spec("nct.sysvar.suppression-3003-3004")
def test_stop_and_single_block_without_effect(driven: Driven) -> None:
    driven.operator.single_block_w = True
    driven.start("%O0001(QUIET)\n#3003=1\n#3004=3\nG90 G1 X20 F3000\nX40\n#3004=0\n#3003=0\nX60\nX70\nM30\n")
    driven.until(lambda: x_of(driven) > 10.0)
    driven.operator.feedhold_w = True
    driven.operator.override_w = 100
    driven.until(lambda: driven.channel.held)
    assert x_of(driven) == pytest.approx(40.0, abs=2.0)
    driven.operator.feedhold_w = False
    driven.operator.override_w = 1000
    driven.until(lambda: bool(driven.channel.stop_condition & StopCondition.SINGLE_BLOCK))
    assert x_of(driven) == pytest.approx(60.0)
    driven.operator.single_block_w = False
    driven.operator.continue_motion_rw = True
    driven.until_done()
    assert driven.alarms == []
