"""`tandem check` and `tandem blocks`, and the rows of blocks.jsonl."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from runtime.cli import blocks, check

APP = typer.Typer()
APP.command("check")(check.command)
APP.command("blocks")(blocks.command)

PLATE = """(bore and frame)
%L BORE
N10 G00 X[P10 + P12] Y[P11]
N20 Z1
N30 G01 Z0 F400
N40 P15 = 0
N50 $WHILE P15 < P13
N60   P15 = P15 + P14
N70   $IF P15 > P13
N80     P15 = P13
N90   $ENDIF
N100  G02 X[P10 + P12] Y[P11] Z[-P15] I[-P12] J0 F600
N110 $ENDWHILE
N120 G02 I[-P12] (one clean turn)
N150 M17
%PLATE
N10 G17 G90 G71 G94 G162
N30 T1 M6
N40 S6000 M3
N60 G00 G54 X0 Y0 Z50
N70 P12 = 7  P13 = 2.5  P14 = 1.5
N80 P10 = 25  P11 = 30
N90 LL BORE
N100 G04 0.2
N110 G00 Z5 H12=[P12 + 1] M0
N380 M30
"""


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> CliRunner:
    monkeypatch.chdir(tmp_path)
    return CliRunner()


def test_check_is_silent_about_a_right_program(run: CliRunner) -> None:
    Path("plate.nc").write_text(PLATE)
    result = run.invoke(APP, ["check", "plate.nc"])
    assert (result.exit_code, result.output) == (0, "")


def test_check_tells_file_line_column_id_text(run: CliRunner) -> None:
    Path("a.nc").write_text("N1 G00 X1\nN2 G777 X2\nN3 M30\n")
    Path("b.nc").write_text("G00 X1\nG01 X2\nM30\n")
    result = run.invoke(APP, ["check", "a.nc", "b.nc", "none.nc"])
    assert result.exit_code == 1
    assert result.stdout.splitlines() == [
        "a.nc:2:4: 300032: G777 is not a G function",
        "    N2 G777 X2",
        "       ^",
        "b.nc:2:5: 300090: G01 without a feed",
        "    G01 X2",
        "        ^",
        "    hint: program F before or in this block",
        "none.nc: 300001: program file none.nc does not exist",
        "    hint: check the name and the program paths",
    ]


def test_check_ends_with_an_endless_loop(run: CliRunner, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(check, "IDLE_LIMIT", 1000)
    monkeypatch.setattr(check, "EXECUTED_LIMIT", 1000)
    Path("a.nc").write_text("$WHILE 1\n$ENDWHILE\nM30\n")
    Path("b.nc").write_text("$WHILE 1\nG00 X[1]\n$ENDWHILE\nM30\n")
    result = run.invoke(APP, ["check", "a.nc"])
    assert result.exit_code == 1
    assert ": 300081: " in result.stdout
    result = run.invoke(APP, ["check", "b.nc"])
    assert result.exit_code == 0
    assert "not followed beyond 1000" in result.stderr


def test_check_refuses_a_dialect_that_is_not_there(run: CliRunner) -> None:
    result = run.invoke(APP, ["check", "--dialect", "step", "a.nc"])
    assert result.exit_code == 1
    assert "300007" in result.stdout


def test_check_uses_the_given_machine(run: CliRunner) -> None:
    Path("m.yaml").write_text(
        "name: small\naxes:\n"
        "  - {name: U, log_axis: 1, velocity: 1 m/min, acceleration: 1 m/s^2, jerk: 9 m/s^3}\n"
        "channels:\n  - {name: one, axes: [U]}\n"
    )
    Path("a.nc").write_text("G00 U1\nM30")
    assert run.invoke(APP, ["check", "a.nc", "-c", "m.yaml"]).exit_code == 0
    assert run.invoke(APP, ["check", "a.nc"]).exit_code == 1


def test_blocks_are_json_lines(run: CliRunner) -> None:
    Path("plate.nc").write_text(PLATE)
    result = run.invoke(APP, ["blocks", "plate.nc"])
    assert result.exit_code == 0
    rows = [json.loads(line) for line in result.stdout.splitlines()]
    assert [row["type"] for row in rows] == (
        ["t", "m", "s", "line", "line", "line", "line", "helix", "helix", "arc", "dwell", "h", "line", "stop", "stop"]
    )
    assert rows[0] == {
        "line": 18,
        "n": 30,
        "program": "plate.nc",
        "type": "t",
        "number": 1,
        "value": 0,
        "synch": "MOS",
    }
    assert rows[2]["spindle"] == 0
    assert rows[2]["synch"] == "MVS_SVS|PLC_INFO"
    assert rows[3] == {
        "line": 20,
        "n": 60,
        "program": "plate.nc",
        "type": "line",
        "from": {"X": 0, "Y": 0, "Z": 0},
        "to": {"X": 100, "Y": 80, "Z": 150},
        "to_pcs": {"X": 0, "Y": 0, "Z": 50},
        "feed": None,
        "rapid": True,
    }
    assert rows[7] == {
        "line": 12,
        "n": 100,
        "program": "plate.nc",
        "type": "helix",
        "from": {"X": 132, "Y": 110, "Z": 100},
        "to": {"X": 132, "Y": 110, "Z": 98.5},
        "to_pcs": {"X": 32, "Y": 30, "Z": -1.5},
        "centre": {"X": 125, "Y": 110},
        "radius": 7,
        "angle": -360,
        "plane": "XY",
        "feed": 600,
        "rapid": False,
    }
    assert rows[10]["seconds"] == 0.2
    assert (rows[11]["number"], rows[11]["value"]) == (12, 8)
    assert [row["kind"] for row in rows[-2:]] == ["M00", "M30"]


def test_blocks_tells_errors_on_standard_error(run: CliRunner) -> None:
    Path("a.nc").write_text("G00 X1\nP1 = 1 / 0\nM30")
    result = run.invoke(APP, ["blocks", "a.nc"])
    assert result.exit_code == 1
    assert len(result.stdout.splitlines()) == 1
    assert result.stderr == "a.nc:2:8: 300055: division by zero\n    P1 = 1 / 0\n           ^\n"
    result = run.invoke(APP, ["blocks", "none.nc"])
    assert result.exit_code == 1
    assert "300001" in result.stderr
