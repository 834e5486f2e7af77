"""An external tool management: the decoder asks it for tools, and waits for the answer (004, lines 2586–2647; 000, 6896–6902).

A block that needs a tool is executed again until the answer is there; its values are computed once. What the program has changed
of the free values of a tool goes back when another tool, or none, is selected.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from runtime.cnc.blocks import Flush, FlushKind, LifeCommand, ToolLifeAction
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.outside import WaitForOutside
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock, Values
from runtime.cnc.language.isg.words import WordKind
from runtime.cnc.tools.tool import FIELDS, FieldError, Tool, ToolId
from runtime.diagnostics.catalogue import tools as catalogue
from runtime.diagnostics.errors import ErrorEntry
from runtime.hli.tools import Identity, ManagedTool, RequestKind, ToolAnswered

_NOBODY = ToolId()


@dataclass(slots=True)
class ToolWait:
    """What a block that waits for its tool keeps: its values, if its `block` is given, and how far it has come."""

    block: CompiledBlock | None
    values: Values
    flushed: bool = False
    told: bool = False  # the management knows of T, and of the changes of the tool before
    request: int = -1
    since: int = 0  # cycle of the request


def announce_outside(x: Execution, tool: ToolId) -> None:
    """T: the management may prepare the magazine (P-CHAN-00087), and the path goes on meanwhile (P-CHAN-00106)."""
    setup = x.setup.tools
    x.tools.known.clear()
    if not setup.external:
        return
    life_changes(x, tool, by_data=False)
    if setup.flush_at_t:
        x.emit(Flush(x.source, FlushKind.CONTINUE))
    if setup.announce:
        x.outside.ask_tool(RequestKind.PREPARE, _identity(tool))


def ready(x: Execution, wanted: ToolId, column: int, values: Values | None = None) -> bool:
    """Whether the tool of a D word, or none, is at hand; if it is not, the block is to be executed once more, with `values` if
    they are given."""
    setup = x.setup.tools
    wait = x.waiting if isinstance(x.waiting, ToolWait) else ToolWait(None if values is None else x.block, values or ())
    x.waiting = wait
    if setup.wait_at_d and not wait.flushed:
        wait.flushed = True
        x.emit(Flush(x.source, FlushKind.WAIT))
        x.repeat("the path before the D word")
        if x.again is not None:
            return False
    if setup.external:
        if not wait.told:
            wait.told = True
            give_back(x)
        if wanted != ToolId() and not _fetched(x, wait, wanted, column):
            return False
    x.waiting = None
    return True


def give_back(x: Execution) -> None:
    """The free values of the active tool, as the program has left them, go back to the management."""
    x.tools.known.clear()
    if x.tools.active.number and not x.outside.waits_in_vain():
        x.outside.ask_tool(RequestKind.SAVE, _identity(x.tools.active.id), x.tools.active.parameters)


def begin_with_tools(x: Execution) -> None:
    """A program starts: the free values of the tool that the one before has left go back (P-CHAN-00103)."""
    tell_life(x, LifeCommand.WEIGHT, time=x.memory.life_factors[0], distance=x.memory.life_factors[1])
    left, x.memory.tool_left = x.memory.tool_left, None
    if left is not None and x.setup.tools.external and x.setup.tools.save_at_start:
        x.outside.ask_tool(RequestKind.SAVE, _identity(left.id), left.parameters)


def _fetched(x: Execution, wait: ToolWait, wanted: ToolId, column: int) -> bool:
    if x.outside.waits_in_vain():
        x.tools.fetched = _assumed(x, wanted, column)
        return True
    if wait.request < 0:
        if not x.outside.has_tool_management():
            raise LineError(catalogue.MANAGEMENT_ABSENT, column, tool=wanted)
        wait.request, wait.since = x.outside.ask_tool(RequestKind.DATA, _identity(wanted)), x.outside.cycle()
    answer = x.outside.tool_answered(wait.request)
    if answer is None:
        if x.outside.cycle() - wait.since > x.setup.tools.answer_cycles:
            raise LineError(catalogue.MANAGEMENT_LATE, column, tool=wanted)
        x.repeat("the tool management")
        return False
    tool = _accepted(answer, wanted)
    if not isinstance(tool, Tool):
        raise LineError(tool[0], column, **tool[1])
    x.tools.fetched = tool
    return True


def _assumed(x: Execution, wanted: ToolId, column: int) -> Tool:
    """Without a machine: the tool of the machine's own table, else one without dimensions, and a warning that says so."""
    tool = x.memory.tools.get(wanted.basic)
    if tool is None:
        x.warn(catalogue.MANAGEMENT_UNKNOWN, column, tool=wanted)
    return tool or Tool(wanted.basic)


def _accepted(answer: ToolAnswered, wanted: ToolId) -> Tool | tuple[ErrorEntry, dict[str, object]]:
    """The tool of an answer, or why it cannot be taken."""
    if answer.tool is None:
        return catalogue.MANAGEMENT_REFUSED, {"tool": wanted, "reason": answer.reason}
    if answer.tool.id.basic != wanted.basic:
        return catalogue.MANAGEMENT_OTHER, {"tool": wanted, "other": answer.tool.id.basic}
    try:
        return _tool(answer.tool)
    except FieldError as error:
        return error.entry, error.values


def _tool(managed: ManagedTool) -> Tool:
    """The record of a managed tool. FieldError for a value that no tool can have."""
    tool = Tool(managed.id.basic)
    given: dict[str, Any] = {
        name: getattr(managed, name)
        for name in FIELDS
        if name not in ("name", "wear_constant", "basic", "sister", "sister_valid", "variant", "variant_valid")
    }
    given |= {"sister": managed.id.sister, "sister_valid": managed.id.sister != 0}
    given |= {"variant": managed.id.variant, "variant_valid": managed.id.variant != 0}
    for name, value in given.items():
        if not FIELDS[name].count:
            tool = tool.with_value(name, value)
            continue
        for index, element in enumerate(value):
            if element != 0.0:
                tool = tool.with_value(name, element, index)
    return tool


def _identity(tool: ToolId) -> Identity:
    return Identity(tool.basic, tool.sister, tool.variant)


# ---------------------------------------------------------------------------------------------------- tool life


def tell_life(
    x: Execution, command: LifeCommand, tool: ToolId = _NOBODY, *, time: float = 0.0, distance: float = 0.0
) -> None:
    """An action of tool life, if somebody wants to know (P-CHAN-00016, P-CHAN-00076)."""
    setup = x.setup.tools
    if setup.external and setup.tell_life:
        source = x.source_in_work()
        x.emit(ToolLifeAction(source, command, tool.basic, tool.sister, tool.variant, time, distance))


def life_changes(x: Execution, tool: ToolId, *, by_data: bool) -> None:
    """Another tool comes by T, or by its data (P-CHAN-00482): its record begins."""
    if by_data is x.setup.tools.life_with_d:
        tell_life(x, LifeCommand.CHANGE, tool)


# ---------------------------------------------------------------------------------------------------- V.G.WZ[j]


def read_outside(x: Execution, number: int, name: str) -> Tool:
    """A tool for V.G.WZ[j], asked for once and kept until the next T or D word.

    Raises WaitForOutside while the answer is not there: the block is computed again from its beginning then, so it may hold no
    second assignment, which would be executed twice. CalculationError for what goes wrong.
    """
    known = x.tools.known.get(number)
    if isinstance(known, Tool):
        return known
    if x.outside.waits_in_vain():
        return x.memory.tools.get(number) or Tool(number)
    wanted = ToolId(number)
    if known is None:
        assert x.block is not None
        if sum(word.kind is WordKind.ASSIGNMENT for word in x.block.words) > 1:
            raise CalculationError(catalogue.MANAGEMENT_ALONE, name)
        if not x.outside.has_tool_management():
            raise CalculationError(catalogue.MANAGEMENT_ABSENT, name, tool=wanted)
        request, since = x.outside.ask_tool(RequestKind.DATA, _identity(wanted)), x.outside.cycle()
        known = x.tools.known[number] = (request, since)
    answer = x.outside.tool_answered(known[0])
    if answer is None:
        if x.outside.cycle() - known[1] > x.setup.tools.answer_cycles:
            raise CalculationError(catalogue.MANAGEMENT_LATE, name, tool=wanted)
        raise WaitForOutside("the tool management")
    tool = _accepted(answer, wanted)
    if not isinstance(tool, Tool):
        raise CalculationError(tool[0], name, **tool[1])
    x.tools.known[number] = tool
    return tool
