"""Importing this module registers the warm-ups of every kernel that the machine uses."""

import runtime.cnc.axes.supervision
import runtime.cnc.decoder
import runtime.cnc.interpolator
import runtime.cnc.path_preparation  # noqa: F401
