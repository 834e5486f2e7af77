"""Analogue inputs and outputs of a CiA 401 node: where they stand in the device, and which quantity their counts are."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from runtime.config.contradictions import Contradiction, Location
from runtime.config.model import Model
from runtime.diagnostics.catalogue import configuration as errors

if TYPE_CHECKING:
    from runtime.config.machine import Machine

Counts = Annotated[tuple[int, int], Field(strict=False)]
Values = Annotated[tuple[float, float], Field(strict=False)]
LARGEST_IMAGE = 32  # analogue inputs, and outputs, of a machine


class AnalogueChannel(Model):
    """`counts` are what the device tells at `values`, on a straight line."""

    name: str = Field(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,47}$")
    bits: Literal[8, 16, 32] = 16  # object 0x6400, 0x6401 or 0x6402; of an output 0x6410, 0x6411 or 0x6412
    channel: Annotated[int, Field(ge=1, le=254)] | None = None  # its sub-index; default: the next one
    unit: str = Field(default="", max_length=15)
    counts: Counts | None = None  # default: 0 to the greatest that the bits hold
    values: Values
    range: Values | None = None  # in the unit; an input outside of it is not valid, an output is kept inside

    @property
    def counts_at_values(self) -> tuple[int, int]:
        """The counts at the first and at the second of `values`."""
        return self.counts or (0, (1 << self.bits - 1) - 1)

    @property
    def factor(self) -> float:
        """Units per count."""
        (low, high), (first, last) = self.counts_at_values, self.values
        return (last - first) / (high - low)

    @property
    def offset(self) -> float:
        """The value at count 0."""
        return self.values[0] - self.factor * self.counts_at_values[0]

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and greatest value that the counts can tell."""
        half = 1 << self.bits - 1
        ends = self.offset - self.factor * half, self.offset + self.factor * (half - 1)
        return min(ends), max(ends)


class AnalogueInput(AnalogueChannel):
    delta: Annotated[float, Field(gt=0)] | None = None  # the device tells a change by so much at once (0x6426)


class AnalogueOutput(AnalogueChannel):
    off: float | None = None  # at the end, and when the device misses the master (0x6444); default: the nearest to 0

    @property
    def limits(self) -> tuple[float, float]:
        """Least and greatest value that is put out: `range`, or else what `values` span."""
        low, high = self.range or self.values
        return min(low, high), max(low, high)

    @property
    def value_off(self) -> float:
        """In the unit."""
        low, high = self.limits
        return max(low, min(0.0, high)) if self.off is None else self.off


def sub_indices(channels: Sequence[AnalogueChannel]) -> list[int]:
    """The sub-index of each: the one that is given, or the next behind the one before."""
    found: list[int] = []
    for channel in channels:
        found.append(channel.channel or (found[-1] if found else 0) + 1)
    return found


def analogue_mistakes(machine: Machine, digital: set[str]) -> Iterator[Contradiction]:
    """What does not fit together. `digital`: the names of the inputs and outputs that are bits."""
    names = set(digital)
    counted = {"analogue_inputs": 0, "analogue_outputs": 0}
    for number, node in enumerate(machine.fieldbus.io):
        for key in ("analogue_inputs", "analogue_outputs"):
            channels: Sequence[AnalogueChannel] = getattr(node, key)
            subs = sub_indices(channels)
            for k, (channel, sub) in enumerate(zip(channels, subs, strict=True)):
                here: Location = ("fieldbus", "io", number, key, k)
                if channel.name in names:
                    yield Contradiction(
                        errors.NOT_UNIQUE, (*here, "name"), {"what": "Input or output", "value": channel.name}
                    )
                names.add(channel.name)
                if sub in subs[:k]:
                    yield _unfit(here, channel, f"channel {sub} of the device is given twice")
                for field, reason in _own_mistakes(channel):
                    yield _unfit((*here, field) if field in channel.model_fields_set else here, channel, reason)
            counted[key] += len(channels)
            if counted[key] > LARGEST_IMAGE:
                values = {"name": key, "reason": f"a machine has {LARGEST_IMAGE} at most"}
                yield Contradiction(errors.ANALOGUE_UNFIT, ("fieldbus", "io", number, key), values)


def _own_mistakes(channel: AnalogueChannel) -> Iterator[tuple[str, str]]:
    """Key and reason."""
    half = 1 << channel.bits - 1
    if any(not -half <= count < half for count in channel.counts_at_values):
        yield "counts", f"counts of {channel.bits} bits go from {-half} to {half - 1}"
        return
    for key, (first, last) in (("counts", channel.counts_at_values), ("values", channel.values)):
        if first == last:
            yield key, "both ends are the same"
            return
    low, high = channel.bounds
    if channel.range is not None and not channel.range[0] < channel.range[1]:
        yield "range", "its first value is not below the second"
    elif isinstance(channel, AnalogueOutput):
        least, greatest = channel.limits
        if least < low - abs(channel.factor) / 2 or greatest > high + abs(channel.factor) / 2:
            yield "range", f"the counts reach from {low:g} to {high:g} {channel.unit}".rstrip()
        elif not least <= channel.value_off <= greatest:
            yield "off", f"{channel.value_off:g} is not between {least:g} and {greatest:g}"


def _unfit(location: Location, channel: AnalogueChannel, reason: str) -> Contradiction:
    return Contradiction(errors.ANALOGUE_UNFIT, location, {"name": channel.name, "reason": reason})
