"""Errors of the block search: entering a program that was not begun here."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity

SEARCH_NOT_FOUND = ErrorEntry(
    306100,
    "the program has come to its end without {target}",
    Severity.ERROR,
    Reaction.REFUSE,
    "Nothing has moved. Check block number, line and count of passes; skipped blocks and branches that were not taken "
    "are not found.",
)
SEARCH_STOPS_HERE = ErrorEntry(
    306101,
    "no block search goes over {what}: where the axes are behind it is not known without moving them",
    Severity.ERROR,
    Reaction.REFUSE,
    "Nothing has moved. Enter the program before this block, or split the program.",
)
SEARCH_LOCKED = ErrorEntry(
    306102,
    "{target} lies in an area that is locked for block search (#BLOCKSEARCH LOCKED)",
    Severity.ERROR,
    Reaction.REFUSE,
    "Nothing has moved. Enter the program before or behind the area.",
)
SEARCH_WITH_SPINDLE = ErrorEntry(
    313105,
    "{target} lies in a thread or in tapping, where nothing can be entered",
    Severity.ERROR,
    Reaction.REFUSE,
    "Nothing has moved. Enter the program in front of it or behind it.",
)
SEARCH_CHANGED = ErrorEntry(
    306103,
    "where the program was interrupted it was on line {line}, now its path is on line {found} there",
    Severity.ERROR,
    Reaction.REFUSE,
    "Nothing has moved. The program, its subprograms, tool data or offsets are not as they were: enter it by line or "
    "block number.",
)
SEARCH_KIND = ErrorEntry(
    306104,
    "there is no block search of type {kind}",
    severity=Severity.WARNING,
    remedy="1 file offset, 3 block counter, 4 block number, 5 line, 6 interruption point",
)
SEARCH_NO_POINT = ErrorEntry(
    306105,
    "no interruption point of {program!r} is known",
    severity=Severity.WARNING,
    remedy="only a program of mode AUTOMATIC that was started and has not come to its end has one",
)
SEARCH_NO_TEXT = ErrorEntry(
    306106,
    "a block search needs a program file: NC blocks of an order start at their beginning",
    severity=Severity.WARNING,
    remedy="start a program in mode AUTOMATIC",
)
