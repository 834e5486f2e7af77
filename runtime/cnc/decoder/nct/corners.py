"""Chamfers ,C and roundings ,R between two motions (manual lines 4505–4565).

The shared stage inserts them; here is what the dialect allows, and its own names for what is wrong.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from runtime.cnc.blocks import Arc, Block, Corner, CornerKind, Line, Polyline
from runtime.cnc.decoder.corners import NO_LENGTH, CornerError, Corners
from runtime.cnc.decoder.modal import PLANE_AXES, Motion
from runtime.cnc.decoder.motion import size_scale
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.language.errors import LineError, ProgramError
from runtime.diagnostics.catalogue import language
from runtime.diagnostics.catalogue import nct as catalogue
from runtime.diagnostics.errors import Place

_KINDS = {",C": CornerKind.CHAMFER_WIDTH, ",R": CornerKind.ROUNDING}


def corner_of(x: NctExecution) -> Corner | None:
    """The chamfer or rounding at the end of the block in work. LineError 3017, 3081."""
    words = x.words
    asked = [address for address in _KINDS if address in words]
    if not asked:
        return None
    if len(asked) > 1:
        raise LineError(catalogue.CORNER_BOTH, words.place(",R"))
    column = words.place(asked[0])
    plane = PLANE_AXES[x.modal.plane]
    if x.modal.motion is Motion.RAPID:
        raise LineError(catalogue.CORNER_DEFINITION, column, reason="this is a rapid motion")
    if any(axis not in plane for axis in x.axis_words):
        raise LineError(catalogue.CORNER_DEFINITION, column, reason="an axis outside of the plane moves")
    size = x.length(words.number(asked[0]) or 0.0)
    if not size > 0.0:
        raise LineError(catalogue.CORNER_DEFINITION, column, reason="its size has to be above 0")
    return Corner(_KINDS[asked[0]], size * size_scale(x, plane))


def with_corners(blocks: Iterable[Block], stage: Corners) -> Iterator[Block]:
    """The blocks with what is inserted. ProgramError 3081 and 3084 at the block that asks for it."""
    try:
        yield from stage(_allowed(blocks))
    except CornerError as error:
        problem = error.problem
        if problem.entry is language.CORNER_TOO_LARGE:
            raise ProgramError(catalogue.CORNER_HIGH, problem.place) from None
        raise ProgramError(catalogue.CORNER_DEFINITION, problem.place, reason=problem.text) from None


def _allowed(blocks: Iterable[Block]) -> Iterator[Block]:
    """The blocks, as long as a motion behind one with a corner is G01, G02 or G03 in its plane."""
    before: Line | Arc | None = None
    for block in blocks:
        if before is not None and isinstance(block, Line | Arc | Polyline):
            reason = _why_not(before, block)
            if reason:
                place = Place(before.source.program, before.source.line)
                raise ProgramError(catalogue.CORNER_DEFINITION, place, reason=reason)
            before = None
        if isinstance(block, Line | Arc) and block.corner is not None:
            before = block
        yield block


def _why_not(before: Line | Arc, block: Line | Arc | Polyline) -> str:
    if isinstance(block, Polyline):
        rapid, way = block.feeds[0] == float("inf"), block.points[1] - block.points[0]
    else:
        rapid, way = isinstance(block, Line) and block.rapid, block.end - block.start
    if rapid:
        return "the next motion is a rapid one"
    outside = [axis for axis in range(len(way)) if axis not in before.plane]
    return (
        "an axis outside of the plane moves in the next block"
        if any(abs(way[axis]) > NO_LENGTH for axis in outside)
        else ""
    )
