"""All registrations of the dialect: importing this module fills the tables."""

from runtime.cnc.decoder.isg import (  # noqa: F401 - each registers what it is named after
    g_calls,
    g_coordinates,
    g_feed,
    g_motion,
    g_offsets,
    statements_channel,
    statements_cycles,
    statements_display,
    statements_files,
    statements_variables,
    variables_axis,
    variables_channel,
    variables_program,
)
