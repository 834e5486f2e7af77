"""Arguments of macro calls: which address fills which local variable (manual lines 6059–6160, 6266–6296).

List 1 names a variable by a letter of its own, list 2 counts I, J and K: I1 J1 K1 … I10 J10 K10 are #4 … #33. Both may stand in
one block, as long as no variable gets two values.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from runtime.cnc.decoder.nct.variables import Locals, no_locals
from runtime.cnc.language.nct.functions import Value
from runtime.diagnostics.catalogue import nct_macros as catalogue
from runtime.diagnostics.errors import ErrorEntry

LIST_1 = {
    "A": 1, "B": 2, "C": 3, "I": 4, "J": 5, "K": 6, "D": 7, "E": 8, "F": 9, "H": 11, "M": 13, "Q": 17, "R": 18, "S": 19,
    "T": 20, "U": 21, "V": 22, "W": 23, "X": 24, "Y": 25, "Z": 26,
}  # fmt: skip
EVERY_BLOCK = {"G": 10, "L": 12, "N": 14, "P": 16}  # more, where blocks are arguments (G66.1) or a user code has them
COUNTED = "IJK"
COUNTED_MOST = 10


@dataclass(frozen=True, slots=True)
class Argument:
    """A word of a call: its address, its value, its column."""

    address: str
    value: Value
    column: int


class ArgumentError(Exception):
    """An argument cannot be given; whoever executes the block adds the place."""

    def __init__(self, entry: ErrorEntry, column: int, **values: object) -> None:
        super().__init__(entry.id)
        self.entry, self.column, self.values = entry, column, values


def assigned(arguments: Iterable[Argument], more: Iterable[str] = ()) -> Locals:
    """The local variables of the level that is called; a vacant value leaves its variable vacant.

    `more`: addresses out of EVERY_BLOCK that count as arguments too. Raises ArgumentError.
    """
    table = LIST_1 | {address: EVERY_BLOCK[address] for address in more}
    variables = no_locals()
    taken: set[int] = set()
    counts = dict.fromkeys(COUNTED, 0)
    for argument in arguments:
        address = argument.address
        if address not in table:
            raise ArgumentError(catalogue.ARGUMENT_ADDRESS, argument.column, address=address)
        number = table[address]
        if address in counts:
            number += 3 * counts[address]
            counts[address] += 1
            if counts[address] > COUNTED_MOST:
                raise ArgumentError(catalogue.TOO_MANY_ARGUMENTS, argument.column, address=address)
        if number in taken:
            raise ArgumentError(catalogue.ARGUMENT_TWICE, argument.column, address=address, number=number)
        taken.add(number)
        variables[number] = argument.value
    return variables
