"""#HSC [SURFACE], the surface optimiser: programs in, smoothed paths out."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given, settings

from runtime.cnc.blocks import Arc, BlockEnd, Line, Polyline, Polynomials, TechnologyFunction
from runtime.diagnostics.catalogue import smoothing as catalogue
from tests.cnc.decoder.programs import decode
from tests.cnc.interpolator.driving import check_path_laws, drive
from tests.cnc.path_preparation.smoothed_paths import (
    Smoothed,
    corners_of,
    deviation,
    distances,
    ends_meet,
    joints,
    places,
    smoothed,
)
from tests.cnc.path_preparation.test_splines import FIVE, HARD, TRIM, met, polygons, program

SURFACE = pytest.mark.spec("isg.smooth.hsc-surface")


def wave(ways: Sequence[float]) -> str:
    """Moves over a smooth curve, with points wherever a program has them."""
    return "\n".join(f"X{x:.4f} Y{3 * math.sin(x / 4):.4f} Z{math.cos(x / 7):.4f}" for x in ways)


def curves_of(path: Smoothed) -> list[Polynomials]:
    return [block for block in path.blocks if isinstance(block, Polynomials)]


def path_of(path: Smoothed) -> np.ndarray:
    return np.vstack([places(block, 20) for block in curves_of(path)])


@SURFACE
@pytest.mark.parametrize("allowed", [0.02, 0.2])
def test_the_surface_keeps_to_the_tolerance_and_turns_smoothly(allowed: float) -> None:
    path = smoothed(program(f"#HSC ON [SURFACE PATH_DEV={allowed}]", TRIM, "#HSC OFF"))
    assert deviation(path) <= allowed + 1e-9
    assert met(path, 0.0, 0.0) < 1e-9
    assert met(path, 100.0, 37.5) < 1e-9
    assert met(path, 25.0, 25.0) > 0.2 * allowed
    assert ends_meet(path.blocks) < 1e-9
    inside = [joint for joint in joints(path.blocks) if np.abs(joint.place[:2]).max() > 0.0]
    assert max(joint.turn for joint in inside) < 1e-6
    assert max(joint.bend for joint in inside) < 1e-4
    run = drive(path.blocks, HARD, np.zeros(3))
    assert run.finished
    check_path_laws(run)


@SURFACE
@given(polygons())
@settings(max_examples=20, deadline=None)
def test_the_tolerance_holds_for_any_polygon(moves: str) -> None:
    for allowed in (0.004, 0.3):
        path = smoothed(program(f"#HSC ON [SURFACE PATH_DEV={allowed} MAX_ANGLE=180]", moves, "#HSC OFF"))
        assert deviation(path) <= allowed + 1e-9
        assert ends_meet(path.blocks) < 1e-9
        straight = smoothed(program("", moves, ""))
        assert places(path.motions[-1], 1)[-1] == pytest.approx(places(straight.motions[-1], 1)[-1], abs=1e-9)


@SURFACE
def test_the_path_hardly_depends_on_where_the_points_are() -> None:
    """Neighbouring paths with points at other places: they come closer together, and none is driven as slowly as before."""
    rng = random.Random(3)
    ways = [sorted([20.0 * rng.random() for _ in range(79)] + [20.0]) for _ in range(2)]
    before = "G01 X0 Y0 Z1 F30000"

    def chosen(method: str, points: Sequence[float]) -> Smoothed:
        return smoothed(program(f"#HSC ON [{method} PATH_DEV=0.03]", wave(points), "#HSC OFF", before))

    def time_of(path: Smoothed) -> int:
        run = drive(path.blocks, HARD, np.zeros(3), keep_records=False)
        assert run.finished
        return run.cycles

    surface, bspline = [chosen("SURFACE", w) for w in ways], [chosen("BSPLINE", w) for w in ways]
    assert all(deviation(path) <= 0.03 for path in surface)
    first, second = (max(distances(path_of(a), path_of(b))) for a, b in (surface, bspline))
    assert first < second
    assert time_of(surface[0]) < 0.6 * time_of(bspline[0])
    even = chosen("SURFACE", np.linspace(0.25, 20.0, 80).tolist())
    assert time_of(surface[0]) < 1.6 * time_of(even)


@SURFACE
def test_many_points_in_windows_stay_smooth_and_keep_their_lines() -> None:
    rng = random.Random(5)
    ways = [0.1 * k + rng.uniform(-0.04, 0.04) for k in range(1, 2600)]
    path = smoothed(program("#HSC ON [SURFACE PATH_DEV=0.01]", wave(ways), "#HSC OFF", "G01 X0 Y0 Z1 F6000"))
    runs = curves_of(path)
    lines = np.concatenate([run.lines for run in runs])
    assert (np.diff(lines) >= 0).all()
    inside = [joint for joint in joints(path.blocks) if joint.place[0] > 1e-6]
    assert max(joint.turn for joint in inside) < 1e-6
    assert ends_meet(path.blocks) < 1e-9
    ends = np.array([[x, 3 * math.sin(x / 4), math.cos(x / 7)] for x in [0.0, *ways]])
    assert max(distances(path_of(path), ends)) <= 0.01 + 1e-4  # the programmed places are rounded


@SURFACE
def test_tracking_axes_keep_to_their_tolerance() -> None:
    moves = "\n".join(f"X{k} Y{(k * 7) % 3 * 0.1:.1f} A{(k * 5) % 4 * 0.5:.1f}" for k in range(1, 60))
    path = smoothed(program("#HSC ON [SURFACE PATH_DEV=1 TRACK_DEV=0.05 MAX_ANGLE=180]", moves, "#HSC OFF"), FIVE)
    polygon = corners_of([block for block in path.programmed if isinstance(block, Line | Polyline)])
    driven = path_of(path)
    for place in driven[::7]:
        near = np.abs(np.interp(place[0], polygon[:, 0], polygon[:, 3]) - place[3])
        reach = np.linspace(place[0] - 0.2, place[0] + 0.2, 41)
        assert min(near, np.abs(np.interp(reach, polygon[:, 0], polygon[:, 3]) - place[3]).min()) <= 0.05 + 1e-9


@SURFACE
def test_rapid_corners_have_a_tolerance_of_their_own() -> None:
    moves = "G00 X10\nY10\nX20\nG01 Y20 F3000\nX30\nY30"
    path = smoothed(program("#HSC ON [SURFACE PATH_DEV=0.05 PATH_DEV_G00=0.8]", moves, "#HSC OFF"))
    assert 0.1 < met(path, 10.0, 10.0) <= 0.8
    assert met(path, 20.0, 20.0) <= 0.05
    assert met(path, 20.0, 10.0) <= 0.05
    assert met(smoothed(program("#HSC ON [SURFACE PATH_DEV=0.05]", moves, "#HSC OFF")), 10.0, 10.0) <= 0.05
    off = smoothed(program("#HSC ON [SURFACE PATH_DEV=0.05 AUTO_OFF_G00=1]", moves, "#HSC OFF"))
    assert met(off, 10.0, 10.0) < 1e-9
    assert met(off, 20.0, 20.0) > 1e-3


@SURFACE
def test_functions_and_feeds_keep_their_places() -> None:
    moves = "X5 Y1\nX10 Y0\nF2000 X15 Y1 M10\nX20 Y0"
    path = smoothed(program("#HSC ON [SURFACE PATH_DEV=0.1]", moves, "#HSC OFF"))
    at = next(i for i, block in enumerate(path.blocks) if isinstance(block, TechnologyFunction) and block.number == 10)
    before = next(block for block in reversed(path.blocks[:at]) if isinstance(block, Polynomials))
    assert float(np.linalg.norm(before.ends[-1][:2] - np.array([10.0, 0.0]))) <= 0.1
    assert before.feeds[-1] == 6000.0
    behind = next(block for block in path.blocks[at:] if isinstance(block, Polynomials))
    assert behind.feeds[0] == 2000.0
    ends = sum(int(run.block_ends.sum()) for run in curves_of(path))
    ends += sum(isinstance(block, BlockEnd) for block in path.blocks)
    assert ends >= 4


@SURFACE
def test_sharp_corners_leave_the_curve_and_settings_stay() -> None:
    moves = "X10\nX10 Y10\nX0.1 Y9.9\nX-5 Y9"
    path = smoothed(program("#HSC [SURFACE PATH_DEV=0.2 MAX_ANGLE=100 CHECK_JERK=0]\n#HSC ON", moves, "#HSC OFF"))
    assert met(path, 10.0, 0.0) > 1e-3
    assert not any(run.check_jerk for run in curves_of(path))
    sharp = smoothed(program("#HSC [SURFACE MAX_ANGLE=80]\n#HSC ON", moves, "#HSC OFF"))
    assert met(sharp, 10.0, 0.0) < 1e-9
    assert met(sharp, 10.0, 10.0) < 1e-9
    assert all(run.check_jerk for run in curves_of(sharp))


def test_large_arcs_stay_and_are_joined_smoothly() -> None:
    moves = "X10 Y0\nX20 Y1\nG02 X40 Y1 I10 J-2\nG01 X50 Y0\nX60 Y3"
    path = smoothed(program("#HSC ON [SURFACE PATH_DEV=0.1]", moves, "#HSC OFF"))
    assert [block for block in path.blocks if isinstance(block, Arc)]
    assert deviation(path) <= 0.1 + 1e-9
    assert met(path, 20.0, 1.0) > 1e-3
    assert met(path, 40.0, 1.0) > 1e-3
    assert ends_meet(path.blocks) < 1e-9
    assert max(joint.turn for joint in joints(path.blocks)) < 2e-3  # of the sampled arc
    run = drive(path.blocks, HARD, np.zeros(3))
    assert run.finished
    check_path_laws(run)
    exact = smoothed(program("#HSC ON [SURFACE PATH_DEV=0.1 CIR_MODE=0]", moves, "#HSC OFF"))
    assert met(exact, 20.0, 1.0) < 1e-9
    assert met(exact, 40.0, 1.0) < 1e-9


@pytest.mark.parametrize(
    ("option", "arcs"), [("", 0), (" CIR_MIN_ANGLE=10", 1), (" CIR_MIN_ANGLE=10 CIR_MIN_RADIUS=60", 0)]
)
def test_small_arcs_become_part_of_the_curve(option: str, arcs: int) -> None:
    """20 degrees of a radius of 50 mm."""
    end = 50.0 * math.sin(math.radians(20.0)), 50.0 * (1.0 - math.cos(math.radians(20.0)))
    moves = f"X10\nG03 X{10.0 + end[0]:.5f} Y{end[1]:.5f} R50\nG01 X40 Y8\nX50 Y8"
    path = smoothed(program(f"#HSC ON [SURFACE PATH_DEV=0.05{option}]", moves, "#HSC OFF"))
    assert sum(isinstance(block, Arc) for block in path.blocks) == arcs
    assert deviation(path) <= 0.05 + 1e-9
    assert ends_meet(path.blocks) < 1e-9


@SURFACE
@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("#HSC ON [SURFACE PATH_DEV=0]", catalogue.NOT_ABOVE),
        ("#HSC ON [SURFACE PATH_DEV=-1]", catalogue.NOT_ABOVE),
        ("#HSC ON [SURFACE TRACK_DEV=-1]", catalogue.VALUE_RANGE),
        ("#HSC ON [SURFACE CIR_MODE=3]", catalogue.VALUE_RANGE),
        ("#HSC ON [SURFACE CIR_MODE=0.5]", catalogue.VALUE_RANGE),
        ("#HSC ON [SURFACE MAX_PATH_LENGTH=1]", catalogue.OF_OTHER_METHOD),
        ("#HSC ON [BSPLINE CIR_MODE=1]", catalogue.OF_OTHER_METHOD),
        ("#HSC [CHECK_JERK=1]", catalogue.OF_OTHER_METHOD),
        ("#HSC ON [SURFACE]\n#HSC [SURFACE PATH_DEV=1]", catalogue.WHILE_ACTIVE),
    ],
)
def test_wrong_settings_are_errors(text: str, entry: object) -> None:
    run = decode(f"G01 F1000 X1\n{text}\nX2\nM30")
    assert run.problem is not None
    assert run.problem.entry is entry


@pytest.mark.spec("isg.var.g-active-flags")
def test_the_flag_tells_whether_the_optimiser_is_on() -> None:
    text = "P1=V.G.HSC_SURFACE_ACTIVE\n#HSC ON [SURFACE]\nP2=V.G.HSC_SURFACE_ACTIVE\n#HSC OFF\nP3=V.G.HSC_SURFACE_ACTIVE\nM30"
    run = decode(text)
    assert [run.parameters[k] for k in (1, 2, 3)] == [0.0, 1.0, 0.0]
