"""A PLC that hangs or is killed at a random moment, again and again, in virtual time: what the axes do then."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from runtime.diagnostics.errors import ErrorEntry
from runtime.plc_logic.motion import MC_MoveVelocity
from tests.machine.beside_channel import Rig

# X and Y on one straight line, X twice as fast, to and fro
LINE = "%LINE\nN10 G90 G01 F9000 X400 Y200\nN20 X0 Y0\nN30 X400 Y200\nN40 M30\n"
FEED = 150.0  # mm/s of X


@dataclass(frozen=True, slots=True)
class Loss:
    """One repetition. Times in s from the moment of the loss, lengths in mm."""

    rest_after: float  # the last set-point that differs from the one before
    limit: float  # watchdog, one PLC cycle, jerk-limited braking from any acceleration, 10 ms
    greatest_step: float  # of X in a cycle
    off_path: float  # greatest distance of X from twice Y
    lost: float  # of any axis: where the CNC believes it to be, less where it is
    moved_by_itself: float  # of any axis when the PLC is back
    first_alarm: ErrorEntry | None


def losses(folder: Path, repeats: int, seed: int = 20) -> Iterator[Loss]:
    """The path moves on a line, a table turns for the PLC at some speed, and the PLC falls silent at some moment.

    Every second time it was killed, and is started anew by the reset.
    """
    rig, chance = Rig(folder), random.Random(seed)
    partner = rig.simulation.plc
    assert partner is not None
    image, period = rig.image, rig.simulation.period
    x, table = rig.machine.axes[0], rig.machine.axes[rig.table]
    path_braking = FEED / x.acceleration + 2.0 * x.acceleration / x.jerk
    table_braking = table.velocity / table.acceleration + 2.0 * table.acceleration / table.jerk
    limit = rig.machine.plc.watchdog + rig.machine.plc.every * period + max(path_braking, table_braking) + 0.01
    for repeat in range(repeats):
        turn = MC_MoveVelocity()
        speed = chance.uniform(20.0, 180.0)
        rig.call("turn", lambda p, turn=turn, speed=speed: turn(Axis=p.axes["B"], Execute=True, Velocity=speed))  # type: ignore[misc]
        rig.start(LINE)
        assert rig.simulation.controller.channel.active, rig.simulation.problems[-1]
        rig.run(chance.uniform(0.0, 1.0))
        partner.frozen = True  # type: ignore[attr-defined]
        seen = len(rig.simulation.problems)
        places = [image.target_position.copy()]
        for _ in range(round((limit + 0.1) / period)):
            rig.cycle()
            places.append(image.target_position.copy())
        way = np.array(places)
        steps = np.abs(np.diff(way, axis=0))
        moving = np.flatnonzero(steps.max(axis=1))
        alarms = rig.simulation.problems[seen:]
        lost = np.abs(image.target_position[:3] - image.actual_position[:3]).max()
        here = way[-1].copy()
        partner.frozen = False  # type: ignore[attr-defined]
        if repeat % 2:
            partner.restart()
        rig.hli.operator[0].reset_rw = True
        rig.until(rig.simulation.ready, 2.0)
        rig.run(0.05)
        yield Loss(
            rest_after=float((moving[-1] + 1) * period) if moving.size else 0.0,
            limit=limit,
            greatest_step=float(steps[:, 0].max()),
            off_path=float(np.abs(way[:, 0] - 2.0 * way[:, 1]).max()),
            lost=float(lost),
            moved_by_itself=float(np.abs(image.target_position[:3] - here[:3]).max()),
            first_alarm=alarms[0].entry if alarms else None,
        )
        # back, so that the next repetition starts where this one did
        vars(rig.program)["calls"].clear()
        rig.start("%HOME\nN10 G90 G00 X0 Y0\nN20 M30\n")
        rig.until(lambda: not rig.simulation.controller.channel.active)
        assert np.abs(image.target_position[:2]).max() < 1e-9
        back = rig.table
        image.target_position[back] = image.actual_position[back] = 0.0  # the table is turned back by hand
