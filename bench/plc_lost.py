"""How a machine stops whose PLC hangs or is killed: 200 times in virtual time, ten times with the real processes.

What is asked: at rest within the watchdog time, one PLC cycle and the jerk-limited braking from any acceleration, and no position
lost. In real time the host's scheduling comes on top, and a look at the positions every millisecond.
"""

from __future__ import annotations

import os
import random
import signal
import tempfile
import time
from pathlib import Path

import numpy as np

from bench.figure import Figure
from runtime.config.loader import load_machine
from runtime.diagnostics.catalogue import plc
from runtime.hli.layout import State
from runtime.kernels import warm_up
from tests.machine.lost_plc import losses
from tests.system.running_machine import RunningMachine

REPEATS = 200
REAL_REPEATS = 10
PROGRAM = "%LONG\nG90 G01 F3000\n$FOR P1 = 1, 200, 1\nX200\nX100\n$ENDFOR\nM30\n"
STILL = 0.1  # s without motion is rest
SECONDS_TO_REST = 5.0  # looked at after the loss
HOST = 0.02  # s that the host may be late in real time
INCREMENT = 1e-4  # mm of the interface


def measure() -> list[Figure]:
    """Both, the worst of all repetitions."""
    warm_up()
    with tempfile.TemporaryDirectory() as name:
        found = list(losses(Path(name), REPEATS))
    virtual = f"{REPEATS} losses in virtual time"
    figures = [
        Figure(f"{virtual}, latest rest", max(loss.rest_after for loss in found) * 1e3, "ms", found[0].limit * 1e3),
        Figure(f"{virtual}, median", float(np.median([loss.rest_after for loss in found])) * 1e3, "ms"),
        Figure(f"{virtual}, greatest distance from the path", max(loss.off_path for loss in found), "mm", 1e-6),
        Figure(f"{virtual}, greatest position lost", max(loss.lost for loss in found), "mm", 0.0),
        Figure(f"{virtual}, alarms other than the watchdog's",
               sum(loss.first_alarm is not plc.PLC_WATCHDOG for loss in found), "", 0),
    ]  # fmt: skip
    return [*figures, *_real()]


def _real() -> list[Figure]:
    """The processes of `tandem run`; the PLC is stopped (SIGSTOP) and killed in turn."""
    rest, lost, limit = [], [], 0.0
    chance = random.Random(7)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "long.nc").write_text(PROGRAM)
        running = RunningMachine(folder, 41_000 + os.getpid() % 1000)
        machine = load_machine(running.machine)
        x = machine.axes[0]
        braking = 50.0 / x.acceleration + 2.0 * x.acceleration / x.jerk
        limit = machine.plc.watchdog + machine.plc.every * machine.cycle.period + braking + HOST
        running.start()
        try:
            for repeat in range(REAL_REPEATS):
                running.order(folder / "long.nc")
                before = running.x()
                running.wait_for(lambda before=before: running.x() != before, "motion")  # type: ignore[misc]
                time.sleep(chance.uniform(0.2, 2.5))
                os.kill(running.pid_of("PLC"), signal.SIGSTOP if repeat % 2 else signal.SIGKILL)
                rest.append(_time_to_rest(running))
                status = running.memory.hli.axes[0].status
                lost.append(abs(int(status.command_position_r) - int(status.actual_position_r)) * INCREMENT)
                running.wait_for(lambda: running.channel_state() is State.ERROR, "the alarm")
                running.reset()
                running.wait_for(lambda: running.channel_state() is State.SELECTED, "the reset")
        finally:
            running.stop()
    real = f"{REAL_REPEATS} losses of the real process"
    return [
        Figure(f"{real}, latest rest", max(rest) * 1e3, "ms", limit * 1e3),
        Figure(f"{real}, median", float(np.median(rest)) * 1e3, "ms"),
        # the drive's own window, since an encoder stands where its servo leaves it
        Figure(f"{real}, greatest position lost", max(lost), "mm", x.in_position),
    ]


def _time_to_rest(running: RunningMachine) -> float:
    """From now to the last change of the commanded position, s."""
    begin = time.monotonic()
    moved, place = begin, None
    while (now := time.monotonic()) < begin + SECONDS_TO_REST and (
        now < moved + STILL or place is None or now < begin + 1
    ):
        here = int(running.memory.hli.axes[0].status.command_position_r)
        if here != place:
            place, moved = here, now
        time.sleep(0.001)
    return moved - begin
