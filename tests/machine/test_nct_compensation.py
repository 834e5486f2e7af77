"""Cutter compensation of the NCT dialect on the machine: path, feed hold, single block, reset, search, backward motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from runtime.cnc.search_target import SearchKind
from runtime.config.machine import Machine
from runtime.hli.layout import StopCondition
from tests.machine.driven import Driven, Floats
from tests.machine.test_backward_motion import at_begin, backward
from tests.machine.test_block_search import place, search

R = 5.0
PART = """%O0001(POCKET)
G90 G17 G0 X-20 Y0 Z0
G10 R5 L12 P1
G41 G1 X0 D1 F6000
N40 X40
N50 Y40
N60 G2 X60 Y60 I20
N70 G1 X0
N80 Y80
G40 X-20
M30
"""
CORNERS = [(0, R), (40 - R, R)]


def driven_by(machine: Machine, folder: Path, storage: int = 0) -> Driven:
    channel = machine.channels[0].model_copy(update={"zero_offsets": {}, "backward_storage": storage})
    machine = machine.model_copy(update={"channels": (channel,)})
    return Driven(machine, folder, ideal_axes=True, dialect="nct", plc=False)


def path_of(driven: Driven) -> Floats:
    seen = []

    def over() -> bool:
        seen.append(place(driven)[:2])
        return not driven.channel.active

    driven.until(over, 60.0)
    assert driven.alarms == []
    return np.array(seen)


def nearest(path: Floats, point: tuple[float, float]) -> float:
    return float(np.linalg.norm(path - point, axis=1).min())


def test_the_path_of_the_machine(demo: Machine, tmp_path: Path) -> None:
    driven = driven_by(demo, tmp_path)
    driven.start(PART)
    path = path_of(driven)
    for corner in CORNERS:
        assert nearest(path, corner) < 0.06
    inner = path[(path[:, 0] > 1) & (path[:, 0] < 39) & (path[:, 1] < 30)]
    assert inner[:, 1].min() >= R - 1e-3  # never nearer to the contour than the tool is wide
    assert place(driven)[:2] == [-20, 80]
    driven.assert_no_jump()


@pytest.mark.parametrize("line", [4, 5, 7])
def test_a_feed_hold_leaves_the_path_as_it_is(demo: Machine, tmp_path: Path, line: int) -> None:
    (tmp_path / "whole").mkdir()
    whole = driven_by(demo, tmp_path / "whole")
    whole.start(PART)
    reference = path_of(whole)
    held = driven_by(demo, tmp_path)
    held.start(PART)
    held.until(lambda: held.channel.interpolator.line == line)
    held.operator.feedhold_w = True
    held.watch(500)
    assert held.channel.held
    held.operator.feedhold_w = False
    for point in path_of(held)[::20]:
        assert nearest(reference, (point[0], point[1])) < 0.06
    assert place(held)[:2] == [-20, 80]
    held.assert_no_jump()


def test_single_block_stops_behind_the_corners(demo: Machine, tmp_path: Path) -> None:
    driven = driven_by(demo, tmp_path)
    driven.operator.single_block_w = True
    driven.start(PART)
    places = []
    for _ in range(20_000):
        driven.watch(1)
        if not driven.channel.active:
            break
        if driven.channel.stop_condition & StopCondition.SINGLE_BLOCK:
            places.append(tuple(round(p, 4) for p in place(driven)[:2]))
            driven.operator.continue_motion_rw = True
            driven.watch(1)
    assert places[:3] == [(-20, 0), (0, R), (40 - R, R)]
    assert places[-1] == (-20, 80)
    assert driven.alarms == []


def test_a_search_enters_the_compensated_contour(demo: Machine, tmp_path: Path) -> None:
    driven = driven_by(demo, tmp_path)
    search(driven, PART, SearchKind.BLOCK_NUMBER, 50)
    path = path_of(driven)
    assert nearest(path, (40 - R, R)) < 0.06  # where N50 begins, with its vector
    assert nearest(path, (0, R)) > 1.0
    assert place(driven)[:2] == [-20, 80]


def test_backward_to_the_begin_and_forward_again(demo: Machine, tmp_path: Path) -> None:
    driven = driven_by(demo, tmp_path, storage=1000)
    driven.start(PART)
    driven.until(lambda: driven.channel.interpolator.line == 6)
    backward(driven, True)
    driven.until(lambda: at_begin(driven), 60.0)
    backward(driven, False)
    driven.until_done()
    assert driven.alarms == []
    assert place(driven)[:2] == [-20, 80]
    driven.assert_no_jump()


def test_a_reset_ends_compensation_and_the_next_program_begins_without(demo: Machine, tmp_path: Path) -> None:
    driven = driven_by(demo, tmp_path)
    driven.start(PART)
    driven.until(lambda: driven.channel.interpolator.line == 5)
    driven.reset()
    driven.until_done()
    driven.reset()
    driven.start("%O0002\nG90 G1 F6000 X10\nX20\nM30\n")
    y = place(driven)[1]
    driven.until_done()
    assert place(driven)[:2] == [20, y]
    driven.assert_no_jump()


def test_interference_stops_in_front_of_the_block_before(demo: Machine, tmp_path: Path) -> None:
    text = "%O0003\nG10 R5 L12 P1\nG90 G0 X-20\nG41 G1 X0 D1 F6000\nX40\nY-20\nX48\nY0\nX80\nG40 X100\nM30\n"
    driven = driven_by(demo, tmp_path)
    driven.start(text)
    driven.watch(4000)
    assert any("3048" in alarm.text for alarm in driven.alarms)
    assert place(driven)[:2] == [45, 5]
    driven.assert_no_jump()
