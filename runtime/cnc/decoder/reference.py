"""The reference of the language as rows, made from the registrations."""

from __future__ import annotations

from inspect import getdoc

from runtime.cnc.decoder.isg.registry import G_FUNCTIONS, STATEMENTS, VARIABLES
from runtime.cnc.decoder.reference_row import Row as Row
from runtime.cnc.language.isg.functions import FUNCTIONS, MANY
from runtime.cnc.language.isg.syntax import Group
from runtime.cnc.language.isg.words import Control, ValueKind, WordKind

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
WORDS: dict[WordKind, tuple[Row, ...]] = {
    WordKind.AXIS: (
        Row("<axis>", "X.. | X[<expression>] | X1=.. | @X..", "block", "coordinate of an axis (mm, inch, deg)"),
    ),
    WordKind.INTERPOLATION: (
        Row("I J K", "I.. J.. | @I..", "block", "centre of a circle, pitch of a thread (mm, inch)"),
    ),
    WordKind.RADIUS: (Row("R", "R.. | R1=..", "block", "radius of a circle; below 0 the longer arc (mm, inch)"),),
    WordKind.FEED: (Row("F", "F..", "modal", "feed, in what G93, G94, G95 or G194 say"),),
    WordKind.END_FEED: (Row("E", "E..", "block", "feed at the end of a block"),),
    WordKind.SPEED: (Row("S", "S.. | S<spindle>=..", "modal", "speed of a spindle (rev/min)"),),
    WordKind.SPINDLE_POSITION: (
        Row("S.POS", "S.POS.. | S<spindle>.POS=..", "modal", "position at which M19 stops a spindle (deg)"),
    ),
    WordKind.SPINDLE_OFFSET: (
        Row("S.OFFSET", "S.OFFSET.. | S<spindle>.OFFSET=..", "modal", "angle at which a thread of G33 begins (deg)"),
    ),
    WordKind.BRACKET: (
        Row("S[ ]", "S<spindle>[<words>] | <axis>[<words>]", "block", "M, H, G and keys of a spindle or an axis"),
    ),
    WordKind.KEY: (Row("REV", "S<spindle>[REV.. M3]", "modal", "in such brackets: REV, POS, OVERRIDE, AUTO, MAIN …"),),
    WordKind.TOOL: (Row("T", "T..", "modal", "tool position"),),
    WordKind.TOOL_DATA: (Row("D", "D..", "modal", "tool data: length, radius, axis offsets; D0: of no tool"),),
    WordKind.M: (Row("M", "M.. | M..=..", "block", "technology function for the PLC, with a value if wanted"),),
    WordKind.H: (Row("H", "H.. | H..=..", "block", "technology function for the PLC, with a value if wanted"),),
    WordKind.G: (
        Row("G", "G.. | G..=.. | G..[.., ..]", "", "the G functions above; a cycle call if one is configured"),
    ),
    WordKind.DWELL: (Row("G04", "G04 .. | G04 X.. | G04 S..", "block", "dwell time (s), or revolutions of a spindle"),),
    WordKind.ASSIGNMENT: (
        Row("P", "P..=.. | P[<expression>]=..", "", "parameter; or a variable V.<name>, += and -= too"),
    ),
    WordKind.DECLARATION: (
        Row(
            "V.", "V.P.<name> [: <type>] [= ..]", "", "between #VAR and #ENDVAR; V.P, V.S, V.L, V.CYC; arrays: name[..]"
        ),
    ),
    WordKind.ADDITION: (
        Row("#ANG", "#ANG=..", "block", "angle of a contour line (deg)"),
        Row("#CANG", "#CANG=..", "block", "opening angle of a circle around its centre (deg)"),
        Row("#CHR", "#CHR=..", "block", "chamfer to the next motion, by its width (mm, inch)"),
        Row("#CHF", "#CHF=..", "block", "chamfer to the next motion, by its length (mm, inch)"),
        Row("#RND", "#RND=..", "block", "rounding to the next motion, by its radius (mm, inch)"),
        Row("#FRC", "#FRC=..", "block", "feed in the chamfer or rounding"),
    ),
    WordKind.CALL_LOCAL: (Row("LL", "LL <name>", "block", "call of a subprogram of the same file"),),
    WordKind.CALL_GLOBAL: (Row("L", "L <file>", "block", "call of a subprogram file"),),
    WordKind.RETURN: (Row("M17 M29", "M17 | M17[[MAIN|JUMPS=..] [[<label>]|N..]]", "block", "end of a subprogram"),),
    WordKind.GOTO: (
        Row("N", "N<number>[:] | [<label>]", "block", "block number, label; /1 to /10 before them: skip level"),
    ),
}
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


def words() -> list[Row]:
    """The words of a block."""
    return [row for rows in WORDS.values() for row in rows]


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
