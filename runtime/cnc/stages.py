"""The stages between the decoder and the motion queue, in their order: what a check, a simulation and a machine do alike.

decoder ─ late synchronisation ─ radius compensation ─ rotated frames ─ arcs in space ─ smoothing ─ corner deceleration
        ─ software limits ─ work and protection spaces ─ micro-joints, if the channel has them ─▶
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from runtime.cnc.blocks import Block
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.path_preparation import (
    ControlAreas,
    CornerDecelerations,
    Frames,
    LateSynchronisation,
    MicroJoints,
    MicroJointSettings,
    SoftwareLimits,
    SpatialArcs,
    smooth,
)
from runtime.cnc.path_preparation.coupled_limits import coupled_limits
from runtime.cnc.tool_radius_comp import ToolRadiusCompensation
from runtime.diagnostics.errors import Problem


def prepared(
    blocks: Iterable[Block],
    axes: AxisLimits,
    limits: SoftwareLimits,
    late: LateSynchronisation,
    warnings: list[Problem] | None = None,
    joints: MicroJointSettings | None = None,
) -> Iterator[Block]:
    """The blocks of one program as they are to be driven; `late` lives as long as the channel.

    What there is to warn of goes to `warnings`. Raises what the stages raise: each of them a TandemError with its place.
    """
    compensated = ToolRadiusCompensation()(late(blocks))
    smoothed = smooth(SpatialArcs()(Frames()(compensated)), axes, warnings)
    limited = ControlAreas()(limits(coupled_limits(CornerDecelerations()(smoothed), limits.configured), warnings))
    return limited if joints is None else MicroJoints(joints, warnings)(limited)
