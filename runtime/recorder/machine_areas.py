"""The memories of a machine that pass through the border: what is looked at in them in every cycle."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

import numpy as np

from runtime.cnc import decoder_reports, preparation_link
from runtime.cnc.motion_queue import RECORD
from runtime.cnc.preparation_link import PreparationLink
from runtime.config.machine import Machine
from runtime.drives import DriveImage
from runtime.hli.external import ExternalVariable, external_variables
from runtime.hli.layout import MAX_AXES, MAX_CHANNELS, Hli
from runtime.hli.memory import layout_hash
from runtime.recorder.areas import Area, Element, elements_of, elements_of_record, words_of


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
    return Area(words_of(shared.buffer), words_of(own.buffer), _link_elements())


def _link_elements() -> Iterator[Element]:
    yield from elements_of_record(preparation_link.RECORD, preparation_link.GUARDS)
    at = preparation_link.RECORD.itemsize
    for k in range(decoder_reports.HEAD // 8):
        yield Element(f"told[{k}]", at + 8 * k, 8, 1, True)
    for k in range(decoder_reports.REPORTS):
        place = at + decoder_reports.HEAD + k * decoder_reports.RECORD.itemsize
        yield from elements_of_record(decoder_reports.RECORD, (), place)


def elements_of_image(image: DriveImage) -> list[Element]:
    """The arrays of a drive image."""
    found = []
    for name, word in image.places.items():
        array = getattr(image, name)
        found.append(Element(name, 8 * word, array.itemsize, array.size, False, array.dtype.char))
    return found


AREAS = ("hli", "preparation link", "drives", "figures of the drives")


def elements_of_area(area: int, image: DriveImage) -> list[Element]:
    """The elements of an area by its place in AREAS."""
    if area == 0:
        return [*elements_of(Hli)]
    if area == 1:
        return [*_link_elements()]
    return elements_of_image(image) if area == 2 else [Element("figure", 0, 8, 4, False, "d")]


def layouts(image: DriveImage) -> dict[str, str]:
    """What has to be alike for words of one runtime to mean the same in another."""
    return {
        "hli": layout_hash(),
        "preparation link": _digest([*_link_elements()]),
        "drives": _digest(elements_of_image(image)),
        "motion queue": _digest([*elements_of_record(RECORD, ())]),
    }


def _digest(elements: list[Element]) -> str:
    return hashlib.sha256(repr(elements).encode()).hexdigest()
