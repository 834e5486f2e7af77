"""Tool length compensation G43, G44, G49 with H, and tool offset G45 to G48 with D (manual lines 3310–3474).

Where the block moves a compensated axis, its motion takes the new value up; any other axis stands still and counts anew.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from runtime.cnc.decoder.modal import Motion
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.g_cycles import drilling_axis
from runtime.cnc.decoder.nct.registers import register_value
from runtime.cnc.decoder.nct.registry import GCall, Group, Stage, g_code, word
from runtime.cnc.language.errors import LineError
from runtime.diagnostics.catalogue import nct
from runtime.diagnostics.catalogue import nct_offsets as catalogue


@word(
    "H",
    "nct.tool.compensation-memory-h-d",
    "nct.tool.length-g43-g44-g49",
    meaning="number of the length compensation, H0: none",
)
def length_number(x: NctExecution, value: float, column: int) -> None:
    """The register is read here. While G43 or G44 holds, the axes of its block get the new value; H0 takes it from all axes."""
    used = x.used
    used.h_number = round(value)
    used.length = register_value(x, "H", used.h_number, column)
    selects = any(w.address == "G" and value in (43, 44, 49) for w, value in x.words.all)  # it says for which axes
    if used.length_sign and not selects:
        _compensate(x, range(len(x.setup.axes)) if used.h_number == 0 else used.length_axes)


def _compensate(x: NctExecution, axes: Iterable[int]) -> None:
    """The length of the last H holds in these axes."""
    c, used = x.coordinates, x.used
    changed = [axis for axis in axes if c.length[axis] != used.length_sign * used.length]
    if not changed:
        return
    before = c.numbers.copy()
    for axis in changed:
        c.length[axis] = used.length_sign * used.length + 0.0
    c.update()
    c.recount(axis for axis in changed if axis not in x.axis_words)
    for axis in changed:
        if axis in x.axis_words:
            c.numbers[axis] = before[axis]
    c.keep_numbers()
    x.modal_changed()


def _length(number: str, sign: float, meaning: str) -> None:
    @g_code(number, Group.LENGTH, "nct.tool.length-g43-g44-g49", meaning=meaning, stage=Stage.SET)
    def select(x: NctExecution, call: GCall) -> None:
        used = x.used
        used.length_sign = sign
        if call.modal:
            return
        if not sign:
            used.length, kept = 0.0, used.length
            _compensate(x, range(len(x.setup.axes)))
            used.length = kept
            return
        if x.cycle.mode:  # the drilling axis alone, with its next motion (line 5826)
            used.length_axes = (drilling_axis(x, call.column),)
        elif not x.axis_words:
            raise LineError(catalogue.AXIS_WANTED, call.column, what=call.name)
        else:
            used.length_axes = tuple(x.axis_words)
        _compensate(x, used.length_axes)


_length("43", 1.0, "tool length is added")
_length("44", -1.0, "tool length is subtracted")
_length("49", 0.0, "no tool length")


def _offset(number: int, factor: float, meaning: str) -> None:
    @g_code(str(number), Group.ONE_SHOT, "nct.tool.offset-g45-g48", meaning=meaning, stage=Stage.SET)
    def lengthen(x: NctExecution, call: GCall) -> None:
        """The way of each axis becomes longer or shorter by the value of D, in its direction; that stays in the position. Not in
        drilling cycles (line 5829)."""
        if x.cycle.mode:
            return
        used, c = x.used, x.coordinates
        if used.offset_number not in (0, used.d_number) and any(c.displaced):
            raise LineError(catalogue.OFFSET_ERRONEOUS, call.column, number=used.d_number, other=used.offset_number)
        if x.modal.motion not in (Motion.RAPID, Motion.LINEAR):
            raise LineError(nct.NOT_SUPPORTED, call.column, what=f"{call.name} with an arc")
        if x.modal.compensation_side:
            raise LineError(catalogue.OFFSET_BESIDE, call.column, name=call.name)
        if not x.axis_words:
            raise LineError(catalogue.AXIS_WANTED, call.column, what=call.name)
        if c.rotation is not None:
            raise LineError(nct.NOT_SUPPORTED, call.column, what=f"{call.name} with G68")
        used.offset_number = used.d_number
        for word_, _ in x.words.all:
            if word_.address not in x.axis_of:
                continue
            axis = x.axis_of[word_.address]
            value = x.axis_value(axis, x.axis_words[axis])
            relative = x.incremental_words[axis]
            way = value if relative else value - c.numbers[axis]
            if way == 0.0 and not relative:
                continue  # it has no direction
            direction = math.copysign(1.0, way) if way else -1.0 if word_.signed else 1.0
            c.displaced[axis] += factor * direction * x.vectors.radius * c.mirror(axis)
        c.update()
        c.keep_numbers()
        x.modal_changed()


_offset(45, 1.0, "the way is longer by the value of D")
_offset(46, -1.0, "the way is shorter by the value of D")
_offset(47, 2.0, "the way is longer by twice the value of D")
_offset(48, -2.0, "the way is shorter by twice the value of D")
