"""G31 of the NCT dialect on the whole machine: a signal ends the motion, #5061 is where it came, the program goes on there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from runtime.cnc.language.nct.functions import Value
from runtime.config.machine import Machine
from runtime.config.nct import NctParameters
from runtime.diagnostics.catalogue import nct as errors
from runtime.hli.layout import State
from tests.machine.driven import Driven
from tests.machine.scripted_plc import ScriptedPlc
from tests.machine.test_measuring import EDGE, measuring_machine, touched_machine
from tests.machine.test_single_step import stops

Make = Callable[..., Driven]
ZERO = 100.0  # of G54 in X, as the demo machine has it


@pytest.fixture
def make(demo: Machine, tmp_path: Path) -> Make:
    def build(probe: float | None = EDGE, **nct: Any) -> Driven:
        machine = measuring_machine(demo, probe)
        channel = machine.channels[0].model_copy(update={"dialect": "nct", "nct": NctParameters(**nct)})
        machine = machine.model_copy(update={"channels": (channel,)})
        return Driven(machine, tmp_path, partner=lambda memory: ScriptedPlc(memory, {}))

    return build


def common(driven: Driven, number: int) -> Value:
    decoder = driven.simulation.preparation.decoder
    assert decoder is not None
    return decoder.execution.memory.common.read(number)


def begin(text: str) -> str:
    return f"%O0001\nN10 G90 G54 G21 G17 G94 G1 X-90 Y0 F3000\n{text}M30\n%\n"


@pytest.mark.spec("nct.meas.skip-g31", "nct.sysvar.positions")
@pytest.mark.parametrize("feed", [300, 3000])
def test_the_program_goes_on_from_where_the_signal_has_stopped_the_path(make: Make, feed: int) -> None:
    driven = make()
    driven.start(begin(f"N20 G31 G91 X100 F{feed}\nN30 #100=#5061\n#101=#5001\n#102=#5062\nN40 X30 F3000\n"))
    driven.until_done()
    assert driven.alarms == []
    skipped, stood = common(driven, 100), common(driven, 101)
    assert isinstance(skipped, float)
    assert isinstance(stood, float)
    assert skipped == pytest.approx(EDGE - ZERO, abs=1e-3)
    x = driven.machine.axes[0]
    v = feed / 60.0
    braking = v * v / (2.0 * x.acceleration) + v * x.acceleration / (2.0 * x.jerk)
    assert skipped < stood < skipped + braking + 6 * v * 0.001
    assert float(driven.image.target_position[0]) == pytest.approx(stood + ZERO + 30.0, abs=1e-3)
    assert common(driven, 102) == pytest.approx(0.0, abs=1e-3)
    driven.assert_brakes_within_limits([0, 1])


@pytest.mark.spec("nct.meas.skip-g31")
def test_without_a_signal_it_ends_where_it_was_to(make: Make) -> None:
    driven = make(probe=None)
    driven.start(begin("N20 G31 X-40 F3000\nN30 #100=#5061\nN40 G91 X5\n"))
    driven.until_done()
    assert driven.alarms == []
    assert common(driven, 100) == pytest.approx(-40.0)
    assert float(driven.image.target_position[0]) == pytest.approx(ZERO - 35.0)


@pytest.mark.spec("nct.meas.skip-g31")
def test_an_absolute_block_behind_it_leads_to_its_place(make: Make) -> None:
    driven = make()
    driven.start(begin("N20 G31 X0 F600\nN30 X-20 Y10 F3000\n"))
    driven.until_done()
    assert driven.alarms == []
    assert float(driven.image.target_position[0]) == pytest.approx(ZERO - 20.0)


@pytest.mark.spec("nct.meas.skip-g31")
def test_its_feed_is_that_of_the_parameters_with_skipf(make: Make) -> None:
    def cycles(**nct: Any) -> int:
        driven = make(probe=None, **nct)
        driven.start(begin("N20 G31 X-50 F6000\n"))
        return driven.until(lambda: not driven.channel.active)

    assert cycles(skipf=True, g31fd=600.0 / 60.0) - cycles() == pytest.approx(4000 - 400, rel=0.15)


def test_single_block_stops_once_behind_it(make: Make) -> None:
    driven = make()
    driven.operator.single_block_w = True
    driven.start(begin("N20 G31 X0 F600\nN30 X-20 F3000\n"))
    assert stops(driven) == [2, 3, 4]
    assert driven.alarms == []


def test_feed_hold_and_reset_in_it(make: Make) -> None:
    driven = make()
    driven.start(begin("N20 G31 X0 F300\nN30 X-20 F3000\n"))
    driven.until_x(15.0)
    driven.operator.feedhold_w = True
    driven.watch(300)
    stood = float(driven.image.target_position[0])
    driven.watch(50)
    assert float(driven.image.target_position[0]) == stood < EDGE
    driven.reset()
    driven.operator.feedhold_w = False
    driven.watch(100)
    assert driven.state() is State.SELECTED
    driven.start(begin("N20 X-30\n"))
    driven.until_done()
    assert float(driven.image.target_position[0]) == pytest.approx(ZERO - 30.0)


@pytest.mark.spec("nct.meas.skip-g31")
@pytest.mark.parametrize(
    ("text", "entry", "said"),
    [
        ("N20 G31\n", errors.G31_FORMAT, "an axis is wanted"),
        ("N20 G31 X0 P4\n", errors.G31_FORMAT, "P is 0, 1, 2 or 3"),
        ("N20 G31 X0 P1\n", errors.G31_FORMAT, "skip signal 2"),
        ("N20 G31 Z0\n", errors.G31_FORMAT, "axis Z has no probe"),
        ("N20 G95 F1\nG31 X0\n", errors.G31_STATE, "G95"),
        ("N20 G51 X0 Y0 P2\nG31 X0\n", errors.G31_STATE, "G51"),
        ("N20 G51.1 X0\nG31 X0\n", errors.G31_STATE, "G51.1"),
        ("N20 G68 X0 Y0 R30\nG31 X0\n", errors.G31_STATE, "G68"),
        ("N20 G16\nG31 X0 Y0\n", errors.G31_STATE, "G16"),
        ("N20 G10 L12 P1 R1\nG41 D1 X-80\nG31 X0\n", errors.G31_STATE, "G41"),
    ],
)
def test_what_is_refused(make: Make, text: str, entry: Any, said: str) -> None:
    driven = make()
    driven.start(begin(text))
    driven.until_done()
    alarm = driven.alarm(entry)
    assert said in alarm.text


def test_the_signal_of_an_input(demo: Machine, tmp_path: Path) -> None:
    """The second skip signal is an input that tells when the probe touches the box, which begins at X 30."""
    machine = touched_machine(demo)
    skip = NctParameters(skip=(machine.fieldbus.io[0].inputs[0], "touched"))
    channel = machine.channels[0].model_copy(update={"dialect": "nct", "nct": skip})
    machine = machine.model_copy(update={"channels": (channel,)})
    driven = Driven(machine, tmp_path, partner=lambda memory: ScriptedPlc(memory, {}))
    driven.start("%O0001\nN10 G90 G53 G0 X0 Y30\nN20 G31 G91 X60 P1 F600\nN30 #100=#5061\nM30\n%\n")
    driven.until_done()
    assert driven.alarms == []
    assert common(driven, 100) == pytest.approx(30.0 - ZERO, abs=4 * 600 / 60 * 0.001)
