"""The machine description: what a machine consists of and what it can do, typed and validated.

Quantities in the YAML file are numbers in the unit given here, or text with a unit ("18 m/min", "2 m/s^2"; "0.5 g" is
refused). Inside everything is mm or degrees, and seconds.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, BeforeValidator, Field, PrivateAttr, ValidationInfo, model_validator

from runtime.config.analogue import AnalogueInput, AnalogueOutput
from runtime.config.channel.list_file import read_list
from runtime.config.channel.parameters import ChannelParameters, ChannelSpindle, PathKind
from runtime.config.channel.reading import read_parameters
from runtime.config.channel.synchronisation import SYNCH_FLAGS, SYNCH_TYPES
from runtime.config.compensation import Compensation
from runtime.config.consistency import inconsistencies
from runtime.config.contradictions import Contradiction, ContradictionError, Location
from runtime.config.drive import Configuration, Drive, Identity, Pair, SimulatedServo
from runtime.config.external import ExternalVariable, Member
from runtime.config.fir_filter import FirFilter
from runtime.config.measuring import MeasuringSetup
from runtime.config.model import FileBeside, Model, Several, beside, folder_of
from runtime.config.nct import NctParameters
from runtime.config.quantities import UnitError, parse_quantity
from runtime.config.quantity_fields import Acceleration, Jerk, Length, Seconds, Velocity, VelocityStep
from runtime.diagnostics.catalogue import configuration as errors
from runtime.diagnostics.catalogue import spindle
from runtime.diagnostics.errors import Problem

__all__ = [
    "SYNCH_FLAGS",
    "SYNCH_TYPES",
    "Axis",
    "AxisType",
    "Channel",
    "ChannelParameters",
    "ChannelSpindle",
    "Contradiction",
    "ContradictionError",
    "Drive",
    "HomingSetup",
    "Location",
    "Machine",
    "SimulatedServo",
    "TurningAxis",
    "UnitError",
    "parse_quantity",
]


def _program_beside(value: str, info: ValidationInfo) -> str:
    return beside(value, info) if value.endswith(".py") else value


def _list_beside(value: str, info: ValidationInfo) -> str:
    return value if ":" in value else beside(value, info)


def _option(value: object) -> object:
    if not isinstance(value, (int, float, str)):  # bool is an int
        raise ValueError("text, a number, true or false is expected")
    return value


def _readable_list(value: str) -> str:
    try:
        read_list(Path(value))
    except OSError as error:
        values = {"reason": error.strerror or str(error)}
        raise ContradictionError([Contradiction(errors.LIST_NOT_READABLE, (), values)]) from None
    return value


def _parameters(value: object, info: ValidationInfo) -> object:
    """The parameters from their YAML tree and from the list beside it, which has been validated before."""
    chosen = info.data.get("parameter_list")
    if isinstance(value, ChannelParameters):
        if chosen is None:
            return value
        value = {}
    if not isinstance(value, Mapping):
        raise ValueError("a mapping (key: value) is expected")
    return read_parameters(value, None if chosen is None else Path(chosen), folder_of(info))


Option = Annotated[int | float | str | bool, BeforeValidator(_option)]
ParameterList = Annotated[FileBeside, AfterValidator(_readable_list)]


class AxisType(StrEnum):
    LINEAR = "linear"
    ROTARY = "rotary"
    SPINDLE = "spindle"


class AbsoluteEncoder(Model):
    """An encoder that knows its place without supply: a reference that was found once is kept."""

    range: Annotated[Length, Field(gt=0)] | None = (
        None  # way after which it counts anew; default: 32 bits of increments
    )
    moved: Annotated[Length, Field(gt=0)] = 1.0  # how far the axis may have been moved without supply

    def turn(self, increments_per_unit: float) -> float:
        """The way after which the drive counts anew."""
        return self.range or 2.0**32 / increments_per_unit


class HomingSetup(Model):
    """How an axis finds its reference: by its drive if there is a `method`, else at the end of a cam, which it looks for.

    The cam is the input `switch`, or the PLC tells it by the control unit reference_cam of the axis.
    """

    method: Annotated[int, Field(ge=-128, le=37)] | None = None  # 0x6098: the drive homes, in mode 6
    timeout: Seconds = 60.0  # that the drive gets for it
    switch: str | None = None  # name of an input
    direction: Literal["negative", "positive"] = "negative"
    fast: Velocity
    slow: Velocity
    position: Length = 0.0  # of the axis where it leaves the cam, or where its drive counts 0
    way: Annotated[Length, Field(gt=0)] | None = None  # greatest way in one direction; default: 1.1 times the travel
    absolute: AbsoluteEncoder | None = None  # the encoder is absolute: a reference that was found once is kept


class FeedHoldRamp(Model):
    """How an axis brakes in feed hold if P-CHAN-00097 is set; what is left out is that of the axis."""

    deceleration: Acceleration | None = None  # P-AXIS-00024; never more than the acceleration of the axis
    ramp_time: Annotated[Seconds, Field(gt=0)] | None = None  # P-AXIS-00081, in which it builds up


class TurningAxis(Model):
    """What an axis is for turning (P-AXIS-00015): the facing axis moves across the turning axis."""

    kind: Literal["facing", "longitudinal"]
    diameter_absolute: bool = True  # P-AXIS-00058, with G51 its values are diameters under G90
    diameter_incremental: bool = False  # P-AXIS-00059, the same under G91

    @property
    def facing(self) -> bool:
        """Its values are distances from the turning centre."""
        return self.kind == "facing"


class GearStage(Model):
    """Dynamic data of a gear stage of a spindle (M40 is stage 1)."""

    velocity: Velocity
    acceleration: Acceleration
    jerk: Jerk


class Axis(Model):
    """An axis or spindle and what it may be asked to do, in mm or, if it turns, degrees, and seconds."""

    name: str = Field(pattern=r"^[A-CQS-Z][A-Za-z0-9_]{0,15}$")
    type: Annotated[AxisType, Field(strict=False)] = AxisType.LINEAR  # before the quantities: it decides their units
    log_axis: int = Field(ge=1, le=65535)
    position_min: Length | None = None  # software limits
    position_max: Length | None = None
    limit_tolerance: Annotated[Length, Field(ge=0)] = 0.0  # P-AXIS-00179, beyond them at rest (P-CHAN-00120)
    velocity: Velocity  # greatest velocity, also that of rapid traverse
    acceleration: Acceleration
    jerk: Jerk
    velocity_step: VelocityStep = 0.0  # allowed jump of velocity at a corner
    following_error: Annotated[Length, Field(gt=0)] = 5.0  # alarm above it
    in_position: Annotated[Length, Field(gt=0)] = 0.02  # window of standstill
    jog_velocity: Velocity | None = None  # by hand, until the PLC or the program names another; default: a tenth
    feed_hold: FeedHoldRamp = FeedHoldRamp()
    homing: HomingSetup | None = None  # None: the encoder is absolute, the axis has its reference always
    reference_points: Several[Length] = Field(
        default=(), max_length=3
    )  # the second to the fourth one (G30 P2 to P4, NCT dialect)
    measuring: MeasuringSetup | None = None  # P-AXIS-00118; None: the axis does not measure
    drive: Drive | None = None
    compensation: Compensation | None = None
    fir_filter: FirFilter | None = None  # of the set-points of the path (#FILTER)
    turning: TurningAxis | None = None
    gear_stages: Several[GearStage] = Field(default=(), max_length=6)  # of a spindle; without: one stage

    @property
    def turns_without_end(self) -> bool:
        """A rotary axis without software limits: a modulo axis."""
        return self.type is AxisType.ROTARY and self.position_min is None and self.position_max is None

    @model_validator(mode="after")
    def _limits_in_order(self) -> Axis:
        if self.position_min is not None and self.position_max is not None and self.position_min >= self.position_max:
            values = {"axis": self.name, "minimum": self.position_min, "maximum": self.position_max}
            raise ContradictionError([Contradiction(errors.LIMITS_REVERSED, ("position_min",), values)])
        if self.turning is not None and self.type is not AxisType.LINEAR:
            values = {"axis": self.name, "type": self.type.value}
            raise ContradictionError([Contradiction(spindle.TURNING_LINEAR, ("turning",), values)])
        return self


ZeroOffsetName = Annotated[str, Field(pattern=r"^G5[4-9]$")]


class Channel(Model):
    name: str = Field(min_length=1, max_length=31)
    axes: Several[str] = Field(min_length=1, max_length=8)  # the first three are the main axes
    program_paths: Several[FileBeside] = (".",)  # where programs are looked for, if there are no path[] parameters
    zero_offsets: dict[ZeroOffsetName, dict[str, Length]] = Field(default_factory=dict)  # "G54" -> axis -> mm
    dialect: Literal["isg", "nct"] = "isg"  # in which its programs are written
    backward_storage: int = Field(default=0, ge=0, le=20_000)  # records of path for backward motion (P-STUP-00033)
    nct: NctParameters = NctParameters()  # parameters of programs in the NCT dialect
    parameter_list: ParameterList | None = None  # list file of channel parameters; before `parameters`, which read it
    parameters: Annotated[ChannelParameters, BeforeValidator(_parameters)] = Field(
        default=ChannelParameters(), validate_default=True
    )

    @model_validator(mode="after")
    def _paths_once(self) -> Channel:
        if self.parameters.path and "program_paths" in self.model_fields_set:
            values = {"channel": self.name}
            raise ContradictionError([Contradiction(errors.PATHS_TWICE, ("program_paths",), values, at_key=True)])
        return self

    def number(self, index: int) -> int:
        """The number of the channel: its own (P-CHAN-00400), else its place in the list, from 1."""
        return self.parameters.channel_id or index + 1

    def folders(self, kind: PathKind) -> tuple[str, ...]:
        """The folders of a kind, in the order in which they are searched: `path[]`, or else `program_paths`.

        `program_paths` hold main programs and subroutines.
        """
        if self.parameters.path:
            return self.parameters.folders(kind)
        return self.program_paths if kind & (PathKind.MAIN | PathKind.SUBROUTINE) else ()


class Bus(Model):
    """The CAN bus, in python-can's terms."""

    interface: Literal["socketcan", "virtual", "udp_multicast"] = "socketcan"
    channel: str = "can0"
    bitrate: int = Field(default=1_000_000, gt=0)
    fd: bool = False  # frames in the format of CAN FD with a faster data phase; the protocol stays that of CiA 301
    data_bitrate: int = Field(default=4_000_000, gt=0)  # of the data phase
    options: dict[str, Option] = Field(default_factory=dict)  # handed to python-can as they are
    master_node: int = Field(default=127, ge=1, le=127)
    heartbeat: Seconds = 0.1  # producer time of the master and the nodes
    heartbeat_timeout: Seconds = 0.3
    boot_timeout: Seconds = 5.0
    sync_counter: Annotated[int, Field(ge=2, le=240)] | None = None  # SYNC counts 1 to this (object 0x1019)
    time_stamp: Seconds | None = None  # the master sends TIME (0x100) this often
    recovery: Literal["automatic", "manual"] = "automatic"  # of a bus that is gone; manual: by a reset
    recovery_pause: Seconds = 0.2  # until it is tried again
    recovery_count: Annotated[int, Field(ge=1)] | None = None  # without a reset between; default: as often as it likes


class IoNode(Model):
    """A CiA 401 node; its inputs and outputs get the image bits that `inputs` and `outputs` name, in order."""

    node: int = Field(ge=1, le=127)
    bus: str | None = None  # name in fieldbus.buses; default: fieldbus.bus
    eds: FileBeside | None = None
    vendor_id: Identity | None = None
    inputs: Several[str] = ()
    outputs: Several[str] = ()
    analogue_inputs: Several[AnalogueInput] = ()
    analogue_outputs: Several[AnalogueOutput] = ()
    analogue_every: int = Field(default=10, ge=1, le=240)  # cycles, between two values of an analogue input
    left_adjusted: bool = False  # counts of 0x6426 and 0x6444 stand in the upper bits of their 32
    optional: bool = False  # the machine starts without it, and takes it in when it comes
    configuration: Configuration | None = None  # 0x1020: date and time, checked
    dcf: FileBeside | None = None  # DCF or concise DCF: what the device is set to before it starts
    dcf_store: bool = False  # the device keeps it (0x1010), if it was not set so already


BusName = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,15}$")]


class Fieldbus(Model):
    """The buses with their nodes. All of them run in the same cycle, each with a SYNC of its own."""

    bus: Bus = Bus()
    buses: Annotated[dict[BusName, Bus], Field(max_length=3)] = Field(default_factory=dict)  # further ones, by name
    io: Several[IoNode] = ()
    workpiece: dict[str, Pair] = Field(
        default_factory=dict
    )  # what the probes of simulated drives meet: axis → from, to

    def all_buses(self) -> dict[str, Bus]:
        """Name → bus; the first one has the name ""."""
        return {"": self.bus, **self.buses}


class Plc(Model):
    program: Annotated[str, Field(min_length=1), AfterValidator(_program_beside)] | None = (
        None  # "file.py" beside the description, or "package.module:Class"
    )
    every: int = Field(default=4, ge=1)  # PLC cycle in base cycles
    watchdog: Seconds = 0.05  # longest time without a finished PLC cycle
    memory: Annotated[int, Field(ge=16)] = 1024  # MB that the program may take


class Cycle(Model):
    period: Annotated[Seconds, Field(ge=0.0001, le=0.02)] = 0.001
    cpu: Annotated[int, Field(ge=0)] | None = None  # pin the cycle process to this processor
    priority: int = Field(default=80, ge=1, le=98)  # SCHED_FIFO; the PLC runs 10 below


class Metrics(Model):
    enabled: bool = True
    host: str = "127.0.0.1"
    port: int = Field(default=9402, ge=0, le=65535)


class HliAccess(Model):
    """What members of the service's group may do with the interface memory; others may nothing, its owner everything."""

    group: Literal["none", "read", "command"] = "read"

    @property
    def permissions(self) -> int:
        """Mode of the memory's file."""
        return {"none": 0o600, "read": 0o640, "command": 0o660}[self.group]


KeyframesWhen = Literal["always", "standstill", "drives_off"]


class Recorder(Model):
    """The flight recorder: what the cycle takes in and gives out, for `tandem replay`."""

    enabled: bool = True
    minutes: Annotated[float, Field(gt=0)] = 10.0  # that are kept while the machine runs
    size: Annotated[int, Field(ge=8)] = 1024  # MB of the disk that they may take
    keyframe_every: Seconds = 30.0  # a replay begins at a keyframe
    keyframes: KeyframesWhen = "always"  # when one may be taken: it makes a cycle longer
    saved: Annotated[int, Field(ge=0)] = 5  # recordings of alarms that are kept


class ToolTable(Model):
    """Where the tools are that D words select: a table, if the channel has no external tool management."""

    database: FileBeside | None = None  # SQLite; default: tools.db in the state directory
    initial_list: Annotated[str, Field(min_length=1), AfterValidator(_list_beside)] | None = (
        None  # tool list that the table begins with, when it is made: "file.lis" beside the description, or "package:file.lis"
    )
    answer_timeout: Seconds = 10.0  # that an external tool management has to answer


class Machine(Model):
    """A whole machine."""

    name: str = Field(min_length=1, max_length=31)
    cycle: Cycle = Cycle()
    axes: Several[Axis] = Field(min_length=1, max_length=16)
    channels: Several[Channel] = Field(min_length=1, max_length=1)
    structures: dict[str, Annotated[Several[Member], Field(min_length=1)]] = Field(default_factory=dict)
    external_variables: Several[ExternalVariable] = ()  # V.E, shared with the PLC
    fieldbus: Fieldbus = Fieldbus()
    plc: Plc = Plc()
    metrics: Metrics = Metrics()
    hli: HliAccess = HliAccess()
    tools: ToolTable = ToolTable()
    recorder: Recorder = Recorder()
    error_texts: FileBeside | None = None  # texts for #ERROR, lines `number text`
    state_directory: Annotated[Path, Field(strict=False)] | None = (
        None  # retained data; default: $STATE_DIRECTORY, else ~/.local/state/tandem
    )

    _warnings: tuple[Problem, ...] = PrivateAttr(default=())

    @model_validator(mode="after")
    def _consistent(self) -> Machine:
        if found := [*inconsistencies(self)]:
            raise ContradictionError(found)
        return self._without_absent_spindles()

    def _without_absent_spindles(self) -> Machine:
        """Spindles that are optional (P-CHAN-00415) and not described are none of their channel."""
        known = {axis.name for axis in self.axes}
        if all(spindle.bezeichnung in known for channel in self.channels for spindle in channel.parameters.spindel):
            return self
        channels = []
        for channel in self.channels:
            there = tuple(spindle for spindle in channel.parameters.spindel if spindle.bezeichnung in known)
            parameters = channel.parameters.model_copy(update={"spindel": there})
            channels.append(channel.model_copy(update={"parameters": parameters}))
        return self.model_copy(update={"channels": tuple(channels)})

    @property
    def drive_nodes(self) -> tuple[tuple[str, int, int], ...]:
        """Bus, node id and index of the axis of every drive, in the order of the axes; a gantry has two."""
        found = []
        for index, axis in enumerate(self.axes):
            if drive := axis.drive:
                found.append((drive.bus or "", drive.node, index))
                if drive.gantry:
                    found.append((drive.bus or "", drive.gantry.node, index))
        return tuple(found)

    def axis_index(self, name: str) -> int:
        """Index of an axis in `axes`, which is also its index in the HLI and in the drive image."""
        return next(i for i, axis in enumerate(self.axes) if axis.name == name)

    @property
    def warnings(self) -> tuple[Problem, ...]:
        """What was found while the description was read and is no mistake, in the order of the file."""
        return self._warnings
