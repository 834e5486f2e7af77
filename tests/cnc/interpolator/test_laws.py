"""Laws for random paths, limits and operators: limits are kept, the path is never left, the end is always met."""

from __future__ import annotations

import math
import os
import random

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.blocks import (
    Arc,
    Block,
    BlockEnd,
    Dwell,
    Line,
    Polyline,
    Source,
    Synch,
    Technology,
    TechnologyFunction,
    Wait,
)
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.motion_queue import RecordKind
from tests.cnc.interpolator.driving import Drive, Order, Schedule, check_path_laws, drive

Floats = npt.NDArray[np.float64]

pytestmark = pytest.mark.uncompiled
COMPILED = os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")  # plain Python is some hundred times slower


def random_direction(rng: random.Random) -> Floats:
    return np.array([rng.uniform(-1, 1) for _ in range(3)])


def random_blocks(rng: random.Random, count: int, start: Floats) -> tuple[list[Block], Floats]:
    """Lines from 3 µm to 10 mm, arcs from 0.1 to 30 mm radius, bent polylines, functions and gates."""
    blocks: list[Block] = []
    place = start
    for number in range(1, count + 1):
        source = Source("p", number, number)
        feed = rng.choice([300.0, 1500.0, 6000.0, 20_000.0])
        kind = rng.random()
        if kind < 0.5:
            end = place + random_direction(rng) * 10 ** rng.uniform(-2.5, 1)
            rapid = rng.random() < 0.3
            blocks += [Line(source, place, end, math.inf if rapid else feed, rapid, end), BlockEnd(source)]
            place = end
        elif kind < 0.75:
            plane = rng.choice([(0, 1), (1, 2), (2, 0)])
            radius, angle, phi = 10 ** rng.uniform(-1, 1.5), rng.uniform(-400, 400), rng.uniform(0, 6.3)
            centre = np.array([place[plane[0]] - radius * math.cos(phi), place[plane[1]] - radius * math.sin(phi)])
            end = place.copy()
            end[plane[0]] = centre[0] + radius * math.cos(phi + math.radians(angle))
            end[plane[1]] = centre[1] + radius * math.sin(phi + math.radians(angle))
            end[3 - sum(plane)] += rng.choice([0.0, rng.uniform(-2, 2)])
            blocks += [Arc(source, place, end, feed, end, plane, centre, radius, angle), BlockEnd(source)]
            place = end
        elif kind < 0.9:
            k, step, direction = rng.randint(1, 60), 10 ** rng.uniform(-2.5, 0), random_direction(rng)
            points = [place]
            for _ in range(k):
                direction = direction + random_direction(rng) * rng.choice([0.01, 0.1, 0.1])
                direction = direction / np.linalg.norm(direction)
                points.append(points[-1] + direction * step * rng.choice([1.0, 1.0, 1.0, 0.0, 0.1]))
            blocks.append(
                Polyline("p", np.array(points), np.full(k, feed), np.full(k, number), np.full(k, -1), np.zeros(3))
            )
            place = points[-1]
        else:
            if rng.random() < 0.4:
                blocks.append(TechnologyFunction(source, Technology.M, 8, 0.0, Synch.MVS_SNS))
            blocks.append(Wait(source) if rng.random() < 0.5 else Dwell(source, 0.1))
    return blocks, place


def random_limits(rng: random.Random) -> AxisLimits:
    return AxisLimits(
        np.array([rng.uniform(50, 500) for _ in range(3)]),
        np.array([rng.uniform(500, 6000) for _ in range(3)]),
        np.array([10 ** rng.uniform(4, 5.3) for _ in range(3)]),
        np.array([rng.choice([0.0, 1.0, 5.0, 20.0]) for _ in range(3)]),
    )


def restless(rng: random.Random, level: int) -> Schedule:
    """An operator, a channel and a preparation that change their minds; everything is let go after 6000 cycles."""
    order = Order()

    def schedule(cycle: int, _interpolator: Interpolator) -> Order:
        if level >= 1 and rng.random() < 0.01:
            order.override = rng.choice([0.0, 0.1, 0.5, 1.0, 1.3, 2.0])
        if level >= 1 and rng.random() < 0.01:
            order.hold = rng.random() < 0.4
        if level >= 2 and rng.random() < 0.01:
            order.single_block = rng.random() < 0.4
        if rng.random() < 0.02:
            order.open_gates = rng.random() < 0.6
        if level >= 3:
            order.feed_queue = rng.random() < 0.05
        return Order() if cycle > 6000 else order

    return schedule


def distance_to_path(run: Drive) -> float:
    """Greatest distance of a commanded position from the element it was commanded on."""
    worst = 0.0
    for cycle, q in enumerate(run.path):
        record = run.elements.get(run.record[cycle])
        if record is None or record["kind"] > RecordKind.POLYNOMIAL:
            continue
        start, end = record["start"][:3], record["end"][:3]
        if record["kind"] == RecordKind.LINE:
            way = end - start
            share = np.clip(np.dot(q - start, way) / np.dot(way, way), 0.0, 1.0)
            off = float(np.linalg.norm(q - start - share * way))
        else:
            i, j = int(record["axis0"]), int(record["axis1"])
            radius = math.hypot(start[i] - record["centre0"], start[j] - record["centre1"])
            off = abs(math.hypot(q[i] - record["centre0"], q[j] - record["centre1"]) - radius)
        worst = max(worst, off)
    return worst


@settings(max_examples=40 if COMPILED else 4, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**9), level=st.integers(0, 3), count=st.integers(1, 8))
def test_limits_are_kept_the_path_is_not_left_and_the_end_is_met(seed: int, level: int, count: int) -> None:
    rng = random.Random(seed)
    start = random_direction(rng) * 5.0
    blocks, end = random_blocks(rng, count, start)
    run = drive(blocks, random_limits(rng), start, restless(rng, level), budget=rng.choice([1, 3, 4000]), most=60_000)
    assert run.finished
    check_path_laws(run)
    assert distance_to_path(run) < 1e-6
    assert np.abs(run.path[-1] - end).max() < 2e-9
    told = [index for _, index in run.passed]
    assert told == sorted(set(told))


@settings(max_examples=15 if COMPILED else 2, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**9), level=st.integers(1, 3))
def test_any_operator_gives_the_same_end_and_the_same_order_of_functions(seed: int, level: int) -> None:
    rng = random.Random(seed)
    blocks, _ = random_blocks(rng, 6, np.zeros(3))
    limited = random_limits(rng)
    calm = drive(blocks, limited, np.zeros(3))
    wild = drive(blocks, limited, np.zeros(3), restless(rng, level), most=60_000)
    assert calm.finished
    assert wild.finished
    if len(calm.path):
        assert calm.path[-1].tolist() == wild.path[-1].tolist()
    assert [i for _, i in calm.passed] == [i for _, i in wild.passed]


def uneven_blocks(rng: random.Random, count: int) -> list[Block]:
    """Neighbours with very different limits: lines along fast and slow axes, tiny and large tangential arcs, gates."""
    blocks: list[Block] = []
    place = np.zeros(3)
    for number in range(1, count + 1):
        source = Source("p", number, number)
        feed = rng.choice([1500.0, 6000.0, 20_000.0])
        way = np.zeros(3)
        if rng.random() < 0.6:
            axis = rng.randrange(3)
            way[axis] = rng.choice([-1.0, 1.0]) * 10 ** rng.uniform(-1.5, 1.3)
            if rng.random() < 0.5:
                way[(axis + 1) % 3] = way[axis] * rng.choice([0.02, 0.3])
            blocks += [Line(source, place, place + way, feed, False, place), BlockEnd(source)]
        else:
            radius, angle = rng.choice([0.2, 0.5, 2.0, 20.0]), rng.choice([-180.0, -90.0, 90.0, 180.0])
            centre = np.array([place[0], place[1] + math.copysign(radius, angle)])
            turned = math.radians(angle) - math.copysign(math.pi / 2, angle)
            way[0] = radius * math.cos(turned)
            way[1] = math.copysign(radius, angle) + radius * math.sin(turned)
            end = place + way
            blocks += [Arc(source, place, end, feed, end, (0, 1), centre, radius, angle), BlockEnd(source)]
        place = place + way
        if rng.random() < 0.15:
            blocks.append(Wait(source))
    return blocks


def fickle(rng: random.Random) -> Schedule:
    """Holds, overrides, gates and single block that change every few cycles; calm after 2500 cycles."""
    order = Order()

    def schedule(cycle: int, _interpolator: Interpolator) -> Order:
        if rng.random() < 0.04:
            order.hold = not order.hold
        if rng.random() < 0.03:
            order.override = rng.choice([0.0, 0.2, 1.0, 1.0, 2.0])
        if rng.random() < 0.02:
            order.open_gates = not order.open_gates
        if rng.random() < 0.01:
            order.single_block = not order.single_block
        order.feed_queue = rng.random() < 0.2
        return Order() if cycle > 2500 else order

    return schedule


def test_brakings_taken_back_before_a_border_keep_the_limits_behind_it() -> None:
    refused = 0
    for seed in range(100, 150 if COMPILED else 103):
        rng = random.Random(seed)
        blocks = uneven_blocks(rng, 12)
        uneven = AxisLimits(
            np.array([rng.choice([60.0, 200.0, 500.0]) for _ in range(3)]),
            np.array([rng.choice([300.0, 2000.0, 8000.0]) for _ in range(3)]),
            np.array([rng.choice([1e4, 5e4, 3e5]) for _ in range(3)]),
            np.array([rng.choice([1.0, 5.0, 20.0]) for _ in range(3)]),
        )
        run = drive(blocks, uneven, np.zeros(3), fickle(rng), budget=rng.choice([1, 4000]), most=60_000)
        assert run.finished, seed
        check_path_laws(run)
        refused += run.refused
    assert refused > 0 or not COMPILED  # otherwise nothing of this kind happened
