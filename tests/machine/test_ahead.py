"""Functions ahead of their place and inside a cycle: where and when exactly, overlap, tolerance, way and time to go."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest

from runtime.config.channel.parameters import Configuration, PathPreparationConfiguration
from runtime.config.machine import Machine
from runtime.diagnostics.events import Event, EventKind
from runtime.hli.memory import HliMemory
from runtime.hli.technology import TechnologyTaker
from runtime.scheduler.simulation import Simulation
from tests.machine.scripted_plc import Key, ScriptedPlc

M = 1
Write = Callable[[str], Path]
Setting = tuple[str, int]  # synchronisation type, lead in 0.1 µm or µs


def machine_with(demo: Machine, functions: Mapping[int, Setting], *, every: int = 4, **parameters: object) -> Machine:
    channel = demo.channels[0]
    update = {
        "m_synch": {**channel.parameters.m_synch, **{number: synch for number, (synch, _) in functions.items()}},
        "m_pre_outp": {number: lead for number, (_, lead) in functions.items() if lead},
        **parameters,
    }
    changed = channel.model_copy(update={"parameters": channel.parameters.model_copy(update=update)})
    return demo.model_copy(update={"channels": (changed,), "plc": demo.plc.model_copy(update={"every": every})})


class Run:
    """A program to its end; x and time of every cycle."""

    def __init__(
        self,
        machine: Machine,
        program: Path,
        delays: Mapping[Key, float | None] | None = None,
        *,
        plc: type[ScriptedPlc] = ScriptedPlc,
        override: float = 100.0,
    ) -> None:
        self.simulation = Simulation(machine, ideal_axes=True, partner=lambda memory: plc(memory, delays or {}))
        simulation = self.simulation
        self.hli = simulation.memory.hli
        self.hli.operator[0].override_w = round(override * 10)
        self.path = simulation.controller.interpolator
        self.status = self.hli.channels[0].status
        self.x: list[float] = []
        self.time: list[float] = []
        self.to_go: list[tuple[float, float]] = []
        assert simulation.run_until(simulation.ready, 20.0)
        simulation.start(program)
        for _ in range(30_000):
            simulation.cycle()
            self.x.append(float(self.path.position[0]))
            self.time.append(simulation.controller.time)
            self.to_go.append((self.status.techno_path_to_go_r * 1e-4, self.status.techno_time_to_go_r * 1e-6))
            if self.status.wait_continue_r and len(self.x) % 100 == 0:
                self.hli.operator[0].continue_motion_rw = True
            if len(self.x) > 3 and not simulation.controller.channel.active:
                break

    def out(self, number: int) -> Event:
        (event,) = [e for e in self.simulation.log if e.kind is EventKind.M_OUT and e.number == number]
        return event

    def when(self, x: float) -> float:
        """The time at which the path was at x, between two cycles by straight interpolation."""
        k = int(np.argmax(np.array(self.x) >= x - 1e-9))
        before, after = self.x[k - 1], self.x[k]
        share = (x - before) / (after - before) if after > before else 1.0
        return self.time[k - 1] + share * (self.time[k] - self.time[k - 1])

    @property
    def alarms(self) -> list[int]:
        return [problem.entry.id for problem in self.simulation.problems]


CRUISING = "%T\nG90 G01 F6000 X10\nX20\nX30\nX40\nM96\nX80\nX100\nM30\n"


@pytest.mark.spec("chan.mh.mep-met-mos", "chan.mh.pre-output-values")
@pytest.mark.parametrize("override", [100.0, 37.0])
def test_a_way_ahead_is_kept_to_one_cycle_over_block_borders(demo: Machine, program: Write, override: float) -> None:
    run = Run(machine_with(demo, {96: ("MEP_MOS", 250_000)}), program(CRUISING), override=override)
    assert 0.0 <= run.out(96).path_pos - 15.0 <= 0.1 * override / 100.0 + 1e-9


@pytest.mark.spec("chan.mh.mep-met-mos")
@pytest.mark.parametrize("override", [100.0, 37.0])
def test_a_time_ahead_is_kept_to_one_cycle(demo: Machine, program: Write, override: float) -> None:
    run = Run(machine_with(demo, {96: ("MET_MOS", 100_000)}), program(CRUISING), override=override)
    assert run.when(40.0) - run.out(96).t == pytest.approx(0.1, abs=0.0011)


@pytest.mark.spec("chan.mh.mep-met-svs", "chan.mh.pre-output-time-model")
@pytest.mark.parametrize("mode", [False, True])
@pytest.mark.parametrize("lead", [20_000, 120_000])
def test_a_time_ahead_of_a_stop_counts_the_braking(demo: Machine, program: Write, lead: int, mode: bool) -> None:
    machine = machine_with(demo, {96: ("MET_SVS", lead)}, m_h_pre_outp_time_calc_mode=mode)
    run = Run(machine, program(CRUISING), {(M, 96): 0.5})
    k = int(np.argmax(np.array(run.x) >= 40.0 - 1e-9))  # it stands there
    assert run.time[k] - run.out(96).t == pytest.approx(lead * 1e-6, abs=0.0021)


@pytest.mark.spec("chan.mh.mep-met-svs")
def test_acknowledged_before_its_place_it_costs_nothing(demo: Machine, program: Write) -> None:
    plain = Run(machine_with(demo, {96: ("NO_SYNCH", 0)}), program(CRUISING))
    early = Run(machine_with(demo, {96: ("MEP_SVS", 250_000)}), program(CRUISING), {(M, 96): 0.05})
    assert early.time[-1] == pytest.approx(plain.time[-1], abs=1e-9)


@pytest.mark.spec("chan.mh.range-overlap", "chan.mh.mep-met-svs")
def test_functions_of_different_blocks_keep_their_order(demo: Machine, program: Write) -> None:
    """The second would be due at 15, but not before the first, which is due at 35."""
    machine = machine_with(demo, {95: ("MEP_SVS", 50_000), 96: ("MEP_SVS", 450_000)})
    run = Run(machine, program("%T\nG90 G01 F6000 X20\nX40\nM95\nX60\nM96\nX80\nM30\n"))
    assert 0.0 <= run.out(95).path_pos - 35.0 <= 0.11
    assert run.out(96).t == run.out(95).t
    order = [e.number for e in run.simulation.log if e.kind is EventKind.M_OUT and e.number in (95, 96)]
    assert order == [95, 96]


@pytest.mark.spec("chan.mh.range-overlap")
def test_functions_of_one_block_are_independent(demo: Machine, program: Write) -> None:
    machine = machine_with(demo, {95: ("MEP_SVS", 50_000), 96: ("MEP_SVS", 250_000)})
    run = Run(machine, program("%T\nG90 G01 F6000 X20\nX40\nM95 M96\nX80\nM30\n"))
    assert 0.0 <= run.out(96).path_pos - 15.0 <= 0.11
    assert 0.0 <= run.out(95).path_pos - 35.0 <= 0.11


@pytest.mark.spec("chan.mh.pre-output-tolerance")
@pytest.mark.parametrize(("tolerance", "alarms"), [(0, []), (1, [120815]), (49_000, [120815]), (51_000, [])])
def test_a_lead_longer_than_the_path_is_a_deviation(
    demo: Machine, program: Write, tolerance: int, alarms: list[int]
) -> None:
    """15 mm ahead of a place that is 10 mm away from the start."""
    machine = machine_with(demo, {96: ("MEP_MOS", 150_000)}, pre_output_tolerance=tolerance)
    run = Run(machine, program("%T\nG90 G01 F6000 X10\nM96\nX40\nM30\n"))
    assert run.alarms == alarms
    if not alarms:
        assert run.out(96).path_pos <= 0.1
    else:
        assert run.x[-1] < 10.0


@pytest.mark.spec("chan.mh.pre-output-tolerance")
def test_the_length_of_a_cycle_is_no_deviation(demo: Machine, program: Write) -> None:
    run = Run(machine_with(demo, {96: ("MEP_MOS", 250_000)}, pre_output_tolerance=1), program(CRUISING))
    assert run.alarms == []
    assert run.x[-1] == pytest.approx(100.0)


@pytest.mark.spec("chan.mh.path-to-go")
def test_way_and_time_to_the_place_are_told_once_it_is_out(demo: Machine, program: Write) -> None:
    machine = machine_with(demo, {96: ("MEP_SVS", 250_000)}, m_h_pre_outp_calc_value_to_go=True)
    run = Run(machine, program(CRUISING), {(M, 96): 0.02})
    x = np.array(run.x)
    way, seconds = np.array(run.to_go).T
    told = (x >= 16.0) & (x < 39.9)
    assert way[told] == pytest.approx(40.0 - x[told], abs=1e-4)
    cruise = (x >= 18.0) & (x < 39.9)  # the stop is lifted 20 ms after the output
    assert seconds[cruise] == pytest.approx((40.0 - x[cruise]) / 100.0, abs=1e-3)
    assert not way[x < 14.9].any()
    assert not way[x > 40.2].any()


@pytest.mark.spec("chan.mh.path-to-go")
def test_the_next_place_waits_until_the_present_one_is_passed(demo: Machine, program: Write) -> None:
    machine = machine_with(
        demo, {95: ("MEP_MOS", 100_000), 96: ("MEP_MOS", 300_000)}, m_h_pre_outp_calc_value_to_go=True
    )
    run = Run(machine, program("%T\nG90 G01 F6000 X20\nX40\nM95\nX60\nM96\nX80\nM30\n"))
    assert 0.0 <= run.out(95).path_pos - 30.0 <= 0.11
    assert 0.0 <= run.out(96).path_pos - 40.0 <= 0.21


@pytest.mark.spec("chan.mh.lookahead-blocks")
@pytest.mark.parametrize(("blocks", "earliest"), [(50, 5.0), (150, 0.0)])
def test_only_so_many_blocks_are_searched(demo: Machine, program: Write, blocks: int, earliest: float) -> None:
    """The place is 101 blocks of 0.1 mm away; a lead of 10.1 mm is seen at the start, or 50 blocks before the place."""
    machine = machine_with(demo, {96: ("MEP_MOS", 101_000)}, m_h_pre_outp_nbr_block=blocks)
    moves = "\n".join(f"X{0.1 * k:.1f}" for k in range(1, 102))
    run = Run(machine, program(f"%T\nG90 G01 F600\n{moves}\nM96\nX40\nM30\n"))
    assert earliest - 0.11 <= run.out(96).path_pos <= earliest + 0.25


def test_times_behind_a_stop_of_unknown_length_are_not_foreseen(demo: Machine, program: Write) -> None:
    """M00 stands between: put out when the path goes on, not while the operator thinks."""
    machine = machine_with(demo, {96: ("MET_MOS", 200_000)})
    run = Run(machine, program("%T\nG90 G01 F6000 X20\nM00\nX25\nM96\nX40\nM30\n"))
    assert run.out(96).t > run.time[int(np.argmax(np.array(run.x) > 20.0))] - 0.002


class EachCycle(ScriptedPlc):
    """Takes in every cycle and keeps the offset of what it took, with the cycle."""

    taken_at: list[tuple[int, int, int]]

    def __init__(self, memory: HliMemory, delays: Mapping[Key, float | None]) -> None:
        super().__init__(memory, delays)
        self.offsets: list[tuple[int, int]] = []  # number, µs
        self.probe = TechnologyTaker(memory.hli.channels[0])

    def wake(self, time: float) -> None:
        self.offsets += [
            (int(u.number_r), int(u.time_r)) for u in self.hli.channels[0].techno_unit_std_sync if u.please_rw
        ]
        super().wake(time)


@pytest.mark.spec("chan.mh.mos-ts", "hli.tech.mos-ts")
@pytest.mark.parametrize("place", [20.0, 20.037, 3.21, 97.0])
def test_the_offset_in_the_cycle_is_that_of_the_path(demo: Machine, program: Write, place: float) -> None:
    """Against the position set-points: where they are steady they are a straight line, to 1 µs."""
    machine = machine_with(demo, {97: ("MOS_TS", 0)}, every=1)
    text = f"%T\nG90 G01 F6000 X{place}\nX{place + 5} M97\nX{place + 30}\nM30\n"
    run = Run(machine, program(text), plc=EachCycle)
    plc = run.simulation.plc
    assert isinstance(plc, EachCycle)
    ((_, offset),) = [entry for entry in plc.offsets if entry[0] == 97]
    event = run.out(97)
    k = run.time.index(event.t)  # the set-point of this cycle is reached at its end
    begin, end = run.x[k - 1], run.x[k]
    assert begin <= place <= end
    # speed at the borders of the cycle by central differences, so a ramp counts too
    v0, v1 = (run.x[k] - run.x[k - 2]) / 0.002, (run.x[k + 1] - run.x[k - 1]) / 0.002
    t = offset * 1e-6
    reached = begin + v0 * t + (v1 - v0) * t * t / 0.002
    assert abs(reached - place) <= max(v0, v1) * 2e-6


@pytest.mark.spec("chan.mh.mos-ts")
def test_an_axis_gets_no_offset(demo: Machine, program: Write) -> None:
    machine = machine_with(demo, {97: ("MOS_TS", 0)}, every=1, m_default_outp_ax_name={97: "X"})
    run = Run(machine, program("%T\nG90 G01 F6000 X20\nX25 M97\nX40\nM30\n"), plc=EachCycle)
    unit = run.hli.axes[0].techno_unit_std_sync[0]
    assert (unit.number_r, unit.time_r, unit.fkt_ctrl_r) == (97, 0, M)
    assert unit.please_rw is False


@pytest.mark.spec("cut.microjoint.pre-output", "chan.mh.microjoint", "cut.microjoint.enable")
@pytest.mark.parametrize("synch", ["MOS_TS", "MVS_SVS"])
def test_a_micro_joint_is_put_out_within_a_block_on_the_machine(demo: Machine, program: Write, synch: str) -> None:
    configuration = Configuration(
        path_preparation=PathPreparationConfiguration(function="FCT_DEFAULT|FCT_M_PRE_OUTPUT")
    )
    machine = machine_with(demo, {100: (synch, 250_000), 26: ("MOS", 0)}, configuration=configuration)
    run = Run(machine, program("N10 G01 X40 F3000\nN20 M100 M26\nN30 X80\nM30"), {(M, 100): 0.1})
    assert not run.alarms
    out, on = run.out(100), run.out(26)
    assert out.path_pos == pytest.approx(15.0, abs=0.06)
    assert on.path_pos == pytest.approx(40.0, abs=0.06)
    rests = [x for x in np.unique(np.round(run.x, 6)) if 0.5 < x < 79.5 and run.x.count(x) > 50]
    assert rests == ([15.0] if synch == "MVS_SVS" else []), "MVS_SVS is waited for where it was put out"
