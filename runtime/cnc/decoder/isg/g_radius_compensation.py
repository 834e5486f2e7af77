"""G functions of tool radius compensation: side, approach, outside corners, feed, masking (programming manual 18666–20015)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from runtime.cnc.blocks import Approach
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import GCall, g_function
from runtime.cnc.decoder.motion import plane_of
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.syntax import Group
from runtime.cnc.language.isg.words import WordKind
from runtime.diagnostics.catalogue import radius as catalogue

_APPROACHES = {
    Approach.DIRECT: "isg.trc.direct-g138",
    Approach.INDIRECT: "isg.trc.indirect-g139",
    Approach.ON_PATH: "isg.trc.on-path-g236",
    Approach.PERPENDICULAR: "isg.trc.perpendicular-g237",
    Approach.INSIDE_CORNER: "isg.trc.inside-corner-g238",
    Approach.WITHOUT_BLOCK: "isg.trc.no-block-g239",
}


def _side(number: int, side: int) -> None:
    @g_function(number, Group.COMPENSATION, "isg.trc.g40-g41-g42", "isg.trc.side-change")
    def select(x: Execution, call: GCall) -> None:
        if side:
            if not x.setup.radius_compensation:
                raise LineError(catalogue.NOT_PRESENT, call.column)
            assert x.block is not None
            plane_of(x, x.block)
        x.modal.compensation_side = side


_side(40, 0)
_side(41, 1)
_side(42, -1)


def _approach(approach: Approach, entry: str) -> None:
    @g_function(int(approach), Group.APPROACH, "isg.trc.selection-modes", entry)
    def select(x: Execution, call: GCall) -> None:
        """How radius compensation begins and ends from here on."""
        if approach is Approach.INSIDE_CORNER and x.compensation.active:
            raise LineError(catalogue.INSIDE_CORNER_LATE, call.column)
        x.modal.approach = approach


for _one, _entry in _APPROACHES.items():
    _approach(_one, _entry)


@g_function(5, Group.NONE, "isg.trc.tangential-g05", modal=False, syntax="G05 G40|G41|G42")
def tangential(x: Execution, call: GCall) -> None:
    """The compensation that begins or ends in this block does so on an arc."""
    assert x.block is not None
    if not any(word.kind is WordKind.G and word.index in (40, 41, 42) for word in x.block.words):
        raise LineError(catalogue.TANGENTIAL_ALONE, call.column)
    x.compensation.tangential = call.column


def _setting(number: int, group: Group, entry: str, **change: Any) -> None:
    @g_function(number, group, entry)
    def select(x: Execution, call: GCall) -> None:
        x.modal.compensation = replace(x.modal.compensation, **change)


_setting(25, Group.OUTSIDE_CORNER, "isg.trc.transitions-g25-g26", circular=False)
_setting(26, Group.OUTSIDE_CORNER, "isg.trc.transitions-g25-g26", circular=True)
_setting(10, Group.COMPENSATED_FEED, "isg.trc.feed-g10-g11", adapt_feed=False)
_setting(11, Group.COMPENSATED_FEED, "isg.trc.feed-g10-g11", adapt_feed=True)
_setting(140, Group.MASKING, "isg.trc.contour-masking-g140-g141")  # nothing is left out: there is no G141 yet
