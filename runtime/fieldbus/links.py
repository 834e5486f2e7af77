"""The master's picture of its nodes: what they must be, what the last frames told, what the next frames say.

Built once from the machine description (`make_links`, which refuses what cannot be), then touched by the cycle only.
"""

from __future__ import annotations

import configparser
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib import resources
from typing import Final

import can
import canopen
from canopen.objectdictionary import ObjectDictionaryError

from runtime.config.machine import Axis, AxisType, Drive, IoNode, Machine
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.drives import DIGITAL_BYTES, DriveEvent, DriveImage, DriveState
from runtime.fieldbus import cia402, exchange
from runtime.fieldbus.cia402 import DriveControl, Mode
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.pdo import VALUE_RANGES, Direction, ObjectKey, PdoLayout, PdoPlan, find_variable, lay_out

DRIVE_EDS: Final = "tandem_cia402.eds"
IO_EDS: Final = "tandem_cia401.eds"
MAX_IO_BITS: Final = 64  # of one node and direction: one PDO

Receiver = Callable[[bytearray], None]


def wrap32(value: int) -> int:
    """`value` as a signed 32-bit number, as the wire carries it."""
    return (value + 0x8000_0000) % 0x1_0000_0000 - 0x8000_0000


def eds_path(file: str | None, default: str) -> str:
    """Path of an EDS file; without `file` that of the simulated node."""
    return file or str(resources.files("runtime.fieldbus").joinpath("eds", default))


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
    pdos: tuple[PdoPlan, ...]
    axis: int = -1  # index into the image, -1 for I/O
    layouts: dict[PdoPlan, PdoLayout] = field(default_factory=dict)
    booted: bool = False
    nmt_state: int = 0
    last_heartbeat: float = 0.0  # s
    last_data: float = 0.0  # s
    lost: bool = False

    def plan(self, direction: Direction, number: int = 1) -> PdoPlan | None:
        return next((p for p in self.pdos if p.direction is direction and p.number == number), None)

    def receivers(self) -> dict[int, Receiver]:
        """COB-ID of each TPDO of the node → who takes its data."""
        return {}

    def event(self, error_id: int, code: int = 0) -> DriveEvent:
        return DriveEvent(error_id, self.axis, self.node, code)

    def _frame(self, plan: PdoPlan) -> can.Message:
        """The one message that carries this RPDO in every cycle; only its data change."""
        data = bytearray(self.layouts[plan].codec.size)
        return can.Message(arbitration_id=plan.cob_id(self.node), data=data, is_extended_id=False)


@dataclass(slots=True)
class DriveLink(NodeLink):
    """A CiA 402 drive. Positions inside are increments, unwrapped from the 32 bits of the wire."""

    spindle: bool = False
    increments_per_unit: float = 1.0
    mode: Mode = Mode.CYCLIC_SYNCHRONOUS_POSITION
    control: DriveControl = field(default_factory=DriveControl)
    fresh: bool = False  # feedback came since the last cycle
    invalid: bool = False  # the set-point is no finite number
    message: can.Message = field(default_factory=can.Message)
    _status: int = 0
    _value: int = 0
    _raw_position: int = 0
    _increments: int = 0
    _cycles: int = 0  # since the last feedback

    def __post_init__(self) -> None:
        for plan in self.pdos:
            self.layouts[plan] = lay_out(self.od, plan.objects)
        command = self.plan(Direction.RECEIVE)
        assert command is not None
        self.message = self._frame(command)

    def receivers(self) -> dict[int, Receiver]:
        return {
            plan.cob_id(self.node): self._receive_feedback if plan.number == 1 else self._receive_position
            for plan in self.pdos
            if plan.direction is Direction.TRANSMIT
        }

    def _receive_feedback(self, data: bytearray) -> None:
        if len(data) >= 6:  # a PDO that is too short is not processed (CiA 301)
            self._status = data[0] | data[1] << 8
            self._value = int.from_bytes(data[2:6], "little", signed=True)
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
        """What the drive said at boot."""
        self._raw_position = self._increments = raw_position
        self._cycles = 0
        self.control = DriveControl()
        self._publish(image, self.control.observe(status), 0.0)

    def feedback(self, image: DriveImage, period: float) -> None:
        """Bring the data of this cycle into the image. `period`: of the cycle, s."""
        self._cycles += 1
        if not self.fresh:
            return
        self.fresh = False
        before = self.control.state
        state = self.control.observe(self._status)
        if self.spindle:
            velocity = self._value / self.increments_per_unit
        else:
            velocity = self._move_to(self._value) / (self.increments_per_unit * period * self._cycles)
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

    def _publish(self, image: DriveImage, state: DriveState, velocity: float) -> None:
        image.state[self.axis] = state
        image.actual_position[self.axis] = self._increments / self.increments_per_unit
        image.actual_velocity[self.axis] = velocity

    def command(self, image: DriveImage, target: float, enable: bool, quick_stop: bool, reset_fault: bool) -> None:
        """Fill `message` with the set-point of this cycle; `target` in units (a spindle: units/s)."""
        control = self.control
        value = 0 if self.spindle else self._raw_position
        if not math.isfinite(target):
            if not self.invalid:
                self.invalid = True
                image.events.append(self.event(catalogue.SETPOINT_INVALID.id))
            quick_stop = True
        else:
            self.invalid = False
        word = control.order(enable, quick_stop, reset_fault)
        # Until the drive is enabled its target is where it stands, so that enabling never makes it jump.
        if word == cia402.ENABLE_OPERATION and control.state is DriveState.OPERATION_ENABLED:
            value = round(target * self.increments_per_unit)
            value = max(-0x8000_0000, min(0x7FFF_FFFF, value)) if self.spindle else wrap32(value)
        data = self.message.data
        data[0] = word & 0xFF
        data[1] = word >> 8
        data[2:6] = value.to_bytes(4, "little", signed=True)


@dataclass(slots=True)
class IoLink(NodeLink):
    """A CiA 401 node: a run of the input bits and a run of the output bits of the image."""

    first_input: int = 0
    inputs: int = 0  # bits
    first_output: int = 0
    outputs: int = 0
    input_value: int = 0
    output_value: int = -1  # nothing sent yet
    message: can.Message | None = None

    def __post_init__(self) -> None:
        for plan in self.pdos:
            self.layouts[plan] = lay_out(self.od, plan.objects)
        if command := self.plan(Direction.RECEIVE):
            self.message = self._frame(command)

    def receivers(self) -> dict[int, Receiver]:
        plan = self.plan(Direction.TRANSMIT)
        return {plan.cob_id(self.node): self.receive_inputs} if plan else {}

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
        self.message.data[:] = value.to_bytes(len(self.message.data), "little")
        return True


Links = list[DriveLink | IoLink]


def make_links(machine: Machine) -> Links:
    """A link per node, axes first, in the order of the machine description.

    Raises FieldbusError for an EDS that cannot be read or lacks what is needed, and for start-up writes that cannot
    be made.
    """
    links: Links = [_drive_link(axis, index, axis.drive) for index, axis in enumerate(machine.axes) if axis.drive]
    first_input = first_output = 0
    for number, io in enumerate(machine.fieldbus.io):
        links.append(_io_link(io, number, first_input, first_output))
        first_input += len(io.inputs)
        first_output += len(io.outputs)
        for bits, direction in ((first_input, "inputs"), (first_output, "outputs")):
            if bits > DIGITAL_BYTES * 8:
                text = f"{direction} with the nodes before it"
                raise FieldbusError(
                    catalogue.TOO_MANY_BITS, node=io.node, bits=bits, direction=text, limit=DIGITAL_BYTES * 8
                )
    master = machine.fieldbus.bus.master_node
    for link in links:
        if link.node == master:
            raise FieldbusError(catalogue.MASTER_NODE_TAKEN, node=master, owner=link.owner)
    return links


def _drive_link(axis: Axis, index: int, drive: Drive) -> DriveLink:
    owner = f"axis {axis.name}"
    od = _dictionary(drive.eds, DRIVE_EDS, drive.node, owner)
    spindle = axis.type is AxisType.SPINDLE
    mode = Mode.CYCLIC_SYNCHRONOUS_VELOCITY if spindle else Mode.CYCLIC_SYNCHRONOUS_POSITION
    pdos = _known_pdos(exchange.SPINDLE_PDOS if spindle else exchange.AXIS_PDOS, od, drive.node, owner)
    return DriveLink(
        node=drive.node,
        owner=owner,
        profile=cia402.DEVICE_PROFILE,
        vendor_id=drive.vendor_id,
        product_code=drive.product_code,
        od=od,
        startup=[_startup_write(name, value, od, drive.node, owner) for name, value in drive.sdo.items()],
        pdos=pdos,
        axis=index,
        spindle=spindle,
        increments_per_unit=drive.increments_per_unit,
        mode=mode,
    )


def _io_link(io: IoNode, number: int, first_input: int, first_output: int) -> IoLink:
    owner = f"I/O node {number}"
    for names, direction in ((io.inputs, "inputs"), (io.outputs, "outputs")):
        if len(names) > MAX_IO_BITS:
            raise FieldbusError(
                catalogue.TOO_MANY_BITS, node=io.node, bits=len(names), direction=direction, limit=MAX_IO_BITS
            )
    od = _dictionary(io.eds, IO_EDS, io.node, owner)
    return IoLink(
        node=io.node,
        owner=owner,
        profile=exchange.IO_PROFILE,
        vendor_id=io.vendor_id,
        product_code=None,
        od=od,
        startup=[],
        pdos=_known_pdos(exchange.io_pdos(len(io.inputs), len(io.outputs)), od, io.node, owner),
        first_input=first_input,
        inputs=len(io.inputs),
        first_output=first_output,
        outputs=len(io.outputs),
    )


def _dictionary(file: str | None, default: str, node: int, owner: str) -> canopen.ObjectDictionary:
    path = eds_path(file, default)
    try:
        od = canopen.import_od(path, node)
    # canopen lets through whatever configparser and int() raise at a broken file
    except (
        OSError,
        ValueError,
        KeyError,
        AttributeError,
        TypeError,
        configparser.Error,
        ObjectDictionaryError,
    ) as error:
        reason = (
            (isinstance(error, OSError) and error.strerror) or str(error).replace("\n", " ") or type(error).__name__
        )
        raise FieldbusError(catalogue.EDS_UNREADABLE, file=path, node=node, owner=owner, reason=reason) from error
    if not len(od):
        raise FieldbusError(
            catalogue.EDS_UNREADABLE, file=path, node=node, owner=owner, reason="it describes no object"
        )
    return od


def _known_pdos(pdos: tuple[PdoPlan, ...], od: canopen.ObjectDictionary, node: int, owner: str) -> tuple[PdoPlan, ...]:
    """These PDOs if the dictionary has all that they need."""
    for plan in pdos:
        needed: list[ObjectKey] = [*plan.objects, (plan.communication_index, 1), (plan.mapping_index, 0)]
        for index, subindex in needed:
            _need(od, index, subindex, node, owner, "the process data")
    return pdos


def _need(od: canopen.ObjectDictionary, index: int, subindex: int, node: int, owner: str, purpose: str) -> None:
    try:
        find_variable(od, index, subindex)
    except KeyError as error:
        raise FieldbusError(
            catalogue.EDS_OBJECT_MISSING, node=node, owner=owner, object=error.args[0], purpose=purpose
        ) from error


def _startup_write(name: str, value: int, od: canopen.ObjectDictionary, node: int, owner: str) -> tuple[int, int, int]:
    """Index, sub-index and value of a start-up write like `0x60C2:1`."""

    def refuse(reason: str) -> FieldbusError:
        return FieldbusError(catalogue.STARTUP_OBJECT, object=name, value=value, node=node, owner=owner, reason=reason)

    try:
        index_text, _, subindex_text = name.partition(":")
        index, subindex = int(index_text, 0), int(subindex_text or "0", 0)
    except ValueError:
        raise refuse("this is no object") from None
    try:
        variable = find_variable(od, index, subindex)
    except KeyError:
        raise refuse("its EDS has no such object") from None
    if not variable.writable:
        raise refuse("the object is read-only")
    low, high = VALUE_RANGES.get(variable.data_type or 0, (0, -1))
    if not low <= value <= high:
        raise refuse(f"its values go from {low} to {high}" if low < high else "only whole numbers can be written")
    return index, subindex, value
