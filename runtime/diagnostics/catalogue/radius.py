"""Errors of tool radius compensation."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity

STOP = Reaction.STOP_AT_BLOCK_END

CONTOUR_DAMAGED = ErrorEntry(
    309001,
    "the tool of radius {radius:g} mm does not fit: its path in this block would run backwards",
    reaction=STOP,
    remedy="use a smaller tool, widen the contour",
    source="programming manual line 20020",
)
ARC_TOO_SMALL = ErrorEntry(
    309002,
    "the tool of radius {radius:g} mm does not fit into the arc of radius {arc:g} mm",
    reaction=STOP,
    remedy="use a smaller tool or a larger arc",
    source="programming manual line 20020",
)
OFFSETS_APART = ErrorEntry(
    309003,
    "the tool of radius {radius:g} mm does not fit: its paths along this block and the next one do not meet",
    reaction=STOP,
    remedy="use a smaller tool, widen the contour",
    source="programming manual line 20020",
)
CHANGE_OVER_ARC = ErrorEntry(
    309005,
    "the radius cannot change from {before:g} to {after:g} mm over this arc",
    reaction=STOP,
    remedy="change the radius over a line or a longer arc",
    source="programming manual line 19895",
)
SIDE_CHANGE_ARC = ErrorEntry(
    309006,
    "compensation cannot change its side over an arc",
    reaction=STOP,
    remedy="program a line for the change between G41 and G42; arcs may stand before and behind it",
    source="programming manual line 19832",
)
APPROACH_SHORT = ErrorEntry(
    309007,
    "the {what} is too short: the tool of radius {radius:g} mm needs at least {needed:.4g} mm of it",
    reaction=STOP,
    remedy="begin or end farther away from the contour",
    source="programming manual line 19641",
)
APPROACH_IMPOSSIBLE = ErrorEntry(
    309008,
    "the {what} cannot be driven tangentially from where it stands",
    reaction=STOP,
    remedy="choose another point for it, or another strategy than G05",
    source="programming manual line 19941",
)
PLANE_CHANGED = ErrorEntry(
    309009,
    "the plane cannot be changed while radius compensation is active",
    remedy="program G40 and its exit block before G17, G18 or G19",
)
OTHER_PLANE = ErrorEntry(
    309010,
    "this arc does not lie in the plane of the radius compensation",
    reaction=STOP,
    remedy="program G40 and its exit block before it",
)
CANNOT_BE_OFFSET = ErrorEntry(
    309011,
    "{what} cannot be compensated",
    reaction=STOP,
    remedy="program G40 and its exit block before it",
)
TOO_MANY_BETWEEN = ErrorEntry(
    309012,
    "more than {limit} blocks without motion in the plane stand between two compensated ones",
    reaction=STOP,
    remedy="program G40 and its exit block before them",
)
TANGENTIAL_ALONE = ErrorEntry(
    309015,
    "G05 without G40, G41 or G42 in its block",
    remedy="write G05 into the block of G40, G41 or G42",
    source="programming manual line 19949",
)
NEEDS_CONTOUR = ErrorEntry(
    309016,
    "{command} needs active radius compensation",
    remedy="program it behind G41 or G42",
    source="programming manual line 20739",
)
INSIDE_CORNER_LATE = ErrorEntry(
    309013,
    "G238 is not allowed between G41 or G42 and G40",
    remedy="program G238 in front of G41 or G42, or in their block",
    source="programming manual line 18707",
)
INSIDE_CORNER = ErrorEntry(
    309014,
    "a contour that is entered with G238: {why}",
    reaction=STOP,
    remedy="change the contour or the point in front of it, or choose another strategy than G238",
    source="programming manual line 19403",
)
OPTION_UNSUPPORTED = ErrorEntry(309017, "#TRC {option} is not supported yet")
OPTION_VALUE = ErrorEntry(309018, "#TRC {option}={value:g} is not allowed", remedy="{option} takes {allowed}")
NOT_PRESENT = ErrorEntry(
    309019,
    "the channel has no radius compensation (P-CHAN-00092)",
    remedy="set wrk_im_kanal_vorhanden 1 in the channel parameters",
)
SPLIT_WRITTEN = ErrorEntry(
    309020,
    "#TRC SPLIT: {why}",
    remedy="written as: SPLIT AX=X or SPLIT_PATH, PRE, POST or COMBINED, DIST_SEG1=.. FEED_SEG1=.. DIST_SEG2=.. FEED_SEG2=..",
    source="programming manual line 20622",
)
FORBIDDEN = ErrorEntry(
    20651,
    "{command} is not allowed between G41 or G42 and G40",
    remedy="program G40 and its exit block before it",
    source="programming manual line 20887",
)
EXIT_MISSING = ErrorEntry(
    90050,
    "{command} directly behind G40: the exit block that takes the tool off the contour is missing",
    remedy="program a motion in the plane behind G40",
    source="programming manual line 20896",
)
STRETCH_RANGE = ErrorEntry(
    22007,
    "STRETCH_FACTOR={value:g} lies outside 1 to 9, it is set to 1",
    Severity.WARNING,
    Reaction.NONE,
    remedy="program a factor from 1 to 9",
    source="programming manual line 20190",
)
ONLINE_WITHOUT_INVERSE = ErrorEntry(
    22125,
    "#TRC ONLINE={value:g} without INVERSE=1",
    remedy="program INVERSE=1 with it, or ONLINE=0",
    source="programming manual line 20747",
)
