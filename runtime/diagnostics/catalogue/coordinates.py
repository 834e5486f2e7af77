"""Errors of coordinate systems in space: #CS, #ACS, #BCS, named systems, #MCS."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity

STOP = Reaction.STOP_AT_BLOCK_END

SYSTEM_AXES = ErrorEntry(
    315000,
    "{statement} needs three linear main axes in the channel; it has {axes}",
    reaction=STOP,
    remedy="coordinate systems lie in the first three axes of the channel",
)
SYSTEM_UNKNOWN = ErrorEntry(
    315001,
    "there is no coordinate system {name} for {statement}; there are: {known}",
    reaction=STOP,
    remedy="define it first (#{group} DEF, or #CS ADD for named ones)",
    source="programming manual line 26932",
)
SYSTEM_NONE = ErrorEntry(
    315002,
    "{statement}: {what}",
    reaction=STOP,
    remedy="define a coordinate system, or activate one, first",
)
DEFINITIONS_FULL = ErrorEntry(
    315003,
    "{statement}: {limit} coordinate systems are defined already",
    reaction=STOP,
    remedy="use an ID again, or end systems that were activated without one",
    source="programming manual line 26934",
)
LINKED_FULL = ErrorEntry(
    315004,
    "{statement}: {limit} coordinate systems are linked already",
    reaction=STOP,
    remedy="end one of them first, or store the link with DEF ACT",
    source="programming manual line 27306",
)
OFF_WITH_ID = ErrorEntry(
    315005,
    "{statement} takes no ID: it ends the coordinate system that was activated last",
    reaction=STOP,
    remedy="write {statement}, or {statement} ALL",
    source="programming manual line 26920",
)
SYSTEM_VALUES = ErrorEntry(
    315006,
    "{statement}: {what}",
    reaction=STOP,
    remedy="three shifts in mm, then three angles in degrees; trailing ones may be left out",
)
SYSTEM_ID = ErrorEntry(
    315007,
    "{value:g} is no ID of a coordinate system",
    reaction=STOP,
    remedy="IDs are whole numbers from 1 on, or names",
)
IN_MACHINE = ErrorEntry(
    315008,
    "{statement} is not possible between #MCS ON and #MCS OFF",
    reaction=STOP,
    remedy="program #MCS OFF first",
    source="programming manual line 27673",
)
NAME_RESERVED = ErrorEntry(
    315009,
    "{name} is the name of a coordinate system of the control",
    reaction=STOP,
    remedy="choose another name than ACS, MCS, IMCS",
    source="programming manual line 27918",
)
NAME_LENGTH = ErrorEntry(
    315010,
    "the name {name} of a coordinate system is longer than {limit} characters",
    reaction=STOP,
    source="programming manual line 27915",
)
NAME_TWICE = ErrorEntry(
    315011,
    "there is a coordinate system {name} already",
    reaction=STOP,
    remedy="change it with #CS SET, or choose another name",
)
SYSTEMS_MIXED = ErrorEntry(
    315012,
    "{statement} is not possible while {other} is active",
    reaction=STOP,
    remedy="use either #CS ON and #CS OFF, or #CS ADD and #CS SELECT",
)
NO_KINEMATICS = ErrorEntry(
    315013,
    "#CS SELECT [{name}] needs a kinematic transformation, and none is active",
    reaction=STOP,
    remedy="#MCS ON goes over to the machine axes",
    source="programming manual line 27997",
)
ROTATED = ErrorEntry(
    315014,
    "{what} is not possible for axis {axis} while a rotated coordinate system is active",
    reaction=STOP,
    remedy="end the coordinate system first, or use #MCS ON",
)
TILTED_ARC = ErrorEntry(
    315015,
    "{word} is not possible at an arc that is tilted on the machine",
    reaction=STOP,
    remedy="leave it out, or program lines",
)
NOTHING_TO_END = ErrorEntry(
    315016,
    "{statement}: there is nothing to end",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
)
MACHINE_TWICE = ErrorEntry(
    315017,
    "#MCS ON is active already",
    reaction=STOP,
    remedy="program #MCS OFF first",
)
BEYOND = ErrorEntry(
    315018,
    "main axis {number} would have to go to {value:.9g}, outside of ±{limit:.0f}",
    reaction=STOP,
    remedy="look at the shifts and angles of the coordinate system",
    source="programming manual line 1974",
)
COUPLED = ErrorEntry(
    315019,
    "{statement}: axis {axis} leads another one (#AX LINK), and cannot be turned into another direction",
    reaction=STOP,
    remedy="switch the coupling off first",
)
ROTATION_LOST = ErrorEntry(
    315020,
    "the contour rotation is not restored behind #MCS OFF: the plane is another one now",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
)
CORNER_SYSTEM = ErrorEntry(
    315022,
    "the coordinate system changes (line {wait_line}) before the motion behind the {what} is known",
    reaction=STOP,
    remedy="program the corner in front of a motion of the same coordinate system",
)
LIMIT_DIRECTION = ErrorEntry(
    315023,
    "#GET WCS POSLIMIT: {what}",
    reaction=STOP,
    remedy="VC1, VC2 and VC3 are a direction in the active coordinate system",
    source="programming manual line 27832",
)
ROTATED_POINT = ErrorEntry(
    315021,
    "in a rotated coordinate system an interim point needs X, Y and Z",
    reaction=STOP,
)
