"""The reference of the language as rows, made from the registrations."""

from __future__ import annotations

from dataclasses import dataclass
from inspect import getdoc

from runtime.cnc.decoder.isg.registry import G_FUNCTIONS, STATEMENTS, VARIABLES
from runtime.cnc.language.isg.functions import FUNCTIONS, MANY
from runtime.cnc.language.isg.syntax import Group
from runtime.cnc.language.isg.words import Control, ValueKind


@dataclass(frozen=True, slots=True)
class Row:
    """One function: its name, how it is written, how long it holds, what it does."""

    name: str
    syntax: str
    holds: str
    meaning: str


_CONTROL_SYNTAX = {
    Control.IF: "$IF <condition> [$GOTO <label>]",
    Control.ELSEIF: "$ELSEIF <condition>",
    Control.SWITCH: "$SWITCH <expression>",
    Control.CASE: "$CASE <expression>",
    Control.FOR: "$FOR <variable> = <start>, <end>, <step>",
    Control.WHILE: "$WHILE <condition>",
    Control.ENDDO: "$ENDDO <condition>",
    Control.UNTIL: "$UNTIL <condition>",
}
CONTROL = [
    *(Row(control.value, _CONTROL_SYNTAX.get(control, control.value), "block", "") for control in Control),
    Row(
        "$GOTO",
        "$GOTO N<expression> | $GOTO [<label>] | $GOTO V.E.<string>",
        "block",
        "labels: N<number>: and [<label>]",
    ),
]
_KINDS = {ValueKind.NUMBER: "number", ValueKind.STRING: "string", ValueKind.ANY: "value"}


def g_functions() -> list[Row]:
    """All G functions by their numbers."""
    rows = []
    for number, function in sorted(G_FUNCTIONS.items()):
        written = function.syntax
        group = "" if written.group in (Group.NONE, Group.ARGUMENTS) else written.group.value
        meaning = "; ".join(part for part in (group, _first_line(function.handler)) if part)
        rows.append(Row(f"G{number:02d}", written.syntax, "modal" if written.modal else "block", meaning))
    return rows


def statements() -> list[Row]:
    """All # statements by their names; old spellings name the one they stand for."""
    rows = []
    for name, entry in sorted(STATEMENTS.items()):
        written = entry.syntax
        meaning = f"the same as #{written.alias_of}" if written.alias_of else _first_line(entry.handler)
        shown = written.prefix + name.removeprefix("CALL ")
        rows.append(Row(shown, " | ".join(written.syntax), "modal" if written.modal else "block", meaning))
    return rows


def functions() -> list[Row]:
    """The functions of expressions."""
    rows = []
    for name, function in sorted(FUNCTIONS.items()):
        kinds = [_KINDS[kind] for kind in function.takes]
        shown = [kinds[min(i, len(kinds) - 1)] for i in range(min(function.most, 4))]
        more = ", …" if function.most == MANY else ""
        rows.append(
            Row(
                name,
                f"{name}[{', '.join(shown)}{more}]",
                "",
                f"{_KINDS[function.gives]}; {_first_line(function.call)}".rstrip("; "),
            )
        )
    return rows


def variables() -> list[Row]:
    """The predefined variables."""
    return [
        Row(
            path,
            entry.syntax.syntax,
            "read, write" if entry.write is not None else "read",
            f"{entry.syntax.meaning} {f'({entry.syntax.unit})' if entry.syntax.unit else ''}".strip(),
        )
        for path, entry in sorted(VARIABLES.items())
    ]


def _first_line(function: object) -> str:
    text = getdoc(function) or ""
    return text.split("\n")[0].rstrip(".")
