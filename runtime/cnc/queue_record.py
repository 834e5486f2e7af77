"""A record of the motion queue in typed words, for the channel: what is passed, what a gate waits for."""

from __future__ import annotations

from typing import NamedTuple

from runtime.cnc.blocks import Synch, Technology
from runtime.cnc.motion_queue import ActionKind, GateReason, MotionQueue, RecordKind


class QueueRecord(NamedTuple):
    """Technology fields hold for FUNCTION and FUNCTION_AHEAD, reason for GATE; `feed` in mm/s for elements. `seconds`
    is how long a gate dwells, or a function is expected to take.

    `synch` of a WAIT gate are the types that are waited for; `area` and `lead` as in TechnologyFunction.

    `offset` and `size` of a T function are sister and variant number of the tool.

    `text`, -1 for none, is an index into the texts of the queue. `number` and `value` of

    - a message: 1 if it goes to the PLC, and 1 if it is information; `size` its receiver (position in `Receiver`);
    - the gate of a message: how many messages for the PLC stand up to here, and 1 if its receiver has to take it first;
    - a setting of a spindle: what it is (SpindleValue), and the value; `spindle` which one;
    - the gate of axis jobs: the id that is waited for, -1 those of the block (a job itself: `job_records`);
    - a timer: its number, and its command (position in `TimerCommand`);
    - an external variable: its type (position in `runtime.hli.external.KINDS`), and its value; `offset` and `size` in bytes;
    - an error: its number, and its remedy class;
    - tool life: its command (position in `LifeCommand`), and the distance (mm) or its factor; `seconds` the time (s) or its
      factor; `offset`, `size`, `feed`: basic, sister and variant number.
    - the gate of #FILTER: `value` the share, `seconds` the cut-off frequency (Hz), `lead` the quality, NaN: those of the axis;
      the halves of the filters (cycles) stand in `end` of the record;
    - G200, G201, G202: the axes as bits; G74: four bits per axis, its turn;
    - SET_POSITION: the axis, and the position, or with `offset` 1 the way;
    - an own motion of an axis: the axis, and the target; `feed`, `lead`, `seconds` velocity, acceleration and jerk in s;
    - the gate that waits for own motions: the axes as bits; `offset` 1: until they are in their windows;
    - limits of an actual position: the axis, and the lower one; `seconds` the upper one, `offset` 1: the path stops;
    - what of the operator has no effect: 1 feed hold, 2 override;
    - the gates of threads and tapping: `mask` the spindle, `value` its angle at the begin; `number` 1: it is measured, over
      `size` cycles; `offset` 1: its override stays;
    - a cutting speed: mm/min as `value`, the spindle, the axis as `number`, its centre (mm) as `lead`, and the limit (rev/min) as
      `seconds`;
    - a parameter of manual mode: the axis, and the first value; `offset` its kind (position in `ManualValue`), `size` its stage,
      `seconds` the second value.
    """

    kind: RecordKind
    line: int
    n: int | None
    technology: Technology
    number: int
    value: float
    synch: Synch
    spindle: int
    reason: GateReason
    seconds: float
    feed: float
    action: ActionKind
    text: int
    offset: int
    size: int
    program: int
    area: int
    lead: float
    angle: float  # of M19, degrees
    sense: int
    override_off: bool
    plc_spindle: int
    mask: int = 0  # of the gate of a section that may be left out; `number` 0 plain, 1 SIMULATE, 2 with this mask


def read_record(queue: MotionQueue, index: int) -> QueueRecord:
    """The record of an absolute index; valid while it is not freed."""
    record = queue.record(index)
    kind = RecordKind(int(record["kind"]))
    n = int(record["n"])
    function = kind is RecordKind.FUNCTION or kind is RecordKind.FUNCTION_AHEAD
    return QueueRecord(
        kind=kind,
        line=int(record["line"]),
        n=None if n < 0 else n,
        technology=Technology(int(record["function"])) if function else Technology.M,
        number=int(record["number"]),
        value=float(record["value"]),
        synch=Synch(int(record["synch"])),
        spindle=int(record["spindle"]) if function or kind is RecordKind.ACTION else -1,
        reason=GateReason(int(record["reason"])) if kind is RecordKind.GATE else GateReason.WAIT,
        seconds=float(record["seconds"]),
        feed=float(record["feed"]),
        action=ActionKind(int(record["action"])),
        text=int(record["text"]),
        offset=int(record["offset"]),
        size=int(record["size"]),
        program=int(record["program"]),
        area=int(record["area"]),
        lead=float(record["lead"]),
        angle=float(record["spindle_angle"]),
        sense=int(record["sense"]),
        override_off=bool(record["override_off"]),
        plc_spindle=int(record["plc_spindle"]),
        mask=int(record["spindle"]),
    )
