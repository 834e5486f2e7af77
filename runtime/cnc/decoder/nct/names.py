"""What the names in expressions mean: whoever implements some of them gives them here.

    @names
    def arithmetic(x: NctExecution) -> dict[str, Callable[..., object]]:
        return {"add": add, "SIN": sine, ...}

The names that expressions call are listed in `runtime.cnc.language.nct.expressions`. A block with a name that nobody gives is
refused as not supported.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from runtime.cnc.decoder.nct.execution import NctExecution

Given = Callable[["NctExecution"], dict[str, Any]]
GIVEN: list[Given] = []


def names(given: Given) -> Given:
    """Register a function that gives names for an execution."""
    GIVEN.append(given)
    return given


def namespace(x: NctExecution) -> dict[str, Any]:
    """All names of an execution: the globals of its compiled blocks."""
    made: dict[str, Any] = {}
    for given in GIVEN:
        made.update(given(x))
    return made
