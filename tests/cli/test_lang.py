"""`tandem lang`: everything that is registered stands in the reference."""

from __future__ import annotations

import json

import pytest

from runtime.cli.main import main
from runtime.cnc.decoder.isg.registry import G_FUNCTIONS, STATEMENTS, VARIABLES
from runtime.cnc.language.isg.functions import FUNCTIONS


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(["lang", *arguments]) == 0
    return capsys.readouterr().out


def test_everything_that_is_registered_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys)
    assert [number for number in G_FUNCTIONS if f"G{number:02d}" not in text] == []
    assert [name for name in STATEMENTS if name.removeprefix("CALL ") not in text] == []
    assert [name for name in FUNCTIONS if f"{name}[" not in text] == []
    assert [path for path in VARIABLES if path.split(".<")[0][:20] not in text] == []


def test_a_word_and_a_section_narrow_it(capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, "rotation", "--section", "statements")
    assert "#ROTATION ON" in text
    assert "#FLUSH" not in text
    assert "G68" not in text


def test_what_does_not_exist(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["lang", "no-such-thing"]) == 1
    assert "no-such-thing" in capsys.readouterr().err
    assert main(["lang", "--section", "x"]) == 1
    assert "sections: g," in capsys.readouterr().err


def test_editors_get_objects(capsys: pytest.CaptureFixture[str]) -> None:
    rows = json.loads(printed(capsys, "--json", "--section", "g"))
    assert len(rows) == len(G_FUNCTIONS)
    plane = next(row for row in rows if row["name"] == "G17")
    assert plane == {"section": "g", "name": "G17", "syntax": "G17", "holds": "modal", "meaning": "plane"}
