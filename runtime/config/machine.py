"""The machine description: what a machine consists of and what it can do, typed and validated.

Quantities in the YAML file are numbers in the unit given here, or text with a unit ("18 m/min", "0.5 g" is refused, "2 m/s^2"
is not). Inside everything is mm or degrees, and seconds.
"""

from __future__ import annotations

import re
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

_UNITS: dict[str, dict[str, float]] = {
    # dimension: unit -> factor to the internal unit
    "length": {"mm": 1.0, "m": 1000.0, "um": 1e-3, "µm": 1e-3, "inch": 25.4, "deg": 1.0},
    "velocity": {"mm/s": 1.0, "m/min": 1000.0 / 60.0, "m/s": 1000.0, "mm/min": 1.0 / 60.0, "deg/s": 1.0, "rev/min": 6.0},
    "acceleration": {"mm/s^2": 1.0, "m/s^2": 1000.0, "deg/s^2": 1.0, "rev/min/s": 6.0},
    "jerk": {"mm/s^3": 1.0, "m/s^3": 1000.0, "deg/s^3": 1.0, "rev/min/s^2": 6.0},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60.0},
}
_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S*)\s*\Z")


def parse_quantity(value: Any, dimension: str) -> float:
    """A number in the internal unit of `dimension` from a number or a text with a unit; ValueError says what is allowed."""
    if isinstance(value, bool):
        raise ValueError(f"a {dimension} is expected, not {value!r}")
    if isinstance(value, (int, float)):
        return float(value)
    allowed = _UNITS[dimension]
    if isinstance(value, str) and (match := _QUANTITY.match(value)):
        unit = match.group(2).replace("²", "^2").replace("³", "^3")
        if unit == "":
            return float(match.group(1))
        if unit in allowed:
            return float(match.group(1)) * allowed[unit]
        raise ValueError(f"{unit!r} is no unit of {dimension}; known: {', '.join(allowed)}")
    raise ValueError(f"a {dimension} is expected (a number, or a number with one of {', '.join(allowed)}), not {value!r}")


def _quantity(dimension: str) -> BeforeValidator:
    return BeforeValidator(lambda value: parse_quantity(value, dimension))


Length = Annotated[float, _quantity("length")]
Velocity = Annotated[float, _quantity("velocity"), Field(gt=0)]
Acceleration = Annotated[float, _quantity("acceleration"), Field(gt=0)]
Jerk = Annotated[float, _quantity("jerk"), Field(gt=0)]
Seconds = Annotated[float, _quantity("time"), Field(ge=0)]


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class AxisType(StrEnum):
    LINEAR = "linear"
    ROTARY = "rotary"
    SPINDLE = "spindle"


class SimulatedServo(_Model):
    """The second-order servo of a simulated drive."""

    bandwidth_hz: float = Field(40.0, gt=0)
    damping: float = Field(1.0, gt=0)


class Drive(_Model):
    """The CiA 402 drive of an axis."""

    node: int = Field(ge=1, le=127)
    increments_per_unit: float = Field(10_000.0, gt=0)  # per mm or degree
    eds: str | None = None  # file; default: the EDS of the simulated drive
    vendor_id: int | None = None  # checked at start when given (object 0x1018)
    product_code: int | None = None
    sdo: dict[str, int] = Field(default_factory=dict)  # start-up writes: "0x6085" or "0x60C2:1" -> value
    simulated: SimulatedServo = SimulatedServo()


class Axis(_Model):
    """An axis or spindle and what it may be asked to do. Spindles: degrees/s; `rev/min` is allowed as a unit."""

    name: str = Field(pattern=r"^[A-CQS-Z][A-Za-z0-9_]{0,15}$")
    type: AxisType = AxisType.LINEAR
    log_axis: int = Field(ge=1, le=65535)
    position_min: Length | None = None  # software limits
    position_max: Length | None = None
    velocity: Velocity  # greatest velocity, also that of rapid traverse
    acceleration: Acceleration
    jerk: Jerk
    velocity_step: Annotated[float, _quantity("velocity"), Field(ge=0)] = 0.0  # allowed jump of velocity at a corner
    following_error: Length = 5.0  # alarm above it
    in_position: Length = 0.02  # window of standstill
    drive: Drive | None = None

    @model_validator(mode="after")
    def _limits_in_order(self) -> Axis:
        if self.position_min is not None and self.position_max is not None and self.position_min >= self.position_max:
            raise ValueError(f"position_min {self.position_min} is not below position_max {self.position_max}")
        return self


SynchName = Annotated[str, Field(min_length=1)]


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

    feedrate: float = 0.0  # P-CHAN-00099, mm/min


class ChannelParameters(_Model):
    """Channel parameters under their manual names."""

    m_synch: dict[int, SynchName] = Field(default_factory=dict)  # P-CHAN-00041
    h_synch: dict[int, SynchName] = Field(default_factory=dict)  # P-CHAN-00027
    spindel: tuple[ChannelSpindle, ...] = ()
    tool: ChannelTool = ChannelTool()
    prog_start: ProgramStart = ProgramStart()
    max_vb_override: int = Field(1000, ge=0, le=2000)  # P-CHAN-00056, 0.1 %


class Channel(_Model):
    name: str = Field(min_length=1, max_length=31)
    axes: tuple[str, ...] = Field(min_length=1, max_length=8)  # the first three are the main axes
    program_paths: tuple[str, ...] = (".",)  # where global subprograms are looked for
    zero_offsets: dict[str, dict[str, Length]] = Field(default_factory=dict)  # "G54" -> axis -> mm
    parameters: ChannelParameters = ChannelParameters()


class Bus(_Model):
    """The CAN bus, in python-can's terms."""

    interface: Literal["socketcan", "virtual", "udp_multicast"] = "socketcan"
    channel: str = "can0"
    bitrate: int = Field(1_000_000, gt=0)
    options: dict[str, int | float | str | bool] = Field(default_factory=dict)  # handed to python-can as they are
    master_node: int = Field(127, ge=1, le=127)
    heartbeat: Seconds = 0.1  # producer time of the master and the nodes
    heartbeat_timeout: Seconds = 0.3
    boot_timeout: Seconds = 5.0


class IoNode(_Model):
    """A CiA 401 node; its inputs and outputs get the image bits that `inputs` and `outputs` name, in order."""

    node: int = Field(ge=1, le=127)
    eds: str | None = None
    vendor_id: int | None = None
    inputs: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ()


class Fieldbus(_Model):
    bus: Bus = Bus()
    io: tuple[IoNode, ...] = ()


class Plc(_Model):
    program: str | None = None  # "file.py" beside the description, or "package.module:Class"
    every: int = Field(4, ge=1)  # PLC cycle in base cycles
    watchdog: Seconds = 0.05  # longest time without a finished PLC cycle


class Cycle(_Model):
    period: Seconds = 0.001
    cpu: int | None = None  # pin the cycle process to this processor
    priority: int = Field(80, ge=1, le=98)  # SCHED_FIFO; the PLC runs 10 below


class Metrics(_Model):
    enabled: bool = True
    host: str = "127.0.0.1"
    port: int = Field(9402, ge=0, le=65535)


class Machine(_Model):
    """A whole machine."""

    name: str = Field(min_length=1, max_length=31)
    cycle: Cycle = Cycle()
    axes: tuple[Axis, ...] = Field(min_length=1, max_length=16)
    channels: tuple[Channel, ...] = Field(min_length=1, max_length=1)
    fieldbus: Fieldbus = Fieldbus()
    plc: Plc = Plc()
    metrics: Metrics = Metrics()
    state_directory: Path | None = None  # retained data; default: $STATE_DIRECTORY, else ~/.local/state/tandem

    @model_validator(mode="after")
    def _consistent(self) -> Machine:
        names = [axis.name for axis in self.axes]
        for kind, values in (
            ("axis name", names),
            ("log_axis", [axis.log_axis for axis in self.axes]),
        ):
            for value in values:
                if values.count(value) > 1:
                    raise ValueError(f"{kind} {value} stands twice")
        nodes: dict[int, str] = {}
        for owner, node in [(f"axis {a.name}", a.drive.node) for a in self.axes if a.drive] + [
            (f"I/O node {i}", io.node) for i, io in enumerate(self.fieldbus.io)
        ]:
            if node in nodes:
                raise ValueError(f"node id {node} is given to {nodes[node]} and to {owner}")
            nodes[node] = owner
        for channel in self.channels:
            for name in (*channel.axes, *(s.bezeichnung for s in channel.parameters.spindel)):
                if name not in names:
                    raise ValueError(f"channel {channel.name} uses axis {name}, which is not described")
            for offset, values in channel.zero_offsets.items():
                for name in values:
                    if name not in channel.axes:
                        raise ValueError(f"zero offset {offset} of channel {channel.name} names axis {name}")
        return self

    def axis_index(self, name: str) -> int:
        """Index of an axis in `axes`, which is also its index in the HLI and in the drive image."""
        return next(i for i, axis in enumerate(self.axes) if axis.name == name)
