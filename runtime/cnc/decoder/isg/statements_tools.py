"""#TLAX: the axis of the tool length; #TOOL: tools by basic, sister and variant number (18602–18666, 29358–29424)."""

from __future__ import annotations

from runtime.cnc.blocks import Synch, Technology, TechnologyFunction
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.decoder.technology import Functions
from runtime.cnc.decoder.tool_management import announce_outside, ready
from runtime.cnc.decoder.tool_words import move_at_once, select, select_id
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.syntax import Form
from runtime.cnc.tools.tool import GREATEST_NUMBER, ToolId
from runtime.diagnostics.catalogue import tools as catalogue

_MAIN_AXES = 3


@statement("TLAX", "isg.tool.tlax", syntax="#TLAX [<axis>+|-]", form=Form.DIRECTION, modal=True)
def assign_length(x: Execution, call: StatementCall) -> None:
    """The length acts in this main axis in every plane, with + as with G17 in Z."""
    argument, _ = next(iter(call))
    if argument.index >= _MAIN_AXES:
        names = ", ".join(x.setup.axes[:_MAIN_AXES])
        raise call.error(catalogue.LENGTH_AXIS, axis=x.setup.axes[argument.index], axes=names)
    x.tools.assign_length(argument.index, -1.0 if argument.text == "-" else 1.0)


@statement("TLAX DEFAULT", "isg.tool.tlax", modal=True)
def assign_length_by_plane(x: Execution, call: StatementCall) -> None:
    x.tools.assign_length(-1, 1.0)


def tool_id(call: StatementCall) -> ToolId:
    """Basic, sister and variant number; an empty place is 0. LineError without a basic number."""
    parts = [0, 0, 0]
    given = 0
    for argument, value in call:
        if argument.index >= len(parts):
            raise call.error(catalogue.ID_PARTS)
        if value is None or not -0.5 <= value < GREATEST_NUMBER + 0.5:
            raise call.error(catalogue.NUMBER_INVALID, word=f"#{call.syntax.name} ", value=value, limit=GREATEST_NUMBER)
        parts[argument.index] = round_half_up(value)
        given |= 1 << argument.index
    if not given & 1:
        raise call.error(catalogue.ID_PARTS)
    return ToolId(*parts)


@statement(
    "TOOL PREP",
    "isg.toolext.tool-data-prep",
    syntax="#TOOL PREP [<basic>[,<sister>[,<variant>]]]",
    form=Form.PLACES,
    modal=True,
)
def prepare(x: Execution, call: StatementCall) -> None:
    """The same as T: the PLC gets to know which tool comes next."""
    tool = tool_id(call)
    x.tools.id = tool
    announce_outside(x, tool)
    if x.setup.tool_synch != Synch.NO_SYNCH:
        functions = Functions(x.source)
        functions.add(TechnologyFunction(x.source, Technology.T, tool.basic, 0.0, x.setup.tool_synch))
        for block in (*functions.leading(), *functions.trailing()):
            x.emit(block)


@statement(
    "TOOL DATA",
    "isg.toolext.tool-data-prep",
    syntax="#TOOL DATA [<basic>[,<sister>[,<variant>]]]",
    form=Form.PLACES,
    modal=True,
)
def request(x: Execution, call: StatementCall) -> None:
    """The same as D: the data of the tool hold from here on."""
    tool = tool_id(call)
    if (x.setup.tools.external or x.setup.tools.wait_at_d) and not ready(x, tool, call.column):
        return
    if tool == ToolId():
        select(x, 0, call.column)
    else:
        select_id(x, tool, call.column)
    x.tools.id = tool


@statement("TOOL REFRESH", "isg.toolext.tool-refresh")
def refresh(x: Execution, call: StatementCall) -> None:
    """The data of the active tool, as they are, are brought into the offsets once more."""
    move_at_once(x, x.tools.include())
