"""What the machine consists of, written into a new HLI from the machine description."""

from __future__ import annotations

from runtime.config.external import ExternalLayout
from runtime.config.machine import AxisType, Machine
from runtime.hli.analogue import AnaloguePlaces, OutputPlace
from runtime.hli.external import describe_external, directory_of
from runtime.hli.layout import Hli
from runtime.hli.memory import put_text

AXIS_TYPE = {AxisType.LINEAR: 1, AxisType.ROTARY: 2, AxisType.SPINDLE: 4}  # P-AXIS-00018


def describe_machine(hli: Hli, machine: Machine) -> None:
    """Write names, numbers and types. The index of an axis is its index in the machine description."""
    head = hli.head
    put_text(head, "machine_name_r", machine.name)
    head.cycle_time_r = round(machine.cycle.period * 1e6)
    head.channels_r = len(machine.channels)
    head.axes_r = len(machine.axes)
    for area, axis in zip(hli.axes, machine.axes, strict=False):
        put_text(area, "name_r", axis.name)
        area.log_ax_n_r = axis.log_axis
        area.axis_type_r = AXIS_TYPE[axis.type]
    for index, (area, channel) in enumerate(zip(hli.channels, machine.channels, strict=False)):
        put_text(area, "name_r", channel.name)
        area.number_r = channel.number(index)
        area.axis_count_r = len(channel.axes)
        for i, name in enumerate(channel.axes):
            area.axis_index_r[i] = machine.axis_index(name)
    for place in analogue_places(machine).outputs.values():
        hli.image.analogue_out_w[place.place] = place.off
    describe_external(hli, directory_of(ExternalLayout.of(machine).elements))


def io_bits(machine: Machine) -> tuple[dict[str, int], dict[str, int]]:
    """The image bit of every input and of every output: counted through over the I/O nodes, in their order.

    Behind the inputs of the I/O nodes stand those of drives (object 0x60FD), in the order of the axes and of their bits.
    """
    inputs = [name for node in machine.fieldbus.io for name in node.inputs]
    inputs += [name for axis in machine.axes if axis.drive for _, name in sorted(axis.drive.inputs.items())]
    outputs = [name for node in machine.fieldbus.io for name in node.outputs]
    return {name: bit for bit, name in enumerate(inputs)}, {name: bit for bit, name in enumerate(outputs)}


def analogue_places(machine: Machine) -> AnaloguePlaces:
    """Where the analogue values of a machine stand."""
    inputs = [one.name for node in machine.fieldbus.io for one in node.analogue_inputs]
    outputs = [one for node in machine.fieldbus.io for one in node.analogue_outputs]
    return AnaloguePlaces(
        {name: index for index, name in enumerate(inputs)},
        {one.name: OutputPlace(index, *one.limits, one.value_off) for index, one in enumerate(outputs)},
    )
