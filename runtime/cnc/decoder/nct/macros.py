"""Macro calls: G65, the modal ones G66 and G66.1, and the codes that call programs (programmer's manual lines 6059–6480).

level in work ── modal_calls: [first, second, third]      G67 takes the last one away
    │ a motion (G66), or any block (G66.1)
    ▼
program of the third ── modal_calls: [first, second]      its own blocks call the second one, and so on
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from runtime.cnc.decoder.nct.arguments import Argument, ArgumentError, assigned
from runtime.cnc.decoder.nct.frames import Frame, Level
from runtime.cnc.decoder.nct.registry import G_CODES, Group, tenths_of
from runtime.cnc.decoder.nct.variables import Locals
from runtime.cnc.decoder.nct.words import BlockWords
from runtime.cnc.language.errors import LineError
from runtime.cnc.language.nct.compiler import CompiledBlock
from runtime.cnc.language.nct.words import Word
from runtime.config.nct import NctParameters
from runtime.diagnostics.catalogue import nct as words_catalogue
from runtime.diagnostics.catalogue import nct_macros as catalogue

if TYPE_CHECKING:
    from runtime.cnc.decoder.nct.execution import NctExecution

MOST_MACROS = 4  # nested (line 6448)
MOST_LEVELS = 8  # with subprograms
CALLS = frozenset(map(tenths_of, ("65", "66", "66.1", "67")))
CODE_ARGUMENTS = "PL"  # more arguments of a user G code (line 6335)
EVERY_BLOCK_ARGUMENTS = "GLNP"
M_ARGUMENTS = "GLP"  # of a user M code (line 6364)
PROGRAM_FLOW = (2, 30, 99)  # M codes that act also where blocks are arguments

# address → subprogram, and the common variable that gets its value (lines 6389-6438)
WORD_CALLS = {"T": (9034, 199), "S": (9033, 198), "A": (9030, 195), "B": (9031, 196), "C": (9032, 197)}
ORDER = "TSABCM"  # in which the subprograms of a block run


def _chosen(parameters: NctParameters, address: str) -> bool:
    """Whether an address calls its subprogram; A, B and C only where they are no axes."""
    if not getattr(parameters, f"{address.lower()}{WORD_CALLS[address][0]}"):
        return False
    return address in "TS" or address in parameters.miscel


@dataclass(frozen=True, slots=True)
class ModalCall:
    """A macro that is called by blocks: behind each motion, or (`every_block`) in the place of each block."""

    program: int
    passes: int
    arguments: Locals
    every_block: bool
    code: str = ""  # user code that has called it


@dataclass(frozen=True, slots=True)
class UserCodes:
    """The codes that call programs, as the machine builder has chosen them.

    `g`: tenths of a G code → program, and whether the call is modal; `m_macros`, `m_subprograms`: M code → program. `words`:
    address → subprogram, and the common variable that gets its value. `nested` (FGMAC): also within a program that such a code
    has called. `modal_every_block` (MODGEQU): modal calls come in the place of each block.
    """

    g: dict[int, tuple[int, bool]] = field(default_factory=dict)
    m_macros: dict[int, int] = field(default_factory=dict)
    m_subprograms: dict[int, int] = field(default_factory=dict)
    words: dict[str, tuple[int, int]] = field(default_factory=dict)
    nested: bool = False
    modal_every_block: bool = False

    @classmethod
    def of(cls, chosen: NctParameters) -> UserCodes:
        return cls(
            g={tenths_of(abs(code)): (program, code < 0) for program, code in chosen.g.items() if code},
            m_macros={code: program for program, code in chosen.m.items() if program >= 9020},
            m_subprograms={code: program for program, code in chosen.m.items() if program < 9020},
            words={address: call for address, call in WORD_CALLS.items() if _chosen(chosen, address)},
            nested=chosen.fgmac,
            modal_every_block=chosen.modgequ,
        )

    @property
    def any(self) -> bool:
        """There are such codes."""
        return bool(self.g or self.m_macros or self.m_subprograms or self.words)


class MacroCalls:
    """Of one execution. All calls raise LineError at the block in work."""

    def __init__(self, execution: NctExecution, codes: UserCodes) -> None:
        self._x = execution
        self._codes = codes
        self._has_codes = codes.any
        self._modal: list[ModalCall] = []  # of the level that the block in work belongs to

    @property
    def watches(self) -> bool:
        """A block may call something besides what its words say."""
        return self._has_codes or bool(self._x.level.modal_calls)

    def is_macro(self, block: CompiledBlock) -> bool:
        """Whether a block is none of motion and functions: an assignment, a control statement, a macro call (line 7791). Within
        cutter compensation, which looks ahead over such blocks, there are none."""
        if self._x.modal.compensation_side:
            return False
        return block.control is not None or bool(block.assigns) or any(map(self._calls, block.words))

    def _calls(self, word: Word) -> bool:
        value = word.value.constant
        if value is None:
            return False
        if word.address == "G":
            return tenths_of(value) in CALLS or tenths_of(value) in self._codes.g
        return word.address == "M" and round(value) in self._codes.m_macros

    # ------------------------------------------------------------------ calls

    def call(self, program: int, passes: int, arguments: Locals, column: int, code: str = "") -> Frame:
        """A level with local variables of its own."""
        x = self._x
        macros = sum(frame.level is Level.MACRO for frame in x.stack)
        if macros >= MOST_MACROS or len(x.stack) > MOST_LEVELS:
            limit = MOST_MACROS if macros >= MOST_MACROS else MOST_LEVELS
            raise LineError(words_catalogue.LEVEL_EXCESS, column, limit=limit)
        frame = x.levels.enter(program, column, passes, Level.MACRO)
        frame.arguments, frame.locals = arguments, list(arguments)
        frame.called_by = code
        return frame

    def _call_modal(self, call: ModalCall, rest: list[ModalCall], arguments: Locals, column: int) -> None:
        self.call(call.program, call.passes, arguments, column, call.code).modal_calls = rest

    def activate(self, call: ModalCall) -> None:
        """G66, G66.1: from the next block on."""
        self._x.level.modal_calls.append(call)

    def cancel(self) -> None:
        """G67: the last one that was activated; without one nothing happens."""
        if self._x.level.modal_calls:
            self._x.level.modal_calls.pop()

    # ------------------------------------------------------------------ around blocks

    def before(self, words: BlockWords) -> bool:
        """Before anything of a block of words is done. True: it is done with that, as it was a call."""
        x = self._x
        self._modal = modal = x.level.modal_calls
        if self._has_codes and words.all and self._user_code(words):
            return True
        if not modal or not modal[-1].every_block or not words.all or _acts_itself(words):
            return False
        arguments = arguments_of(words, EVERY_BLOCK_ARGUMENTS)
        self._call_modal(modal[-1], modal[:-1], arguments, words.all[0][0].column)
        return True

    def after(self, moved: bool) -> None:
        """Behind each block of words, `moved` if it had a motion."""
        modal = self._modal
        if moved and modal and not modal[-1].every_block:
            self._call_modal(modal[-1], modal[:-1], modal[-1].arguments, 1)

    # ------------------------------------------------------------------ user codes

    def _free(self, code: str) -> bool:
        """Whether a user code makes a call here, and is not what it is without."""
        called_by = [frame.called_by for frame in self._x.stack if frame.called_by]
        return not called_by or (self._codes.nested and code not in called_by)

    def _user_code(self, words: BlockWords) -> bool:
        """Calls of the block; True: it is done with that."""
        codes = self._codes
        for place, (word, value) in enumerate(words.all):
            if value is None:
                continue
            if word.address == "G" and (found := codes.g.get(tenths_of(value))) is not None:
                if self._free(name := f"G{value:g}"):
                    self._g_code(words, word, name, *found)
                    return True
                if tenths_of(value) not in G_CODES:
                    raise LineError(words_catalogue.ILLEGAL_G, word.column, number=f"{value:g}")
            elif word.address == "M" and round(value) in codes.m_macros and self._free(name := f"M{round(value)}"):
                self._m_code(words, word, place, name, codes.m_macros[round(value)])
                return True
        self._subprograms(words)
        return False

    def _g_code(self, words: BlockWords, word: Word, name: str, program: int, modal: bool) -> None:
        arguments = arguments_of(words, CODE_ARGUMENTS, without=word)
        if not modal:
            self.call(program, 1, arguments, word.column, name)
            return
        call = ModalCall(program, 1, arguments, self._codes.modal_every_block, name)
        if call.every_block:
            self._call_modal(call, list(self._modal), arguments, word.column)
        self._modal.append(call)
        self._x.active[Group.MACRO] = tenths_of("66.1" if call.every_block else "66")

    def _m_code(self, words: BlockWords, word: Word, place: int, name: str, program: int) -> None:
        if place > 0:
            raise LineError(catalogue.CODE_NOT_FIRST, word.column, code=name)
        arguments = arguments_of(words, M_ARGUMENTS, without=word, barred="M")
        self.call(program, 1, arguments, word.column, name)

    def _subprograms(self, words: BlockWords) -> None:
        """Codes that call a subprogram when everything else of the block is done, in the order of ORDER."""
        x, codes = self._x, self._codes
        found: list[tuple[str, int, int]] = []  # code, program, column
        for word, value in list(words.all):
            if value is None:
                continue
            name, program, variable = word.address, 0, 0
            if name == "M":
                name, program = f"M{round(value)}", codes.m_subprograms.get(round(value), 0)
            elif name in codes.words:
                program, variable = codes.words[name]
            if not program or not self._free(name):
                continue
            if variable:
                x.variables.write(variable, value)
            words.drop(word)
            found.append((name, program, word.column))
        for name, program, column in sorted(found, key=lambda call: ORDER.index(call[0][0]), reverse=True):

            def enter(name: str = name, program: int = program, column: int = column) -> None:
                x.levels.enter(program, column).called_by = name

            x.actions.append(enter)


def _acts_itself(words: BlockWords) -> bool:
    """A block that is no argument list where all others are: macro calls, and what ends or leaves a program."""
    for word, value in words.all:
        assert value is not None
        if word.address == "G" and tenths_of(value) in CALLS:
            return True
        if word.address == "M" and round(value) in PROGRAM_FLOW:
            return True
    return False


def arguments_of(words: BlockWords, more: str = "", without: Word | None = None, barred: str = "") -> Locals:
    """The words of a block as arguments; `without`: the code that calls. `barred` addresses are none. Raises LineError."""
    given: list[Argument] = []
    for word, value in words.all:
        if word is without:
            continue
        if word.address in barred or (word.address == "G" and any(a.address == "G" for a in given)):
            entry = words_catalogue.ILLEGAL_G if word.address == "G" else catalogue.ARGUMENT_ADDRESS
            raise LineError(entry, word.column, number=f"{value:g}", address=word.address)
        given.append(Argument(word.address, value, word.column))
    try:
        return assigned(given, more)
    except ArgumentError as error:
        raise LineError(error.entry, error.column, **error.values) from None
