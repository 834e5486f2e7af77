"""What a block of the NCT dialect consists of after parsing: words with their values, assignments, or a control statement."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


@dataclass(frozen=True, slots=True)
class Expression:
    """An expression as Python source over the names of the namespace that executes it.

    `constant` is its value if it is a plain number, else None. `names` are the operators and functions that it calls, upper
    case as in the text for functions and comparisons: what executes it has to have them.
    """

    source: str
    constant: float | None = None
    names: frozenset[str] = frozenset()
    depth: int = 0  # nested brackets

    @classmethod
    def number(cls, value: float) -> Expression:
        return cls(repr(value), value)


@dataclass(frozen=True, slots=True)
class Word:
    """An address with its value. `incremental`: the operator I stands between them. `column` counts from 1.

    `signed`, `decimal`: how the value is written (a variable may have both, whatever is written).
    """

    address: str
    column: int
    value: Expression
    incremental: bool = False
    signed: bool = False
    decimal: bool = False


@dataclass(frozen=True, slots=True)
class Assignment:
    """`#i = formula`; `number` gives i."""

    number: Expression
    value: Expression
    column: int


class Control(Enum):
    """Control statements."""

    GOTO = "GOTO"
    IF = "IF"
    WHILE = "WHILE"
    DO = "DO"
    END = "END"


@dataclass(frozen=True, slots=True)
class ControlStatement:
    """A control statement: `condition` of IF and WHILE, `target` the number behind GOTO, DO or END.

    IF without `target` executes the words or assignments of its block if the condition holds.
    """

    control: Control
    column: int
    condition: Expression | None = None
    target: Expression | None = None
    target_column: int = 0


@dataclass(frozen=True, slots=True)
class ParsedBlock:
    """One block. `skip` is the number of the skip switch, 0 without; `number` that of the N word, -1 without; `comment` the
    text of its first comment (message of #3000, #3006), "" without."""

    words: tuple[Word, ...] = ()
    assignments: tuple[Assignment, ...] = ()
    control: ControlStatement | None = None
    number: int = -1
    skip: int = 0
    comment: str = ""
