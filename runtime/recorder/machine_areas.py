"""The memories of a machine that pass through the border: what is looked at in them in every cycle."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from runtime.cnc.preparation_link import PreparationLink
from runtime.config.machine import Machine
from runtime.hli.external import ExternalVariable, external_variables
from runtime.hli.layout import MAX_AXES, MAX_CHANNELS, Hli
from runtime.recorder.areas import Area, words_of
from runtime.recorder.elements import Element, elements_of
from runtime.recorder.layouts import link_elements


def hli_area(machine: Machine, shared: Hli, own: Hli) -> Area:
    """The HLI; `own` has been described, the rest of both is alike. Channels and axes that the machine has not are left out."""
    variables = external_variables(own)
    return Area(words_of(shared), words_of(own), _hli_elements(variables), _hli_ranges(machine, variables))


def _hli_elements(variables: list[ExternalVariable]) -> Iterator[Element]:
    at = Hli.external.offset
    for element in elements_of(Hli):
        if element.offset == at:
            yield Element(element.name, at, 1, Hli.external.size, False)
        else:
            yield element
    for variable in variables:  # they lie as the machine description says
        for place in _places(variable):
            if place % variable.size == 0 and variable.size in (2, 4, 8) and variable.kind != "STRING":
                yield Element(variable.path, at + place, variable.size, 1, False)


def _places(variable: ExternalVariable) -> Iterator[int]:
    """Where the values of a variable begin, in the order of their indices."""
    for flat in np.ndindex(variable.dims):
        yield variable.offset + sum(i * stride for i, stride in zip(flat, variable.strides, strict=True))


def _hli_ranges(machine: Machine, variables: list[ExternalVariable]) -> Iterator[tuple[int, int]]:
    """Bytes that change while the machine runs."""
    parts: dict[str, float] = {
        "head": 1,
        "platform": 1,
        "image": 1,
        "alarm_count_r": 1,
        "alarms": 1,
        "timers": 1,
    }
    parts |= {
        "channels": len(machine.channels) / MAX_CHANNELS,
        "axes": len(machine.axes) / MAX_AXES,
        "operator": len(machine.channels) / MAX_CHANNELS,
    }
    for name, share in parts.items():
        place = getattr(Hli, name)
        yield place.offset, place.offset + round(place.size * share)
    end = max((last + variable.size for variable in variables for last in _places(variable)), default=0)
    yield Hli.external.offset, Hli.external.offset + -(-end // 8) * 8


def link_area(shared: PreparationLink, own: PreparationLink) -> Area:
    """The preparation link of a channel, with what is told at decoding time."""
    return Area(words_of(shared.buffer), words_of(own.buffer), link_elements())
