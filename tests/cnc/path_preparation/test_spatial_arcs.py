"""Arcs in space become arcs of a main plane or chords, and are driven as one block."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from runtime.cnc.blocks import Arc, Block, BlockEnd, Floats, Line, Polyline, Source, SpatialArc
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.path_preparation import SoftwareLimitError, SoftwareLimits, SpatialArcs
from runtime.cnc.path_preparation.spatial_arcs import CHORD_ERROR, in_parts
from tests.cnc.interpolator.driving import Drive, Order, check_path_laws, drive, limits

SOURCE = Source("p", 4, 40)
LIMITS = limits(400.0, 4000.0, 6e4, 5.0)


def arc_in_space(normal: Floats, radius: float, angle: float, feed: float = 6000.0, *, others: int = 0) -> SpatialArc:
    """An arc around (1, 2, 3); each other axis goes from 0 to 8."""
    least = np.eye(3)[int(np.argmin(np.abs(normal)))]
    along = np.cross(normal, least)
    along *= radius / np.linalg.norm(along)
    across = np.cross(normal, along)
    phi = math.radians(angle)
    centre = np.array([1.0, 2.0, 3.0])
    start = np.concatenate([centre + along, np.zeros(others)])
    end = np.concatenate([centre + math.cos(phi) * along + math.sin(phi) * across, np.full(others, 8.0)])
    return SpatialArc(SOURCE, start, end, feed, end - 0.5, centre, normal, angle)


def unit(*vector: float) -> Floats:
    normal: Floats = np.array(vector) / np.linalg.norm(vector)
    return normal


part = st.floats(-1.0, 1.0)


@given(part, part, part, st.floats(0.05, 2000.0), st.floats(0.1, 359.9))
def test_chords_stay_at_the_arc(x: float, y: float, z: float, radius: float, angle: float) -> None:
    assume(math.hypot(x, y, z) > 0.1)
    arc = arc_in_space(unit(x, y, z), radius, angle, others=1)
    run = in_parts(arc)
    assume(isinstance(run, Polyline))
    assert isinstance(run, Polyline)
    np.testing.assert_array_equal(run.points[0], arc.start)
    np.testing.assert_array_equal(run.points[-1], arc.end)
    middles = (run.points[1:, :3] + run.points[:-1, :3]) / 2
    for points in (run.points[:, :3], middles):
        away = points - arc.centre
        assert np.abs(away @ arc.normal).max() < 1e-6
        assert np.abs(np.linalg.norm(away, axis=1) - radius).max() < 1.01 * CHORD_ERROR
    # in the direction of the angle, in equal steps, all the way
    turns = np.cross(run.points[:-1, :3] - arc.centre, run.points[1:, :3] - arc.centre) @ arc.normal
    assert (turns > 0.0).all()
    count = len(run.feeds)
    assert np.degrees(np.arcsin(turns / radius**2)).sum() == pytest.approx(angle, abs=1e-3)
    np.testing.assert_allclose(run.points[:, 3], np.linspace(0.0, 8.0, count + 1), atol=1e-9)
    np.testing.assert_allclose(run.pcs_shift, 0.5)
    assert set(run.lines.tolist()) == {4}
    assert set(run.numbers.tolist()) == {40}
    assert set(run.feeds.tolist()) == {6000.0}
    assert run.one_block


@pytest.mark.parametrize(("axis", "plane"), [(0, (1, 2)), (1, (2, 0)), (2, (0, 1))])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_an_arc_parallel_to_a_main_plane_is_an_arc(axis: int, plane: tuple[int, int], sense: float) -> None:
    space = arc_in_space(sense * np.eye(3)[axis], 20.0, 250.0)
    block = in_parts(space)
    assert isinstance(block, Arc)
    assert (block.plane, block.angle, block.radius) == (plane, sense * 250.0, 20.0)
    np.testing.assert_array_equal(block.centre, space.centre[list(plane)])
    begin, end = (p[list(plane)] - block.centre for p in (block.start, block.end))
    phi = math.radians(block.angle)
    turned = np.array([[math.cos(phi), -math.sin(phi)], [math.sin(phi), math.cos(phi)]]) @ begin
    np.testing.assert_allclose(turned, end, atol=1e-9)


def test_other_blocks_pass_and_the_points_are_checked_against_the_software_limits() -> None:
    tilted = arc_in_space(unit(1.0, 1.0, 1.0), 20.0, 300.0)
    end = BlockEnd(SOURCE)
    out = list(SpatialArcs()([end, tilted, end]))
    assert [type(block) for block in out] == [BlockEnd, Polyline, BlockEnd]
    highest = 1.0 + 20.0 * math.sqrt(2.0 / 3.0)
    for limit, fits in ((highest + 1e-4, True), (highest - 1e-4, False)):
        stage = SoftwareLimits(("X", "Y", "Z"), (None, None, None), (limit, None, None))
        if fits:
            assert len(list(stage(out))) == 3
        else:
            with pytest.raises(SoftwareLimitError, match="p:4: 301001"):
                list(stage(out))


def driven(arc: SpatialArc, *, single_block: bool = False) -> Drive:
    """The arc and a line behind it."""
    after = arc.end + np.array([0.0, 0.0, 5.0])
    following = Line(Source("p", 5), arc.end, after, 6000.0, False, after)
    blocks: list[Block] = [*SpatialArcs()([arc]), BlockEnd(SOURCE), following, BlockEnd(following.source)]

    def order(_cycle: int, interpolator: Interpolator) -> Order:
        return Order(single_block=single_block, open_gates=interpolator.at_gate)

    run = drive(blocks, LIMITS, arc.start, order, capacity=16384)
    check_path_laws(run)
    return run


def test_chords_are_driven_as_fast_as_an_arc() -> None:
    flat, tilted = (driven(arc_in_space(unit(0.0, y, 1.0), 50.0, 180.0)) for y in (0.0, 1.0))
    assert flat.finished
    assert tilted.finished
    assert max(flat.v) == pytest.approx(100.0)
    assert max(tilted.v) == pytest.approx(100.0, rel=0.01)
    assert tilted.cycles < 1.1 * flat.cycles


def test_single_block_stops_behind_the_arc_not_within() -> None:
    arc = arc_in_space(unit(0.0, 1.0, 1.0), 5.0, 90.0)
    run = driven(arc, single_block=True)
    moving = np.array(run.v) > 0.0
    stops = np.flatnonzero(moving[:-1] & ~moving[1:]) + 1
    assert len(stops) == 2
    np.testing.assert_allclose(run.path[stops[0]], arc.end, atol=1e-9)


def test_a_rapid_arc_obeys_override_zero() -> None:
    arc = arc_in_space(unit(0.0, 0.0, 1.0), 50.0, 90.0, math.inf)
    blocks = list(SpatialArcs()([arc]))
    run = drive(blocks, LIMITS, arc.start, lambda cycle, _: Order(override=0.0 if cycle < 100 else 2.0))
    check_path_laws(run)
    assert run.finished
    assert run.v[99] == 0.0
    assert run.elements[0]["rapid"] == 1
    assert max(run.v) <= float(run.elements[0]["v_limit"])
