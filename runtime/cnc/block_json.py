"""Blocks as rows of `blocks.jsonl`: one per motion element, dwell, function, stop, or action of the cycle."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict

from runtime.cnc.blocks import (
    Arc,
    AxisJob,
    AxisJobWait,
    Block,
    CouplingChange,
    Dwell,
    ExactStop,
    ExternalWrite,
    Floats,
    Flush,
    Homing,
    IndependentMotion,
    IndependentWait,
    Line,
    ManualMotion,
    ManualParameter,
    Measurement,
    Message,
    Polyline,
    Polynomials,
    PositionSetting,
    Source,
    SpatialArc,
    SpindleSetting,
    Stop,
    Suppression,
    TechnologyFunction,
    TimerAction,
    ToolLifeAction,
    ToolRadius,
    UserError,
    programmed_way,
)

Row = dict[str, object]


def rows(block: Block, axis_names: Sequence[str]) -> Iterator[Row]:
    """The rows of a block, in the order of the program. A polyline gives one per segment, a run of
    polynomials one per element, `Wait`, `BlockEnd`, `Hold` none.

    Every row has `line`, `n` (block number or None), `program`, `type`. Motion: `from`, `to` (axis name → machine
    coordinate, mm or degrees), `to_pcs` (programmed coordinates), `feed` (mm/min, None for rapid), `rapid`; arcs and
    helices also `centre` (axis name → mm), `radius` (mm), `angle` (degrees, counter-clockwise positive) and `plane`
    ("XY"), arcs in space `normal` (unit vector) in its place; polynomials ("poly") `coefficients` (axis name → six, of a
    parameter from 0 to 1). Functions: `number`, `value`, `synch`, for S `spindle`.
    Dwell: `seconds`. Stop, flush: `kind`. Message: `text`, `receiver`, `acknowledge`, `information`. Timer: `command`, `timer`.
    Suppression: `feed_stop`, `override`.
    External variable: `offset` (bytes), `kind`, `value`. Error: `number`, `multiple`, `remedy_class`, `values`, `meanings`,
    `further`. Tool radius: `radius` (mm). Tool life: `command`, `basic`, `sister`, `variant`, `time` (s), `distance`
    (mm). Manual mode: `kind` and `axes` (indices), or `axis`, `stage`, `values`; homing: `order`
    of the axes, 0 none.
    """
    if isinstance(block, Polyline):
        yield from _polyline(block, axis_names)
    elif isinstance(block, Polynomials):
        yield from _polynomials(block, axis_names)
    elif isinstance(block, Line):
        yield {
            **_source(block.source, "line"),
            "from": _axes(block.start, axis_names),
            "to": _axes(block.end, axis_names),
            "to_pcs": _axes(block.end_pcs, axis_names),
            **_feed(block.feed, block.rapid),
        }
    elif isinstance(block, Arc):
        yield _arc(block, axis_names)
    elif isinstance(block, SpatialArc):
        yield _spatial_arc(block, axis_names)
    elif isinstance(block, Dwell):
        yield {**_source(block.source, "dwell"), "seconds": block.seconds}
    elif isinstance(block, Suppression):
        yield {**_source(block.source, "suppression"), "feed_stop": block.feed_stop, "override": block.override}
    elif isinstance(block, ExactStop):
        yield _source(block.source, "exact stop")
    elif isinstance(block, TechnologyFunction):
        row = _source(block.source, block.kind.name.lower())
        row |= {"number": block.number, "value": block.value, "synch": block.synch.name}
        if block.spindle >= 0:
            row["spindle"] = block.spindle
            if block.number == 19:
                row["angle"] = block.angle
        yield row
    elif isinstance(block, Stop):
        yield {**_source(block.source, "stop"), "kind": block.kind.value}
    else:
        yield from _action(block)


def _action(block: Block) -> Iterator[Row]:
    match block:
        case Flush():
            yield {**_source(block.source, "flush"), "kind": block.kind.value}
        case Message():
            yield {
                **_source(block.source, "message"),
                "text": block.text,
                "receiver": block.receiver.value,
                "acknowledge": block.acknowledge,
                "information": block.information,
            }
        case ToolLifeAction():
            row = _source(block.source, "tool life") | {"command": block.command.value}
            row |= {"basic": block.basic, "sister": block.sister, "variant": block.variant}
            yield row | {"time": block.time, "distance": block.distance}
        case ToolRadius():
            yield {**_source(block.source, "tool radius"), "radius": block.radius}
        case SpindleSetting():
            row = _source(block.source, "spindle")
            yield row | {"spindle": block.spindle, "what": block.what.name.lower(), "value": block.value}
        case AxisJob():
            job = {key: value for key, value in asdict(block.job).items() if key not in ("function", "number")}
            row = _source(block.source, "axis job") | {"axis": block.axis, "function": block.job.function.name.lower()}
            yield row | job | {"id": block.id, "waits": block.waits}
        case AxisJobWait():
            yield _source(block.source, "axis job wait") | {"id": block.id}
        case TimerAction():
            yield {**_source(block.source, "timer"), "command": block.command.value, "timer": block.timer}
        case ExternalWrite():
            row = _source(block.source, "external")
            yield row | {"offset": block.offset, "kind": block.kind, "value": block.value}
        case UserError():
            yield {
                **_source(block.source, "error"),
                "number": block.number,
                "multiple": block.multiple,
                "remedy_class": block.remedy_class,
                "values": list(block.values),
                "meanings": list(block.meanings),
                "further": list(block.further),
            }
        case ManualMotion():
            yield {**_source(block.source, "manual"), "kind": block.kind.value, "axes": list(block.axes)}
        case ManualParameter():
            values = {"axis": block.axis, "stage": block.stage, "values": [block.first, block.second]}
            yield {**_source(block.source, "manual parameter"), "kind": block.what.value, **values}
        case Homing():
            yield {**_source(block.source, "homing"), "order": list(block.ranks)}
        case IndependentMotion():
            row = _source(block.source, "own motion") | {"axis": block.axis, "to": block.target}
            yield row | {"velocity": block.velocity, "acceleration": block.acceleration, "jerk": block.jerk}
        case IndependentWait():
            yield _source(block.source, "own motion wait") | {"axes": list(block.axes), "exact": block.exact}
        case CouplingChange():
            yield _source(block.source, "coupling") | {"coupled": [list(pair[:2]) for pair in block.coupled]}
        case Measurement():
            row = _source(block.source, "measurement") | {"axes": [probe.axis for probe in block.probes]}
            yield row | {"signals": [probe.signal.name.lower() for probe in block.probes], "through": block.through}
        case PositionSetting():
            row = _source(block.source, "set position") | {"axis": block.axis}
            yield row | {"offset" if block.relative else "position": block.value}


def _polyline(block: Polyline, names: Sequence[str]) -> Iterator[Row]:
    points = block.points.tolist()
    programmed = programmed_way(block.points - block.pcs_shift, block.pcs_gain).tolist()
    columns = zip(block.feeds.tolist(), block.lines.tolist(), block.numbers.tolist(), strict=True)
    for i, (feed, line, number) in enumerate(columns):
        yield {
            **_source(Source(block.program, line, number if number >= 0 else None), "line"),
            "from": dict(zip(names, points[i], strict=True)),
            "to": dict(zip(names, points[i + 1], strict=True)),
            "to_pcs": dict(zip(names, programmed[i + 1], strict=True)),
            **_feed(feed, math.isinf(feed)),
        }


def _polynomials(block: Polynomials, names: Sequence[str]) -> Iterator[Row]:
    ends = block.ends
    programmed = programmed_way(ends - block.pcs_shift, block.pcs_gain)
    for i, feed in enumerate(block.feeds.tolist()):
        number = int(block.numbers[i])
        yield {
            **_source(Source(block.program, int(block.lines[i]), number if number >= 0 else None), "poly"),
            "from": _axes(block.coefficients[i, 0], names),
            "to": _axes(ends[i], names),
            "to_pcs": _axes(programmed[i], names),
            "coefficients": dict(zip(names, block.coefficients[i].T.tolist(), strict=True)),
            **_feed(feed, math.isinf(feed)),
        }


def _arc(block: Arc, names: Sequence[str]) -> Row:
    outside = [axis for axis in range(len(block.start)) if axis not in block.plane]
    helix = any(block.start[axis] != block.end[axis] for axis in outside)
    first, second = (names[axis] for axis in block.plane)
    return {
        **_source(block.source, "helix" if helix else "arc"),
        "from": _axes(block.start, names),
        "to": _axes(block.end, names),
        "to_pcs": _axes(block.end_pcs, names),
        "centre": {first: float(block.centre[0]), second: float(block.centre[1])},
        "radius": block.radius,
        "angle": block.angle,
        "plane": first + second,
        **_feed(block.feed, math.isinf(block.feed)),
    }


def _spatial_arc(block: SpatialArc, names: Sequence[str]) -> Row:
    return {
        **_source(block.source, "arc"),
        "from": _axes(block.start, names),
        "to": _axes(block.end, names),
        "to_pcs": _axes(block.end_pcs, names),
        "centre": _axes(block.centre, names[:3]),
        "radius": math.dist(block.start[:3], block.centre),
        "angle": block.angle,
        "normal": block.normal.tolist(),
        **_feed(block.feed, math.isinf(block.feed)),
    }


def _source(source: Source, kind: str) -> Row:
    return {"line": source.line, "n": source.n, "program": source.program, "type": kind}


def _axes(position: Floats, names: Sequence[str]) -> dict[str, float]:
    return dict(zip(names, position.tolist(), strict=True))


def _feed(feed: float, rapid: bool) -> Row:
    return {"feed": None if math.isinf(feed) else feed, "rapid": rapid}
