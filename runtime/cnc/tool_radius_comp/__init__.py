"""Tool radius compensation: between decoder and path preparation (see stage.py)."""

from runtime.cnc.tool_radius_comp.errors import CompensationError
from runtime.cnc.tool_radius_comp.stage import ToolRadiusCompensation

__all__ = ["CompensationError", "ToolRadiusCompensation"]
