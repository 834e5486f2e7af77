"""The stages that change the programmed path on purpose, in their order."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from runtime.cnc.blocks import Block
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.path_preparation.contouring import ContouringStage
from runtime.cnc.path_preparation.segmentation import SegmentationStage
from runtime.cnc.path_preparation.splines import SplineStage
from runtime.diagnostics.errors import Problem


def smooth(blocks: Iterable[Block], limits: AxisLimits, warnings: list[Problem] | None = None) -> Iterator[Block]:
    """The blocks of one program with all smoothing that they ask for; what there is to warn of goes to `warnings`."""
    splines, contouring = SplineStage(), ContouringStage(limits)
    if warnings is not None:
        contouring.warnings = warnings
    return contouring(splines(SegmentationStage()(blocks)))
