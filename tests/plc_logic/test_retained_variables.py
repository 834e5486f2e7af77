"""Retained variables: whatever moment the process or the power goes, the last whole record is what counts.

`TANDEM_KILLS=2000 pytest tests/plc_logic/test_retained_variables.py` kills more often.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from runtime.plc_logic import PlcError, Program, retain, retained_variables
from runtime.plc_logic.retained_variables import PREFIX, RetainJournal, read_journal, starting_values

KILLS = int(os.environ.get("TANDEM_KILLS", "40"))

# A parent that forks a counting child, kills it at a random moment, and reads what is left: again and again.
KILLER = """
import os, random, signal, sys, time
from pathlib import Path

from runtime.plc_logic import retained_variables as module
from runtime.plc_logic.retained_variables import RetainJournal, read_journal

directory, kills = Path(sys.argv[1]), int(sys.argv[2])
module.GREATEST_JOURNAL = 50_000  # many journals
chance = random.Random(7)
count = 0
for attempt in range(kills):
    here, there = os.pipe()
    child = os.fork()
    if child == 0:
        journal = RetainJournal(directory)
        n = journal.kept.get("n", 0)
        while True:
            n += 1
            journal.commit({"n": n, "twice": 2 * n, "list": [n] * (n % 50), "text": "x" * (n % 300)})
            os.write(there, n.to_bytes(8, "little"))  # the cycle goes on: outputs, acknowledgements
    os.close(there)
    told = count
    if attempt % 2:  # every other child gets as far as its first record, on however busy a machine
        told = int.from_bytes(os.read(here, 8), "little")
    time.sleep(chance.uniform(0.002, 0.03))
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    while data := os.read(here, 8 * 1024):
        told = int.from_bytes(data[-8:], "little")
    os.close(here)
    _, kept, torn = read_journal(directory)
    count = kept.get("n", 0)
    assert told <= count <= told + 1, (attempt, told, count)
    if count:
        assert kept["twice"] == 2 * count, kept
        assert kept["list"] == [count] * (count % 50), kept
        assert len(kept["text"]) == count % 300, kept
    assert len(list(directory.iterdir())) < 100
print(count)
"""


def test_a_process_killed_at_any_moment_loses_nothing(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", KILLER, str(tmp_path), str(KILLS)], capture_output=True, text=True, timeout=60 + KILLS
    )
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) >= KILLS // 2, "it has counted between the kills"


@given(cut=st.integers(0, 2000), noise=st.binary(max_size=40))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40)
def test_whatever_a_power_loss_leaves_of_the_end_the_rest_counts(
    tmp_path_factory: pytest.TempPathFactory, cut: int, noise: bytes
) -> None:
    """What was not yet on the disk may be missing or be anything; what was before it is there, never half of a record."""
    directory = tmp_path_factory.mktemp("retain")
    journal = RetainJournal(directory)
    sizes = [_newest(directory).stat().st_size]
    for n in range(1, 12):
        journal.commit({"n": n, "twice": 2 * n})
        sizes.append(_newest(directory).stat().st_size)
    journal.close()
    file = _newest(directory)
    whole = file.read_bytes()
    cut = min(cut, len(whole))
    file.write_bytes(whole[:cut] + noise)
    _, kept, _ = read_journal(directory)
    whole_records = sum(size <= cut for size in sizes)
    if whole[: cut + len(noise)] != whole[:cut] + noise:  # not by chance the same bytes
        assert kept == ({} if whole_records < 2 else {"n": whole_records - 1, "twice": 2 * (whole_records - 1)})
    again = RetainJournal(directory)  # and it goes on from there
    again.commit({"n": 100})
    again.close()
    assert read_journal(directory)[1]["n"] == 100


def _newest(directory: Path) -> Path:
    return max(directory.glob(f"{PREFIX}*"), key=lambda file: int(file.suffix[1:]))


def test_a_journal_that_was_begun_and_lost_falls_back_to_the_one_before(tmp_path: Path) -> None:
    journal = RetainJournal(tmp_path)
    journal.commit({"n": 5})
    journal.close()
    RetainJournal(tmp_path).close()
    _newest(tmp_path).write_bytes(b"")
    number, kept, torn = read_journal(tmp_path)
    assert (kept, torn) == ({"n": 5}, _newest(tmp_path))
    again = RetainJournal(tmp_path)
    assert again.kept == {"n": 5}
    assert [problem.entry.id for problem in again.problems] == [304064]
    again.close()
    assert read_journal(tmp_path)[0] == number + 1


def test_old_journals_go_away_and_the_values_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(retained_variables, "GREATEST_JOURNAL", 500)
    journal = RetainJournal(tmp_path)
    for n in range(200):
        journal.commit({"n": n, "kept": "always"})
    journal.close()
    assert journal.saved
    assert read_journal(tmp_path)[1] == {"n": 199, "kept": "always"}


def test_nothing_changed_writes_nothing(tmp_path: Path) -> None:
    journal = RetainJournal(tmp_path)
    values = {"n": 1, "list": [1, 2]}
    journal.commit(values)
    size = _newest(tmp_path).stat().st_size
    journal.commit(values)
    assert _newest(tmp_path).stat().st_size == size
    values["list"].append(3)  # type: ignore[attr-defined]
    journal.commit(values)
    journal.close()
    assert read_journal(tmp_path)[1]["list"] == [1, 2, 3]


def test_a_disk_that_takes_nothing_is_told_and_tried_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    journal = RetainJournal(tmp_path)
    with monkeypatch.context() as broken:
        broken.setattr(os, "write", lambda *_: 3)
        journal.commit({"n": 1})
    assert [problem.entry.id for problem in journal.problems] == [304065]
    for _ in range(1000):
        journal.commit({"n": 1})
    journal.close()
    assert read_journal(tmp_path)[1] == {"n": 1}


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(PlcError, match="304065"):
        RetainJournal(tmp_path / "file" / "below")


class Counting(Program):
    parts = retain(0)
    share = retain(0.5)
    names = retain(["a"])


class Later(Counting):
    on = retain(False)


def test_variables_begin_with_what_was_kept_if_it_still_fits() -> None:
    assert starting_values(Later, {}) == ({"parts": 0, "share": 0.5, "names": ["a"], "on": False}, [])
    values, problems = starting_values(Later, {"parts": 7, "share": 2, "names": "b", "on": 1, "gone": 3})
    assert values == {"parts": 7, "share": 2, "names": ["a"], "on": False}
    assert [problem.values["name"] for problem in problems] == ["names", "on"]


@pytest.mark.parametrize("value", [True, 1.5, "1", None, [1]])
def test_a_value_of_another_kind_is_refused(value: object) -> None:
    program = Counting()
    vars(program)["_retained"] = {}
    with pytest.raises(PlcError, match="retained variable parts of kind int"):
        program.parts = value  # type: ignore[assignment]
    with pytest.raises(PlcError):
        program.names = [object()]  # type: ignore[list-item]


def test_the_declaration_is_seen_at_the_class() -> None:
    assert isinstance(Counting.parts, retain)
    assert Counting.parts.initial == 0
