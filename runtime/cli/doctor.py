"""`tandem doctor`: is this host fit, and what to do if not."""

from __future__ import annotations

import json
import os
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from runtime.cli.host_checks import Finding, Host, Verdict, examine
from runtime.config.loader import load_machine

_COLOURS = {Verdict.OK: "green", Verdict.WARN: "yellow", Verdict.FAIL: "red"}


def command(
    config: Annotated[
        Path | None, typer.Option("-c", "--config", help="Machine description; default: the built-in demo machine.")
    ] = None,
    dialect: Annotated[str, typer.Option(help="As for the other commands; without effect here.")] = "isg",
    as_json: Annotated[bool, typer.Option("--json", help="Print the findings as a JSON list.")] = False,
) -> None:
    """Tell whether this host is fit for real time, and what to do if not.

    The exit code is 0 if nothing fails; a warning means that the machine runs, with more jitter.
    """
    findings = examine(Host(environment=os.environ), load_machine(config))
    if as_json:
        print(json.dumps([asdict(finding) for finding in findings], indent=2, ensure_ascii=False))
    else:
        Console().print(_table(findings))
    raise typer.Exit(int(any(finding.verdict is Verdict.FAIL for finding in findings)))


def _table(findings: list[Finding]) -> Table:
    table = Table("", "check", "found", "what to do")
    for finding in findings:
        colour = _COLOURS[finding.verdict]
        table.add_row(f"[{colour}]{finding.verdict}[/]", finding.check, _plain(finding.found), _plain(finding.remedy))
    return table


def _plain(text: str) -> str:
    """Square brackets are text here, not markup."""
    return text.replace("[", r"\[")
