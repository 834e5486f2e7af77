"""The text of a program file, read in windows: a program of any length takes the same small memory.

Windows are read with `pread` and not mapped into memory: if somebody shortens the file while it runs, a mapping kills
the process with SIGBUS; here it is an error with an id.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import numpy.typing as npt

from runtime.cnc.language.errors import ProgramError
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import Place

Bytes = npt.NDArray[np.uint8]

WINDOW = 1 << 20  # bytes; some 30 000 plain blocks
MAX_BLOCK = 4000  # characters per block, comments included (programming manual line 1121)
_PROBE = 8192  # bytes that are looked at for signs of a binary file
_BOM = b"\xef\xbb\xbf"  # what some editors write in front of UTF-8 text


class ProgramText:
    """An open program file. Offsets count bytes from the start of the file."""

    def __init__(self, path: Path, name: str | None = None) -> None:
        """Open `path`; ProgramError if it is missing, unreadable, empty or no text. `name` is what errors call it."""
        self.path = path
        self.name = name or str(path)
        place = Place(file=self.name)
        try:
            self._file = path.open("rb", buffering=0)
            status = os.fstat(self._file.fileno())
            probe = os.pread(self._file.fileno(), _PROBE, 0)
        except FileNotFoundError:
            raise ProgramError(catalogue.FILE_MISSING, place, file=self.name) from None
        except OSError as error:
            raise ProgramError(catalogue.FILE_UNREADABLE, place, file=self.name, reason=error.strerror) from None
        self.size = status.st_size
        self._modified = status.st_mtime_ns
        if not probe:
            raise ProgramError(catalogue.FILE_EMPTY, place, file=self.name)
        for offset, byte in enumerate(probe):
            if byte < 32 and byte not in b"\t\n\v\f\r\x03\x1a":
                raise ProgramError(catalogue.FILE_BINARY, place, file=self.name, byte=byte, offset=offset)
        self.start = len(_BOM) if probe.startswith(_BOM) else 0

    def close(self) -> None:
        """Give the file back; the text cannot be read any more."""
        self._file.close()

    def window(self, offset: int, size: int = WINDOW) -> Bytes:
        """Up to `size` bytes from `offset` on; shorter only at the end of the file."""
        return np.frombuffer(self._read(offset, size), dtype=np.uint8)

    def line(self, offset: int) -> tuple[str, int]:
        """The line at `offset` without its end, and the offset of the next one.

        A line longer than a block may be is cut behind MAX_BLOCK + 1 characters, so that the caller can tell.
        """
        data = self._read(offset, MAX_BLOCK + 2)
        end = data.find(b"\n")
        if end >= 0:
            return data[:end].rstrip(b"\r").decode("latin-1"), offset + end + 1
        following = offset + len(data)
        while following < self.size:
            more = self._read(following, WINDOW)
            end = more.find(b"\n")
            if end >= 0:
                following += end + 1
                break
            following += len(more)
        return data.rstrip(b"\r").decode("latin-1")[: MAX_BLOCK + 1], following

    def _read(self, offset: int, size: int) -> bytes:
        descriptor = self._file.fileno()
        status = os.fstat(descriptor)
        wanted = min(size, max(0, self.size - offset))
        data = os.pread(descriptor, wanted, offset)
        while len(data) < wanted:
            more = os.pread(descriptor, wanted - len(data), offset + len(data))
            if not more:
                break
            data += more
        if status.st_size != self.size or status.st_mtime_ns != self._modified or len(data) != wanted:
            raise ProgramError(catalogue.FILE_CHANGED, Place(file=self.name), file=self.name)
        return data
