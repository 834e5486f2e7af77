"""G functions of the path: rapid, lines, circles, dwell."""

from __future__ import annotations

from runtime.cnc.blocks import BlockEnd, CornerKind
from runtime.cnc.decoder.additions import corner_block, expect_no_line
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import GCall, StatementCall, g_function, statement
from runtime.cnc.decoder.modal import Motion
from runtime.cnc.decoder.motion import dwell_time
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.syntax import Form, Group, Values
from runtime.diagnostics.catalogue import language as catalogue

_EXACT_STOP = "isg.g.exact-stop"
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


@statement("TIME", "isg.add.time", "isg.g.dwell-g04-time", syntax="#TIME <s>", form=Form.VALUE)
def time(x: Execution, call: StatementCall) -> None:
    """The same as G04 with a time."""
    expect_no_line(x)
    dwell_time(x, call.needed(), call.column)
    x.emit(BlockEnd(x.source))


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


@g_function(164, Group.CENTRE_CORRECTION, "isg.g.circle-centre-correction-g164-g165", "isg.g.circle-radius-transition")
def centre_kept(x: Execution, call: GCall) -> None:
    x.modal.centre_correction = False


@g_function(165, Group.CENTRE_CORRECTION, "isg.g.circle-centre-correction-g164-g165")
def centre_corrected(x: Execution, call: GCall) -> None:
    x.modal.centre_correction = True


@g_function(303, Group.PATH_CONDITION, "isg.g.arc-in-space-g303", syntax="G303 I.. J.. K.. X.. Y.. Z..")
def arc_in_space(x: Execution, call: GCall) -> None:
    x.modal.motion = Motion.ARC_IN_SPACE


@g_function(60, Group.EXACT_STOP, _EXACT_STOP, modal=False)
def exact_stop(x: Execution, call: GCall) -> None:
    """Acts behind the motion of the block: see Execution.stop_exactly."""
    x.exact_stop = call.column


@g_function(360, Group.EXACT_STOP, _EXACT_STOP)
def exact_stop_on(x: Execution, call: GCall) -> None:
    x.modal.exact_stop = True
    x.modal_changed()


@g_function(359, Group.EXACT_STOP, _EXACT_STOP)
def exact_stop_off(x: Execution, call: GCall) -> None:
    x.modal.exact_stop = False
    x.modal_changed()


def _corner(number: int, kind: CornerKind) -> None:
    @g_function(
        number,
        Group.CORNER,
        "isg.g.chamfer-rounding-g301-g302",
        "isg.g.chamfer-rounding-inline",
        modal=False,
        syntax=f"G{number} [I..] [F..] | G{number}=..",
        values=Values.OPTIONAL,
    )
    def request(x: Execution, call: GCall) -> None:
        """As a block of its own between two motions, or with a value in the block of the first one (see additions)."""
        if x.setup.no_corners:
            raise LineError(catalogue.CORNERS_OFF, call.column, number=number)
        if call.value is None:
            corner_block(x, kind, call.column)


_corner(301, CornerKind.CHAMFER_WIDTH)
_corner(302, CornerKind.ROUNDING)
