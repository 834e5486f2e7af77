"""How the memories lie that pass through the border: what has to be alike where a recording is replayed."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

from runtime.cnc import decoder_reports, preparation_link
from runtime.cnc.motion_queue import RECORD
from runtime.drives import DriveImage
from runtime.hli.layout import Hli
from runtime.hli.memory import layout_hash
from runtime.recorder.elements import Element, elements_of, elements_of_record


def link_elements() -> Iterator[Element]:
    """Those of the preparation link, with what is told at decoding time."""
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
        return [*link_elements()]
    return elements_of_image(image) if area == 2 else [Element("figure", 0, 8, 4, False, "d")]


def layouts(image: DriveImage) -> dict[str, str]:
    """What has to be alike for words of one runtime to mean the same in another."""
    return {
        "hli": layout_hash(),
        "preparation link": _digest([*link_elements()]),
        "drives": _digest(elements_of_image(image)),
        "motion queue": _digest([*elements_of_record(RECORD, ())]),
    }


def _digest(elements: list[Element]) -> str:
    return hashlib.sha256(repr(elements).encode()).hexdigest()
