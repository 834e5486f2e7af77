"""#SEGMENTATION: long blocks in pieces (programming manual 17178–17323)."""

from __future__ import annotations

from dataclasses import replace

from runtime.cnc.blocks import ArcPieces, Segmentation, SegmentationChange
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement, variable
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import smoothing as catalogue

_SPEC = "isg.add.segmentation"
_LEAST = 0.001  # mm: shorter pieces would be more records than the path needs
_MODES = {0: ArcPieces.LINES, 1: ArcPieces.CHORD_ERROR, 2: ArcPieces.ARCS}
_KEYS = (
    Key("LIN", KeyKind.FLAG),
    Key("LENGTH"),
    Key("CIR", KeyKind.FLAG),
    Key("OPMODE"),
    Key("PARAM"),
)


def _emit(x: Execution, chosen: Segmentation) -> None:
    x.smoothing.segmentation = chosen
    x.emit(SegmentationChange(x.source, chosen))


@statement("SEGMENTATION ON ALL", _SPEC)
def segment_all(x: Execution, call: StatementCall) -> None:
    _emit(x, replace(x.smoothing.segmentation, lines=True, arcs=True))


@statement("SEGMENTATION OFF ALL", _SPEC)
def segment_nothing(x: Execution, call: StatementCall) -> None:
    _emit(x, replace(x.smoothing.segmentation, lines=False, arcs=False))


@statement(
    "SEGMENTATION ON", _SPEC, syntax="#SEGMENTATION ON [[LIN [LENGTH=..]] [CIR [OPMODE=0|1|2] [PARAM=..]]]",
    form=Form.KEYS, keys=_KEYS,
)  # fmt: skip
def segment(x: Execution, call: StatementCall) -> None:
    now = x.smoothing.segmentation
    lines, arcs = call.given("LIN"), call.given("CIR")
    for key, owner in (("LENGTH", lines or now.lines), ("OPMODE", arcs or now.arcs), ("PARAM", arcs or now.arcs)):
        if call.given(key) and not owner:
            word = "LIN" if key == "LENGTH" else "CIR"
            raise call.error(catalogue.OF_OTHER_METHOD, key, key=key, method="#SEGMENTATION without it", known=word)
    changes = now
    if call.given("LENGTH"):
        changes = replace(changes, length=_size(x, call, "LENGTH"))
    if call.given("OPMODE"):
        mode = call.needed("OPMODE")
        if mode not in _MODES:
            raise call.error(catalogue.VALUE_RANGE, "OPMODE", key="OPMODE", value=mode, least=0, most=2)
        changes = replace(changes, mode=_MODES[int(mode)])
    if call.given("PARAM"):
        changes = replace(changes, parameter=_size(x, call, "PARAM"))
    _emit(x, replace(changes, lines=now.lines or lines, arcs=now.arcs or arcs))


@statement("SEGMENTATION OFF", _SPEC, syntax="#SEGMENTATION OFF [[LIN] [CIR]]", form=Form.KEYS, keys=_KEYS)
def do_not_segment(x: Execution, call: StatementCall) -> None:
    now = x.smoothing.segmentation
    _emit(x, replace(now, lines=now.lines and not call.given("LIN"), arcs=now.arcs and not call.given("CIR")))


def _size(x: Execution, call: StatementCall, key: str) -> float:
    value = x.length(call.needed(key))
    if not _LEAST <= value <= 1e6:
        raise call.error(catalogue.VALUE_RANGE, key, key=key, value=value, least=_LEAST, most=1e6)
    return value


@variable("V.G.SEGMENTATION_ACTIVE", "isg.var.g-active-flags", "1 while lines or arcs are segmented (#SEGMENTATION)")
def active(x: Execution) -> float:
    return float(x.smoothing.segmentation.lines or x.smoothing.segmentation.arcs)
