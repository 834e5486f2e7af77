"""A host that has no memory for another process: the machine goes on, says so once, and starts it as soon as it can."""

from __future__ import annotations

import errno
import subprocess
from pathlib import Path
from typing import Any

import pytest

from runtime.config import load_machine
from runtime.diagnostics.catalogue import system as errors
from runtime.hli.memory import HliMemory
from runtime.scheduler.supervisor import RunOptions, Supervisor


class Kept:
    """A journal that keeps the ids of what is written."""

    def __init__(self) -> None:
        self.ids: list[object] = []

    def write(self, message: str, priority: int = 6, **fields: object) -> None:
        self.ids.append(fields.get("TANDEM_ERROR_ID"))


class Ended:
    """A process that has ended."""

    pid = 1
    returncode = 1

    def poll(self) -> int:
        return 1


def test_a_process_that_cannot_be_forked_is_started_later(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = load_machine(None).model_copy(update={"state_directory": tmp_path})
    journal, now, started = Kept(), [100.0], []
    service = Supervisor(machine, RunOptions(None, "tandem-test-fork"), journal)
    service.memory = HliMemory.private()
    platform = service.memory.hli.platform
    room = False

    def popen(command: list[str], **_options: Any) -> Any:
        if not room:
            raise OSError(errno.ENOMEM, "Cannot allocate memory")
        started.append(command[2])
        return Ended()

    monkeypatch.setattr(subprocess, "Popen", popen)
    monkeypatch.setattr("runtime.scheduler.supervisor.time.monotonic", lambda: now[0])
    service.preparation.process = Ended()  # type: ignore[assignment]
    platform.plc_restart_request_r = 1
    for _ in range(20):
        now[0] += 0.1
        service._watch_preparation()
        service._watch_plc()
    assert journal.ids == [errors.PROCESS_NOT_STARTED.id] * 2, "once for each process"
    assert platform.process_lost_w == 1, "the cycle was told once, and has stopped the path"
    room = True
    now[0] += 1.1
    service._watch_preparation()
    service._watch_plc()
    assert started == ["runtime.scheduler.preparation_process", "runtime.scheduler.plc_process"]
