"""MC_TouchProbe with the touch probe of a drive: the position of the edge itself, in coordinates of the axis."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.cnc.axes.job_probe import DRIVE_PROBES
from runtime.diagnostics.catalogue import axis_jobs as errors
from runtime.plc_logic.motion import MC_AbortTrigger, MC_MoveAbsolute, MC_TouchProbe
from tests.machine.beside_channel import TABLE, Rig

EDGE = 33.3337
PROBING = TABLE.replace("{node: 9,", f"{{node: 9, process_data: [probe_1_rising], simulated: {{probe: {EDGE}}},")


@pytest.fixture
def rig(tmp_path: Path) -> Rig:
    return Rig(tmp_path, ideal=False, table=PROBING)


def move(rig: Rig, position: float) -> None:
    run = MC_MoveAbsolute()
    rig.call("run", lambda p: run(p.axes["B"], True, Position=position, Velocity=90.0))
    rig.until(lambda: run.Done)
    rig.call("run", lambda p: run(p.axes["B"], False))
    rig.run(0.02)


def test_the_drive_latches_where_the_edge_was(rig: Rig) -> None:
    probe = MC_TouchProbe()
    rig.call("probe", lambda p: probe(p.axes["B"], True, TriggerInput=DRIVE_PROBES))
    rig.run(0.05)
    assert probe.Busy
    move(rig, 60.0)
    assert probe.Done
    assert probe.RecordedPosition == pytest.approx(EDGE, abs=1e-3)  # a cycle at this speed is 0.09 degrees
    assert rig.image.probe_function[rig.table] == 0
    again = MC_TouchProbe()
    rig.call("probe", lambda p: again(p.axes["B"], True, TriggerInput=DRIVE_PROBES))
    rig.run(0.2)
    assert again.Busy  # what was latched before does not count
    move(rig, 0.0)
    assert again.Busy  # a falling edge
    move(rig, 60.0)
    assert again.Done


def test_a_probe_that_is_aborted_is_switched_off(rig: Rig) -> None:
    probe, abort = MC_TouchProbe(), MC_AbortTrigger()
    rig.call("probe", lambda p: probe(p.axes["B"], True, TriggerInput=DRIVE_PROBES))
    rig.run(0.05)
    assert rig.image.probe_function[rig.table] != 0
    rig.call("abort", lambda p: abort(p.axes["B"], True))
    rig.run(0.05)
    assert rig.image.probe_function[rig.table] == 0
    assert not probe.Busy
    move(rig, 60.0)
    assert not probe.Done


@pytest.mark.parametrize(("number", "mode"), [(DRIVE_PROBES, 1), (DRIVE_PROBES + 1, 2)])
def test_a_probe_that_the_drive_does_not_exchange_is_refused(rig: Rig, number: int, mode: int) -> None:
    probe = MC_TouchProbe()
    rig.call("probe", lambda p: probe(p.axes["B"], True, TriggerInput=number, Mode=mode))
    rig.until(lambda: probe.Error, 1.0)
    assert probe.ErrorID == errors.JOB_NO_PROBE.id
