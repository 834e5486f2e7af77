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
    "axis {axis} has come to {position:.4f}, beyond its software limit {limit:.4f}, which only warns",
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
COUPLING_GROUP = _entry(
    312520,
    "a program cannot define coupling group {value}",
    "1 to {last}; group 0 is that of the channel parameters (synchro_data)",
    "programming manual line 12955",
)
COUPLING_PAIRS = _entry(
    312521, "coupling group {group}: {what}", "correct the pairs of the group", "programming manual line 12960"
)
COUPLING_CHANGED = _entry(
    312522,
    "coupling group {group} is active, so it cannot be changed",
    "switch it off before (#AX LINK OFF)",
    "programming manual line 12958",
)
COUPLING_UNDEFINED = _entry(
    312523,
    "coupling group {group} is not defined",
    "define it with #AX LINK, or in synchro_data",
    "programming manual line 13215",
)
COUPLING_NUMBER = _entry(312524, "{text!r} is no logical axis number", "with NBR pairs are written as numbers: 4=2")
COUPLED_SLAVE = _entry(
    312525,
    "axis {axis} follows {master}, so it cannot be programmed",
    "switch the coupling off before (#AX LINK OFF)",
    "programming manual line 13222",
)
COUPLING_ACTIVE = _entry(
    312526,
    "{what} cannot be while axes are coupled (group {group})",
    "switch the coupling off before (#AX LINK OFF)",
    "programming manual line 13220",
)
COUPLING_SMOOTHED = _entry(
    312527, "{statement} cannot be while contouring, splines or HSC are selected", "deselect them before"
)
