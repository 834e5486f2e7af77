"""Errors of the NCT dialect: coordinate systems, reference points, compensations, transformations.

Texts begin with the number that the manual gives, where it gives one.
"""

from runtime.diagnostics.errors import ErrorEntry, Reaction

STOP = Reaction.STOP_AT_BLOCK_END

# -- cutter compensation, on the way behind the decoder ------------------------------------------------------------

NO_INTERSECTION = ErrorEntry(
    322201,
    "3046: the paths of the tool of radius {radius:g} mm along this block and the next one do not meet",
    reaction=STOP,
    remedy="use a smaller tool, widen the contour",
    source="NCT manual line 3705",
)
INTERFERENCE = ErrorEntry(
    322202,
    "3048: the path of the tool of radius {radius:g} mm would run against the programmed direction",
    reaction=STOP,
    remedy="use a smaller tool, widen the contour; the check is over-careful at narrow recesses (INTERFER, ANGLAL)",
    source="NCT manual line 4161",
)
AFTER_ARC = ErrorEntry(
    322203,
    "3041: {what} in G41 or G42 stands beside an arc",
    reaction=STOP,
    remedy="program straight moves before and behind it, or cancel the compensation with G40",
    source="NCT manual line 4001",
)
START_IN_ARC = ErrorEntry(
    322204,
    "3043: G41 or G42 cannot begin with an arc",
    reaction=STOP,
    remedy="program G41 and G42 with a straight move (G00, G01)",
    source="NCT manual line 3597",
)
CANCEL_IN_ARC = ErrorEntry(
    322205,
    "3042: G40 cannot end the compensation with an arc",
    reaction=STOP,
    remedy="program G40 with a straight move (G00, G01)",
    source="NCT manual line 3735",
)
CHANGE_IMPOSSIBLE = ErrorEntry(
    322206,
    "3047: the side of the compensation cannot change over this arc",
    reaction=STOP,
    remedy="change the side at a straight move, or lead both paths to a common point",
    source="NCT manual line 3836",
)
RADIUS_OVER_ARC = ErrorEntry(
    322207,
    "the arc of radius {arc:g} mm is too small for a compensation of {radius:g} mm",
    reaction=STOP,
    remedy="use a smaller tool or a larger arc",
    source="NCT manual line 4217",
)
