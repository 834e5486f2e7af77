"""A row of the reference of a dialect."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Row:
    """One function: its name, how it is written, how long it holds, what it does."""

    name: str
    syntax: str
    holds: str
    meaning: str
