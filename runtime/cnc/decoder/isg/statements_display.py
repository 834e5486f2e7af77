"""# statements that change what single block stops at (programming manual lines 16953–17050)."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import language as catalogue


@statement(
    "SINGLE STEP",
    "isg.add.single-step",
    syntax="#SINGLE STEP [DISABLE | ENABLE | RESOLUTION=..]",
    form=Form.KEYS,
    keys=(Key("DISABLE", KeyKind.FLAG), Key("ENABLE", KeyKind.FLAG), Key("RESOLUTION")),
)
def single_step(x: Execution, call: StatementCall) -> None:
    resolution = call.number("RESOLUTION")
    if len(list(call)) != 1:
        raise call.error(catalogue.SINGLE_STEP)
    x.flush_run()  # moves before this block are steps as they were
    if resolution is None:
        x.steps.locked = call.given("DISABLE")
    elif resolution < 0.5:
        raise call.error(catalogue.RESOLUTION_INVALID, "RESOLUTION", value=resolution)
    else:
        x.steps.resolution = round_half_up(resolution)
        x.steps.reached = None
