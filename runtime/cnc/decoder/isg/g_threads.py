"""G functions of threads and tapping: what they mean is carried out with the motion of their block (`decoder.threads`)."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import GCall, StatementCall, g_function, statement
from runtime.cnc.decoder.modal import Motion
from runtime.cnc.language.isg.syntax import Form, Group, Key
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.catalogue import spindle as errors


@g_function(33, Group.PATH_CONDITION, "isg.turn.thread-g33", syntax="G33 <axis>.. I..|J..|K.. [<spindle>.OFFSET=..]")
def thread(x: Execution, call: GCall) -> None:
    """Thread with a turning spindle: the path follows its angle; I, J, K are the pitch."""
    x.modal.motion = Motion.THREAD


@g_function(63, Group.PATH_CONDITION, "isg.spdl.tapping-g63", syntax="G63 <axis>.. [F..] [S..]")
def tapping(x: Execution, call: GCall) -> None:
    """Tapping: the spindle follows the path, by S and F."""
    x.modal.motion = Motion.TAPPING


@g_function(331, Group.PATH_CONDITION, "isg.spdl.tapping-g331-g332", syntax="G331 <axis>.. I..|J..|K.. [S..]")
def tapping_in(x: Execution, call: GCall) -> None:
    """Tapping by a pitch: the spindle follows the path."""
    x.modal.motion = Motion.TAPPING_IN


@g_function(332, Group.PATH_CONDITION, "isg.spdl.tapping-g331-g332", syntax="G332 <axis>.. [I..|J..|K..] [S..]")
def tapping_out(x: Execution, call: GCall) -> None:
    """Out of the hole of G331: the spindle turns the other way."""
    x.modal.motion = Motion.TAPPING_OUT


_FLAGS = ("ROT_FEED_CPL", "TAPPING_ACT_POS", "THREAD_CUT_ACT_SPEED", "THREAD_CUT_IGNORE_OV", "THREAD_CHAIN")
_CYCLES = ("TAPPING_N_CYCLES", "THREAD_CUT_N_CYCLES")
_ABSENT = ("ROT_FEED_CPL", "TAPPING_ACT_POS", "TAPPING_N_CYCLES")  # only 0 is possible
MOST_CYCLES = 20


@statement(
    "TURN",
    "isg.add.turn",
    syntax=(
        "#TURN [THREAD_CUT_ACT_SPEED=.. THREAD_CUT_N_CYCLES=.. THREAD_CUT_IGNORE_OV=.. THREAD_CHAIN=.. ROT_FEED_CPL=0"
        " TAPPING_ACT_POS=0 TAPPING_N_CYCLES=0]",
    ),
    form=Form.KEYS,
    keys=tuple(Key(name) for name in (*_FLAGS, *_CYCLES)),
    modal=True,
)
def turn(x: Execution, call: StatementCall) -> None:
    """How threads follow the spindle: as it is told or as measured, with its override or without, one by one or in a chain."""
    given = {name: call.number(name) for name in (*_FLAGS, *_CYCLES) if call.given(name)}
    if not given:
        raise call.error(catalogue.KEY_MISSING, key="THREAD_CHAIN or another setting", statement="#TURN",
                         syntax=call.syntax.syntax[0])  # fmt: skip
    for name, value in given.items():
        most = 0 if name in _ABSENT else MOST_CYCLES if name in _CYCLES else 1
        if value not in range(most + 1):
            shown = "0" if most == 0 else f"0 to {most}"
            raise call.error(errors.TURN_VALUE, name, key=name, value=value, range=shown)
    sections = x.sections
    sections.measured = bool(given.get("THREAD_CUT_ACT_SPEED", sections.measured))
    sections.cycles = int(given.get("THREAD_CUT_N_CYCLES", sections.cycles) or 0)
    sections.steady = bool(given.get("THREAD_CUT_IGNORE_OV", sections.steady))
    sections.chain = bool(given.get("THREAD_CHAIN", sections.chain))
