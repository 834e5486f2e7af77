"""G31: a straight motion that a skip signal ends (manual lines 5834–5904).

    gate: the probes are got ready ─ line, braked at the edge, its rest dropped ─ gate: the place of the edge is known
    the decoder waits behind it, and goes on from where the path stands

P is the number of the signal less 1. Signal 1 is the probe of each axis of the block (`measuring` of the axis), or, like the
others, an input of the machine that the parameters name (`skip`). #5061 … are those of the last G31.
"""

from __future__ import annotations

from runtime.cnc.blocks import (
    Flush,
    FlushKind,
    Measurement,
    MeasurementEnd,
    PathRestart,
    Probe,
    ProbeSignal,
    StepEnd,
)
from runtime.cnc.decoder.measuring_state import Run
from runtime.cnc.decoder.modal import FeedMode, Motion
from runtime.cnc.decoder.motion import target
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.motion import line_to
from runtime.cnc.decoder.nct.registry import G_CODES, GCall, Group, Stage, g_code
from runtime.cnc.language.errors import LineError
from runtime.cnc.language.motion_words import WordKind
from runtime.diagnostics.catalogue import nct as catalogue

SIGNALS = 4
NO_WAY = 1e-6  # mm or degrees
_OUT_OF_PLACE = {Group.COMPENSATION: (410, 420), Group.FEED_MODE: (950,), Group.SCALING: (510,), Group.MIRROR: (511,),
                 Group.ROTATION: (680,), Group.POLAR: (160,)}  # fmt: skip


@g_code(
    "31", Group.ONE_SHOT, "nct.meas.skip-g31", meaning="straight motion that skip signal P + 1 ends", stage=Stage.MOVE, takes="P",
    axes=True,
)  # fmt: skip
def skip(x: NctExecution, call: GCall) -> None:
    for group, codes in _OUT_OF_PLACE.items():
        if x.active.get(group) in codes:
            raise LineError(catalogue.G31_STATE, call.column, code=G_CODES[x.active[group]].name)
    words = x.axes()
    if not words:
        raise LineError(catalogue.G31_FORMAT, call.column, reason="an axis is wanted")
    probes = _probes(x, call, tuple(words))
    start, end = list(x.coordinates.position), target(x, x.words)
    x.memory.skip = list(end)
    if all(abs(e - s) <= NO_WAY for s, e in zip(start, end, strict=True)):
        return
    x.emit(Flush(x.source, FlushKind.CONTINUE))  # nothing before it is smoothed into the motion
    x.emit(Measurement(x.source, probes))
    _drive(x, call, end)
    x.emit(MeasurementEnd(x.source))
    x.measuring.pending = Run(tuple(words), start, end, call.column)


def _drive(x: NctExecution, call: GCall, end: list[float]) -> None:
    """The line at the feed of G31: F, or with SKIPF that of the parameters."""
    modal, nct = x.modal, x.nct
    motion, feed = modal.motion, modal.feeds.get(FeedMode.PER_MINUTE)
    modal.motion = Motion.LINEAR
    if nct.skipf:
        if not nct.g31fd:
            raise LineError(catalogue.G31_FORMAT, call.column, reason="skipf is chosen, and g31fd gives no feed")
        modal.feeds[FeedMode.PER_MINUTE] = nct.g31fd * 60.0
    try:
        line_to(x, end)
    finally:
        modal.motion = motion
        if feed is None:
            modal.feeds.pop(FeedMode.PER_MINUTE, None)
        else:
            modal.feeds[FeedMode.PER_MINUTE] = feed


def _probes(x: NctExecution, call: GCall, axes: tuple[int, ...]) -> tuple[Probe, ...]:
    """Who says that the motion is over; LineError 3051 for a signal that there is not."""
    number = x.words.number("P")
    if number is not None and number not in range(SIGNALS):
        raise LineError(catalogue.G31_FORMAT, x.words.place("P"), reason="P is 0, 1, 2 or 3")
    signal = 0 if number is None else round(number)
    inputs = x.setup.skip_inputs
    if signal < len(inputs):
        return tuple(Probe(axis, ProbeSignal.INPUT, level=inputs[signal]) for axis in axes)
    if signal:
        reason = f"skip signal {signal + 1} is no input of this machine (parameter skip)"
        raise LineError(catalogue.G31_FORMAT, x.words.place("P"), reason=reason)
    found = []
    for axis in axes:
        probe = x.measuring.probes[axis]
        column = x.words.column(WordKind.AXIS, axis)
        name = x.setup.axes[axis]
        if probe is None:
            raise LineError(catalogue.G31_FORMAT, column, reason=f"axis {name} has no probe (`measuring`)")
        if probe.signal is ProbeSignal.DRIVE and (probe.number, probe.rising) not in probe.latched:
            raise LineError(catalogue.G31_FORMAT, column, reason=f"the drive of axis {name} tells no touch probe")
        found.append(Probe(axis, probe.signal, probe.number, probe.level, probe.rising))
    return tuple(found)


def wait_for_signal(x: NctExecution) -> None:
    """The end of the block: the decoder goes on when the path stands. Single block stops at a gate of its own, as the path
    stands already."""
    if x.call_shown is None and x.steps.ends(x.source.n):
        x.emit(StepEnd(x.source))
    x.emit(Flush(x.source, FlushKind.WAIT))


def end_of_skip(x: NctExecution) -> None:
    """The path stands: the program goes on from there, and #5061 … are known."""
    run, x.measuring.pending = x.measuring.pending, None
    assert run is not None
    measured, position = x.outside.measured(), x.outside.command_position()
    if measured is None or position is None:  # without a machine the motion ends where it was to
        return
    stands = [float(place) for place in position]
    x.coordinates.moved_to(stands)
    x.emit(PathRestart(x.source))
    if any(axis in measured for axis in run.axes):
        x.memory.skip = [measured.get(axis, place) for axis, place in enumerate(stands)]
