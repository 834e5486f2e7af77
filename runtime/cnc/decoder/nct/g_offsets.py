"""Coordinate systems and their offsets: G53, G54 to G59, G10, G92, G52 (manual lines 2260–2478, 3289–3307).

A change of the system moves nothing: the position counts anew in it. Within cutter compensation it takes the vector away at the
end of the motion in front, and the next motion brings it back.
"""

from __future__ import annotations

import math

import numpy as np

from runtime.cnc.blocks import Line, VectorOrder
from runtime.cnc.decoder.modal import PLANE_AXES
from runtime.cnc.decoder.modulo import modulo_end
from runtime.cnc.decoder.motion import expect_in_range, pcs_gain, programmed_at
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.registers import write_register
from runtime.cnc.decoder.nct.registry import GCall, Group, Stage, g_code
from runtime.cnc.decoder.selection import select_zero_offset
from runtime.cnc.language.errors import LineError
from runtime.cnc.tools.offset_table import COMMON, GREATEST_REGISTER, OffsetTableError
from runtime.diagnostics.catalogue import nct
from runtime.diagnostics.catalogue import nct_offsets as catalogue

WORK_SYSTEMS = 6
_REGISTERS = {10: ("H", False), 11: ("H", True), 12: ("D", False), 13: ("D", True)}  # L → kind, wear


def shortest(x: NctExecution, end: list[float]) -> list[float]:
    """A machine position to which axes that turn without end go the shorter way."""
    now = x.coordinates.position
    ranges = x.modulo.ranges
    return [modulo_end(now[i], place, x.modulo.size(i), 0) if i in ranges else place for i, place in enumerate(end)]


def rapid_to(x: NctExecution, end: list[float]) -> None:
    """A straight move in rapid traverse to a machine position."""
    expect_in_range(x, x.words, end)
    start, programmed = x.take_path_start(), np.array(programmed_at(x, end))
    plane = PLANE_AXES[x.modal.plane]
    x.emit(Line(x.source, np.array(start), np.array(end), math.inf, True, programmed, plane, pcs_gain=pcs_gain(x)))
    x.coordinates.moved(end)


def expect_alone(x: NctExecution, addresses: str) -> None:
    """LineError for a word beside a code that stands alone with these addresses, and for a second G code."""
    codes = 0
    for word, _ in x.words.all:
        codes += word.address == "G"
        if word.address not in addresses or codes > 1:
            raise LineError(nct.WORD_WITHOUT_MEANING, word.column, address=word.address)


def suspended(x: NctExecution) -> None:
    """The system changes: the vector of cutter compensation goes and comes again."""
    x.vectors.order(VectorOrder.SUSPEND, VectorOrder.RESUME)


def _work_system(number: int) -> None:
    @g_code(
        str(number),
        Group.WORK_OFFSET,
        "nct.coord.work-g54-g59",
        "nct.trc.suspension",
        meaning=f"work coordinate system {number - 53}",
        stage=Stage.SET,
    )
    def select(x: NctExecution, call: GCall) -> None:
        suspended(x)
        select_zero_offset(x, number - 53)
        x.coordinates.recount()
        x.modal_changed()


for _number in range(54, 54 + WORK_SYSTEMS):
    _work_system(_number)


@g_code(
    "53", Group.ONE_SHOT, "nct.coord.machine-g53", "nct.trc.suspension", meaning="positioning in machine coordinates",
    stage=Stage.MOVE, axes=True,
)  # fmt: skip
def machine_coordinates(x: NctExecution, call: GCall) -> None:
    """In rapid traverse, absolute whatever G91 and I say; the tool length is taken into account."""
    words = x.axes()
    if not words:
        return
    end = x.coordinates.position.copy()
    for axis, value in words.items():
        end[axis] = value + x.coordinates.length[axis]
    x.vectors.tell(x, VectorOrder.SUSPEND)
    rapid_to(x, shortest(x, end))
    x.vectors.tell(x, VectorOrder.RESUME)
    x.modal_changed()


@g_code(
    "10", Group.ONE_SHOT, "nct.coord.set-offset-g10-l2", "nct.tool.set-compensation-g10",
    meaning="set work offsets (L2) or compensation registers (L10 to L13)", stage=Stage.SET, takes="LPR", axes=True,
)  # fmt: skip
def set_data(x: NctExecution, call: GCall) -> None:
    kind = x.words.number("L")
    number = x.words.number("P")
    place = x.words.place("P") if number is not None else call.column
    if kind == 2:
        if number is None or number not in range(WORK_SYSTEMS + 1):
            raise LineError(nct.FAULTY_P, place)
        _set_work_offsets(x, call, round(number))
    elif kind in _REGISTERS:
        if number is None or number != int(number) or not 1 <= number <= GREATEST_REGISTER:
            raise LineError(nct.FAULTY_P, place)
        register, wear = _REGISTERS[round(kind)]
        value = x.words.needed("R", catalogue.VALUE_MISSING, call.column, word="R", what="G10")
        added = x.modal.incremental or x.words.incremental("R")
        column = x.words.place("R")
        write_register(x, register, round(number), x.length(value), wear=wear, added=added, column=column)
    else:
        raise LineError(catalogue.SETTING_UNKNOWN, x.words.place("L") if kind is not None else call.column)


def _set_work_offsets(x: NctExecution, call: GCall, number: int) -> None:
    """The offsets are absolute, whatever G91 says. One that is active acts at once; the position counts anew."""
    words = x.axes()
    if not words:
        raise LineError(catalogue.AXIS_WANTED, call.column, what="G10 L2")
    try:
        for axis, value in words.items():
            x.memory.set_work_offset(COMMON if number == 0 else number, axis, value)
    except OffsetTableError as error:
        raise LineError(error.problem.entry, call.column, **error.problem.values) from None
    offset_changed(x, number)


def offset_changed(x: NctExecution, number: int) -> None:
    """The offset of a work system, 1 for G54, or of all (0) is another one: if it is active it acts at once."""
    if number in (0, x.modal.zero_offset):
        suspended(x)
        x.coordinates.common = [float(offset) for offset in x.memory.common_offset]
        select_zero_offset(x, x.modal.zero_offset)
        x.coordinates.recount()
        x.modal_changed()


@g_code(
    "92", Group.ONE_SHOT, "nct.coord.shift-g92", "nct.trc.suspension", meaning="the position counts as the words say",
    stage=Stage.SET, axes=True,
)  # fmt: skip
def new_system(x: NctExecution, call: GCall) -> None:
    """The shift acts in all work systems; it takes a local shift of its axes away."""
    limit = x.words.number("S")
    if limit is not None:
        x.surface.take_limit(limit, x.words.place("S"))
        x.speed_taken = True
    words = x.axes()
    if not words and limit is not None:
        return
    if not words:
        raise LineError(catalogue.AXIS_WANTED, call.column, what="G92")
    c = x.coordinates
    suspended(x)
    for axis in words:
        c.local[axis] = 0.0
    c.update()
    c.recount()
    wanted = [words.get(axis, number) for axis, number in enumerate(c.numbers)]
    expected = c.machine_of(wanted)
    c.shifted = [old + place - other for old, place, other in zip(c.shifted, c.position, expected, strict=True)]
    c.update()
    c.numbers = wanted
    x.modal_changed()


@g_code(
    "52", Group.ONE_SHOT, "nct.coord.local-g52", "nct.trc.suspension", meaning="local coordinate system",
    stage=Stage.SET, axes=True,
)  # fmt: skip
def local_system(x: NctExecution, call: GCall) -> None:
    """Its origin in the work system; incremental words shift the one that there is."""
    words = x.axes()
    if not words:
        raise LineError(catalogue.AXIS_WANTED, call.column, what="G52")
    suspended(x)
    for axis, value in words.items():
        relative = x.incremental_words[axis]
        x.coordinates.local[axis] = x.coordinates.local[axis] + value if relative else value
    x.coordinates.update()
    x.coordinates.recount()
    x.modal_changed()
