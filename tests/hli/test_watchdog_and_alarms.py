"""The PLC's sign of life, the alarm history, and the PLC's way into it."""

from __future__ import annotations

import pytest

from runtime.diagnostics.errors import Severity
from runtime.hli.alarms import AlarmHistory, AlarmLine, Report, alarm_lines, send_report, take_report
from runtime.hli.layout import ALARMS, Channel, Hli, PlcReport
from runtime.hli.watchdog import PlcWatchdog

MS = 1_000_000


@pytest.mark.spec("hli.mech.watchdog-cnc-monitors-plc", "hli.mech.watchdog-plc-monitors-cnc")
def test_silence_is_reported_once_and_after_the_promised_time() -> None:
    channel = Channel(plc_present_w=True)
    watchdog = PlcWatchdog(channel)
    channel.watchdog.cycle_time_w = 20_000  # µs
    channel.watchdog.enable_w = True
    channel.watchdog.alive_rw = True
    assert watchdog.check(0) is None
    assert channel.watchdog.alive_state_r
    assert not channel.watchdog.alive_rw
    assert channel.watchdog.lc_alive_rw
    found = [watchdog.check(t * MS) for t in range(1, 40)]
    problems = [(t, problem) for t, problem in enumerate(found, 1) if problem is not None]
    assert [(t, problem.entry.id) for t, problem in problems] == [(21, 270053)]
    assert "21 ms" in problems[0][1].text
    assert not channel.watchdog.alive_state_r
    channel.watchdog.alive_rw = True
    assert watchdog.check(40 * MS) is None
    assert channel.watchdog.alive_state_r


@pytest.mark.spec("hli.mech.watchdog-cnc-monitors-plc")
@pytest.mark.parametrize(("present", "enable"), [(False, True), (True, False)])
def test_only_a_plc_that_is_present_and_feeds_is_watched(present: bool, enable: bool) -> None:
    channel = Channel(plc_present_w=present)
    channel.watchdog.enable_w = enable
    channel.watchdog.cycle_time_w = 1
    watchdog = PlcWatchdog(channel)
    assert [watchdog.check(t * 1000 * MS) for t in range(3)] == [None] * 3


def test_a_plc_that_never_shows_life_is_missed_too() -> None:
    channel = Channel(plc_present_w=True)
    channel.watchdog.enable_w = True
    channel.watchdog.cycle_time_w = 20_000
    watchdog = PlcWatchdog(channel)
    assert watchdog.check(0) is None
    problem = watchdog.check(21 * MS)
    assert problem is not None


def line(number: int) -> AlarmLine:
    return AlarmLine(0, number * 10, number, 300000 + number, Severity.ERROR, f"alarm {number}", axis=2, line=7)


def test_the_history_is_a_ring_newest_first() -> None:
    hli = Hli()
    history = AlarmHistory(hli)
    assert alarm_lines(hli) == []
    sequences = [history.add(line(n)) for n in range(ALARMS + 3)]
    lines = alarm_lines(hli)
    assert len(lines) == ALARMS
    assert [entry.sequence for entry in lines] == sequences[: -ALARMS - 1 : -1]
    assert (lines[0].text, lines[0].axis, lines[0].line, lines[0].id) == (f"alarm {ALARMS + 2}", 2, 7, 300066)
    history.close(sequences[-1])
    history.close(sequences[0])  # overwritten long ago: must not close the line that took its place
    assert [entry.sequence for entry in alarm_lines(hli, active_only=True)] == sequences[-2 : -ALARMS - 1 : -1]
    history.close_all()
    assert alarm_lines(hli, active_only=True) == []


def test_a_line_that_is_being_written_is_left_out() -> None:
    hli = Hli()
    AlarmHistory(hli).add(line(1))
    hli.alarms[0].sequence_r = 0
    assert alarm_lines(hli) == []


@pytest.mark.spec("hli.mech.error-plc-to-cnc")
def test_reports_pass_one_at_a_time() -> None:
    slot = PlcReport()
    assert take_report(slot) is None
    report = Report(304031, 1, "clamp does not close", line=12)
    assert send_report(slot, report)
    assert not send_report(slot, Report(304031, 2, "other"))
    assert take_report(slot) == report
    assert take_report(slot) is None
