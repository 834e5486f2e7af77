"""T and D of a block, and the tool data that a program changes: selection, checks, the motion of a D word that moves at once."""

from __future__ import annotations

import numpy as np

from runtime.cnc.blocks import Line
from runtime.cnc.decoder import additions
from runtime.cnc.decoder.couplings import expect_no_slave
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.feed import feed_of, require_feed
from runtime.cnc.decoder.independent import wait_before_motion
from runtime.cnc.decoder.modal import PLANE_AXES, Motion
from runtime.cnc.decoder.motion import expect_in_range, pcs_gain, programmed_at
from runtime.cnc.decoder.tool_management import ToolWait, announce_outside, life_changes, ready
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock, Values
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.words import WordKind
from runtime.cnc.tools.table import ToolTableError
from runtime.cnc.tools.tool import GREATEST_NUMBER, NO_TOOL, Tool, ToolId
from runtime.diagnostics.catalogue import language
from runtime.diagnostics.catalogue import tools as catalogue


def tools_ready(x: Execution, block: CompiledBlock, values: Values) -> bool:
    """Before anything of the block is done: whether the tool that it selects is at hand; else it is executed once more."""
    if block.tool < 0 and block.tool_data < 0:
        return True
    if block.tool >= 0 and not isinstance(x.waiting, ToolWait):
        announce_outside(x, ToolId(_position(values[block.tool], block.column(WordKind.TOOL))))
    number = data_number(x, block, values)
    if number is None or not (x.setup.tools.external or x.setup.tools.wait_at_d):
        return True
    column = block.column(WordKind.TOOL_DATA if block.tool_data >= 0 else WordKind.TOOL)
    return ready(x, ToolId(number), column, values)


def tool_words(x: Execution, block: CompiledBlock, values: Values) -> None:
    """T and D of the block. LineError for what cannot be selected."""
    if block.tool >= 0:
        x.tools.id = ToolId(_position(values[block.tool], block.column(WordKind.TOOL)))
    number = data_number(x, block, values)
    if number is not None:
        column = block.column(WordKind.TOOL_DATA if block.tool_data >= 0 else WordKind.TOOL)
        select(x, number, column)


def data_number(x: Execution, block: CompiledBlock, values: Values) -> int | None:
    """The number of the D word, or of the T word that stands for it (P-CHAN-00014); None without one."""
    if block.tool_data >= 0:
        value = values[block.tool_data]
        if not -0.5 <= value < GREATEST_NUMBER + 0.5:
            column = block.column(WordKind.TOOL_DATA)
            raise LineError(catalogue.NUMBER_INVALID, column, word="D", value=value, limit=GREATEST_NUMBER)
        return round_half_up(value)
    if block.tool >= 0 and x.setup.tools.implicit_d:
        return _position(values[block.tool], block.column(WordKind.TOOL))
    return None


def _position(value: float, column: int) -> int:
    """The number of a T word."""
    if value < 0:
        raise LineError(language.FUNCTION_NEGATIVE, column, value=value, address="T")
    if not value < GREATEST_NUMBER + 0.5:
        raise LineError(catalogue.NUMBER_INVALID, column, word="T", value=value, limit=GREATEST_NUMBER)
    return round_half_up(value)


def select(x: Execution, number: int, column: int) -> None:
    """D: the data of a tool hold from here on; 0: those of none."""
    _use(x, NO_TOOL if number == 0 else fetched(x, number, column), column)


def select_id(x: Execution, wanted: ToolId, column: int) -> None:
    """#TOOL DATA: as `select`, of the tool with this identity; without sister and variant it is that of the number."""
    if wanted == ToolId(wanted.basic) or x.setup.tools.external:
        select(x, wanted.basic, column)
        return
    try:
        tool = next((tool for tool in x.memory.tools.all() if tool.id == wanted), None)
    except ToolTableError as error:
        raise LineError(error.problem.entry, column, **error.problem.values) from None
    if tool is None:
        raise LineError(catalogue.TOOL_MISSING, column, number=wanted)
    _use(x, tool, column)


def _use(x: Execution, tool: Tool, column: int) -> None:
    _expect_usable(x, tool, column)
    life_changes(x, tool.id, by_data=True)
    move_at_once(x, x.tools.use(tool))


def fetched(x: Execution, number: int, column: int) -> Tool:
    """The tool that the external management has given, else that of the table. LineError if there is none."""
    if x.setup.tools.external:
        given, x.tools.fetched = x.tools.fetched, None
        assert given is not None  # the block was not executed before it was there
        return given
    try:
        tool = x.memory.tools.get(number)
    except ToolTableError as error:
        raise LineError(error.problem.entry, column, **error.problem.values) from None
    if tool is None:
        raise LineError(catalogue.TOOL_MISSING, column, number=number)
    return tool


def _expect_usable(x: Execution, tool: Tool, column: int) -> None:
    """A tool that is selected is valid, and not smaller than the channel allows (P-CHAN-00156, P-CHAN-00157)."""
    if tool is NO_TOOL:
        return
    setup = x.setup.tools
    if not tool.valid:
        raise LineError(catalogue.TOOL_INVALID, column, number=tool.number)
    if setup.minimum_length and tool.length < setup.minimum_length:
        minimum = setup.minimum_length
        raise LineError(catalogue.LENGTH_MINIMUM, column, number=tool.number, length=tool.length, minimum=minimum)
    if setup.minimum_radius and tool.radius < setup.minimum_radius:
        minimum = setup.minimum_radius
        raise LineError(catalogue.RADIUS_MINIMUM, column, number=tool.number, radius=tool.radius, minimum=minimum)


def move_at_once(x: Execution, ways: dict[int, float]) -> None:
    """The motion of a D word with P-CHAN-00100: straight, by the change of the offsets, in front of the motion of its block.

    It is rapid with G00, else it has the feed.
    """
    block = x.block
    if not ways or not x.setup.tools.direct_offsets or block is None:
        return
    additions.expect_no_line(x)
    start, end = x.take_path_start(), x.coordinates.position.copy()
    if x.coordinates.frame is not None:  # they are ways of the machine axes
        end = x.coordinates.machine()
    for axis, way in ways.items():
        end[axis] += way
    if x.coordinates.frame is not None:
        end = x.coordinates.of_machine(end)
    expect_in_range(x, block, end)
    expect_no_slave(x, ways, block.column(WordKind.TOOL_DATA))
    wait_before_motion(x, end)
    rapid = x.modal.motion is Motion.RAPID
    if not rapid:
        require_feed(x, block)
    feed = np.inf if rapid else feed_of(x, block, start, end, None)
    programmed = np.array(programmed_at(x, end))
    plane = PLANE_AXES[x.modal.plane]
    x.emit(
        Line(x.source_in_work(), np.array(start), np.array(end), feed, rapid, programmed, plane, pcs_gain=pcs_gain(x))
    )
    x.coordinates.moved(end)
    x.tools.moved = True
