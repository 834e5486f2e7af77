"""Where axes and drives meet: plain arrays, one element per axis, and the protocol of whatever carries them.

The CNC writes the upper half of the image and reads the lower one; the fieldbus (or the ideal drives below) does the
opposite. Neither knows the other. Units: mm and degrees, per second.
"""

from __future__ import annotations

from collections import deque
from enum import IntEnum
from typing import Final, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

DIGITAL_BYTES = 64
ANALOGUE_VALUES = 32


# Bits of the touch probe's function (0x60B8) and status (0x60B9); those of probe 2 stand 8 bits higher
PROBE_ON: Final = 0x01
PROBE_CONTINUOUS: Final = 0x02
PROBE_RISING: Final = 0x10
PROBE_FALLING: Final = 0x20
PROBE_IS_ON: Final = 0x01
PROBE_HAS_RISEN: Final = 0x02
PROBE_HAS_FALLEN: Final = 0x04
PROBE_2_SHIFT: Final = 8


class DriveState(IntEnum):
    """The states of IEC 61800-7-201 (CiA 402), and OFFLINE for a node that does not answer."""

    OFFLINE = 0
    NOT_READY_TO_SWITCH_ON = 1
    SWITCH_ON_DISABLED = 2
    READY_TO_SWITCH_ON = 3
    SWITCHED_ON = 4
    OPERATION_ENABLED = 5
    QUICK_STOP_ACTIVE = 6
    FAULT_REACTION_ACTIVE = 7
    FAULT = 8


class DriveMode(IntEnum):
    """Modes of operation of CiA 402 (object 0x6060); bit `mode - 1` of 0x6502 says whether a drive has it."""

    CONFIGURED = 0  # in the image: the one that the machine description gives the drive
    PROFILE_POSITION = 1
    PROFILE_VELOCITY = 3
    PROFILE_TORQUE = 4
    HOMING = 6
    INTERPOLATED_POSITION = 7
    CYCLIC_SYNCHRONOUS_POSITION = 8
    CYCLIC_SYNCHRONOUS_VELOCITY = 9
    CYCLIC_SYNCHRONOUS_TORQUE = 10


class HomingState(IntEnum):
    """What became of a homing that the drive does itself (mode 6)."""

    IDLE = 0  # none is requested
    RUNNING = 1
    DONE = 2  # the drive has its reference and takes set-points again; stays until the request is taken back
    FAILED = 3  # homing error, the drive was disabled, or it has no homing mode
    STOPPING = 4  # the request was taken back before it was done: the drive brakes


class DriveEvent(NamedTuple):
    """Something the bus has to tell the cycle: a catalogue error, where, and the code the node gave."""

    error_id: int
    axis: int  # index into the image, -1 if no axis
    node: int  # CANopen node id, 0 if the bus itself
    code: int  # EMCY error code, SDO abort code, CiA 402 error code, or 0
    text: str = ""  # what no code tells
    bus: str = ""  # name of the bus in the machine description, "" the first one


class BusFigures:
    """One bus, for the metrics."""

    def __init__(self, channel: str) -> None:
        self.channel = channel
        self.load = 0.0  # share of its capacity, 0...1
        self.gone = False


class DriveImage:
    """What is exchanged with the drives in every cycle, for `n` axes in the order of the machine description.

    All arrays lie in one memory, `words`; they are filled, never replaced.
    What only some drives exchange (torque, inputs, probes: `process_data` of the machine description) stays 0 for others.
    """

    SET_POINTS: Final = (
        "target_position", "target_velocity", "target_torque", "torque_limit", "profile_target", "mode", "enable", "quick_stop",
        "reset_fault", "halt", "homing_request", "probe_function", "origin", "correction", "feed_forward",
        "digital_out", "analogue_out",
    )  # fmt: skip
    """The arrays that the axes write, for whoever records them."""
    FEEDBACK: Final = (
        "actual_position", "actual_velocity", "actual_torque", "drive_lag", "state", "fault_code", "mode_shown",
        "by_drive", "target_reached", "limited", "drive_inputs", "homing_state", "probe_status", "probe_position", "digital_in",
        "analogue_in", "analogue_valid", "identity",
    )  # fmt: skip
    """The arrays that the bus writes; `events` and the figures come beside them. Homing by the drive sets `origin` too."""

    def __init__(self, n: int) -> None:
        self.n = n
        # set-points, written by the axes
        self.target_position: Floats = np.zeros(n)
        self.target_velocity: Floats = np.zeros(n)  # spindles (cyclic synchronous velocity mode)
        self.enable: Flags = np.zeros(n, dtype=np.bool_)  # go to operation enabled and stay there
        self.quick_stop: Flags = np.zeros(n, dtype=np.bool_)  # brake by the drive's own ramp
        self.reset_fault: Flags = np.zeros(n, dtype=np.bool_)  # rising edge acknowledges a fault
        self.digital_out: npt.NDArray[np.uint8] = np.zeros(DIGITAL_BYTES, dtype=np.uint8)
        self.analogue_out: Floats = np.zeros(ANALOGUE_VALUES)
        self.origin: Floats = np.zeros(n)  # position of the axis where its drive counts 0; changed by homing
        self.correction: Floats = np.zeros(n)  # position of the drive minus that of the axis (backlash, pitch error)
        self.feed_forward: Floats = np.ones(n)  # share of the feed-forward that the drive is described to get, 0…1
        self.mode: npt.NDArray[np.int8] = np.zeros(n, dtype=np.int8)  # DriveMode wanted
        self.target_torque: Floats = np.zeros(n)  # share of the rated torque (torque modes)
        self.torque_limit: Floats = np.full(n, np.inf)  # share of the rated torque; inf: the drive's own limit
        self.profile_target: Floats = np.zeros(n)  # where a drive in profile position mode goes
        self.halt: Flags = np.zeros(
            n, dtype=np.bool_
        )  # brake and stay enabled (modes in which the drive moves by itself)
        self.homing_request: Flags = np.zeros(n, dtype=np.bool_)  # home by the drive; taken back: stop
        self.probe_function: npt.NDArray[np.uint16] = np.zeros(n, dtype=np.uint16)  # object 0x60B8
        # feedback, written by the bus
        self.actual_position: Floats = np.zeros(n)
        self.actual_velocity: Floats = np.zeros(n)
        self.state: npt.NDArray[np.int8] = np.zeros(n, dtype=np.int8)  # DriveState
        self.fault_code: npt.NDArray[np.int32] = np.zeros(n, dtype=np.int32)  # CiA 402 object 0x603F
        self.mode_shown: npt.NDArray[np.int8] = np.zeros(n, dtype=np.int8)  # DriveMode that the drive is in
        self.by_drive: Flags = np.zeros(n, dtype=np.bool_)  # the drive moves by itself, set-points are not followed
        self.target_reached: Flags = np.zeros(n, dtype=np.bool_)  # bit 10 of the status word
        self.limited: Flags = np.zeros(n, dtype=np.bool_)  # bit 11: the drive cannot do what it is told
        self.actual_torque: Floats = np.zeros(n)  # share of the rated torque
        self.drive_lag: Floats = np.zeros(n)  # following error that the drive measures (0x60F4)
        self.drive_inputs: npt.NDArray[np.uint32] = np.zeros(n, dtype=np.uint32)  # object 0x60FD
        self.homing_state: npt.NDArray[np.int8] = np.zeros(n, dtype=np.int8)  # HomingState
        self.probe_status: npt.NDArray[np.uint16] = np.zeros(n, dtype=np.uint16)  # object 0x60B9
        self.probe_position: Floats = np.zeros((n, 4))  # of the axis: probe 1 rising, falling, probe 2 rising, falling
        self.digital_in: npt.NDArray[np.uint8] = np.zeros(DIGITAL_BYTES, dtype=np.uint8)
        self.analogue_in: Floats = np.zeros(ANALOGUE_VALUES)  # in the unit of the machine description
        # The node is there, and the value within its range.
        self.analogue_valid: Flags = np.zeros(ANALOGUE_VALUES, dtype=np.bool_)
        self.identity: npt.NDArray[np.uint32] = np.zeros((n, 3), dtype=np.uint32)  # vendor, product, serial (0x1018)
        self.events: deque[DriveEvent] = deque(maxlen=64)
        # figures for the metrics
        self.bus_load: float = 0.0  # share of the bus capacity, 0...1; of the busiest one
        self.buses: list[BusFigures] = []
        self.buses_changed = True  # until somebody has looked at them
        self.emcy_count: int = 0
        self.frames_sent: int = 0
        self.frames_received: int = 0
        self.words, self.places = self._pack()

    def _pack(self) -> tuple[npt.NDArray[np.int64], dict[str, int]]:
        """All arrays in one memory of words (8 bytes), each from a whole word on, and where each begins.

        Whoever looks for what has changed compares that.
        """
        names = (*self.SET_POINTS, *self.FEEDBACK)
        sizes = [-(-getattr(self, name).nbytes // 8) for name in names]
        words = np.zeros(sum(sizes), dtype=np.int64)
        places: dict[str, int] = {}
        at = 0
        for name, size in zip(names, sizes, strict=True):
            array = getattr(self, name)
            part = words[at : at + size].view(np.uint8)[: array.nbytes].view(array.dtype).reshape(array.shape)
            part[...] = array
            setattr(self, name, part)
            places[name] = at
            at += size
        return words, places


class DriveSystem(Protocol):
    """Whatever carries the image: a CANopen master, or ideal drives."""

    image: DriveImage

    def start(self) -> None:
        """Boot and configure everything; blocks, called once before the first cycle; raises a TandemError subclass."""

    def read(self) -> None:
        """Start of a cycle: bring the feedback into the image. Never blocks, never raises."""

    def write(self) -> None:
        """End of a cycle: send the set-points. Never blocks, never raises."""

    def tell_again(self) -> None:
        """After a reset: what is still lost becomes an event again. Never blocks, never raises."""

    def stop(self) -> None:
        """Disable the drives in order and leave the bus; blocks for a bounded time, never raises."""


_STATES = np.array([DriveState.SWITCH_ON_DISABLED, DriveState.OPERATION_ENABLED], dtype=np.int8)  # disabled, enabled


class IdealDrives:
    """Drives without dynamics: enabled at once, actual equal to target one cycle later."""

    def __init__(self, n: int, initial_position: Floats | None = None, period: float = 0.001) -> None:
        """`period`: of the cycle, s."""
        self.image = DriveImage(n)
        self._period = period
        # A drive moves by itself: by its velocity, as all modes that can be ordered beside its own do here.
        self._driven = False
        self._enabled: Flags = np.zeros(n, dtype=np.bool_)
        self._orders_before = b""
        if initial_position is not None:
            self.image.actual_position[:] = initial_position
            self.image.target_position[:] = initial_position

    def start(self) -> None:
        self.image.state[:] = DriveState.SWITCH_ON_DISABLED
        self._orders_before = b""

    def read(self) -> None:
        image = self.image
        orders = (
            image.enable.tobytes() + image.quick_stop.tobytes() + image.homing_request.tobytes() + image.mode.tobytes()
        )
        if orders != self._orders_before:
            self._orders_before = orders
            np.logical_and(image.enable, ~image.quick_stop, out=self._enabled)
            image.state[:] = _STATES[self._enabled.view(np.int8)]
            image.homing_state[:] = np.where(
                image.homing_request, HomingState.DONE, HomingState.IDLE
            )  # where it stands
            np.logical_and(image.mode != DriveMode.CONFIGURED, self._enabled, out=image.by_drive)
            self._driven = bool(image.by_drive.any())
        if self._driven:
            way = np.where(image.by_drive, image.target_velocity * self._period, 0.0)
            image.actual_position += way
            np.copyto(image.target_position, image.actual_position, where=image.by_drive)
        np.copyto(image.actual_position, image.target_position, where=self._enabled)
        np.multiply(image.target_velocity, self._enabled, out=image.actual_velocity)

    def write(self) -> None:
        """Nothing to send: the set-points are taken at the next read."""

    def tell_again(self) -> None:
        """Nothing is ever lost."""

    def stop(self) -> None:
        self.image.state[:] = DriveState.SWITCH_ON_DISABLED
