"""Places in a program as the user writes them, for a block search."""

from __future__ import annotations

import re

import typer

from runtime.cnc.search_target import SearchKind
from runtime.hli.layout import SearchOrder
from runtime.hli.units import PERCENT, SPEED

HELP = "Enter the program here: N80 block number, 12 line, block:40 block counter, offset:1000 file offset."
_KINDS = {
    "N": SearchKind.BLOCK_NUMBER,
    "": SearchKind.LINE,
    "BLOCK:": SearchKind.BLOCK_COUNTER,
    "OFFSET:": SearchKind.FILE_OFFSET,
}
_PLACE = re.compile(r"(N|BLOCK:|OFFSET:|)\s*(\d{1,15})", re.IGNORECASE)


def search_order(
    place: str, passes: int = 1, program: str = "", covered: float = 0.0, feed: float = 0.0, *, automatic: bool = False
) -> SearchOrder:
    """The order to enter a program at `place`. `covered` in percent of its first motion, `feed` of the return in mm/min.

    `automatic`: nobody is asked before the axes move. Raises typer.BadParameter for a place that is none.
    """
    match = _PLACE.fullmatch(place.strip())
    if place and match is None:
        raise typer.BadParameter(f"{place!r} is no place: say N80, 12 (a line), block:40 or offset:1000")
    order = SearchOrder(passes=passes, covered=round(covered / PERCENT), return_feed=round(feed / 60.0 / SPEED))
    if match is not None:
        order.type, order.value = int(_KINDS[match.group(1).upper()]), int(match.group(2))
    order.program = program.encode()
    order.automatic_return = order.no_hold = automatic
    return order
