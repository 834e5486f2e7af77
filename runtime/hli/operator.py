"""The operator's side: another process that starts programs, holds, resets, overrides (`tandem hli command`, later
the HMI)."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.diagnostics.errors import ErrorEntry, Severity, TandemError
from runtime.hli.errors import HliError
from runtime.hli.layout import Mode, State
from runtime.hli.memory import SHARED_MEMORY, HliMemory, get_text, put_text
from runtime.hli.modes import Wish

PATIENCE = 2.0  # s until an order counts as not answered
POLL = 0.002


class OrderRefusedError(TandemError):
    """The CNC has refused the order; the problem is the CNC's answer."""


class Operator:
    """Gives orders to one channel. `sleep` waits between two looks at the answer; it is the caller's clock."""

    def __init__(self, memory: HliMemory, sleep: Callable[[float], None], channel: int = 0) -> None:
        self._name = memory.name or ""
        self._memory = memory
        self._sleep = sleep
        self._unit = memory.hli.operator[channel]
        self._modes = memory.hli.channels[channel].control.mode_and_state

    # ------------------------------------------------------------------ orders of the mode unit

    def start(self, program: str) -> None:
        """Start an NC program in AUTOMATIC. Raises OrderRefusedError, or HliError if nobody answers."""
        self.order(Wish(Mode.AUTOMATIC, State.ACTIVE, program))

    def stop(self) -> None:
        """Stop on the path and end the program."""
        self.order(Wish(int(self._modes.mode_r), State.SELECTED))

    def order(self, wish: Wish) -> None:
        """Give an order and wait until the CNC has taken it (not: carried it out; that shows in mode and state)."""
        unit = self._unit
        with _one_at_a_time(self._memory.name):
            self._wait()  # for the end of an order whose giver did not wait
            order = unit.order_w
            order.from_mode = wish.from_mode
            order.from_state = wish.from_state
            order.to_mode = wish.to_mode
            order.to_state = wish.to_state
            put_text(order, "parameter", wish.parameter)
            unit.order_semaphor_rw = True
            self._wait()
            if unit.answer_r:
                text = get_text(unit, "answer_text_r")
                raise OrderRefusedError(ErrorEntry(int(unit.answer_r), "{text}", severity=Severity.WARNING), text=text)

    def _wait(self) -> None:
        for _ in range(round(PATIENCE / POLL)):
            if not self._unit.order_semaphor_rw:
                return
            self._sleep(POLL)
        self._unit.order_semaphor_rw = False  # withdrawn: it must not act when nobody expects it any more
        raise HliError(catalogue.OPERATOR_NO_ANSWER, name=self._name, seconds=PATIENCE)

    # ------------------------------------------------------------------ values that stand until they are changed

    def hold(self) -> None:
        """Feed hold."""
        self._unit.feedhold_w = True

    def resume(self) -> None:
        """Take the feed hold back."""
        self._unit.feedhold_w = False

    def override(self, percent: float) -> None:
        """Feed override."""
        self._unit.override_w = max(round(percent * 10), 0)

    def single_block(self, on: bool) -> None:
        """Stop after every block."""
        self._unit.single_block_w = on

    def optional_stop(self, on: bool) -> None:
        """M01 stops."""
        self._unit.optional_stop_w = on

    def skip_levels(self, mask: int) -> None:
        """Block skip: bit n-1 = level n."""
        self._unit.program_block_ignore_w = mask

    # ------------------------------------------------------------------ once

    def reset(self) -> None:
        """Reset the channel."""
        self._unit.reset_rw = True

    def continue_motion(self) -> None:
        """Go on after M00, M01 or single block."""
        self._unit.continue_motion_rw = True


@contextmanager
def _one_at_a_time(name: str | None) -> Iterator[None]:
    """Two operators (command line and HMI) must not write one order together: the kernel lets them pass one by one.

    A record lock, which leaves the owner's lock on the same file alone; it goes with its process.
    """
    if name is None:
        yield
        return
    descriptor = os.open(SHARED_MEMORY / name, os.O_RDWR)
    try:
        fcntl.lockf(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)
