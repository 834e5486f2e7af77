"""docs/faults.md is true as far as a test can see: its alarms exist and react as it says, its tests are there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from runtime.diagnostics.catalogue import CATALOGUE
from runtime.diagnostics.errors import Reaction

ROWS = [
    [cell.strip() for cell in line.strip("|").split("|")]
    for line in Path("docs/faults.md").read_text(encoding="utf-8").splitlines()
    if line.startswith("| ") and not line.startswith("| fault ")
]


@pytest.mark.parametrize("row", ROWS, ids=[row[0][:60] for row in ROWS])
def test_a_row_is_true(row: list[str]) -> None:
    fault, axes, alarms, go_on, test = row
    assert fault
    assert go_on
    numbers = [int(number) for number in re.findall(r"\d{6}", alarms)]
    assert numbers or alarms == "–"
    reactions = {CATALOGUE[number].reaction for number in numbers}
    if "all by their own ramps" in axes:
        assert Reaction.QUICK_STOP in reactions
    elif "stop on the path" in axes:
        assert Reaction.STOP_ON_PATH in reactions
    elif axes.startswith("nothing"):
        assert reactions <= {Reaction.NONE}
    file, _, name = test.strip("`").partition("::")
    assert f"def {name}(" in Path(file).read_text(encoding="utf-8")
