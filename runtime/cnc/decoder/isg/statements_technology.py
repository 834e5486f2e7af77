"""# statements of technology functions and spindles."""

from __future__ import annotations

import math

from runtime.cnc.blocks import MicroJointFeed, Synch, Wait
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.catalogue import technology


@statement("EXPL SYN", "isg.spdl.late-sync-explicit", "chan.mh.mvs-slp")
def explicit_synchronisation(x: Execution, call: StatementCall) -> None:
    """The path waits here for the late functions of type MVS_SLP."""
    x.emit(Wait(x.source, Synch.MVS_SLP))


@statement(
    "CHANNEL SET",
    "cut.microjoint.feed",
    syntax="#CHANNEL SET [M_PRE_OUTPUT [E=..] [F=..] [VECTOR_LIMIT_OFF]]",
    form=Form.KEYS,
    keys=(
        Key("M_PRE_OUTPUT", KeyKind.FLAG, needed=True),
        Key("E"),
        Key("F"),
        Key("VECTOR_LIMIT_OFF", KeyKind.FLAG),
    ),
)
def micro_joint_feed(x: Execution, call: StatementCall) -> None:
    """Feed at the begin of the next micro-joint (E) and in it (F); #VECTOR LIMIT does not count in it (VECTOR_LIMIT_OFF)."""
    if not x.setup.micro_joints:
        raise call.error(technology.JOINT_FEED_USELESS, "M_PRE_OUTPUT")
    feeds: dict[str, float | None] = {}
    for key in ("E", "F"):
        value = call.number(key)
        if value is not None and not 0.0 < value < math.inf:
            raise call.error(technology.JOINT_FEED, key, key=key, value=value)
        feeds[key] = None if value is None else x.length(value) * x.setup.feed_factor
    x.emit(MicroJointFeed(x.source, feeds["E"], feeds["F"], call.given("VECTOR_LIMIT_OFF")))


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
