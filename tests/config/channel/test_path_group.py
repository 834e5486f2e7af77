"""The path axes of a channel: names, logical numbers, and what its list of parameters says of them (manual 004, 3543–3641)."""

from __future__ import annotations

import pytest

from runtime.config.loader import parse_machine
from runtime.diagnostics.catalogue import configuration as errors
from tests.config.machines import MACHINE, problems_of, with_parameters

_AXES = "{bezeichnung: X, log_achs_nr: 1}, {bezeichnung: Y, log_achs_nr: 2}"
GROUP = f"gruppe: [{{bezeichnung: MILL, achs_anzahl: 2, achse: [{_AXES}]}}]"


@pytest.mark.spec("chan.axes.path-group")
def test_a_group_that_says_what_the_channel_has_is_taken() -> None:
    machine = parse_machine(with_parameters(f"grp_anzahl: 1\n{GROUP}"))
    assert machine.channels[0].axes == ("X", "Y")
    assert [machine.axes[machine.axis_index(name)].log_axis for name in ("X", "Y")] == [1, 2]


@pytest.mark.spec("chan.axes.path-group")
@pytest.mark.parametrize("letter", "ABCUVWXYZQ")
def test_names_begin_with_a_letter_of_an_axis(letter: str) -> None:
    name = f"{letter}_ACHSE1"
    text = MACHINE.replace("name: Y,", f"name: {name},").replace("[X, Y]", f"[X, {name}]")
    assert parse_machine(text).channels[0].axes == ("X", name)


@pytest.mark.spec("chan.axes.path-group")
@pytest.mark.parametrize(
    ("old", "new", "number"),
    [
        ("log_axis: 1,", "log_axis: 0,", 302010),
        ("log_axis: 2,", "log_axis: 1,", errors.NOT_UNIQUE.id),
        ("log_axis: 6,", "log_axis: 2,", errors.NOT_UNIQUE.id),  # path axis and spindle
        ("axes: [X, Y]", "axes: [X, X]", errors.UNKNOWN_AXIS.id),
        ("axes: [X, Y]", "axes: [X, S]", errors.SPINDLE_IN_PATH.id),
        ("name: X,", "name: P1,", 302017),
        ("name: Y,", "name: X,", errors.NOT_UNIQUE.id),
    ],
)
def test_numbers_and_names_are_given_once(old: str, new: str, number: int) -> None:
    assert old in MACHINE
    assert number in [problem.entry.id for problem in problems_of(MACHINE.replace(old, new))]


@pytest.mark.spec("chan.axes.path-group")
@pytest.mark.parametrize(
    "text",
    [
        "gruppe: [{achs_anzahl: 3}]",
        "gruppe: [{achse: [{bezeichnung: Y}]}]",
        "gruppe: [{achse: [{bezeichnung: X, log_achs_nr: 2}]}]",
        "spindel: [{bezeichnung: S, log_achs_nr: 1}]",
    ],
)
def test_a_group_that_says_something_else_is_an_error(text: str) -> None:
    (problem,) = problems_of(with_parameters(text))
    assert problem.entry.id == 302034


@pytest.mark.spec("chan.axes.path-group")
def test_there_is_one_group() -> None:
    (problem,) = problems_of(with_parameters("grp_anzahl: 0"))
    assert problem.entry.id == 302010
