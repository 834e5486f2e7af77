"""The tables of the dialect: every G function, # statement and predefined variable is registered here once.

Parser, checker, reference (`tandem lang`) and coverage read these tables, and nothing else. A handler gets the `Execution` of the
program and what was written; it changes the state or emits blocks, and raises LineError for what the user did wrong.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import StatementSlots
from runtime.cnc.language.isg.compiler import Values as BlockValues
from runtime.cnc.language.isg.syntax import Form, Group, GSyntax, Key, StatementSyntax, Values, VariableSyntax
from runtime.cnc.language.isg.words import Argument, ValueKind
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import ErrorEntry

if TYPE_CHECKING:
    from runtime.cnc.decoder.execution import Execution


# ---------------------------------------------------------------------------------------------------- G functions


@dataclass(frozen=True, slots=True)
class GCall:
    """A G function in a block: `value` of G163=.., `values` of G80[..] with None for empty places."""

    number: int
    column: int
    value: float | None = None
    values: tuple[float | str | None, ...] = ()
    bracketed: bool = False


GHandler = Callable[["Execution", GCall], None]


@dataclass(frozen=True, slots=True)
class GFunction:
    """A registered G function. `last`: it acts behind motion and functions of its block, as its last action."""

    syntax: GSyntax
    handler: GHandler
    last: bool = False


G_FUNCTIONS: dict[int, GFunction] = {}


def g_function(
    number: int,
    group: Group,
    *spec: str,
    modal: bool = True,
    syntax: str = "",
    values: Values = Values.NONE,
    axis_arguments: bool = False,
    alone: bool = False,
    last: bool = False,
) -> Callable[[GHandler], GHandler]:
    """Register the decorated handler for a G number; `spec` are the catalogue entries it belongs to."""

    def register(handler: GHandler) -> GHandler:
        if number in G_FUNCTIONS:
            raise ValueError(f"G{number} is registered twice")
        written = GSyntax(number, group, modal, syntax or f"G{number:02d}", spec, values, axis_arguments, alone)
        G_FUNCTIONS[number] = GFunction(written, handler, last)
        return handler

    return register


# ---------------------------------------------------------------------------------------------------- # statements


class StatementCall:
    """A # statement with the values of its arguments."""

    __slots__ = ("_slots", "_values", "column", "syntax")

    def __init__(self, slots: StatementSlots, values: BlockValues) -> None:
        self.syntax = slots.statement.syntax
        self.column = slots.statement.column
        self._slots = slots
        self._values = values

    def __iter__(self) -> Iterator[tuple[Argument, Any]]:
        """The arguments with their values, None where an argument has none."""
        for argument, slot in zip(self._slots.statement.arguments, self._slots.slots, strict=True):
            yield argument, None if slot < 0 else self._values[slot]

    def indices(self, number: int) -> tuple[float, ...]:
        """The indices of the variable that is argument `number`."""
        return tuple(self._values[slot] for slot in self._slots.indices[number])

    def argument(self, key: str) -> Argument | None:
        """The argument of a key, None if it is not given."""
        return next((argument for argument, _ in self if argument.name == key), None)

    def given(self, key: str) -> bool:
        """Whether a key is given."""
        return self.argument(key) is not None

    def number(self, key: str = "", default: float | None = None) -> float | None:
        """The number of a key (or the only value), `default` if it is not given."""
        for argument, value in self:
            if argument.name == key and isinstance(value, float):
                return value
        return default

    def needed(self, key: str = "") -> float:
        """The number of a key that has to be given."""
        value = self.number(key)
        if value is None:
            what = key or "a value"
            raise LineError(
                catalogue.KEY_MISSING,
                self.column,
                key=what,
                statement="#" + self.syntax.name,
                syntax=self.syntax.syntax[0],
            )
        return value

    def text(self, key: str, default: str | None = None) -> str | None:
        """The string of a key, or its literal word; `default` if it is not given."""
        for argument, value in self:
            if argument.name == key:
                return value if isinstance(value, str) else argument.text
        return default

    def words(self) -> list[str]:
        """The words in front of the bracket."""
        return [argument.text for argument, value in self if not argument.name and value is None and argument.text]

    def values(self) -> list[tuple[Argument, Any]]:
        """The arguments in the bracket of a message, with their values: the text first."""
        return [(argument, value) for argument, value in self if argument.name]

    def axes(self) -> dict[int, float | None]:
        """Axis words: channel index → value."""
        return {argument.index: value for argument, value in self if argument.index >= 0}

    def columns(self, key: str) -> int:
        """Column of a key, else of the statement."""
        argument = self.argument(key)
        return argument.column if argument else self.column

    def error(self, entry: ErrorEntry, key: str = "", /, **values: object) -> LineError:
        """An error at the place of a key."""
        return LineError(entry, self.columns(key) if key else self.column, **values)


StatementHandler = Callable[["Execution", StatementCall], None]


@dataclass(frozen=True, slots=True)
class Statement:
    """A registered # statement."""

    syntax: StatementSyntax
    handler: StatementHandler


STATEMENTS: dict[str, Statement] = {}


def statement(
    name: str,
    *spec: str,
    syntax: tuple[str, ...] | str = (),
    form: Form = Form.ALONE,
    keys: tuple[Key, ...] = (),
    words: tuple[str, ...] = (),
    optional: bool = False,
    flush: bool = False,
    modal: bool = False,
    aliases: tuple[str, ...] = (),
    prefix: str = "#",
    continued: bool = False,
) -> Callable[[StatementHandler], StatementHandler]:
    """Register the decorated handler for a # statement (cycle calls: name "CALL L CYCLE", prefix "").

    `aliases` are old spellings with the same meaning.
    """

    def register(handler: StatementHandler) -> StatementHandler:
        written = (syntax,) if isinstance(syntax, str) else syntax or (prefix + name,)
        for alias in (name, *aliases):
            if alias in STATEMENTS:
                raise ValueError(f"#{alias} is registered twice")
            STATEMENTS[alias] = Statement(
                StatementSyntax(
                    alias, written, spec, form, keys, words, optional, flush, modal,
                    name if alias != name else "", prefix, continued,
                ),
                handler,
            )  # fmt: skip
        return handler

    return register


# ---------------------------------------------------------------------------------------------------- variables

Reader = Callable[..., Any]  # (execution, *indices) → float, str or a set of values
Writer = Callable[..., None]  # (execution, value, *indices)


@dataclass(slots=True)
class Variable:
    """A predefined variable: `path` with [] for an index and <axis>, <axis beside> (outside of the channel) or
    <spindle> for a name at the end."""

    path: str
    syntax: VariableSyntax
    kind: ValueKind
    read: Reader
    write: Writer | None = None
    flush: bool = False


VARIABLES: dict[str, Variable] = {}


def variable(
    path: str,
    spec: str,
    meaning: str,
    *,
    unit: str = "",
    kind: ValueKind = ValueKind.NUMBER,
    flush: bool = False,
    syntax: str = "",
) -> Callable[[Reader], Reader]:
    """Register the decorated reader: `reader(execution, *indices)`; the index of an axis or spindle comes last."""

    def register(read: Reader) -> Reader:
        if path in VARIABLES:
            raise ValueError(f"{path} is registered twice")
        VARIABLES[path] = Variable(
            path, VariableSyntax(syntax or path, spec, "r", meaning, unit), kind, read, None, flush
        )
        return read

    return register


def writes(path: str) -> Callable[[Writer], Writer]:
    """Register the decorated writer of a variable that is registered already: `writer(execution, value, *indices)`."""

    def register(write: Writer) -> Writer:
        known = VARIABLES[path]
        known.write = write
        written = known.syntax
        known.syntax = VariableSyntax(written.syntax, written.spec, "rw", written.meaning, written.unit)
        return write

    return register


def syntaxes() -> tuple[Mapping[int, GSyntax], Mapping[str, StatementSyntax]]:
    """What the parser needs of the tables."""
    return (
        {number: function.syntax for number, function in G_FUNCTIONS.items()},
        {name: entry.syntax for name, entry in STATEMENTS.items()},
    )
