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
    remedy="use a smaller tool, widen the contour; the check is over-careful at narrow recesses (interfer, anglal)",
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
DIRECTION_ZERO = ErrorEntry(
    322208, "I, J and K give no direction", remedy="one of the two of the plane has to differ from 0"
)
HOLD_OUTSIDE = ErrorEntry(322209, "3039: G38 needs cutter compensation", remedy="program it while G41 or G42 holds")
HOLD_IN_ARC = ErrorEntry(322210, "3040: G38 needs a straight move", remedy="program it while G00 or G01 holds")
ARC_OUTSIDE = ErrorEntry(322211, "3036: G39 needs cutter compensation", remedy="program it while G41 or G42 holds")

# -- offsets, lengths, reference points ----------------------------------------------------------------------------

AXIS_WANTED = ErrorEntry(322101, "{what} needs an axis", remedy="write the axes that it is for into the block")
VALUE_MISSING = ErrorEntry(322102, "{what} needs {word}", remedy="write {word} with its value into the block")
SETTING_UNKNOWN = ErrorEntry(
    322103,
    "G10 sets nothing without L2, L10, L11, L12 or L13",
    remedy="L2: work offsets; L10 to L13: compensation registers",
)
OFFSET_ERRONEOUS = ErrorEntry(
    322104,
    "3008: G45 to G48 with D{number}, while the offset of D{other} is still in the position",
    remedy="take the offset back with the same D first",
)
OFFSET_BESIDE = ErrorEntry(322105, "{name} cannot stand beside cutter compensation", remedy="program G40 first")
REFERENCE_FORMAT = ErrorEntry(322106, "3051: {name}: {reason}", remedy="G28 v, G29 v, G30 v P: v are axis words")
FIXED_POINT_MISSING = ErrorEntry(
    322107,
    "axis {axis} has no reference point {number}",
    remedy="give it in the machine description: axes[].reference_points",
)

# -- transformations -----------------------------------------------------------------------------------------------

MIRROR_INSIDE = ErrorEntry(
    322150, "3000: a mirror image cannot change while G51 or G68 holds", remedy="program G50 and G69 before it"
)
NOT_NESTED = ErrorEntry(
    322151, "{name} before {other}: what was switched on last is switched off first", remedy="program {other} before it"
)
PLANE_TURNED = ErrorEntry(322152, "the plane cannot change while G68 holds", remedy="program G69 before it")

# -- stroke check --------------------------------------------------------------------------------------------------

STROKE_INSIDE = ErrorEntry(
    322301,
    "1400 INTERNALLY FORBIDDEN AREA: the axes stand within the box of G22",
    reaction=STOP,
    remedy="switch the check off with G23, and move the axes out of it by hand",
    source="NCT manual line 5995",
)
STROKE_OUTSIDE = ErrorEntry(
    322302,
    "FORBIDDEN AREA {axis}{sign}: the axes stand outside of the box of G22",
    reaction=STOP,
    remedy="move the axes back by hand, or switch the check off with G23",
    source="NCT manual line 5998",
)
STROKE_ENTERED = ErrorEntry(
    322303,
    "3057 FORBIDDEN AREA: this block would come into the box of G22",
    reaction=STOP,
    remedy="lead the path around it",
    source="NCT manual line 6045",
)
STROKE_LEFT = ErrorEntry(
    322304,
    "3057 FORBIDDEN AREA: this block would leave the box of G22",
    reaction=STOP,
    remedy="stay within it",
    source="NCT manual line 6045",
)
LIMIT = ErrorEntry(
    322305,
    "3056 LIMIT: {what} of axis {axis}, {position:.4f}, lies beyond {limit:.4f} ({limit_name})",
    reaction=STOP,
    remedy="correct the target or the work offset; the limits are those of the axis in the machine description",
    source="NCT manual line 6043",
)
