"""G135, G136, G137: what the drives are told beside their set-points."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from runtime.cnc.blocks import FeedForward
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import language as catalogue
from runtime.fieldbus import cia402
from tests.cnc.decoder.programs import SETUP, decode
from tests.machine.driven import Driven
from tests.machine.scripted_plc import ScriptedPlc

SPEC = pytest.mark.spec("isg.g.feedforward-g135-g137")
X = 1  # node
PROGRAM = """%FORWARD
N10 G90 G01 F6000 X40
N20 G135
N30 X80
N40 G136 X50
N50 X120
N60 G137
N70 X160
N80 G135
N90 X200
N100 M30
"""


def shares(text: str) -> list[tuple[float, ...]]:
    run = decode(f"{text}\nM30", SETUP)
    assert run.problem is None
    return [block.shares for block in run.blocks if isinstance(block, FeedForward)]


@SPEC
def test_weights_stay_and_count_while_it_is_selected() -> None:
    assert shares("G136 X80 Y95 Z0\nG135\nG137\nG135 G136 Y150") == [
        (0.8, 0.95, 0.0),
        (0.0, 0.0, 0.0),
        (0.8, 0.95, 0.0),
        (0.8, 1.0, 0.0),
    ]
    assert shares("G135") == [(1.0, 1.0, 1.0)]
    problem = decode("G136 X-1\nM30", SETUP).problem
    assert problem is not None
    assert problem.entry is catalogue.WEIGHT_INVALID


@SPEC
def test_the_drive_gets_its_share_and_never_a_step(demo: Machine, tmp_path: Path) -> None:
    first = demo.axes[0]
    assert first.drive is not None
    described = first.model_copy(update={"drive": first.drive.model_copy(update={"velocity_feed_forward": 1.0})})
    machine = demo.model_copy(update={"axes": (described, *demo.axes[1:])})
    driven = Driven(machine, tmp_path, partner=lambda memory: ScriptedPlc(memory, {}))
    driven.start(PROGRAM)
    drive = driven.drive(0)
    told: list[float] = []
    places: list[float] = []
    while driven.channel.active:
        driven.watch(1)
        told.append(drive.values[cia402.VELOCITY_OFFSET, 0] / 10_000)
        places.append(float(driven.targets[-1][0]))
    at = {x: int(np.argmax(np.array(places) > x)) for x in (30.0, 70.0, 110.0, 150.0, 190.0)}
    assert [told[k] for k in at.values()] == pytest.approx([0.0, 100.0, 50.0, 0.0, 50.0], abs=0.5)
    change = np.abs(np.diff(told))
    assert change.max() <= 4.0 + 100.0 * driven.simulation.period / 0.1 + 0.1  # 4 m/s², and the share over 0.1 s
    assert driven.alarms == []
