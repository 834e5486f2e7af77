"""The machine description: what a machine consists of and what it can do, typed and validated.

Quantities in the YAML file are numbers in the unit given here, or text with a unit ("18 m/min", "2 m/s^2"; "0.5 g" is
refused). Inside everything is mm or degrees, and seconds.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Literal, TypeVar

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, ValidationInfo, model_validator

from runtime.diagnostics.catalogue import configuration as errors
from runtime.diagnostics.errors import ErrorEntry

_UNITS: dict[str, dict[str, float]] = {
    # dimension: unit -> factor to the internal unit
    "length": {"mm": 1.0, "m": 1000.0, "um": 1e-3, "µm": 1e-3, "inch": 25.4},
    "angle": {"deg": 1.0},
    "velocity": {"mm/s": 1.0, "m/min": 1000.0 / 60.0, "m/s": 1000.0, "mm/min": 1.0 / 60.0},
    "angular velocity": {"deg/s": 1.0, "rev/min": 6.0},
    "acceleration": {"mm/s^2": 1.0, "m/s^2": 1000.0},
    "angular acceleration": {"deg/s^2": 1.0, "rev/min/s": 6.0},
    "jerk": {"mm/s^3": 1.0, "m/s^3": 1000.0},
    "angular jerk": {"deg/s^3": 1.0, "rev/min/s^2": 6.0},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60.0},
}
_ANGULAR = {  # what a dimension is at an axis that turns
    "length": "angle",
    "velocity": "angular velocity",
    "acceleration": "angular acceleration",
    "jerk": "angular jerk",
}
_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S*)\s*\Z")

SYNCH_TYPES = ("NOT_VALID", "NO_SYNCH", "MOS", "MVS_SVS", "MVS_SNS", "MNS_SNS")
SYNCH_FLAGS = ("PLC_INFO",)  # may be added to a type with "|"

Location = tuple[str | int, ...]  # keys and list indices from the root of the description


class UnitError(ValueError):
    """A quantity whose unit does not belong to its dimension."""

    def __init__(self, unit: str, dimension: str, allowed: tuple[str, ...]) -> None:
        self.unit, self.dimension, self.allowed = unit, dimension, allowed
        super().__init__(f"{unit!r} is no unit of {dimension}; known: {', '.join(allowed)}")


class SynchError(ValueError):
    """A text that names no synchronisation type."""

    def __init__(self, name: str, allowed: tuple[str, ...]) -> None:
        self.name, self.allowed = name, allowed
        super().__init__(f"{name!r} is no synchronisation type; known: {', '.join(allowed)}")


@dataclass(frozen=True, slots=True)
class Contradiction:
    """Two parts of the description that do not fit together; `location` is the part to blame."""

    entry: ErrorEntry
    location: Location
    values: Mapping[str, object]
    at_key: bool = False  # the key itself is to blame, not its value


class ContradictionError(ValueError):
    """Everything found that does not fit together; locations count from the model whose validator raised it."""

    def __init__(self, contradictions: Iterable[Contradiction]) -> None:
        self.contradictions = tuple(contradictions)
        super().__init__("; ".join(c.entry.text.format(**c.values) for c in self.contradictions))


def parse_quantity(value: object, dimension: str, *, angular: bool | None = None) -> float:
    """A number in the internal unit of `dimension` from a number or a text with a unit.

    `angular` tells whether the quantity belongs to an axis that turns; None allows both. Raises UnitError for a unit of
    something else, ValueError for what is no quantity.
    """
    allowed = dict(_UNITS[dimension]) if not (angular and dimension in _ANGULAR) else {}
    if angular is not False and dimension in _ANGULAR:
        allowed |= _UNITS[_ANGULAR[dimension]]
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    if isinstance(value, str) and (match := _QUANTITY.match(value)):
        unit = match.group(2).replace("²", "^2").replace("³", "^3")
        if unit == "":
            return float(match.group(1))
        if unit in allowed:
            return float(match.group(1)) * allowed[unit]
        name = _ANGULAR.get(dimension, dimension) if angular else dimension
        raise UnitError(match.group(2), name, tuple(allowed))
    raise ValueError(f"a number with or without a unit ({', '.join(allowed)}) is expected")


def _quantity(dimension: str) -> BeforeValidator:
    def parse(value: object, info: ValidationInfo) -> float:
        axis_type = info.data.get("type") if info.data else None  # of the axis the quantity belongs to
        return parse_quantity(value, dimension, angular=None if axis_type is None else axis_type != AxisType.LINEAR)

    return BeforeValidator(parse)


def _synch_name(value: str) -> str:
    names = [name.strip() for name in value.split("|")]
    for name in names:
        if name not in SYNCH_TYPES + SYNCH_FLAGS:
            raise SynchError(name, SYNCH_TYPES + SYNCH_FLAGS)
    if sum(name in SYNCH_TYPES for name in names) != 1:
        raise ValueError(
            f"exactly one of {', '.join(SYNCH_TYPES)} is expected, with {', '.join(SYNCH_FLAGS)} added or not"
        )
    return value


def _beside(value: str, info: ValidationInfo) -> str:
    """Paths in a description count from its folder, wherever the command is given."""
    folder = (info.context or {}).get("folder")
    return value if folder is None else str((Path(folder) / value).absolute())


def _program_beside(value: str, info: ValidationInfo) -> str:
    return _beside(value, info) if value.endswith(".py") else value


def _option(value: object) -> object:
    if not isinstance(value, (int, float, str)):  # bool is an int
        raise ValueError("text, a number, true or false is expected")
    return value


T = TypeVar("T")
Several = Annotated[tuple[T, ...], Field(strict=False)]  # a YAML list
Length = Annotated[float, _quantity("length")]
Velocity = Annotated[float, _quantity("velocity"), Field(gt=0)]
Acceleration = Annotated[float, _quantity("acceleration"), Field(gt=0)]
Jerk = Annotated[float, _quantity("jerk"), Field(gt=0)]
Seconds = Annotated[float, _quantity("time"), Field(gt=0)]
Option = Annotated[int | float | str | bool, BeforeValidator(_option)]
Identity = Annotated[int, Field(ge=0, le=0xFFFFFFFF)]  # of CANopen object 0x1018
FileBeside = Annotated[str, Field(min_length=1), AfterValidator(_beside)]


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class AxisType(StrEnum):
    LINEAR = "linear"
    ROTARY = "rotary"
    SPINDLE = "spindle"


class SimulatedServo(_Model):
    """The second-order servo of a simulated drive."""

    bandwidth_hz: float = Field(default=40.0, gt=0)
    damping: float = Field(default=1.0, gt=0)


class Drive(_Model):
    """The CiA 402 drive of an axis."""

    node: int = Field(ge=1, le=127)
    increments_per_unit: float = Field(default=10_000.0, gt=0)  # per mm or degree
    eds: FileBeside | None = None  # default: the EDS of the simulated drive
    vendor_id: Identity | None = None  # checked at start when given (object 0x1018)
    product_code: Identity | None = None
    sdo: dict[str, int] = Field(default_factory=dict)  # start-up writes: "0x6085" or "0x60C2:1" -> value
    simulated: SimulatedServo = SimulatedServo()
    optional: bool = False  # the machine starts without it, and takes it in when it comes
    configuration: Annotated[tuple[Identity, Identity], Field(strict=False)] | None = (
        None  # 0x1020: date and time, checked
    )


class Axis(_Model):
    """An axis or spindle and what it may be asked to do, in mm or, if it turns, degrees, and seconds."""

    name: str = Field(pattern=r"^[A-CQS-Z][A-Za-z0-9_]{0,15}$")
    type: Annotated[AxisType, Field(strict=False)] = AxisType.LINEAR  # before the quantities: it decides their units
    log_axis: int = Field(ge=1, le=65535)
    position_min: Length | None = None  # software limits
    position_max: Length | None = None
    velocity: Velocity  # greatest velocity, also that of rapid traverse
    acceleration: Acceleration
    jerk: Jerk
    velocity_step: Annotated[float, _quantity("velocity"), Field(ge=0)] = 0.0  # allowed jump of velocity at a corner
    following_error: Annotated[Length, Field(gt=0)] = 5.0  # alarm above it
    in_position: Annotated[Length, Field(gt=0)] = 0.02  # window of standstill
    drive: Drive | None = None

    @model_validator(mode="after")
    def _limits_in_order(self) -> Axis:
        if self.position_min is not None and self.position_max is not None and self.position_min >= self.position_max:
            values = {"axis": self.name, "minimum": self.position_min, "maximum": self.position_max}
            raise ContradictionError([Contradiction(errors.LIMITS_REVERSED, ("position_min",), values)])
        return self


SynchName = Annotated[str, AfterValidator(_synch_name)]
FunctionNumber = Annotated[int, Field(ge=0, le=999)]
ZeroOffsetName = Annotated[str, Field(pattern=r"^G5[4-9]$")]


class ChannelSpindle(_Model):
    """A spindle of a channel, under the names of the channel parameters (manual line 3772 and following)."""

    bezeichnung: str  # name of the axis
    s_synch: SynchName = "NO_SYNCH"
    m3_synch: SynchName = "NO_SYNCH"
    m4_synch: SynchName = "NO_SYNCH"
    m5_synch: SynchName = "NO_SYNCH"


class ChannelTool(_Model):
    """`tool.synch` (P-CHAN-00086)."""

    synch: SynchName = "NO_SYNCH"


class ProgramStart(_Model):
    """`prog_start.*`: what holds when a program starts."""

    feedrate: float = Field(default=0.0, ge=0)  # P-CHAN-00099, mm/min


class ChannelParameters(_Model):
    """Channel parameters under their manual names."""

    m_synch: dict[FunctionNumber, SynchName] = Field(default_factory=dict)  # P-CHAN-00041
    h_synch: dict[FunctionNumber, SynchName] = Field(default_factory=dict)  # P-CHAN-00027
    spindel: Several[ChannelSpindle] = ()
    tool: ChannelTool = ChannelTool()
    prog_start: ProgramStart = ProgramStart()
    max_vb_override: int = Field(default=1000, ge=0, le=2000)  # P-CHAN-00056, 0.1 %


class Channel(_Model):
    name: str = Field(min_length=1, max_length=31)
    axes: Several[str] = Field(min_length=1, max_length=8)  # the first three are the main axes
    program_paths: Several[FileBeside] = (".",)  # where global subprograms are looked for
    zero_offsets: dict[ZeroOffsetName, dict[str, Length]] = Field(default_factory=dict)  # "G54" -> axis -> mm
    parameters: ChannelParameters = ChannelParameters()


class Bus(_Model):
    """The CAN bus, in python-can's terms."""

    interface: Literal["socketcan", "virtual", "udp_multicast"] = "socketcan"
    channel: str = "can0"
    bitrate: int = Field(default=1_000_000, gt=0)
    options: dict[str, Option] = Field(default_factory=dict)  # handed to python-can as they are
    master_node: int = Field(default=127, ge=1, le=127)
    heartbeat: Seconds = 0.1  # producer time of the master and the nodes
    heartbeat_timeout: Seconds = 0.3
    boot_timeout: Seconds = 5.0
    sync_counter: Annotated[int, Field(ge=2, le=240)] | None = None  # SYNC counts 1 to this (object 0x1019)
    time_stamp: Seconds | None = None  # the master sends TIME (0x100) this often


class IoNode(_Model):
    """A CiA 401 node; its inputs and outputs get the image bits that `inputs` and `outputs` name, in order."""

    node: int = Field(ge=1, le=127)
    eds: FileBeside | None = None
    vendor_id: Identity | None = None
    inputs: Several[str] = ()
    outputs: Several[str] = ()
    optional: bool = False  # the machine starts without it, and takes it in when it comes
    configuration: Annotated[tuple[Identity, Identity], Field(strict=False)] | None = (
        None  # 0x1020: date and time, checked
    )


class Fieldbus(_Model):
    bus: Bus = Bus()
    io: Several[IoNode] = ()


class Plc(_Model):
    program: Annotated[str, Field(min_length=1), AfterValidator(_program_beside)] | None = (
        None  # "file.py" beside the description, or "package.module:Class"
    )
    every: int = Field(default=4, ge=1)  # PLC cycle in base cycles
    watchdog: Seconds = 0.05  # longest time without a finished PLC cycle


class Cycle(_Model):
    period: Annotated[Seconds, Field(ge=0.0001, le=0.02)] = 0.001
    cpu: Annotated[int, Field(ge=0)] | None = None  # pin the cycle process to this processor
    priority: int = Field(default=80, ge=1, le=98)  # SCHED_FIFO; the PLC runs 10 below


class Metrics(_Model):
    enabled: bool = True
    host: str = "127.0.0.1"
    port: int = Field(default=9402, ge=0, le=65535)


class Machine(_Model):
    """A whole machine."""

    name: str = Field(min_length=1, max_length=31)
    cycle: Cycle = Cycle()
    axes: Several[Axis] = Field(min_length=1, max_length=16)
    channels: Several[Channel] = Field(min_length=1, max_length=1)
    fieldbus: Fieldbus = Fieldbus()
    plc: Plc = Plc()
    metrics: Metrics = Metrics()
    state_directory: Annotated[Path, Field(strict=False)] | None = (
        None  # retained data; default: $STATE_DIRECTORY, else ~/.local/state/tandem
    )

    @model_validator(mode="after")
    def _consistent(self) -> Machine:
        if found := [*_twice(self), *_shared_nodes(self), *_unknown_axes(self), *_short_watchdogs(self)]:
            raise ContradictionError(found)
        return self

    def axis_index(self, name: str) -> int:
        """Index of an axis in `axes`, which is also its index in the HLI and in the drive image."""
        return next(i for i, axis in enumerate(self.axes) if axis.name == name)


def _twice(machine: Machine) -> Iterator[Contradiction]:
    """Axis names and logical axis numbers are given once."""
    for key, what in (("name", "Axis name"), ("log_axis", "Logical axis number")):
        seen: set[object] = set()
        for index, axis in enumerate(machine.axes):
            value = getattr(axis, key)
            if value in seen:
                yield Contradiction(errors.NOT_UNIQUE, ("axes", index, key), {"what": what, "value": value})
            seen.add(value)


def _shared_nodes(machine: Machine) -> Iterator[Contradiction]:
    """A CANopen node id belongs to one device; the master is one too."""
    owners: dict[int, str] = {machine.fieldbus.bus.master_node: "the master (fieldbus.bus.master_node)"}
    used: list[tuple[int, str, Location]] = [
        (axis.drive.node, f"axis {axis.name}", ("axes", index, "drive", "node"))
        for index, axis in enumerate(machine.axes)
        if axis.drive
    ]
    used += [
        (io.node, f"I/O node fieldbus.io[{index}]", ("fieldbus", "io", index, "node"))
        for index, io in enumerate(machine.fieldbus.io)
    ]
    for node, owner, location in used:
        if node in owners:
            yield Contradiction(errors.NODE_TWICE, location, {"node": node, "first": owners[node], "second": owner})
        else:
            owners[node] = owner


def _unknown(
    location: Location, user: str, axis: str, reason: str, known: str, *, at_key: bool = False
) -> Contradiction:
    values = {"user": user, "axis": axis, "reason": reason, "known": known}
    return Contradiction(errors.UNKNOWN_AXIS, location, values, at_key)


def _unknown_axes(machine: Machine) -> Iterator[Contradiction]:
    """A channel uses axes that are described, its spindles are spindles, its zero offsets shift its own axes."""
    types = {axis.name: axis.type for axis in machine.axes}
    for index, channel in enumerate(machine.channels):
        user = f"Channel {channel.name}"
        known = ", ".join(types)

        for number, name in enumerate(channel.axes):
            location: Location = ("channels", index, "axes", number)
            if name not in types:
                yield _unknown(location, user, name, "is not described under axes", known)
            elif name in channel.axes[:number]:
                yield _unknown(location, user, name, "stands in the list already", known)
        for number, spindle in enumerate(channel.parameters.spindel):
            location = ("channels", index, "parameters", "spindel", number, "bezeichnung")
            name = spindle.bezeichnung
            if name not in types:
                yield _unknown(location, user, name, "is not described under axes", known)
            elif types[name] is not AxisType.SPINDLE:
                values = {"channel": channel.name, "axis": name, "type": types[name].value}
                yield Contradiction(errors.SPINDLE_EXPECTED, location, values)
        for offset, shifts in channel.zero_offsets.items():
            for name in shifts:
                if name not in channel.axes:
                    location = ("channels", index, "zero_offsets", offset, name)
                    user = f"Zero offset {offset} of channel {channel.name}"
                    yield _unknown(
                        location, user, name, "is no axis of the channel", ", ".join(channel.axes), at_key=True
                    )


def _short_watchdogs(machine: Machine) -> Iterator[Contradiction]:
    """A time limit longer than what it watches, else it fires on a healthy machine."""
    bus, plc = machine.fieldbus.bus, machine.plc
    for what, timeout, of_what, cycle, location in (
        ("The PLC watchdog", plc.watchdog, "the PLC cycle", plc.every * machine.cycle.period, ("plc", "watchdog")),
        (
            "The heartbeat timeout",
            bus.heartbeat_timeout,
            "the heartbeat's producer time",
            bus.heartbeat,
            ("fieldbus", "bus", "heartbeat_timeout"),
        ),
    ):
        if timeout <= cycle:
            values = {"what": what, "timeout": timeout, "cycle": cycle, "of_what": of_what}
            yield Contradiction(errors.WATCHDOG_TOO_SHORT, location, values)
