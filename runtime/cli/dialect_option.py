"""The option that says in which dialect a program is written."""

from __future__ import annotations

from typing import Annotated

import typer

DialectOption = Annotated[
    str,
    typer.Option(
        "--dialect",
        help="Dialect of the program: isg or nct; default: as the machine description says.",
        show_default=False,
    ),
]
