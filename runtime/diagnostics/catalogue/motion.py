"""Errors of motion: limits, geometry, following error, standstill."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity

SOFTWARE_LIMIT = ErrorEntry(
    301001,
    "{what} of axis {axis}, {position:.4f}, lies beyond its software limit {limit_name} = {limit:.4f}",
    Severity.ERROR,
    Reaction.STOP_AT_BLOCK_END,
    "Correct the target or the zero offset, or clamp the workpiece elsewhere; the limits are position_min and "
    "position_max of the axis in the machine description.",
)
PATH_GAP = ErrorEntry(
    301002,
    "the block starts at {start:.6f} of axis {axis}, but the path so far ends at {end:.6f}",
    Severity.ERROR,
    Reaction.STOP_ON_PATH,
    "The path must not jump. If no offset was changed by hand this is an error of the control: report it with "
    "the program.",
)
NO_FEED = ErrorEntry(
    301003,
    "a feed of {feed:g} mm/min cannot be driven",
    Severity.ERROR,
    Reaction.REFUSE,
    "Program a feed F greater than 0 before the move.",
)
NOT_FINITE = ErrorEntry(
    301004,
    "the target of axis {axis} is not a number",
    Severity.ERROR,
    Reaction.REFUSE,
    "Check the expressions of the block: one of them overflows.",
)
ARC_GEOMETRY = ErrorEntry(
    301005,
    "an arc of radius {radius:g} mm and {angle:g} degrees cannot be driven",
    Severity.ERROR,
    Reaction.REFUSE,
    "Check centre, radius and end point of the arc.",
)
POLYNOMIAL_GEOMETRY = ErrorEntry(
    301006,
    "a polynomial of this block stands still somewhere on its way and cannot be driven at a path velocity",
    Severity.ERROR,
    Reaction.REFUSE,
    "Move the points of the curve apart, or switch the smoothing off for this block.",
)
CONTOUR_AT_END = ErrorEntry(
    301007,
    "G61 asks for contouring at the end of this block, but no motion follows",
    Severity.WARNING,
    Reaction.NONE,
    "Remove G61, or move it to a block with a motion behind it.",
)
