"""The CiA 402 drive of an axis: node, modes, what is exchanged with it, how it reacts and how it counts."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from runtime.config.model import FileBeside, Model, Several
from runtime.config.quantity_fields import Length, Seconds
from runtime.drives import DriveMode

Identity = Annotated[int, Field(ge=0, le=0xFFFFFFFF)]  # of CANopen object 0x1018
Configuration = Annotated[tuple[Identity, Identity], Field(strict=False)]
Share = Annotated[float, Field(gt=0, le=6.5)]  # of the rated torque
Ratio = Annotated[tuple[Annotated[int, Field(ge=1)], Annotated[int, Field(ge=1)]], Field(strict=False)]
Pair = Annotated[tuple[float, float], Field(strict=False)]

ModeName = Literal[
    "profile_position",
    "profile_velocity",
    "profile_torque",
    "interpolated_position",
    "cyclic_synchronous_position",
    "cyclic_synchronous_velocity",
    "cyclic_synchronous_torque",
]
ProcessData = Literal[
    "following_error",
    "torque",
    "torque_limit",
    "probe_1_rising",
    "probe_1_falling",
    "probe_2_rising",
    "probe_2_falling",
]


class SimulatedServo(Model):
    """The servo of a simulated drive, and what is mounted at its axis; places in mm or degrees of the encoder since power-on."""

    bandwidth_hz: float = Field(default=40.0, gt=0)
    damping: float = Field(default=1.0, gt=0)
    rated_acceleration: Annotated[float, Field(gt=0)] | None = (
        None  # mm/s² or degrees/s² at rated torque; default: twice that of the axis
    )
    index_distance: float = Field(default=10.0, gt=0)  # between two index pulses of the encoder
    home_switch: Pair | None = None  # active from, to
    limits: Pair | None = None  # limit switches: negative, positive
    probe: float | None = None  # touch probe 1 is high from here on


class Reactions(Model):
    """Option codes of CiA 402: how the drive comes to rest. 0 coast, 1 on 0x6084, 2 on 0x6085, 3 and 4 at its limits."""

    quick_stop: Annotated[int, Field(ge=0, le=8)] = 2  # 0x605A; 5 to 8 are 1 to 4, and the drive stays energised
    shutdown: Annotated[int, Field(ge=0, le=1)] = 1  # 0x605B
    disable: Annotated[int, Field(ge=0, le=1)] = 1  # 0x605C
    halt: Annotated[int, Field(ge=1, le=4)] = 1  # 0x605D
    fault: Annotated[int, Field(ge=0, le=4)] = 2  # 0x605E
    connection: Annotated[int, Field(ge=0, le=3)] = 1  # 0x6007: 0 nothing, 1 fault, 2 coast, 3 quick stop


class Transmission(Model):
    """How the drive converts its increments: read and compared with this, or written."""

    encoder: Ratio | None = None  # 0x608F: increments per motor revolutions
    gear: Ratio | None = None  # 0x6091: motor revolutions per revolutions of the driving shaft
    feed: Annotated[Length, Field(gt=0)]  # 0x6092: way of the axis per revolution of the driving shaft
    objects: Literal["check", "write"] = "check"


class Gantry(Model):
    """The second drive of an axis that is moved at both ends."""

    node: int = Field(ge=1, le=127)
    increments_per_unit: Annotated[float, Field(gt=0)] | None = None  # default: as the first drive
    difference: Annotated[Length, Field(gt=0)]  # greatest difference between both ends; beyond it the axis stops
    # of the second encoder against the first; default: as they stand at start. If the drives home: as they count from then on,
    # when the axis is square; default: 0
    offset: Length | None = None
    simulated: SimulatedServo = SimulatedServo()


class Drive(Model):
    """The CiA 402 drive of an axis."""

    node: int = Field(ge=1, le=127)
    bus: str | None = None  # name in fieldbus.buses; default: fieldbus.bus
    increments_per_unit: float = Field(default=10_000.0, gt=0)  # per mm or degree
    eds: FileBeside | None = None  # default: the EDS of the simulated drive
    vendor_id: Identity | None = None  # checked at start when given (object 0x1018)
    product_code: Identity | None = None
    sdo: dict[str, int] = Field(default_factory=dict)  # start-up writes: "0x6085" or "0x60C2:1" -> value
    simulated: SimulatedServo = SimulatedServo()
    optional: bool = False  # the machine starts without it, and takes it in when it comes
    configuration: Configuration | None = None  # 0x1020: date and time, checked
    dcf: FileBeside | None = None  # DCF or concise DCF: what the device is set to before it starts
    dcf_store: bool = False  # the device keeps it (0x1010), if it was not set so already
    mode: Literal["cyclic_synchronous_position", "cyclic_synchronous_velocity", "interpolated_position"] | None = (
        None  # default: cyclic synchronous position, of a spindle velocity
    )
    modes: Several[ModeName] = ()  # that can be ordered while the machine runs
    position_gain: float = Field(
        default=20.0, gt=0, le=500
    )  # 1/s, of an axis in velocity mode: the control closes the loop
    velocity_feed_forward: Annotated[float, Field(gt=0, le=1.5)] | None = (
        None  # share of the velocity that 0x60B1 tells
    )
    torque_feed_forward: Annotated[float, Field(gt=0)] | None = (
        None  # share of the rated torque per mm/s² or degree/s², told by 0x60B2
    )
    # share of the rated torque per mm/s or degree/s by which the velocity is limited in a torque mode; default: 40/s, if rated
    # torque accelerates the axis twice as much as it may be
    torque_gain: Annotated[float, Field(gt=0)] | None = None
    max_torque: Share | None = None  # 0x6072
    torque_limits: Annotated[tuple[Share, Share], Field(strict=False)] | None = None  # 0x60E0, 0x60E1
    process_data: Several[ProcessData] = ()  # exchanged beside set-point and position
    inputs: dict[Annotated[int, Field(ge=0, le=31)], Annotated[str, Field(min_length=1)]] = Field(
        default_factory=dict
    )  # bit of 0x60FD -> name of an input
    window: Annotated[Length, Field(gt=0)] | None = None  # 0x6065; default: twice the following error of the axis
    window_time: Seconds | None = None  # 0x6066
    reactions: Reactions = Reactions()
    transmission: Transmission | None = None
    gantry: Gantry | None = None

    def runs_in(self, *, spindle: bool) -> DriveMode:
        """The mode in which the drive takes set-points."""
        if self.mode is not None:
            return DriveMode[self.mode.upper()]
        return DriveMode.CYCLIC_SYNCHRONOUS_VELOCITY if spindle else DriveMode.CYCLIC_SYNCHRONOUS_POSITION
