"""G135, G136, G137: feed-forward control of the axes of the channel (programming manual 4963–5000)."""

from __future__ import annotations

from runtime.cnc.blocks import FeedForward
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.g_weights import share
from runtime.cnc.decoder.isg.registry import GCall, g_function
from runtime.cnc.dynamic_settings import with_share
from runtime.cnc.language.isg.syntax import Group
from runtime.cnc.language.isg.words import WordKind

_SPEC = "isg.g.feedforward-g135-g137"


def _emit(x: Execution) -> None:
    """What holds from here on: nothing while it is deselected, whatever the weights are."""
    n = len(x.setup.axes)
    modal = x.modal
    x.emit(FeedForward(x.source, (modal.feed_forward or (1.0,) * n) if modal.feeds_forward else (0.0,) * n))


@g_function(135, Group.FEED_FORWARD, _SPEC)
def feed_forward_on(x: Execution, call: GCall) -> None:
    x.modal.feeds_forward = True
    _emit(x)


@g_function(137, Group.FEED_FORWARD, _SPEC)
def feed_forward_off(x: Execution, call: GCall) -> None:
    """The weights stay for the next selection."""
    x.modal.feeds_forward = False
    _emit(x)


@g_function(136, Group.ARGUMENTS, _SPEC, syntax="G136 <axis><percent> {<axis><percent>}", axis_arguments=True)
def feed_forward_weights(x: Execution, call: GCall) -> None:
    """Axes that are not named keep their weights; more than 100 % is 100 %."""
    assert x.block is not None
    chosen = {
        axis: min(share(value, x.block.column(WordKind.AXIS, axis)), 1.0)
        for axis, value in x.raw_arguments(136, call.column).items()
    }
    x.modal.feed_forward = with_share(x.modal.feed_forward, len(x.setup.axes), chosen)
    if x.modal.feeds_forward:
        _emit(x)
