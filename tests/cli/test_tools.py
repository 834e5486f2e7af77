"""`tandem tools`, on a machine whose table lies in a folder of the test."""

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
    code = main(["tools", *arguments])
    out, err = capsys.readouterr()
    return code, out, err


def test_looking_at_the_tools_makes_no_table(capsys: pytest.CaptureFixture[str], state: Path) -> None:
    code, out, _ = told(capsys, "list")
    assert code == 0
    assert [line.split()[1] for line in out.splitlines()[3:-1]] == ["1", "2", "3", "4"]
    assert told(capsys, "show", "2")[1].count("mm") >= 2
    assert not state.exists()


def test_a_tool_is_made_changed_shown_and_taken_out(capsys: pytest.CaptureFixture[str]) -> None:
    assert told(capsys, "set", "7", "radius=4", "length=2 inch", "offset.X=0.5", "name=face mill")[0] == 0
    assert told(capsys, "set", "7", "radius=3.9")[0] == 0
    _, out, _ = told(capsys, "show", "7")
    shown = {line.split()[0]: " ".join(line.split()[1:]) for line in out.splitlines()}
    assert (shown["radius"], shown["length"], shown["offset.X"]) == ("3.9 mm", "50.8 mm", "0.5 mm or degrees")
    assert shown["name"] == "face mill"
    assert told(capsys, "remove", "7")[0] == 0
    assert told(capsys, "remove", "7")[0] == 1
    code, _, err = told(capsys, "show", "7")
    assert (code, err.splitlines()[0]) == (1, "307001: there is no tool 7")


@pytest.mark.parametrize(
    ("text", "error"),
    [("radius=-1", 307041), ("radius=5 deg", 307043), ("depth=1", 307042), ("radius", 307048), ("valid=3", 307020)],
)
def test_a_mistake_changes_nothing(capsys: pytest.CaptureFixture[str], text: str, error: int) -> None:
    code, _, err = told(capsys, "set", "1", "length=99", text)
    assert code == 1
    assert err.startswith(f"{error}: ")
    assert "50.0  mm" in told(capsys, "show", "1")[1]


@pytest.mark.parametrize("name", ["tools.csv", "tools.lis"])
def test_what_is_exported_is_imported(capsys: pytest.CaptureFixture[str], tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    assert told(capsys, "export", str(file))[:2] == (0, "4 tools\n")
    before = told(capsys, "list")[1]
    assert told(capsys, "set", "9", "radius=1")[0] == 0
    assert told(capsys, "set", "1", "radius=1")[0] == 0
    assert told(capsys, "import", str(file))[:2] == (0, "4 tools\n")
    assert told(capsys, "list")[1].count("\n") == before.count("\n") + 1
    assert told(capsys, "import", str(file), "--replace")[0] == 0
    assert told(capsys, "list")[1] == before


def test_a_file_with_a_mistake_enters_nothing(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "tools.csv"
    file.write_text("number,radius\n1,7\n2,-7\n2,5\n")
    code, _, err = told(capsys, "import", str(file))
    assert code == 1
    assert [line for line in err.splitlines() if "hint" not in line] == [
        f"{file}:3:2: 307041: the radius of tool 2, -7, is negative",
        f"{file}:4:1: 307044: tool 2 stands twice",
    ]
    assert "5.0  mm" in told(capsys, "show", "1")[1]
    assert told(capsys, "import", str(tmp_path / "no.lis"))[0] == 1
    assert told(capsys, "import", str(tmp_path / "no.xls"))[0] == 1


def test_no_more_tools_than_the_channel_has_room_for(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    file = tmp_path / "many.csv"
    file.write_text("number\n" + "\n".join(str(n) for n in range(1, 202)))
    code, _, err = told(capsys, "import", str(file))
    assert code == 1
    assert err.startswith("307038: 201 tools")


def test_programs_are_checked_with_the_tools_of_the_machine(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    program = tmp_path / "d.nc"
    program.write_text("%D\nD11\nM30\n")
    assert main(["check", str(program)]) == 1
    assert told(capsys, "set", "11", "radius=1")[0] == 0
    assert main(["check", str(program)]) == 0
