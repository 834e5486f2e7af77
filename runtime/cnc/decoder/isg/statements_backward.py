"""# statements for backward and simulated motion on the path (programming manual lines 16725–16906)."""

from __future__ import annotations

import numpy as np

from runtime.cnc.blocks import ClearStorage, Flush, FlushKind, OptionalSection
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.decoder.radius_compensation import expect_none
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import language as catalogue

_SAME_PLACE = 1e-6  # mm, degrees
_GREATEST_MASK = 2**63 - 1


@statement(
    "OPTIONAL EXECUTION ON",
    "isg.add.optional-execution",
    syntax="#OPTIONAL EXECUTION ON [[SIMULATE [MASK=..]]]",
    form=Form.KEYS,
    keys=(Key("SIMULATE", KeyKind.FLAG), Key("MASK")),
    optional=True,
)
def section_begins(x: Execution, call: StatementCall) -> None:
    """Sections do not nest: the first ON counts."""
    mask = call.number("MASK")
    if mask is not None and (not call.given("SIMULATE") or not 0 <= mask <= _GREATEST_MASK):
        raise call.error(catalogue.SECTION_MASK, "MASK")
    if x.frame.optional is not None:
        return
    expect_none(x, "#OPTIONAL EXECUTION", 1)
    x.emit(Flush(x.source, FlushKind.CONTINUE))  # no smoothed corner lies half in the section
    x.frame.optional = list(x.coordinates.position)
    number = None if mask is None else round_half_up(mask)
    x.emit(OptionalSection(x.source, True, call.given("SIMULATE"), number))


@statement("OPTIONAL EXECUTION OFF", "isg.add.optional-execution")
def section_ends(x: Execution, call: StatementCall) -> None:
    begin = x.frame.optional
    if begin is None:
        return
    expect_none(x, "#OPTIONAL EXECUTION", 1)
    x.frame.optional = None
    way = np.abs(np.array(begin) - np.array(x.coordinates.position))
    if way.max() > _SAME_PLACE:
        axis = int(np.argmax(way))
        values = {"axis": x.setup.axes[axis], "begin": begin[axis], "end": x.coordinates.position[axis]}
        raise call.error(catalogue.SECTION_MOVES, "", **values)
    x.emit(Flush(x.source, FlushKind.CONTINUE))
    x.emit(OptionalSection(x.source, False))


@statement("BACKWARD STORAGE CLEAR", "isg.add.backward-storage-clear")
def clear_storage(x: Execution, call: StatementCall) -> None:
    x.emit(ClearStorage(x.source))
