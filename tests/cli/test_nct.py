"""The commands with programs of the NCT dialect."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from runtime.cli.main import main
from runtime.cnc.decoder.nct.registry import G_CODES, M_CODES, TABLE, WORDS, number_text
from runtime.cnc.language.nct.addresses import ADDRESSES

PROGRAM = "%O0001\nN10 G0 X1 Y2\nM98 P2\nM30\n%\n%O0002\nG91 X1\nG90\nM99\n%\n"


def test_the_reference_has_everything_that_is_registered(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["lang", "--dialect", "nct", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    names = {section: [row["name"] for row in rows if row["section"] == section] for section in ("g", "m", "words")}
    assert names["g"] == [f"G{number_text(tenths)}" for tenths in sorted(G_CODES)]
    assert names["m"] == [f"M{number:02d}" for number in sorted(M_CODES)]
    assert set(names["words"]) == {"/", *ADDRESSES}
    assert set(G_CODES) <= TABLE
    assert set(WORDS) <= set(ADDRESSES)
    assert main(["lang", "--dialect", "nct", "dwell", "--section", "g"]) == 0
    assert "G04" in capsys.readouterr().out
    assert main(["lang", "--dialect", "nct", "--section", "statements"]) == 1
    assert "sections: g, m, words" in capsys.readouterr().err


def test_the_option_and_the_machine_description(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program = tmp_path / "part.nc"
    program.write_text(PROGRAM)
    assert main(["check", str(program)]) == 1
    capsys.readouterr()
    assert main(["check", "--dialect", "nct", str(program)]) == 0
    description = (
        Path("runtime/demo/machine.yaml").read_text().replace("  - name: mill\n", "  - name: mill\n    dialect: nct\n")
    )
    machine = tmp_path / "machine.yaml"
    machine.write_text(description)
    assert main(["check", "-c", str(machine), str(program)]) == 0
    assert main(["check", "-c", str(machine), "--dialect", "isg", str(program)]) == 1
    capsys.readouterr()
    assert main(["blocks", "-c", str(machine), str(program)]) == 0
    rows = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [row["line"] for row in rows if row["type"] == "line"] == [2, 7]


def test_errors_are_told_at_their_place(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    program = tmp_path / "part.nc"
    program.write_text("O0001\nG0 X1\nG1.5 X2\nM98 P9\n")
    assert main(["check", "--dialect", "nct", str(program)]) == 1
    assert f"{program}:3:1: 320002: 3005 ILLEGAL G CODE: G01.5" in capsys.readouterr().out


def test_what_is_not_there_yet_is_refused_before_anything_moves(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    program = tmp_path / "part.nc"
    program.write_text("O0001\nG0 X1\nG12.1\n")
    assert main(["simulate", "--ideal-axes", "--dialect", "nct", str(program)]) == 1
    printed = capsys.readouterr()
    assert "G12.1 is not supported yet" in printed.err
    assert "path 0.000 mm" in printed.out
