"""All registrations of the dialect: importing this module fills the tables."""

from runtime.cnc.decoder.isg import (  # noqa: F401 - each registers what it is named after
    g_calls,
    g_coordinates,
    g_feed,
    g_motion,
    g_offsets,
    statements_channel,
    statements_errors,
    statements_file_access,
    statements_messages,
    statements_timers,
    statements_variables,
    variables_axis,
    variables_channel,
    variables_flags,
    variables_functions,
    variables_spindle,
    variables_stamps,
    variables_zero_offsets,
)
