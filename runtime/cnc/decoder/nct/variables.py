"""The variables of NCT programs: #1–#33 per macro level, #100–#199 and #500–#599 of the channel (manual lines 6618–6720).

#0              always vacant
#1 … #33        of the macro level in work; a call makes a new level, the return brings the old one back
#100 … #199     common, vacant after the start of the control
#500 … #599     common, kept over it
all others      system variables: see `system_variables`
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from runtime.cnc.decoder.common_variables import RETAINED, VOLATILE, CommonVariables
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.nct.functions import Value
from runtime.diagnostics.catalogue import nct_macros as catalogue

LOCALS = 33
NUMBER_MOST = 99_999

Locals = list[Value]  # index is the number; [0] stays vacant


def no_locals() -> Locals:
    """A level on which nothing was given."""
    return [None] * (LOCALS + 1)


@dataclass(slots=True)
class Variables:
    """All variables as the program in work sees them.

    `locals()` gives those of the macro level in work. `read_system` and `write_system` do what lies outside of these memories;
    both raise CalculationError.
    """

    common: CommonVariables
    locals: Callable[[], Locals]
    read_system: Callable[[int], Value]
    write_system: Callable[[int, Value], None]

    def number_of(self, value: Value) -> int:
        """The number of a variable from a formula, `#[..]`; CalculationError if it is none. It has to be whole."""
        number = 0.0 if value is None else value
        nearest = round(number)
        if not (abs(number - nearest) < 1e-6 and 0 <= nearest <= NUMBER_MOST):
            raise CalculationError(catalogue.VARIABLE_NUMBER, "#", value=number)
        return nearest

    def read(self, number: int) -> Value:
        """A variable by its number."""
        if number <= LOCALS:
            return self.locals()[number]
        if number in VOLATILE or number in RETAINED:
            return self.common.values.get(number)
        return self.read_system(number)

    def write(self, number: int, value: Value) -> None:
        """Give a variable a value, or make it vacant."""
        if 0 < number <= LOCALS:
            self.locals()[number] = value
        elif number in VOLATILE or number in RETAINED:
            self.common.write(number, value)
        elif number == 0:
            raise CalculationError(catalogue.VARIABLE_READ_ONLY, "#0", number=0)
        else:
            self.write_system(number, value)
