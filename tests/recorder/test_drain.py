"""From the ring to the disk: segments, what is saved at an alarm, and a disk that does not take it."""

from __future__ import annotations

import resource
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from runtime.diagnostics.catalogue import recorder as errors
from runtime.diagnostics.errors import Problem
from runtime.recorder.drain import Drain
from runtime.recorder.file import RecordingError, RecordingFile
from runtime.recorder.record import GAP, KEYFRAME
from runtime.recorder.ring import RecorderRing
from runtime.recorder.store import Segments, runs, save

Words = npt.NDArray[np.int64]
NOISE = np.random.default_rng(1)


def record(cycle: int, marks: int = 0, words: int = 400) -> Words:
    made = NOISE.integers(0, 1 << 60, words)  # cannot be packed
    made[:5] = words, cycle, np.float64(cycle * 0.001).view(np.int64), 0, marks
    made[5] = 99 << 32 | (words - 6)
    return made


def cycles(path: Path) -> list[int]:
    with RecordingFile(path) as file:
        return [found.cycle for found in file.records()]


class Rig:
    """A ring, a drain without its thread, and a clock."""

    def __init__(self, folder: Path, size: int = 1_000_000, seconds: float = 1000.0) -> None:
        self.ring = RecorderRing(size=400_000)
        self.folder = folder / "recorder"
        self.now = 0.0
        self.told: list[Problem] = []
        self.segments = Segments(self.folder, 7, {"version": "x"}, size, seconds)
        self.drain = Drain(
            self.ring, self.segments, self.told.append, period=0.001, keyframe_every=30.0, kept=2, now=lambda: self.now
        )
        self.cycle = 0

    def put(self, count: int, marks: int = 0) -> None:
        for k in range(count):
            self.cycle += 1
            self.ring.put(record(self.cycle, marks if k == 0 else 0))

    def step(self, seconds: float = 0.25) -> None:
        self.now += seconds
        self.drain.step()

    @property
    def entries(self) -> list[int]:
        return [problem.entry.id for problem in self.told]


def test_the_oldest_segments_give_way_and_the_newest_are_whole(tmp_path: Path) -> None:
    rig = Rig(tmp_path, size=300_000)
    for _ in range(10):
        rig.put(20, KEYFRAME)  # 64 kB
        rig.step()
    segments = runs(rig.folder)[7]
    assert sum(path.stat().st_size for path in segments) <= 300_000
    assert 2 <= len(segments) < 10
    kept = [cycle for path in segments for cycle in cycles(path)]
    assert kept == list(range(kept[0], 201))
    assert kept[0] % 20 == 1
    save(segments, tmp_path / "whole")
    assert cycles(tmp_path / "whole") == kept


def test_segments_older_than_wanted_go(tmp_path: Path) -> None:
    rig = Rig(tmp_path, seconds=0.05)
    for _ in range(10):
        rig.put(20, KEYFRAME)
        rig.step()
    kept = [cycle for path in runs(rig.folder)[7] for cycle in cycles(path)]
    assert 50 <= len(kept) <= 90


def test_an_alarm_is_saved_with_what_comes_behind_it_and_a_storm_is_saved_once(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    rig.put(30, KEYFRAME)
    rig.step()
    for _ in range(100):
        rig.drain.alarm(306001)
    rig.put(30)
    rig.step(1.0)
    assert not list(rig.folder.glob("*.tandem"))
    rig.step(1.5)
    (saved,) = rig.folder.glob("alarm-306001-*.tandem")
    assert cycles(saved) == list(range(1, 61))
    assert rig.entries == [errors.SAVED.id]
    rig.drain.alarm(306001)
    rig.step(5.0)
    assert rig.drain.figures.saved == 1


def test_a_full_ring_drops_marks_the_gap_and_asks_for_nothing_of_the_cycle(tmp_path: Path) -> None:
    rig = Rig(tmp_path)
    rig.put(200)
    assert rig.ring.dropped == 200 - rig.ring.records
    rig.step()
    rig.put(1, GAP)
    rig.step()
    assert rig.drain.figures.dropped == rig.ring.dropped > 0


def test_a_full_disk_costs_the_recording_only_is_told_once_and_ends(tmp_path: Path) -> None:
    """Real: the kernel refuses to let the files grow (RLIMIT_FSIZE), as a full disk or a quota does."""
    rig = Rig(tmp_path)
    rig.put(20, KEYFRAME)
    rig.step()
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, before[1]))
    try:
        for _ in range(8):
            rig.put(20)
            rig.step()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert rig.entries == [errors.NOT_WRITTEN.id]
    assert not rig.ring.waiting, "the ring is emptied all the same"
    assert rig.drain.figures.lost >= 100
    assert not rig.drain.figures.writing
    whole = [cycle for path in runs(rig.folder)[7] for cycle in cycles(path)]
    assert whole == list(range(1, len(whole) + 1)), "what was written before is whole"
    rig.put(20)  # there is room again, but nothing that could be replayed before the next keyframe
    rig.step(6.0)
    assert rig.ring.take_wish()
    rig.put(20, KEYFRAME)
    rig.step()
    assert rig.entries == [errors.NOT_WRITTEN.id, errors.WRITES_AGAIN.id]
    assert rig.drain.figures.writing
    assert cycles(runs(rig.folder)[7][-1])[-1] == rig.cycle


def test_a_folder_that_cannot_be_made_is_told(tmp_path: Path) -> None:
    (tmp_path / "recorder").write_text("a file stands in the way")
    rig = Rig(tmp_path)
    rig.put(20, KEYFRAME)
    rig.step()
    assert rig.entries == [errors.NOT_WRITTEN.id]
    assert not rig.ring.waiting


def test_nothing_recorded_cannot_be_saved(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="no recording in"):
        save([], tmp_path / "x")
    assert not list(tmp_path.iterdir())
