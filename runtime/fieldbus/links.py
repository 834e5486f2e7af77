"""The master's picture of its nodes: what they must be, what the last frames told, what the next frames say.

Built once from the machine description (runtime.fieldbus.described), then touched by the cycle only.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import can
import canopen

from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.drives import DriveEvent, DriveImage, DriveMode, DriveState
from runtime.fieldbus import cia402
from runtime.fieldbus.analogue import AnalogueValues
from runtime.fieldbus.cia402 import DriveControl
from runtime.fieldbus.network import fill
from runtime.fieldbus.pdo import (
    Direction,
    PdoLayout,
    PdoPlan,
)

Receiver = Callable[[bytearray], None]

STILL = 2.0  # increments per cycle that an encoder at rest may tremble
RESTING_CYCLES = 20  # at rest, until a quick stop is over


def wrap32(value: int) -> int:
    """`value` as a signed 32-bit number, as the wire carries it."""
    return (value + 0x8000_0000) % 0x1_0000_0000 - 0x8000_0000


@dataclass(slots=True)
class NodeLink:
    """What the master knows of one node, whatever its profile."""

    node: int
    owner: str  # "axis X", "I/O node"
    profile: int  # low word of the device type 0x1000
    vendor_id: int | None
    product_code: int | None
    od: canopen.ObjectDictionary
    startup: list[tuple[int, int, int]]  # index, sub-index, value
    layouts: dict[PdoPlan, PdoLayout]  # the PDOs in use
    axis: int = -1  # index into the image, -1 for I/O
    bus: str = ""  # its name in the machine description
    optional: bool = False  # may be missing at the boot
    configuration: tuple[int, int] | None = None  # date and time that object 0x1020 must tell
    guarded: bool = False  # has no heartbeat: it is asked for its state (node guarding)
    toggle: int = -1  # bit 7 of its last answer, which has to change every time; -1 before the first one
    booted: bool = False
    nmt_state: int = 0
    last_heartbeat: float = 0.0  # s
    last_data: float = 0.0  # s
    lost: bool = False
    loss: DriveEvent | None = None  # how it was lost
    last_emergency: tuple[int, float] = (0, -math.inf)  # error code, and when it was last told, s

    def plan(self, direction: Direction, number: int = 1) -> PdoPlan | None:
        return next((p for p in self.layouts if p.direction is direction and p.number == number), None)

    def receivers(self) -> dict[int, Receiver]:
        """COB-ID of each TPDO of the node → who takes its data."""
        return {}

    def event(self, error_id: int, code: int = 0, text: str = "") -> DriveEvent:
        return DriveEvent(error_id, self.axis, self.node, code, text, self.bus)

    def _frame(self, plan: PdoPlan) -> can.Message:
        """The one message that carries this RPDO in every cycle; only its data change."""
        message = can.Message(arbitration_id=plan.cob_id(self.node), is_extended_id=False)
        message.dlc = self.layouts[plan].codec.size
        fill(message, bytes(message.dlc))
        return message


@dataclass(slots=True)
class DriveLink(NodeLink):
    """A CiA 402 drive. Positions inside are increments, unwrapped from the 32 bits of the wire."""

    spindle: bool = False
    increments_per_unit: float = 1.0
    mode: DriveMode = DriveMode.CYCLIC_SYNCHRONOUS_POSITION
    modes: frozenset[DriveMode] = frozenset()  # that can be ordered beside it
    period: float = 0.001  # s, of the cycle
    longest: float = math.inf  # increments that a set-point may go in one cycle
    stays: bool = False  # after a quick stop it stays energised (0x605A is 5 to 8)
    further: tuple[can.Message, ...] = ()  # messages beside `message`, sent in every cycle
    control: DriveControl = field(default_factory=DriveControl)
    fresh: bool = False  # feedback came since the last cycle
    invalid: bool = False  # the set-point is no finite number, or a jump
    message: can.Message = field(default_factory=can.Message)
    _pack: Callable[[int, int], bytes] = field(init=False)
    _unpack: Callable[[bytearray], tuple[int, int]] = field(init=False)
    _feedback_size: int = 0
    _status: int = 0
    _value: int = 0
    _raw_position: int = 0
    _increments: int = 0
    _resting: int = 0  # cycles at rest after a quick stop
    _sent: int = 0  # set-point of the cycle before
    _cycles: int = 0  # since the last feedback
    moved: int = 0  # increments, between the last feedback of a lost drive and its return

    def __post_init__(self) -> None:
        command, feedback = self.plan(Direction.RECEIVE), self.plan(Direction.TRANSMIT)
        assert command is not None  # exchange.py has both for every drive
        assert feedback is not None
        self.message = self._frame(command)
        self._pack = self.layouts[command].codec.pack
        self._unpack = self.layouts[feedback].codec.unpack_from
        self._feedback_size = self.layouts[feedback].codec.size

    def receivers(self) -> dict[int, Receiver]:
        return {
            plan.cob_id(self.node): self._receive_feedback if plan.number == 1 else self._receive_position
            for plan in self.layouts
            if plan.direction is Direction.TRANSMIT
        }

    def _receive_feedback(self, data: bytearray) -> None:
        if len(data) >= self._feedback_size:  # a PDO that is too short is not processed (CiA 301)
            self._status, self._value = self._unpack(data)
            self.fresh = True

    def _receive_position(self, data: bytearray) -> None:
        if len(data) >= 4:
            self._move_to(int.from_bytes(data[:4], "little", signed=True))

    def _move_to(self, raw: int) -> int:
        moved = wrap32(raw - self._raw_position)
        self._raw_position = raw
        self._increments += moved
        return moved

    def begin(self, status: int, raw_position: int, image: DriveImage) -> None:
        """What the drive said at boot; a fault that it already has is told like one that comes."""
        self.moved = wrap32(raw_position - self._raw_position) if self.lost else 0
        self._raw_position = self._increments = raw_position
        self._cycles = 0
        self.control = DriveControl(
            locked=self.lost, stays=self.stays
        )  # whoever comes back waits until its enable was withdrawn once
        state = self.control.observe(status)
        self._publish(image, state, 0.0)
        if state in cia402.FAULT_STATES:
            image.events.append(self.event(catalogue.DRIVE_FAULT.id, int(image.fault_code[self.axis])))

    def feedback(self, image: DriveImage, period: float) -> None:
        """Bring the data of this cycle into the image. `period`: of the cycle, s."""
        self._cycles += 1
        if not self.fresh:
            return
        self.fresh = False
        before = self.control.state
        if before is not DriveState.QUICK_STOP_ACTIVE:
            self._resting, self.control.standing = 0, False
        state = self.control.observe(self._status)
        if self.spindle:
            velocity = self._value / self.increments_per_unit
        else:
            velocity = self._move_to(self._value) / (self.increments_per_unit * period * self._cycles)
        if state is DriveState.QUICK_STOP_ACTIVE and self.stays:
            self._look_for_rest(velocity)
        self._cycles = 0
        self._publish(image, state, velocity)
        if state is before:
            return
        if state in cia402.FAULT_STATES:
            if before not in cia402.FAULT_STATES:
                image.events.append(self.event(catalogue.DRIVE_FAULT.id, int(image.fault_code[self.axis])))
        elif before in cia402.FAULT_STATES:
            image.fault_code[self.axis] = 0
        if self.control.fell:
            image.events.append(self.event(catalogue.DRIVE_DISABLED.id, int(state)))

    def _look_for_rest(self, velocity: float) -> None:
        """Bit 10 of the status word, or the position, says for some cycles that the quick stop is over."""
        rests = bool(self._status & cia402.TARGET_REACHED) or (
            not self.spindle and abs(velocity) * self.increments_per_unit * self.period <= STILL
        )
        self._resting = self._resting + 1 if rests else 0
        self.control.standing = self._resting >= RESTING_CYCLES

    def _publish(self, image: DriveImage, state: DriveState, velocity: float) -> None:
        image.state[self.axis] = state
        i = self.axis
        image.actual_position[i] = self._increments / self.increments_per_unit + image.origin[i] - image.correction[i]
        image.actual_velocity[self.axis] = velocity

    def command(self, image: DriveImage, target: float, enable: bool, quick_stop: bool, reset_fault: bool) -> None:
        """Fill `message` with the set-point of this cycle; `target` in units (a spindle: units/s)."""
        control = self.control
        # Until the drive is enabled its target is where it stands, so that enabling never makes it jump.
        value = 0 if self.spindle else self._raw_position
        if not math.isfinite(target):
            quick_stop = self._refuse(image, catalogue.SETPOINT_INVALID.id)
        elif control.state is not DriveState.OPERATION_ENABLED:
            self.invalid = False
        elif enable and not quick_stop:
            wanted = round(target * self.increments_per_unit)
            if self.spindle:
                value = max(-0x8000_0000, min(0x7FFF_FFFF, wanted))
            elif abs(wrap32(wanted - self._sent)) <= self.longest and not self.invalid:
                value = wrap32(wanted)
            else:
                value, quick_stop = self._sent, self._refuse(image, catalogue.SETPOINT_JUMP.id)
        word = control.order(enable, quick_stop, reset_fault)
        if word != cia402.ENABLE_OPERATION and not self.invalid:
            value = 0 if self.spindle else self._raw_position
        self._sent = value
        fill(self.message, self._pack(word, value))

    def lose(self) -> None:
        """The node does not answer any more."""
        self.control.lose()

    @property
    def has_inputs(self) -> bool:
        """Whether inputs of the image are those of the drive."""
        return False

    def input_bits(self) -> int:
        """The inputs at their place among all of the image."""
        return 0

    def _refuse(self, image: DriveImage, error_id: int) -> bool:
        """A set-point that the drive must not get: told once, the drive brakes by itself, until it is disabled."""
        self.control.locked = True
        if not self.invalid:
            self.invalid = True
            image.events.append(self.event(error_id))
        return True


@dataclass(slots=True)
class IoLink(NodeLink):
    """A CiA 401 node: a run of the input bits and a run of the output bits of the image, and analogue values."""

    first_input: int = 0
    inputs: int = 0  # bits
    first_output: int = 0
    outputs: int = 0
    input_value: int = 0
    output_value: int = -1  # nothing sent yet
    analogue: AnalogueValues = field(default_factory=AnalogueValues)
    message: can.Message | None = None

    def __post_init__(self) -> None:
        if self.outputs and (command := self.plan(Direction.RECEIVE)):
            self.message = self._frame(command)
        self.analogue.use(self.layouts, self._frame)

    def receivers(self) -> dict[int, Receiver]:
        table: dict[int, Receiver] = {}
        for plan, layout in self.layouts.items():
            if plan.direction is Direction.TRANSMIT:
                digital = plan.number == 1 and self.inputs > 0
                table[plan.cob_id(self.node)] = self.receive_inputs if digital else self.analogue.receiver(plan, layout)
        return table

    def receive_inputs(self, data: bytes | bytearray) -> None:
        size = (self.inputs + 7) // 8
        if len(data) >= size:
            self.input_value = int.from_bytes(data[:size], "little") & ((1 << self.inputs) - 1)

    def input_bits(self) -> int:
        """The inputs at their place among all; a lost node's inputs are FALSE."""
        return 0 if self.lost else self.input_value << self.first_input

    def command(self, output_bits: int) -> bool:
        """Fill `message` from all output bits; whether anything changed."""
        value = output_bits >> self.first_output & ((1 << self.outputs) - 1)
        if value == self.output_value or self.message is None:
            return False
        self.output_value = value
        fill(self.message, value.to_bytes(self.message.dlc, "little"))
        return True


Links = list[DriveLink | IoLink]
