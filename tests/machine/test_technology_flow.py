"""What functions cost, and what becomes of them at the end of a program, with a stop of decoding, for H and T."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from runtime.cnc.blocks import Synch
from runtime.cnc.technology import Travel, synch_in
from runtime.config.machine import Machine
from runtime.diagnostics.events import Event, EventKind
from runtime.hli.technology import TechnologyTaker
from runtime.scheduler.simulation import Simulation
from tests.machine.scripted_plc import Key, ScriptedPlc

M, H, T = 1, 2, 4
Write = Callable[[str], Path]


def machine_with(demo: Machine, functions: Mapping[int, str], **parameters: object) -> Machine:
    channel = demo.channels[0]
    update = {"m_synch": {**channel.parameters.m_synch, **functions}, **parameters}
    changed = channel.model_copy(update={"parameters": channel.parameters.model_copy(update=update)})
    return demo.model_copy(update={"channels": (changed,)})


class Run:
    def __init__(self, machine: Machine, delays: Mapping[Key, float | None]) -> None:
        self.simulation = Simulation(machine, ideal_axes=True, partner=lambda memory: ScriptedPlc(memory, delays))
        self.channel = self.simulation.controller.channel
        self.hli = self.simulation.memory.hli
        assert self.simulation.run_until(self.simulation.ready, 20.0)

    def program(self, path: Path) -> None:
        """Start it, and run to its end."""
        self.start(path)
        assert self.simulation.run_until(lambda: not self.channel.active, 10.0)

    def start(self, path: Path) -> None:
        self.simulation.start(path)
        for _ in range(3):
            self.simulation.cycle()

    def events(self, kind: EventKind, number: int) -> list[Event]:
        return [e for e in self.simulation.log if e.kind is kind and e.number == number]

    @property
    def plc(self) -> ScriptedPlc:
        assert isinstance(self.simulation.plc, ScriptedPlc)
        return self.simulation.plc


@pytest.mark.spec("chan.mh.mvs-svs", "hli.tech.sync-kinds")
def test_output_acknowledgement_and_going_on_take_two_plc_cycles_and_a_base_cycle(
    demo: Machine, program: Write
) -> None:
    run = Run(machine_with(demo, {110: "MVS_SVS"}), {})
    text = "%T\nG90 G01 F6000\n" + "\n".join(f"X{x} M110" for x in range(2, 42, 2)) + "\nM30\n"
    run.start(program(text))
    x: list[float] = []
    first = run.simulation.controller.cycle_number + 1
    while run.channel.active:
        run.simulation.cycle()
        x.append(float(run.channel.interpolator.position[0]))
    most = 2 * run.simulation.machine.plc.every + 1
    outs = run.events(EventKind.M_OUT, 110)
    assert len(outs) == 20
    for out in outs:
        here = out.cycle - first
        moving = next(k for k in range(here + 1, len(x)) if x[k] != x[here])
        assert moving - here <= most


@pytest.mark.spec("chan.mh.mos", "hli.tech.unit")
def test_what_the_plc_has_not_taken_outlives_the_program_end(demo: Machine, program: Write) -> None:
    run = Run(machine_with(demo, {110: "MOS", 111: "MOS"}), {})
    run.program(program("%T\nM110 M111\nM30\n"))
    for _ in range(10):
        run.simulation.cycle()
    assert run.plc.taken == [(M, 110), (M, 111)]


@pytest.mark.spec("chan.mh.late-sync-program-end", "hli.tech.late-sync", "chan.mh.mvs-slm")
def test_late_functions_stay_open_for_the_next_program(demo: Machine, program: Write) -> None:
    run = Run(machine_with(demo, {110: "MVS_SLM"}), {(M, 110): 1.0})
    run.program(program("%T\nM110\nG00 X10\nM30\n"))
    assert not run.events(EventKind.M_ACK, 110)
    area = run.hli.channels[0]
    assert area.used_units_late_sync_r == 1
    assert (area.techno_unit_late_sync[0].number_r, area.techno_unit_late_sync[0].nr_late_sync_r) == (110, 1)
    run.start(program("%T\nG00 X20\nG01 F6000 X40\nM30\n"))
    assert run.simulation.run_until(lambda: float(run.channel.interpolator.position[0]) > 20.0, 5.0)
    assert len(run.events(EventKind.M_ACK, 110)) == 1
    assert area.used_units_late_sync_r == 0


@pytest.mark.spec("chan.mh.late-sync-program-end")
def test_or_the_program_end_waits_for_them(demo: Machine, program: Write) -> None:
    start = demo.channels[0].parameters.prog_start.model_copy(update={"late_sync_ready": True})
    run = Run(machine_with(demo, {110: "MVS_SLP"}, prog_start=start), {(M, 110): 1.0})
    run.program(program("%T\nM110\nG00 X10\nM30\n"))
    assert len(run.events(EventKind.M_ACK, 110)) == 1


@pytest.mark.spec("hli.tech.late-sync")
def test_late_functions_leave_the_units_of_the_blocks_alone(demo: Machine, program: Write) -> None:
    run = Run(machine_with(demo, {110: "MVS_SLP", 111: "MVS_SVS"}), {(M, 110): None})
    blocks = "\n".join(["M110"] * 5 + ["M111"] * 40)
    run.program(program(f"%T\n{blocks}\nM30\n"))
    assert run.plc.taken == [(M, 110)] * 5 + [(M, 111)] * 40
    assert run.hli.channels[0].used_units_late_sync_r == 5


@pytest.mark.spec("chan.mh.faw-sync")
def test_decoding_goes_on_when_everything_is_done(demo: Machine, program: Write) -> None:
    """A value that the PLC program changes in its answer is read behind the block with the function, not before."""
    run = Run(machine_with(demo, {110: "MVS_SNS | FAW_SYNCH", 111: "MVS_SNS"}), {(M, 110): 0.4, (M, 111): 0.4})

    def decoded_early(number: int) -> bool:
        """The next block is in the queue while the function is still open."""
        run.start(program(f"%T\nG90 G01 F6000 X10 M{number}\nX20\nX0\nM30\n"))
        assert run.simulation.run_until(lambda: bool(run.events(EventKind.M_OUT, number)), 5.0)
        for _ in range(200):
            run.simulation.cycle()
        early = not run.events(EventKind.M_ACK, number) and run.channel.queue.capacity - run.channel.queue.free > 3
        assert run.simulation.run_until(lambda: not run.channel.active, 10.0)
        return early

    assert decoded_early(111)
    assert not decoded_early(110)


@pytest.mark.spec("chan.mh.h-functions", "hli.tech.mh-data", "chan.mh.process-times")
def test_h_functions_are_as_m_functions(demo: Machine, program: Write) -> None:
    update = {"h_synch": {50: "MNS_SNS", 51: "MEP_MOS"}, "h_pre_outp": {51: 50_000}, "h_prozess_zeit": {50: 7000}}
    run = Run(machine_with(demo, {}, **update), {(H, 50): 0.3})
    run.program(program("%T\nG90 G01 F6000 X20 H50=-9\nX40\nH51\nX60\nM30\n"))
    (out,), (ack,) = run.events(EventKind.H_OUT, 50), run.events(EventKind.H_ACK, 50)
    assert out.path_pos == ack.path_pos == pytest.approx(20.0)
    unit = run.hli.channels[0].techno_unit_std_sync[0]
    assert (unit.fkt_ctrl_r, unit.number_r) == (H, 51)  # the unit has been used again
    (ahead,) = run.events(EventKind.H_OUT, 51)
    assert 0.0 <= ahead.path_pos - 35.0 <= 0.11


@pytest.mark.spec("hli.tech.mh-data", "hli.tech.t-data", "isg.mh.additive-value", "chan.tool.t-sync")
def test_the_data_of_a_unit(demo: Machine, program: Write) -> None:
    tool = demo.channels[0].parameters.tool.model_copy(update={"synch": "MNS_SNS", "prozess_zeit": 5000})
    run = Run(
        machine_with(demo, {110: "MVS_SVS"}, tool=tool, m_prozess_zeit={110: 2_000_000}), {(M, 110): 0.1, (T, 7): 0.1}
    )
    run.start(program("%T\nN10 G90 G01 F6000 X5 M110=-345\nN20 X10 T7\nM30\n"))
    unit = run.hli.channels[0].techno_unit_std_sync[0]
    assert run.simulation.run_until(lambda: unit.number_r == 110, 5.0)
    assert (unit.fkt_ctrl_r, unit.value_r, unit.time_r, unit.line_r, unit.block_number_r, unit.synch_r) == (
        M, -345, 2_000_000, 2, 10, int(Synch.MVS_SVS),
    )  # fmt: skip
    assert run.simulation.run_until(lambda: unit.number_r == 7, 5.0)
    assert (unit.fkt_ctrl_r, unit.time_r, unit.line_r, unit.synch_r) == (T, 5000, 3, int(Synch.MNS_SNS))
    (out,) = run.events(EventKind.T_OUT, 7)
    assert out.path_pos == pytest.approx(10.0)


@pytest.mark.spec("isg.mh.axis-specific-default", "hli.tech.axis-specific", "hli.mech.plc-present")
def test_an_axis_without_a_plc_answers_for_itself(demo: Machine, program: Write) -> None:
    """The PLC has logged on to the channel only: what goes to the axis is taken as done, what goes to the channel is not."""
    machine = machine_with(demo, {110: "MVS_SVS", 111: "MVS_SVS"}, m_default_outp_ax_name={110: "Z"})

    class ChannelOnly(ScriptedPlc):
        def wake(self, time: float) -> None:
            super().wake(time)
            self._takers = [TechnologyTaker(self.hli.channels[0])]
            for axis in self.hli.axes:
                axis.plc_present_w = False

    simulation = Simulation(machine, ideal_axes=True, partner=lambda memory: ChannelOnly(memory, {(M, 111): 0.5}))
    assert simulation.run_until(simulation.ready, 20.0)
    simulation.start(program("%T\nG90 G01 F6000 X10 M110\nX20 M111\nM30\n"))
    for _ in range(3):
        simulation.cycle()
    assert simulation.run_until(lambda: not simulation.controller.channel.active, 10.0)
    times = {e.number: e.t for e in simulation.log if e.kind is EventKind.M_ACK}
    outs = {e.number: e.t for e in simulation.log if e.kind is EventKind.M_OUT}
    assert times[110] - outs[110] <= 0.002
    assert times[111] - outs[111] == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize(
    ("synch", "backward", "simulated"),
    [
        (Synch.MVS_SNS | Synch.BWD_SYNCH, Synch.MVS_SVS | Synch.BWD_SYNCH, Synch.MOS | Synch.BWD_SYNCH),
        (Synch.MNS_SNS | Synch.FWD_SYNCH, Synch.MOS | Synch.FWD_SYNCH, Synch.MNS_SNS | Synch.FWD_SYNCH),
        (Synch.MOS | Synch.BWD_SYNCH | Synch.FWD_SYNCH, Synch.MVS_SVS | Synch.BWD_SYNCH | Synch.FWD_SYNCH,
         Synch.MOS | Synch.BWD_SYNCH | Synch.FWD_SYNCH),
        (Synch.MVS_SVS, Synch.MOS, Synch.MOS),
        (Synch.NO_SYNCH, Synch.NO_SYNCH, Synch.NO_SYNCH),
    ],
)  # fmt: skip
def test_the_type_that_counts_when_the_path_is_driven_otherwise(
    synch: Synch, backward: Synch, simulated: Synch
) -> None:
    assert synch_in(synch, Travel.FORWARD) == synch
    assert synch_in(synch, Travel.BACKWARD) == backward
    assert synch_in(synch, Travel.SIMULATED_FORWARD) == simulated
