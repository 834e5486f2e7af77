"""Tasks, declared image, alarms that need acknowledgement, retained variables: in a program, on the bench."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from runtime.plc_logic import Input, Io, Output, PlcError, PlcFailure, Program, retain, task
from runtime.plc_logic.bench import Bench
from runtime.plc_logic.reports import Change
from runtime.plc_logic.retained_variables import RetainJournal, read_journal


class Tasked(Program):
    def setup(self) -> None:
        self.ran: list[str] = []
        self.fast: list[float] = []

    @task(every=0.1)
    def slow_one(self) -> None:
        self.ran.append("slow")

    @task(every=0.01)
    def fast_one(self) -> None:
        self.ran.append("fast")
        self.fast.append(self.time)

    def cycle(self) -> None:
        self.ran.append("cycle")


def test_tasks_run_in_their_own_periods_before_the_cycle() -> None:
    bench = Bench(Tasked)
    bench.run(1.0)
    ran = bench.program.ran
    assert ran[:3] == ["fast", "slow", "cycle"]
    assert ran.count("cycle") == 250
    assert ran.count("slow") == 10
    assert ran.count("fast") == 100, "10 ms in cycles of 4 ms: on the average"


def test_missed_periods_are_not_made_up_for() -> None:
    bench = Bench(Tasked)
    bench.run(0.1)
    before = len(bench.program.fast)
    bench.time_ns += 1_000_000_000
    bench.run(0.02)
    assert len(bench.program.fast) - before <= 3


def test_an_overridden_task_runs_as_the_class_says() -> None:
    class Quiet(Tasked):
        @task(every=0.5)
        def slow_one(self) -> None:
            self.ran.append("quiet")

        def fast_one(self) -> None: ...

    bench = Bench(Quiet)
    bench.run(1.0)
    assert bench.program.ran.count("quiet") == 2
    assert set(bench.program.ran) == {"quiet", "cycle"}


def test_a_period_of_nothing_is_refused() -> None:
    with pytest.raises(PlcError, match="304061"):
        task(every=0.0)


# --------------------------------------------------------------------------------------------- image


class MillIo(Io):
    closed: Input
    valve: Output


class Declared(Program):
    io: MillIo

    def cycle(self) -> None:
        self.io.valve = not self.io.closed


def test_a_declared_image_reads_and_writes() -> None:
    bench = Bench(Declared, inputs=["other", "closed"], outputs=["lamp", "valve"])
    bench.run(0.01)
    assert bench.output("valve")
    bench.set(closed=True)
    bench.run(0.01)
    assert not bench.output("valve")
    assert isinstance(bench.program.io, MillIo)


@pytest.mark.parametrize(
    ("inputs", "outputs", "says"),
    [
        (["closd"], ["valve"], "no input or output closed; known: closd"),
        (["closed", "valve"], [], "valve is declared as output, but the machine has it as input"),
    ],
)
def test_a_declaration_that_does_not_fit_the_machine_is_found_at_the_start(
    inputs: list[str], outputs: list[str], says: str
) -> None:
    with pytest.raises(PlcFailure, match=says):
        Bench(Declared, inputs=inputs, outputs=outputs)


def test_an_input_may_have_the_name_of_a_method() -> None:
    bench = Bench(Declared, inputs=["closed", "read_inputs"], outputs=["valve", "write_outputs"])
    bench.set(closed=True)
    bench.run(0.01)
    assert not bench.output("valve")


# --------------------------------------------------------------------------------------------- alarms


class Alarming(Program):
    def cycle(self) -> None:
        if self.io.hot:
            self.alarm("too hot", acknowledge=True)
        if self.io.low:
            self.alarm("oil low")
        if self.io.button:
            self.acknowledge_alarms()


def alarming() -> Bench[Alarming]:
    return Bench(Alarming, inputs=["hot", "low", "button"])


def test_an_alarm_stands_until_its_cause_is_gone_and_it_is_acknowledged() -> None:
    bench = alarming()
    bench.set(hot=True, low=True)
    bench.run(0.02)
    assert bench.alarms == ["too hot", "oil low"]
    assert bench.program.unacknowledged == ["too hot"]
    bench.set(hot=False, low=False)
    bench.run(0.02)
    assert bench.alarms == ["too hot"]
    bench.set(button=True)
    bench.run(0.02)
    assert bench.alarms == []
    assert [(line.change, line.text) for line in bench.program.alarm_history] == [
        (Change.CAME, "too hot"),
        (Change.CAME, "oil low"),
        (Change.GONE, "too hot"),
        (Change.GONE, "oil low"),
        (Change.ACKNOWLEDGED, "too hot"),
    ]
    times = [line.time for line in bench.program.alarm_history]
    assert times == sorted(times)
    assert times[0] > 0


def test_acknowledged_first_it_goes_with_its_cause() -> None:
    bench = alarming()
    bench.set(hot=True)
    bench.run(0.02)
    bench.set(button=True)
    bench.run(0.02)
    assert bench.alarms == ["too hot"]
    bench.set(button=False, hot=False)
    bench.run(0.02)
    assert bench.alarms == []


def test_a_cause_that_comes_back_needs_a_new_acknowledgement() -> None:
    bench = alarming()
    for button in (True, False):
        bench.set(hot=True)
        bench.run(0.01)
        bench.set(hot=False, button=button)
        bench.run(0.01)
        bench.set(button=False)
        assert bench.alarms == ([] if button else ["too hot"])
    assert [report.active for report in bench.reports] == [True, False, True]


def test_a_reset_of_the_channel_acknowledges() -> None:
    bench = alarming()
    bench.set(hot=True)
    bench.run(0.02)
    bench.set(hot=False)
    bench.reset()
    bench.run(0.02)
    assert bench.alarms == []


# --------------------------------------------------------------------------------------------- retained


class Counts(Program):
    parts = retain(0)
    tools = retain({"spindle": 0})
    saved = False

    def cycle(self) -> None:
        if self.io.part:
            self.parts += 1
            self.tools["spindle"] = self.parts % 3
        self.saved = self.retained_saved


def test_retained_variables_survive_a_program_that_ends_in_any_way(tmp_path: Path) -> None:
    bench = Bench(Counts, inputs=["part"], journal=lambda: RetainJournal(tmp_path))
    bench.set(part=True)
    bench.run(0.2)
    again = Bench(Counts, inputs=["part"], journal=lambda: RetainJournal(tmp_path))
    again.run(0.02)
    assert again.program.parts == 50
    assert again.program.tools == {"spindle": 2}
    without = Bench(Counts, inputs=["part"])
    assert without.program.parts == 0


def test_a_disk_that_takes_nothing_is_an_alarm_and_the_program_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench = Bench(Counts, inputs=["part"], journal=lambda: RetainJournal(tmp_path))
    with monkeypatch.context() as broken:
        broken.setattr(os, "write", lambda *_: 1)
        bench.set(part=True)
        bench.run(0.02)
    bench.run(2.0)
    assert bench.program.parts == 505
    assert [report.id for report in bench.reports if report.active] == [304065]
    bench.host.stop()
    assert read_journal(tmp_path)[1]["parts"] >= 500


class Changed(Program):
    parts = retain("none")


def test_a_kept_value_of_another_kind_is_a_warning_and_begins_anew(tmp_path: Path) -> None:
    bench = Bench(Counts, inputs=["part"], journal=lambda: RetainJournal(tmp_path))
    bench.set(part=True)
    bench.run(0.2)
    again = Bench(Changed, journal=lambda: RetainJournal(tmp_path))
    again.run(0.02)
    assert again.program.parts == "none"
    assert again.reports[0].id == 304063


def test_a_value_that_is_none_stops_the_program() -> None:
    class Wrong(Program):
        parts = retain(0)

        def cycle(self) -> None:
            self.parts = "x"  # type: ignore[assignment]

    with pytest.raises(PlcFailure, match="retained variable parts of kind int cannot be 'x'"):
        Bench(Wrong).run(0.02)


def test_what_is_kept_is_on_the_disk_soon(tmp_path: Path) -> None:
    bench = Bench(Counts, inputs=["part"], journal=lambda: RetainJournal(tmp_path))
    bench.set(part=True)
    bench.run(0.02)
    bench.host.stop()
    assert bench.program.retained_saved
    script = "import sys; from pathlib import Path; from runtime.plc_logic.retained_variables import read_journal as r"
    done = subprocess.run(
        [sys.executable, "-c", f"{script}; print(r(Path({str(tmp_path)!r}))[1]['parts'])"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == "5"
