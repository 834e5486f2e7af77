"""#HSC [OPMODE 2]: curves through the points, straight in prismatic parts."""

from __future__ import annotations

import math

import numpy as np
import pytest

from runtime.cnc.blocks import Line, Polynomials
from tests.cnc.interpolator.driving import check_path_laws, drive
from tests.cnc.path_preparation.smoothed_paths import Smoothed, ends_meet, joints, smoothed
from tests.cnc.path_preparation.test_splines import HARD, met, program

MODE_2 = pytest.mark.spec("isg.smooth.psc-opmode2")
THRESHOLDS = pytest.mark.spec("isg.smooth.psc-thresholds")
POINTS = [(round(0.5 * k, 4), round(math.sin(0.25 * k), 4)) for k in range(1, 25)]
WAVE = "\n".join(f"X{x} Y{y}" for x, y in POINTS)


def lines_of(path: Smoothed, longest: float = 0.01) -> list[Line]:
    return [b for b in path.blocks if isinstance(b, Line) and np.linalg.norm(b.end - b.start) > longest]


@MODE_2
def test_the_curve_goes_through_its_points_and_into_lines_tangentially() -> None:
    moves = WAVE + "\nX40 Y0\nX60 Y5\nX60 Y30"
    path = smoothed(program("#HSC ON [OPMODE 2 CONTERROR 0.05]", moves, "#HSC OFF"))
    assert all(met(path, x, y) < 1e-3 for x, y in POINTS[:-1])
    assert len(lines_of(path)) == 3  # those that are prismatic
    assert 1e-4 < met(path, 60.0, 5.0) <= 0.05  # a corner between two of them is rounded
    assert ends_meet(path.blocks) < 1e-9
    assert max(joint.turn for joint in joints(path.blocks)) < 1e-6
    run = drive(path.blocks, HARD, np.zeros(3))
    assert run.finished
    check_path_laws(run)


@MODE_2
def test_the_contour_error_can_change_while_the_curve_is_on() -> None:
    moves = "X20\nX40 Y1\nX40 Y30\n#HSC [CONTERROR 0.5]\nX70 Y32\nX70 Y60"
    path = smoothed(program("#HSC ON [OPMODE 2 CONTERROR 0.01]", moves, "#HSC OFF"))
    assert met(path, 40.0, 1.0) <= 0.01
    assert 0.02 < met(path, 70.0, 32.0) <= 0.5


@THRESHOLDS
def test_the_least_cosine_decides_which_corners_are_prismatic() -> None:
    """Corners of 30 degrees: their cosine is 0.87."""
    moves = "\n".join(f"X{5 * k} Y{(k % 2) * 5 * math.tan(math.radians(15)):.4f}" for k in range(1, 8))
    curved = smoothed(program("#HSC ON [OPMODE 2]", moves, "#HSC OFF"))
    assert not lines_of(curved)
    assert met(curved, 10.0, 0.0) < 1e-9
    straight = smoothed(program("#HSC ON [OPMODE 2 COS_PHI_MIN 0.9]", moves, "#HSC OFF"))
    assert len(lines_of(straight)) == 7
    assert met(straight, 10.0, 0.0) > 1e-3


@THRESHOLDS
def test_a_block_much_longer_than_the_median_of_five_is_prismatic() -> None:
    moves = WAVE + f"\nX14 Y{POINTS[-1][1]}\nX14.5 Y0.2\nX15 Y0.8"
    short = smoothed(program("#HSC ON [OPMODE 2 FACT_BLOCK_LEN 3]", moves, "#HSC OFF"))
    assert [line.end[0] for line in lines_of(short)] == [14.0]
    assert not lines_of(smoothed(program("#HSC ON [OPMODE 2 FACT_BLOCK_LEN 10]", moves, "#HSC OFF")))


@MODE_2
def test_a_long_curve_does_not_show_its_windows() -> None:
    moves = "\n".join(f"X{0.5 * k:.4f} Y{5 * math.sin(0.05 * k):.4f}" for k in range(1, 2400))
    path = smoothed(program("#HSC ON [OPMODE 2]", moves, "#HSC OFF"))
    runs = [block for block in path.blocks if isinstance(block, Polynomials)]
    assert sum(len(run.feeds) for run in runs) == 2399
    assert max(len(run.feeds) for run in runs) < 1100
    assert sum(int(run.block_ends.sum()) for run in runs) == 2399
    assert max(joint.turn for joint in joints(path.blocks)) < 1e-6
    assert ends_meet(path.blocks) < 1e-9
