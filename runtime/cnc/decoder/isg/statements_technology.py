"""# statements of technology functions."""

from __future__ import annotations

from runtime.cnc.blocks import Synch, Wait
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement


@statement("EXPL SYN", "isg.spdl.late-sync-explicit", "chan.mh.mvs-slp")
def explicit_synchronisation(x: Execution, call: StatementCall) -> None:
    """The path waits here for the late functions of type MVS_SLP."""
    x.emit(Wait(x.source, Synch.MVS_SLP))
