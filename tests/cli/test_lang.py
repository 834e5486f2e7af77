"""`tandem lang`: everything that is registered stands in the reference."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from runtime.cli.main import main
from runtime.cnc.decoder.isg.registry import G_FUNCTIONS, STATEMENTS, VARIABLES
from runtime.cnc.decoder.reference import WORDS, words
from runtime.cnc.language.isg.functions import FUNCTIONS
from runtime.cnc.language.isg.words import ADDITIONS, WordKind


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


EXAMPLES = {  # of each word, behind a block with a feed
    "<axis>": "@X1 Y=2 Z[1+1]",
    "I J K": "G02 X2 I1 J0",
    "R": "G02 X2 R1",
    "F": "F200",
    "E": "G01 X1 E50",
    "S": "S1000 M3",
    "S.POS": "M19 S100 S.POS=90",
    "S.OFFSET": "S.OFFSET=90",
    "S[ ]": "S[M3 REV500]",
    "REV": "S[REV500 M4]",
    "T": "T1",
    "D": "D0",
    "M": "M8",
    "H": "H12=3",
    "G": "G17",
    "G04": "G04 0.1",
    "P": "P1=1 P[2]=P1",
    "V.": "#VAR\nV.P.A = 1\nV.L.B[3] = [1, 2, 3]\n#ENDVAR",
    "#ANG": "#ANG=45 X10",
    "#CANG": "G02 I5 J0 #CANG=90",
    "#CHR": "X10 #CHR=1\nY10",
    "#CHF": "X10 #CHF=1\nY10",
    "#RND": "X10 #RND=1\nY10",
    "#FRC": "X10 #RND=1 #FRC=100\nY10",
    "LL": "LL SUB",
    "L": "L sub.nc",
    "M17 M29": "LL BACK\nN9: X1",
    "N": "/2 N10: X1\n[HERE] X2",
}


def test_every_kind_of_word_is_in_the_reference_and_understood(tmp_path: Path) -> None:
    assert set(WORDS) == set(WordKind)
    assert {row.name for row in words()} == set(EXAMPLES)
    assert [row.name for row in WORDS[WordKind.ADDITION]] == [f"#{name}" for name in ADDITIONS]
    (tmp_path / "sub.nc").write_text("M17\n")
    for name, example in EXAMPLES.items():
        file = tmp_path / "a.nc"
        file.write_text(f"%L SUB\nM17\n%L BACK\nM17 [N9]\n%A\nG01 X0 F100\n{example}\nM30\n")
        assert main(["check", str(file)]) == 0, name
