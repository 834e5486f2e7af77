"""#ERROR: a warning, an error that a reset clears, a fatal error that needs a new start."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from runtime.cnc.blocks import Block, UserError
from runtime.cnc.decoder.outside import Outside
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import machine as alarms
from runtime.hli.alarms import alarm_lines
from runtime.hli.layout import Mode, State
from tests.machine.scripted_blocks import Contour, Script, Scripted, at


@pytest.fixture
def texts(demo: Machine, tmp_path: Path) -> Machine:
    """The demo machine with texts of its own."""
    file = tmp_path / "errors.txt"
    file.write_text("; ours\n100 clamping pressure too low\n455 part is not in its place\n")
    return demo.model_copy(update={"error_texts": str(file)})


def raising(remedy_class: int) -> Script:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        yield from contour.to(50.0, 1)
        yield UserError(at(2), 455, remedy_class, 10, (5.0, 4.999), (2, 3))
        yield from contour.to(100.0, 3)

    return script


TEXT = "user error 455/10: part is not in its place; current value 5, error value 4.999"


@pytest.mark.spec("isg.add.error")
def test_a_warning_stops_nothing(texts: Machine) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        outside.error(UserError(at(1), 100, 0, 0))
        yield from raising(0)(contour, outside)

    scripted = Scripted(texts, script)
    scripted.finish()
    assert scripted.x == pytest.approx(100.0)
    lines = alarm_lines(scripted.hli)[::-1]
    assert [(line.id, line.line, line.active) for line in lines] == [(306050, 1, False), (306050, 2, False)]
    assert lines[0].text == "script:1: user error 100: clamping pressure too low"
    assert lines[1].text == f"script:2: {TEXT}"


@pytest.mark.spec("isg.add.error")
def test_an_error_stops_at_its_place_until_a_reset(texts: Machine) -> None:
    scripted = Scripted(texts, raising(2))
    scripted.finish()
    assert scripted.x == pytest.approx(50.0)
    (line,) = alarm_lines(scripted.hli)
    assert (line.id, line.text, line.line, line.active) == (306051, f"script:2: {TEXT}", 2, True)
    scripted.run(0.01)
    unit = scripted.hli.channels[0].control.mode_and_state
    assert unit.state_r == State.ERROR
    scripted.simulation.order(Mode.AUTOMATIC, State.ACTIVE, "script.nc")
    scripted.run(0.01)
    assert not scripted.channel.active
    scripted.hli.operator[0].reset_rw = True
    scripted.run(0.1)
    assert unit.state_r == State.SELECTED
    scripted.start()
    scripted.finish()
    assert scripted.x == pytest.approx(50.0)


@pytest.mark.spec("isg.add.error")
def test_a_fatal_error_needs_a_new_start_of_the_runtime(texts: Machine) -> None:
    scripted = Scripted(texts, raising(7))
    scripted.finish()
    assert scripted.x == pytest.approx(50.0)
    assert scripted.alarms == [alarms.USER_FATAL.id]
    scripted.hli.operator[0].reset_rw = True
    scripted.run(0.1)
    assert scripted.hli.channels[0].control.mode_and_state.state_r == State.ERROR
    assert [line.id for line in alarm_lines(scripted.hli, active_only=True)] == [alarms.RESTART_NEEDED.id]
    scripted.start()
    scripted.run(0.1)
    assert not scripted.channel.active
    assert scripted.x == pytest.approx(50.0)


@pytest.mark.spec("isg.add.error")
def test_without_texts_an_error_is_told_by_its_number(demo: Machine) -> None:
    scripted = Scripted(demo, raising(2))
    scripted.finish()
    assert alarm_lines(scripted.hli)[0].text == "script:2: user error 455/10; current value 5, error value 4.999"
