"""G functions of the path: rapid, lines, circles, dwell."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import GCall, g_function
from runtime.cnc.decoder.modal import Motion
from runtime.cnc.language.isg.syntax import Group, Values

_CENTRE = "isg.g.circular-centre-g02-g03"


@g_function(0, Group.PATH_CONDITION, "isg.g.rapid-g00", syntax="G00 <axis>.. {<axis>..}")
def rapid(x: Execution, call: GCall) -> None:
    x.modal.motion = Motion.RAPID


@g_function(1, Group.PATH_CONDITION, "isg.g.linear-g01", syntax="G01 <axis>.. {<axis>..} [F..]")
def linear(x: Execution, call: GCall) -> None:
    x.modal.motion = Motion.LINEAR


@g_function(
    2, Group.PATH_CONDITION, _CENTRE, "isg.g.circular-radius", "isg.g.helix-pitch", syntax="G02 X.. Y.. I.. J.. | R.."
)
def circle_clockwise(x: Execution, call: GCall) -> None:
    x.modal.motion = Motion.CIRCLE_CW


@g_function(
    3, Group.PATH_CONDITION, _CENTRE, "isg.g.circular-radius", "isg.g.helix-pitch", syntax="G03 X.. Y.. I.. J.. | R.."
)
def circle_counter_clockwise(x: Execution, call: GCall) -> None:
    x.modal.motion = Motion.CIRCLE_CCW


@g_function(4, Group.PATH_CONDITION, "isg.g.dwell-g04-time", modal=False, syntax="G04 X.. | G04 <expr> | G04 S..")
def dwell(x: Execution, call: GCall) -> None:
    """The time is a word of the block: see motion.dwell."""


@g_function(161, Group.CIRCLE_CENTRE, "isg.g.circle-centre-mode-g161-g162")
def centre_absolute(x: Execution, call: GCall) -> None:
    x.modal.centre_absolute = True


@g_function(162, Group.CIRCLE_CENTRE, "isg.g.circle-centre-mode-g161-g162")
def centre_relative(x: Execution, call: GCall) -> None:
    x.modal.centre_absolute = False


@g_function(163, Group.CIRCLE_RADIUS, "isg.g.circular-radius", syntax="G163=..", values=Values.EQUALS)
def circle_radius(x: Execution, call: GCall) -> None:
    assert call.value is not None
    x.modal.radius = x.length(call.value)
