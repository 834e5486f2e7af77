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
