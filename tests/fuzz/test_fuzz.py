"""Mutants of programs through the decoder, the same ones in every run, and the fuzzer itself."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest

from runtime.cnc.decoder import DecoderSetup, Program, load_program
from tests.fuzz import __main__ as fuzz
from tests.fuzz.harness import Harness
from tests.fuzz.mutation import LONGEST, SEEDS, TOKENS, dictionary, mutants, seeds

MUTANTS = 1200  # of each row; `make fuzz` goes on for as long as one likes


@pytest.mark.parametrize("row", range(4))
def test_mutants_give_blocks_or_program_errors(row: int) -> None:
    with Harness() as harness:
        blocks = [harness.run(data) for data in itertools.islice(mutants(row), MUTANTS)]
    assert sum(count > 0 for count in blocks) > MUTANTS // 20, "nearly nothing gets through the check: poor mutants"


@pytest.mark.parametrize("name", ["arcs", "expressions", "flow", "plain", "technology"])
def test_seeds_are_programs(name: str) -> None:
    with Harness() as harness:
        assert harness.run((SEEDS / f"{name}.nc").read_bytes()) > 0


def test_a_number_stands_for_the_same_mutants() -> None:
    first, again, other = (list(itertools.islice(mutants(number), 50)) for number in (7, 7, 8))
    assert first == again
    assert first != other
    assert max(map(len, first)) <= LONGEST
    assert len(set(first) - set(seeds())) > 40


def test_the_seeds_are_small() -> None:
    assert 0 < sum(map(len, seeds())) < 100_000


def test_the_dictionary_of_libfuzzer() -> None:
    lines = dictionary().splitlines()
    assert len(lines) == len(TOKENS)
    assert lines[TOKENS.index(b"$ELSE")] == r'"\x24\x45\x4c\x53\x45"'


@pytest.fixture
def breaking(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A decoder that breaks at every program with an X in it."""

    def broken(path: Path, setup: DecoderSetup) -> Program:
        if b"X" in path.read_bytes():
            raise IndexError("list index out of range")
        return load_program(path, setup)

    monkeypatch.setattr("tests.fuzz.harness.load_program", broken)
    monkeypatch.chdir(tmp_path)


@pytest.mark.usefixtures("breaking")
def test_what_breaks_the_decoder_is_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert fuzz.search([b"Y1\n", b"X1\n", b"Z1\n"], 10.0) == 1
    (found,) = (tmp_path / "out/fuzz").iterdir()
    assert found.read_bytes() == b"X1\n"
    captured = capsys.readouterr()
    assert f"input 2 breaks the decoder: out/fuzz/{found.name}" in captured.out
    assert "IndexError" in captured.err
    assert fuzz.main([str(found)]) == 1
    found.write_bytes(b"Y1\n")
    assert fuzz.main([str(found)]) == 0


def test_the_search_ends_with_its_time(capsys: pytest.CaptureFixture[str]) -> None:
    assert fuzz.main(["--mutants", "--seconds", "0"]) == 0
    assert capsys.readouterr().out == "0 inputs, none breaks the decoder\n"
