"""The tables of the NCT dialect: every G code, modal word and system variable is registered here once.

Checker, decoder and `tandem lang --dialect nct` read these tables and nothing else.

    @g_code("1", Group.MOTION, "nct.motion.linear-g01", meaning="straight line at feed", moves=straight_line)
    def linear(x: NctExecution, call: GCall) -> None:
        x.modal.motion = Motion.LINEAR

A block is executed in the stages of `Stage`; within a stage in the order of the text. A handler gets the `NctExecution` of the
program and the code as it was written; it changes the state or emits blocks, and raises LineError for what the user did wrong.
What a code wants from its block it reads from `x.words` (see `BlockWords`): `x.words.number("P")`, `x.axes()`.

`takes` names the addresses that a code takes besides axis words. An address that no code of the block, no active mover and
no modal word takes is refused, so that nothing of a block is passed over silently.

The **mover** of a block is the active code of the drilling cycles (Group.CYCLE, unless it is G80), else that of Group.MOTION: its
`moves` is called when axis words, or addresses that it takes, are left for it.
"""

from __future__ import annotations

import bisect
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import TYPE_CHECKING

from runtime.cnc.language.nct.compiler import Value

if TYPE_CHECKING:
    from runtime.cnc.decoder.nct.execution import NctExecution


class Group(Enum):
    """Groups of G codes with their numbers in the table (manual lines 627–933); one code of a group per block.

    The codes of ONE_SHOT act in their own block only and exclude each other there; others hold until another one of their group.
    """

    ONE_SHOT = 0
    MOTION = 1
    PLANE = 2
    DIMENSION = 3
    STROKE_CHECK = 4
    FEED_MODE = 5
    UNIT = 6
    COMPENSATION = 7
    LENGTH = 8
    CYCLE = 9
    RETURN_LEVEL = 10
    SCALING = 11
    MACRO = 12
    SURFACE_SPEED = 13
    WORK_OFFSET = 14
    FEED_CONTROL = 15
    ROTATION = 16
    POLAR = 17
    MIRROR = 18
    FLUCTUATION = 108  # printed as 8, with which it has nothing to do
    POLAR_INTERPOLATION = 26


class Stage(IntEnum):
    """When the handler of a code is called within its block.

    SELECT      what the words of the block mean: plane, unit, dimension, polar, meaning of F, path condition
    (then the modal words: F, D, H … in the order of `WORDS`)
    SET         coordinate systems, compensations, transformations; settings that take the axis words as arguments
    (then functions M, S, T that stand in front of the motion)
    MOVE        takes the place of the motion of the block: G04, G28, G53, G31
    (the mover, if axis words are left; then functions behind the motion)
    LAST        when everything else is done: calls
    """

    SELECT = 0
    SET = 1
    MOVE = 2
    LAST = 3


@dataclass(frozen=True, slots=True)
class GCall:
    """A G code in a block: `tenths` is ten times its number (842 for G84.2), `name` as it is written in texts."""

    tenths: int
    column: int
    modal: bool = False  # called for the state at program start, no block is there

    @property
    def name(self) -> str:
        return f"G{number_text(self.tenths)}"


Handler = Callable[["NctExecution", GCall], None]
Mover = Callable[["NctExecution"], None]


@dataclass(frozen=True, slots=True)
class GCode:
    """A registered G code."""

    tenths: int
    group: Group
    spec: tuple[str, ...]
    meaning: str
    handler: Handler
    stage: Stage
    takes: frozenset[str]
    axes: bool  # its axis words are arguments, or targets of a motion of its own
    moves: Mover | None
    all_words: bool  # it takes every word of the block: macro calls
    functions_within: bool  # its `moves` puts out the functions of the block (`x.block_functions`)

    @property
    def name(self) -> str:
        return f"G{number_text(self.tenths)}"

    @property
    def modal(self) -> bool:
        return self.group is not Group.ONE_SHOT


G_CODES: dict[int, GCode] = {}

# Codes of the table that no registration has are refused as not supported yet, all others as 3005.
TABLE = frozenset(
    (
        *(
            10 * number
            for number in (*range(5), *range(9, 12), *range(15, 24), 25, 26, 28, 29, 30, 31, 33, *range(37, 60))
        ),
        *(10 * number for number in (*range(61, 70), 73, 74, 76, *range(80, 93), *range(94, 100))),
        *(51, 71, 121, 131, 501, 511, 661, 842, 843),
    )
)


def tenths_of(number: str | float) -> int:
    """The key of a G number."""
    return round(float(number) * 10)


def number_text(tenths: int) -> str:
    """G numbers as they are written: 1 is 01, 842 is 84.2."""
    whole, part = divmod(tenths, 10)
    return f"{whole:02d}.{part}" if part else f"{whole:02d}"


def g_code(
    number: str,
    group: Group,
    *spec: str,
    meaning: str,
    stage: Stage = Stage.SELECT,
    takes: str | tuple[str, ...] = "",
    axes: bool = False,
    moves: Mover | None = None,
    all_words: bool = False,
    functions_within: bool = False,
) -> Callable[[Handler], Handler]:
    """Register the decorated handler for a G code ("1", "84.2"); `spec` are the catalogue entries it belongs to."""

    def register(handler: Handler) -> Handler:
        tenths = tenths_of(number)
        if tenths in G_CODES:
            raise ValueError(f"G{number} is registered twice")
        G_CODES[tenths] = GCode(
            tenths,
            group,
            spec,
            meaning,
            handler,
            stage,
            frozenset(takes),
            axes,
            moves,
            all_words,
            functions_within,
        )
        return handler

    return register


# ---------------------------------------------------------------------------------------------------- modal words

WordHandler = Callable[["NctExecution", float, int], None]  # (execution, value, column)


@dataclass(frozen=True, slots=True)
class ModalWord:
    """An address that means something by itself, whatever else stands in its block, and holds until the next one."""

    address: str
    spec: tuple[str, ...]
    meaning: str
    handler: WordHandler
    syntax: str


WORDS: dict[str, ModalWord] = {}  # in the order in which they are executed


def word(address: str, *spec: str, meaning: str, syntax: str = "") -> Callable[[WordHandler], WordHandler]:
    """Register the decorated handler of a modal word, called with its value (rounded and within its limits)."""

    def register(handler: WordHandler) -> WordHandler:
        if address in WORDS:
            raise ValueError(f"address {address} is registered twice")
        WORDS[address] = ModalWord(address, spec, meaning, handler, syntax or f"{address}_")
        return handler

    return register


# ---------------------------------------------------------------------------------------------------- M codes

MHandler = Callable[["NctExecution", int, int], None]  # (execution, number, column)


@dataclass(frozen=True, slots=True)
class MCode:
    """An M code that the control acts on itself: M00, M01, M02, M30, M98, M99. All others go to the PLC."""

    number: int
    spec: tuple[str, ...]
    meaning: str
    handler: MHandler
    takes: frozenset[str]


M_CODES: dict[int, MCode] = {}


def m_code(number: int, *spec: str, meaning: str, takes: str = "") -> Callable[[MHandler], MHandler]:
    """Register the decorated handler: it is called when everything else of its block is done."""

    def register(handler: MHandler) -> MHandler:
        if number in M_CODES:
            raise ValueError(f"M{number} is registered twice")
        M_CODES[number] = MCode(number, spec, meaning, handler, frozenset(takes))
        return handler

    return register


# ---------------------------------------------------------------------------------------------------- system variables

Reader = Callable[["NctExecution", int], Value]  # (execution, number of the variable)
Writer = Callable[["NctExecution", int, Value], None]


@dataclass(slots=True)
class SystemVariable:
    """The system variables `first` to `last`. `in_step`: before it is read the path has to have come to this block."""

    first: int
    last: int
    spec: tuple[str, ...]
    meaning: str
    read: Reader | None
    write: Writer | None = None
    in_step: bool = False


_VARIABLES: list[SystemVariable] = []  # by `first`
_FIRST: list[int] = []


def system_variable(
    first: int, last: int | None = None, *spec: str, meaning: str, in_step: bool = False
) -> Callable[[Reader], Reader]:
    """Register the decorated reader of system variables: `read(execution, number)`, None for vacant; raises CalculationError."""

    def register(read: Reader) -> Reader:
        _add(SystemVariable(first, first if last is None else last, spec, meaning, read, None, in_step))
        return read

    return register


def writes(
    first: int, last: int | None = None, *, spec: tuple[str, ...] = (), meaning: str = ""
) -> Callable[[Writer], Writer]:
    """Register the decorated writer: of variables that have a reader already, or of some that can only be written."""

    def register(write: Writer) -> Writer:
        known = find_variable(first)
        if known is None:
            _add(SystemVariable(first, first if last is None else last, spec, meaning, None, write))
        else:
            known.write = write
        return write

    return register


def _add(variable: SystemVariable) -> None:
    place = bisect.bisect(_FIRST, variable.first)
    before = _VARIABLES[place - 1] if place else None
    if before is not None and before.last >= variable.first:
        raise ValueError(f"#{variable.first} is registered twice")
    _FIRST.insert(place, variable.first)
    _VARIABLES.insert(place, variable)


def find_variable(number: int) -> SystemVariable | None:
    """The registration of a system variable, None if there is none of this number."""
    place = bisect.bisect(_FIRST, number) - 1
    return _VARIABLES[place] if place >= 0 and number <= _VARIABLES[place].last else None


def system_variables() -> tuple[SystemVariable, ...]:
    """All of them by number."""
    return tuple(_VARIABLES)
