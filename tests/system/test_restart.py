"""What survives a restart of all processes, and starts that cannot succeed."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.diagnostics.catalogue import fieldbus, language, plc
from runtime.diagnostics.catalogue import machine as alarms
from runtime.fieldbus.simulator.encoder import EncoderFile
from runtime.hli.layout import State
from tests.system.running_machine import RunningMachine

MM = 10_000  # increments of the demo's drives


def test_positions_and_alarms_survive_a_restart_and_a_moved_axis_is_told(
    machine: RunningMachine, tmp_path: Path
) -> None:
    there = tmp_path / "there.nc"
    there.write_text("%THERE\nG54 G90 G00 X10 Y5 Z20\nM30\n")
    machine.start()
    machine.order(there)
    machine.wait_for(lambda: abs(machine.x() - 110 * MM) < 50, "the end position")
    machine.wait_for(lambda: machine.channel_state() is State.SELECTED, "the end of the program")
    machine.order(tmp_path / "none.nc")
    machine.wait_for(lambda: machine.has_alarm(language.FILE_MISSING.id), "the alarm")
    assert machine.stop() == 0, machine.log.read_text()

    encoders = EncoderFile(machine.state / "simulated-drives.json")
    encoders[2] += 7 * MM  # somebody pushes Y
    encoders.close()
    machine.start()
    machine.wait_for(lambda: machine.has_alarm(alarms.AXIS_MOVED.id), "the warning")
    (moved,) = [alarm for alarm in machine.alarms if alarm.id == alarms.AXIS_MOVED.id]
    assert moved.axis == 2
    assert moved.text == "axis Y stands at 92.000, at the end of the last run it stood at 85.000"
    (before,) = [alarm for alarm in machine.alarms if alarm.id == language.FILE_MISSING.id]
    assert not before.active
    assert "none.nc" in before.text
    assert before.time_ns < moved.time_ns
    assert machine.x() == pytest.approx(110 * MM, abs=50)

    there.write_text("%BACK\nG54 G90 G00 X0 Y0\nM30\n")
    machine.order(there)
    machine.wait_for(lambda: abs(machine.x() - 100 * MM) < 50, "the same zero offset as before")
    assert machine.stop() == 0


def test_a_node_that_is_missing_ends_the_start_by_name(machine: RunningMachine) -> None:
    text = machine.machine.read_text().replace(
        "heartbeat_timeout: 2 s", "heartbeat_timeout: 2 s\n    boot_timeout: 500 ms"
    )
    machine.machine.write_text(text)
    machine.start(drives=False)
    assert machine.process is not None
    assert machine.process.wait(60) == 1
    log = machine.log.read_text()
    assert f"{fieldbus.NODE_MISSING.id}: no answer on the bus within 0.5 s from node 1 (axis X), node 2" in log
    assert str(alarms.CYCLE_NOT_STARTED.id) in log
    assert "Traceback" not in log


@pytest.mark.parametrize(
    ("source", "number"),
    [
        (None, plc.PLC_MODULE_MISSING.id),
        ("class Bad(Program)\n", plc.PLC_SYNTAX.id),
        ("x = 1\n", plc.PLC_NO_PROGRAM.id),
    ],
)
def test_a_plc_program_that_cannot_be_loaded_is_told_and_nothing_starts(
    machine: RunningMachine, long_program: Path, tmp_path: Path, source: str | None, number: int
) -> None:
    if source is not None:
        (tmp_path / "bad_plc.py").write_text(source)
    machine.machine.write_text(machine.machine.read_text().replace("runtime.demo.plc:DemoMill", "bad_plc.py"))
    machine.start()
    machine.wait_for(lambda: machine.has_alarm(number), "the alarm")
    assert any("bad_plc.py" in alarm.text for alarm in machine.alarms)
    hli = machine.memory.hli
    machine.wait_for(lambda: all(hli.axes[i].status.ready_for_control_loop_on_r for i in range(4)), "the drives")
    order = hli.operator[0].order_w
    order.to_mode, order.to_state, order.parameter = 2, 4, str(long_program).encode()
    hli.operator[0].order_semaphor_rw = True
    machine.wait_for(lambda: not hli.operator[0].order_semaphor_rw, "the answer")
    assert machine.channel_state() is State.ERROR
    assert machine.x() == 0
    assert machine.stop() == 0
