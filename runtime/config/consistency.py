"""The parts of a machine description that have to fit together."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from runtime.config.analogue import analogue_mistakes
from runtime.config.channel.key import key_text
from runtime.config.contradictions import Contradiction, Location
from runtime.config.error_texts import ErrorTexts, ErrorTextsError
from runtime.config.external import external_mistakes
from runtime.diagnostics.catalogue import configuration as errors
from runtime.diagnostics.catalogue import nct as nct_errors
from runtime.diagnostics.catalogue import spindle as errors_of_spindles
from runtime.diagnostics.errors import Place

if TYPE_CHECKING:
    from runtime.config.machine import AbsoluteEncoder, Axis, Channel, Machine


def inconsistencies(machine: Machine) -> Iterator[Contradiction]:
    """Everything that does not fit together; locations count from the machine."""
    yield from _twice(machine)
    yield from _buses(machine)
    yield from _shared_nodes(machine)
    yield from _drives(machine)
    yield from _measuring(machine)
    yield from _workpiece(machine)
    yield from _unknown_axes(machine)
    yield from _spindle_axes(machine)
    yield from _axis_groups(machine)
    yield from _short_watchdogs(machine)
    yield from analogue_mistakes(machine, _digital_names(machine))
    yield from external_mistakes(machine.structures, machine.external_variables)
    yield from _unusable_texts(machine)


def _unusable_texts(machine: Machine) -> Iterator[Contradiction]:
    """The file of error texts can be read: the preparation does so later, where nobody looks any more."""
    try:
        ErrorTexts.of(machine)
    except ErrorTextsError as error:
        values = {"file": machine.error_texts, "reason": error}
        yield Contradiction(errors.ERROR_TEXTS, ("error_texts",), values)


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
    owners: dict[tuple[str, int], str] = {
        (name, bus.master_node): f"the master (fieldbus.{f'buses.{name}' if name else 'bus'}.master_node)"
        for name, bus in machine.fieldbus.all_buses().items()
    }
    for bus_name, node, owner, location in _nodes(machine):
        if (bus_name, node) in owners:
            values = {"node": node, "first": owners[bus_name, node], "second": owner}
            yield Contradiction(errors.NODE_TWICE, (*location, "node"), values)
        else:
            owners[bus_name, node] = owner


def _nodes(machine: Machine) -> Iterator[tuple[str, int, str, Location]]:
    """Bus, node id, owner and place of every node."""
    for index, axis in enumerate(machine.axes):
        if axis.drive:
            bus = axis.drive.bus or ""
            yield bus, axis.drive.node, f"axis {axis.name}", ("axes", index, "drive")
            if gantry := axis.drive.gantry:
                owner = f"the second drive of axis {axis.name}"
                yield bus, gantry.node, owner, ("axes", index, "drive", "gantry")
    for index, io in enumerate(machine.fieldbus.io):
        yield io.bus or "", io.node, f"I/O node fieldbus.io[{index}]", ("fieldbus", "io", index)


def _buses(machine: Machine) -> Iterator[Contradiction]:
    """A node is on a bus that is described; two buses are two channels."""
    known = machine.fieldbus.all_buses()
    for bus_name, _, owner, location in _nodes(machine):
        if bus_name not in known:
            values = {"owner": owner, "bus": bus_name, "known": ", ".join(machine.fieldbus.buses) or "none"}
            yield Contradiction(errors.BUS_UNKNOWN, (*location, "bus"), values)
    channels: dict[tuple[str, str], str] = {}
    for name, bus in known.items():
        key = (bus.interface, bus.channel)
        if key in channels:
            values = {"channel": bus.channel, "first": channels[key] or "fieldbus.bus", "second": name}
            yield Contradiction(errors.BUS_TWICE, ("fieldbus", "buses", name, "channel"), values)
        channels.setdefault(key, name)


def _drives(machine: Machine) -> Iterator[Contradiction]:
    """What is asked of a drive goes together; inputs of drives are names of their own."""
    names = {name for io in machine.fieldbus.io for name in io.inputs}
    for index, axis in enumerate(machine.axes):
        drive = axis.drive
        by_drive = axis.homing is not None and axis.homing.method is not None
        encoder = axis.homing.absolute if axis.homing is not None else None
        if encoder is not None and (reason := _not_kept(axis, encoder)):
            yield _against(index, ("homing", "absolute"), axis.name, "a reference that is kept", reason)
        if by_drive and drive is None:
            yield _against(index, ("homing", "method"), axis.name, "homing by the drive", "the axis has no drive")
        if drive is None:
            continue
        if drive.gantry is not None:
            if by_drive and abs(drive.gantry.offset or 0.0) > drive.gantry.difference:
                reason = "each end stops at its own reference, and `offset` is greater than `difference`"
                yield _against(index, ("homing", "method"), axis.name, "homing by the drive", reason)
            if axis.type.value == "spindle":
                yield _against(index, ("drive", "gantry"), axis.name, "a second drive", "it is a spindle")
            if drive.mode == "cyclic_synchronous_velocity" or drive.modes:
                reason = "both drives have to follow positions"
                yield _against(index, ("drive", "gantry"), axis.name, "another mode of operation", reason)
        if axis.type.value == "spindle" and drive.mode not in (None, "cyclic_synchronous_velocity"):
            yield _against(
                index, ("drive", "mode"), axis.name, f"the mode {drive.mode}", "a spindle is told velocities"
            )
        for bit, name in drive.inputs.items():
            if name in names:
                location = ("axes", index, "drive", "inputs", bit)
                yield Contradiction(errors.NOT_UNIQUE, location, {"what": "Input", "value": name})
            names.add(name)


def _measuring(machine: Machine) -> Iterator[Contradiction]:
    """An axis that measures has the signal that it names."""
    for index, axis in enumerate(machine.axes):
        setup = axis.measuring
        if setup is None:
            continue
        what = "measuring"
        if axis.type.value == "spindle":
            yield _against(index, ("measuring",), axis.name, what, "it is a spindle")
        if setup.input is not None and setup.input not in _digital_inputs(machine):
            yield _against(index, ("measuring", "input"), axis.name, what, f"no node has an input {setup.input}")
        if setup.signal == "input" and setup.input is None:
            yield _against(index, ("measuring", "signal"), axis.name, what, "`input` does not name the signal")
        if setup.signal == "drive":
            edge = f"probe_{setup.touch_probe}_{setup.edge}"
            if axis.drive is None or edge not in axis.drive.process_data:
                reason = f"its drive does not exchange {edge} (process_data)"
                yield _against(index, ("measuring", "signal"), axis.name, what, reason)
    known = _digital_inputs(machine)
    for number, channel in enumerate(machine.channels):
        for place, name in enumerate(channel.nct.skip):
            if name not in known:
                location: Location = ("channels", number, "nct", "skip", place)
                yield Contradiction(nct_errors.SKIP_INPUT, location, {"name": name, "known": ", ".join(sorted(known))})


def _workpiece(machine: Machine) -> Iterator[Contradiction]:
    """The simulated workpiece lies in the space of axes with drives."""
    driven = [axis.name for axis in machine.axes if axis.drive]
    for name, (low, high) in machine.fieldbus.workpiece.items():
        location: Location = ("fieldbus", "workpiece", name)
        if name not in driven:
            yield _unknown(location, "The workpiece", name, "has no drive", ", ".join(driven), at_key=True)
        elif not low < high:
            values = {"axis": name, "what": f"the range {low:g} to {high:g} of the workpiece", "reason": "it is empty"}
            yield Contradiction(errors.DRIVE_CANNOT, location, values)


def _digital_inputs(machine: Machine) -> set[str]:
    names = {name for io in machine.fieldbus.io for name in io.inputs}
    return names | {name for axis in machine.axes if axis.drive for name in axis.drive.inputs.values()}


def _not_kept(axis: Axis, encoder: AbsoluteEncoder) -> str:
    """Why the reference of an axis cannot be kept, "" it can."""
    if axis.drive is None:
        return "the axis has no drive"
    if axis.drive.gantry is not None:
        return "the axis has two drives"
    if axis.type.value == "spindle":
        return "it is a spindle"
    if 2.0 * encoder.moved >= encoder.turn(axis.drive.increments_per_unit):
        return "`moved` is not below half of the range of the encoder"
    return ""


def _digital_names(machine: Machine) -> set[str]:
    names = {name for io in machine.fieldbus.io for name in (*io.inputs, *io.outputs)}
    return names | {name for axis in machine.axes if axis.drive for name in axis.drive.inputs.values()}


def _against(index: int, key: Location, axis: str, what: str, reason: str) -> Contradiction:
    values = {"axis": axis, "what": what, "reason": reason}
    return Contradiction(errors.DRIVE_CANNOT, ("axes", index, *key), values)


def _unknown(
    location: Location, user: str, axis: str, reason: str, known: str, *, at_key: bool = False
) -> Contradiction:
    values = {"user": user, "axis": axis, "reason": reason, "known": known}
    return Contradiction(errors.UNKNOWN_AXIS, location, values, at_key)


def _unknown_axes(machine: Machine) -> Iterator[Contradiction]:
    """A channel uses axes that are described, its zero offsets shift its own axes."""
    names = [axis.name for axis in machine.axes]
    for index, channel in enumerate(machine.channels):
        user = f"Channel {channel.name}"
        known = ", ".join(names)
        for number, name in enumerate(channel.axes):
            location: Location = ("channels", index, "axes", number)
            if name not in names:
                yield _unknown(location, user, name, "is not described under axes", known)
            elif name in channel.axes[:number]:
                yield _unknown(location, user, name, "stands in the list already", known)
            elif machine.axes[names.index(name)].type.value == "spindle":
                yield Contradiction(errors.SPINDLE_IN_PATH, location, {"channel": channel.name, "axis": name})
        for offset, shifts in channel.zero_offsets.items():
            for name in shifts:
                if name not in channel.axes:
                    location = ("channels", index, "zero_offsets", offset, name)
                    user = f"Zero offset {offset} of channel {channel.name}"
                    yield _unknown(
                        location, user, name, "is no axis of the channel", ", ".join(channel.axes), at_key=True
                    )


def _spindle_axes(machine: Machine) -> Iterator[Contradiction]:
    """The spindles of a channel are axes of type spindle, with the logical number that their parameters give."""
    axes = {axis.name: axis for axis in machine.axes}
    for channel_index, channel in enumerate(machine.channels):
        for index, spindle in enumerate(channel.parameters.spindel):
            location, place = _origin(channel_index, channel, "spindel", index, "bezeichnung")
            name = spindle.bezeichnung
            if name not in axes and spindle.optional:
                wanted = channel.parameters.main_spindle_ax_nr
                if index == 0 if wanted == 0 else spindle.log_achs_nr == wanted:
                    values = {"channel": channel.name, "axis": name}
                    yield Contradiction(errors_of_spindles.MAIN_SPINDLE_ABSENT, location, values, place=place)
                continue
            if name not in axes:
                values = {
                    "user": f"Channel {channel.name}",
                    "axis": name,
                    "reason": "is not described under axes",
                    "known": ", ".join(axes),
                }
                yield Contradiction(errors.UNKNOWN_AXIS, location, values, place=place)
                continue
            axis = axes[name]
            if axis.type.value != "spindle":
                values = {"channel": channel.name, "axis": name, "type": axis.type.value}
                yield Contradiction(errors.SPINDLE_EXPECTED, location, values, place=place)
            if spindle.log_achs_nr not in (None, axis.log_axis):
                yield _differs(
                    channel_index,
                    channel,
                    ("spindel", index, "log_achs_nr"),
                    spindle.log_achs_nr,
                    f"log_axis of {name}",
                    axis.log_axis,
                )


def _axis_groups(machine: Machine) -> Iterator[Contradiction]:
    """The axes that the parameters give are those of the channel."""
    numbers = {axis.name: axis.log_axis for axis in machine.axes}
    for index, channel in enumerate(machine.channels):
        for group_index, group in channel.parameters.gruppe.items():
            here = ("gruppe", group_index)
            if group.achs_anzahl not in (0, len(channel.axes)):
                yield _differs(
                    index, channel, (*here, "achs_anzahl"), group.achs_anzahl, "the number of axes", len(channel.axes)
                )
            for number, axis in group.achse.items():
                key = (*here, "achse", number)
                name = channel.axes[number] if number < len(channel.axes) else None
                if name is None:
                    member = next(member for member in ("bezeichnung", "log_achs_nr", "default_feed_axis")
                                  if member in axis.model_fields_set)  # fmt: skip
                    yield _differs(
                        index, channel, (*key, member), getattr(axis, member), f"axes[{number}]", "not given"
                    )
                    continue
                if axis.bezeichnung not in ("", name):
                    yield _differs(
                        index, channel, (*key, "bezeichnung"), axis.bezeichnung, f"axes[{number}] of the channel", name
                    )
                if axis.log_achs_nr is not None and axis.log_achs_nr != numbers.get(name, axis.log_achs_nr):
                    yield _differs(
                        index, channel, (*key, "log_achs_nr"), axis.log_achs_nr, f"log_axis of {name}", numbers[name]
                    )


def _origin(channel_index: int, channel: Channel, *key: str | int) -> tuple[Location, Place | None]:
    """Where a channel parameter was given: its location in the description, or its place in the list file."""
    location, place = channel.parameters.origin(*key)
    return ("channels", channel_index, "parameters", *location), place


def _differs(
    channel_index: int, channel: Channel, key: Location, given: object, what: str, other: object
) -> Contradiction:
    location, place = _origin(channel_index, channel, *key)
    values = {"key": key_text(key), "given": given, "what": what, "other": other}
    return Contradiction(errors.PARAMETER_CONTRADICTS, location, values, place=place)


def _short_watchdogs(machine: Machine) -> Iterator[Contradiction]:
    """A time limit longer than what it watches, else it fires on a healthy machine."""
    plc = machine.plc
    watched: list[tuple[str, float, str, float, Location]] = [
        ("The PLC watchdog", plc.watchdog, "the PLC cycle", plc.every * machine.cycle.period, ("plc", "watchdog"))
    ]
    for name, bus in machine.fieldbus.all_buses().items():
        place: Location = ("fieldbus", "buses", name) if name else ("fieldbus", "bus")
        what, of_what = "The heartbeat timeout", "the heartbeat's producer time"
        watched.append((what, bus.heartbeat_timeout, of_what, bus.heartbeat, (*place, "heartbeat_timeout")))
    for what, timeout, of_what, cycle, location in watched:
        if timeout <= cycle:
            values = {"what": what, "timeout": timeout, "cycle": cycle, "of_what": of_what}
            yield Contradiction(errors.WATCHDOG_TOO_SHORT, location, values)
