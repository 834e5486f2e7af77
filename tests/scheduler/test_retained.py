"""Retained data: whole after a kill at any moment, the copy before it after damage."""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.scheduler.retained import (
    GREATEST_HISTORY,
    Retained,
    RetainedAlarm,
    RetainedError,
    RetainedStore,
    state_directory,
)

DATA = Retained(
    positions={"X": 12.345678901234567, "S": -0.1},
    zero_offsets={"mill": {"G54": {"X": 100.0, "Z": -3.5}}},
    alarms=(RetainedAlarm(1_700_000_000_000_000_000, 303010, 2, "Drive of axis X: fault", "X", 12),),
)


def test_what_is_saved_is_loaded(tmp_path: Path) -> None:
    store = RetainedStore(tmp_path / "made" / "when needed")
    assert store.load() == (Retained(), [])
    store.save(DATA)
    assert RetainedStore(store.directory).load() == (DATA, [])


@settings(max_examples=30, deadline=None)
@given(
    st.dictionaries(st.text(max_size=8), st.floats(allow_nan=False), max_size=4),
    st.lists(
        st.builds(RetainedAlarm, st.integers(0, 2**63), st.integers(0, 2**31), st.integers(0, 3), st.text(max_size=20))
    ),
)
def test_any_numbers_and_texts_come_back_unchanged(
    tmp_path_factory: pytest.TempPathFactory, positions: dict[str, float], alarms: list[RetainedAlarm]
) -> None:
    store = RetainedStore(tmp_path_factory.mktemp("state"))
    data = Retained(positions=positions, alarms=tuple(alarms))
    store.save(data)
    assert store.load() == (data, [])


def test_the_history_keeps_the_newest(tmp_path: Path) -> None:
    store = RetainedStore(tmp_path)
    store.save(Retained(alarms=tuple(RetainedAlarm(n, 1, 2, "") for n in range(GREATEST_HISTORY + 5))))
    alarms = store.load()[0].alarms
    assert (len(alarms), alarms[0].time_ns) == (GREATEST_HISTORY, 5)


def _wrong_number(text: str) -> str:
    content = json.loads(text)
    content["data"]["positions"]["X"] = 1.0
    return json.dumps(content)


def _other_schema(text: str) -> str:
    return json.dumps(json.loads(text) | {"schema": 999})


DAMAGES = {
    "empty": lambda text: "",
    "half": lambda text: text[: len(text) // 2],
    "number": _wrong_number,
    "schema": _other_schema,
    "no object": lambda text: "[]",
    "binary": lambda text: "\x00" * 100,
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES.keys())
def test_after_damage_the_copy_before_it_is_read_and_told(tmp_path: Path, damage: object) -> None:
    assert callable(damage)
    store = RetainedStore(tmp_path)
    store.save(DATA)
    newer = Retained(positions={"X": 99.0})
    store.save(newer)
    store.file.write_text(damage(store.file.read_text()))
    data, (problem,) = store.load()
    assert data == DATA
    assert problem.entry.id == 305020
    assert str(store.file) in problem.text
    # the next save keeps the damaged file for a look, and the whole copy in its place
    store.save(newer)
    assert store.load() == (newer, [])
    assert (tmp_path / "retained.json.broken").exists()
    store.file.write_text("")
    assert store.load()[0] == DATA


def test_damage_to_both_is_an_error_not_silence(tmp_path: Path) -> None:
    store = RetainedStore(tmp_path)
    for _ in range(2):
        store.save(DATA)
    store.file.write_text("")
    store.previous.write_text("")
    data, (problem,) = store.load()
    assert (data, problem.entry.id) == (Retained(), 305021)


def test_a_missing_file_with_a_copy_is_told(tmp_path: Path) -> None:
    store = RetainedStore(tmp_path)
    for _ in range(2):
        store.save(DATA)
    store.file.unlink()
    data, (problem,) = store.load()
    assert (data, problem.entry.id) == (DATA, 305020)


def test_a_directory_that_cannot_be_written_is_an_error_of_the_catalogue(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(RetainedError) as caught:
        RetainedStore(tmp_path / "file").save(DATA)
    assert caught.value.problem.entry.id == 305022


def test_where_the_state_lives() -> None:
    assert state_directory(Path("/a"), {"STATE_DIRECTORY": "/b"}) == Path("/a")
    assert state_directory(None, {"STATE_DIRECTORY": "/b:/c", "HOME": "/h"}) == Path("/b")
    assert state_directory(None, {"HOME": "/h"}) == Path("/h/.local/state/tandem")
    assert state_directory(None, {"HOME": "/h", "XDG_STATE_HOME": "/s"}) == Path("/s/tandem")


WRITER = """
import sys
from pathlib import Path
from runtime.scheduler.retained import Retained, RetainedStore
store = RetainedStore(Path(sys.argv[1]))
n = int(store.load()[0].positions.get("X", 0))
print("begun", flush=True)
while True:
    n += 1
    store.save(Retained(positions={name: float(n) for name in ("X", "Y", "Z")}))
    print(n, flush=True)
"""


def test_a_writer_killed_at_any_moment_leaves_whole_and_newest_data(tmp_path: Path) -> None:
    """24 kills at random moments: what is read is whole, told by no warning, and the last save that finished."""
    moments = random.Random(7)
    last = 0
    for _ in range(24):
        command = [sys.executable, "-c", WRITER, str(tmp_path)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == "begun\n"
            begun = [int(process.stdout.readline()) for _ in range(moments.randint(0, 3))]
            time.sleep(moments.uniform(0.0, 0.03))
            process.kill()
            finished = begun + [int(line) for line in process.stdout.read().split("\n")[:-1]]
        data, problems = RetainedStore(tmp_path).load()
        assert problems == []
        n = int(data.positions.get("X", 0))
        assert dict(data.positions) == ({"X": n, "Y": n, "Z": n} if n else {})
        assert max([last, *finished]) <= n <= max([last, *finished]) + 1
        last = n
    assert last > 24


def test_a_kill_between_any_two_system_calls_loses_nothing(tmp_path: Path) -> None:
    """The same, exhaustively: the writer ends before its k-th system call on files, for every k."""
    code = """
import os, sys
from pathlib import Path
from runtime.scheduler import retained
store = retained.RetainedStore(Path(sys.argv[1])); count = [int(sys.argv[2])]
def ending(call):
    def wrapped(*args, **kwargs):
        if count[0] == 0: os._exit(9)
        count[0] -= 1
        return call(*args, **kwargs)
    return wrapped
for name in ("open", "fsync", "replace", "link", "close"):
    setattr(os, name, ending(getattr(os, name)))
store.save(retained.Retained(positions={"X": float(sys.argv[3])}))
os._exit(0)
"""
    RetainedStore(tmp_path).save(Retained(positions={"X": 0.0}))
    old, kills = 0.0, 0
    for k in range(40):
        new = float(k + 1)
        done = subprocess.run([sys.executable, "-c", code, str(tmp_path), str(k), str(new)], check=False)
        data, problems = RetainedStore(tmp_path).load()
        assert problems == []
        assert data.positions["X"] in (old, new)
        old = data.positions["X"]
        if done.returncode == 0:
            assert old == new
            break
        assert done.returncode == 9
        kills += 1
    assert kills >= 6
    assert not os.path.exists(tmp_path / "retained.json.broken")
