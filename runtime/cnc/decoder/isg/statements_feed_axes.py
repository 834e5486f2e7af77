"""#FGROUP: the axes that F refers to; #TANGFEED (programming manual 15569–15722, 12478–12528)."""

from __future__ import annotations

import math
from dataclasses import replace

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.feed_group import FeedGroup
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import language as catalogue

_LEAST_FACTOR, _GREATEST_FACTOR = 0.001, 1000.0


def _select(x: Execution, group: FeedGroup) -> None:
    x.feed_group = group
    x.modal_changed()


@statement(
    "FGROUP",
    "isg.add.fgroup",
    "isg.add.fgroup-factors",
    syntax=("#FGROUP [<axis>[=<factor>] {, <axis>[=<factor>]}]", "#FGROUP"),
    form=Form.AXIS_BRACKET,
    optional=True,
)
def feed_group(x: Execution, call: StatementCall) -> None:
    """Without axes those of the channel parameters."""
    chosen = call.axes()
    if not chosen:
        if not x.setup.feed_axes_configured:
            x.warn(catalogue.FEED_GROUP_DEFAULT, call.column)
        _select(x, x.setup.feed_group)
        return
    factors = [0.0] * len(x.setup.axes)
    for axis, value in chosen.items():
        factor = 1.0 if value is None else value
        name = x.setup.axes[axis]
        if not _LEAST_FACTOR <= factor <= _GREATEST_FACTOR:
            raise call.error(catalogue.FEED_GROUP_FACTOR, name, value=factor, axis=name)
        factors[axis] = factor
    _select(x, FeedGroup(tuple(factors)))


@statement(
    "FGROUP ROT",
    "isg.add.fgroup-rot",
    syntax=("#FGROUP ROT [AX=<axis> REF=..]", "#FGROUP ROT"),
    form=Form.KEYS,
    keys=(Key("AX", KeyKind.AXIS, needed=True), Key("REF", needed=True)),
    optional=True,
)
def reference_radius(x: Execution, call: StatementCall) -> None:
    """The degrees of an axis count as way at this radius; without arguments no longer."""
    if not call.given("AX"):
        _select(x, replace(x.feed_group, reference=None))
        return
    argument = call.argument("AX")
    assert argument is not None
    radius = x.length(call.needed("REF"))
    if not 0.0 < radius < math.inf:
        raise call.error(catalogue.FEED_GROUP_RADIUS, "REF", value=radius)
    held = x.setup.feed_group
    _select(x, FeedGroup(held.factors, reference=(argument.index, radius)))


@statement("FGROUP WAXIS", "isg.add.fgroup-waxis")
def weakest_axis(x: Execution, call: StatementCall) -> None:
    """In each block the axis with the longest way moves at F."""
    _select(x, FeedGroup(weakest=True))


@statement(
    "TANGFEED",
    "isg.add.tangfeed",
    syntax="#TANGFEED [RMIN=..]",
    form=Form.KEYS,
    keys=(Key("RMIN", needed=True),),
)
def tangential_feed(x: Execution, call: StatementCall) -> None:
    """G11 converts the feed of arcs from this radius on; 0: of all."""
    _tangential(x, call, call.needed("RMIN"))


def _tangential(x: Execution, call: StatementCall, radius: float) -> None:
    radius = x.length(radius)
    if not 0.0 <= radius < math.inf:
        raise call.error(catalogue.RADIUS_NEGATIVE, value=radius)
    x.modal.compensation = replace(x.modal.compensation, adapted_from=radius)


@statement("SET TANGFEED RMIN", "isg.add.tangfeed", syntax="#SET TANGFEED RMIN [..]", form=Form.VALUE)
def tangential_feed_old(x: Execution, call: StatementCall) -> None:
    """The old form."""
    _tangential(x, call, call.needed())
