"""All registrations of the dialect: importing this module fills the tables."""

from __future__ import annotations

import runtime.cnc.decoder.nct.expressions
import runtime.cnc.decoder.nct.g_compensation
import runtime.cnc.decoder.nct.g_cycles
import runtime.cnc.decoder.nct.g_feed
import runtime.cnc.decoder.nct.g_length
import runtime.cnc.decoder.nct.g_macros
import runtime.cnc.decoder.nct.g_motion
import runtime.cnc.decoder.nct.g_offsets
import runtime.cnc.decoder.nct.g_reference
import runtime.cnc.decoder.nct.g_select
import runtime.cnc.decoder.nct.g_skip
import runtime.cnc.decoder.nct.g_spindle
import runtime.cnc.decoder.nct.g_stroke_check
import runtime.cnc.decoder.nct.g_transformations
import runtime.cnc.decoder.nct.m_program
import runtime.cnc.decoder.nct.variables_interface
import runtime.cnc.decoder.nct.variables_offsets
import runtime.cnc.decoder.nct.variables_positions
import runtime.cnc.decoder.nct.variables_program  # noqa: F401
