"""Errors of technology functions and spindles in NC programs."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity

PRE_OUTPUT = ErrorEntry(
    300206,
    "{name}: {letter}{number} of type {synch} has no {what} ahead of its place",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="a distance belongs to the types MEP_SVS and MEP_MOS, a time to MET_SVS and MET_MOS",
    source="programming manual line 21372",
)
PRE_OUTPUT_VALUE = ErrorEntry(
    300700,
    "{name}: {value:g} is no {what} ahead of the place of output",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="at least 0, and at most 429496 mm or 4294 s",
    source="programming manual line 21370",
)
FLUSH_BARRED = ErrorEntry(
    300719,
    "a function with FAW_SYNCH is not allowed while tool radius compensation or contouring is selected",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="deselect them before, or configure the function without FAW_SYNCH",
    source="channel parameters, line 1858",
)
_SPECIFIC = "programming manual, line 24444"
BRACKET_OPEN = ErrorEntry(300702, "the bracket is not closed", source=_SPECIFIC)
BRACKET_NAME = ErrorEntry(
    300703, "{name!r} in front of a bracket with commands is neither an axis nor a spindle", remedy="known: {known}"
)
BRACKET_COMMAND = ErrorEntry(
    300704,
    "{text!r} is no command of a bracket",
    remedy="S[M3 REV1000], S[M19 POS45], S[G167 REV500], X[M20 H12]",
    source=_SPECIFIC,
)
AXIS_BRACKET = ErrorEntry(
    300705,
    "{word} in the bracket of {name}: an axis takes M and H functions only",
    source="programming manual, line 6783",
)
BRACKET_UNSUPPORTED = ErrorEntry(300706, "{word} of a spindle is not supported yet", source=_SPECIFIC)
BRACKET_ALONE = ErrorEntry(300707, "{word} stands alone in its bracket", source=_SPECIFIC)
BRACKET_VALUE = ErrorEntry(
    300708,
    "{word} of a spindle: {value:.9g} is outside of {range}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source=_SPECIFIC,
)
BRACKET_VALUE_MISSING = ErrorEntry(300709, "{word} of a spindle needs a value", source=_SPECIFIC)
NOT_MAIN_SPINDLE = ErrorEntry(
    300710,
    "{name} is not the main spindle, which is {main}: outside of brackets only that one can be programmed",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="{name}[REV1000 M3], or #MAIN SPINDLE [{name}] first",
    source="programming manual, line 22232",
)
POSITIONING_SPEED = ErrorEntry(
    300711,
    "M19 of spindle {name} has no speed",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="program a speed above 0 first",
    source="programming manual, line 22640",
)
PLC_SPINDLE = ErrorEntry(
    300712,
    "the PLC moves spindle {name}: it takes a speed and M3, M4, M5, M19 only",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="P-CHAN-00069",
)
GEAR_UNSUITABLE = ErrorEntry(
    300713,
    "M{number} does not cover {speed:.9g} rev/min",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="choose another stage, or see spindel[].range_table",
    source="programming manual, line 22936",
)
GEAR_MISSING = ErrorEntry(
    300714,
    "{speed:.9g} rev/min needs another gear stage than the present one ({present})",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="program M40 to M45 with it, or choose the stage by the speed (spindel[].autom_range)",
    source="programming manual, line 22962",
)
GEAR_NONE = ErrorEntry(
    300715,
    "no gear stage covers {speed:.9g} rev/min",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual, line 22936",
)
GEAR_DATA = ErrorEntry(
    300716,
    "G112: spindle {name} has no data of gear stage {stage:.9g}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="stages count from 1; give the axis gear_stages",
    source="programming manual, line 24332",
)
GEAR_TURNING = ErrorEntry(
    300717,
    "G112: spindle {name} turns",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="stop it in a block before, with M5 or M19",
    source="programming manual, line 24350",
)
SPINDLE_WORD_NEEDED = ErrorEntry(
    300718, "G{number} of a spindle needs its name and a value", remedy="G{number} S1", source="programming manual"
)
HOMING_WITH_M = ErrorEntry(
    300720, "G74 of a spindle and a spindle M function exclude each other", source="programming manual, line 24390"
)
MICRO_JOINT = ErrorEntry(
    300701,
    "{letter}{number} of type {synch} has a distance ahead of its place: the channel has no micro-joints",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="set the distance to 0, choose a type that is put out ahead (MEP_MOS, MEP_SVS, MET_MOS, MET_SVS), or add "
    "FCT_M_PRE_OUTPUT to configuration.path_preparation.function (P-CHAN-00600)",
    source="channel parameters, line 2162",
)
JOINT_BARRED = ErrorEntry(
    300721,
    "{letter}{number} of type {synch} cannot be moved back on the path",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="functions of the channel of type MOS, MOS_TS, MVS_SVS, MVS_SNS or MNS_SNS can; set the distance of the others to 0",
    source="cutting manual, line 1060",
)
JOINT_SHORT = ErrorEntry(
    120693,
    "{letter}{number} is put out {late:.4f} mm behind its place, which is {lead:.4f} mm back: that far nothing is kept",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
    remedy="keep more blocks (P-CHAN-00603), program longer ones, or a shorter distance; P-CHAN-00760 makes it an error",
    source="channel parameters, line 1574",
)
JOINT_FEED = ErrorEntry(
    300722,
    "#CHANNEL SET: {key} is {value:g}, it has to be above 0",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="cutting manual, line 1350",
)
JOINT_FEED_USELESS = ErrorEntry(
    300723,
    "#CHANNEL SET [M_PRE_OUTPUT] in a channel without micro-joints",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="add FCT_M_PRE_OUTPUT to configuration.path_preparation.function (P-CHAN-00600)",
    source="cutting manual, line 1350",
)
