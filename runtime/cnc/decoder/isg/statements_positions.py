"""#GET and #CHANNEL INIT: positions of the machine for variables and for the decoder (programming manual 6070–6217).

#CHANNEL INIT [ACTPOS] makes the decoder count from where the axes are measured, while the path goes on from where it stands, at
the command position: the next straight move leads from there to its target, and no axis jumps.
"""

from __future__ import annotations

from runtime.cnc.blocks import TakeOver
from runtime.cnc.decoder.couplings import expect_uncoupled
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.decoder.places import waits_for_place
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import language as catalogue

_INIT = "isg.g.channel-init-cmdpos-actpos"
_GET = "isg.g.get-cmdpos-actpos"
_OWN = ("P", "V.P.", "V.S.", "V.L.", "V.CYC.")


def command_position(x: Execution) -> list[float]:
    """Where the path stands, (n,) in machine coordinates; the decoded position where no machine is."""
    position = x.outside.command_position()
    return x.coordinates.machine() if position is None else [float(p) for p in position]


def actual_position(x: Execution) -> list[float]:
    """Where the axes are measured, (n,) in machine coordinates; the decoded position where no machine is."""
    position = x.outside.actual_position()
    return x.coordinates.machine() if position is None else [float(p) for p in position]


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


# ---------------------------------------------------------------------------------------------------- initialisation


@statement(
    "CHANNEL INIT",
    _INIT,
    syntax=(
        "#CHANNEL INIT [CMDPOS {AX=<axis> | AXNR=<number>}]",
        "#CHANNEL INIT [ACTPOS {AX=<axis> | AXNR=<number>}]",
    ),
    form=Form.KEYS,
    keys=(Key("CMDPOS", KeyKind.FLAG), Key("ACTPOS", KeyKind.FLAG), Key("AX", KeyKind.AXIS), Key("AXNR")),
    flush=True,
)
def initialise(x: Execution, call: StatementCall) -> None:
    """All axes, or those that are named: of the others ACTPOS takes the command position, CMDPOS nothing (line 6094).

    With ACTPOS the next motion has to be straight, whatever the difference is, so that a check without machine tells it too.
    """
    expect_uncoupled(x, "#CHANNEL INIT", call.column)
    actual = call.given("ACTPOS")
    if actual == call.given("CMDPOS"):
        raise LineError(catalogue.POSITIONS_KIND, call.column)
    if _by_hand(x):
        return
    named = _named(x, call)
    command = command_position(x)
    position = command if actual else x.coordinates.machine()
    asked = actual_position(x) if actual else command
    begin = [asked[i] if i in named else position[i] for i in range(len(position))]
    _begin_at(x, begin, command if actual or begin != command else None)


@statement("SET DEC LR SOLL", _INIT, flush=True)
def initialise_command(x: Execution, call: StatementCall) -> None:
    """The old form of #CHANNEL INIT [CMDPOS]."""
    expect_uncoupled(x, "#SET DEC LR SOLL", call.column)
    if _by_hand(x):
        return
    _begin_at(x, command_position(x), None)


def _by_hand(x: Execution) -> bool:
    """The path takes over what the axes were moved by hand: the block waits for it, then it is executed once more."""
    offsets = x.outside.manual_offsets()
    if x.waiting is None and (offsets is None or not offsets.any()):
        return False
    return waits_for_place(x, TakeOver(x.source), "#CHANNEL INIT")


def _named(x: Execution, call: StatementCall) -> frozenset[int]:
    """Channel indices of the axes that are named, all of them if none is."""
    axes = set()
    for argument, value in call:
        if argument.name == "AX":
            axes.add(argument.index)
        elif argument.name == "AXNR":
            numbers = x.setup.log_axes
            if value not in numbers:
                known = ", ".join(f"{name} {n}" for name, n in zip(x.setup.axes, numbers, strict=False))
                known = (
                    f"axes of the channel: {known}" if known else "without a machine description axes have no number"
                )
                raise LineError(catalogue.LOGICAL_AXIS, argument.column, value=value, known=known)
            axes.add(numbers.index(value))
    return frozenset(axes or range(len(x.setup.axes)))


def _begin_at(x: Execution, position: list[float], path: list[float] | None) -> None:
    """The decoder counts from `position`, the path goes on from `path` (None: from there too), (n,) in machine coordinates."""
    x.coordinates.moved_to(position)
    x.path_start = None if path is None else x.coordinates.of_machine(path)
    x.modal_changed()
