"""M, H, S and T functions at their place on the path, and the path waiting or not (channel parameters, lines 1823-2160)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest

from runtime.config.machine import Machine
from runtime.diagnostics.events import Event, EventKind
from runtime.scheduler import simulation
from runtime.scheduler.simulation import Result, Simulation
from tests.machine.scripted_plc import Key, ScriptedPlc

M = 1
SYNCH = {"NO_SYNCH": 101, "MOS": 102, "MVS_SVS": 103, "MVS_SNS": 104, "MNS_SNS": 105}
Write = Callable[[str], Path]


@pytest.fixture(scope="module")
def machine(demo: Machine) -> Machine:
    """The demo machine with an M function of every type: M101…M105."""
    channel = demo.channels[0]
    synch = {**channel.parameters.m_synch, **{number: name for name, number in SYNCH.items()}}
    parameters = channel.parameters.model_copy(update={"m_synch": synch})
    return demo.model_copy(update={"channels": (channel.model_copy(update={"parameters": parameters}),)})


class Run:
    """A program on the machine with a scripted PLC."""

    def __init__(self, machine: Machine, program: Path, delays: Mapping[Key, float | None]) -> None:
        self.simulation = Simulation(
            machine, ideal_axes=True, samples=True, partner=lambda memory: ScriptedPlc(memory, delays)
        )
        self.result: Result = self.simulation.run_program(program)
        assert self.simulation.samples is not None
        self.samples = self.simulation.samples.arrays()

    def event(self, kind: EventKind, number: int) -> Event:
        (event,) = [e for e in self.result.events if e.kind is kind and e.number == number]
        return event

    def standing_at(self, x: float) -> float:
        """Seconds at rest at X = x."""
        there = np.abs(np.asarray(self.samples["X"], dtype=float) - x) < 1e-9
        return float(np.count_nonzero(there)) * self.simulation.period


def moves(number: int) -> str:
    return f"%T\nG90 G01 F6000 X100\nX200 M{number}\nX300\nM30\n"


@pytest.mark.spec("chan.mh.mos")
def test_mos_is_put_out_before_the_motion_of_its_block_and_never_waits(machine: Machine, program: Write) -> None:
    run = Run(machine, program(moves(SYNCH["MOS"])), {(M, SYNCH["MOS"]): None})
    assert run.result.good
    assert run.event(EventKind.M_OUT, SYNCH["MOS"]).path_pos == pytest.approx(100.0, abs=0.2)
    assert run.standing_at(100.0) <= 0.002
    assert run.standing_at(200.0) <= 0.002


@pytest.mark.spec("chan.mh.sync-model", "isg.mh.user-functions")
def test_no_synch_is_not_put_out(machine: Machine, program: Write) -> None:
    run = Run(machine, program(moves(SYNCH["NO_SYNCH"])), {})
    assert run.result.good
    assert not [e for e in run.result.events if e.kind is EventKind.M_OUT and e.number == SYNCH["NO_SYNCH"]]


@pytest.mark.spec("chan.mh.mvs-svs")
def test_mvs_svs_waits_before_the_motion(machine: Machine, program: Write) -> None:
    run = Run(machine, program(moves(SYNCH["MVS_SVS"])), {(M, SYNCH["MVS_SVS"]): 0.5})
    assert run.result.good
    assert run.event(EventKind.M_OUT, SYNCH["MVS_SVS"]).path_pos == pytest.approx(100.0, abs=1e-6)
    assert run.standing_at(100.0) == pytest.approx(0.5, abs=0.02)
    assert run.standing_at(200.0) <= 0.002


@pytest.mark.spec("chan.mh.mvs-sns")
def test_mvs_sns_acknowledged_early_runs_through_without_a_stop(machine: Machine, program: Write) -> None:
    early = Run(machine, program(moves(SYNCH["MVS_SNS"])), {(M, SYNCH["MVS_SNS"]): 0.1})
    plain = Run(machine, program(moves(SYNCH["NO_SYNCH"])), {})
    assert early.result.good
    assert early.event(EventKind.M_OUT, SYNCH["MVS_SNS"]).path_pos == pytest.approx(100.0, abs=0.2)
    assert early.standing_at(200.0) <= 0.002
    assert early.result.time == pytest.approx(plain.result.time, abs=0.001)


@pytest.mark.spec("chan.mh.mvs-sns")
def test_mvs_sns_acknowledged_late_stops_at_the_block_end(machine: Machine, program: Write) -> None:
    run = Run(machine, program(moves(SYNCH["MVS_SNS"])), {(M, SYNCH["MVS_SNS"]): 3.0})
    assert run.result.good
    out, ack = run.event(EventKind.M_OUT, SYNCH["MVS_SNS"]), run.event(EventKind.M_ACK, SYNCH["MVS_SNS"])
    assert ack.t - out.t == pytest.approx(3.0, abs=0.01)
    assert ack.path_pos == pytest.approx(200.0, abs=1e-6)
    assert run.standing_at(200.0) > 1.0
    speed = np.diff(np.asarray(run.samples["X"], dtype=float)) / run.simulation.period
    assert np.abs(np.diff(speed)).max() <= 4.02  # under control: 4 m/s² in 1 ms


@pytest.mark.spec("chan.mh.mns-sns")
def test_mns_sns_is_put_out_after_the_motion_and_waits_there(machine: Machine, program: Write) -> None:
    run = Run(machine, program(moves(SYNCH["MNS_SNS"])), {(M, SYNCH["MNS_SNS"]): 0.3})
    assert run.result.good
    assert run.event(EventKind.M_OUT, SYNCH["MNS_SNS"]).path_pos == pytest.approx(200.0, abs=1e-6)
    assert run.standing_at(200.0) == pytest.approx(0.3, abs=0.02)


def test_in_front_of_the_motion_only_mvs_svs_is_waited_for(machine: Machine, program: Write) -> None:
    first, second = SYNCH["MVS_SVS"], SYNCH["MVS_SNS"]
    text = f"%T\nG90 G01 F6000 X100\nX200 M{first} M{second}\nX300\nM30\n"
    run = Run(machine, program(text), {(M, first): 0.2, (M, second): 0.7})
    assert run.result.good
    assert run.standing_at(100.0) == pytest.approx(0.2, abs=0.02)
    assert run.standing_at(200.0) <= 0.002


def test_never_acknowledged_the_path_stands_and_says_what_it_waits_for(
    machine: Machine, program: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(simulation, "STANDING_LIMIT", 5.0)
    run = Run(machine, program(moves(SYNCH["MVS_SVS"])), {(M, SYNCH["MVS_SVS"]): None})
    assert not run.result.good
    assert "WAIT_TECHNOLOGY" in run.result.problems[0]
    assert run.result.positions["X"] == pytest.approx(100.0)


def test_order_is_kept_and_nothing_is_lost_when_the_plc_is_slow(machine: Machine, program: Write) -> None:
    blocks = "\n".join(f"X{x}.5 M{SYNCH['MOS']}\nX{x + 1} M{SYNCH['MVS_SNS']}" for x in range(40))
    run = Run(machine, program(f"%T\nG90 G01 F60000\n{blocks}\nM30\n"), {(M, SYNCH["MVS_SNS"]): 0.02})
    assert run.result.good
    plc = run.simulation.plc
    assert isinstance(plc, ScriptedPlc)
    assert plc.taken == [(M, SYNCH["MOS"]), (M, SYNCH["MVS_SNS"])] * 40


@pytest.mark.spec("isg.mh.m00-programmed-stop", "isg.mh.m01-optional-stop")
def test_m00_stops_after_the_motion_until_continue_and_m01_only_when_wanted(machine: Machine, program: Write) -> None:
    run = Run(machine, program("%T\nG90 G01 F6000 X50 M00\nX80 M01\nX100\nM30\n"), {})
    assert run.result.good
    assert run.standing_at(50.0) >= 1.0  # the simulated operator takes a second
    assert run.standing_at(80.0) <= 0.002


@pytest.mark.spec("isg.g.dwell-g04-time")
def test_dwell_stands_for_its_time(machine: Machine, program: Write) -> None:
    run = Run(machine, program("%T\nG90 G01 F6000 X50\nG04 0.25\nX100\nM30\n"), {})
    assert run.result.good
    assert run.standing_at(50.0) == pytest.approx(0.25, abs=0.005)


def test_a_spindle_that_is_not_at_speed_holds_the_path(machine: Machine, program: Write) -> None:
    run = Run(machine, program("%T\nS12000 M3\nG90 G01 F6000 X50\nM5\nM30\n"), {})
    assert run.result.good
    first_motion = next(t for t, x in zip(run.samples["t"], run.samples["X"], strict=True) if x > 0)
    out = next(e for e in run.result.events if e.kind is EventKind.SPINDLE and e.number == 3)
    assert float(first_motion) - out.t > 0.45  # 12 000 rev/min at 24 000 rev/min/s
