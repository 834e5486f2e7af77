"""Speed at the borders of blocks: G08, G09, G900, G901, corner deceleration, and what the look-ahead limits.

Programming manual 3834–3949 (transitions), 4469–4560 (corner deceleration), 6251–6384 (look-ahead).
"""

from __future__ import annotations

from runtime.cnc.decoder.dynamics import change_dynamics
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import GCall, StatementCall, g_function, statement
from runtime.cnc.decoder.modal import INCH
from runtime.cnc.dynamic_settings import ALL_LIMITS, CornerDeceleration, CornerFeedUnit
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.syntax import Form, Group, Key, KeyKind, Values
from runtime.cnc.language.isg.words import WordKind
from runtime.diagnostics.catalogue import language as catalogue

_TRANSITION = "isg.g.block-transition-g08-g09-g900-g901"
_CORNER = "isg.g.corner-deceleration"
_LOOK_AHEAD = "isg.g.look-ahead-g115-g117"


# ---------------------------------------------------------------------------------------------------- transitions


def _beside_feed_change(x: Execution, number: int) -> None:
    """LineError if the block also has G193 or G293 (line 3969)."""
    assert x.block is not None
    for word in x.block.words:
        if word.kind is WordKind.G and word.index in (193, 293):
            raise LineError(catalogue.FEED_CHANGE_BESIDE, word.column, word=f"G{number:02d}")


@g_function(8, Group.ACCELERATING, _TRANSITION)
def accelerate_behind(x: Execution, call: GCall) -> None:
    """A higher feed begins behind the border: that is always so."""
    _beside_feed_change(x, 8)


@g_function(9, Group.ACCELERATING, _TRANSITION, modal=False)
def brake_in_front(x: Execution, call: GCall) -> None:
    """The block itself brakes to the feed of the next one, in spite of G901."""
    _beside_feed_change(x, 9)
    x.brake_in_front = True


def _braking(number: int, late: bool) -> None:
    @g_function(number, Group.BRAKING, _TRANSITION)
    def select(x: Execution, call: GCall) -> None:
        """A lower feed is reached at the border (G900) or behind it (G901)."""
        change_dynamics(x, late_braking=late)


_braking(900, False)
_braking(901, True)


# ---------------------------------------------------------------------------------------------------- corners


@statement(
    "CORNER PARAM",
    _CORNER,
    syntax="#CORNER PARAM [DIST=.. UNIT=FWORD|PERCENT FEED=..]",
    form=Form.KEYS,
    keys=(
        Key("DIST", needed=True),
        Key("UNIT", KeyKind.WORD, ("FWORD", "PERCENT"), needed=True),
        Key("FEED", needed=True),
    ),
    aliases=("SET CORNER PARAM",),
)
def corner_parameters(x: Execution, call: StatementCall) -> None:
    """For G13; where it is on already, for the next motion."""
    distance, feed = x.length(call.needed("DIST")), call.needed("FEED")
    if not 0.0 < distance < float("inf"):
        raise call.error(catalogue.CORNER_DISTANCE, "DIST", value=distance)
    if not 0.0 < feed < float("inf"):
        raise call.error(catalogue.FEED_INVALID, "FEED", value=feed)
    unit = CornerFeedUnit(call.text("UNIT"))
    if unit is CornerFeedUnit.PERCENT:
        feed /= 100.0
    else:
        feed *= (INCH if x.modal.inch else 1.0) * x.setup.feed_factor
    x.corner_parameters = CornerDeceleration(distance, unit, feed)
    if x.dynamics.corner is not None:
        change_dynamics(x, corner=x.corner_parameters)


@g_function(13, Group.CORNER_DECELERATION, _CORNER)
def corner_deceleration(x: Execution, call: GCall) -> None:
    """Acts with the slope STEP."""
    if x.corner_parameters is None:
        raise LineError(catalogue.CORNER_PARAMETERS, call.column)
    change_dynamics(x, corner=x.corner_parameters)


@g_function(12, Group.CORNER_DECELERATION, _CORNER)
def no_corner_deceleration(x: Execution, call: GCall) -> None:
    change_dynamics(x, corner=None)


# ---------------------------------------------------------------------------------------------------- look-ahead


@g_function(115, Group.LOOK_AHEAD, _LOOK_AHEAD, syntax="G115=<0|2|4..14>", values=Values.EQUALS)
def choose_limits(x: Execution, call: GCall) -> None:
    """Which limits of the path speed hold, for all axes."""
    value = call.value
    if value is None or value not in range(0, ALL_LIMITS + 1, 2):
        raise LineError(catalogue.LOOK_AHEAD_NUMBER, call.column, value=value or 0.0)
    change_dynamics(x, look_ahead=int(value))


@g_function(116, Group.ARGUMENTS, _LOOK_AHEAD, syntax="G116 <axis>.. {<axis>..}", axis_arguments=True)
def free_corners(x: Execution, call: GCall) -> None:
    """The jump of these axes at corners limits nothing; the values have no meaning."""
    change_dynamics(x, free_corners=x.dynamics.free_corners | x.raw_arguments(116, call.column).keys())


@g_function(117, Group.LOOK_AHEAD, _LOOK_AHEAD)
def all_limits(x: Execution, call: GCall) -> None:
    change_dynamics(x, look_ahead=ALL_LIMITS, free_corners=frozenset())
