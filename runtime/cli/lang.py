"""`tandem lang`: the reference of the language, from the registrations that parser and decoder read."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import asdict
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from runtime.cnc.decoder import expect_dialect
from runtime.cnc.decoder.nct import reference as nct
from runtime.cnc.decoder.reference import CONTROL, Row, functions, g_functions, statements, variables, words

Sections = dict[str, tuple[str, Callable[[], list[Row]]]]

SECTIONS: Sections = {
    "g": ("G functions", g_functions),
    "words": ("Words of a block", words),
    "statements": ("# statements and cycle calls", statements),
    "control": ("Control statements", lambda: CONTROL),
    "functions": ("Functions of expressions", functions),
    "variables": ("Predefined variables", variables),
}
NCT_SECTIONS: Sections = {
    "g": ("G codes", nct.g_codes),
    "m": ("M codes of the control itself", nct.m_codes),
    "words": ("Addresses", nct.words),
    "control": ("Control statements", lambda: nct.CONTROL),
    "variables": ("System variables", nct.variables),
}


def command(
    word: Annotated[str, typer.Argument(help="Only what has this in its name or syntax.", show_default=False)] = "",
    as_json: Annotated[bool, typer.Option("--json", help="For editors: a list of objects.")] = False,
    section: Annotated[str, typer.Option(help=f"Only one section: {', '.join(SECTIONS)}.", show_default=False)] = "",
    dialect: Annotated[str, typer.Option(help="Of which dialect: isg or nct.")] = "isg",
) -> None:
    """Print every function of the language with its syntax."""
    expect_dialect(dialect)
    sections = NCT_SECTIONS if dialect == "nct" else SECTIONS
    if section and section not in sections:
        typer.echo(f"section {section!r} does not exist; sections: {', '.join(sections)}", err=True)
        raise typer.Exit(1)
    if as_json:
        chosen = {key: rows() for key, (_, rows) in sections.items() if section in ("", key)}
        found_rows = [
            {"section": key, **asdict(row)} for key, rows in chosen.items() for row in rows if _matches(row, word)
        ]
        sys.stdout.write(json.dumps(found_rows, ensure_ascii=False, indent=1) + "\n")
        return
    console = Console(width=None if sys.stdout.isatty() else 140)
    found = False
    for key, (title, rows) in sections.items():
        if section in ("", key):
            found |= _print(console, title, [row for row in rows() if _matches(row, word)])
    if not found:
        typer.echo(
            f"nothing with {word!r} among {sum(len(rows()) for _, rows in sections.values())} functions", err=True
        )
        raise typer.Exit(1)


def _matches(row: Row, word: str) -> bool:
    return word.upper() in f"{row.name} {row.syntax} {row.meaning}".upper()


def _print(console: Console, title: str, rows: list[Row]) -> bool:
    if not rows:
        return False
    table = Table(title=title, title_justify="left", show_edge=False)
    table.add_column("name", no_wrap=True)
    for column in ("syntax", "holds", "meaning"):
        table.add_column(column)
    for row in rows:
        table.add_row(row.name, row.syntax.replace("[", "\\["), row.holds, row.meaning.replace("[", "\\["))
    console.print(table)
    return True
