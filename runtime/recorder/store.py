"""The recorder's folder: segments, each a recording by itself, of which the oldest give way; and what was saved from them.

    <state>/recorder/
      run-1764150000-000001.rec     begins with a keyframe; a new one with every keyframe
      run-1764150000-000002.rec
      alarm-306001-20261126T095012.tandem     saved by itself at an alarm

The segments of earlier runs stay until the room is needed: that of a run that has ended badly can still be saved.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from runtime.diagnostics.catalogue import recorder as errors
from runtime.diagnostics.errors import Place
from runtime.recorder.file import Chunk, RecordingError, RecordingFile, header_bytes
from runtime.recorder.record import KEYFRAME

Words = npt.NDArray[np.int64]
FOLDER = "recorder"
_SEGMENT = re.compile(r"run-(\d+)-(\d{6})\.rec\Z")
_SAVED = "*.tandem"


def runs(folder: Path) -> dict[int, list[Path]]:
    """The runs that are recorded there, oldest first: start (s since 1970) -> segments in their order."""
    found: dict[int, list[Path]] = {}
    with suppress(OSError):
        for path in sorted(folder.iterdir()):
            if match := _SEGMENT.match(path.name):
                found.setdefault(int(match[1]), []).append(path)
    return dict(sorted(found.items()))


def save(segments: Sequence[Path], target: Path) -> tuple[int, int]:
    """Join segments of one run into a recording; its first and last cycle. Raises RecordingError, OSError.

    A segment that gave way meanwhile is left out. The file gets its name when it is whole.
    """
    first = last = -1
    new = target.with_name(target.name + ".new")
    try:
        with _private(new) as out:
            for segment in segments:
                try:
                    with RecordingFile(segment) as file:
                        if first < 0:
                            out.write(header_bytes(file.header))
                        for chunk in file.chunks():
                            out.write(chunk.to_bytes())
                            first, last = (chunk.first if first < 0 else first), chunk.last
                except FileNotFoundError:
                    continue
            out.flush()
            os.fsync(out.fileno())
        if first < 0:
            raise RecordingError(errors.NOT_RECORDED, Place(str(target)), folder=target.parent)
        new.replace(target)
    finally:
        with suppress(OSError):
            new.unlink()
    return first, last


class Segments:
    """Writes the segments of one run; at most `size` bytes of all runs and `seconds` of this one. Raises OSError."""

    def __init__(self, folder: Path, run: int, header: Mapping[str, Any], size: int, seconds: float) -> None:
        self.folder = folder
        self._run, self._size, self._seconds = run, size, seconds
        self._header = header_bytes({**header, "run": run})
        self._file: IO[bytes] | None = None
        self._number = 0
        self._begins: dict[Path, float] = {}  # s since the start of the runtime
        self.bytes = 0  # of all segments
        self.full = False  # there is no keyframe behind which something could go on

    @property
    def current(self) -> list[Path]:
        """The segments of this run, oldest first."""
        return list(self._begins)

    @property
    def open(self) -> bool:
        """A segment is being written."""
        return self._file is not None

    def add(self, words: Words) -> None:
        """Whole records, oldest first; a keyframe begins a new segment."""
        for keyframe, part in _at_keyframes(words):
            if keyframe:
                self._begin(float(part[2:3].view(np.float64)[0]))
            if self._file is None:
                continue  # behind a failure: the next keyframe goes on
            data = Chunk.of(part).to_bytes()
            if self.bytes + len(data) > self._size and not self._give_way(1, room=len(data)):
                self.full = True
                self.close()
                continue
            self._file.write(data)
            self._file.flush()
            self.bytes += len(data)

    def _begin(self, time: float) -> None:
        self.close()
        self.folder.mkdir(parents=True, exist_ok=True)
        self._number += 1
        path = self.folder / f"run-{self._run}-{self._number:06}.rec"
        self._give_way(0, time)
        self._file = _private(path)
        self._begins[path] = time
        self._file.write(self._header)
        self.bytes += len(self._header)
        self.full = False

    def _give_way(self, kept: int, time: float = 0.0, room: int = 0) -> bool:
        """Remove what is oldest until there is `room` bytes and some more; whether there is. `kept` of the newest stay."""
        others = [path for run, paths in runs(self.folder).items() if run != self._run for path in paths]
        mine = list(self._begins)
        sizes = {path: _size(path) for path in (*others, *mine)}
        self.bytes = sum(sizes.values())
        wanted = min(self._size * 9 // 10, self._size - room)
        for path in (*others, *mine[: len(mine) - kept]):
            index = mine.index(path) if path in self._begins else -1
            over = index >= 0 and index + 1 < len(mine) and self._begins[mine[index + 1]] < time - self._seconds
            if self.bytes <= wanted and not over:
                continue
            with suppress(FileNotFoundError):
                path.unlink()
            self.bytes -= sizes[path]
            self._begins.pop(path, None)
        return self.bytes <= wanted

    def fail(self) -> None:
        """Writing has failed: nothing more goes into this segment."""
        with suppress(OSError):
            self.close()

    def close(self) -> None:
        file, self._file = self._file, None
        if file is not None:
            file.close()

    def forget_saved(self, kept: int) -> None:
        """Of what was saved by itself at alarms, the newest stay."""
        saved = sorted(self.folder.glob(_SAVED), key=lambda path: path.stat().st_mtime)
        for path in saved[: len(saved) - kept]:
            path.unlink(missing_ok=True)


def _private(path: Path) -> IO[bytes]:
    """A new file that others than the group cannot read: it tells what the machine makes."""
    return os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o640), "wb")


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0


def _at_keyframes(words: Words) -> Iterator[tuple[bool, Words]]:
    """Runs of records, each but the first beginning with a keyframe."""
    begin = at = 0
    keyframe = False
    while at < len(words):
        if int(words[at + 4]) & KEYFRAME:
            if at > begin:
                yield keyframe, words[begin:at]
            begin, keyframe = at, True
        at += int(words[at])
    if at > begin:
        yield keyframe, words[begin:at]
