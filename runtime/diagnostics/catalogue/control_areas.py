"""Errors of work and protection spaces (#CONTROL AREA)."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity

STOP = Reaction.STOP_AT_BLOCK_END

SPACE_LEFT = ErrorEntry(
    315101,
    "the tool would leave the work space {number}",
    reaction=STOP,
    remedy="correct the program, or end the monitoring with #CONTROL AREA OFF",
    source="programming manual line 16429",
)
SPACE_ENTERED = ErrorEntry(
    315102,
    "the tool would enter the protection space {number}",
    reaction=STOP,
    remedy="correct the program, or end the monitoring with #CONTROL AREA OFF",
    source="programming manual line 16429",
)
SPACE_BEGIN = ErrorEntry(
    315103,
    "{kind} space {number} cannot be watched: the tool is {where} it",
    reaction=STOP,
    remedy="move the tool to a permitted place first",
    source="programming manual line 16574",
)
SPACE_BESIDE = ErrorEntry(
    315104,
    "{what} is not watched, so it is not possible while the space {number} is active",
    reaction=STOP,
    remedy="program #CONTROL AREA OFF first",
)
SPACE_UNKNOWN = ErrorEntry(
    315105,
    "there is no control area {number}",
    reaction=STOP,
    remedy="define it with #CONTROL AREA BEGIN and END",
)
SPACE_ID = ErrorEntry(
    315106,
    "{value:g} is no ID of a control area",
    reaction=STOP,
    remedy="IDs are whole numbers from 0 on",
)
SPACES_FULL = ErrorEntry(
    315107,
    "{limit} control areas are defined already",
    reaction=STOP,
    remedy="delete one with #CONTROL AREA CLEAR",
    source="programming manual line 16464",
)
SPACE_ACTIVE = ErrorEntry(
    315108,
    "the control area {number} is active and cannot be {what}",
    reaction=STOP,
    remedy="program #CONTROL AREA OFF first",
    source="programming manual line 16511",
)
SPACE_KEYS = ErrorEntry(
    315109,
    "#CONTROL AREA BEGIN: {what}",
    reaction=STOP,
    remedy="#CONTROL AREA BEGIN [ID=1 WORK POLY MIN_EXCUR=-50 MAX_EXCUR=50], with PROT and CIRC for the others",
)
SPACE_TWICE = ErrorEntry(
    315110,
    "the control area of line {line} is not closed",
    reaction=STOP,
    remedy="program #CONTROL AREA END first",
    source="programming manual line 16508",
)
SPACE_NOT_BEGUN = ErrorEntry(
    315111,
    "no control area is being defined",
    severity=Severity.ERROR,
    reaction=STOP,
    remedy="program #CONTROL AREA BEGIN first",
)
SPACE_BLOCK = ErrorEntry(
    315112,
    "{what} in the contour of a control area",
    reaction=STOP,
    remedy="between BEGIN and END there are lines (POLY), or a line and a full circle (CIRC), in absolute dimensions",
    source="programming manual line 16447",
)
SPACE_OPEN = ErrorEntry(
    315113,
    "the contour of the control area {number} is no closed one: {what}",
    reaction=STOP,
    remedy="end where it began",
    source="programming manual line 16449",
)
