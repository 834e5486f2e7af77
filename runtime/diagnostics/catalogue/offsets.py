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
