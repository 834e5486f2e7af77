"""Keys of a terminal while something moves: nothing waits for them, and their end is noticed.

A terminal sends a key that is held again and again, and tells nothing when it is let go: who moves something for a key has to
stop by itself when no more comes. Ctrl-C, a terminal that is closed and the end of a pipe all mean the same: stop, then end.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import termios
import tty
from types import FrameType
from typing import Any, Final, Self

_ARROWS: Final = {b"\x1b[C": b"+", b"\x1b[D": b"-", b"\x1bOC": b"+", b"\x1bOD": b"-"}
_SIGNALS: Final = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_LONGEST: Final = 256  # bytes at once


class Keys:
    """The keys of a file descriptor, a terminal or a pipe; use it with `with`."""

    def __init__(self, descriptor: int | None = None) -> None:
        self._descriptor = sys.stdin.fileno() if descriptor is None else descriptor
        self._before: list[Any] | None = None  # settings of the terminal
        self._handlers: dict[int, Any] = {}
        self.ended = False

    def __enter__(self) -> Self:
        if os.isatty(self._descriptor):
            self._before = termios.tcgetattr(self._descriptor)
            tty.setcbreak(self._descriptor)
        for number in _SIGNALS:
            self._handlers[number] = signal.signal(number, self._end)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
        if self._before is not None:
            with contextlib.suppress(termios.error, OSError):  # a terminal that is gone needs no settings
                termios.tcsetattr(self._descriptor, termios.TCSADRAIN, self._before)

    def _end(self, number: int, frame: FrameType | None) -> None:
        self.ended = True

    def read(self) -> bytes | None:
        """The keys since the last time, arrows as + and -; None when there will be no more."""
        if self.ended:
            return None
        try:
            if not select.select([self._descriptor], [], [], 0)[0]:
                return b""
            data = os.read(self._descriptor, _LONGEST)
        except OSError:  # EIO: the terminal was closed
            data = b""
        if not data:
            self.ended = True
            return None
        for arrow, key in _ARROWS.items():
            data = data.replace(arrow, key)
        return data


class StatusLine:
    """One line on standard error that is written over again; what a terminal does not take at once is left out."""

    def __init__(self, descriptor: int = 2) -> None:
        self._descriptor = descriptor
        self._terminal = os.isatty(descriptor)

    def tell(self, text: str) -> None:
        """A terminal that is stopped (Ctrl-S) or gone must not stop who writes to it."""
        if not self._terminal:
            return
        with contextlib.suppress(OSError):
            if select.select([], [self._descriptor], [], 0)[1]:
                os.write(self._descriptor, f"\r{text}\x1b[K".encode())

    def close(self) -> None:
        """Go on in the next line."""
        if self._terminal:
            with contextlib.suppress(OSError):
                os.write(self._descriptor, b"\n")
