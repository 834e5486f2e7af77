"""The common variables of the NCT dialect, which outlive programs (NCT programmer's manual lines 6700–6720)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from runtime.cnc.language.errors import CalculationError
from runtime.diagnostics.catalogue import nct_macros as catalogue

VOLATILE = range(100, 200)
RETAINED = range(500, 600)


@dataclass(slots=True)
class CommonVariables:
    """#100–#199 and #500–#599 of a channel: they outlive programs. Only those that are not vacant are there.

    `protected`: first and last number that programs may not write (WRPROT1, WRPROT2), within #500–#599; (0, 0) protects none.
    """

    values: dict[int, float] = field(default_factory=dict)
    protected: tuple[int, int] = (0, 0)
    changed: dict[int, float | None] = field(default_factory=dict)  # retained ones that are not yet kept
    restored: bool = False  # what was kept has been taken over

    def read(self, number: int) -> float | None:
        return self.values.get(number)

    def write(self, number: int, value: float | None) -> None:
        """CalculationError for a protected one."""
        first, last = self.protected
        if number in RETAINED:
            if first <= number <= last:
                raise CalculationError(
                    catalogue.VARIABLE_PROTECTED, f"#{number}", number=number, first=first, last=last
                )
            self.changed[number] = value
        if value is None:
            self.values.pop(number, None)
        else:
            self.values[number] = value

    def retained(self) -> dict[int, float]:
        """What is kept over a restart, by number."""
        return {number: value for number, value in self.values.items() if number in RETAINED}

    def restore(self, kept: Mapping[int, float]) -> None:
        """What was kept; numbers that are none of these variables are left out."""
        self.restored = True
        self.values.update({number: float(value) for number, value in kept.items() if number in RETAINED})
