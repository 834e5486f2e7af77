"""The real processes of a machine: run, stop, and what happens when one of them is killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml

from runtime.diagnostics.catalogue import machine as alarms
from runtime.diagnostics.catalogue import plc
from runtime.drives import DriveState
from runtime.hli.layout import State
from tests.system.running_machine import RunningMachine


def moving(machine: RunningMachine) -> bool:
    before = machine.x()
    time.sleep(0.05)
    return machine.x() != before


def at_rest(machine: RunningMachine) -> bool:
    places = set()
    for _ in range(10):
        places.add(machine.x())
        time.sleep(0.02)
    return len(places) == 1


def test_a_program_runs_from_start_to_end_and_leaves_its_positions(machine: RunningMachine, tmp_path: Path) -> None:
    program = tmp_path / "short.nc"
    program.write_text(
        "%SHORT\nG90 G54\nM20\nT1 M6\nS3000 M3\nG00 X10 Y5 Z20\nG01 Z10 F2000\nX30 M8\nM9 M5\nM21\nM30\n"
    )
    machine.start("--program", str(program), "--plot", str(tmp_path / "path.png"))
    metrics = machine.scrape()
    assert "tandem_cycle_work_seconds_bucket" in metrics
    assert 'axis="X"' in metrics
    assert machine.process is not None
    assert machine.process.wait(60) == 0, machine.log.read_text()
    log = machine.log.read_text()
    assert "short.nc: done" in log
    assert "X 130.000  Y 85.000  Z 110.000" in log
    assert (tmp_path / "path.png").read_bytes().startswith(b"\x89PNG")
    assert '"X": 13' in (machine.state / "retained.json").read_text().replace("129.99", "130")


def test_short_of_memory_the_kernel_ends_plc_and_preparation_before_the_cycle(machine: RunningMachine) -> None:
    machine.start()
    assert machine.memory.hli.head.running_r
    names = ("PLC", "preparation", "cycle", "service")
    scores = {name: int(Path(f"/proc/{machine.pid_of(name)}/oom_score_adj").read_text()) for name in names}
    assert scores["PLC"] > scores["preparation"] > scores["cycle"]
    assert scores["cycle"] == scores["service"], "as the unit says"
    limits = Path(f"/proc/{machine.pid_of('PLC')}/limits").read_text().splitlines()
    (data,) = (line.split()[3] for line in limits if line.startswith("Max data size"))
    assert 1_024_000_000 < int(data) < 2_048_000_000


def test_sigterm_brings_the_axes_to_rest_and_ends_with_0(machine: RunningMachine, long_program: Path) -> None:
    machine.start()
    machine.order(long_program)
    machine.wait_for(lambda: moving(machine), "motion")
    assert machine.stop() == 0, machine.log.read_text()
    assert "brought to rest" in machine.log.read_text()


def test_sigterm_to_every_process_stops_as_sigterm_to_one(machine: RunningMachine, long_program: Path) -> None:
    """So systemd does it, and so it goes on when the main process has died."""
    machine.start()
    machine.order(long_program)
    machine.wait_for(lambda: moving(machine), "motion")
    for name in ("PLC", "preparation", "drives", "cycle", "service"):
        os.kill(machine.pid_of(name), signal.SIGTERM)
    assert machine.process is not None
    assert machine.process.wait(60) == 0, machine.log.read_text()
    log = machine.log.read_text()
    assert "brought to rest" in log
    assert str(alarms.PROCESS_LOST.id) not in log, "nobody was missed while the axes braked"


@pytest.mark.parametrize("victim", ["PLC", "preparation", "drives"])
def test_a_killed_process_stops_the_axes_and_is_named(machine: RunningMachine, long_program: Path, victim: str) -> None:
    machine.start()
    machine.order(long_program)
    machine.wait_for(lambda: moving(machine), "motion")
    os.kill(machine.pid_of(victim), signal.SIGKILL)
    machine.wait_for(lambda: machine.channel_state() is State.ERROR, "the alarm")
    machine.wait_for(lambda: at_rest(machine), "standstill")
    machine.wait_for(lambda: machine.has_alarm(alarms.PROCESS_LOST.id), "the alarm that names the process")
    assert any(victim in alarm.text and "SIGKILL" in alarm.text for alarm in machine.alarms)
    assert machine.stop() == 0
    assert "SIGKILL" in machine.log.read_text()


HUNGRY = """
from pathlib import Path

from runtime.demo.plc import DemoMill


class Hungry(DemoMill):
    def cycle(self):
        super().cycle()
        if Path({flag!r}).exists():
            self.eaten = (*getattr(self, "eaten", ()), b"x" * 8_000_000)
"""


def test_a_plc_program_that_eats_memory_meets_its_limit_and_the_axes_stop(
    machine: RunningMachine, long_program: Path, tmp_path: Path
) -> None:
    """The kernel refuses (RLIMIT_DATA) before the host suffers; the axes brake on the path and keep their positions."""
    flag = tmp_path / "hungry"
    (tmp_path / "hungry.py").write_text(HUNGRY.format(flag=str(flag)))
    description = yaml.safe_load(machine.machine.read_text())
    description["plc"] |= {"program": "hungry.py", "memory": 64}
    machine.machine.write_text(yaml.safe_dump(description))
    machine.start()
    machine.order(long_program)
    machine.wait_for(lambda: moving(machine), "motion")
    victim = machine.pid_of("PLC")
    flag.touch()
    machine.wait_for(lambda: machine.channel_state() is State.ERROR, "the alarm")
    machine.wait_for(lambda: at_rest(machine), "standstill")
    machine.wait_for(lambda: machine.has_alarm(plc.PLC_RAISED.id), "the alarm with the line of the program")
    assert any("MemoryError" in alarm.text and "hungry.py" in alarm.text for alarm in machine.alarms)
    assert not Path(f"/proc/{victim}").exists()
    status = machine.memory.hli.axes[0].status
    assert status.ready_for_control_loop_on_r  # the drives hold the axes
    assert abs(status.position_lag_r) < 1_000  # 0.1 mm
    stands = machine.x()
    flag.unlink()
    machine.reset()
    machine.wait_for(lambda: bool(machine.memory.hli.platform.plc_running_r), "the PLC again")
    assert abs(machine.x() - stands) < 1_000
    machine.order(long_program)
    machine.wait_for(lambda: moving(machine), "motion again")
    assert machine.stop() == 0


def test_a_killed_cycle_is_named_in_journal_and_hli_and_ends_the_service(
    machine: RunningMachine, long_program: Path
) -> None:
    machine.start()
    machine.order(long_program)
    machine.wait_for(lambda: moving(machine), "motion")
    memory = machine.memory
    os.kill(machine.pid_of("cycle"), signal.SIGKILL)
    assert machine.process is not None
    assert machine.process.wait(60) != 0
    assert not memory.hli.head.running_r
    assert any("cycle: killed by SIGKILL" in alarm.text for alarm in machine.alarms)
    assert machine.log.read_text().count("cycle: killed by SIGKILL") == 1
    assert [path.name for path in Path("/dev/shm").glob(f"{machine.name}*")] == [machine.name]
    watch = [sys.executable, "-m", "runtime.cli.main", "hli", "watch", "--once", "--name", machine.name]
    picture = subprocess.run(watch, capture_output=True, text=True, check=True).stdout
    assert "not running" in picture
    assert "cycle: killed by SIGKILL" in picture


def test_a_frozen_cycle_is_ended_and_named(machine: RunningMachine, long_program: Path) -> None:
    machine.start()
    machine.order(long_program)
    machine.wait_for(lambda: moving(machine), "motion")
    memory = machine.memory
    os.kill(machine.pid_of("cycle"), signal.SIGSTOP)
    assert machine.process is not None
    assert machine.process.wait(60) == 1
    assert not memory.hli.head.running_r
    assert any(alarm.id == alarms.CYCLE_LOST.id and "no cycle for 5 s" in alarm.text for alarm in machine.alarms)
    assert str(alarms.CYCLE_LOST.id) in (machine.state / "retained.json").read_text()


def test_a_killed_service_process_stops_the_machine_under_control(machine: RunningMachine, long_program: Path) -> None:
    machine.start()
    machine.order(long_program)
    machine.wait_for(lambda: moving(machine), "motion")
    memory, cycle = machine.memory, machine.pid_of("cycle")
    os.kill(machine.pid_of("service"), signal.SIGKILL)
    machine.wait_for(lambda: not memory.hli.head.running_r, "the end of the cycle")
    machine.wait_for(lambda: not Path(f"/proc/{cycle}").exists(), "the end of the cycle process")
    assert machine.has_alarm(alarms.SERVICE_LOST.id)
    assert at_rest(machine)
    assert all(axis.status.drive_state_r < DriveState.OPERATION_ENABLED for axis in memory.hli.axes)
    assert str(alarms.SERVICE_LOST.id) in machine.log.read_text()
    assert str(alarms.SERVICE_LOST.id) in (machine.state / "retained.json").read_text()


def test_a_hanging_plc_stops_the_path_and_a_reset_starts_it_again(machine: RunningMachine, long_program: Path) -> None:
    machine.start()
    machine.order(long_program)
    machine.wait_for(lambda: moving(machine), "motion")
    os.kill(machine.pid_of("PLC"), signal.SIGSTOP)
    machine.wait_for(lambda: machine.has_alarm(plc.PLC_WATCHDOG.id), "the watchdog alarm")
    machine.wait_for(lambda: at_rest(machine), "standstill")
    machine.reset()
    machine.wait_for(lambda: machine.channel_state() is State.SELECTED, "the reset")
    machine.order(long_program)  # waits until the new PLC runs
    machine.wait_for(lambda: moving(machine), "motion after the restart")
    assert machine.stop() == 0


def test_a_plc_program_that_raises_leaves_its_traceback(
    machine: RunningMachine, long_program: Path, tmp_path: Path
) -> None:
    program = tmp_path / "bad_plc.py"
    program.write_text(
        "from runtime.plc_logic import Program\n\n\nclass Bad(Program):\n"
        "    def cycle(self) -> None:\n        if self.time > 3.0:\n            raise ValueError('valve 7')\n"
    )
    text = machine.machine.read_text().replace("runtime.demo.plc:DemoMill", "bad_plc.py")
    machine.machine.write_text(text)
    machine.start()
    machine.wait_for(lambda: machine.has_alarm(plc.PLC_RAISED.id), "the alarm")
    assert any("valve 7" in alarm.text for alarm in machine.alarms)
    assert machine.stop() == 0
    assert "bad_plc.py" in machine.log.read_text()
