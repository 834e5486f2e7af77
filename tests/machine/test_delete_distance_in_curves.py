"""Delete distance to go where the path is not what the program says: curves, radius compensation, functions ahead."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from runtime.config.machine import Machine
from runtime.diagnostics.events import EventKind
from tests.machine.driven import Driven
from tests.machine.scripted_plc import ScriptedPlc
from tests.machine.test_ahead import machine_with
from tests.machine.test_control_units import delete_distance

DELETE = pytest.mark.spec("hli.ch.cu.delete-distance-to-go")
CURVES = {
    "corner": "#CONTOUR MODE [DEV PATH_DEV=2]\nG261",
    "soft corner": "#CONTOUR MODE [DIST_SOFT PATH_DIST=8]\nG261",
    "B-spline": "#HSC ON [BSPLINE PATH_DEV=3]",
    "surface": "#HSC ON [SURFACE PATH_DEV=3]",
    "Akima": "G151",
}
PATH = "G90 G162 G01 F6000 X0 Y0\n{}\nN10 X60\nN20 Y50\nN30 X100 Y80\nN40 X140 Y60\nG260 G150\n#HSC OFF\nN90 M30\n"


def ideal(machine: Machine, folder: Path, **options: object) -> Driven:
    return Driven(machine, folder, ideal_axes=True, **options)


def check_motion(driven: Driven) -> None:
    """No axis faster or accelerated more than it may be, in any cycle, but for its jump at corners."""
    places = np.array(driven.targets)
    for k, axis in enumerate(driven.machine.axes[:3]):
        v = np.diff(places[:, k]) / driven.simulation.period
        a = np.diff(v) / driven.simulation.period
        assert np.abs(v).max() <= axis.velocity * 1.001
        jump = axis.velocity_step / driven.simulation.period
        assert np.abs(a).max() <= axis.acceleration * 1.01 + jump


@DELETE
@pytest.mark.parametrize("curve", CURVES)
@pytest.mark.parametrize("x", [20.0, 58.5])
def test_the_rest_of_a_curve_is_dropped_and_the_next_targets_are_reached(
    demo: Machine, tmp_path: Path, curve: str, x: float
) -> None:
    driven = ideal(demo, tmp_path, partner=lambda memory: ScriptedPlc(memory, {}))
    driven.start("%D\n" + PATH.format(CURVES[curve]))
    driven.until_x(x)
    delete_distance(driven)
    driven.until(lambda: driven.channel.interpolator.standstill, 2.0)
    stood = driven.channel.interpolator.position[:2].copy()
    assert x <= stood[0] < 63.0  # an Akima curve swings out
    driven.until_done()
    assert driven.errors == []
    check_motion(driven)
    assert driven.channel.interpolator.position[:2] == pytest.approx([140.0, 60.0], abs=1e-6)


@DELETE
def test_the_compensated_contour_goes_on_with_the_next_block(demo: Machine, tmp_path: Path) -> None:
    driven = ideal(demo, tmp_path, partner=lambda memory: ScriptedPlc(memory, {}))
    text = "V.G.WZ_AKT.R = 4\nG90 G162 G01 F6000 X0 Y0\nN5 G42 X10 Y10\nN10 X60\nN20 Y50\nN30 X10\nN40 G40 X0 Y60\nN90 M30\n"
    driven.start("%D\n" + text)
    driven.until(lambda: float(driven.image.target_position[0]) > 30.0)
    delete_distance(driven)
    driven.until(lambda: driven.channel.interpolator.standstill, 2.0)
    stood = driven.channel.interpolator.position[:2].copy()
    assert stood[1] == pytest.approx(6.0, abs=1e-6)
    assert stood[0] < 40.0
    driven.until(lambda: float(driven.image.target_position[1]) > 50.0)
    driven.until_done()
    assert driven.errors == []
    check_motion(driven)
    places = np.array(driven.targets)[:, :2]
    assert np.linalg.norm(places - np.array([64.0, 54.0]), axis=1).min() < 0.1  # the compensated target of N20
    assert driven.channel.interpolator.position[:2] == pytest.approx([0.0, 60.0], abs=1e-6)


@DELETE
@pytest.mark.parametrize("x", [20.0, 55.0])
def test_functions_ahead_of_a_place_that_is_dropped_are_put_out_once(demo: Machine, tmp_path: Path, x: float) -> None:
    """M50 goes out 10 mm ahead of the end of its block: the path is before that, or behind it."""
    machine = machine_with(demo, {50: ("MEP_SVS", 100_000)})
    driven = ideal(machine, tmp_path, partner=lambda memory: ScriptedPlc(memory, {}))
    driven.start("%D\nG90 G162 G01 F6000 X0 Y0\nN10 X60 M50\nN20 Y50\nN90 M30\n")
    driven.until_x(x)
    delete_distance(driven)
    driven.until_done()
    assert driven.errors == []
    out = [e for e in driven.simulation.log if e.kind is EventKind.M_OUT and e.number == 50]
    assert len(out) == 1
    check_motion(driven)
    assert driven.channel.interpolator.position[:2] == pytest.approx([60.0, 50.0], abs=1e-6)
