"""Real-time privileges: taken where the host gives them, one plain line each where it does not."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from runtime.diagnostics.catalogue import system
from runtime.diagnostics.errors import Reaction, Severity
from runtime.scheduler import realtime

# in a process of its own: what is asked for holds until the process ends
REPORT = """
import gc, json, os, resource, sys
from pathlib import Path
from runtime.scheduler.realtime import prepare_realtime
if sys.argv[2] == "nobody":
    resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
    resource.setrlimit(resource.RLIMIT_MEMLOCK, (65536, 65536))
    if os.geteuid() == 0:
        os.setgroups([]); os.setresgid(65534, 65534, 65534); os.setresuid(65534, 65534, 65534)
problems = prepare_realtime(42, int(sys.argv[1]))
status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
print(json.dumps({
    "ids": [problem.entry.id for problem in problems],
    "texts": [problem.explained() for problem in problems],
    "policy": os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK,
    "priority": os.sched_getparam(0).sched_priority,
    "locked": int(status["VmLck"].split()[0]),
    "cpus": sorted(os.sched_getaffinity(0)),
    "gc": gc.isenabled(), "frozen": gc.get_freeze_count(),
    "files": [os.readlink(entry) for entry in Path("/proc/self/fd").iterdir() if entry.exists()],
}))
"""


def report(cpu: int, who: str) -> dict[str, object]:
    command = [sys.executable, "-c", REPORT, str(cpu), who]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    result: dict[str, object] = json.loads(done.stdout)
    return result


def test_without_privileges_every_refusal_is_one_line_and_no_error() -> None:
    found = report(9999, "nobody")
    ids = found["ids"]
    assert isinstance(ids, list)
    assert {305010, 305011, 305012} <= set(ids) <= {305010, 305011, 305012, 305014}
    assert ids == [305012, *([305014] if 305014 in ids else []), 305011, 305010]
    texts = found["texts"]
    assert isinstance(texts, list)
    assert all(text.count("\n") == 1 and "hint: " in text for text in texts)
    assert (found["policy"], found["locked"]) == (os.SCHED_OTHER, 0)
    assert found["gc"] is False
    assert isinstance(found["frozen"], int)
    assert found["frozen"] > 1000


def test_what_is_not_refused_is_in_force() -> None:
    cpu = min(os.sched_getaffinity(0))
    found = report(cpu, "me")
    ids = found["ids"]
    assert isinstance(ids, list)
    assert found["cpus"] == [cpu]
    assert ids == sorted(set(ids), key=[305012, 305013, 305014, 305011, 305010].index)
    assert (found["policy"], found["priority"]) == ((os.SCHED_OTHER, 0) if 305010 in ids else (os.SCHED_FIFO, 42))
    assert (found["locked"] == 0) == (305011 in ids)
    files = found["files"]
    assert isinstance(files, list)
    assert ("/dev/cpu_dma_latency" not in files) == (305014 in ids)


def test_warnings_are_warnings() -> None:
    for entry in (
        system.NO_PRIORITY,
        system.NO_MEMORY_LOCK,
        system.NO_AFFINITY,
        system.NO_TIMER_SLACK,
        system.NO_CPU_LATENCY,
    ):
        assert (entry.severity, entry.reaction) == (Severity.WARNING, Reaction.NONE)


def test_the_latency_device_gets_zero_and_stays_open(tmp_path: Path) -> None:
    device = tmp_path / "latency"
    device.write_bytes(b"")
    realtime.forbid_deep_sleep(device)
    targets = {entry: os.path.realpath(f"/proc/self/fd/{entry}") for entry in os.listdir("/proc/self/fd")}
    (descriptor,) = [int(entry) for entry, target in targets.items() if target == str(device.resolve())]
    os.close(descriptor)
    assert device.read_bytes() == b"\0\0\0\0"
    with pytest.raises(realtime.RefusedError, match="No such file"):
        realtime.forbid_deep_sleep(tmp_path / "missing")
