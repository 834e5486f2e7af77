"""#GET CMDPOS, #GET ACTPOS: where the axes are (programming manual 6157–6217)."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.syntax import Form
from runtime.diagnostics.catalogue import language as catalogue

_GET = "isg.g.get-cmdpos-actpos"
_OWN = ("P", "V.P.", "V.S.", "V.L.", "V.CYC.")


def command_position(x: Execution) -> list[float]:
    """Where the path stands, (n,) in machine coordinates; the decoded position where no machine is."""
    position = x.outside.command_position()
    return x.coordinates.position if position is None else [float(p) for p in position]


def actual_position(x: Execution) -> list[float]:
    """Where the axes are measured, (n,) in machine coordinates; the decoded position where no machine is."""
    position = x.outside.actual_position()
    return x.coordinates.position if position is None else [float(p) for p in position]


@statement(
    "GET CMDPOS",
    _GET,
    syntax="#GET CMDPOS [P<n>|V.P.<name>|V.S.<name>|V.L.<name>=<axis> {, ..}]",
    form=Form.ASSIGNMENTS,
    flush=True,
    aliases=("SET IPO SOLLPOS",),
)
def get_command_position(x: Execution, call: StatementCall) -> None:
    _store(x, call, command_position(x))


@statement(
    "GET ACTPOS",
    _GET,
    syntax="#GET ACTPOS [P<n>|V.P.<name>|V.S.<name>|V.L.<name>=<axis> {, ..}]",
    form=Form.ASSIGNMENTS,
    flush=True,
)
def get_actual_position(x: Execution, call: StatementCall) -> None:
    _store(x, call, actual_position(x))


def _store(x: Execution, call: StatementCall, position: list[float]) -> None:
    """With all offsets, as V.A.ABS has it, in the unit that is selected; targets are parameters and variables of one's own."""
    for argument, _ in call:
        if not argument.name.upper().startswith(_OWN):
            raise LineError(
                catalogue.STATEMENT_ARGUMENTS,
                argument.column,
                found=argument.name,
                statement="#" + call.syntax.name,
                syntax=call.syntax.syntax[0],
            )
    for argument, write in call:
        write(x.shown(argument.index, position[argument.index]))
