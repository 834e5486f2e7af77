"""Nothing beyond a software limit is handed on."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from runtime.cnc.blocks import ActualLimit, Arc, Block, Line, Polyline, Polynomials, SoftwareLimitChange, Source
from runtime.cnc.path_preparation import SoftwareLimitError, SoftwareLimits
from runtime.cnc.path_preparation.software_limits import axes_of
from runtime.config.loader import load_machine
from runtime.diagnostics.catalogue.axes import LIMIT_WARNING
from runtime.diagnostics.errors import Problem

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


# -- what the channel says of the monitoring


def poly(*points: tuple[float, float, float]) -> Polyline:
    count = len(points) - 1
    numbers = np.arange(1, count + 1)
    return Polyline("part.nc", np.array(points, dtype=float), np.full(count, 1000.0), numbers, numbers, np.zeros(3))


def stage(**options: object) -> SoftwareLimits:
    return SoftwareLimits(("X", "Y", "Z"), (-50.0, -50.0, None), (100.0, 100.0, 80.0), **options)  # type: ignore[arg-type]


def refused(limits: SoftwareLimits, *blocks: Block) -> str:
    with pytest.raises(SoftwareLimitError) as caught:
        list(limits(blocks))
    return str(caught.value.problem)


@pytest.mark.spec("chan.sls.command-side")
def test_an_axis_that_only_warns_goes_on_and_the_cycle_watches_it() -> None:
    limits, warnings = stage(warning={0}), list[Problem]()
    beyond = line(150, 0, 0, 7)
    blocks = list(limits([line(10, 0, 0), beyond, line(-60, 0, 0, 8)], warnings))
    assert blocks[0] == ActualLimit(Source("", 0), 0, -50.0, 100.0)
    assert blocks[2] is beyond
    assert [(w.entry, w.place.line, w.values["axis"]) for w in warnings] == [
        (LIMIT_WARNING, 7, "X"),
        (LIMIT_WARNING, 8, "X"),
    ]
    assert "axis Y" in refused(limits, line(0, 150, 0))
    tighter = SoftwareLimitChange(Source("part.nc", 2), ((-5.0, 5.0), (-50.0, 100.0), (-np.inf, 80.0)))
    blocks = list(limits([line(1, 1, 1), tighter, line(7, 0, 0)]))
    assert blocks[2] == ActualLimit(Source("part.nc", 2), 0, -5.0, 5.0)


@pytest.mark.spec("chan.sls.command-side")
def test_an_axis_whose_monitoring_is_suppressed_has_no_limits_on_the_path() -> None:
    limits = stage(free={1}, warning={1})
    change = SoftwareLimitChange(Source("part.nc", 2), ((-5.0, 5.0), (-1.0, 1.0), (-np.inf, 80.0)))
    blocks: list[Block] = [line(10, 5000, 0), poly((10, 5000, 0), (10, -5000, 0)), change, line(0, 5000, 0)]
    assert len(list(limits(blocks))) == 3
    assert limits.configured[1] == (-math.inf, math.inf)
    assert "axis X" in refused(limits, line(150, 5000, 0))


@pytest.mark.spec("chan.sls.command-side")
def test_an_axis_at_rest_may_lie_beyond_its_limit_by_its_tolerance() -> None:
    limits = stage(tolerance=(0.5, 0.5, 0.5))

    def beside(y: float, to: float, x: float = 10.0) -> Line:
        start, end = np.array([0.0, y, 0.0]), np.array([x, to, 0.0])
        return Line(Source("part.nc", 1), start, end, 1000.0, False, end)

    assert len(list(limits([beside(100.4, 100.4)]))) == 1
    assert "axis Y, 100.6000" in refused(limits, beside(100.6, 100.6))
    assert "axis Y, 100.3000" in refused(limits, beside(100.4, 100.3))  # it moves
    assert len(list(limits([beside(100.4, 99.0)]))) == 1
    assert "axis Y" in refused(stage(), beside(100.4, 100.4))


@pytest.mark.spec("chan.sls.command-side")
def test_the_tolerance_counts_on_every_kind_of_motion() -> None:
    limits = stage(tolerance=(0.5, 0.5, 0.5))
    run = poly((0, 100.4, 0), (5, 100.4, 0), (9, 100.4, 0), (9, 90, 0), (20, 100, 0))
    (made,) = limits([run])
    assert made is run
    moves = poly((0, 100.4, 0), (5, 100.4, 0), (9, 100.2, 0), (9, 90, 0))
    passed: list[Block] = []
    with pytest.raises(SoftwareLimitError, match=r"part.nc:2: .*axis Y, 100.2000"):
        passed.extend(limits([moves]))
    (first,) = passed
    assert isinstance(first, Polyline)
    assert len(first.feeds) == 1
    start = np.array([10.0, 0.0, 80.3])
    around = Arc(Source("p", 9), start, start, 1000.0, start, (0, 1), np.array([0.0, 0.0]), 10.0, 360.0)
    assert len(list(limits([around]))) == 1
    edge = np.array([100.3, 0.0, 0.0])
    wide = Arc(Source("p", 9), edge, edge, 1000.0, edge, (0, 1), np.array([90.3, 0.0]), 10.0, 360.0)
    assert "axis X" in refused(limits, wide)  # it comes back, but does not rest
    curve = np.zeros((1, 6, 3))
    curve[0, 0], curve[0, 1] = (0.0, 100.4, 0.0), (5.0, 0.0, 0.0)
    ends = np.array([True])
    numbers = np.array([3])
    smooth = Polynomials("part.nc", curve, np.array([1000.0]), numbers, numbers, ends, np.zeros(3))
    assert len(list(limits([smooth]))) == 1
    moving = curve.copy()
    moving[0, 1, 1], moving[0, 2, 1] = 0.05, -0.05  # out and back: it ends where it began
    assert "axis Y" in refused(limits, replace(smooth, coefficients=moving))


@pytest.mark.spec("chan.sls.command-side")
def test_the_channel_chooses_the_axes_by_their_bits() -> None:
    assert axes_of(0x5, 3) == {0, 2}
    machine = load_machine(None)
    axes = [axis.model_copy(update={"limit_tolerance": 0.25}) for axis in machine.axes]
    parameters = machine.channels[0].parameters.model_copy(
        update={
            "soft_limit_warning_axes": 0x1,
            "suppress_soft_limit_monitoring_axes": 0x4,
            "soft_limit_tolerance": True,
        }
    )
    channel = machine.channels[0].model_copy(update={"parameters": parameters})
    limits = SoftwareLimits.of(machine.model_copy(update={"axes": tuple(axes), "channels": (channel,)}))
    upper = axes[1].position_max
    assert upper is not None
    start = np.array([0.0, upper + 0.2, 0.0])
    end = start + np.array([9e3, 0.0, 9e3])
    assert len(list(limits([Line(Source("p", 1), start, end, 1.0, False, end)]))) == 2
