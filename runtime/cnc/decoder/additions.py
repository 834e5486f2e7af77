"""The # additions of a motion block: #ANG, #CANG, #CHR, #CHF, #RND, #FRC (programming manual 2420–2952, 5291–5555)."""

from __future__ import annotations

from runtime.cnc.blocks import Corner
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock
from runtime.cnc.language.isg.words import WordKind
from runtime.diagnostics.catalogue import language as catalogue


def corner_of(x: Execution, block: CompiledBlock) -> Corner | None:
    """The chamfer or rounding that the block asks for at its end."""
    for name in ("CHR", "CHF", "RND", "FRC"):
        if name in x.additions:
            raise LineError(catalogue.NOT_SUPPORTED, block.column(WordKind.ADDITION), what=f"#{name}")
    return None


def contour_line(x: Execution, block: CompiledBlock, corner: Corner | None) -> bool:
    """A line by its angle; whether the block was one."""
    if "ANG" in x.additions:
        raise LineError(catalogue.NOT_SUPPORTED, block.column(WordKind.ADDITION), what="#ANG")
    return False


def arc_by_angle(x: Execution, block: CompiledBlock, corner: Corner | None) -> bool:
    """A circle by centre and opening angle; whether the block was one."""
    if "CANG" in x.additions:
        raise LineError(catalogue.NOT_SUPPORTED, block.column(WordKind.ADDITION), what="#CANG")
    return False
