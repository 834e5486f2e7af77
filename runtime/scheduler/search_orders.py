"""From the order of a block search in the HLI to what the preparation is to look for."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from runtime.cnc.block_search import PointOfInterruption
from runtime.cnc.search_target import BlockSearch, SearchKind
from runtime.diagnostics.catalogue import block_search as catalogue
from runtime.diagnostics.errors import Problem
from runtime.hli.layout import Hli, SearchOrder
from runtime.hli.memory import get_text
from runtime.hli.modes import Work
from runtime.hli.units import LENGTH, SPEED

Floats = npt.NDArray[np.float64]
_SHARE = 1e-3  # 0.1 %


def search_of(
    order: SearchOrder | None, work: Work, point: PointOfInterruption | None, n_axes: int
) -> tuple[BlockSearch | None, Floats | None] | Problem:
    """The search, and where the program takes the axes to be at its beginning if not where they are; or why it is refused."""
    if order is None:
        return None, None
    if order.type not in list(SearchKind):
        return Problem(catalogue.SEARCH_KIND, {"kind": int(order.type)})
    if work.text:
        return Problem(catalogue.SEARCH_NO_TEXT)
    kind = SearchKind(order.type)
    way, line, begin = 0.0, 0, None
    if kind is SearchKind.INTERRUPTION:
        if point is None or not point.valid or point.program != work.content:
            return Problem(catalogue.SEARCH_NO_POINT, {"program": work.content})
        way, line, begin = point.way, point.line, point.begin
    search = BlockSearch(
        kind,
        value=min(int(order.value), 2**62),
        passes=max(int(order.passes), 1),
        program=get_text(order, "program"),
        covered=min(order.covered * _SHARE, 1.0),
        way=way,
        line=line,
        automatic=bool(order.automatic_return),
        without_stop=bool(order.no_hold),
        feed=order.return_feed * SPEED * 60.0,
        ranks=tuple(int(order.ranks[k]) for k in range(n_axes)),
    )
    return search, begin


def point_in(hli: Hli, n_axes: int) -> PointOfInterruption | None:
    """The point of interruption that stands in the HLI; None if there is none."""
    told = hli.channels[0].status.interruption
    line, n, way = int(told.line_r), int(told.block_number_r), float(told.way_r) * LENGTH
    if not told.valid_r:
        return None
    begin = np.array([told.begin_r[k] * LENGTH for k in range(n_axes)])
    return PointOfInterruption(get_text(told, "program_r"), begin, way, line, n)
