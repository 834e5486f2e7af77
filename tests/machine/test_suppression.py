"""Sections in which the operator's stop and override have no effect: X 0 → 40, 40 → 80 suppressed, 80 → 120."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from runtime.cnc.blocks import Block, ExactStop, Suppression
from runtime.cnc.decoder.outside import Outside
from runtime.config.machine import Machine
from runtime.hli.layout import StopCondition
from tests.machine.scripted_blocks import Contour, Scripted, at, speeds_at

FEED = 6000.0  # mm/min


def section(contour: Contour, _outside: Outside) -> Iterator[Block]:
    yield from contour.to(40.0, 1)
    yield ExactStop(at(1))
    yield Suppression(at(2), feed_stop=True, override=True)
    yield from contour.to(80.0, 2)
    yield Suppression(at(3))
    yield from contour.to(120.0, 3)


@pytest.fixture
def scripted(demo: Machine) -> Scripted:
    return Scripted(demo, section)


def test_a_stop_within_takes_effect_behind(scripted: Scripted) -> None:
    scripted.until(lambda: scripted.x > 50.0)
    scripted.hli.operator[0].feedhold_w = True
    scripted.run(0.2)
    assert not scripted.stop & StopCondition.FEED_HOLD
    scripted.until(lambda: scripted.channel.held)
    assert 80.0 < scripted.x < 90.0  # the braking distance from 100 mm/s
    scripted.hli.operator[0].feedhold_w = False
    scripted.finish()
    assert scripted.x == pytest.approx(120.0)


@pytest.mark.parametrize("pressed", [20.0, 35.0, 39.0, 39.9])
def test_a_stop_before_keeps_the_path_out(scripted: Scripted, pressed: float) -> None:
    scripted.until(lambda: scripted.x > pressed)
    scripted.hli.operator[0].feedhold_w = True
    scripted.run(1.0)
    assert scripted.channel.held
    assert scripted.x <= 40.0 + 1e-9
    scripted.hli.operator[0].feedhold_w = False
    scripted.finish()


def test_the_override_counts_in_full(scripted: Scripted) -> None:
    scripted.hli.operator[0].override_w = 500
    assert speeds_at(scripted, 20.0) == pytest.approx(50.0)
    assert speeds_at(scripted, 60.0) == pytest.approx(100.0)
    assert speeds_at(scripted, 110.0) == pytest.approx(50.0)
    scripted.finish()


def test_a_reset_within_stops_and_the_next_program_can_be_held(scripted: Scripted) -> None:
    scripted.until(lambda: scripted.x > 50.0)
    scripted.hli.operator[0].reset_rw = True
    scripted.finish()
    assert 50.0 < scripted.x < 70.0
    scripted.hli.operator[0].feedhold_w = True
    scripted.start()
    scripted.run(0.5)
    assert scripted.stop & StopCondition.FEED_HOLD
