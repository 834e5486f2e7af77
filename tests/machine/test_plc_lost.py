"""A PLC that hangs or is killed at any moment: every axis comes to rest in time, on its path, and no position is lost.

`TANDEM_REPEATS=200 pytest tests/machine/test_plc_lost.py` does it more often.
"""

from __future__ import annotations

import os
import random
from pathlib import Path

import numpy as np
import pytest

from runtime.diagnostics.catalogue import plc
from runtime.plc_logic.motion import MC_MoveVelocity
from tests.machine.beside_channel import Rig

REPEATS = int(os.environ.get("TANDEM_REPEATS", "15"))
# X and Y on one straight line, X twice as fast, to and fro
LINE = "%LINE\nN10 G90 G01 F9000 X400 Y200\nN20 X0 Y0\nN30 X400 Y200\nN40 M30\n"


@pytest.mark.spec("hli.mech.watchdog-cnc-monitors-plc")
def test_a_lost_plc_leaves_every_axis_at_rest_in_time_and_on_its_path(tmp_path: Path) -> None:
    rig, chance = Rig(tmp_path), random.Random(20)
    partner = rig.simulation.plc
    assert partner is not None
    image, period = rig.image, rig.simulation.period
    x, table = rig.machine.axes[0], rig.machine.axes[rig.table]
    # from any acceleration: bring it to zero, brake, and the watchdog before it
    path_braking = 150.0 / x.acceleration + 2.0 * x.acceleration / x.jerk
    table_braking = table.velocity / table.acceleration + 2.0 * table.acceleration / table.jerk
    limit = rig.machine.plc.watchdog + rig.machine.plc.every * period + max(path_braking, table_braking) + 0.01
    assert limit < 0.5
    for repeat in range(REPEATS):
        turn = MC_MoveVelocity()
        speed = chance.uniform(20.0, 180.0)
        rig.call("turn", lambda p, turn=turn, speed=speed: turn(Axis=p.axes["B"], Execute=True, Velocity=speed))  # type: ignore[misc]
        rig.start(LINE)
        assert rig.simulation.controller.channel.active, rig.simulation.problems[-1]
        rig.run(chance.uniform(0.0, 1.0))
        partner.frozen = True  # type: ignore[attr-defined]
        seen = len(rig.simulation.problems)
        places = []
        for _ in range(round((limit + 0.1) / period)):
            rig.cycle()
            places.append(image.target_position.copy())
        way = np.array(places)
        steps = np.abs(np.diff(way, axis=0))
        after = round(limit / period)
        assert steps[after:].max() == 0.0, f"{repeat}: not at rest after {limit:.3f} s"
        assert steps[:, 0].max() <= 150.0 * period * 1.001
        assert np.abs(way[:, 0] - 2.0 * way[:, 1]).max() < 1e-6, "on the path"
        assert [problem.entry for problem in rig.simulation.problems[seen : seen + 1]] == [plc.PLC_WATCHDOG]
        assert np.array_equal(image.target_position[:3], image.actual_position[:3]), "where the CNC thinks they are"
        here = way[-1].copy()
        partner.frozen = False  # type: ignore[attr-defined]
        if repeat % 2:  # it was killed: the reset starts it anew
            partner.restart()
        rig.hli.operator[0].reset_rw = True
        rig.until(rig.simulation.ready, 2.0)
        rig.run(0.05)
        assert np.array_equal(image.target_position[:3], here[:3]), "nothing moves by itself when the PLC is back"
        # back, so that the next repetition starts where this one did
        vars(rig.program)["calls"].clear()
        rig.start("%HOME\nN10 G90 G00 X0 Y0\nN20 M30\n")
        rig.until(lambda: not rig.simulation.controller.channel.active)
        assert np.abs(image.target_position[:2]).max() < 1e-9
        back = rig.table
        image.target_position[back] = image.actual_position[back] = 0.0  # the table is turned back by hand
