"""From the machine description to the master's picture of its nodes; what cannot be is refused before it starts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from importlib import resources
from typing import Final, TypedDict

import canopen

from runtime.config.machine import Axis, AxisType, Drive, IoNode, Machine
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.drives import DIGITAL_BYTES, DriveMode
from runtime.fieldbus import cia402, exchange
from runtime.fieldbus.analogue import AnalogueValues
from runtime.fieldbus.dialogue import GUARD_TIME, LIFE_TIME_FACTOR, PRODUCER_HEARTBEAT
from runtime.fieldbus.dictionaries import load_dictionary
from runtime.fieldbus.drive_link import NO_TORQUE_LIMIT, PER_MILLE, ExtendedDriveLink
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.exchange import DriveNeeds
from runtime.fieldbus.gantry import GantryEnd
from runtime.fieldbus.links import DriveLink, IoLink, Links
from runtime.fieldbus.pdo import (
    FREE_COB_IDS,
    PREDEFINED,
    VALUE_RANGES,
    ObjectKey,
    PdoLayout,
    PdoPlan,
    find_variable,
    lay_out,
    object_name,
)

DRIVE_EDS: Final = "tandem_cia402.eds"
IO_EDS: Final = "tandem_cia401.eds"
MAX_IO_BITS: Final = 64  # of one node and direction: one PDO
STEP_MARGIN: Final = 1.05  # times the velocity limit: a set-point that goes further in a cycle is refused


def eds_path(file: str | None, default: str) -> str:
    """Path of an EDS file; without `file` that of the simulated node."""
    return file or str(resources.files("runtime.fieldbus").joinpath("eds", default))


def make_links(machine: Machine) -> Links:
    """A link per node, axes first, in the order of the machine description.

    Raises FieldbusError for an EDS that cannot be read or lacks what is needed, and for start-up writes that cannot
    be made.
    """
    links: Links = []
    cob_ids = CobIds()
    first_input = sum(len(io.inputs) for io in machine.fieldbus.io)
    for index, axis in enumerate(machine.axes):
        if axis.drive:
            links += _drive_links(axis, index, axis.drive, machine.cycle.period, first_input, cob_ids)
            first_input += len(axis.drive.inputs)
            _fits(first_input, axis.drive.node, "inputs with those of the nodes before it")
    first_input = first_output = first_value = first_put_out = 0
    for number, io in enumerate(machine.fieldbus.io):
        values = AnalogueValues.of(io, first_value, first_put_out)
        links.append(_io_link(io, number, first_input, first_output, values, machine.cycle.period, cob_ids))
        first_value += len(io.analogue_inputs)
        first_put_out += len(io.analogue_outputs)
        first_input += len(io.inputs)
        first_output += len(io.outputs)
        for bits, direction in ((first_input, "inputs"), (first_output, "outputs")):
            _fits(bits, io.node, f"{direction} with the nodes before it")
    return links


class CobIds:
    """Gives PDOs beyond the predefined ones a COB-ID that nobody else has on their bus."""

    def __init__(self) -> None:
        self._free: dict[str, Iterator[int]] = {}  # by the name of the bus

    def given(self, plans: tuple[PdoPlan, ...], bus: str | None, node: int, owner: str) -> tuple[PdoPlan, ...]:
        """The same PDOs. Raises FieldbusError if there is none left."""
        free = self._free.setdefault(bus or "", iter(FREE_COB_IDS))
        try:
            return tuple(replace(plan, own_cob_id=next(free)) if plan.number > PREDEFINED else plan for plan in plans)
        except (StopIteration, RuntimeError):
            reason = (
                f"the bus has no more than {len(FREE_COB_IDS)} identifiers for PDOs beyond the first four of a node"
            )
            raise FieldbusError(catalogue.TOO_MANY_PDOS, node=node, owner=owner, reason=reason) from None


def _fits(bits: int, node: int, direction: str) -> None:
    if bits > DIGITAL_BYTES * 8:
        raise FieldbusError(catalogue.TOO_MANY_BITS, node=node, bits=bits, direction=direction, limit=DIGITAL_BYTES * 8)


class _Common(TypedDict):
    """What every drive link is made of."""

    node: int
    owner: str
    profile: int
    vendor_id: int | None
    product_code: int | None
    od: canopen.ObjectDictionary
    startup: list[tuple[int, int, int]]
    layouts: dict[PdoPlan, PdoLayout]
    axis: int
    bus: str
    optional: bool
    configuration: tuple[int, int] | None
    guarded: bool
    spindle: bool
    increments_per_unit: float
    mode: DriveMode
    modes: frozenset[DriveMode]
    period: float
    longest: float
    stays: bool


def _drive_links(
    axis: Axis, index: int, drive: Drive, period: float, first_input: int, cob_ids: CobIds
) -> list[DriveLink]:
    """The drive of an axis, or both of a gantry."""
    gantry = drive.gantry
    if gantry is None:
        return [_drive_link(axis, index, drive, period, first_input, cob_ids)]
    by_drive = axis.homing is not None and axis.homing.method is not None
    speed = max(axis.homing.fast, axis.homing.slow) if axis.homing is not None and by_drive else None
    first, second = GantryEnd.pair(gantry.difference, period, gantry.offset, speed)
    scale = gantry.increments_per_unit or drive.increments_per_unit
    other = drive.model_copy(update={"node": gantry.node, "increments_per_unit": scale, "inputs": {}})
    return [
        _drive_link(axis, index, drive, period, first_input, cob_ids, first),
        _drive_link(axis, index, other, period, first_input, cob_ids, second),
    ]


def _drive_link(
    axis: Axis,
    index: int,
    drive: Drive,
    period: float,
    first_input: int,
    cob_ids: CobIds,
    end: GantryEnd | None = None,
) -> DriveLink:
    owner = f"axis {axis.name}"
    od = _dictionary(drive.eds, DRIVE_EDS, drive.node, owner)
    spindle = axis.type is AxisType.SPINDLE
    needs = _needs(axis, drive, spindle)
    plans = cob_ids.given(exchange.drive_pdos(needs), drive.bus, drive.node, owner)
    common = _Common(
        node=drive.node,
        owner=owner,
        profile=cia402.DEVICE_PROFILE,
        vendor_id=drive.vendor_id,
        product_code=drive.product_code,
        od=od,
        startup=[_startup_write(name, value, od, drive.node, owner) for name, value in drive.sdo.items()],
        layouts=_layouts(plans, od, drive.node, owner),
        axis=index,
        bus=drive.bus or "",
        optional=drive.optional,
        configuration=drive.configuration,
        guarded=_guarded(od, drive.node, owner),
        spindle=spindle,
        increments_per_unit=drive.increments_per_unit,
        mode=needs.mode,
        modes=needs.modes,
        period=period,
        longest=_longest_step(axis, drive, period),
        stays=drive.reactions.quick_stop >= cia402.STAYS,
    )
    if needs == DriveNeeds(spindle, exchange.plain_mode(spindle)) and end is None:
        return DriveLink(**common)
    return ExtendedDriveLink(
        **common,
        velocity_limit=axis.velocity,
        position_gain=drive.position_gain,
        velocity_feed_forward=drive.velocity_feed_forward or 0.0,
        torque_feed_forward=drive.torque_feed_forward or 0.0,
        inputs=tuple(sorted(drive.inputs)),
        first_input=first_input,
        home_position=axis.homing.position if axis.homing else 0.0,
        torque_limit=NO_TORQUE_LIMIT if drive.max_torque is None else round(drive.max_torque * PER_MILLE),
        end=end,
    )


def _needs(axis: Axis, drive: Drive, spindle: bool) -> DriveNeeds:
    modes = {DriveMode[name.upper()] for name in drive.modes}
    if axis.homing is not None and axis.homing.method is not None:
        modes.add(DriveMode.HOMING)
    mode = drive.runs_in(spindle=spindle)
    return DriveNeeds(
        spindle=spindle,
        mode=mode,
        modes=frozenset(modes - {mode}),
        velocity_offset=drive.velocity_feed_forward is not None,
        torque_offset=drive.torque_feed_forward is not None,
        process_data=frozenset(drive.process_data),
        inputs=bool(drive.inputs),
    )


def _longest_step(axis: Axis, drive: Drive, period: float) -> float:
    """Increments that a set-point may go in one cycle: the velocity limit and what rounding and compensation add."""
    correction = axis.compensation.velocity if axis.compensation else 0.0
    return (STEP_MARGIN * axis.velocity + correction) * period * drive.increments_per_unit + 2.0


def _io_link(
    io: IoNode,
    number: int,
    first_input: int,
    first_output: int,
    analogue: AnalogueValues,
    period: float,
    cob_ids: CobIds,
) -> IoLink:
    owner = f"I/O node {number}"
    for names, direction in ((io.inputs, "inputs"), (io.outputs, "outputs")):
        if len(names) > MAX_IO_BITS:
            raise FieldbusError(
                catalogue.TOO_MANY_BITS, node=io.node, bits=len(names), direction=direction, limit=MAX_IO_BITS
            )
    od = _dictionary(io.eds, IO_EDS, io.node, owner)
    plans = exchange.io_pdos(len(io.inputs), len(io.outputs), analogue.needs(io.analogue_every, period))
    plans = cob_ids.given(plans, io.bus, io.node, owner)
    return IoLink(
        node=io.node,
        owner=owner,
        profile=exchange.IO_PROFILE,
        vendor_id=io.vendor_id,
        product_code=None,
        od=od,
        startup=[],
        layouts=_layouts(plans, od, io.node, owner),
        bus=io.bus or "",
        optional=io.optional,
        configuration=io.configuration,
        guarded=_guarded(od, io.node, owner),
        first_input=first_input,
        inputs=len(io.inputs),
        first_output=first_output,
        outputs=len(io.outputs),
        analogue=analogue,
    )


def _dictionary(file: str | None, default: str, node: int, owner: str) -> canopen.ObjectDictionary:
    return load_dictionary(eds_path(file, default), node, owner)


def _layouts(
    pdos: tuple[PdoPlan, ...], od: canopen.ObjectDictionary, node: int, owner: str
) -> dict[PdoPlan, PdoLayout]:
    """The layouts of these PDOs, if the dictionary has all that they need, of the types that the profile tells."""
    layouts = {}
    for plan in pdos:
        needed: list[ObjectKey] = [*plan.objects, (plan.communication_index, 1), (plan.mapping_index, 0)]
        for index, subindex in needed:
            _need(od, index, subindex, node, owner, "the process data")
        try:
            layout = lay_out(od, plan.objects)
        except ValueError as error:
            file = "of the device"
            raise FieldbusError(catalogue.EDS_UNREADABLE, file=file, node=node, owner=owner, reason=error) from error
        codes = "".join(exchange.CODES.get(index, "?") for index, _ in plan.objects)
        if layout.codec.format != "<" + codes:
            names = ", ".join(object_name(*key) for key in plan.objects)
            reason = f"{names} are not of the types that the device profile prescribes"
            raise FieldbusError(catalogue.EDS_UNREADABLE, file="of the device", node=node, owner=owner, reason=reason)
        layouts[plan] = layout
    return layouts


def _need(od: canopen.ObjectDictionary, index: int, subindex: int, node: int, owner: str, purpose: str) -> None:
    try:
        find_variable(od, index, subindex)
    except KeyError as error:
        raise FieldbusError(
            catalogue.EDS_OBJECT_MISSING, node=node, owner=owner, object=error.args[0], purpose=purpose
        ) from error


def _guarded(od: canopen.ObjectDictionary, node: int, owner: str) -> bool:
    """Whether the node is of the time before the heartbeat. One that can be watched in neither way is refused."""
    if PRODUCER_HEARTBEAT in od:
        return False
    for index in (GUARD_TIME, LIFE_TIME_FACTOR):
        _need(od, index, 0, node, owner, "watching the node (it has no heartbeat, object 0x1017)")
    return True


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
