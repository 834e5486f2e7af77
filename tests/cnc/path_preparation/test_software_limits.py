"""Nothing beyond a software limit is handed on."""

from __future__ import annotations

import math

import numpy as np
import pytest

from runtime.cnc.blocks import Arc, Block, Line, Polyline, SoftwareLimitChange, Source
from runtime.cnc.path_preparation import SoftwareLimitError, SoftwareLimits

STAGE = SoftwareLimits(("X", "Y", "Z"), (-50.0, -50.0, None), (100.0, 100.0, 80.0))


def line(x: float, y: float, z: float, number: int = 1) -> Line:
    end = np.array([x, y, z])
    return Line(Source("part.nc", number), np.zeros(3), end, 1000.0, False, end)


def test_blocks_before_the_error_are_handed_on_and_the_error_says_all() -> None:
    blocks: list[Block] = [line(10, 10, 10), line(100, -50, 80, 2), line(10, -50.5, 10, 3), line(0, 0, 0, 4)]
    passed: list[Block] = []
    with pytest.raises(SoftwareLimitError) as caught:
        passed.extend(STAGE(blocks))
    problem = caught.value.problem
    assert str(problem) == (
        "part.nc:3: 301001: the target of axis Y, -50.5000, lies beyond its software limit position_min = -50.0000"
    )
    assert problem.entry.remedy


@pytest.mark.spec("isg.g.soft-limits-g98-g99", "isg.g.soft-limits-extension")
def test_a_program_changes_the_limits_from_its_block_on() -> None:
    stage = SoftwareLimits(("X", "Y", "Z"), (-50.0, -50.0, None), (100.0, 100.0, 80.0))
    wider = SoftwareLimitChange(Source("part.nc", 2), ((-50.0, 450.0), (-50.0, 100.0), (0.0, 80.0)))
    assert len(list(stage([line(100, 0, -1), wider, line(450, 0, 0), line(100, 0, 80)]))) == 3
    with pytest.raises(SoftwareLimitError):
        list(stage([wider, line(100, 0, -1)]))
    with pytest.raises(SoftwareLimitError):  # the next program begins with the configured ones
        list(stage([line(101, 0, 0)]))


def test_an_axis_without_limit_is_free() -> None:
    STAGE.check(line(0, 0, -1e6))


@pytest.mark.parametrize(("angle", "beyond"), [(80.0, False), (100.0, True), (-280.0, True), (-260.0, False)])
def test_the_extremes_of_an_arc_count(angle: float, beyond: bool) -> None:
    centre = np.array([60.0, 70.0])  # radius 40: reaches Y 110 at 90 degrees, from 0 degrees (X 100)
    start = np.array([100.0, 70.0, 0.0])
    phi = math.radians(angle)
    end = np.array([60.0 + 40.0 * math.cos(phi), 70.0 + 40.0 * math.sin(phi), 0.0])
    free_y = SoftwareLimits(("X", "Y", "Z"), (None, None, None), (None, 109.999, None))
    arc = Arc(Source("p", 9), start, end, 1000.0, end, (0, 1), centre, 40.0, angle)
    if beyond:
        with pytest.raises(SoftwareLimitError, match="turning point of the arc of axis Y"):
            free_y.check(arc)
    else:
        free_y.check(arc)


def test_polylines_name_the_line_of_the_first_point_beyond() -> None:
    points = np.zeros((6, 3))
    points[4, 2] = 80.01
    block = Polyline("cam.nc", points, np.full(5, 100.0), np.arange(11, 16), np.full(5, -1), np.zeros(3))
    with pytest.raises(SoftwareLimitError) as caught:
        STAGE.check(block)
    assert caught.value.problem.place.line == 14
    assert caught.value.problem.values["axis"] == "Z"
