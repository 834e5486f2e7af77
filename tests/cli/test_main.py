"""The `tandem` command: its overview, its exit codes, and what stands on the error output."""

from __future__ import annotations

import subprocess
import sys
import types
from pathlib import Path
from typing import Annotated

import pytest
import typer

from runtime.cli import main as cli
from runtime.config.loader import load_machine
from runtime.diagnostics.errors import ErrorEntry, Place, TandemError


def invoke(monkeypatch: pytest.MonkeyPatch, function: object, *arguments: str) -> int:
    """Run `tandem probe` with a sub-command made of `function`."""
    module = types.ModuleType("runtime.cli.probe")
    setattr(module, "app" if isinstance(function, typer.Typer) else "command", function)
    monkeypatch.setitem(sys.modules, "runtime.cli.probe", module)
    probe = cli.SubCommand("probe", "runtime.cli.probe", "Probe.")
    monkeypatch.setattr(cli, "SUB_COMMANDS", (*cli.SUB_COMMANDS, probe))
    return cli.main(["probe", *arguments])


def test_help_lists_every_sub_command_and_imports_none() -> None:
    code = "import sys; from runtime.cli.main import main; code = main(['--help']); print(*sys.modules); sys.exit(code)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    for command in cli.SUB_COMMANDS:
        assert command.name in done.stdout
        assert command.help.split(";")[0][:30] in done.stdout
    loaded = done.stdout.splitlines()[-1].split()
    assert not {"numba", "numpy", "can", "lark", *(c.module for c in cli.SUB_COMMANDS)} & set(loaded)


def test_arguments_reach_the_sub_command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def command(file: Path, trace: Annotated[Path, typer.Option()] = Path("none")) -> None:
        """Probe."""
        print(file, trace)

    assert invoke(monkeypatch, command, "--trace", "out", "--", "-x.nc") == 0
    assert capsys.readouterr().out == "-x.nc out\n"
    assert invoke(monkeypatch, command, "--help") == 0
    assert "tandem probe" in capsys.readouterr().out


def test_a_sub_command_may_have_commands_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    application = typer.Typer()
    application.command("watch")(lambda: None)

    @application.command("header")
    def header() -> None:
        raise typer.Exit(3)

    assert invoke(monkeypatch, application, "watch") == 0
    assert invoke(monkeypatch, application, "header") == 3


def test_wrong_usage_is_exit_code_2(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def command(file: Path) -> None:
        """Probe."""

    assert invoke(monkeypatch, command) == 2
    assert cli.main(["simulat"]) == 2
    assert "simulate" in capsys.readouterr().err


def test_an_error_of_the_catalogue_is_explained(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def command() -> None:
        raise TandemError(
            ErrorEntry(999_999, "It is {how}", remedy="Mend it."), Place("a.nc", 3, 5, "N10 G01"), how="broken"
        )

    assert invoke(monkeypatch, command) == 1
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err == "a.nc:3:5: 999999: It is broken\n    N10 G01\n        ^\n    hint: Mend it.\n"


def test_every_mistake_of_a_description_is_printed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    file = tmp_path / "m.yaml"
    file.write_text("nam: x\nchannels: []\n")

    def command() -> None:
        load_machine(file)

    assert invoke(monkeypatch, command) == 1
    lines = [line for line in capsys.readouterr().err.splitlines() if line.startswith(str(file))]
    assert [line.split(": ")[1] for line in lines] == ["302007", "302007", "302006", "302016"]


def test_interruption_is_exit_code_130(monkeypatch: pytest.MonkeyPatch) -> None:
    def command() -> None:
        raise KeyboardInterrupt

    assert invoke(monkeypatch, command) == 130


def test_a_module_that_is_missing_is_told(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    missing = cli.SubCommand("gone", "runtime.cli.gone", "Gone.")
    monkeypatch.setattr(cli, "SUB_COMMANDS", (missing,))
    assert cli.main(["gone"]) == 1
    assert "305001" in capsys.readouterr().err


def test_a_reader_that_has_enough_is_no_error() -> None:
    code = (
        "import sys, types, typer; from runtime.cli import main as cli\n"
        "probe = types.ModuleType('probe'); probe.command = lambda: [print('x' * 1000) for _ in range(1000)] and None\n"
        "sys.modules['probe'] = probe; cli.SUB_COMMANDS = (cli.SubCommand('probe', 'probe', 'Probe.'),)\n"
        "sys.exit(cli.main(['probe']))"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.read(10)
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode in (0, 1)
