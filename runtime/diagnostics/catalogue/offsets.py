"""Errors of the offset table: compensation registers and work offsets that are kept."""

from runtime.diagnostics.errors import ErrorEntry, Reaction

TABLE_FAILED = ErrorEntry(
    322001,
    "the offset table cannot be used: {reason}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="check the file and its access rights; without it the offsets of the machine are not known",
)
TABLE_VERSION = ErrorEntry(
    322002,
    "the offset table has the form {version}, this version knows {known}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="use the version that made it, or put the file aside and set the offsets anew",
)

# -- tandem offsets ------------------------------------------------------------------------------------------------

OFFSET_UNKNOWN = ErrorEntry(
    322010, "there is no offset {name}", remedy="COMMON, G54 to G59, or a register: H1 to H{last}, D1 to D{last}"
)
ASSIGNMENT = ErrorEntry(
    322011,
    "{text!r} sets nothing",
    remedy="<axis>=<value> for a work offset, geometry=<value> or wear=<value> for a register",
)
VALUE_UNKNOWN = ErrorEntry(
    322012, "{text!r} is no length: {reason}", remedy="a number in mm, or one with its unit: '2 inch'"
)
AXIS_UNKNOWN = ErrorEntry(322013, "the channel has no axis {axis}", remedy="it has: {axes}")
REGISTER_LIMITS = ErrorEntry(
    322014, "{name} cannot hold that: {value}", remedy="geometry up to 9999.999 mm, wear up to 16.38 mm"
)
