"""The tool that tells which entries of a catalogue have passing tests, with a small catalogue of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from io import StringIO
from pathlib import Path

import pytest
from rich.console import Console

from tests import coverage_spec

CATALOGUE = {
    "language.yaml": """
about: [words about it]
features:
- {id: toy.flow.if, title: Branch, group: flow, core: 1}
- {id: toy.flow.goto, title: Jump, group: flow, core: 2}
- {id: toy.g.rapid-g00, title: Rapid, group: motion, core: 1}
""",
    "parameters.yaml": "parameters:\n- {id: P-1, name: some.name}\n",
    "tokens.yaml": "commands:\n- {token: G00, title: rapid}\n",
}
TESTS = """
import pytest

@pytest.mark.spec("toy.flow.if")
@pytest.mark.parametrize("n", [1, 2])
def test_if(n): pass

@pytest.mark.spec("toy.flow.if", "toy.g.rapid-g00")
def test_both(): pass

@pytest.mark.spec("toy.g.rapid-g00")
def test_broken(): assert False

@pytest.mark.spec("toy.flow.goto")
def test_not_here(): pytest.skip("not today")

@pytest.mark.spec("toy.flow.iff")
def test_misspelt(): pass

def test_of_nothing(): pass

@pytest.fixture
def fragile():
    yield
    raise RuntimeError

@pytest.mark.spec("P-1")
def test_tear_down(fragile): pass
"""


@pytest.fixture
def catalogue(tmp_path: Path) -> Path:
    folder = tmp_path / "catalogue"
    folder.mkdir()
    for name, text in CATALOGUE.items():
        (folder / name).write_text(text)
    return folder


def results(folder: Path, **outcomes: tuple[str, ...]) -> Path:
    """A file of results with one test per outcome: passed=("a.b.c", …)."""
    file = folder / "results.json"
    tests = {f"test_{outcome}": {"ids": list(ids), "outcome": outcome} for outcome, ids in outcomes.items()}
    file.write_text(json.dumps({"tests": tests}))
    return file


def told(*arguments: str | Path, sources: Path) -> tuple[int, str]:
    output = StringIO()
    code = coverage_spec.main([*map(str, arguments), "--sources", str(sources)], Console(file=output))
    return code, output.getvalue()


def cells(output: str, name: str) -> list[str]:
    """The cells of the table's row that begins with `name`."""
    rows = [[cell.strip() for cell in line.split("│")[1:-1]] for line in output.splitlines() if "│" in line]
    return next(row[1:] for row in rows if row[0] == name)


@pytest.mark.parametrize("workers", [(), ("-n", "2")])
def test_outcomes_are_recorded(tmp_path: Path, workers: tuple[str, ...]) -> None:
    (tmp_path / "test_toy.py").write_text(TESTS)
    command = [sys.executable, "-m", "pytest", "-p", "tests.spec_results", "--spec-results", "out/r.json", *workers]
    environment = os.environ | {"PYTHONPATH": str(Path.cwd())}
    subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, check=False)
    read = coverage_spec.read_results(tmp_path / "out" / "r.json")
    assert {id_: len(tests) for id_, tests in read.passed.items()} == {
        "toy.flow.if": 3,
        "toy.g.rapid-g00": 1,
        "toy.flow.iff": 1,
    }
    assert {id_: [test.partition("::")[2] for test in tests] for id_, tests in read.failed.items()} == {
        "toy.g.rapid-g00": ["test_broken"],
        "toy.flow.goto": ["test_not_here"],
        "P-1": ["test_tear_down"],
    }


def test_an_entry_counts_if_every_test_that_names_it_passed(catalogue: Path, tmp_path: Path) -> None:
    file = results(tmp_path, passed=("toy.flow.if", "toy.g.rapid-g00"), failed=("toy.g.rapid-g00",))
    code, output = told(catalogue, "--results", file, sources=tmp_path)
    assert code == 0
    assert cells(output, "language.yaml") == ["3", "1", "33.3 %", "1/2", "0/1"]
    assert cells(output, "parameters.yaml") == ["1", "0", "0.0 %", "", ""]
    assert cells(output, "all") == ["4", "1", "25.0 %", "1/2", "0/1"]
    assert "tokens.yaml" not in output  # no ids in it
    assert "  2 toy.flow.goto  Jump\n" in output
    assert "  1 toy.g.rapid-g00  Rapid  (its tests did not pass)\n" in output
    assert "  - P-1  some.name\n" in output
    assert "toy.flow.if " not in output


def test_groups_and_core_levels(catalogue: Path, tmp_path: Path) -> None:
    file = results(tmp_path, passed=("toy.flow.if", "toy.g.rapid-g00"))
    code, output = told(catalogue, "--results", file, "--groups", "--core", "1", sources=tmp_path)
    assert code == 0
    assert cells(output, "flow") == ["1", "1", "100.0 %", "1/1"]
    assert cells(output, "motion") == ["1", "1", "100.0 %", "1/1"]
    assert "missing" not in output
    assert "P-1" not in output


def test_ids_that_nobody_knows_are_told(catalogue: Path, tmp_path: Path) -> None:
    sources = tmp_path / "sources"
    sources.mkdir()
    (sources / "registry.py").write_text('A = "toy.flow.if"\nB = "toy.g.rapid"\nC = "other.flow.if"\nD = "toy.flow"\n')
    file = results(tmp_path, passed=("toy.flow.iff",))
    code, output = told(catalogue, "--results", file, sources=sources)
    assert code == 1
    told_ids = output.partition("not in the catalogue:\n")[2].splitlines()
    assert told_ids == ["  toy.flow.iff  named by test_passed", f"  toy.g.rapid  named by {sources}/registry.py:2"]


def test_what_cannot_be_read(catalogue: Path, tmp_path: Path) -> None:
    good = results(tmp_path)
    empty = tmp_path / "empty"
    empty.mkdir()
    other = tmp_path / "other.json"
    other.write_text("[]")
    assert told(empty, "--results", good, sources=tmp_path) == (2, f"{empty}: no catalogue entries there\n")
    assert told(catalogue, "--results", other, sources=tmp_path)[1].endswith("not written by `pytest --spec-results`\n")
    code, output = told(catalogue, "--results", tmp_path / "none.json", sources=tmp_path)
    assert code == 2
    assert "No such file" in output
    (catalogue / "again.yaml").write_text("- {id: P-1, name: other}\n")
    assert "P-1 is there twice" in told(catalogue, "--results", good, sources=tmp_path)[1]
    (catalogue / "again.yaml").write_text("a: [\n")
    assert told(catalogue, "--results", good, sources=tmp_path)[0] == 2
