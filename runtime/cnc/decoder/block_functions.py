"""The functions of a block on their way into the stream: sorted by their place around the motion, with what is configured."""

from __future__ import annotations

from runtime.cnc.blocks import (
    AHEAD,
    AT_BLOCK_END,
    BY_TIME,
    MICRO_JOINTS,
    Block,
    Source,
    StopKind,
    Synch,
    Technology,
    TechnologyFunction,
    Wait,
)
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.language.addresses import Addresses
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import FunctionSlots, Values
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.parser import check_function
from runtime.config.channel.parameters import INTERNAL
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.catalogue import technology
from runtime.hli.units import MICROSECOND

VALUE_LIMIT = 2**31 - 1  # additional values are signed 32 bit integers
_BEHIND = Synch.MNS_SNS | Synch.MNE_SNS | AHEAD  # types that are put out at the end of the motion, or ahead of it
_WAIT_BEHIND = AT_BLOCK_END ^ Synch.MVS_SVS


class Functions:
    """The functions of one block, sorted by their place in the stream."""

    __slots__ = ("_source", "after", "before", "ending", "flush", "stops", "tool_change", "waits")

    def __init__(self, source: Source) -> None:
        self._source = source
        self.tool_change = False  # M6 calls a program
        self.before: list[Block] = []
        self.after: list[Block] = []
        self.waits = Synch.NO_SYNCH  # types in this block
        self.flush = False  # decoding goes on when everything is done
        self.stops: list[StopKind] = []
        self.ending = -1  # number of the M function that ends the program or subprogram

    def add(self, function: TechnologyFunction) -> None:
        """Sort a function in by its synchronisation type."""
        kind = function.synch.kind
        (self.after if kind & _BEHIND else self.before).append(function)
        if not function.lead or kind & AHEAD:  # one that is moved back waits where it is put out
            self.waits |= kind
        self.flush |= bool(function.synch & Synch.FAW_SYNCH)

    def leading(self) -> list[Block]:
        """What stands in front of the motion."""
        if not self.waits & Synch.MVS_SVS:
            return self.before
        return [*self.before, Wait(self._source, Synch.MVS_SVS)]

    def held_back(self) -> list[Block]:
        """The M function that ends the program, taken out of the block: it is put out when everything else is done."""
        held = Functions(self._source)
        for place in (self.before, self.after):
            for function in [f for f in place if isinstance(f, TechnologyFunction)]:
                if function.kind is Technology.M and function.number == self.ending:
                    place.remove(function)
                    held.add(function)
        return [*held.leading(), *held.trailing()]

    def trailing(self) -> list[Block]:
        """What stands behind the motion."""
        return [*self.after, Wait(self._source)] if self.waits & _WAIT_BEHIND else self.after


def put_out_tool(x: Execution, functions: Functions, basic: int, sister: int = 0, variant: int = 0) -> None:
    """The T function of a tool, if the channel has one (P-CHAN-00086)."""
    setup = x.setup
    if setup.tool_synch != Synch.NO_SYNCH:
        synch, duration = setup.tool_synch, setup.tool_duration
        tool = TechnologyFunction(
            x.source, Technology.T, basic, 0.0, synch, duration=duration, sister=sister, variant=variant
        )
        functions.add(tool)


def put_out(
    x: Execution,
    functions: Functions,
    kind: Technology,
    number: int,
    value: float,
    column: int,
    area: int | None = None,
) -> None:
    """An M or H function that the channel has; `area`: on whose interface, None where the configuration says.

    Raises LineError.
    """
    memory, setup = x.memory, x.setup
    m = kind is Technology.M
    synch = (memory.m_synch if m else memory.h_synch).get(number, Synch.NO_SYNCH)
    if synch.kind == Synch.NO_SYNCH:
        return
    ahead = (memory.m_ahead if m else memory.h_ahead).get(number, 0)
    if area is None:
        area = (setup.m_area if m else setup.h_area).get(number, -1)
    if ahead and not synch & AHEAD:
        values: dict[str, object] = {"letter": kind.name, "number": number, "synch": synch.kind.name}
        if not setup.micro_joints:
            raise LineError(technology.MICRO_JOINT, column, **values)
        if area >= 0 or not synch & MICRO_JOINTS:
            raise LineError(technology.JOINT_BARRED, column, **values)
    lead = ahead * (MICROSECOND if synch & BY_TIME else INTERNAL)
    duration = (setup.m_duration if m else setup.h_duration).get(number, 0.0)
    functions.add(TechnologyFunction(x.source, kind, number, value, synch, area=area, lead=lead, duration=duration))


def number_of(slots: FunctionSlots, values: Values, addresses: Addresses) -> int:
    """The number of an M or H word that the channel has; raises LineError."""
    if slots.word.value is not None and slots.word.value.constant is not None:
        return round_half_up(values[slots.number])  # checked when the program was read
    return check_function(slots.word, values[slots.number], addresses)


def extra_of(slots: FunctionSlots, values: Values) -> float:
    """The additional value of an M or H word, a whole number, 0 without; raises LineError."""
    if slots.extra < 0:
        return 0.0
    value = values[slots.extra]
    if not abs(value) <= VALUE_LIMIT:
        raise LineError(
            catalogue.RESULT_RANGE, slots.word.column, value=value, name=f"additional value of {slots.word.kind.name}"
        )
    return float(round_half_up(value))
