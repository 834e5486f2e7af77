"""Spindles of the whole machine: they turn, stand at angles, and the path waits for them as configured."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from runtime.cnc.axes.spindle import TURN
from runtime.config.channel.parameters import ChannelSpindle
from runtime.config.machine import Drive, Machine
from runtime.diagnostics.events import Event, EventKind
from runtime.hli.layout import StopCondition
from runtime.scheduler.simulation import Simulation
from tests.machine.scripted_plc import Key, ScriptedPlc

S, M = 3, 1
Write = Callable[[str], Path]
REV = 6.0  # degrees/s per rev/min


def machine_with(demo: Machine, first: Mapping[str, str], **parameters: object) -> Machine:
    """The demo machine with a second spindle, S2 on node 7; `first` are the synchronisation types of its own one."""
    own = demo.axes[3]
    assert own.drive is not None
    second = own.model_copy(update={"name": "S2", "log_axis": 11, "drive": Drive(node=7, increments_per_unit=100.0)})
    channel = demo.channels[0]
    types = {"s_synch": "MOS", "m3_synch": "MOS", "m4_synch": "MOS", "m5_synch": "MOS", "m19_synch": "MOS"}
    spindles = (
        ChannelSpindle(bezeichnung="S", **{**types, **first}),  # type: ignore[arg-type]
        ChannelSpindle(bezeichnung="S2", **types),  # type: ignore[arg-type]
    )
    changed = channel.model_copy(
        update={"parameters": channel.parameters.model_copy(update={"spindel": spindles, **parameters})}
    )
    return demo.model_copy(update={"channels": (changed,), "axes": (*demo.axes, second)})


class Run:
    """A program, cycle by cycle."""

    def __init__(
        self,
        machine: Machine,
        program: Path,
        delays: Mapping[Key, float | None] | None = None,
        *,
        ideal: bool = True,
    ) -> None:
        self.simulation = Simulation(
            machine, ideal_axes=ideal, partner=lambda memory: ScriptedPlc(memory, delays or {})
        )
        self.hli = self.simulation.memory.hli
        self.channel = self.simulation.controller.channel
        self.path = self.simulation.controller.interpolator
        self.spindles = self.channel.spindles
        self.image = self.simulation.drives.image
        assert self.simulation.run_until(self.simulation.ready, 20.0)
        self.simulation.start(program)
        for _ in range(3):
            self.simulation.cycle()

    @property
    def x(self) -> float:
        return float(self.path.position[0])

    def until(self, condition: Callable[[], bool], limit: float = 10.0) -> None:
        waits = StopCondition(self.channel.stop_condition)
        assert self.simulation.run_until(condition, limit), f"{waits!r} {self.simulation.problems}"

    def finish(self) -> None:
        self.until(lambda: not self.channel.active)

    def speed(self, spindle: int) -> float:
        """Measured, rev/min."""
        return float(self.image.actual_velocity[3 + spindle]) / REV

    def angle(self, spindle: int) -> float:
        """Measured, 0…360."""
        return float(self.image.actual_position[3 + spindle]) % TURN

    def events(self, kind: EventKind, number: int) -> list[Event]:
        return [e for e in self.simulation.log if e.kind is kind and e.number == number]


@pytest.mark.spec("isg.spdl.m19-pos", "isg.spdl.mfct-sync", "chan.spindle.sync", "hli.sp.status")
@pytest.mark.parametrize("ideal", [True, False])
@pytest.mark.parametrize("before", ["S600", "S600 M3", "S3000 M4"])
def test_m19_brings_the_spindle_to_its_angle_before_the_path_goes_on(
    demo: Machine, program: Write, before: str, ideal: bool
) -> None:
    machine = machine_with(demo, {"m3_synch": "MVS_SVS", "m4_synch": "MVS_SVS", "m19_synch": "MVS_SVS"})
    text = f"%T\n{before}\nM19 S.POS=90\nG90 G01 F6000 X10\nM30\n"
    run = Run(machine, program(text), ideal=ideal)
    run.until(lambda: run.x > 0.0)
    assert run.angle(0) == pytest.approx(90.0, abs=1.0)
    assert abs(run.speed(0)) <= 10.0
    run.finish()
    assert run.angle(0) == pytest.approx(90.0, abs=0.1)
    assert run.hli.axes[3].spindle.mode_r == 8
    assert run.hli.axes[3].spindle.rev_erreicht_r
    (acknowledged,) = run.events(EventKind.S_ACK, 19)
    assert acknowledged.path_pos == 0.0


@pytest.mark.spec("isg.spdl.m19-pos", "isg.spdl.specific-m19")
@pytest.mark.parametrize(("words", "sign"), [("M19", -1), ("M19 M3", 1), ("M19 M4", -1)])
def test_from_standstill_the_shorter_way_or_the_sense_that_is_programmed(
    demo: Machine, program: Write, words: str, sign: int
) -> None:
    run = Run(machine_with(demo, {"m19_synch": "MNS_SNS"}), program(f"%T\nS60 S.POS=270 {words}\nM30\n"))
    turned: list[float] = []
    while run.channel.active:
        run.simulation.cycle()
        turned.append(run.spindles[0].set_point)
    assert {v > 0.0 for v in turned if abs(v) > 1.0} == {sign > 0}
    assert run.angle(0) == pytest.approx(270.0, abs=0.1)


@pytest.mark.spec("isg.spdl.specific-m3-m4-m5", "isg.spdl.config", "isg.spdl.main-spindle-change")
def test_two_spindles_turn_on_their_own_and_over_the_program_end(demo: Machine, program: Write) -> None:
    text = "%T\nS[M3 REV1000] S2[M4 REV500]\n#MAIN SPINDLE [S2]\nS700\nG90 G01 F600 X10\nM30\n"
    run = Run(machine_with(demo, {}), program(text))
    run.finish()
    assert run.speed(0) == pytest.approx(1000.0)
    assert run.speed(1) == pytest.approx(-700.0)


@pytest.mark.spec("isg.spdl.override-g167", "isg.spdl.specific-g167", "isg.spdl.override-prog", "hli.sp.cu.override")
def test_overrides_multiply_and_g167_takes_the_external_one_away(demo: Machine, program: Write) -> None:
    text = (
        "%T\nM3 S1000\nS2[OVERRIDE SPEED_FACT=20]\nS2[M3 REV1000]\nG04 1\nM00\nG167 S1\nS2[G167 REV1000]\nG04 1\nM00\nS3000\n"
        "S2[REV2000]\nG04 1\nM00\nM30\n"
    )
    run = Run(machine_with(demo, {}), program(text))
    for axis in (3, 4):
        unit = run.hli.axes[axis].control
        unit.override.enable_w, unit.override.command_w = True, 500

    def speeds() -> list[float]:
        run.until(lambda: bool(run.channel.stop_condition & StopCondition.WAIT_CONTINUE))
        told = [run.speed(0), run.speed(1)]
        run.hli.operator[0].continue_motion_rw = True
        run.until(lambda: not run.channel.stop_condition & StopCondition.WAIT_CONTINUE)
        return told

    assert speeds() == pytest.approx([500.0, 100.0])
    assert speeds() == pytest.approx([1000.0, 200.0])
    assert speeds() == pytest.approx([1500.0, 200.0])


@pytest.mark.spec("isg.spdl.acc-g130")
def test_acceleration_is_weighted_until_it_is_set_again(demo: Machine, program: Write) -> None:
    def time(first: str) -> float:
        text = f"%T\n{first}\nS10000 M3\nM30\n"
        run = Run(machine_with(demo, {"m3_synch": "MNS_SNS"}), program(text))
        run.finish()
        (out,), (ack,) = run.events(EventKind.S_OUT, 3), run.events(EventKind.S_ACK, 3)
        return ack.t - out.t

    full, half, again = time(""), time("S[G130=50]"), time("S[G130=50]\nS[G130=100]")
    # 10000 rev/min at 12000 instead of 24000 rev/min/s; the time in which the acceleration builds up stays
    assert half == pytest.approx(full + 10_000 / 24_000, abs=0.005)
    assert again == pytest.approx(full, abs=0.002)


@pytest.mark.spec("isg.spdl.late-sync-implicit", "chan.mh.mvs-slm")
def test_a_late_m3_is_waited_for_where_machining_begins(demo: Machine, program: Write) -> None:
    text = "%T\nG00 M03 S12000 X20\nX40\nG01 F6000 X60\nM30\n"
    run = Run(machine_with(demo, {"m3_synch": "MVS_SLM"}), program(text))
    run.until(lambda: run.x >= 40.0 and run.path.standstill)
    assert run.speed(0) < 11_000.0
    assert run.channel.stop_condition & StopCondition.WAIT_SPINDLE
    run.until(lambda: run.x > 40.0)
    assert run.speed(0) >= 11_700.0
    run.finish()


@pytest.mark.spec("isg.spdl.mfct-sync", "hli.tech.s-data")
def test_with_plc_info_both_have_to_be_ready(demo: Machine, program: Write) -> None:
    machine = machine_with(
        demo,
        {"m3_synch": "MVS_SVS | PLC_INFO"},
    )
    run = Run(machine, program("%T\nS1000 M3\nG90 G01 F6000 X10\nM30\n"), {(S, 3): 0.5})
    run.until(lambda: run.spindles[0].reached(run.speed(0) * REV))
    unit = run.hli.axes[3].techno_unit_std_sync[0]
    assert (unit.fkt_ctrl_r, unit.number_r, unit.revolutions_r) == (S, 3, 6_000_000)
    assert run.channel.stop_condition & StopCondition.WAIT_TECHNOLOGY
    run.finish()
    (out,), (ack,) = run.events(EventKind.S_OUT, 3), run.events(EventKind.S_ACK, 3)
    assert ack.t - out.t == pytest.approx(0.5, abs=0.01)


@pytest.mark.spec("hli.sp.plc-spindle", "chan.spindle.plc")
def test_a_spindle_of_the_plc_is_acknowledged_by_it_alone(demo: Machine, program: Write) -> None:
    machine = machine_with(demo, {})
    channel = machine.channels[0]
    first = channel.parameters.spindel[0].model_copy(update={"plc_control": True, "m3_synch": "MVS_SVS"})
    spindles = (first, channel.parameters.spindel[1])
    changed = channel.model_copy(update={"parameters": channel.parameters.model_copy(update={"spindel": spindles})})
    machine = machine.model_copy(update={"channels": (changed,)})
    run = Run(machine, program("%T\nS1000 M3\nG90 G01 F6000 X10\nM30\n"), {(S, 3): 0.3})
    run.finish()
    assert run.speed(0) == 0.0  # nobody but the PLC moves it
    unit = run.hli.channels[0].techno_unit_std_sync[0]
    assert (unit.fkt_ctrl_r, unit.number_r, unit.spindle_r) == (S, 3, 6)
    (out,), (ack,) = run.events(EventKind.S_OUT, 3), run.events(EventKind.S_ACK, 3)
    assert ack.t - out.t == pytest.approx(0.3, abs=0.01)


@pytest.mark.spec("isg.spdl.homing-g74", "isg.spdl.specific-g74")
def test_homing_does_not_keep_the_program_waiting(demo: Machine, program: Write) -> None:
    run = Run(machine_with(demo, {"m3_synch": "MVS_SVS"}), program("%T\nS6000 M3\nS[G74]\nG90 G01 F6000 X1\nM30\n"))
    run.until(lambda: run.x > 0.0)
    assert run.speed(0) > 100.0
    run.until(lambda: run.speed(0) == 0.0)
    run.finish()


def test_a_reset_stops_every_spindle_also_on_its_way_to_an_angle(demo: Machine, program: Write) -> None:
    text = "%T\nS2[M3 REV3000]\nS3000 M3\nG04 1\nM19 S.POS=10\nG04 10\nM30\n"
    run = Run(machine_with(demo, {}), program(text))
    run.until(lambda: bool(run.events(EventKind.SPINDLE, 19)))
    run.hli.operator[0].reset_rw = True
    run.until(lambda: run.speed(0) == 0.0 and run.speed(1) == 0.0, 2.0)
    assert run.hli.axes[3].spindle.mode_r == 1
