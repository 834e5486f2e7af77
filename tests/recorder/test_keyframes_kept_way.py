"""Keyframes of a machine that keeps its way: driven backward and forward again, with sections left out, and a block search."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.cnc.search_target import SearchKind
from runtime.config.machine import Machine
from runtime.hli.layout import PathWay, SearchOrder, SearchState
from runtime.recorder import keyframes as of_the_border
from runtime.recorder.file import RecordingFile
from runtime.recorder.record import Section
from tests.machine.conftest import demo
from tests.machine.test_backward_motion import SECTIONS, TOUR
from tests.machine.test_block_search import PART
from tests.recorder.test_keyframes import assert_same_from_each, keyframes, rewritten, with_keyframes
from tests.recorder.test_replay import Recorded, replay

__all__ = ["demo"]


def keeping(machine: Machine, folder: Path, storage: int) -> Recorded:
    channel = machine.channels[0].model_copy(update={"backward_storage": storage})
    return Recorded(machine.model_copy(update={"channels": (channel,)}), folder, ideal_axes=True)


def until_way(recorded: Recorded, way: PathWay, every: int, seconds: float = 0.25) -> None:
    """Run until the path goes that way, and on with keyframes."""
    status = recorded.simulation.memory.hli.channels[0].status
    assert recorded.simulation.run_until(lambda: status.path_way_r == way, 2.0)
    with_keyframes(recorded, seconds, every)


@pytest.mark.parametrize("storage", [2000, 40])
def test_backward_and_forward_again(demo: Machine, tmp_path: Path, storage: int) -> None:
    """2000 records, as the template of a machine description has them, are 1.9 MB; of 40 the oldest have given way."""
    recorded = keeping(demo, tmp_path, storage)
    operator = recorded.simulation.memory.hli.operator[0]
    recorded.start(TOUR)
    with_keyframes(recorded, 1.8, 300)
    operator.backward_motion_w = True
    until_way(recorded, PathWay.BACKWARD, 120, 0.8)
    operator.backward_motion_w = False
    until_way(recorded, PathWay.REPEATING, 80)
    with_keyframes(recorded, 0.2, 80)
    assert not recorded.simulation.problems
    assert_same_from_each(recorded, tmp_path, 6)


def test_sections_left_out(demo: Machine, tmp_path: Path) -> None:
    """With a keyframe while the section has begun and not yet ended."""
    recorded = keeping(demo, tmp_path, 2000)
    operator = recorded.simulation.memory.hli.operator[0]
    recorded.start(SECTIONS.format(which=""))
    with_keyframes(recorded, 1.6, 60)
    operator.backward_motion_w = True
    until_way(recorded, PathWay.BACKWARD, 60)
    operator.backward_motion_w = False
    with_keyframes(recorded, 0.6, 60)
    assert_same_from_each(recorded, tmp_path, 6)


def test_what_is_told_of_an_open_section_is_as_it_was(
    demo: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its end is passed before its begin is told; then a replay turns in front of the end, and must not know it yet."""
    monkeypatch.setattr(of_the_border, "KEPT_RECORDS", 1)
    recorded = keeping(demo, tmp_path, 2000)
    storage = recorded.simulation.controller.channel.backward.storage
    recorded.start(SECTIONS.format(which=""))
    simulation, border = recorded.simulation, recorded.simulation.recording.border  # type: ignore[union-attr]
    while storage.state[3] <= 0:
        simulation.cycle()
    number = int(storage.state[3])
    border.keyframe_wanted = True
    while border.keyframe_wanted:
        simulation.cycle()
    storage.kept[number]["size"] = 17
    while border.busy:
        simulation.cycle()
    simulation.close()
    pieces = [
        words
        for record in RecordingFile(recorded.path).records()
        for kind, words in record.sections
        if kind == Section.KEYFRAME_RING and words[0] == 0
    ]
    sizes = {int(words[1]): int(words[2 + of_the_border._OPEN_SIZE]) for words in pieces}
    assert sizes[number] == -1


def test_a_path_that_is_faster_than_the_recorder_gives_the_keyframe_up(
    demo: Machine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is taken again; a replay of what begins with the one that was given up goes on at the next."""
    monkeypatch.setattr(of_the_border, "KEPT_RECORDS", 1)
    recorded = keeping(demo, tmp_path, 24)
    lines = "".join(f"N{k} X{k * 0.03:.2f}\n" for k in range(20, 2000))
    recorded.start(f"%SHORT\nN10 G90 G01 F9000 X0.1\n{lines}N3000 X200\nN3010 M30\n")
    with_keyframes(recorded, 2.5, 200)
    recorded.simulation.close()
    first = keyframes(recorded.path, whole=False)[0]
    second = next(cycle for cycle in keyframes(recorded.path) if cycle > first)
    result = replay(rewritten(recorded.path, tmp_path / "part", lambda cycle: cycle >= first), recorded.machine)
    assert result.difference is None
    assert result.cycles == recorded.simulation.controller.cycle_number - second + 1


def test_a_block_search_between_two_keyframes(demo: Machine, tmp_path: Path) -> None:
    recorded = Recorded(demo, tmp_path, ideal_axes=True)
    recorded.program.write_text(PART)
    simulation = recorded.simulation
    assert simulation.run_until(simulation.ready, 20.0)
    with_keyframes(recorded, 0.1, 40)
    order = SearchOrder(type=int(SearchKind.BLOCK_NUMBER), value=80, automatic_return=True, no_hold=True)
    simulation.start(recorded.program, order)
    with_keyframes(recorded, 1.5, 90)
    assert not simulation.problems
    assert simulation.controller.channel.active
    assert simulation.memory.hli.channels[0].status.block_search_state_r != SearchState.INACTIVE
    assert_same_from_each(recorded, tmp_path, 5)
