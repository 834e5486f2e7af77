"""G functions of turning: diameters, constant cutting speed."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import GCall, g_function
from runtime.cnc.decoder.turning import LIMIT_G, select_diameter
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.syntax import Group, Values
from runtime.diagnostics.catalogue import technology

_DIAMETER, _CUTTING = "isg.turn.diameter-g51-g52", "isg.turn.css-g96-g97-g196"


@g_function(51, Group.DIAMETER, _DIAMETER)
def diameters(x: Execution, call: GCall) -> None:
    """Values of the facing axis are diameters."""
    select_diameter(x, True, call.column)


@g_function(52, Group.DIAMETER, _DIAMETER)
def radii(x: Execution, call: GCall) -> None:
    """Values of the facing axis are radii."""
    select_diameter(x, False, call.column)


@g_function(96, Group.CUTTING_SPEED, _CUTTING, syntax="G96 S<m/min>")
def cutting_speed(x: Execution, call: GCall) -> None:
    """S is the cutting speed: the speed of the spindle follows the distance from the turning centre."""
    x.turning.begin(x, call.column)


@g_function(97, Group.CUTTING_SPEED, _CUTTING, syntax="G97 [S<rev/min>]")
def spindle_speed(x: Execution, call: GCall) -> None:
    """S is the speed of the spindle, which stays as it is."""
    x.turning.end(x)


@g_function(LIMIT_G, Group.NONE, _CUTTING, modal=False, syntax="G196 S.. | G196=..", values=Values.OPTIONAL)
def greatest_speed(x: Execution, call: GCall) -> None:
    """The greatest speed of the spindle while G96 holds, rev/min."""
    if call.value is not None:
        x.turning.take_limit(x, call.value, call.column)
    elif x.block is None or x.block.speed < 0:
        raise LineError(technology.SPINDLE_WORD_NEEDED, call.column, number=call.number)
    else:
        x.speed_argument = call.number
