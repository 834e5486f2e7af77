"""A PLC that hangs or is killed at any moment: every axis comes to rest in time, on its path, and no position is lost.

`python -m bench plc_lost` does it two hundred times, and some times with the real processes.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from runtime.config.loader import load_machine
from runtime.diagnostics.catalogue import plc
from tests.machine.lost_plc import FEED, losses

REPEATS = int(os.environ.get("TANDEM_REPEATS", "6"))


@pytest.mark.spec("hli.mech.watchdog-cnc-monitors-plc")
def test_a_lost_plc_leaves_every_axis_at_rest_in_time_and_on_its_path(tmp_path: Path) -> None:
    period = load_machine(None).cycle.period
    for number, loss in enumerate(losses(tmp_path, REPEATS)):
        assert loss.limit < 0.5
        assert 0.0 < loss.rest_after <= loss.limit, number
        assert loss.greatest_step <= FEED * period * 1.001
        assert loss.off_path < 1e-6
        assert loss.first_alarm is plc.PLC_WATCHDOG
        assert loss.lost == 0.0, "where the CNC thinks they are"
        assert loss.moved_by_itself == 0.0, "nothing moves by itself when the PLC is back"
