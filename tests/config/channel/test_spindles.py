"""Spindles of a channel: which of them there are, by their list, and which one is the main spindle."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.cnc.decoder.setup import DecoderSetup
from runtime.diagnostics.catalogue import configuration as errors
from runtime.diagnostics.catalogue import spindle
from tests.config.machines import list_problems, machine_with_list, parameters_of

SPEC = "chan.spindle.config"
TWO = "spindel[0].bezeichnung S\nspindel[0].log_achs_nr 6\nspindel[1].bezeichnung S2\n"


@pytest.mark.spec(SPEC)
def test_only_what_is_listed_can_be_programmed(tmp_path: Path) -> None:
    machine = machine_with_list(tmp_path, "spdl_anzahl 1\nspindel[0].bezeichnung S\nspindel[0].log_achs_nr 6\n")
    assert DecoderSetup.from_machine(machine).spindle_names == ("S",)
    assert DecoderSetup.from_machine(machine_with_list(tmp_path, "spdl_anzahl 0\n")).spindle_names == ()


@pytest.mark.spec(SPEC)
def test_an_optional_spindle_that_the_machine_does_not_have_is_left_out(tmp_path: Path) -> None:
    machine = machine_with_list(tmp_path, f"spdl_anzahl 2\n{TWO}spindel[1].optional 1\n")
    assert [known.bezeichnung for known in machine.channels[0].parameters.spindel] == ["S"]
    assert DecoderSetup.from_machine(machine).spindle_names == ("S",)
    (problem,) = list_problems(tmp_path, TWO)
    assert (problem.entry, problem.place.line) == (errors.UNKNOWN_AXIS, 3)


@pytest.mark.spec(SPEC)
def test_an_optional_spindle_that_is_there_is_kept(tmp_path: Path) -> None:
    machine = machine_with_list(tmp_path, "spindel[0].bezeichnung S\nspindel[0].optional 1\n")
    assert DecoderSetup.from_machine(machine).spindle_names == ("S",)


@pytest.mark.spec(SPEC, "chan.spindle.main")
def test_the_main_spindle_is_not_left_out_in_silence(tmp_path: Path) -> None:
    absent = "spindel[0].bezeichnung S2\nspindel[0].log_achs_nr 11\nspindel[0].optional 1\nspindel[1].bezeichnung S\n"
    (problem,) = list_problems(tmp_path, absent)
    assert (problem.entry, problem.place.line) == (spindle.MAIN_SPINDLE_ABSENT, 1)
    (problem,) = list_problems(tmp_path, f"main_spindle_ax_nr 11\n{absent}")
    assert problem.entry is spindle.MAIN_SPINDLE_ABSENT
    kept = machine_with_list(tmp_path, f"main_spindle_ax_nr 6\n{absent}spindel[1].log_achs_nr 6\n")
    assert DecoderSetup.from_machine(kept).main_spindle == 0
    assert DecoderSetup.from_machine(kept).spindles[0].log_axis == 6


@pytest.mark.spec(SPEC)
@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("spdl_anzahl 2\nspindel[0].bezeichnung S", errors.PARAMETER_CONTRADICTS),
        ("spindel[0].bezeichnung S\nspindel[0].log_achs_nr 7", errors.PARAMETER_CONTRADICTS),
        ("spindel[0].bezeichnung S\nspindel[0].log_achs_nr 0", errors.OUT_OF_RANGE),
        ("spindel[0].bezeichnung X", errors.SPINDLE_EXPECTED),
    ],
)
def test_what_contradicts_itself_is_told(tmp_path: Path, text: str, entry: object) -> None:
    assert list_problems(tmp_path, text)[0].entry is entry


@pytest.mark.spec(SPEC)
@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("spindel[0].bezeichnung S\nspindel[1].bezeichnung S\n", 2),
        (f"{TWO}spindel[1].log_achs_nr 6\nspindel[1].optional 1\n", 4),
    ],
)
def test_no_spindle_is_there_twice(tmp_path: Path, text: str, line: int) -> None:
    found = [(problem.entry, problem.place.line) for problem in list_problems(tmp_path, text)]
    assert (errors.PARAMETER_NOT_UNIQUE, line) in found


def test_the_default_is_a_spindle_that_has_to_be_there() -> None:
    assert parameters_of("spindel: [{bezeichnung: S}]").spindel[0].optional is False
