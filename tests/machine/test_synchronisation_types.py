"""Every synchronisation type against every behaviour of the PLC, undisturbed and with what an operator may do in between.

One program has a place for each type: where the function is put out and where the path waits stands in the table.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from runtime.cnc.blocks import Synch
from runtime.config.machine import Machine
from runtime.diagnostics.events import Event, EventKind
from runtime.hli.layout import StopCondition
from runtime.hli.memory import HliMemory
from runtime.scheduler.simulation import Simulation
from tests.machine.scripted_plc import ScriptedPlc

M = 1
Write = Callable[[str], Path]
NEVER = float("inf")
LEAD, LEAD_TIME = 5.0, 0.04  # mm, s
LIMIT = 3.0  # s: a program that is not over by then waits for ever


@dataclass(frozen=True)
class Case:
    """Where, in mm, a function of a type is put out (None: a time ahead), and where the path waits for it (None: nowhere)."""

    synch: Synch
    out: float | None
    wait: float | None
    spec: str


CASES = (
    Case(Synch.MOS, 20.0, None, "chan.mh.mos"),
    Case(Synch.MOS_TS, 20.0, None, "chan.mh.mos-ts"),
    Case(Synch.MVS_SVS, 20.0, 20.0, "chan.mh.mvs-svs"),
    Case(Synch.MVS_SNS, 20.0, 40.0, "chan.mh.mvs-sns"),
    Case(Synch.MNS_SNS, 40.0, 40.0, "chan.mh.mns-sns"),
    Case(Synch.MNE_SNS, 40.0, 40.0, "chan.mh.sync-model"),
    Case(Synch.MVS_SLM, 20.0, 60.0, "chan.mh.mvs-slm"),
    Case(Synch.MVS_SLP, 20.0, 80.0, "chan.mh.mvs-slp"),
    Case(Synch.MEP_MOS, 40.0 - LEAD, None, "chan.mh.mep-met-mos"),
    Case(Synch.MEP_SVS, 40.0 - LEAD, 40.0, "chan.mh.mep-met-svs"),
    Case(Synch.MET_MOS, None, None, "chan.mh.mep-met-mos"),
    Case(Synch.MET_SVS, None, 40.0, "chan.mh.mep-met-svs"),
)
PROGRAM = "%T\nG90 G01 F6000 X20\nG00 X40 M{0}\nX60\nG01 X80\n#EXPL SYN\nX100\nM30\n"
NUMBERS = {case.synch: 110 + k for k, case in enumerate(CASES)}


@pytest.fixture(scope="module")
def machine(demo: Machine) -> Machine:
    """The demo machine with an M function of every type."""
    channel = demo.channels[0]
    names = {number: synch.name for synch, number in NUMBERS.items()}
    ahead = {number: round(LEAD * 1e4) for synch, number in NUMBERS.items() if synch.name in ("MEP_MOS", "MEP_SVS")}
    ahead |= {
        number: round(LEAD_TIME * 1e6) for synch, number in NUMBERS.items() if synch.name in ("MET_MOS", "MET_SVS")
    }
    update = {"m_synch": {**channel.parameters.m_synch, **names}, "m_pre_outp": ahead}
    parameters = channel.parameters.model_copy(update=update)
    return demo.model_copy(update={"channels": (channel.model_copy(update={"parameters": parameters}),)})


class Refusing(ScriptedPlc):
    """A PLC that answers the function with a reset of the channel."""

    def __init__(self, memory: HliMemory, number: int) -> None:
        super().__init__(memory, {(M, number): None})
        self.number = number
        self.commanded = False

    def wake(self, time: float) -> None:
        super().wake(time)
        reset = self.hli.channels[0].control.reset
        reset.enable_w = True
        reset.command_w = (M, self.number) in self.taken and not self.commanded
        self.commanded |= bool(reset.command_w)


class Run:
    """The program with one function, watched cycle by cycle."""

    def __init__(self, machine: Machine, program: Path, number: int, delay: float | None) -> None:
        self.number = number
        delays = {(M, number): None if delay == NEVER else delay}
        self.simulation = Simulation(
            machine,
            ideal_axes=True,
            partner=lambda memory: Refusing(memory, number) if delay is None else ScriptedPlc(memory, delays),
        )
        self.channel = self.simulation.controller.channel
        self.path = self.simulation.controller.interpolator
        self.operator = self.simulation.memory.hli.operator[0]
        self.x: list[float] = []
        assert self.simulation.run_until(self.simulation.ready, 20.0)
        self.begin = self.simulation.time
        self.first = self.simulation.controller.cycle_number + 1  # of the positions in x
        self.simulation.start(program)
        self.cycles(3)

    def cycles(self, count: int) -> None:
        for _ in range(count):
            self.simulation.cycle()
            self.x.append(float(self.path.position[0]))

    def until(self, condition: Callable[[], bool]) -> bool:
        """False if it did not happen in time."""
        while not condition():
            if self.simulation.time - self.begin > LIMIT:
                return False
            self.cycles(1)
        return True

    def finish(self) -> bool:
        """Whether the program came to its end."""
        return self.until(lambda: not self.channel.active)

    @property
    def standing(self) -> bool:
        return len(self.x) > 30 and self.x[-1] == self.x[-30]

    def events(self, *kinds: EventKind) -> list[Event]:
        return [e for e in self.simulation.log if e.kind in kinds and e.number == self.number]

    @property
    def out(self) -> Event:
        (event,) = self.events(EventKind.M_OUT)
        return event


def cycle_way(run: Run, event: Event) -> float:
    """Way of the path in the cycle of the event, mm."""
    k = event.cycle - run.first
    return abs(run.x[k] - run.x[k - 1]) + 1e-9


def check_output(run: Run, case: Case) -> None:
    """Put out once, at its place, at most one cycle's path behind it."""
    if case.out is not None:
        assert -1e-6 <= run.out.path_pos - case.out <= cycle_way(run, run.out)
    else:
        assert run.out.path_pos < 40.0  # ahead; when exactly stands in test_ahead


parametrize = pytest.mark.parametrize(
    "case", [pytest.param(c, id=str(c.synch.name), marks=pytest.mark.spec(c.spec)) for c in CASES]
)


@parametrize
def test_answered_at_once(machine: Machine, program: Write, case: Case) -> None:
    run = Run(machine, program(PROGRAM.format(NUMBERS[case.synch])), NUMBERS[case.synch], 0.0)
    assert run.finish()
    check_output(run, case)
    acknowledged = run.events(EventKind.M_ACK)
    assert len(acknowledged) == (case.wait is not None)
    if case.wait is not None:
        assert acknowledged[0].path_pos <= case.wait + 1e-6


@parametrize
def test_answered_late(machine: Machine, program: Write, case: Case) -> None:
    run = Run(machine, program(PROGRAM.format(NUMBERS[case.synch])), NUMBERS[case.synch], 1.0)
    assert run.finish()
    check_output(run, case)
    order = [event.kind for event in run.events(EventKind.M_OUT, EventKind.M_ACK)]
    if case.wait is None:
        assert order == [EventKind.M_OUT]
        assert run.simulation.time - run.begin < 1.5
        return
    assert order == [EventKind.M_OUT, EventKind.M_ACK]
    (acknowledged,) = run.events(EventKind.M_ACK)
    assert acknowledged.path_pos == pytest.approx(case.wait, abs=1e-6)  # it stands where it has to wait
    assert acknowledged.t - run.out.t == pytest.approx(1.0, abs=0.012)


@parametrize
def test_never_answered(machine: Machine, program: Write, case: Case) -> None:
    run = Run(machine, program(PROGRAM.format(NUMBERS[case.synch])), NUMBERS[case.synch], NEVER)
    assert run.finish() == (case.wait is None)
    check_output(run, case)
    assert run.x[-1] == pytest.approx(100.0 if case.wait is None else case.wait, abs=1e-6)
    if case.wait is not None:
        assert StopCondition(run.channel.stop_condition) == StopCondition.WAIT_TECHNOLOGY
        run.operator.reset_rw = True  # the way out
        run.cycles(10)
        assert not run.channel.active
        assert run.channel.waiting_functions == 0


@parametrize
def test_refused(machine: Machine, program: Write, case: Case) -> None:
    """The PLC answers with a reset: the path stands under control, nothing is left over, the next program runs."""
    path = program(PROGRAM.format(NUMBERS[case.synch]))
    run = Run(machine, path, NUMBERS[case.synch], None)
    assert run.finish()
    assert len(run.events(EventKind.M_OUT)) == 1
    assert not run.events(EventKind.M_ACK)
    assert run.x[-1] < 100.0
    assert run.channel.waiting_functions == 0
    assert not run.channel.functions.pending


DISTURBANCES = ("feed hold", "override 0", "single block", "reset")


@pytest.mark.parametrize("disturbance", DISTURBANCES)
@parametrize
def test_disturbed_while_the_answer_is_on_its_way(
    machine: Machine, program: Write, case: Case, disturbance: str
) -> None:
    """Whatever the operator does: once, in its place, never past the place of waiting without the answer."""
    run = Run(machine, program(PROGRAM.format(NUMBERS[case.synch])), NUMBERS[case.synch], 0.3)
    operator = run.operator
    operator.single_block_w = disturbance == "single block"
    assert run.until(lambda: run.x[-1] >= 10.0)
    if disturbance == "feed hold":
        operator.feedhold_w = True
        run.cycles(200)
        assert run.standing
        operator.feedhold_w = False
    elif disturbance == "override 0":
        operator.override_w = 0
        run.cycles(200)
        assert run.standing
        operator.override_w = 1000
    elif disturbance == "reset":
        assert run.until(lambda: bool(run.events(EventKind.M_OUT)))
        operator.reset_rw = True
        assert run.finish()
        assert len(run.events(EventKind.M_OUT)) == 1
        assert run.channel.waiting_functions == 0
        return
    else:
        for _ in range(8):
            run.until(lambda: run.channel.stop_condition & StopCondition.SINGLE_BLOCK != 0 or not run.channel.active)
            operator.continue_motion_rw = True
            run.cycles(3)
    assert run.finish()
    assert len(run.events(EventKind.M_OUT)) == 1
    if case.out is not None:
        assert -1e-6 <= run.out.path_pos - case.out <= cycle_way(run, run.out)
    assert len(run.events(EventKind.M_ACK)) == (case.wait is not None)
    for event in run.events(EventKind.M_ACK):
        assert case.wait is not None
        assert event.path_pos <= case.wait + 1e-6
    assert run.x[-1] == pytest.approx(100.0)
