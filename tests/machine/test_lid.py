"""A milled part on the whole machine: two tools of a table, an outside contour, a recess and grooves with radius compensation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely
from shapely.geometry import LineString, Point, Polygon
from shapely.geometry.base import BaseGeometry

from runtime.cnc.blocks import Floats
from runtime.cnc.tools.table import MemoryTools
from runtime.cnc.tools.tool import Tool
from runtime.config.machine import Machine
from runtime.diagnostics.events import EventKind
from runtime.scheduler.simulation import Simulation

PROGRAM = Path(__file__).parents[1] / "programs" / "lid.nc"
MILL, SLIM = Tool(1, "mill", radius=6.0, length=40.0), Tool(2, "slim", radius=2.0, length=30.0)
NEAR = 1e-3  # mm: what the samples, 0.03 mm apart, and the judge's arcs of chords leave open


def plate() -> BaseGeometry:
    """The programmed outside: 100 x 70, the two far corners rounded by 10 mm."""
    corners = [Point(x, 60).buffer(10, quad_segs=256) for x in (10, 90)]
    return shapely.union_all([Polygon([(0, 0), (100, 0), (100, 60), (90, 70), (10, 70), (0, 60)]), *corners])


def groove(y: float) -> BaseGeometry:
    """The programmed groove: all within 3 mm of a line."""
    return LineString([(20, y + 3), (80, y + 3)]).buffer(3, quad_segs=256)


def expect_cut(path: Floats, walls: BaseGeometry, radius: float) -> None:
    """The tool comes to every place of the walls, and nowhere farther: `path` (n, 2) of its centre."""
    boundary = walls.boundary
    assert shapely.distance(boundary, shapely.points(path)).min() > radius - NEAR
    places = shapely.line_interpolate_point(boundary, np.arange(0.0, boundary.length, 0.5))
    farthest = shapely.distance(shapely.MultiPoint(path), places).max()
    assert farthest < radius + NEAR


@pytest.mark.spec("isg.trc.g40-g41-g42", "isg.trc.direct-g138", "isg.trc.indirect-g139")
def test_a_part_is_milled_as_it_is_programmed(demo: Machine) -> None:
    simulation = Simulation(demo, ideal_axes=True, samples=True, tools=MemoryTools((MILL, SLIM)))
    result = simulation.run_program(PROGRAM)
    assert result.good, result.problems
    functions = [event.number for event in result.events if event.kind is EventKind.M_OUT]
    assert functions == [20, 6, 8, 9, 6, 8, 9, 21]
    assert simulation.samples is not None
    samples = simulation.samples.arrays()
    path, z = np.column_stack([samples["X"], samples["Y"]]), samples["Z"].astype(np.float64)

    def at(tool: Tool, depth: float) -> Floats:
        return path[np.abs(z - tool.length - depth) < 1e-6]

    outside = at(MILL, -5.0)
    assert not shapely.contains(plate(), shapely.points(outside)).any()
    expect_cut(outside, plate(), MILL.radius)
    for depth in (-2.0, -4.0, -6.0):
        expect_recess(at(MILL, depth))
    slim = at(SLIM, -3.0)
    for y in (5.0, 59.0):
        there = slim[np.abs(slim[:, 1] - y - 3.0) < 5.0]
        assert shapely.contains(groove(y), shapely.points(there)).all()
        expect_cut(there, groove(y), SLIM.radius)


def expect_recess(path: Floats) -> None:
    """36 mm square about X50 Y35: the tool keeps within its walls and leaves nothing but what the corners keep of it."""
    out = np.abs(path - np.array([50.0, 35.0])).max()
    assert out == pytest.approx(18.0 - MILL.radius, abs=1e-6)
    cut = LineString(path).simplify(1e-5).buffer(MILL.radius, quad_segs=64)
    rest = shapely.box(32.0, 17.0, 68.0, 53.0).difference(cut)
    assert rest.area == pytest.approx((4.0 - np.pi) * MILL.radius**2, abs=0.05)
