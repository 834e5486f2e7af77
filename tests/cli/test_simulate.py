"""`tandem simulate`: what it prints, its exit codes, its traces."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from runtime.cli import main as cli

PROGRAM = "%PART\nN10 G90 G01 X10 F3000 M8\nN20 G02 X20 Y10 I10\nN30 G00 Z5\nN40 M30\n"
TRACE = ("blocks.jsonl", "events.jsonl", "samples.npz", "summary.json")


@pytest.fixture
def program(tmp_path: Path) -> Path:
    path = tmp_path / "part.nc"
    path.write_text(PROGRAM)
    return path


def lines(path: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in path.read_text().splitlines()]


@pytest.mark.parametrize(
    "options", [[], ["--ideal-axes"], ["--ideal-axes", "--no-plc"]], ids=["drives", "ideal", "bare"]
)
def test_two_runs_give_the_same_bytes(program: Path, tmp_path: Path, options: list[str]) -> None:
    for name in "ab":
        assert cli.main(["simulate", str(program), "--trace", str(tmp_path / name), *options]) == 0
    for file in TRACE:
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()


def test_the_trace_has_what_the_program_does(program: Path, tmp_path: Path) -> None:
    assert cli.main(["simulate", str(program), "--trace", str(tmp_path / "out"), "--ideal-axes"]) == 0
    blocks = lines(tmp_path / "out/blocks.jsonl")
    assert [(block["type"], block["n"], block.get("rapid")) for block in blocks if "from" in block] == [
        ("line", 10, False), ("arc", 20, False), ("line", 30, True)]  # fmt: skip
    events = lines(tmp_path / "out/events.jsonl")
    assert [(event["event"], event["number"]) for event in events if str(event["event"]).startswith("m_")] == [
        ("m_out", 8), ("m_ack", 8)]  # fmt: skip
    with np.load(tmp_path / "out/samples.npz") as samples:
        assert sorted(samples) == ["X", "Y", "Z", "line", "t", "v_path"]
        assert (samples["X"][-1], samples["Y"][-1], samples["Z"][-1]) == pytest.approx((20.0, 10.0, 5.0))
        assert np.allclose(np.diff(samples["t"]), 0.001)
    summary = json.loads((tmp_path / "out/summary.json").read_text())
    assert summary["positions"] == pytest.approx({"X": 20.0, "Y": 10.0, "Z": 5.0})
    assert summary["errors"] == []
    assert summary["path_length_mm"] == pytest.approx(10.0 + np.pi * 5.0 + 5.0, abs=5.0)


def test_the_picture_is_drawn(program: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = tmp_path / "path.png"
    assert cli.main(["simulate", str(program), "--ideal-axes", "--plot", str(picture)]) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert f"picture {picture}" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "id_"), [("%A\nG01 X5\nM30\n", 300090), ("%A\nG90 G01 X5 F100 M77\nM30\n", 300070), ("", 300003)]
)
def test_an_error_ends_with_1_and_moves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, id_: int
) -> None:
    program = tmp_path / "wrong.nc"
    program.write_text(text)
    trace = tmp_path / "out"
    assert cli.main(["simulate", str(program), "--ideal-axes", "--trace", str(trace)]) == 1
    assert f"{id_}: " in capsys.readouterr().err
    summary = json.loads((trace / "summary.json").read_text())
    assert summary["path_length_mm"] == 0.0
    assert len(summary["errors"]) == 1


@pytest.mark.parametrize("option", ["--trace", "--plot"])
def test_a_place_that_cannot_be_written_is_told_at_once(
    program: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], option: str
) -> None:
    (tmp_path / "file").write_text("")
    assert cli.main(["simulate", str(program), option, str(tmp_path / "file" / "below")]) == 1
    assert "305003" in capsys.readouterr().err


def test_a_dialect_that_is_not_there(program: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for command in ("simulate", "check", "blocks"):
        assert cli.main([command, str(program), "--dialect", "step"]) == 1
        printed = capsys.readouterr()
        assert "300007" in printed.out + printed.err


def test_run_refuses_before_anything_starts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for arguments, id_ in (
        (["--dialect", "step"], "300007"),
        (["--program", str(tmp_path / "missing.nc")], "300001"),
        (["--plot", str(tmp_path / "no" / "path.png")], "305003"),
        (["-c", str(tmp_path / "missing.yaml")], "302001"),
    ):
        assert cli.main(["run", *arguments]) == 1
        assert id_ in capsys.readouterr().err
    assert cli.main(["run", "--demo", "-c", "config/machine.yaml"]) == 2


def test_a_program_is_entered_in_the_middle(program: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    options = ["--ideal-axes", "--trace", str(out)]
    assert cli.main(["simulate", str(program), "--start-at", "N30", *options]) == 0
    moved = [(block["line"], block["to"]) for block in lines(out / "blocks.jsonl") if "to" in block]
    assert moved == [
        (4, {"X": 20.0, "Y": 10.0, "Z": 0.0}),  # the way back
        (4, {"X": 20.0, "Y": 10.0, "Z": 5.0}),
    ]
    assert cli.main(["simulate", str(program), "--start-at", "N35", "--ideal-axes"]) == 1
    assert "306100" in capsys.readouterr().err
    assert cli.main(["simulate", str(program), "--start-at", "here", "--ideal-axes"]) == 2
