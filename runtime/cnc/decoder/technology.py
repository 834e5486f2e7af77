"""M, H, S and T of a block: which functions are put out, with which synchronisation, before or behind the motion."""

from __future__ import annotations

from runtime.cnc.blocks import (
    AHEAD,
    AT_BLOCK_END,
    BY_PATH,
    Block,
    Source,
    StopKind,
    Synch,
    Technology,
    TechnologyFunction,
    Wait,
)
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.modal import ModalState
from runtime.cnc.language.addresses import Addresses
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock, FunctionSlots, Values
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.parser import INTERNAL_M, SPINDLE_M, TOOL_CHANGE_M, check_function
from runtime.cnc.language.isg.words import WordKind
from runtime.config.channel.parameters import INTERNAL
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.catalogue import technology
from runtime.hli.units import MICROSECOND

STOPS = {0: StopKind.PROGRAMMED, 1: StopKind.OPTIONAL}
PROGRAM_END = (2, 30)
SUBPROGRAM_END = (17, 29)
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


def functions_of(block: CompiledBlock, values: Values, x: Execution) -> Functions:
    """The functions of a block: T, spindle, M, H, whatever their order in the text, so that a tool change knows its
    tool.

    S is entered into the modal state. Raises LineError.
    """
    source, setup, addresses, modal = x.source, x.setup, x.setup.addresses, x.modal
    functions = Functions(source)
    spindle_m = -1
    if block.speed >= 0:
        speed = values[block.speed]
        if not 0 <= speed <= VALUE_LIMIT:
            raise LineError(catalogue.SPEED_NEGATIVE, block.column(WordKind.SPEED), value=speed)
        modal.speed = speed
    if block.tool >= 0:
        tool = values[block.tool]
        if not 0 <= tool <= VALUE_LIMIT:
            raise LineError(catalogue.FUNCTION_NEGATIVE, block.column(WordKind.TOOL), value=tool, address="T")
        if setup.tool_synch != Synch.NO_SYNCH:
            number = round_half_up(tool)
            functions.add(
                TechnologyFunction(source, Technology.T, number, 0.0, setup.tool_synch, duration=setup.tool_duration)
            )
    numbers = [_number(slots, values, addresses) for slots in block.m]
    for slots, number in zip(block.m, numbers, strict=True):
        if number in SPINDLE_M:
            if spindle_m >= 0:
                raise LineError(catalogue.SPINDLE_M_TWICE, slots.word.column, number=number, other=spindle_m)
            spindle_m = x.spindle_command = number
            _spindle(functions, setup.spindles[0].m[number], number, modal, source, slots.word.column)
    if block.speed >= 0 and spindle_m < 0:  # with a spindle M function, only the synchronisation of that one counts
        _spindle(functions, setup.spindles[0].s, 0, modal, source, block.column(WordKind.SPEED))
    for slots, number in zip(block.m, numbers, strict=True):
        if number in SPINDLE_M:
            continue
        if number in STOPS:
            functions.stops.append(STOPS[number])
        elif number in PROGRAM_END or number in SUBPROGRAM_END:
            functions.ending = number
        if number == TOOL_CHANGE_M and x.levels.file_of("M6"):
            if slots.extra >= 0:
                raise LineError(catalogue.VALUE_NOT_ALLOWED, slots.word.column, number=number)
            functions.tool_change = True
            continue
        if number not in x.memory.m_synch and number not in INTERNAL_M:
            raise LineError(catalogue.M_UNDEFINED, slots.word.column, number=number)
        put_out(x, functions, Technology.M, number, _extra(slots, values), slots.word.column)
    for slots in block.h:
        number = _number(slots, values, addresses)
        put_out(x, functions, Technology.H, number, _extra(slots, values), slots.word.column)
    return functions


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
    if ahead and not synch & AHEAD:
        raise LineError(technology.MICRO_JOINT, column, letter=kind.name, number=number, synch=synch.kind.name)
    if area is None:
        area = (setup.m_area if m else setup.h_area).get(number, -1)
    lead = ahead * (INTERNAL if synch & BY_PATH else MICROSECOND)
    duration = (setup.m_duration if m else setup.h_duration).get(number, 0.0)
    functions.add(TechnologyFunction(x.source, kind, number, value, synch, area=area, lead=lead, duration=duration))


def _spindle(functions: Functions, synch: Synch, number: int, modal: ModalState, source: Source, column: int) -> None:
    """A function of the main spindle: for the spindle axis, and with PLC_INFO for the PLC too.

    With NO_SYNCH the kernel of the manual does not execute it (programming manual, chapter 15.2.1.1). A spindle that
    goes on turning after an M5 is no way to run a machine, so here that is an error.
    """
    if synch.kind == Synch.NO_SYNCH:
        raise LineError(catalogue.SPINDLE_NO_SYNCH, column, word=f"M{number}" if number else "S")
    if synch == Synch.NOT_VALID:
        raise LineError(catalogue.SPINDLE_LOCKED, column, word=f"M{number}" if number else "S")
    functions.add(TechnologyFunction(source, Technology.S, number, modal.speed, synch, 0))


def _number(slots: FunctionSlots, values: Values, addresses: Addresses) -> int:
    if slots.word.value is not None and slots.word.value.constant is not None:
        return round_half_up(values[slots.number])  # checked when the program was read
    return check_function(slots.word, values[slots.number], addresses)


def _extra(slots: FunctionSlots, values: Values) -> float:
    if slots.extra < 0:
        return 0.0
    value = values[slots.extra]
    if not abs(value) <= VALUE_LIMIT:
        raise LineError(
            catalogue.RESULT_RANGE, slots.word.column, value=value, name=f"additional value of {slots.word.kind.name}"
        )
    return float(round_half_up(value))
