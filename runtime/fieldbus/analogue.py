"""The analogue values of an I/O node (CiA 401): counts on the wire, quantities with a unit in the image.

An input outside of its range (a broken wire, a value that no sensor tells) is not valid, nor is one of a lost node; of that
the image keeps the last value. An output is kept inside its limits whatever stands in the image.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Final

import can

from runtime.config.analogue import AnalogueInput, AnalogueOutput, sub_indices
from runtime.config.machine import IoNode
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.drives import DriveEvent, DriveImage
from runtime.fieldbus.exchange import READ_ANALOGUE, WRITE_ANALOGUE, AnalogueNeeds
from runtime.fieldbus.network import fill
from runtime.fieldbus.pdo import Direction, ObjectKey, PdoLayout, PdoPlan

TRIGGER: Final = 0x6421  # what makes the device tell an input
TRIGGER_DELTA: Final = 0x04
GLOBAL_ENABLE: Final = 0x6423  # FALSE at power-on: then no change is told
DELTA: Final = 0x6426
ERROR_MODE: Final = 0x6443
ERROR_VALUE: Final = 0x6444
TOLD_PAUSE: Final = 1.0  # s, until the same input is told again to be out of its range
COUNTS: Final = {8: (-0x80, 0x7F), 16: (-0x8000, 0x7FFF), 32: (-0x8000_0000, 0x7FFF_FFFF)}


@dataclass(slots=True)
class Input:
    """One input. `place`: in the image."""

    described: AnalogueInput
    key: ObjectKey
    place: int
    counts: int = 0
    valid: bool = False
    told: float = -math.inf  # s

    @property
    def value(self) -> float:
        """In the unit."""
        return self.described.offset + self.described.factor * self.counts

    @property
    def delta_counts(self) -> int:
        """What the device has to tell at once, 0: nothing."""
        delta = self.described.delta
        return 0 if delta is None else max(1, round(delta / abs(self.described.factor)))


@dataclass(slots=True)
class Output:
    """One output. `place`: in the image."""

    described: AnalogueOutput
    key: ObjectKey
    place: int

    def counts(self, value: float) -> int:
        """The counts of a value; of one that is no number those of `off`."""
        least, greatest = self.described.limits
        if not math.isfinite(value):
            value = self.described.value_off
        value = max(least, min(greatest, value))
        low, high = COUNTS[self.described.bits]
        return max(low, min(high, round((value - self.described.offset) / self.described.factor)))


@dataclass(slots=True)
class AnalogueValues:
    """Those of one node."""

    inputs: tuple[Input, ...] = ()
    outputs: tuple[Output, ...] = ()
    left_adjusted: bool = False
    changed: bool = False  # something has come that the image does not have
    was_lost: bool = False
    _rows: list[tuple[can.Message, Callable[..., bytes], list[Output]]] = field(default_factory=list)

    @staticmethod
    def of(node: IoNode, first_input: int, first_output: int) -> AnalogueValues:
        """`first_input`, `first_output`: places of the first ones in the image."""
        inputs = zip(node.analogue_inputs, sub_indices(node.analogue_inputs), strict=True)
        outputs = zip(node.analogue_outputs, sub_indices(node.analogue_outputs), strict=True)
        return AnalogueValues(
            tuple(Input(one, (READ_ANALOGUE[one.bits], sub), first_input + k) for k, (one, sub) in enumerate(inputs)),
            tuple(Output(one, (WRITE_ANALOGUE[one.bits], sub), first_output + k) for k, (one, sub) in enumerate(outputs)),
            node.left_adjusted,
        )  # fmt: skip

    def needs(self, every: int, period: float) -> AnalogueNeeds:
        """What goes through PDOs; `every`: cycles, `period` of one, s."""
        plain = tuple(one.key for one in self.inputs if not one.delta_counts)
        watched = tuple(one.key for one in self.inputs if one.delta_counts)
        return AnalogueNeeds(plain, watched, tuple(one.key for one in self.outputs), every, period)

    def use(self, layouts: dict[PdoPlan, PdoLayout], frame: Callable[[PdoPlan], can.Message]) -> None:
        """Make the messages of the outputs; `frame` makes an empty one."""
        outputs = {one.key: one for one in self.outputs}
        for plan, layout in layouts.items():
            if plan.direction is Direction.RECEIVE and plan.objects[0] in outputs:
                self._rows.append((frame(plan), layout.codec.pack, [outputs[key] for key in plan.objects]))

    def receiver(self, plan: PdoPlan, layout: PdoLayout) -> Callable[[bytearray], None]:
        """Who takes the data of a PDO with inputs."""
        inputs = {one.key: one for one in self.inputs}
        row = [inputs[key] for key in plan.objects]
        codec = layout.codec

        def receive(data: bytearray) -> None:
            if len(data) >= codec.size:
                for one, counts in zip(row, codec.unpack_from(data), strict=True):
                    one.counts = counts
                self.changed = True

        return receive

    def publish(self, image: DriveImage, *, lost: bool, now: float, event: Callable[[int, str], DriveEvent]) -> None:
        """The inputs into the image. `event` makes one of the node from id and text."""
        self.changed, self.was_lost = False, lost
        for one in self.inputs:
            value = one.value
            span = one.described.range
            inside = span is None or span[0] <= value <= span[1]
            if one.valid and not inside and not lost and now - one.told >= TOLD_PAUSE:
                one.told = now
                text = f"{one.described.name} is {value:.6g} {one.described.unit}".rstrip()
                image.events.append(event(catalogue.ANALOGUE_OUT_OF_RANGE.id, text))
            one.valid = inside and not lost
            if not lost:
                image.analogue_in[one.place] = value
            image.analogue_valid[one.place] = one.valid

    def command(self, image: DriveImage, *, due: bool) -> Iterator[can.Message]:
        """The messages of the outputs that have changed, or of all."""
        for message, pack, outputs in self._rows:
            data = pack(*[one.counts(float(image.analogue_out[one.place])) for one in outputs])
            if due or data != message.data:
                fill(message, data)
                yield message

    def switch_off(self, image: DriveImage) -> None:
        """The outputs at the end."""
        for one in self.outputs:
            image.analogue_out[one.place] = one.described.value_off

    def set_up(self) -> Iterator[tuple[int, int, int]]:
        """What the node is told before it runs: index, sub-index, value."""
        for one in self.inputs:
            if counts := one.delta_counts:
                yield TRIGGER, one.key[1], TRIGGER_DELTA
                yield DELTA, one.key[1], self._adjusted(counts, one.described.bits)
        if any(one.delta_counts for one in self.inputs):
            yield GLOBAL_ENABLE, 0, 1

    def set_up_if_there(self) -> Iterator[tuple[int, int, int]]:
        """The same, where the node has the object: what outputs are without the master."""
        for one in self.outputs:
            counts = one.counts(one.described.value_off)
            yield ERROR_MODE, one.key[1], 1
            yield ERROR_VALUE, one.key[1], self._adjusted(counts, one.described.bits)

    def _adjusted(self, counts: int, bits: int) -> int:
        """Within the 32 bits of an object that belongs to values of so many bits."""
        return counts << 32 - bits if self.left_adjusted else counts

    def counts_of(self, number: int, bits: int) -> int:
        """The counts in such an object."""
        return number >> 32 - bits if self.left_adjusted else number
