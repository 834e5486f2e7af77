"""The time of the PLC cycle: one moment for everything that runs in it, given by the runtime's clock.

Function blocks read it here, so they need no clock and behave the same in a simulation. It is nanoseconds, whole
numbers: a timer of 0.3 s must not end a cycle late because 75 cycles of 4 ms add up to a little less.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from datetime import datetime

OUTSIDE = -1


class _Moment:
    """A PLC process runs one cycle at a time, so one place is enough; a context variable would cost each timer more
    than the rest of its work."""

    __slots__ = ("now_ns", "wall_ns")

    def __init__(self) -> None:
        self.now_ns = OUTSIDE
        self.wall_ns = 0  # since 1970 UTC


MOMENT = _Moment()


def now_ns() -> int:
    """The time of the running PLC cycle, ns; RuntimeError outside of one."""
    now = MOMENT.now_ns
    if now < 0:
        raise RuntimeError("timers run in a PLC cycle only; in a test use runtime.plc_logic.cycle_at(seconds)")
    return now


def wall_clock() -> datetime:
    """Date and time of day of the running PLC cycle, local time."""
    return datetime.fromtimestamp(MOMENT.wall_ns // 1000 / 1e6)


@contextmanager
def cycle_at_ns(time_ns: int, wall_ns: int = 0) -> Iterator[None]:
    """A PLC cycle at this time; `wall_ns`: nanoseconds since 1970."""
    before = (MOMENT.now_ns, MOMENT.wall_ns)
    MOMENT.now_ns, MOMENT.wall_ns = time_ns, wall_ns
    try:
        yield
    finally:
        MOMENT.now_ns, MOMENT.wall_ns = before


def cycle_at(seconds: float) -> AbstractContextManager[None]:
    """The same in seconds, for tests: `with cycle_at(0.3): timer(IN=True, PT=0.3)`."""
    return cycle_at_ns(round(seconds * 1e9))
