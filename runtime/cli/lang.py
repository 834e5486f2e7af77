"""`tandem lang`: the reference of the language, from the registrations that parser and decoder read."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from runtime.cnc.decoder.reference import CONTROL, Row, functions, g_functions, statements, variables, words

SECTIONS = {
    "g": ("G functions", g_functions),
    "words": ("Words of a block", words),
    "statements": ("# statements and cycle calls", statements),
    "control": ("Control statements", lambda: CONTROL),
    "functions": ("Functions of expressions", functions),
    "variables": ("Predefined variables", variables),
}


def command(
    word: Annotated[str, typer.Argument(help="Only what has this in its name or syntax.", show_default=False)] = "",
    as_json: Annotated[bool, typer.Option("--json", help="For editors: a list of objects.")] = False,
    section: Annotated[str, typer.Option(help=f"Only one section: {', '.join(SECTIONS)}.", show_default=False)] = "",
) -> None:
    """Print every function of the language with its syntax."""
    if section and section not in SECTIONS:
        typer.echo(f"section {section!r} does not exist; sections: {', '.join(SECTIONS)}", err=True)
        raise typer.Exit(1)
    if as_json:
        chosen = {key: rows() for key, (_, rows) in SECTIONS.items() if section in ("", key)}
        found_rows = [
            {"section": key, **asdict(row)} for key, rows in chosen.items() for row in rows if _matches(row, word)
        ]
        sys.stdout.write(json.dumps(found_rows, ensure_ascii=False, indent=1) + "\n")
        return
    console = Console(width=None if sys.stdout.isatty() else 140)
    found = False
    for key, (title, rows) in SECTIONS.items():
        if section in ("", key):
            found |= _print(console, title, [row for row in rows() if _matches(row, word)])
    if not found:
        typer.echo(
            f"nothing with {word!r} among {sum(len(rows()) for _, rows in SECTIONS.values())} functions", err=True
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
