"""`tandem offsets`, on a machine whose table lies in a folder of the test."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.cli.main import main


@pytest.fixture(autouse=True)
def state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The demo machine with a state of its own."""
    monkeypatch.setenv("STATE_DIRECTORY", str(tmp_path / "state"))
    return tmp_path / "state"


def told(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    code = main(["offsets", *arguments])
    out, err = capsys.readouterr()
    return code, out, err


def row(out: str, name: str) -> list[str]:
    return next(line for line in out.splitlines() if f" {name} " in line).replace("│", " ").split()


def test_looking_makes_no_table(capsys: pytest.CaptureFixture[str], state: Path) -> None:
    code, out, _ = told(capsys, "list")
    assert code == 0
    assert row(out, "COMMON")[1:] == ["0", "0", "0"]
    assert not state.exists()


def test_what_is_set_is_shown_and_used(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert told(capsys, "set", "G55", "X=10", "Y=1 inch")[0] == 0
    assert told(capsys, "set", "common", "Z=-3 mm")[0] == 0
    assert told(capsys, "set", "H2", "geometry=120", "wear=-0.05")[0] == 0
    assert told(capsys, "set", "H2", "wear=-0.07")[0] == 0
    _, out, _ = told(capsys, "list")
    assert row(out, "G55")[1:3] == ["10", "25.4"]
    assert row(out, "COMMON")[3] == "-3"
    assert row(out, "H2")[1:] == ["120", "-0.07", "119.93"]
    program = tmp_path / "O0001.nc"
    program.write_text("G55 G0 X0 Y0\nG91 G43 Z0 H2\nM30\n")
    assert main(["blocks", "--dialect", "nct", str(program)]) == 0
    out, _ = capsys.readouterr()
    assert '"X": 10.0' in out
    assert '"Y": 25.4' in out
    assert "119.93" in out


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        (("G53", "X=1"), 322010),
        (("H1000", "wear=1"), 322010),
        (("G54", "X"), 322011),
        (("H1", "length=1"), 322011),
        (("G54", "X=wide"), 322012),
        (("G54", "Q=1"), 322013),
        (("D1", "wear=17"), 322014),
        (("D1", "geometry=10000"), 322014),
    ],
)
def test_a_mistake_changes_nothing(capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], error: int) -> None:
    code, _, err = told(capsys, "set", *arguments)
    assert code == 1
    assert err.startswith(f"{error}: ")
    assert " H1 " not in told(capsys, "list")[1]
