"""Threads and tapping beside what else a machine does: recorded and replayed, entered by a block search, parked kernels."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from runtime.cnc.interpolator.cycle import cycle
from runtime.cnc.interpolator.prediction import time_until
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import block_search as errors
from runtime.hli.layout import Mode
from tests.recorder.test_replay import Recorded

TEXT = (
    "%T\nN10 G90 G00 Z10\nN20 M3 S600\nN30 G95 F0.2 G01 X2\nN40 G94 G33 Z2 K1\nN50 G00 Z10\nN60 M5\nN70 G331 Z2 K1 S600\n"
    "N80 G332 Z10\nN90 G01 F1000 X5\nN100 M30\n"
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


def test_the_kernels_of_the_path_have_one_signature(demo: Machine, tmp_path: Path) -> None:
    recorded = Recorded(demo, tmp_path, ideal_axes=True)
    recorded.start(TEXT)
    assert recorded.simulation.run_until(lambda: not recorded.simulation.controller.channel.active, 30.0)
    recorded.simulation.close()
    kernels: tuple[Any, ...] = (cycle, time_until)
    for kernel in kernels:
        assert len(kernel.signatures) <= 1, kernel.signatures
    assert Mode.AUTOMATIC is not None
    assert errors.SEARCH_WITH_SPINDLE.id == 313105
