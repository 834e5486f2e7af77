"""Errors of technology functions and spindles in NC programs."""

from runtime.diagnostics.errors import ErrorEntry, Reaction

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
MICRO_JOINT = ErrorEntry(
    300701,
    "{letter}{number} of type {synch} has a distance ahead of its place: micro-joints are not supported",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="set the distance to 0, or choose a type that is put out ahead: MEP_MOS, MEP_SVS, MET_MOS, MET_SVS",
    source="channel parameters, line 2162",
)
