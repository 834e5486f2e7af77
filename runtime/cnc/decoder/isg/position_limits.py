"""#GET WCS POSLIMIT: how far the axes can go in a direction of the active coordinate system (programming manual 27830–27905)."""

from __future__ import annotations

import math

import numpy as np

from runtime.cnc.decoder.coordinates import MAIN
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement, variable
from runtime.cnc.decoder.systems import expect_main_axes
from runtime.cnc.language.isg.syntax import Form, Key
from runtime.diagnostics.catalogue import coordinates as errors

_SPEC = "isg.cs.get-wcs-poslimit"
_KEYS = ("VC1", "VC2", "VC3")
_NO_WAY = 1e-12


@statement(
    "GET WCS POSLIMIT",
    _SPEC,
    syntax="#GET WCS POSLIMIT [VC1=.. VC2=.. VC3=..]",
    form=Form.KEYS,
    keys=tuple(Key(key) for key in _KEYS),
)
def limit_in_direction(x: Execution, call: StatementCall) -> None:
    """Where the first main axis comes to its software limit on a straight way, for V.G.WCS_POSLIMIT_1 to 3.

    Nobody goes there. An axis that is beyond its limit already has no way left.
    """
    expect_main_axes(x, "#GET WCS POSLIMIT", call.column)
    c = x.coordinates
    given = {axis: call.number(key, 0.0) or 0.0 for axis, key in enumerate(_KEYS)}
    length = math.hypot(*given.values())
    if not 0.0 < length < math.inf:
        raise call.error(errors.LIMIT_DIRECTION, "", what="the direction has no length")
    way = {axis: value / length for axis, value in given.items()}
    tip, tail = c.target(way, False), c.target(dict.fromkeys(way, 0.0), False)
    along = np.array(tip[:MAIN]) - np.array(tail[:MAIN])
    if c.frame is not None:
        along = c.frame.rotation @ along
    here, most = c.machine(), math.inf
    for axis, step in enumerate(along.tolist()):
        limit = x.soft_limits[axis][1 if step > 0.0 else 0]
        if abs(step) > _NO_WAY and math.isfinite(limit):
            most = min(most, max(0.0, (limit - here[axis]) / step))
    if math.isinf(most):
        raise call.error(errors.LIMIT_DIRECTION, "", what="no axis has a software limit in this direction")
    now = c.programmed_of(c.position)
    x.direction_limit = tuple(now[axis] + way[axis] * most for axis in range(MAIN))


def _limit(number: int) -> None:
    @variable(
        f"V.G.WCS_POSLIMIT_{number}",
        _SPEC,
        f"main axis {number} at the limit that #GET WCS POSLIMIT has found",
        unit="mm, inch",
    )
    def read(x: Execution) -> float:
        return x.shown_length(x.direction_limit[number - 1])


for _number in (1, 2, 3):
    _limit(_number)
