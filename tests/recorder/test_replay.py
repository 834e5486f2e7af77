"""What is recorded is done again, bit by bit: with drives, faults, holds, a lost PLC. The recorder changes nothing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from runtime.config import load_machine
from runtime.config.loader import DEMO_MACHINE
from runtime.config.machine import Machine
from runtime.fieldbus.simulator.drive import Fault
from runtime.recorder.file import RecordingError, RecordingFile
from runtime.scheduler.replay import Replay, ReplayResult
from runtime.scheduler.simulation import Simulation
from tests.machine.driven import LONG_LINE
from tests.machine.test_determinism import assert_same

PART = (
    "%PART\nN10 G90 G17 G162 M20\nN20 S2000 M3\nN30 G00 X5 Y5 Z2\nN40 $FOR P1 = 1, 2, 1\nN50 G01 X[10 * P1] F4000\n"
    "N60 G03 X[10 * P1] Y5 I0 J2 F3000\nN70 G00 Z[P1] H12=P1\nN80 $ENDFOR\nN90 M5\nN100 M30\n"
)
MESSAGES = (
    '%TOLD\nN10 G90\n#MSG ["begin"]\nN20 G01 X20 F6000\nN30 V.E.parts = 3\nN40 #MSG SYN ["there"]\nN50 #FLUSH WAIT\n'
    "N70 G02 X40 Y0 I10 J0 F3000\nN80 #CONTOUR MODE [DEV PATH_DEV 0.1]\nN90 G61 X50 Y10\n"
    "N100 X60 Y0\nN110 G04 0.05\nN120 M30\n"
)


def replay(path: Path, machine: Machine, **options: object) -> ReplayResult:
    with RecordingFile(path) as file:
        return Replay(file, machine, **options).run()  # type: ignore[arg-type]


class Recorded:
    """A simulation with a recording, and what happens in it."""

    def __init__(self, machine: Machine, folder: Path, **options: object) -> None:
        self.machine = machine
        self.path = folder / "recording"
        self.program = folder / "program.nc"
        self.simulation = Simulation(machine, record=self.path, **options)  # type: ignore[arg-type]

    def start(self, text: str) -> None:
        self.program.write_text(text)
        assert self.simulation.run_until(self.simulation.ready, 20.0)
        self.simulation.start(self.program)

    def run(self, seconds: float) -> None:
        end = self.simulation.time + seconds
        self.simulation.run_until(lambda: self.simulation.time >= end, seconds + 1.0)

    def replayed(self) -> ReplayResult:
        self.simulation.close()
        result = replay(self.path, self.machine)
        assert result.difference is None, str(result.difference)
        assert result.cycles == self.simulation.controller.cycle_number
        return result


@pytest.mark.parametrize("ideal", [True, False])
def test_a_whole_program_is_done_again(demo: Machine, tmp_path: Path, ideal: bool) -> None:
    recorded = Recorded(demo, tmp_path, ideal_axes=ideal)
    recorded.program.write_text(PART)
    assert recorded.simulation.run_program(recorded.program).good
    recorded.replayed()


def test_a_recorded_machine_does_the_same_as_one_that_is_not(demo: Machine, tmp_path: Path) -> None:
    """The border changes nothing: the traces of both are the same bytes, and so is that of the replay, but for the blocks."""
    program = tmp_path / "part.nc"
    program.write_text(PART)
    for name, record in (("plain", None), ("recorded", tmp_path / "recording")):
        simulation = Simulation(demo, trace=tmp_path / name, record=record)
        simulation.close(simulation.run_program(program))
    assert_same(tmp_path / "plain", tmp_path / "recorded")
    assert replay(tmp_path / "recording", demo, trace=tmp_path / "replayed").same
    for name in ("events.jsonl", "samples.npz"):
        assert (tmp_path / "replayed" / name).read_bytes() == (tmp_path / "plain" / name).read_bytes()


def _fault(recorded: Recorded) -> None:
    recorded.simulation.nodes.inject(1, Fault.DRIVE)
    recorded.run(0.8)
    recorded.simulation.memory.hli.operator[0].reset_rw = True


def _feed_hold(recorded: Recorded) -> None:
    operator = recorded.simulation.memory.hli.operator[0]
    operator.feedhold_w = True
    recorded.run(0.5)
    operator.override_w = 430
    operator.feedhold_w = False


def _plc_killed(recorded: Recorded) -> None:
    partner = recorded.simulation.plc
    partner.frozen = True  # type: ignore[union-attr]
    recorded.run(0.6)
    partner.frozen = False  # type: ignore[union-attr]
    recorded.simulation.memory.hli.operator[0].reset_rw = True


@pytest.mark.parametrize("happens", [_fault, _feed_hold, _plc_killed])
def test_what_goes_wrong_goes_wrong_again(demo: Machine, tmp_path: Path, happens: Callable[[Recorded], None]) -> None:
    recorded = Recorded(demo, tmp_path)
    recorded.start(LONG_LINE)
    recorded.run(1.0)
    happens(recorded)
    recorded.run(1.0)
    assert bool(recorded.simulation.problems) == (happens is not _feed_hold)
    recorded.replayed()


def test_messages_variables_flushes_and_smoothing_come_through_the_border(tmp_path: Path) -> None:
    """And the recording brings its machine description along."""
    description = tmp_path / "machine.yaml"
    variables = "\nexternal_variables:\n- {name: parts, type: SGN32, access: read_write, synchronous: true}\nplc:"
    description.write_text(DEMO_MACHINE.read_text().replace("\nplc:", variables))
    recorded = Recorded(load_machine(description), tmp_path, ideal_axes=True, machine_file=description)
    recorded.program.write_text(MESSAGES)
    result = recorded.simulation.run_program(recorded.program)
    assert [event.text for event in result.events if event.text == "there"], result.problems
    recorded.simulation.close()
    description.unlink()
    with RecordingFile(recorded.path) as file:
        found = Replay(file).run()
    assert found.difference is None, str(found.difference)
    assert found.cycles == recorded.simulation.controller.cycle_number


def test_another_machine_parts_and_the_place_is_told(demo: Machine, tmp_path: Path) -> None:
    recorded = Recorded(demo, tmp_path, ideal_axes=True)
    recorded.program.write_text(PART)
    recorded.simulation.run_program(recorded.program)
    recorded.simulation.close()
    lazy = demo.axes[3].model_copy(update={"acceleration": 0.9 * demo.axes[3].acceleration})
    found = replay(recorded.path, demo.model_copy(update={"axes": (*demo.axes[:3], lazy)}))
    assert found.difference is not None
    assert (found.difference.area, found.difference.element) == ("drives", "target_position[3]")
    assert found.cycles == found.difference.cycle - 1


def test_a_changed_output_is_found_in_its_cycle(demo: Machine, tmp_path: Path) -> None:
    """One bit of one set-point in the recording: cycle, axis and both values are told."""
    from runtime.recorder.file import RecordingWriter
    from runtime.recorder.record import Section

    recorded = Recorded(demo, tmp_path, ideal_axes=True)
    recorded.program.write_text(PART)
    recorded.simulation.run_program(recorded.program)
    recorded.simulation.close()
    changed, cycle = tmp_path / "changed", 0
    with RecordingFile(recorded.path) as file:
        writer = RecordingWriter(changed, file.header)
        for chunk in file.chunks():
            words, at = chunk.words().copy(), 0
            while at < len(words):
                end, k = at + int(words[at]), at + 5
                while k < end and not cycle:
                    kind, count = int(words[k]) >> 32, int(words[k]) & 0xFFFFFFFF
                    if kind == Section.IMAGE_OUT and int(words[at + 1]) > 300 and int(words[k + 1]) >> 32 == 0:
                        words[k + 2] ^= 1  # the last bit of the set-point of X
                        cycle = int(words[at + 1])
                    k += 1 + count
                at = end
            writer.add(words)
        writer.close()
    found = replay(changed, demo).difference
    assert found is not None
    assert (found.cycle, found.area, found.element) == (cycle, "drives", "target_position[0]")
    then, now = float(found.recorded), float(found.replayed)
    assert then != now
    assert np.isclose(then, now, rtol=1e-15)


def test_a_recording_that_is_cut_off_is_replayed_up_to_there(demo: Machine, tmp_path: Path) -> None:
    recorded = Recorded(demo, tmp_path, ideal_axes=True)
    recorded.run(0.2)
    recorded.simulation.recording.flush()  # type: ignore[union-attr]
    recorded.run(0.2)
    assert recorded.replayed().cycles == 400
    data = recorded.path.read_bytes()
    recorded.path.write_bytes(data[: len(data) - 10])
    assert replay(recorded.path, demo).cycles == 200
    recorded.path.write_bytes(data[:5000])
    with pytest.raises(RecordingError, match="no cycle"):
        replay(recorded.path, demo)
    recorded.path.write_bytes(b"something else")
    with pytest.raises(RecordingError, match="no recording"):
        replay(recorded.path, demo)
