"""Errors of contouring, HSC, splines, filters and segmentation."""

from runtime.diagnostics.errors import ErrorEntry, Reaction

CHOOSE_ONE = ErrorEntry(
    300500,
    "{first} and {second} exclude each other",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="choose one of them",
)
METHOD_UNSUPPORTED = ErrorEntry(
    300501,
    "{method} is not supported by this version",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="choose another method of smoothing: DEV, DIST, DIST_SOFT, PTP or POS",
)
OF_OTHER_METHOD = ErrorEntry(
    300502,
    "{key} does not belong to {method}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="{method} takes {known}",
)
VALUE_RANGE = ErrorEntry(
    300503,
    "{key}={value:.9g} is not within {least:g} to {most:g}",
    reaction=Reaction.STOP_AT_BLOCK_END,
)
NOT_ABOVE = ErrorEntry(
    300509,
    "{key}={value:.9g} is not greater than {least:g}",
    reaction=Reaction.STOP_AT_BLOCK_END,
)
ACCELERATION_ORDER = ErrorEntry(300504, "ACC_MIN is greater than ACC_MAX", reaction=Reaction.STOP_AT_BLOCK_END)
SPLINE_POINTS = ErrorEntry(
    300505,
    "the {kind} spline ends after {points} points; it needs {least}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="program more points between selection and deselection, or straight moves without a spline",
)
WHILE_ACTIVE = ErrorEntry(
    300506,
    "{statement} cannot change anything while the curve is on",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="write it in front of the selection, or behind {off}",
)
TANGENT_AXIS = ErrorEntry(
    300507,
    "the tangent has no component of {axis}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="name all main axes, with 0 where the curve has no direction",
)
TANGENT_ZERO = ErrorEntry(300508, "the tangent has no direction", reaction=Reaction.STOP_AT_BLOCK_END)
NO_FILTER = ErrorEntry(
    300510,
    "no axis of the channel has a filter",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="describe the filters of the axes in the machine description (fir_filter)",
)
FILTER_WITHOUT_ORDER = ErrorEntry(
    300511,
    "the filters have no order",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="program ORDER or ORDER_TIME, or describe the order of the axes in the machine description",
)
ONE_DEVIATION_ZERO = ErrorEntry(
    21682,
    "{key} is 0 and {other} is not: a B-spline without one of its tolerances leaves the contour",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="program both tolerances greater than 0, or both 0 for the contour itself (P-CHAN-00241)",
)
