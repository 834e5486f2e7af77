"""#DIST TO GO: what the axes have still to go in a section."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import machine as alarms
from runtime.hli.layout import PathWay
from tests.machine.driven import Driven
from tests.machine.test_backward_motion import back_to, backward, make, place, way

PROGRAM = """%DIST
N10 G90 G17 G01 F6000 X10
N20 #DIST TO GO BEGIN
N30 X50 Z-5
N40 X30
N50 G02 X30 Y40 I0 J20
#CONTOUR MODE ON [DEV, PATH_DEV 0.5]
N60 G01 X60 Y40
N70 X60 Y50
#CONTOUR MODE OFF
N80 #DIST TO GO END
N90 X80
N100 M30
"""


def shown(driven: Driven) -> list[float]:
    return [value * 1e-4 for value in driven.hli.channels[0].status.dist_to_geom_end_r[:3]]


@pytest.mark.spec("isg.add.dist-to-go", "hli.ch.status.path")
def test_every_axis_tells_what_it_has_still_to_go(demo: Machine, tmp_path: Path) -> None:
    driven = make(demo, tmp_path)
    driven.start(PROGRAM)
    rows: list[list[float]] = []
    turned = False
    while driven.channel.active:
        driven.watch(1)
        if 3 <= driven.channel.interpolator.line < 11 and way(driven) is PathWay.ONWARD:
            rows.append([*place(driven), *shown(driven)])
        if not turned and place(driven)[1] > 20.0:
            turned = True
            before = np.array(shown(driven))
            back_to(driven, driven.channel.interpolator.path_position - 15.0)
            assert (np.array(shown(driven)) >= before - 1e-3).all()
            backward(driven, False)
    data = np.array(rows)
    assert data[2, 3:] == pytest.approx([40 + 20 + 40 + 30, 50, 5], abs=2.0)
    first = data[data[:, 0] < 45.0][5]  # on N30
    assert first[3:] == pytest.approx([50 - first[0] + 20 + 40 + 30, 50, 5 + first[2]], abs=0.6)
    behind = data[data[:, 1] > 41.0][-1]  # nearly at the end, where the smoothed corner lies behind
    assert behind[3:] == pytest.approx([60 - behind[0], 50 - behind[1], 0], abs=0.6)
    assert shown(driven) == [0.0, 0.0, 0.0]
    assert driven.alarms == []


@pytest.mark.spec("isg.add.dist-to-go")
def test_a_deleted_distance_is_warned_of(demo: Machine, tmp_path: Path) -> None:
    driven = make(demo, tmp_path)
    driven.start(PROGRAM)
    driven.until_x(20.0)
    unit = driven.hli.channels[0].control.delete_distance_to_go
    unit.enable_w = unit.command_w = True
    driven.until_done()
    assert driven.alarm(alarms.DISTANCE_WRONG)


@pytest.mark.spec("isg.add.dist-to-go")
def test_nothing_is_shown_until_the_end_is_known(demo: Machine, tmp_path: Path) -> None:
    driven = make(demo, tmp_path)
    driven.start(PROGRAM.replace("N40 X30", "N40 X30\n#FLUSH WAIT"))
    driven.until(lambda: driven.channel.interpolator.line == 4)
    driven.watch(20)
    assert shown(driven) == [0.0, 0.0, 0.0]
    driven.until(lambda: driven.channel.interpolator.line == 7)
    driven.watch(20)
    assert shown(driven)[1] > 40.0
    driven.until_done()
    long = make(demo, tmp_path)
    moves = "".join(f"X{20 + i % 2 * 0.3}\n" for i in range(20_000))
    long.start(f"%LONG\nG90 G01 F6000 X20\n#DIST TO GO BEGIN\n{moves}#DIST TO GO END\nM30\n")
    long.until(lambda: bool(long.alarms))
    assert long.alarm(alarms.DISTANCE_LATE)
    assert long.channel.active
