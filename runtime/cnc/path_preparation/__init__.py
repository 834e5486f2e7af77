"""Path preparation: what happens to blocks between the decoder and the motion queue."""

from runtime.cnc.path_preparation.errors import PathError, SoftwareLimitError
from runtime.cnc.path_preparation.queue_writer import PumpState, QueueWriter
from runtime.cnc.path_preparation.software_limits import SoftwareLimits

__all__ = ["PathError", "PumpState", "QueueWriter", "SoftwareLimitError", "SoftwareLimits"]
