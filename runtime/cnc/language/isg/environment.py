"""What names in expressions mean: the parser asks, the decoder answers.

Every access becomes a call in the compiled block: `name(index, ...)` reads, `name(value, index, ...)` writes. The callables
stand in `namespace`, which is the global scope of the compiled blocks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from runtime.cnc.language.isg.words import ValueKind


@dataclass(frozen=True, slots=True)
class Access:
    """How a variable is read: the name of the callable, what it gives, and whether the interpolator is asked."""

    name: str
    kind: ValueKind = ValueKind.NUMBER
    flush: bool = False


class Environment(Protocol):
    """`path` is the variable as written, with [] where an index stands: "V.G.NP[].V.X", "P10[][]", "@P3".

    All calls may add to `namespace`; read and write raise LineError at `column` for a variable that does not exist or may not
    be written.
    """

    namespace: dict[str, object]

    def read(self, path: str, column: int) -> Access:
        """Access for reading."""

    def write(self, path: str, column: int) -> Access:
        """Access for writing; its callable takes the value first."""

    def exists(self, path: str) -> str:
        """Name of a callable that takes the indices and gives 1.0 or 0.0; never fails."""

    def size(self, path: str) -> str:
        """Name of a callable that takes a dimension from 1 on and gives the size, -1.0 if there is none."""

    def macro(self, name: str) -> str | None:
        """The content of a macro, None if it is not defined."""

    @property
    def macro_version(self) -> int:
        """Counts up whenever a macro is defined or removed."""
