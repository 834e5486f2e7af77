"""A bus that is gone: when it counts as gone, who may bring it back, and what proves that it works again.

    there ─ errors in a row, interface down, bus off ─▶ gone ─ pause over ─▶ tried ─ frames go out and one comes in ─▶ there
                                                         └─ recovery manual, or count spent ─▶ waits for the reset ─▶ tried

That sending succeeds proves little: an interface without carrier takes frames into its queue.
"""

from __future__ import annotations

import errno
from typing import Final

from runtime.config.machine import Bus
from runtime.drives import DriveEvent

FAILURES_UNTIL_GONE: Final = 3  # cycles in a row with an error of the bus; a full transmit queue may pass by
GONE_AT_ONCE: Final = frozenset({errno.ENETDOWN, errno.ENODEV, errno.ENXIO, errno.EBADF, errno.ENETUNREACH})


class Outage:
    """State of one bus. `gone` is how it was lost, None while it is there."""

    def __init__(self, bus: Bus) -> None:
        self._pause = bus.recovery_pause
        self._count = 0 if bus.recovery == "manual" else bus.recovery_count
        self.forget()

    def forget(self) -> None:
        """The state before the first cycle."""
        self.gone: DriveEvent | None = None
        self.sending_works = False
        self.recoveries = 0  # since the last reset, by itself
        self._gone_at = 0.0
        self._allowed = False  # by a reset
        self._failed = False  # an error of the bus in this cycle
        self._failures = 0

    def cycle(self) -> None:
        """A cycle begins."""
        self._failures = self._failures + 1 if self._failed else 0
        self._failed = False

    def failed(self, code: int) -> bool:
        """An error of the bus, with its errno or 0; True if it counts as gone now."""
        self._failed = True
        return code in GONE_AT_ONCE or self._failures >= FAILURES_UNTIL_GONE - 1

    def begin(self, event: DriveEvent, now: float) -> None:
        self.gone, self._gone_at = event, now
        self.sending_works = self._allowed = False

    @property
    def waits(self) -> bool:
        """Whether only a reset lets the bus be tried again."""
        return not self._allowed and self._count is not None and self.recoveries >= self._count

    def reset(self) -> None:
        """Somebody has acknowledged."""
        self.recoveries = 0
        self._allowed = True

    def tried(self, now: float) -> bool:
        """Whether frames are to be sent into the bus that is gone."""
        return not self.waits and now - self._gone_at >= self._pause

    def heard(self, now: float) -> bool:
        """Somebody else's frame has come; True if this is the end of the outage."""
        if not (self.sending_works and self.tried(now)):
            return False
        if not self._allowed:
            self.recoveries += 1
        self.gone = None
        self._failures, self._failed = 0, False
        return True
