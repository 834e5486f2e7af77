"""Errors of what a program does with single axes: turning without end, own motions, positions, limits, exchange, couplings."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity


def _entry(number: int, text: str, remedy: str, source: str = "") -> ErrorEntry:
    return ErrorEntry(number, text, reaction=Reaction.STOP_AT_BLOCK_END, remedy=remedy, source=source)


MODULO_NEGATIVE = _entry(
    312500,
    "axis {axis}: with G91 the sign behind the name is the direction, and the way {value:.9g} behind it is negative",
    "program the way without a second sign",
    "programming manual line 29282",
)
TWO_SIGNS = _entry(
    312501,
    "axis {axis} does not turn without end, so two signs have no meaning",
    "one sign, or brackets: X[-5]",
    "programming manual line 29158",
)
MODULO_RANGE = _entry(
    312502,
    "axis {axis}: {low:.9g} to {high:.9g} is no modulo range",
    "MAX has to be greater than MIN",
    "programming manual line 31100",
)
LIMIT_WARNING = ErrorEntry(
    312503,
    "{what} of axis {axis}, {position:.4f}, lies beyond its software limit {limit:.4f}; it is driven nevertheless (POS_LIMIT)",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
    source="programming manual line 31012",
)
LIMIT_REACHED = ErrorEntry(
    312504,
    "axis {axis} has come to {position:.4f}, beyond its software limit {limit:.4f}",
    reaction=Reaction.STOP_ON_PATH,
    remedy="move it back by hand, correct the program",
    source="programming manual line 31008",
)
LIMIT_PASSED = ErrorEntry(
    312505,
    "axis {axis} has come to {position:.4f}, beyond its software limit {limit:.4f}, which only warns (POS_LIMIT)",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
    source="programming manual line 31012",
)
INDEPENDENT_BARRED = _entry(
    312510,
    "axis {axis} cannot move by itself here: {what}",
    "end it before, or move the axis with the path",
    "programming manual line 29541",
)
INDEPENDENT_UNSUPPORTED = _entry(312511, "{what} is not available in this version", "leave the keyword out")
INDEPENDENT_VALUE = _entry(
    312512,
    "axis {axis}: {key} = {value:.9g} is not allowed, it is {allowed}",
    "correct the value",
    "programming manual line 29578",
)
INDEPENDENT_FEED = _entry(
    312513,
    "axis {axis}: an own motion with G01 needs FEED, TIME or FEED_MAX_WEIGHT",
    "name one of them, or G00",
)
INDEPENDENT_SYNCH = _entry(
    312514,
    "{function} cannot stand {where}",
    "only MOS, MVS_SVS, MVS_SNS and MNS_SNS can; put it beside the bracket",
    "programming manual line 29626",
)
INDEPENDENT_FUNCTION = _entry(
    312515,
    "a function of the block goes to the interface of axis {axis}, which moves by itself in the same block",
    "put it into the bracket of the axis, or into another block",
    "programming manual line 29685",
)
