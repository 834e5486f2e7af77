"""The interface's own whole numbers and what they are in mm, degrees, seconds and percent.

Lengths of 0.1 µm and angles of 0.0001 degrees have the same factor, and so have speeds of 1 µm/s and 0.001 degrees/s:
nothing here needs to know whether an axis is linear or rotary.
"""

from __future__ import annotations

import math

LENGTH = 1e-4  # 0.1 µm -> mm, 0.0001 degrees -> degrees
SPEED = 1e-3  # 1 µm/s -> mm/s, 0.001 degrees/s -> degrees/s
PERCENT = 0.1  # 0.1 % -> %
MICROSECOND = 1e-6
NANOSECOND = 1e-9
REV_PER_MIN = 1e-3 / 6.0  # 0.001 degrees/s -> rev/min

INT32 = 2**31 - 1
RAPID = INT32  # command_feed_r of a rapid move: each axis as fast as it may

FACTORS: dict[str, float] = {
    # element, or the unit whose values all have it -> factor
    "position_r": LENGTH,
    "command_position_r": LENGTH,
    "actual_position_r": LENGTH,
    "target_position_r": LENGTH,
    "position_lag_r": LENGTH,
    "path_position_r": LENGTH,
    "way_r": LENGTH,
    "dist_to_geom_end_r": LENGTH,
    "begin_r": LENGTH,
    "return_feed": SPEED,
    "covered": PERCENT,
    "techno_path_to_go_r": LENGTH,
    "command_feed_r": SPEED,
    "active_feed_r": SPEED,
    "actual_velocity_r": SPEED,
    "revolutions_r": SPEED,
    "programmed_speed_r": SPEED,
    "command_speed_r": SPEED,
    "actual_speed_r": SPEED,
    "offset_r": LENGTH,
    "width": LENGTH,
    "jog_weg_r": LENGTH,
    "hr_aufloesung_r": LENGTH,
    "velocity": SPEED,
    "tipp_geschw_r": SPEED,
    "jog_geschw_r": SPEED,
    "hold_time": MICROSECOND,
    "override": PERCENT,
    "rapid_override": PERCENT,
    "ext_command_speed": SPEED,
    "override_w": PERCENT,
    "active_override_r": PERCENT,
    "covered_distance_r": PERCENT,
    "cycle_time_r": MICROSECOND,
    "cycle_time_w": MICROSECOND,
    "time_r": MICROSECOND,
    "techno_time_to_go_r": MICROSECOND,
    "time_ns_r": NANOSECOND,
    "plc_cycle_time_ns_w": NANOSECOND,
    "work_time_ns_r": NANOSECOND,
    "lateness_ns_r": NANOSECOND,
}


def to_int32(value: float, factor: float) -> int:
    """The interface's whole number for `value`, at the ends of the 32-bit range where it would not fit."""
    if math.isnan(value):
        return 0
    return int(min(max(round(value / factor) if math.isfinite(value) else math.copysign(INT32, value), -INT32), INT32))
