"""What a program may ask of smoothing by mistake: no tolerance, one point, no length, the way back, compensation in between."""

from __future__ import annotations

import numpy as np
import pytest

from runtime.cnc.blocks import Line, Polyline, Polynomials
from runtime.cnc.path_preparation import PathError, smooth
from runtime.cnc.tool_radius_comp import ToolRadiusCompensation
from runtime.diagnostics.catalogue import smoothing as catalogue
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.programs import decode
from tests.cnc.interpolator.driving import check_path_laws, drive
from tests.cnc.path_preparation.smoothed_paths import Smoothed, deviation, ends_meet, smoothed
from tests.cnc.path_preparation.test_splines import HARD, met

METHODS = {
    "DEV": ("#CONTOUR MODE [DEV PATH_DEV=0.5]\nG261", "G260"),
    "DIST": ("#CONTOUR MODE [DIST PRE_DIST=2 POST_DIST=3]\nG261", "G260"),
    "DIST_SOFT": ("#CONTOUR MODE [DIST_SOFT PATH_DIST=2]\nG261", "G260"),
    "PTP": ("#CONTOUR MODE [PTP PATH_DEV=0.5]\nG261", "G260"),
    "BSPLINE": ("#HSC ON [BSPLINE PATH_DEV=0.5 MAX_ANGLE=180]", "#HSC OFF"),
    "SURFACE": ("#HSC ON [SURFACE PATH_DEV=0.5 MAX_ANGLE=180]", "#HSC OFF"),
    "OPMODE 1": ("#HSC ON [OPMODE 1 CONTERROR 0.5]", "#HSC OFF"),
    "OPMODE 2": ("#HSC ON [OPMODE 2 CONTERROR 0.5]", "#HSC OFF"),
    "AKIMA": ("G151", "G150"),
}
every_method = pytest.mark.parametrize("method", METHODS)


def chosen(method: str, moves: str) -> Smoothed:
    on, off = METHODS[method]
    return smoothed(f"G01 X0 Y0 F6000\n{on}\n{moves}\n{off}\nM30")


def check_driven(path: Smoothed) -> None:
    assert ends_meet(path.blocks) < 1e-9
    run = drive(path.blocks, HARD, np.zeros(3))
    assert run.finished
    check_path_laws(run)


@every_method
def test_the_way_back_is_a_corner_that_is_met_exactly(method: str) -> None:
    path = chosen(method, "X20 Y5\nX40\nX20\nX30 Y20")
    assert met(path, 40.0, 5.0) < 1e-9
    assert met(path, 30.0, 20.0) < 1e-9
    check_driven(path)


@every_method
def test_blocks_without_length_change_nothing(method: str) -> None:
    moves = ["X10 Y3", "X20 Y0", "X30 Y8", "X40 Y9", "X55 Y9"]
    path, with_empty = (
        chosen(method, "\n".join(moves)),
        chosen(method, "\n".join(f"{m}\n{m}\nG91 X0\nG90" for m in moves)),
    )

    if method != "SURFACE":  # it has a point of its own where a block ends for itself
        assert len(path.curves) == len(with_empty.curves)
        assert all(np.abs(one - other).max() < 1e-9 for one, other in zip(path.curves, with_empty.curves, strict=True))
    else:
        assert deviation(with_empty) <= 0.5
    check_driven(with_empty)


@every_method
def test_a_single_block_is_driven_as_it_is(method: str) -> None:
    if method == "AKIMA":
        with pytest.raises(PathError) as error:
            chosen(method, "X20 Y5")
        assert error.value.problem.entry is catalogue.SPLINE_POINTS
        assert error.value.problem.place.line == 4  # where it is deselected
        assert "2 points" in str(error.value)
        return
    path = chosen(method, "X20 Y5")
    assert met(path, 10.0, 2.5) < 1e-9
    check_driven(path)


@pytest.mark.parametrize(
    ("settings", "entry"),
    [
        ("#CONTOUR MODE [DEV PATH_DEV=-0.1]", catalogue.VALUE_RANGE),
        ("#CONTOUR MODE [DIST PRE_DIST=-1]", catalogue.VALUE_RANGE),
        ("#CONTOUR MODE [PTP PATH_DEV=-1]", catalogue.VALUE_RANGE),
        ("#CONTOUR MODE [PTP PATH_DIST=-1]", catalogue.VALUE_RANGE),
        ("#HSC ON [BSPLINE PATH_DEV=-1]", catalogue.VALUE_RANGE),
        ("#HSC ON [SURFACE PATH_DEV=-1]", catalogue.NOT_ABOVE),
        ("#HSC ON [SURFACE PATH_DEV=0]", catalogue.NOT_ABOVE),
        ("#HSC ON [OPMODE 1 CONTERROR=-1]", catalogue.VALUE_RANGE),
    ],
)
def test_a_negative_tolerance_is_an_error_at_its_place(settings: str, entry: ErrorEntry) -> None:
    run = decode(f"G01 F1000 X1\n{settings}\nX2\nM30")
    assert run.problem is not None
    assert run.problem.entry is entry
    assert run.problem.place.line == 2
    assert run.problem.place.column


@pytest.mark.parametrize(
    "selection",
    ["#CONTOUR MODE [DEV PATH_DEV=0]\nG261", "#CONTOUR MODE [DIST PRE_DIST=0 POST_DIST=0]\nG261",
     "#CONTOUR MODE [PTP PATH_DEV=0]\nG261", "#CONTOUR MODE [PTP PATH_DIST=0]\nG261", "#HSC ON [OPMODE 1 CONTERROR=0]"],
)  # fmt: skip
def test_no_tolerance_is_the_programmed_path(selection: str) -> None:
    path = smoothed(f"G01 X0 Y0 F6000\n{selection}\nX20\nY20\nX0\nM30")
    assert not path.curves
    assert deviation(path) < 1e-9
    check_driven(path)


@pytest.mark.parametrize("method", ["DEV", "DIST", "DIST_SOFT", "PTP", "SURFACE", "BSPLINE"])
def test_compensation_is_switched_in_between(method: str) -> None:
    """Contouring works on the compensated path, also over its approach, its exit and the corners that it inserts."""
    on, off = METHODS[method]
    text = f"V.G.WZ_AKT.R = 3\nG01 X0 Y0 F6000\n{on}\nX10\nG41 X20 Y5\nX60\nY40\nX20\nG42 Y80\nX60\nG40 X80 Y90\nX90\n{off}\nM30"
    run = decode(text)
    assert run.problem is None
    compensated = list(ToolRadiusCompensation()(iter(run.blocks)))
    path = Smoothed(compensated, list(smooth(iter(compensated), HARD)), [])
    assert any(isinstance(block, Polynomials) for block in path.blocks)
    assert any(isinstance(block, Line | Polyline) for block in compensated)
    if method not in ("DIST", "DIST_SOFT"):
        assert deviation(path) <= 0.5 + 1e-9
    check_driven(path)
