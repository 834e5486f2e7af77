"""Path preparation: what happens to blocks between the decoder and the motion queue."""

from runtime.cnc.path_preparation.block_search import BlockSearchStage
from runtime.cnc.path_preparation.control_areas import ControlAreas
from runtime.cnc.path_preparation.corner_deceleration import CornerDecelerations
from runtime.cnc.path_preparation.errors import PathError, SoftwareLimitError
from runtime.cnc.path_preparation.frames import Frames
from runtime.cnc.path_preparation.late_synchronisation import LateSynchronisation
from runtime.cnc.path_preparation.micro_joints import MicroJoints, MicroJointSettings
from runtime.cnc.path_preparation.queue_writer import PumpState, QueueWriter
from runtime.cnc.path_preparation.smoothing import smooth
from runtime.cnc.path_preparation.software_limits import SoftwareLimits
from runtime.cnc.path_preparation.spatial_arcs import SpatialArcs

__all__ = [
    "BlockSearchStage",
    "ControlAreas",
    "CornerDecelerations",
    "Frames",
    "LateSynchronisation",
    "MicroJointSettings",
    "MicroJoints",
    "PathError",
    "PumpState",
    "QueueWriter",
    "SoftwareLimitError",
    "SoftwareLimits",
    "SpatialArcs",
    "smooth",
]
