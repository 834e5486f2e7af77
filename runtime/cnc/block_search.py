"""A block search in the cycle: it opens the gates of the search one by one, and keeps the place where the program is.

    WAIT_FOR_PLC_ON ─ ACTIVE ─ WAIT_FOR_PLC_OFF ─ WAIT_FOR_RETURN ─ RETURNING ─ WAIT_TO_CONTINUE ─ INACTIVE

What leaves functions, path and hand alone: they behave as in any program, and so do feed hold, reset and abort.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from runtime.cnc.motion_queue import GateReason
from runtime.cnc.preparation_link import StartOrder
from runtime.hli.block_search import SearchPartner
from runtime.hli.layout import Mode, SearchState

Floats = npt.NDArray[np.float64]
GATES = frozenset({GateReason.SEARCH_BEGIN, GateReason.SEARCH_END, GateReason.SEARCH_RETURN, GateReason.SEARCH_GO_ON})
_BEHIND = {
    GateReason.SEARCH_BEGIN: SearchState.ACTIVE,
    GateReason.SEARCH_END: SearchState.WAIT_FOR_RETURN,
    GateReason.SEARCH_RETURN: SearchState.RETURNING,
    GateReason.SEARCH_GO_ON: SearchState.INACTIVE,
}


@dataclass(slots=True)
class PointOfInterruption:
    """Where the program of mode AUTOMATIC is or was; `begin` (n_axes,) where the axes were at its start, `way` in mm."""

    program: str
    begin: Floats
    way: float = 0.0
    line: int = 0
    n: int = -1
    valid: bool = True


class BlockSearching:
    """Of one channel. Every method is bounded, and called in the cycle."""

    def __init__(self, partner: SearchPartner) -> None:
        self._partner = partner
        self.point: PointOfInterruption | None = None
        self._follows = False  # the point goes along with the path
        self._next: PointOfInterruption | None = None  # takes its place when the program goes on
        self._shift = 0.0  # way of the program - way of the path

    @property
    def state(self) -> SearchState:
        return self._partner.state

    def begin(self, order: StartOrder, *, locked: bool) -> None:
        """A program starts. An older point of interruption stays until the new program moves, which a locked one never does."""
        self._shift = 0.0
        self._follows, self._next = False, None
        if order.mode == Mode.AUTOMATIC and not order.text and not locked:
            self._next = PointOfInterruption(
                order.program, (order.start if order.begin is None else order.begin).copy()
            )
        if order.search is None:
            self._go_on()
        else:
            self._partner.show(SearchState.WAIT_FOR_PLC_ON)

    def _go_on(self) -> None:
        if self._next is not None:
            self.point, self._next, self._follows = self._next, None, True

    def end(self, *, reached: bool) -> None:
        """The program is over; `reached`: it has come to its end, and there is nothing to go on with."""
        if self.state is not SearchState.INACTIVE:
            self._partner.show(SearchState.INACTIVE)
        if self._follows and reached and self.point is not None:
            self.point.valid = False
        self._follows, self._next = False, None

    def place(self, way: float, path_position: float) -> None:
        """The program goes on here, `way` mm behind its start."""
        self._shift = way - path_position
        if self._next is not None:
            self._next.way = way

    def follow(self, path_position: float, line: int, n: int) -> None:
        """Once per cycle while a program runs."""
        point = self.point
        if self._follows and point is not None:
            point.way = path_position + self._shift
            if line > 0:
                point.line, point.n = line, n

    # ------------------------------------------------------------------ gates

    def agrees(self, present: bool) -> bool:
        """At BEGIN and END: the PLC has nothing against going on."""
        return self._partner.agrees(present)

    def arrived(self, reason: GateReason) -> None:
        """The path stands at a gate of the search."""
        if reason is GateReason.SEARCH_END and self.state is SearchState.ACTIVE:
            self._partner.show(SearchState.WAIT_FOR_PLC_OFF)
        elif reason is GateReason.SEARCH_GO_ON and self.state is SearchState.RETURNING:
            self._partner.show(SearchState.WAIT_TO_CONTINUE)

    def passed(self, reason: GateReason) -> None:
        """A gate of the search was opened."""
        self._partner.show(_BEHIND[reason])
        if reason is GateReason.SEARCH_GO_ON:
            self._go_on()
