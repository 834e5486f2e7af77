"""# statements for backward and simulated motion on the path (programming manual lines 16725–16906)."""

from __future__ import annotations

import numpy as np

from runtime.cnc.blocks import ClearStorage, Flush, FlushKind, OptionalSection, StopMark
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.decoder.radius_compensation import expect_none
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.catalogue import smoothing

_SAME_PLACE = 1e-6  # mm, degrees
_GREATEST_MASK = 2**63 - 1
_HALF = 0.5


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
    x.frame.optional = x.coordinates.machine()
    number = None if mask is None else round_half_up(mask)
    x.emit(OptionalSection(x.source, True, call.given("SIMULATE"), number))


@statement("OPTIONAL EXECUTION OFF", "isg.add.optional-execution")
def section_ends(x: Execution, call: StatementCall) -> None:
    begin = x.frame.optional
    if begin is None:
        return
    expect_none(x, "#OPTIONAL EXECUTION", 1)
    x.frame.optional = None
    here = x.coordinates.machine()
    way = np.abs(np.array(begin) - np.array(here))
    if way.max() > _SAME_PLACE:
        axis = int(np.argmax(way))
        values = {"axis": x.setup.axes[axis], "begin": begin[axis], "end": here[axis]}
        raise call.error(catalogue.SECTION_MOVES, "", **values)
    x.emit(Flush(x.source, FlushKind.CONTINUE))
    x.emit(OptionalSection(x.source, False))


@statement("BACKWARD STORAGE CLEAR", "isg.add.backward-storage-clear")
def clear_storage(x: Execution, call: StatementCall) -> None:
    x.emit(ClearStorage(x.source))


_GREATEST = 2**32 - 1


def _whole(call: StatementCall, key: str) -> int:
    value = call.number(key)
    if value is not None and not 0 <= value <= _GREATEST:
        raise call.error(smoothing.VALUE_RANGE, key, key=key, value=value, least=0, most=_GREATEST)
    return 0 if value is None else round_half_up(value)


@statement(
    "STOP REVERSIBLE",
    "chan.fwbw.stop-marks",
    "hli.ch.cu.stop-level",
    syntax="#STOP REVERSIBLE [[LEVEL=.. 1ST_FORWARD=.. 2ND_FORWARD=.. BACKWARD=.. USR_VAL=..]]",
    form=Form.KEYS,
    keys=(Key("LEVEL"), Key("1ST_FORWARD"), Key("2ND_FORWARD"), Key("BACKWARD"), Key("USR_VAL")),
    optional=True,
)
def stop_mark(x: Execution, call: StatementCall) -> None:
    """0 suppresses the stop in a way of driving; what is not said comes from the channel."""
    ways = []
    for key, usual in zip(("1ST_FORWARD", "2ND_FORWARD", "BACKWARD"), x.setup.stop_marks, strict=True):
        value = call.number(key)
        ways.append(usual if value is None else value > _HALF)
    x.emit(StopMark(x.source, _whole(call, "LEVEL"), ways[0], ways[1], ways[2], _whole(call, "USR_VAL")))
