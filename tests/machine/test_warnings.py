"""Warnings of decoder and path preparation on the machine: told where its errors are told, and nothing stops for them."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import coordinates, language
from runtime.hli.layout import State
from runtime.scheduler.preparation import MOST_WARNINGS
from tests.machine.driven import Driven


@pytest.fixture
def driven(demo: Machine, tmp_path: Path) -> Driven:
    return Driven(demo, tmp_path, ideal_axes=True)


def test_a_warning_is_told_with_its_place_and_stops_nothing(driven: Driven) -> None:
    driven.start("%L SUB\nX10\nM30\n%WARNS\nG90 G01 F6000\nLL SUB\nX20\nM30\n")
    driven.until_done()
    driven.watch(10)
    (told,) = [event for event in driven.errors if event.number == language.END_IN_SUBPROGRAM.id]
    assert "SUB" in told.text
    assert told.line == 3
    assert driven.state() is State.SELECTED
    assert driven.channel.interpolator.position[0] == pytest.approx(10.0)
    driven.start("%AGAIN\nG90 G01 F6000 X5\nM30\n")
    driven.until_done()
    assert len([event for event in driven.errors if event.number == language.END_IN_SUBPROGRAM.id]) == 1


def test_of_many_warnings_the_first_ones_are_told(driven: Driven) -> None:
    driven.start("%MANY\nG90 G01 F6000\n" + "#CS OFF\n" * 30 + "X20\nM30\n")
    driven.until_done()
    told = [event.line for event in driven.errors if event.number == coordinates.NOTHING_TO_END.id]
    assert told == list(range(3, 3 + MOST_WARNINGS))
    assert driven.channel.interpolator.position[0] == pytest.approx(20.0)


def test_warnings_before_an_error_are_told_too(driven: Driven) -> None:
    driven.start("%BOTH\nG90 G01 F6000 X5\n#CS OFF\nP1=0\nX[1/P1]\nM30\n")
    driven.until_done()
    numbers = [event.number for event in driven.errors]
    assert coordinates.NOTHING_TO_END.id in numbers
    assert language.DIVISION_BY_ZERO.id in numbers
