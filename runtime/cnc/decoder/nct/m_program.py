"""The M codes that control the program: stops, end, subprograms, jumps (manual lines 2861–2878, 2951–3170)."""

from __future__ import annotations

from runtime.cnc.blocks import Block, Technology
from runtime.cnc.decoder.block_functions import Functions, put_out
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.frames import Level
from runtime.cnc.decoder.nct.registry import m_code
from runtime.cnc.language.errors import LineError
from runtime.diagnostics.catalogue import nct as catalogue

MOST_PROGRAM = 9999
MOST_PASSES = 9999
MOST_BLOCK = 99_999


@m_code(0, "nct.mh.program-control-m00-m30", meaning="programmed stop")
def stop(x: NctExecution, number: int, column: int) -> None:
    """The stop itself stands in the stream, at the end of the block."""


@m_code(1, "nct.mh.program-control-m00-m30", meaning="conditional stop")
def optional_stop(x: NctExecution, number: int, column: int) -> None:
    """As M00, while the operator has it switched on."""


@m_code(2, "nct.mh.program-control-m00-m30", meaning="end of the program")
def end(x: NctExecution, number: int, column: int) -> None:
    """M02: everything of the block is done, then the function is put out, then nothing comes."""
    x.actions.append(lambda: x.levels.finish(_held(x, number, column)))


@m_code(30, "nct.mh.program-control-m00-m30", meaning="end of the program")
def end_and_rewind(x: NctExecution, number: int, column: int) -> None:
    """M30 does what M02 does."""
    end(x, number, column)


def _held(x: NctExecution, number: int, column: int) -> list[Block]:
    functions = Functions(x.source)
    if number in x.memory.m_synch:
        put_out(x, functions, Technology.M, number, 0.0, column)
    return [*functions.leading(), *functions.trailing()]


@m_code(98, "nct.sub.call-m98", meaning="call of a subprogram: M98 P<program> L<passes>", takes="PL")
def call(x: NctExecution, number: int, column: int) -> None:
    """The program P runs L times, then the block behind the call comes."""
    program = x.words.number("P")
    if program is None or program != int(program) or not 1 <= program <= MOST_PROGRAM:
        raise LineError(catalogue.FAULTY_P, x.words.place("P") if program is not None else column)
    passes = x.words.number("L")
    if passes is not None and not 1 <= passes <= MOST_PASSES:
        raise LineError(catalogue.FAULTY_L, x.words.place("L"), value=passes, least=1)
    place = x.words.place("P")

    def enter() -> None:
        x.levels.enter(int(program), place, int(passes or 1))

    x.actions.append(enter)


@m_code(
    99,
    "nct.sub.return-m99",
    "nct.sub.main-jump-m99",
    meaning="return, or jump in the main program: M99 P<block> L<passes>",
    takes="PL",
)
def back(x: NctExecution, number: int, column: int) -> None:
    """In a subprogram back behind the call, or to the block P of the caller; in the main program to its start, or to the block P.

    L: the program runs L times more in all, whatever the call said. P counts when it has run for the last time.
    """
    block = x.words.number("P")
    place = x.words.place("P")
    if block is not None and (block != int(block) or not 1 <= block <= MOST_BLOCK):
        raise LineError(catalogue.FAULTY_P, place)
    further = x.words.number("L")
    if further is not None and not 0 <= further <= MOST_PASSES:
        raise LineError(catalogue.FAULTY_L, x.words.place("L"), value=further, least=0)
    target = None if block is None else int(block)
    passes = None if further is None else int(further) + 1

    def act() -> None:
        if x.level.level is not Level.MAIN:
            x.levels.leave(target, passes, place)
        elif target is None:
            x.levels.restart()
        else:
            x.levels.jump(x.level, target, place)

    x.actions.append(act)
