"""Threads and tapping beside what else a machine does: recorded and replayed from any keyframe, entered by a block search."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from runtime.cnc.interpolator.cycle import cycle
from runtime.cnc.interpolator.prediction import time_until
from runtime.cnc.search_target import SearchKind
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import block_search as errors
from runtime.hli.layout import SearchState
from tests.machine.test_block_search import make, place, refused, search, until
from tests.recorder.test_keyframes import assert_same_from_each, with_keyframes
from tests.recorder.test_replay import Recorded

TEXT = (
    "%T\nN10 G90 G00 Z10\nN20 M3 S600\nN30 G95 F0.2 G01 X2\nN40 G94 G33 Z2 K1\nN50 G00 Z10\nN60 M5\nN70 G331 Z2 K1 S600\n"
    "N80 G332 Z10\nN90 G01 F1000 X5\nN100 M30\n"
)
CHAIN = (
    "%T\nN10 G90 G00 Z10\nN20 M3 S600\nN30 #TURN [THREAD_CHAIN=1]\nN40 G33 Z6 K1\nN50 Z2 K2\nN60 G00 Z10\nN70 M5\n"
    "N80 G63 Z2 F600 S600\nN90 Z10 S-600\nN100 G01 X5\nN110 M30\n"
)


@pytest.mark.parametrize("ideal", [True, False])
def test_what_is_recorded_is_done_again(demo: Machine, tmp_path: Path, ideal: bool) -> None:
    recorded = Recorded(demo, tmp_path, ideal_axes=ideal)
    recorded.start(TEXT)
    recorded.run(0.3)
    unit = recorded.simulation.memory.hli.axes[3].control.override
    unit.enable_w, unit.command_w = True, 900
    assert recorded.simulation.run_until(lambda: not recorded.simulation.controller.channel.active, 30.0)
    assert float(recorded.simulation.controller.interpolator.position[0]) == 5.0
    assert recorded.replayed().difference is None


@pytest.mark.parametrize("role", ["cutting", "tapping"])
def test_a_replay_begins_in_the_middle_of_them(demo: Machine, tmp_path: Path, role: str) -> None:
    recorded = Recorded(demo, tmp_path, ideal_axes=True)
    recorded.start(TEXT)
    together = recorded.simulation.controller.channel.together
    assert recorded.simulation.run_until(lambda: bool(getattr(together, role)), 30.0)
    with_keyframes(recorded, 0.6, 97)
    assert getattr(together, role)
    recorded.run(0.5)
    assert_same_from_each(recorded, tmp_path, 3)


def test_the_kernels_of_the_path_have_one_signature(demo: Machine, tmp_path: Path) -> None:
    recorded = Recorded(demo, tmp_path, ideal_axes=True)
    recorded.start(TEXT)
    assert recorded.simulation.run_until(lambda: not recorded.simulation.controller.channel.active, 30.0)
    recorded.simulation.close()
    kernels: tuple[Any, ...] = (cycle, time_until)
    for kernel in kernels:
        assert len(getattr(kernel, "signatures", [])) <= 1, kernel.signatures


def test_a_block_search_enters_at_a_thread_and_behind_it(demo: Machine, tmp_path: Path) -> None:
    driven = make(demo, tmp_path)
    search(driven, CHAIN, SearchKind.BLOCK_NUMBER, 40)
    until(driven, SearchState.INACTIVE)
    driven.until(lambda: driven.channel.together.cutting)
    driven.until_done()
    assert place(driven) == [5.0, 0.0, 10.0]
    search(driven, CHAIN, SearchKind.BLOCK_NUMBER, 100)
    driven.until_done()
    assert driven.alarms == []
    assert place(driven) == [5.0, 0.0, 10.0]


@pytest.mark.parametrize("number", [50, 90])
def test_no_block_search_enters_them(demo: Machine, tmp_path: Path, number: int) -> None:
    driven = make(demo, tmp_path)
    search(driven, CHAIN, SearchKind.BLOCK_NUMBER, number)
    assert f"N{number}" in refused(driven, errors.SEARCH_WITH_SPINDLE)
