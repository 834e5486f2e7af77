"""A disk that is full: retained data, tools and logs stay whole, say so, and work again when there is room.

The limit is the kernel's (RLIMIT_FSIZE): writing beyond it is refused in the middle, as on a full disk.
"""

from __future__ import annotations

import errno
import os
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from runtime.cnc.tools.table import SqliteTools, ToolTableError
from runtime.cnc.tools.tool import Tool
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import system
from runtime.hli.alarms import alarm_lines
from runtime.scheduler.journal import LineJournal, NativeJournal
from runtime.scheduler.keeping import Keeper
from runtime.scheduler.retained import Retained, RetainedAlarm, RetainedError, RetainedStore
from runtime.scheduler.simulation import Simulation
from tests.machine.conftest import demo

__all__ = ["demo"]


@contextmanager
def full_disk(room: int) -> Iterator[None]:
    """No file grows beyond `room` bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (room, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_retained_data_stays_what_it_was_and_is_written_when_there_is_room(tmp_path: Path) -> None:
    store = RetainedStore(tmp_path / "state")
    small = Retained({"X": 1.25})
    large = Retained({"X": 2.5}, alarms=tuple(RetainedAlarm(k, 306001, 2, "drive") for k in range(500)))
    store.save(small)
    with full_disk(4096):
        for _ in range(3):
            with pytest.raises(RetainedError) as caught:
                store.save(large)
            assert caught.value.problem.entry is system.RETAINED_NOT_WRITTEN
            assert "too large" in caught.value.problem.text, "the kernel's own reason"
            assert store.load() == (small, [])
    store.save(large)
    assert store.load() == (large, [])


def _alarms(simulation: Simulation) -> list[tuple[str, bool]]:
    lines = alarm_lines(simulation.memory.hli)
    return [(line.text, line.active) for line in lines if line.id == system.RETAINED_NOT_WRITTEN.id]


def test_retained_data_that_cannot_be_written_is_an_alarm_until_it_is_written(demo: Machine, tmp_path: Path) -> None:
    """It moves nobody; a reset does not hide it; what the operator has to do stands in it."""
    simulation = Simulation(demo, ideal_axes=True)
    assert simulation.run_until(simulation.ready, 20.0)
    folder = tmp_path / "state"
    keeper = Keeper(demo, RetainedStore(folder))
    keeper.keep(simulation.memory.hli)

    def passes() -> list[tuple[str, bool]]:
        keeper.keep(simulation.memory.hli)
        for _ in range(70):
            simulation.cycle()
        return _alarms(simulation)

    with full_disk(200):
        simulation.memory.hli.axes[0].status.actual_position_r += 10_000  # something has changed
        found = passes()
        assert len(found) == 1
        text, active = found[0]
        assert active
        assert "too large; make room on this disk" in text
        assert passes() == found, "told once"
        assert simulation.controller.channel.error is None
        simulation.memory.hli.operator[0].reset_rw = True
        assert [active for _, active in passes()] == [True, False], "still so: told again, newest first"
    assert [active for _, active in passes()] == [False, False]


@pytest.mark.parametrize(
    ("number", "advice"),
    [
        (errno.ENOSPC, "make room"),
        (errno.EROFS, "mount this disk"),
        (errno.EACCES, "to the user of the runtime"),
        (errno.EIO, "look after the disk"),
    ],
)
def test_the_alarm_says_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, advice: str) -> None:
    def refuse(*_: object) -> int:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "open", refuse)
    with pytest.raises(RetainedError) as caught:
        RetainedStore(tmp_path).save(Retained())
    assert f"{os.strerror(number)}; " in caught.value.problem.text
    assert advice in caught.value.problem.text


def test_the_tool_table_stays_whole_and_can_be_written_again(tmp_path: Path) -> None:
    table = SqliteTools(tmp_path / "tools.db")
    table.put(Tool(1, radius=3.0))
    size = table.path.stat().st_size
    with full_disk(size):
        for _ in range(3):
            with pytest.raises(ToolTableError, match=r"disk I/O error|full"):
                table.put(*(Tool(number, radius=5.0) for number in range(1, 500)))
            assert [(tool.number, tool.radius) for tool in table.all()] == [(1, 3.0)]
    table.put(Tool(1, radius=4.0), Tool(2, radius=5.0))
    assert [(tool.number, tool.radius) for tool in table.all()] == [(1, 4.0), (2, 5.0)]
    table.close()


def test_logs_that_cannot_be_written_stop_nobody(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = tmp_path / "log"
    with log.open("w") as stream:
        journal = LineJournal(stream, verbose=True)
        journal.write("before")
        with full_disk(log.stat().st_size + 20):
            for _ in range(50):
                journal.write("a line that finds no room")
            monkeypatch.setattr("sys.stderr", stream)
            for _ in range(5):
                NativeJournal(tmp_path / "nobody").write("no journal, and stderr is full")
        journal.write("behind")
    text = log.read_text()
    assert text.startswith("info: before\n")
    assert text.endswith("info: behind\n")
