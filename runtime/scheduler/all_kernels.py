"""Importing this module registers the warm-ups of every kernel that there is: what a first start compiles."""

import runtime.cnc.axes.compensation
import runtime.cnc.axes.supervision
import runtime.cnc.decoder
import runtime.cnc.interpolator
import runtime.cnc.interpolator.path_storage
import runtime.cnc.path_preparation
import runtime.cnc.technology.ahead
import runtime.cnc.tool_radius_comp.corners
import runtime.cnc.tool_radius_comp.elements
import runtime.cnc.tool_radius_comp.meeting
import runtime.recorder.areas
import runtime.recorder.border
import runtime.scheduler.publish
import runtime.scheduler.trace_difference  # noqa: F401
