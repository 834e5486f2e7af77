"""The CNC's side of the block search: orders for the next start, and the PLC's agreement."""

from __future__ import annotations

from runtime.hli.layout import BoolUnit, ChannelControl, ChannelStatus, OperatorUnit, SearchOrder, SearchState


class SearchOrders:
    """The unit of a channel. An order of the operator's holds for one start only."""

    def __init__(self, control: ChannelControl, operator: OperatorUnit) -> None:
        self._unit = control.block_search
        self._operator = operator.block_search

    def take(self, present: bool, *, asked: bool) -> SearchOrder | None:
        """A program is started: the order that holds for it, None to start at the beginning.

        `asked`: the operator has asked for this start; what he has asked for another one, which the PLC kept, is dropped.
        """
        unit, operator = self._unit, self._operator
        order = SearchOrder()
        if present and unit.enable_w:
            if operator.semaphor_rw:
                unit.request_r = operator.data_w
            order = SearchOrder.from_buffer_copy(unit.command_w)
        elif operator.semaphor_rw and asked:
            order = SearchOrder.from_buffer_copy(operator.data_w)
        operator.semaphor_rw = False
        unit.type_r = order.type
        return order if order.type else None

    def start_refused(self) -> None:
        """The start was refused before it came to a program: what was asked for it holds for no other one."""
        self._operator.semaphor_rw = False


class SearchPartner:
    """The PLC while a search goes on: whether it agrees, and what it is told."""

    def __init__(self, unit: BoolUnit, status: ChannelStatus) -> None:
        self._unit = unit
        self._status = status
        self.state = SearchState.INACTIVE

    def show(self, state: SearchState) -> None:
        """Tell where the search is."""
        self.state = state
        status = self._status
        status.block_search_active_r = state in (SearchState.ACTIVE, SearchState.WAIT_FOR_PLC_OFF)
        status.block_search_state_r = state
        self._unit.request_r = state in (SearchState.WAIT_FOR_PLC_ON, SearchState.WAIT_FOR_PLC_OFF)

    def agrees(self, present: bool) -> bool:
        """The PLC has confirmed what is waited for, or has not claimed the unit."""
        unit = self._unit
        unit.state_r = bool(unit.command_w) if present and unit.enable_w else self.state == SearchState.WAIT_FOR_PLC_ON
        return bool(unit.state_r) == (self.state is SearchState.WAIT_FOR_PLC_ON)
