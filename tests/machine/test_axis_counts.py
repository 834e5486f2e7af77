"""SET_POSITION, POS_LIMIT and axes that turn without end, on the whole machine in virtual time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from runtime.config import load_machine
from runtime.config.loader import DEMO_MACHINE
from runtime.diagnostics.catalogue import axes as errors
from runtime.diagnostics.catalogue import motion
from tests.machine.driven import Driven

TURNTABLE = """  - name: C
    type: rotary
    log_axis: 9
    velocity: 360
    acceleration: 3000
    jerk: 100000
    drive: {node: 9, increments_per_unit: 1000, vendor_id: 0x7A4D, product_code: 0x402}
"""


def driven(folder: Path, *, ideal: bool = True) -> Driven:
    text = DEMO_MACHINE.read_text().replace("channels:\n", TURNTABLE + "channels:\n", 1)
    text = text.replace("axes: [X, Y, Z]", "axes: [X, Y, Z, C]", 1)
    (folder / "machine.yaml").write_text(text)
    return Driven(load_machine(folder / "machine.yaml"), folder, ideal_axes=ideal)


def run(machine: Driven, text: str) -> None:
    machine.forget()
    machine.start(text)
    machine.until_done()


def shown(machine: Driven, axis: str) -> float:
    return float(machine.hli.axes[machine.machine.axis_index(axis)].status.command_position_r) * 1e-4


@pytest.mark.spec("isg.modulo.absolute-sign-programming", "isg.modulo.incremental-programming")
def test_a_turntable_turns_on_and_shows_its_angle(tmp_path: Path) -> None:
    machine = driven(tmp_path)
    run(machine, "%A\nN10 G90 G01 F20000 C+350\nN20 C+10\nN30 G91 C+720\nN40 G90 C-0\nM30\n")
    index = machine.machine.axis_index("C")
    path = np.array(machine.targets)[:, index]
    assert not machine.simulation.problems
    assert path[-1] == pytest.approx(1080.0, abs=1e-9)
    assert path.max() == pytest.approx(1090.0, abs=1e-3)
    assert np.abs(np.diff(path)).max() <= 360.0 * machine.simulation.period * 1.001
    assert shown(machine, "C") == pytest.approx(0.0)


@pytest.mark.spec("isg.axis.set-position")
@pytest.mark.parametrize("ideal", [True, False])
def test_set_position_moves_nothing(tmp_path: Path, ideal: bool) -> None:
    machine = driven(tmp_path, ideal=ideal)
    run(
        machine,
        "%B\nN10 G90 G54 G01 F6000 X20\nN20 G92 X5\nN30 X[SET_POSITION POS=100]\nP1=V.A.ABS.X\nN40 G01 X100\n"
        "N50 X[SET_POSITION OFFSET=-50]\nN60 G91 X1\nN70 G90 X0\nM30\n",
    )
    assert not machine.simulation.problems
    image, axis = machine.image, machine.machine.axes[0]
    jumps = np.abs(np.diff(np.array(machine.targets)[:, 0])) > axis.velocity * machine.simulation.period * 1.01
    assert jumps.sum() == 2, "the count jumps, twice"
    program = machine.simulation.preparation.decoder
    assert program is not None
    assert program.parameters[1] == pytest.approx(100.0)
    zero = float(program.execution.coordinates.offsets.zero[0])
    assert image.target_position[0] == pytest.approx(zero + 5.0), "G54 and G92 hold on"
    assert image.origin[0] == pytest.approx(100.0 - (20.0 + zero) - 50.0), "by which the axis counts anew"


@pytest.mark.spec("isg.axis.pos-limit")
def test_a_limit_of_the_program_is_an_error_before_the_motion(tmp_path: Path) -> None:
    machine = driven(tmp_path)
    run(machine, "%C\nN10 X[POS_LIMIT ON MAX=10]\nN20 G90 G01 F6000 X9\nN30 X11\nM30\n")
    machine.alarm(motion.SOFTWARE_LIMIT)
    assert np.array(machine.targets)[:, 0].max() <= 9.0 + 1e-9
    machine.reset()
    run(machine, "%C\nN10 G90 G01 F6000 X11\nM30\n")
    assert machine.image.target_position[0] == pytest.approx(11.0), "the next program has the configured limits"


@pytest.mark.spec("isg.axis.pos-limit")
def test_a_limit_that_only_warns(tmp_path: Path) -> None:
    machine = driven(tmp_path)
    run(machine, "%D\nN10 X[POS_LIMIT ON MAX=10 BEHAVIOUR=WARNING]\nN20 G90 G01 F6000 X12\nN30 X0\nM30\n")
    machine.alarm(errors.LIMIT_PASSED)
    assert np.array(machine.targets)[:, 0].max() == pytest.approx(12.0, abs=0.01)
    assert machine.image.target_position[0] == pytest.approx(0.0)


@pytest.mark.spec("isg.axis.pos-limit")
def test_an_actual_position_beyond_its_limit_stops_the_path(tmp_path: Path) -> None:
    machine = driven(tmp_path)
    run(machine, "%E\nN10 X[POS_LIMIT ON MAX=10 BEHAVIOUR=ERROR_LR]\nN20 G90 G01 F6000 X8\nN30 X50 Y5\nM30\n")
    machine.alarm(errors.LIMIT_REACHED)
    assert 10.0 < machine.image.target_position[0] < 30.0
    speeds = np.diff(np.array(machine.targets)[:, 0]) / machine.simulation.period
    axis = machine.machine.axes[0]
    assert np.abs(np.diff(speeds)).max() / machine.simulation.period <= axis.acceleration * 1.001, "stops under control"
