"""Every error of variables, macros and cycles has a test."""

from __future__ import annotations

import re
from pathlib import Path

from runtime.diagnostics.catalogue import nct_macros
from runtime.diagnostics.errors import ErrorEntry


def test_every_entry_is_met_in_a_test() -> None:
    tests = "".join(path.read_text() for path in Path(__file__).parents[2].rglob("test_*.py"))
    names = [name for name, value in vars(nct_macros).items() if isinstance(value, ErrorEntry)]
    assert [name for name in names if not re.search(rf"\bcatalogue\.{name}\b", tests)] == []
