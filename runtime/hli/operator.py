"""The operator's side: another process that starts programs, holds, resets, overrides (`tandem hli command`, later
the HMI)."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from runtime.diagnostics.catalogue import block_search
from runtime.diagnostics.catalogue import plc as catalogue
from runtime.diagnostics.errors import ErrorEntry, Severity, TandemError
from runtime.diagnostics.memory import SHARED_MEMORY
from runtime.hli.errors import HliError
from runtime.hli.layout import (
    ManualMode,
    Mode,
    OperatorActivation,
    OperatorJogParameter,
    OperatorKey,
    SearchOrder,
    State,
)
from runtime.hli.memory import HliMemory, get_text, put_text
from runtime.hli.modes import Wish
from runtime.hli.units import LENGTH, SPEED, to_int32

SEARCH_INTERRUPTION = 6  # type of a block search: where the program was interrupted
PATIENCE = 2.0  # s until an order counts as not answered
POLL = 0.002
KEY_HOLD = 0.3  # s that a press holds by itself


class OrderRefusedError(TandemError):
    """The CNC has refused the order; the problem is the CNC's answer."""


class Operator:
    """Gives orders to one channel. `sleep` waits between two looks at the answer; it is the caller's clock."""

    def __init__(self, memory: HliMemory, sleep: Callable[[float], None], channel: int = 0) -> None:
        self._name = memory.name or ""
        self._memory = memory
        self._sleep = sleep
        self._channel = channel
        self._unit = memory.hli.operator[channel]
        self._modes = memory.hli.channels[channel].control.mode_and_state

    # ------------------------------------------------------------------ orders of the mode unit

    def start(self, program: str, search: SearchOrder | None = None) -> None:
        """Start an NC program in AUTOMATIC, with a block search where one is given. Raises OrderRefusedError, or HliError if
        nobody answers; the search is withdrawn then."""
        unit = self._unit.block_search
        if search is not None:
            unit.data_w = search
        unit.semaphor_rw = search is not None
        try:
            self.order(Wish(Mode.AUTOMATIC, State.ACTIVE, program))
        except TandemError:
            unit.semaphor_rw = False
            raise

    def restart(self, search: SearchOrder) -> str:
        """Go on with the program that was interrupted, where it was; its name. Raises as `start`, and HliError without one."""
        point = self._memory.hli.channels[self._channel].status.interruption
        program = get_text(point, "program_r")
        if not point.valid_r:
            raise HliError(block_search.SEARCH_NO_POINT, program=program)
        search.type = SEARCH_INTERRUPTION
        self.start(program, search)
        return program

    def execute(self, blocks: str) -> None:
        """Execute NC blocks in MDI, separated by line feeds. Raises as `start`."""
        self.order(Wish(Mode.MDI, State.ACTIVE, blocks))

    def manual(self, blocks: str = "") -> None:
        """Select MANUAL; `blocks` go before, with G200 as the last of them. Raises as `start`."""
        self.order(Wish(Mode.MANUAL, State.ACTIVE, blocks))

    def home(self, blocks: str = "") -> None:
        """Home the axes that the NC blocks name, or start the program rpf.nc. Raises as `start`."""
        self.order(Wish(Mode.HOMING, State.ACTIVE, blocks))

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

    def machine_lock(self, on: bool) -> None:
        """No axis moves in the programs that are started from now on."""
        self._unit.machine_lock_w = on

    def backward(self, on: bool) -> None:
        """Drive the path backward, as far as it is kept; off: forward again."""
        self._unit.backward_motion_w = on

    def simulate_motion(self, on: bool) -> None:
        """Leave out the sections of #OPTIONAL EXECUTION."""
        self._unit.simulate_motion_w = on

    def skip_levels(self, mask: int) -> None:
        """Block skip: bit n-1 = level n."""
        self._unit.program_block_ignore_w = mask

    # ------------------------------------------------------------------ manual mode

    def press(self, key: int, direction: int, hold: float = KEY_HOLD) -> None:
        """Press a key of a pair (direction 1 or -1) or release it (0). It is released by itself after `hold` s: renew it."""
        unit = self._unit.key
        self._hand_over(unit, key=key, direction=direction, hold_time=round(hold * 1e6))

    def link(self, axis: int, element: int, mode: ManualMode, stage: int = 0) -> None:
        """Link a key pair or handwheel to the axis with a logical number."""
        self._hand_over(
            self._unit.activation, log_ax_n=axis, control_element=element, operation_mode=int(mode), parameter_set=stage
        )

    def jog_parameter(self, unit: str, axis: int, width: float = 0.0, velocity: float = 0.0) -> None:
        """Values of `handwheel_parameter`, `continuous_parameter` or `jog_parameter`, mm or degrees and seconds; 0 keeps."""
        values = {"width": to_int32(width, LENGTH), "velocity": to_int32(velocity, SPEED)}
        self._hand_over(getattr(self._unit, unit), log_ax_n=axis, **values)

    def turn(self, handwheel: int, pulses: int) -> None:
        """Turn a handwheel (from 1)."""
        counts = self._unit.handwheel_w
        counts[handwheel - 1] = (counts[handwheel - 1] + pulses + 2**31) % 2**32 - 2**31

    def _hand_over(self, unit: OperatorKey | OperatorActivation | OperatorJogParameter, **values: int) -> None:
        """Fill a unit and raise its flag, when the CNC has taken what was in it."""
        with _one_at_a_time(self._memory.name):
            for _ in range(round(PATIENCE / POLL)):
                if not unit.semaphor_rw:
                    break
                self._sleep(POLL)
            for name, value in values.items():
                setattr(unit.data_w, name, value)
            unit.semaphor_rw = True

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
