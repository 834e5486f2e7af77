"""PLC, operator and CNC in any order: no control unit gets stuck, no order is lost, no axis leaves its limits.

The machine is the whole one in virtual time; what is done to it is drawn by Hypothesis. TANDEM_HANDSHAKES=500 draws as many
sequences, other ones in each run.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections import Counter
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, precondition, rule

from runtime.cnc.search_target import SearchKind
from runtime.config.loader import load_machine
from runtime.diagnostics.events import EventKind
from runtime.hli.layout import Activation, KeyPress, ManualMode, Mode, PathWay, SearchOrder, State, StopCondition
from tests.machine.acting_plc import ActingPlc, Manner
from tests.machine.driven import Driven

LONG = int(os.environ.get("TANDEM_HANDSHAKES", "0"))
ANSWER = 3  # cycles in which an order is taken or refused
STUCK = 400  # cycles: a path that stands so long has to tell why

PROGRAMS = (
    """%WORK
N10 G90 G17 G00 X10 Y10 Z5 S500 M3
N20 M8 H12
N30 G01 Z-2 F6000
/N35 M20
N40 X40
N50 M20
N60 G03 X40 Y50 I0 J20
N70 M9
/2 N75 X35
N80 G01 X10 M21
N85 M01
N90 Y10
N95 G04 0.05
N100 G00 Z20 M5
N110 M30
""",
    """%SMOOTH
N10 G90 G17 G01 F6000 X10 Y10 Z0 M8
N20 #CONTOUR MODE ON [DEV, PATH_DEV 0.5]
N30 X40
N40 Y30 M20
N50 G02 X70 Y60 I30 J0
#OPTIONAL EXECUTION ON
N55 G01 X75
N56 X70
#OPTIONAL EXECUTION OFF
N60 X20 Z-3
#CONTOUR MODE OFF
#STOP REVERSIBLE [ID 1 LEVEL 1]
N70 X25 M21
N80 M00
N90 X5 Y10 M9
#MSG SYN ["half"]
N100 M30
""",
    "%HAND\nN10 G90 G01 F6000 X15 Y5 M8\nN20 G200\nN30 G90 G01 X30 Y20 M20\nN40 M30\n",
    "%LINES\nN10 G90 G01 F6000 X5 Y5\n"
    + "".join(f"N{20 + i} X{5 + i * 0.3:.1f} Y{5 + (i % 2) * 0.1:.1f}\n" for i in range(200))
    + "N300 M20\nN310 G01 X0 Y0\nN320 M30\n",
)
LAST = "%LAST\nN10 G90 G01 F6000 X1 Y1 Z1 M8\nN20 M20\nN30 X2 Y2 M21\nN40 M30\n"
CLAIMED = {
    "feedhold": st.booleans(),
    "single_block": st.booleans(),
    "optional_stop": st.booleans(),
    "machine_lock": st.booleans(),
    "read_disable": st.booleans(),
    "backward_motion": st.booleans(),
    "simulate_motion": st.booleans(),
    "reset": st.booleans(),
    "continue_motion": st.booleans(),
    "delete_distance_to_go": st.booleans(),
    "block_search_on": st.booleans(),
    "override": st.sampled_from([0, 300, 1000]),
    "program_block_ignore": st.sampled_from([0, 1, 2, 3]),
    "stop_level": st.sampled_from([0, 1]),
    "ext_command_speed_valid": st.booleans(),
    "ext_command_speed": st.sampled_from([0, 50_000]),
}


SWITCHES = (
    "feedhold_w",
    "single_block_w",
    "optional_stop_w",
    "machine_lock_w",
    "backward_motion_w",
    "simulate_motion_w",
)
CLAMP = (1, 20)  # M20 is MVS_SVS: acknowledged before the path goes on


class Handshakes(RuleBasedStateMachine):
    """What a step does is written behind it at once; `go` lets the time pass and looks at everything in each cycle."""

    seen: ClassVar[Counter[StopCondition]] = Counter()  # cycles of all runs, by what they waited for

    def __init__(self) -> None:
        super().__init__()
        self.folder = Path(tempfile.mkdtemp(prefix="handshakes"))
        machine = load_machine(None)
        channel = machine.channels[0].model_copy(update={"backward_storage": 500})
        plc = machine.plc.model_copy(update={"watchdog": 0.05})
        machine = machine.model_copy(update={"channels": (channel,), "plc": plc})
        self.driven = Driven(machine, self.folder, ideal_axes=True, partner=ActingPlc)
        plc_ = self.driven.simulation.plc
        assert isinstance(plc_, ActingPlc)
        self.plc = plc_
        self.hli = self.driven.hli
        self.operator = self.driven.operator
        self.unit = self.hli.channels[0].control.mode_and_state
        self.still = 0
        self.clamped_at: float | None = None
        self.files = [self.driven.program(text) for text in PROGRAMS]

    # ------------------------------------------------------------------ time

    def go(self, cycles: int) -> None:
        driven = self.driven
        for _ in range(cycles):
            driven.watch(1)
            self.look()
        self.limits()

    def look(self) -> None:
        """What holds after every cycle."""
        channel, operator = self.driven.channel, self.operator
        assert not operator.reset_rw, "the operator's reset was not taken"
        assert not operator.continue_motion_rw, "continue was not taken"
        silent = channel.active and not channel.stop_condition and channel.interpolator.standstill
        self.still = self.still + 1 if silent else 0
        assert self.still < STUCK, "the path stands, and nothing tells why"
        self.owes()
        self.seen[StopCondition(channel.stop_condition)] += 1

    def owes(self) -> None:
        """A path that is driven for the first time does not go on before its function is acknowledged."""
        channel, area = self.driven.channel, self.hli.channels[0]
        clamps = [t for t in self.plc.owed if (t.function.kind, t.function.number) == CLAMP and not t.is_done]
        counts = clamps and channel.active and not area.lc_reset.please_rw and channel.path_way == PathWay.ONWARD
        place = channel.interpolator.path_position if counts else None
        if place is not None and self.clamped_at is not None:
            assert place == self.clamped_at, "the path has passed a function that was not acknowledged"
        self.clamped_at = place

    def limits(self) -> None:
        """Set-points keep position, velocity and acceleration; what a corner may jump is on top."""
        driven = self.driven
        places = np.array(driven.targets)[:, :3]
        period = driven.simulation.period
        for i, axis in enumerate(driven.machine.axes[:3]):
            low, high = axis.position_min, axis.position_max
            assert low is not None
            assert high is not None
            assert low - 1e-6 <= places[:, i].min()
            assert places[:, i].max() <= high + 1e-6
            velocity = np.diff(places[:, i]) / period
            if not velocity.size:
                return
            assert np.abs(velocity).max() <= axis.velocity * 1.0001
            most = axis.acceleration * period * 1.001 + axis.velocity_step
            assert len(velocity) < 2 or np.abs(np.diff(velocity)).max() <= most, (i, np.abs(np.diff(velocity)).max())
        driven.targets = driven.targets[-3:]
        driven.states = driven.states[-3:]

    # ------------------------------------------------------------------ the operator

    def order(self, mode: Mode, state: State, parameter: str = "") -> None:
        """Every order is taken or refused at once; if the PLC has the unit, it gets it as soon as the one before is gone."""
        if self.operator.order_semaphor_rw:
            self.go(ANSWER)
        if self.operator.order_semaphor_rw:
            assert self.claimed, "an order before this one was not answered"
            return
        self.driven.simulation.order(mode, state, parameter)
        self.go(ANSWER)
        if self.operator.order_semaphor_rw:
            with_plc = self.claimed and bool(self.unit.request_semaphor_rw)
            assert with_plc, "neither taken nor refused, and not with the PLC"

    @property
    def claimed(self) -> bool:
        """The PLC has the mode unit."""
        return bool(self.unit.enable_w and self.hli.channels[0].plc_present_w)

    @initialize(which=st.integers(0, len(PROGRAMS) - 1))
    def first_start(self, which: int) -> None:
        self.start(which)

    @rule(which=st.integers(0, len(PROGRAMS) - 1))
    def start(self, which: int) -> None:
        self.order(Mode.AUTOMATIC, State.ACTIVE, str(self.files[which]))
        self.go(20)

    @precondition(lambda self: self.driven.channel.error is None)
    @rule(
        line=st.sampled_from([2, 4, 7, 9, 12, 60]),
        which=st.integers(0, len(PROGRAMS) - 1),
        asked=st.booleans(),
    )
    def search(self, line: int, which: int, asked: bool) -> None:
        if self.operator.order_semaphor_rw:
            return  # an order waits for the PLC, and a search belongs to one
        order = SearchOrder(type=int(SearchKind.LINE), value=line, automatic_return=not asked, no_hold=not asked)
        self.operator.block_search.data_w = order
        self.operator.block_search.semaphor_rw = True
        self.start(which)

    @precondition(lambda self: self.driven.channel.error is None)
    @rule(mode=st.sampled_from([Mode.MDI, Mode.MANUAL, Mode.HOMING, Mode.STANDBY]))
    def other_mode(self, mode: Mode) -> None:
        text = {Mode.MDI: "G91 G01 F3000 X3\nM8", Mode.HOMING: "G74 X1 Y1 Z1"}.get(mode, "")
        self.order(mode, State.SELECTED if mode is Mode.STANDBY else State.ACTIVE, text)
        self.go(10)

    @precondition(lambda self: self.driven.channel.error is None)
    @rule(state=st.sampled_from([State.SELECTED, State.READY, State.ACTIVE, State.HOLD]))
    def other_state(self, state: State) -> None:
        mode = Mode(self.unit.mode_r)
        self.order(mode, state, str(self.files[0]) if state is State.READY else "")

    @rule()
    def reset(self) -> None:
        self.operator.reset_rw = True
        self.go(2)

    @precondition(lambda self: self.driven.channel.active)
    @rule()
    def go_on(self) -> None:
        self.operator.continue_motion_rw = True
        self.go(2)

    @precondition(lambda self: self.driven.channel.error is None)
    @rule(
        name=st.sampled_from(SWITCHES),
        on=st.booleans(),
    )
    def switch(self, name: str, on: bool) -> None:
        setattr(self.operator, name, on)
        self.go(10)

    @precondition(lambda self: self.driven.channel.active)
    @rule(percent=st.sampled_from([0, 20, 100]))
    def override(self, percent: int) -> None:
        self.operator.override_w = percent * 10

    @precondition(lambda self: self.driven.channel.error is None)
    @rule(mask=st.sampled_from([0, 1, 2, 3]))
    def skip_levels(self, mask: int) -> None:
        self.operator.program_block_ignore_w = mask

    @precondition(lambda self: self.driven.channel.error is None)
    @rule(axis=st.integers(1, 3), direction=st.sampled_from([-1, 0, 1]), how=st.sampled_from([2, 3]))
    def hand(self, axis: int, direction: int, how: int) -> None:
        operator = self.operator
        assert not operator.activation.semaphor_rw, "a job of the hand was not taken"
        assert not operator.key.semaphor_rw, "a key was not taken"
        operator.activation.data_w = Activation(axis, 1, int(ManualMode(how)), 0)
        operator.activation.semaphor_rw = True
        self.go(2)
        operator.key.data_w = KeyPress(1, direction, 100_000)
        operator.key.semaphor_rw = True
        self.go(2)

    # ------------------------------------------------------------------ the PLC

    @precondition(lambda self: self.driven.channel.error is None)
    @rule(manner=st.sampled_from(list(Manner)))
    def manner(self, manner: Manner) -> None:
        self.plc.manner = manner

    @precondition(lambda self: self.driven.channel.active)
    @rule(data=st.data(), name=st.sampled_from(sorted(CLAIMED)))
    def claim(self, data: st.DataObject, name: str) -> None:
        self.plc.claim(name, data.draw(CLAIMED[name]))
        self.go(5)

    @precondition(lambda self: self.driven.channel.error is None)
    @rule(forwards=st.booleans())
    def claim_modes(self, forwards: bool) -> None:
        self.plc.forwards = forwards
        self.unit.enable_w = True

    @rule()
    def give_back(self) -> None:
        self.plc.give_back()
        self.go(5)

    @precondition(lambda self: self.driven.channel.active)
    @rule()
    def hang(self) -> None:
        self.plc.frozen = True

    @rule()
    def wake(self) -> None:
        self.plc.frozen = False

    @rule()
    def release(self) -> None:
        """Nobody holds the path any more, and what was forgotten is caught up."""
        self.free()
        self.plc.manner = Manner.AT_ONCE
        self.go(30)

    # ------------------------------------------------------------------ the CNC

    @precondition(lambda self: self.driven.channel.active)
    @rule(cycles=st.sampled_from([60, 150, 300]))
    def run(self, cycles: int) -> None:
        self.go(cycles)

    @precondition(lambda self: self.unit.state_r in (State.SELECTED, State.ERROR))
    @rule(which=st.integers(0, len(PROGRAMS) - 1))
    def start_again(self, which: int) -> None:
        if self.driven.channel.error is not None:
            self.reset()
        self.free()
        self.go(20)
        self.start(which)
        self.go(60)

    @rule(cycles=st.sampled_from([1, 30, 120, 400]))
    def wait(self, cycles: int) -> None:
        self.go(cycles)

    # ------------------------------------------------------------------ the end

    def teardown(self) -> None:
        try:
            self.all_quiet()
            self.goes_on()
            self.resets_and_starts()
        finally:
            self.driven.simulation.close()
            shutil.rmtree(self.folder, ignore_errors=True)

    def all_quiet(self) -> None:
        """Nobody wants anything special any more, and the PLC is well again and acknowledges."""
        plc = self.plc
        plc.manner, plc.frozen, plc.forwards = Manner.AT_ONCE, False, True
        self.go(20)  # whatever the PLC still has to hand on
        self.free()
        self.go(20)
        operator = self.operator
        flags = (operator.order_semaphor_rw, self.unit.request_semaphor_rw, self.unit.command_semaphor_rw)
        assert flags == (False, False, False), "an order was lost"
        assert (operator.activation.semaphor_rw, operator.key.semaphor_rw) == (False, False)

    def free(self) -> None:
        """Operator and PLC hold nothing."""
        self.plc.give_back()
        for name in SWITCHES:
            setattr(self.operator, name, False)
        self.operator.override_w = 1000
        self.operator.program_block_ignore_w = 0
        if self.unit.state_r in (State.ACTIVE, State.HOLD):  # in ACTIVE the path may brake for a hold
            self.order(Mode(self.unit.mode_r), State.ACTIVE)

    def goes_on(self) -> None:
        """What runs comes to its end if one says continue wherever it asks for it and every function is acknowledged at last."""
        channel = self.driven.channel
        for _ in range(150):
            if not channel.active:
                return
            if self.owed:  # what was never acknowledged, or was claimed by a version of the PLC that is gone
                break
            self.operator.continue_motion_rw = True
            self.go(100)
        assert not channel.active or self.owed, (StopCondition(channel.stop_condition), channel.interpolator.line)

    @property
    def owed(self) -> bool:
        """A function that the PLC has taken, and will never acknowledge."""
        stop = self.driven.channel.stop_condition
        return bool(stop & (StopCondition.WAIT_TECHNOLOGY | StopCondition.TECHNOLOGY_FULL))

    def resets_and_starts(self) -> None:
        driven = self.driven
        self.operator.reset_rw = True
        self.go(2)
        driven.until(lambda: not driven.channel.active, 3.0)
        driven.until(driven.simulation.ready, 3.0)
        self.operator.reset_rw = True
        self.go(5)
        assert driven.channel.error is None
        before, outs = len(driven.simulation.problems), len(driven.simulation.log)
        taken = len(self.plc.taken)
        self.order(Mode.AUTOMATIC, State.ACTIVE, str(driven.program(LAST)))
        self.go(3)
        assert driven.channel.active, driven.simulation.problems[before:]
        driven.until(lambda: not driven.channel.active, 10.0)
        self.go(10)
        assert driven.simulation.problems[before:] == []
        assert driven.image.target_position[:3].tolist() == pytest.approx([2.0, 2.0, 1.0])
        functions = [event.number for event in driven.simulation.log[outs:] if event.kind is EventKind.M_OUT]
        assert functions == [8, 20, 21]
        assert [number for _, number in self.plc.taken[taken:]] == functions, "each was taken once, in its order"


_settings = settings(
    max_examples=LONG or 20,
    stateful_step_count=40 if LONG else 25,
    deadline=None,
    derandomize=not LONG,
    suppress_health_check=list(HealthCheck),
    phases=[Phase.generate],  # a sequence that fails is told as it is: making it shorter takes minutes
    report_multiple_bugs=False,
)
TestHandshakes = pytest.mark.spec("hli.mech.control-unit", "hli.mech.control-unit-usage-check")(Handshakes.TestCase)
TestHandshakes.settings = _settings
