"""Writes what must survive as fast as the disk takes it, and tells outside of the machine what it was promised.

A number counts up in each of the three stores; when a store says that the number is on the disk, and only then, it goes into a
file of the host. After the power was lost no store may have less than what the host was told.

python -m tests.vm.guest.writers FOLDER PROMISES         until it is killed
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from typing import Final

from runtime.cnc.tools.table import SqliteTools
from runtime.cnc.tools.tool import Tool
from runtime.plc_logic.retained_variables import RetainJournal, read_journal
from runtime.scheduler.retained import Retained, RetainedAlarm, RetainedStore

STORES: Final = ("machine", "plc", "tools")
WIDTH: Final = 20  # digits of a promise


def read(folder: Path) -> dict[str, int]:
    """The number in each store, 0 for an empty one; raises whatever a damaged store raises."""
    retained, _ = RetainedStore(folder / "machine").load()
    _, values, _ = read_journal(folder / "plc")
    tool = SqliteTools(folder / "tools.db").get(1)
    return {
        "machine": round(retained.positions.get("X", 0.0)),
        "plc": int(values.get("n", 0)),
        "tools": round(tool.length) if tool is not None else 0,
    }


def whole(folder: Path) -> list[str]:
    """What is wrong in the stores, apart from the number: nothing may be half-written."""
    retained, problems = RetainedStore(folder / "machine").load()
    wrong = [str(problem) for problem in problems]
    n = round(retained.positions.get("X", 0.0))
    if any(round(value) != n for value in retained.positions.values()) or any(a.line != n for a in retained.alarms):
        wrong.append(f"machine: parts of several writings: {retained}")
    _, values, _ = read_journal(folder / "plc")
    if values and values["copy"] != [values["n"]] * 50:
        wrong.append(f"plc: parts of several cycles: {values}")
    tool = SqliteTools(folder / "tools.db").get(1)
    if tool is not None and tool.radius != tool.length:
        wrong.append(f"tools: parts of several writings: {tool}")
    return wrong


def main() -> int:
    folder, promises = Path(sys.argv[1]), Path(sys.argv[2])
    told = {store: os.open(promises / f"promised-{store}", os.O_WRONLY) for store in STORES}
    begin = max(read(folder).values()) if folder.exists() else 0
    folder.mkdir(exist_ok=True)
    machine, tools = RetainedStore(folder / "machine"), SqliteTools(folder / "tools.db")
    journal = RetainJournal(folder / "plc")
    n = begin
    while True:
        n += 1
        alarms = tuple(RetainedAlarm(n, n, 1, "x" * 60, "X", n) for _ in range(200))
        journal.commit({"n": n, "copy": [n] * 50})
        machine.save(Retained({axis: float(n) for axis in "XYZABC"}, {}, alarms))
        _promise(told["machine"], n)
        tools.put(Tool(1, length=float(n), radius=float(n)))
        _promise(told["tools"], n)
        while not journal.saved:
            time.sleep(0.001)
        _promise(told["plc"], n)


def _promise(descriptor: int, n: int) -> None:
    """In one write: the host sees the old number or the new one."""
    os.pwrite(descriptor, b"%0*d" % (WIDTH, n), 0)


if __name__ == "__main__":
    sys.exit(main())
