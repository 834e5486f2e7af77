"""A replay begins at any keyframe, in motion too, and does from there on what was done: nothing of the state is missing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from runtime.cnc.axes.single_axis import SingleAxis
from runtime.config.machine import Machine
from runtime.fieldbus.simulator.drive import Fault
from runtime.kernels import warm_up
from runtime.recorder import border
from runtime.recorder.file import RecordingError, RecordingFile, RecordingWriter
from runtime.recorder.keyframes import stage_records
from runtime.recorder.noting import StateNotes
from runtime.recorder.record import GAP, KEYFRAME, Section
from runtime.recorder.state import Outside, StateError, restore
from runtime.scheduler.recorded import watch
from tests.recorder.test_replay import MESSAGES, PART, Recorded, replay

Words = npt.NDArray[np.int64]


def rewritten(source: Path, target: Path, keep: Callable[[int], bool]) -> Path:
    """The recording with those cycles only; what follows a cycle that is left out carries the mark of a gap."""
    with RecordingFile(source) as file:
        writer = RecordingWriter(target, file.header)
        gap = False
        for chunk in file.chunks():
            words, at, kept = chunk.words().copy(), 0, []
            while at < len(words):
                end = at + int(words[at])
                if keep(int(words[at + 1])):
                    words[at + 4] |= GAP if gap else 0
                    kept.append(words[at:end])
                    gap = False
                else:
                    gap = True
                at = end
            if kept:
                writer.add(np.concatenate(kept))
        writer.close()
    return target


def keyframes(path: Path, *, whole: bool = True) -> list[int]:
    """The cycles that they are of; `whole`: those that were told to their end, else those that were given up."""
    found, cycle = [], 0
    with RecordingFile(path) as file:
        for record in file.records():
            if record.marks & KEYFRAME:
                cycle = record.cycle
            end = record.section(Section.KEYFRAME_END)
            if end is not None and bool(end[0]) == whole:
                found.append(cycle)
    return found


def with_keyframes(recorded: Recorded, seconds: float, every: int) -> None:
    """Run, with a keyframe every so many cycles, in motion too."""
    border = recorded.simulation.recording.border  # type: ignore[union-attr]
    for k in range(round(seconds / recorded.simulation.period)):
        border.keyframe_wanted = border.keyframe_wanted or k % every == 0
        recorded.simulation.cycle()


def assert_same_from_each(recorded: Recorded, folder: Path, most: int) -> None:
    recorded.simulation.close()
    found = keyframes(recorded.path)
    assert len(found) > most
    last = recorded.simulation.controller.cycle_number
    for cycle in found[:: max(1, len(found) // most)][1:]:
        path = rewritten(recorded.path, folder / "part", lambda number, cycle=cycle: number >= cycle)  # type: ignore[misc]
        result = replay(path, recorded.machine)
        assert result.difference is None, f"from {cycle}: {result.difference}"
        assert result.cycles == last - cycle + 1


@pytest.mark.parametrize("text", [PART, MESSAGES.replace("N30 V.E.parts = 3\n", "")])
def test_a_replay_begins_at_any_keyframe(demo: Machine, tmp_path: Path, text: str) -> None:
    recorded = Recorded(demo, tmp_path, ideal_axes=True)
    recorded.start(text)
    with_keyframes(recorded, 0.8, 97)
    assert_same_from_each(recorded, tmp_path, 4)


def test_a_keyframe_in_a_fault_and_in_a_hold(demo: Machine, tmp_path: Path) -> None:
    recorded = Recorded(demo, tmp_path)
    recorded.start("%P\nN10 G90 G01 X100 F6000 M3 S500\nN20 M30\n")
    operator = recorded.simulation.memory.hli.operator[0]
    with_keyframes(recorded, 0.2, 67)
    operator.feedhold_w = True
    with_keyframes(recorded, 0.2, 67)
    operator.feedhold_w = False
    with_keyframes(recorded, 0.1, 67)
    recorded.simulation.nodes.inject(1, Fault.DRIVE)
    with_keyframes(recorded, 0.3, 67)
    assert recorded.simulation.problems
    assert_same_from_each(recorded, tmp_path, 3)


def test_the_cycle_compiles_nothing(demo: Machine, tmp_path: Path) -> None:
    """Each kernel of the border is warmed with what the cycle calls it with: one signature, whatever was recorded."""
    warm_up()
    recorded = Recorded(demo, tmp_path, ideal_axes=True)
    recorded.start(PART)
    with_keyframes(recorded, 0.3, 50)
    recorded.simulation.close()
    kernels: tuple[Any, ...] = (border._count_ahead, stage_records)
    for kernel in kernels:
        assert len(kernel.signatures) == 1, kernel.signatures


def test_a_gap_is_gone_over_at_the_next_keyframe(demo: Machine, tmp_path: Path) -> None:
    recorded = Recorded(demo, tmp_path, ideal_axes=True)
    recorded.start(PART)
    with_keyframes(recorded, 0.6, 100)
    recorded.simulation.close()
    found = keyframes(recorded.path)
    path = rewritten(recorded.path, tmp_path / "gap", lambda cycle: not 150 <= cycle < 250)
    result = replay(path, recorded.machine)
    assert result.difference is None
    assert result.gaps == 1
    behind = next(cycle for cycle in found if cycle >= 250)
    assert result.cycles == 149 + recorded.simulation.controller.cycle_number - behind + 1


def test_a_recording_without_a_whole_keyframe_is_refused(demo: Machine, tmp_path: Path) -> None:
    recorded = Recorded(demo, tmp_path, ideal_axes=True)
    recorded.run(0.1)
    recorded.simulation.close()
    path = rewritten(recorded.path, tmp_path / "late", lambda cycle: cycle > 5)
    with pytest.raises(RecordingError, match="no cycle from which"):
        replay(path, recorded.machine)


def test_keyframes_may_wait_for_standstill(demo: Machine, tmp_path: Path) -> None:
    """Then none is taken while something moves, and the next standstill has one."""
    recorded = Recorded(demo, tmp_path, ideal_axes=True)
    watch(recorded.simulation.recording.border, recorded.simulation.controller, "standstill")  # type: ignore[union-attr]
    recorded.start("%P\nN10 G90 G01 X20 F6000\nN20 X0\nN30 M30\n")
    recorded.run(0.1)
    simulation, border = recorded.simulation, recorded.simulation.recording.border  # type: ignore[union-attr]
    moving = []
    border.keyframe_wanted = True
    while border.keyframe_wanted:
        simulation.cycle()
        moving.append(not simulation.controller.channel.interpolator.standstill)
    assert sum(moving) > 300
    taken = simulation.controller.cycle_number
    recorded.run(0.2)  # it is told in the cycles behind it
    recorded.replayed()
    assert keyframes(recorded.path)[1:] == [taken]


def test_objects_that_are_shared_are_shared_again_and_other_classes_are_refused() -> None:
    from runtime.cnc.axes.axis_plan import Dynamics

    limits = Dynamics(100.0, 1000.0, 10000.0)
    axis = SingleAxis(limits, 0.001)
    axis.move_to(20.0)
    for _ in range(50):
        axis.step()
    notes = StateNotes(axis, Outside())
    for _ in notes.survey():
        pass
    noted = notes.note()
    assert noted is not None
    text = b"".join(notes.tell(noted))
    again = SingleAxis(limits, 0.001)
    restore(again, text, Outside())
    assert [again.step() for _ in range(300)] == [axis.step() for _ in range(300)]
    for module in ("os", "runtime.diagnostics.errors.os", "subprocess"):
        with pytest.raises((StateError, ModuleNotFoundError)):
            restore(axis, text.replace(b'"runtime.cnc.axes.single_axis"', f'"{module}"'.encode()), Outside())
    with pytest.raises(StateError, match="no class"):
        restore(axis, text.replace(b'"SingleAxis"', b'"plan_speed"'), Outside())
    with pytest.raises(StateError, match="too large"):
        list(StateNotes([np.zeros(1_000_000)], Outside()).survey())
