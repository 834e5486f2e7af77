"""Problems as a terminal shows them."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.cli.explained import explained
from runtime.diagnostics.errors import WINDOW, ErrorEntry, Place, Problem

ENTRY = ErrorEntry(399999, "{what} is wrong", remedy="look at {what}")


def test_the_marker_stands_under_the_place_behind_a_tabulator() -> None:
    problem = Problem(ENTRY, {"what": "X"}, Place("a.nc", 2, 4, "N1\tX1"))
    assert explained(problem).splitlines() == [
        "a.nc:2:4: 399999: X is wrong",
        "    N1\tX1",
        "      \t^",
        "    hint: look at X",
    ]


@pytest.mark.parametrize("column", [1, 60, 61, 5_000, 10_000])
def test_of_a_long_line_the_part_around_the_place_is_shown(column: int) -> None:
    text = "".join(chr(ord("A") + i % 26) for i in range(10_000))
    _, line, marker, _ = explained(Problem(ENTRY, {"what": "X"}, Place("a.nc", 1, column, text))).splitlines()
    assert len(line) <= 4 + WINDOW
    assert line[marker.index("^")] == text[column - 1]


def test_a_line_that_is_not_brought_along_is_read_from_its_file(tmp_path: Path) -> None:
    file = tmp_path / "a.nc"
    file.write_text("N10 X1\nN20 Y2\n")
    assert "    N20 Y2\n        ^" in explained(Problem(ENTRY, {"what": "Y"}, Place(str(file), 2, 5)))
    for gone in (Place(str(file), 9, 1), Place(str(tmp_path / "none.nc"), 2, 1), Place(str(tmp_path), 1, 1)):
        assert len(explained(Problem(ENTRY, {"what": "Y"}, gone)).splitlines()) == 2


def test_a_hint_whose_values_are_lost_is_left_out() -> None:
    told = ErrorEntry(ENTRY.id, "{text}", remedy=ENTRY.remedy)
    assert Problem(told, {"text": "{X} is wrong"}).explained() == "399999: {X} is wrong"
