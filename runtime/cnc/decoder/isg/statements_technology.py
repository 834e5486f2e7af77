"""# statements of technology functions and spindles."""

from __future__ import annotations

from runtime.cnc.blocks import Synch, Wait
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.syntax import Form
from runtime.diagnostics.catalogue import language as catalogue


@statement("EXPL SYN", "isg.spdl.late-sync-explicit", "chan.mh.mvs-slp")
def explicit_synchronisation(x: Execution, call: StatementCall) -> None:
    """The path waits here for the late functions of type MVS_SLP."""
    x.emit(Wait(x.source, Synch.MVS_SLP))


@statement(
    "MAIN SPINDLE",
    "isg.spdl.main-spindle-change",
    syntax="#MAIN SPINDLE [ [<spindle>|<logical axis number>] ]",
    form=Form.SPINDLE,
    optional=True,
    modal=True,
)
def main_spindle(x: Execution, call: StatementCall) -> None:
    """Another spindle answers to the name of the main spindle, and to every function without a bracket."""
    given = next(iter(call), None)
    if given is None:
        x.spindles.choose_main(x, None)
        return
    argument, value = given
    if value is None:
        x.spindles.choose_main(x, x.spindles.index_of(argument.text, argument.column))
        return
    number = round_half_up(value)
    if number not in x.setup.log_spindles:
        known = ", ".join(str(known) for known in x.setup.log_spindles)
        raise LineError(catalogue.SPINDLE_UNKNOWN, argument.column, spindle=str(number), spindles=known)
    x.spindles.choose_main(x, x.setup.log_spindles.index(number))
