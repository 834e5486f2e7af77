"""# statements that make and remove variables and macros."""

from __future__ import annotations

import re

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.frames import Frame
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.decoder.user_variables import Scope
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.syntax import Form
from runtime.diagnostics.catalogue import language as catalogue

_USER = re.compile(r"V\.(P|S|L|CYC)\.([^\[\]]+)$")


@statement("VAR", "isg.param.arrays", "isg.var.user-declaration", syntax="#VAR … #ENDVAR")
def begin_declarations(x: Execution, call: StatementCall) -> None:
    x.declaring = True


@statement("ENDVAR", "isg.param.arrays", "isg.var.user-declaration")
def end_declarations(x: Execution, call: StatementCall) -> None:
    x.declaring = False


@statement(
    "DELETE",
    "isg.param.delete-exist-sizeof",
    "isg.var.delete-exist-sizeof",
    "isg.var.cycle-variables",
    syntax=("#DELETE P<n> {, P<n>}", "#DELETE V.<class>.<name> {, V.<class>.<name>}"),
    form=Form.VARIABLES,
)
def delete(x: Execution, call: StatementCall) -> None:
    """Whole variables and arrays; one that is not there is passed over (line 22112)."""
    for number, (argument, _) in enumerate(call):
        path = argument.text
        if path == "P":
            index = round_half_up(call.indices(number)[0])
            x.parameters.pop(index, None)
            x.parameter_arrays.delete(str(index))
            continue
        match = _USER.match(path)
        if match is None:
            raise LineError(
                catalogue.STATEMENT_ARGUMENTS,
                argument.column,
                found=argument.name,
                statement="#DELETE",
                syntax=call.syntax.syntax[1],
            )
        kind, name = match.groups()
        if kind in ("P", "S"):
            (x.program_scope if kind == "P" else x.memory.static).delete(name)
        elif not _own(x.frame, kind).delete(name) and any(name in _own(frame, kind) for frame in x.frames):
            raise LineError(catalogue.DELETE_HIGHER, argument.column, name=path)


def _own(frame: Frame, kind: str) -> Scope:
    return frame.local if kind == "L" else frame.cycle


@statement(
    "INIT",
    "isg.var.external-init",
    syntax="#INIT V.E.<name> {, V.E.<name>}",
    form=Form.VARIABLES,
)
def clear_external(x: Execution, call: StatementCall) -> None:
    """External variables, arrays, structures, elements of them: back to zero. One synchronous member makes all of what is named
    synchronous (line 22183)."""
    for number, (argument, _) in enumerate(call):
        path = argument.text
        items = x.external.below(path)
        if not items:
            x.external.item(path, argument.column)  # tells what is known
        for item in items:
            if not item.writable:
                raise LineError(
                    catalogue.VARIABLE_READ_ONLY, argument.column, name=item.entry.path.replace("[]", "[..]")
                )
        synchronous = any(item.synchronous for item in items)
        for item in items:
            item.clear(call.indices(number), synchronous)


@statement("INIT MACRO TAB", "isg.macro.init-tab", aliases=("INIT MAKRO TAB",))
def clear_macros(x: Execution, call: StatementCall) -> None:
    x.memory.clear_macros()
