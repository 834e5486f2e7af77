"""The recorder on the real processes: what they did is done again, bit by bit."""

from __future__ import annotations

import os
import signal
from pathlib import Path

from runtime.cli import main as cli
from runtime.diagnostics.catalogue import machine as alarms
from runtime.diagnostics.catalogue import plc
from runtime.hli.layout import State
from tests.system.running_machine import RunningMachine


def test_a_run_with_a_killed_plc_is_saved_and_replayed(machine: RunningMachine, tmp_path: Path) -> None:
    program = tmp_path / "part.nc"
    program.write_text("%P\nN10 G90 G54 G00 X5 Y5\nN20 G01 X200 F6000\nN30 M30\n")
    machine.start()
    machine.order(program)
    machine.wait_for(lambda: machine.x() > 1_100_000, "the motion")
    os.kill(machine.pid_of("PLC"), signal.SIGKILL)
    machine.wait_for(lambda: machine.has_alarm(alarms.PROCESS_LOST.id), "the alarm")
    machine.wait_for(lambda: machine.has_alarm(plc.PLC_WATCHDOG.id), "the watchdog")
    machine.wait_for(lambda: machine.channel_state() is State.ERROR, "the stop")
    machine.reset()
    machine.wait_for(lambda: machine.channel_state() is not State.ERROR, "the reset")
    folder = machine.state / "recorder"
    machine.wait_for(lambda: bool(list(folder.glob("alarm-*.tandem"))), "the recording of the alarm")
    assert machine.stop() == 0, machine.log.read_text()
    (saved,) = folder.glob("alarm-*.tandem")
    assert cli.main(["replay", str(saved)]) == 0
    whole = tmp_path / "whole.tandem"
    assert cli.main(["record", "save", str(whole), "-c", str(machine.machine)]) == 0
    assert cli.main(["replay", str(whole), "--trace", str(tmp_path / "trace")]) == 0
    assert "killed by SIGKILL" in (tmp_path / "trace" / "events.jsonl").read_text()
