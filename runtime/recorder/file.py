"""Recordings on the disk: a header, and chunks of whole records, each packed and with a checksum.

    | TANDEM RECORDING 2 | header: length, JSON | chunk | chunk | …
    chunk:  | mark, marks, packed bytes, checksum, first cycle, last cycle | packed records |

What was written last may be cut off (killed, power lost, disk full): the whole chunks before it can be read.
"""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from runtime.diagnostics.catalogue import recorder as errors
from runtime.diagnostics.errors import Place, TandemError
from runtime.recorder.record import CycleRecord, records_of

Words = npt.NDArray[np.int64]
MAGIC = b"TANDEM RECORDING 2\n"
CHUNK = struct.Struct("<4sIIIqq")
_MARK = b"CHNK"
_LENGTH = struct.Struct("<I")
_GREATEST = 1 << 30  # bytes of a header or a chunk
_LEVEL = 1  # of the compression: a third of the bytes at some 100 MB/s


class RecordingError(TandemError):
    """A recording that cannot be read, written or replayed."""


@dataclass(frozen=True, slots=True)
class Chunk:
    """Whole records, packed; `marks` are those of all of them together."""

    marks: int
    first: int  # cycle
    last: int
    data: bytes

    @classmethod
    def of(cls, words: Words) -> Chunk:
        """Pack whole records; at least one."""
        marks, at, last = 0, 0, int(words[1])
        while at < len(words):
            marks |= int(words[at + 4])
            last = int(words[at + 1])
            at += int(words[at])
        return cls(marks, int(words[1]), last, zlib.compress(words.tobytes(), _LEVEL))

    def words(self) -> Words:
        """Unpacked."""
        return np.frombuffer(zlib.decompress(self.data), dtype=np.int64)

    def to_bytes(self) -> bytes:
        """As it stands in a file."""
        head = CHUNK.pack(_MARK, self.marks, len(self.data), zlib.crc32(self.data), self.first, self.last)
        return head + self.data


def header_bytes(header: Mapping[str, Any]) -> bytes:
    """The beginning of a file."""
    text = json.dumps(header).encode()
    return MAGIC + _LENGTH.pack(len(text)) + text


class RecordingFile:
    """A recording to be read; use it with `with`. Raises RecordingError if it is none, OSError if it cannot be read."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file: IO[bytes] = path.open("rb")
        if self._file.read(len(MAGIC)) != MAGIC:
            raise self._refused("it does not begin as one of this version does")
        try:
            (length,) = _LENGTH.unpack(self._file.read(_LENGTH.size))
            self.header: dict[str, Any] = json.loads(self._file.read(min(length, _GREATEST)))
        except (ValueError, struct.error):
            raise self._refused("its header is damaged") from None
        self._begin = self._file.tell()

    def _refused(self, reason: str) -> RecordingError:
        self._file.close()
        return RecordingError(errors.NOT_A_RECORDING, Place(str(self.path)), file=self.path, reason=reason)

    def chunks(self) -> Iterator[Chunk]:
        """Up to the end, or to where the file is damaged or cut off."""
        self._file.seek(self._begin)
        while len(head := self._file.read(CHUNK.size)) == CHUNK.size:
            mark, marks, packed, checksum, first, last = CHUNK.unpack(head)
            if mark != _MARK or packed > _GREATEST:
                return
            data = self._file.read(packed)
            if len(data) < packed or zlib.crc32(data) != checksum:
                return
            yield Chunk(marks, first, last, data)

    def records(self) -> Iterator[CycleRecord]:
        """Every record."""
        for chunk in self.chunks():
            yield from records_of(chunk.words())

    def close(self) -> None:
        self._file.close()

    def __enter__(self) -> RecordingFile:
        return self

    def __exit__(self, *_exception: object) -> None:
        self.close()


class RecordingWriter:
    """Writes a recording into one file, as records come. Raises OSError."""

    def __init__(self, path: Path, header: Mapping[str, Any]) -> None:
        self._file: IO[bytes] = path.open("wb")
        self._file.write(header_bytes(header))

    def add(self, words: Words) -> None:
        """Whole records."""
        if len(words):
            self._file.write(Chunk.of(words).to_bytes())

    def close(self) -> None:
        self._file.close()
