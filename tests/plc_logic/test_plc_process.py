"""The PLC process from outside: it runs a cycle per wake-up, and whatever ends it leaves a reason."""

from __future__ import annotations

import contextlib
import itertools
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from runtime.config.loader import DEMO_MACHINE, load_machine
from runtime.hli.describe import describe_machine
from runtime.hli.memory import HliMemory, get_text
from runtime.hli.watchdog import PlcWatchdog
from runtime.plc_logic.retained_variables import read_journal

PATIENCE = 30.0  # s; only a failing test waits that long
_numbers = itertools.count()


def wait_for(condition: Callable[[], bool]) -> bool:
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.002)
    return True


class Rig:
    """The cycle process' side: owner of the HLI, waker of the PLC."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.memory = HliMemory.create(f"tandem-plc-{os.getpid()}-{next(_numbers)}")
        describe_machine(self.memory.hli, load_machine())
        self.memory.hli.head.running_r = True
        self.wake_fd = os.eventfd(0)
        self.platform = self.memory.hli.platform
        self.process: subprocess.Popen[str] | None = None

    def start(self, program: str | None = None, machine: str = "demo", memory: int = 1024) -> subprocess.Popen[str]:
        """Start the PLC process; with a program text, as the file of a machine of its own."""
        if program is not None:
            (self.folder / "mill.py").write_text(program)
            text = DEMO_MACHINE.read_text().replace("runtime.demo.plc:DemoMill", f"mill.py\n  memory: {memory}")
            (self.folder / "machine.yaml").write_text(text)
            machine = str(self.folder / "machine.yaml")
        arguments = ["--machine", machine, "--hli", str(self.memory.name), "--wake-fd", str(self.wake_fd)]
        self.process = subprocess.Popen(
            [sys.executable, "-m", "runtime.scheduler.plc_process", *arguments],
            stderr=subprocess.PIPE,
            text=True,
            pass_fds=[self.wake_fd],
        )
        return self.process

    def cycle(self) -> None:
        """One PLC cycle is due."""
        self.memory.hli.head.time_ns_r += 4_000_000
        self.platform.plc_cycle_request_r += 1
        os.eventfd_write(self.wake_fd, 1)

    def run_cycle(self) -> bool:
        """The same, and wait for its end."""
        self.cycle()
        return wait_for(lambda: self.platform.plc_cycle_done_w == self.platform.plc_cycle_request_r)

    def end(self) -> tuple[int, str]:
        """Wait for the end of the process: exit code and what it said."""
        assert self.process is not None
        _, said = self.process.communicate(timeout=PATIENCE)
        return self.process.returncode, said

    def close(self) -> None:
        if self.process is not None and self.process.poll() is None:
            self.process.kill()
            self.process.communicate()
        os.close(self.wake_fd)
        self.memory.close()


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    with contextlib.closing(Rig(tmp_path)) as rig:
        yield rig


@pytest.mark.spec("hli.mech.shared-memory", "hli.mech.plc-present")
def test_a_cycle_per_wake_up_until_sigterm(rig: Rig) -> None:
    process = rig.start()
    assert wait_for(lambda: bool(rig.platform.plc_present_w))
    for _ in range(3):
        assert rig.run_cycle()
    assert rig.platform.plc_cycle_time_ns_w > 0
    assert rig.memory.hli.channels[0].control.feedhold.command_w, "the door is open: DemoMill holds"
    process.send_signal(signal.SIGINT)  # Ctrl+C reaches the whole group; the runtime decides
    assert rig.run_cycle()
    process.send_signal(signal.SIGTERM)
    assert rig.run_cycle()
    assert rig.run_cycle(), "the machine brakes with its PLC"
    rig.memory.hli.head.running_r = False
    assert rig.end() == (0, "")
    assert not rig.platform.plc_present_w
    assert not rig.memory.hli.channels[0].control.feedhold.enable_w


def test_it_ends_with_the_runtime(rig: Rig) -> None:
    rig.start()
    assert wait_for(lambda: bool(rig.platform.plc_present_w))
    assert rig.run_cycle()
    rig.memory.hli.head.running_r = False
    assert rig.end() == (0, "")


RAISES = """
from runtime.plc_logic import Program

class Mill(Program):
    def cycle(self) -> None:
        if self.time > 0.01:
            self.io.clamp_valve = self.pressure / 0
    pressure = 1
"""


EATS = """
from runtime.plc_logic import Program

class Mill(Program):
    eaten = ()
    def cycle(self) -> None:
        self.eaten = (*self.eaten, bytes(10_000_000))
"""


def test_a_program_that_eats_memory_fails_in_its_own_line(rig: Rig) -> None:
    process = rig.start(EATS, memory=64)
    assert wait_for(lambda: bool(rig.platform.plc_present_w))
    assert Path(f"/proc/{process.pid}/oom_score_adj").read_text() == "800\n"
    cycles = 0
    while rig.platform.plc_error_count_w == 0 and cycles < 20:
        rig.cycle()
        cycles += 1
        wait_for(
            lambda: (
                rig.platform.plc_cycle_done_w == rig.platform.plc_cycle_request_r or rig.platform.plc_error_count_w > 0
            )
        )
    code, said = rig.end()
    assert code == 4
    assert "MemoryError" in said
    assert "mill.py" in said
    assert 5 <= cycles <= 7, "64 MB are six times ten, or one less"


def test_a_program_that_raises_leaves_its_traceback(rig: Rig) -> None:
    rig.start(RAISES)
    assert wait_for(lambda: bool(rig.platform.plc_present_w))
    for _ in range(4):
        rig.cycle()
        wait_for(
            lambda: (
                rig.platform.plc_cycle_done_w == rig.platform.plc_cycle_request_r or rig.platform.plc_error_count_w > 0
            )
        )
    code, said = rig.end()
    assert code == 4
    for text in (said, get_text(rig.platform, "plc_error_text_w")):
        assert "ZeroDivisionError: division by zero (mill.py:7, in cycle)" in text
        assert "self.pressure / 0" in text
    assert rig.platform.plc_error_id_w == 304026
    assert rig.platform.plc_present_w
    # and it can be started again
    rig.start(RAISES.replace("/ 0", "/ 1"))
    assert wait_for(lambda: rig.platform.plc_error_id_w == 0)
    assert rig.run_cycle()


COUNTS = """
from runtime.plc_logic import Program, retain

class Mill(Program):
    total = retain(0)

    def setup(self):
        self.count = 0

    def cycle(self):
        self.count += 1
        self.total += 1
        self.warning(f"count {self.count}")
"""


def test_the_program_is_replaced_while_the_process_runs(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STATE_DIRECTORY", str(rig.folder / "state"))
    process = rig.start(COUNTS)
    assert wait_for(lambda: bool(rig.platform.plc_present_w))
    for _ in range(5):
        assert rig.run_cycle()
    rig.platform.plc_running_r = True  # as the cycle process finds
    said = [reload_while_cycles_go_on(rig, text) for text in (COUNTS, COUNTS.replace("+= 1", "+= 1 / 0", 1))]
    assert said[0][0] == 0
    assert "Mill runs; state kept: count" in said[0][1]
    assert said[1][0] == 1
    assert "304069" in said[1][1]
    assert "self.count += 1 / 0" in said[1][1]
    assert process.poll() is None
    assert rig.run_cycle(), "the old one goes on"
    process.kill()
    process.wait()
    _, kept, torn = read_journal(rig.folder / "state" / "plc")
    assert kept["total"] == rig.platform.plc_cycle_done_w
    assert torn is None


def reload_while_cycles_go_on(rig: Rig, text: str) -> tuple[int, str]:
    """Exit code and output of `tandem plc reload` for a new text of the program."""
    (rig.folder / "mill.py").write_text(text)
    command = [sys.executable, "-m", "runtime.cli.main", "plc", "reload", "--name", str(rig.memory.name)]
    asked = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    while asked.poll() is None:
        assert rig.run_cycle()
        time.sleep(0.002)
    return asked.returncode, asked.communicate()[0]


def test_without_a_running_program_there_is_nothing_to_replace(rig: Rig) -> None:
    command = [sys.executable, "-m", "runtime.cli.main", "plc", "reload", "--name", str(rig.memory.name)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 1
    assert "304070" in done.stderr


@pytest.mark.parametrize(
    ("program", "error"),
    [("class Mill(\n", 304021), ("x = 1\n", 304022), ("import no_such_neighbour\n", 304024)],
)
def test_a_program_that_cannot_be_loaded(rig: Rig, program: str, error: int) -> None:
    rig.start(program)
    code, said = rig.end()
    assert code == 3
    assert f"{error}: PLC program" in said
    assert "mill.py" in said
    assert rig.platform.plc_error_id_w == error
    assert not rig.platform.plc_present_w


def test_a_missing_program(rig: Rig) -> None:
    rig.start("x = 1\n")
    rig.end()
    (rig.folder / "mill.py").unlink()
    rig.start(machine=str(rig.folder / "machine.yaml"))
    code, said = rig.end()
    assert code == 3
    assert "304020" in said
    assert str(rig.folder / "mill.py") in said


@pytest.mark.spec("hli.mech.init-check")
def test_an_hli_of_another_layout_is_not_touched(rig: Rig) -> None:
    rig.memory.hli.head.layout_hash_r = b"0" * 64
    rig.start()
    code, said = rig.end()
    assert code == 5
    assert "304004" in said
    assert not rig.platform.plc_present_w


def test_a_wrong_machine_description(rig: Rig) -> None:
    (rig.folder / "wrong.yaml").write_text("name: [\n")
    rig.start(machine=str(rig.folder / "wrong.yaml"))
    code, said = rig.end()
    assert code == 6
    assert "wrong.yaml" in said


@pytest.mark.spec("hli.mech.watchdog-cnc-monitors-plc")
def test_a_plc_that_hangs_is_found_and_may_come_back(rig: Rig) -> None:
    process = rig.start()
    assert wait_for(lambda: bool(rig.platform.plc_present_w))
    watchdog = PlcWatchdog(rig.memory.hli.channels[0])
    assert rig.run_cycle()
    assert watchdog.check(0) is None
    process.send_signal(signal.SIGSTOP)
    rig.cycle()
    allowed_ns = int(rig.memory.hli.channels[0].watchdog.cycle_time_w) * 1000
    assert watchdog.check(allowed_ns - 1_000_000) is None
    problem = watchdog.check(allowed_ns + 1_000_000)
    assert problem is not None
    assert problem.entry.id == 270053
    process.send_signal(signal.SIGCONT)
    assert wait_for(lambda: bool(rig.memory.hli.channels[0].watchdog.alive_rw))


OWNER = """
import os, subprocess, sys, time
from runtime.config.loader import load_machine
from runtime.hli.describe import describe_machine
from runtime.hli.memory import HliMemory
memory = HliMemory.create(sys.argv[1])
describe_machine(memory.hli, load_machine())
memory.hli.head.running_r = True
wake = os.eventfd(0)
plc = subprocess.Popen([sys.executable, "-m", "runtime.scheduler.plc_process", "--machine", "demo",
                        "--hli", sys.argv[1], "--wake-fd", str(wake)], pass_fds=[wake])
while not memory.hli.platform.plc_present_w:
    time.sleep(0.002)
print(plc.pid, flush=True)
time.sleep(600)
"""


def test_a_plc_does_not_outlive_a_killed_runtime(tmp_path: Path) -> None:
    name = f"tandem-plc-{os.getpid()}-{next(_numbers)}"
    owner = subprocess.Popen([sys.executable, "-c", OWNER, name], stdout=subprocess.PIPE, text=True)
    assert owner.stdout is not None
    pid = int(owner.stdout.readline())
    owner.kill()
    owner.communicate()

    def gone() -> bool:
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
        except FileNotFoundError:
            return True
        return state == "Z"

    try:
        assert wait_for(gone)
    finally:
        HliMemory.create(name).close()  # takes the left-over away
