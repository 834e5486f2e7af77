"""The machine is switched off: the path brakes, the axes come to where they are told to be, then the drives are switched off."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from runtime.config.machine import Machine
from runtime.drives import DriveState
from runtime.scheduler.controller import SETTLED
from tests.machine.driven import Driven

LINE = "%LINE\nN10 G90 G01 F9000 X400 Y200\nN20 M30\n"  # no spindle that takes longer
ON = int(DriveState.OPERATION_ENABLED)


def switched_off(driven: Driven, limit: int = 4000) -> None:
    controller = driven.simulation.controller
    controller.stop()
    for _ in range(limit):
        driven.watch(1)
        if controller.stopped:
            return
    pytest.fail("the drives are not switched off")


def test_drives_are_switched_off_where_the_axes_stand(demo: Machine, tmp_path: Path) -> None:
    driven = Driven(demo, tmp_path)
    driven.start(LINE)
    driven.watch(1500)
    assert abs(driven.targets[-1][0] - driven.targets[-2][0]) > 0.05, "in motion"
    switched_off(driven)
    on = [cycle for cycle, states in enumerate(driven.states) if states[0] == ON]
    last = on[-1] - 3  # on the bus an order takes effect some cycles later
    still = round(SETTLED / demo.cycle.period) - 5
    targets = np.array(driven.targets)[:, :3]
    assert (targets[last - still : last] == targets[last]).all(), "the set-points rest before"
    driven.assert_no_jump()
    assert targets[-1] == pytest.approx(targets[last], abs=0.001), "nothing coasts: the axes stood there"


def test_an_axis_that_cannot_come_there_is_switched_off_all_the_same(demo: Machine, tmp_path: Path) -> None:
    driven = Driven(demo, tmp_path)
    driven.simulation.controller.supervision.window[:] = -1.0  # never in position
    switched_off(driven, 1500)
    assert len(driven.targets) > 1000
