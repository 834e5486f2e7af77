"""The time of the PLC cycle: one moment for everything that runs in it, given by the runtime's clock.

Function blocks read it here, so they need no clock and behave the same in a simulation. It is nanoseconds, whole
numbers: a timer of 0.3 s must not end a cycle late because 75 cycles of 4 ms add up to a little less.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar

_now_ns: ContextVar[int] = ContextVar("time of the PLC cycle")


def now_ns() -> int:
    """The time of the running PLC cycle, ns; RuntimeError outside of one."""
    try:
        return _now_ns.get()
    except LookupError:
        raise RuntimeError(
            "timers run in a PLC cycle only; in a test use runtime.plc_logic.cycle_at(seconds)"
        ) from None


@contextmanager
def cycle_at_ns(time_ns: int) -> Iterator[None]:
    """A PLC cycle at this time."""
    token = _now_ns.set(time_ns)
    try:
        yield
    finally:
        _now_ns.reset(token)


def cycle_at(seconds: float) -> AbstractContextManager[None]:
    """The same in seconds, for tests: `with cycle_at(0.3): timer(IN=True, PT=0.3)`."""
    return cycle_at_ns(round(seconds * 1e9))
