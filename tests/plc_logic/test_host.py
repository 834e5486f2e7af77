"""A PLC program in its host: cycles, handlers, image, alarms, failures. The bench is the CNC."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from runtime.hli.layout import Mode, State
from runtime.hli.memory import get_text, put_text
from runtime.hli.modes import Wish
from runtime.plc_logic import (
    TON,
    NcFunction,
    PlcError,
    PlcFailure,
    Program,
    h_function,
    m_function,
    s_function,
    t_function,
)
from runtime.plc_logic.bench import Bench


class Clamp(Program):
    """The example of the README."""

    def setup(self) -> None:
        self.resets = 0
        self.seen: list[str] = []

    @m_function(20)
    def close_clamp(self, f: NcFunction) -> bool:
        self.io.valve = True
        if f.elapsed > 2.0:
            self.alarm("clamp does not close")
        return self.io.closed

    @m_function(30, 31)
    def several(self, f: NcFunction) -> bool:
        self.seen.append(f"{f}={f.value} line {f.line} in {f.area}")
        return True

    @h_function()
    def any_h(self, f: NcFunction) -> bool:
        self.seen.append(str(f))
        return True

    @h_function(5)
    def one_h(self, f: NcFunction) -> bool:
        self.seen.append("five")
        return True

    @t_function()
    def tool(self, f: NcFunction) -> bool:
        self.seen.append(f"tool {f.tool}")
        return True

    @s_function(3)
    def clockwise(self, f: NcFunction) -> bool:
        self.seen.append(f"{f.area} {f.speed:.0f}")
        return True

    @m_function(40)
    def steps(self, f: NcFunction) -> Iterator[None]:
        self.io.valve = True
        yield from self.until(lambda: self.io.closed, 1.0, "step 1 hangs")
        yield from self.wait(0.1)
        self.io.valve = False

    def on_reset(self) -> None:
        self.resets += 1


def bench() -> Bench[Clamp]:
    return Bench(Clamp, inputs=["closed"], outputs=["valve", "lamp"])


@pytest.mark.spec("hli.tech.unit")
def test_a_handler_acknowledges_when_it_returns_true() -> None:
    b = bench()
    sent = b.m(20)
    b.run(0.1)
    assert b.output("valve")
    assert not sent.done
    b.set(closed=True)
    assert b.run_until(lambda: sent.done) <= 0.008


def test_an_alarm_stands_while_it_is_reported_and_carries_the_line() -> None:
    b = bench()
    b.m(20, line=17)
    b.run(2.1)
    assert b.alarms == ["clamp does not close"]
    b.set(closed=True)
    b.run(0.1)
    assert b.alarms == []
    came, went = b.reports
    assert (came.id, came.active, came.line) == (304031, True, 17)
    assert (went.number, went.active) == (came.number, False)


def test_numbers_values_and_defaults_find_their_handlers() -> None:
    b = bench()
    b.m(31, value=-4, line=9)
    b.h(5)
    b.h(6)
    b.t(12)
    b.s(3, 6000)
    b.run(0.02)
    assert b.program.seen == ["M31=-4 line 9 in bench", "five", "H6", "tool 12", "S 6000"]


def test_a_sequence_runs_step_by_step_with_times() -> None:
    b = bench()
    sent = b.m(40)
    b.run(1.2)
    assert b.alarms == ["step 1 hangs"]
    b.set(closed=True)
    assert b.run_until(lambda: sent.done) == pytest.approx(0.108, abs=0.0041)
    assert not b.output("valve")
    assert b.alarms == []
    again = b.m(40)
    b.run_until(lambda: again.done)


@pytest.mark.spec("hli.tech.unit", "hli.tech.sync-kinds")
def test_a_function_without_a_handler_stops_the_path_with_an_alarm_or_warns_if_nobody_waits() -> None:
    b = bench()
    waiting, passing = b.m(99, line=3), b.m(98, wait=False)
    b.run(0.1)
    assert (waiting.done, passing.done) == (False, True)
    assert b.alarms == ["PLC program has no handler for M99 (line 3); it stays unacknowledged and the path waits"]
    assert [(r.id, r.line) for r in b.reports if r.active] == [(304029, 3), (304030, 0)]


@pytest.mark.spec("hli.ch.cu.reset")
def test_a_reset_withdraws_what_is_under_way() -> None:
    b = bench()
    b.m(20)
    b.m(40)
    b.run(0.1)
    b.reset()
    b.run(0.1)
    assert b.program.resets == 1
    assert b.host.waiting == []
    sent = b.m(30)
    b.run(0.02)
    assert sent.done


class Wrong(Program):
    """Mistakes to be made on demand."""

    mistake = ""

    def cycle(self) -> None:
        self.io.lamp = True
        match self.mistake:
            case "raises":
                self.divide(1)
            case "input":
                self.io.closed = True
            case "unknown":
                self.io.clsoed  # noqa: B018
            case "axis":
                self.axes["Q"].position  # noqa: B018
            case "exit":
                raise SystemExit

    def divide(self, n: int) -> float:
        return n / 0

    @m_function(1)
    def forgets(self, f: NcFunction) -> bool:
        return None  # type: ignore[return-value] # what a method without a return gives


@pytest.mark.parametrize(
    ("mistake", "says"),
    [
        ("raises", "ZeroDivisionError: division by zero (test_host.py:"),
        ("input", "closed is an input"),
        ("unknown", "no input or output clsoed; known: closed"),
        ("axis", "no axis Q; known: X, Y, Z, S"),
        ("exit", "SystemExit"),
    ],
)
def test_a_program_that_raises_has_no_effect_in_that_cycle(mistake: str, says: str) -> None:
    b = Bench(Wrong, inputs=["closed"], outputs=["lamp"])
    b.program.mistake = mistake
    with pytest.raises(PlcFailure) as caught:
        b.cycle()
    assert caught.value.problem.entry.id == 304026
    assert says in caught.value.problem.text
    platform = b.hli.platform
    assert platform.plc_error_id_w == 304026
    assert says in get_text(platform, "plc_error_text_w")
    assert "test_host.py" in get_text(platform, "plc_error_text_w")
    assert platform.plc_error_count_w == 1
    assert not b.output("lamp")
    assert platform.plc_cycle_done_w == 0
    assert b.channel.plc_present_w, "it has not given up its responsibility: the CNC goes on waiting"


def test_a_handler_without_an_answer_is_a_mistake_not_an_acknowledgement() -> None:
    b = Bench(Wrong, inputs=["closed"], outputs=["lamp"])
    sent = b.m(1)
    with pytest.raises(PlcFailure) as caught:
        b.cycle()
    assert "Wrong.forgets returned None for M1" in caught.value.problem.text
    assert not sent.done


def test_setup_that_raises() -> None:
    class NoStart(Program):
        def setup(self) -> None:
            self.io.nowhere = True

    with pytest.raises(PlcFailure) as caught:
        Bench(NoStart)
    assert caught.value.problem.entry.id == 304025


def test_two_handlers_in_one_class_and_overriding_in_a_subclass() -> None:
    with pytest.raises(PlcError, match="304028"):

        class Twice(Program):
            @m_function(6)
            def a(self, f: NcFunction) -> bool:
                return True

            @m_function(6)
            def b(self, f: NcFunction) -> bool:
                return True

    class Special(Clamp):
        def close_clamp(self, f: NcFunction) -> bool:
            return True  # the decorator of the base holds

        @m_function(30)
        def mine(self, f: NcFunction) -> bool:
            self.seen.append("mine")
            return True

    b = Bench(Special, inputs=["closed"], outputs=["valve", "lamp"])
    sent = [b.m(20), b.m(30), b.m(31)]
    b.run(0.02)
    assert all(s.done for s in sent)
    assert b.program.seen == ["mine", "M31=0 line 0 in bench"]
    assert Clamp.handlers != Special.handlers


class Commands(Program):
    """Uses every command once asked to."""

    def setup(self) -> None:
        self.delay = TON(PT=0.1)
        self.times: list[tuple[float, float]] = []

    def cycle(self) -> None:
        self.times.append((self.time, self.cycle_time))
        self.delay(IN=True)


@pytest.mark.spec("hli.mech.control-unit", "hli.mech.operation-without-plc")
def test_a_program_claims_only_what_it_assigns() -> None:
    b = Bench(Commands)
    b.run(0.02)
    control = b.channel.control
    assert not any(getattr(control, name).enable_w for name, *_ in control._fields_ if name != "manual")
    port, x = b.program.channel, b.program.axes["X"]
    port.override = 50
    port.feed_hold = True
    x.release = False
    b.cycle()
    assert (b.commands.override, b.commands.feed_hold, b.axis_commands["X"].release) == (0.5, True, False)
    assert b.axis_commands["Y"].release
    assert (port.override, port.feed_hold, x.release) == (50, True, False)
    b.hli.operator[0].override_w = 700
    b.cycle()
    assert (b.commands.override, port.operator.override) == (0.5, 70.0)
    del port.override
    b.cycle()
    assert b.commands.override == 0.7


@pytest.mark.spec("hli.mech.control-unit-usage-check", "hli.ch.cu.program-start-abort")
def test_orders_of_the_program_and_of_the_operator() -> None:
    b = Bench(Commands)
    b.cycle()
    b.program.channel.start("plate.nc")
    b.run(0.02)
    assert b.orders == [Wish(Mode.AUTOMATIC, State.ACTIVE, "plate.nc")]
    assert not b.channel.control.mode_and_state.enable_w, "the unit is the operator's again"
    operator = b.hli.operator[0]

    def order(program: str) -> None:
        operator.order_w.to_mode, operator.order_w.to_state = Mode.AUTOMATIC, State.ACTIVE
        put_text(operator.order_w, "parameter", program)
        operator.order_semaphor_rw = True
        b.run(0.02)

    order("direct.nc")
    assert b.orders[-1].parameter == "direct.nc"
    port = b.program.channel
    port.claims_orders = True
    b.cycle()
    order("asked.nc")
    assert b.orders[-1].parameter == "direct.nc"
    assert port.requested_order == Wish(Mode.AUTOMATIC, State.ACTIVE, "asked.nc")
    port.refuse_order()
    b.run(0.02)
    order("allowed.nc")
    port.allow_order()
    b.run(0.02)
    assert [wish.parameter for wish in b.orders] == ["plate.nc", "direct.nc", "allowed.nc"]


@pytest.mark.spec("hli.ch.cu.reset", "hli.ch.cu.continue")
def test_one_shots_are_given_once_and_taken_back() -> None:
    b = Bench(Commands)
    resets = 0
    b.cycle()
    b.program.channel.reset()
    for _ in range(5):
        b.cycle()
        resets += b.commands.reset
    assert resets == 1
    assert not b.channel.control.reset.command_w
    b.program.channel.continue_motion()
    b.cycle()
    assert not b.channel.control.continue_motion.enable_w, "nothing waits: no effect, nothing stored"
    b.channel.status.wait_continue_r = True
    b.program.channel.continue_motion()
    b.cycle()
    assert b.commands.continue_motion


def test_time_is_that_of_the_runtime() -> None:
    b = Bench(Commands, cycle_time=0.004)
    b.run(0.096)
    assert not b.program.delay.Q
    b.run(0.012)
    assert b.program.delay.Q
    assert b.program.times[0] == (pytest.approx(0.004), 0.0)
    assert b.program.times[1] == (pytest.approx(0.008), pytest.approx(0.004))


@pytest.mark.spec("hli.ax.status.positions", "hli.sp.status", "hli.ax.status.state")
def test_axes_and_spindles_in_the_programs_units() -> None:
    b = Bench(Commands)
    b.hli.axes[0].status.actual_position_r = -1_234_567
    b.hli.axes[0].status.position_lag_r = 25
    b.spindle("S", 12_000)
    x, s = b.program.axes["X"], b.program.spindles["S"]
    assert x.position == pytest.approx(-123.4567)
    assert x.lag == pytest.approx(0.0025)
    assert s.speed == pytest.approx(12_000)
    assert s.at_speed
    assert list(b.program.spindles) == ["S"]
    assert "S" in b.program.axes


@pytest.mark.spec("hli.mech.plc-present", "hli.mech.watchdog-cnc-monitors-plc")
def test_log_on_and_log_off() -> None:
    b = Bench(Commands)
    assert b.hli.platform.plc_present_w
    assert b.hli.axes[3].plc_present_w
    assert not b.hli.axes[4].plc_present_w, "there is no such axis"
    assert b.channel.watchdog.enable_w
    assert b.channel.watchdog.cycle_time_w == 50_000
    b.program.channel.feed_hold = True
    b.channel.watchdog.alive_rw = False
    b.cycle()
    assert b.channel.watchdog.alive_rw
    assert b.hli.platform.plc_cycle_done_w == b.hli.platform.plc_cycle_request_r == 1
    b.host.stop()
    assert not b.channel.plc_present_w
    assert not b.channel.control.feedhold.enable_w
    assert not b.channel.watchdog.enable_w


def test_commands_of_a_killed_plc_end_when_it_is_started_again() -> None:
    b = Bench(Commands)
    b.program.channel.feed_hold = True
    b.program.channel.override = 10
    b.host.start(b.time_ns)  # the same memory, a new program
    b.cycle()
    assert (b.commands.feed_hold, b.commands.override) == (False, 1.0)
