"""Looking into the HLI, and `tandem hli`."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator

import pytest
from typer.testing import CliRunner

from runtime.cli.hli import app
from runtime.config.loader import load_machine
from runtime.diagnostics.catalogue import plc as catalogue
from runtime.diagnostics.errors import Problem, Severity
from runtime.hli.alarms import AlarmHistory, AlarmLine
from runtime.hli.client import HliClient, element, snapshot, stop_conditions
from runtime.hli.control import ChannelCommands
from runtime.hli.describe import describe_machine
from runtime.hli.errors import HliError
from runtime.hli.layout import Hli, Mode, State, StopCondition
from runtime.hli.memory import HliMemory, put_text
from runtime.hli.modes import Wish
from runtime.hli.operator import Operator, OrderRefusedError
from runtime.hli.technology import Function, Kind, TechnologyPort


def fill(hli: Hli) -> None:
    """A demo mill in the middle of a program."""
    describe_machine(hli, load_machine())
    hli.head.running_r = True
    hli.head.cycle_r = 77
    channel = hli.channels[0]
    channel.control.mode_and_state.mode_r = Mode.AUTOMATIC
    channel.control.mode_and_state.state_r = State.ACTIVE
    channel.control.override.state_r = 800
    channel.status.active_feed_r = 25_000
    channel.status.active_override_r = 800
    channel.status.line_r = 42
    channel.status.stop_condition_r = StopCondition.WAIT_TECHNOLOGY | StopCondition.FEED_HOLD
    put_text(channel.status, "program_name_r", "plate[1].nc")
    hli.axes[0].status.actual_position_r = 1_234_567
    hli.axes[3].spindle.actual_speed_r = 6_000_000
    channel.plc_present_w = True
    TechnologyPort(channel).put(Function(Kind.M, 20, synch=2))
    AlarmHistory(hli).add(AlarmLine(0, 5, 6, 304031, Severity.ERROR, "clamp [does] not close", line=12))


@pytest.fixture
def machine(shared: HliMemory) -> HliMemory:
    fill(shared.hli)
    return shared


@pytest.mark.spec("hli.mech.status-refresh", "hli.ch.status.path", "hli.ch.status.waiting", "hli.ax.status.positions")
def test_values_are_in_mm_degrees_seconds_and_percent(machine: HliMemory) -> None:
    with HliClient(str(machine.name)) as client:
        picture = json.loads(json.dumps(client.snapshot()))
    channel = picture["channels"][0]
    assert picture["running"] is True
    assert picture["head"]["cycle_time_r"] == 0.001
    assert channel["status"]["active_feed_r"] == 25.0
    assert channel["control"]["override"]["state_r"] == 80.0
    assert channel["control"]["feedhold"]["state_r"] is False
    assert channel["control"]["program_block_ignore"]["state_r"] == 0
    assert [unit["number_r"] for unit in channel["techno_unit_std_sync"]] == [20]
    assert len(picture["axes"]) == 4
    assert picture["axes"][0]["status"]["actual_position_r"] == 123.4567
    assert picture["axes"][3]["spindle"]["actual_speed_r"] == 6000.0
    assert picture["alarms"][0]["text"] == "clamp [does] not close"


def test_elements_are_found_by_index_name_and_without_suffix() -> None:
    hli = HliMemory.private().hli
    fill(hli)
    assert element(hli, "axes.X.status.actual_position") == 123.4567
    assert element(hli, "axes.0.status.actual_position_r") == 123.4567
    assert element(hli, "channels.mill.status.line") == 42
    assert element(hli, "") == snapshot(hli)
    for wrong in ("axes.Q", "axes.7", "head.cycle.more", "nothing"):
        with pytest.raises(HliError, match="304006"):
            element(hli, wrong)


def test_stop_conditions_in_words() -> None:
    assert stop_conditions(StopCondition.WAIT_TECHNOLOGY | StopCondition.FEED_HOLD) == ["feed hold", "wait technology"]
    assert stop_conditions(0) == []


# --------------------------------------------------------------------------------------------- tandem hli


def run(*arguments: str) -> str:
    result = CliRunner().invoke(app, list(arguments), catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return result.output


def test_watch_once_shows_the_machine(machine: HliMemory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    text = run("watch", "--once", "--name", str(machine.name))
    for part in ("demo mill", "running", "AUTOMATIC ACTIVE", "plate[1].nc", "line 42", "feed hold, wait technology"):
        assert part in text
    assert "123.4567" in text
    assert "1000 rev/min" in text
    assert "clamp [does] not close" in text


def test_watch_tells_the_mode_of_a_drive_that_moves_its_axis_by_itself(
    machine: HliMemory, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "140")
    status = machine.hli.axes[0].status
    for shown, told in ((0, ""), (8, ""), (10, "cyclic synchronous torque"), (-3 % 2**32, "mode 4294967293")):
        status.drive_mode_r = shown
        text = run("watch", "--once", "--name", str(machine.name))
        assert told in text
        assert ("cyclic" in text) is told.startswith("cyclic")


def test_watch_json_and_show(machine: HliMemory) -> None:
    picture = json.loads(run("watch", "--once", "--json", "--name", str(machine.name)))
    assert picture["channels"][0]["status"]["line_r"] == 42
    status = json.loads(run("show", "channels.0.status", "--name", str(machine.name)))
    assert status["active_feed_r"] == 25.0


def test_watch_from_another_process_ends_with_the_runtime(machine: HliMemory) -> None:
    code = "from runtime.cli.hli import app; app()"
    arguments = ["watch", "--json", "--interval", "0.02", "--name", str(machine.name)]
    watcher = subprocess.Popen([sys.executable, "-c", code, *arguments], stdout=subprocess.PIPE, text=True)
    assert watcher.stdout is not None
    assert json.loads(watcher.stdout.readline())["running"] is True
    machine.hli.head.running_r = False
    rest, _ = watcher.communicate(timeout=30)
    assert watcher.returncode == 0
    assert json.loads(rest.splitlines()[-1])["running"] is False


def test_header_is_written(tmp_path: os.PathLike[str]) -> None:
    file = os.path.join(tmp_path, "tandem_hli.h")
    run("header", "-o", file)
    with open(file) as text:
        assert text.read() == run("header")


@pytest.fixture
def cnc(machine: HliMemory) -> Iterator[list[Wish]]:
    """A CNC that takes orders, refuses a program named no.nc, and cannot begin one named gone.nc."""
    channel = machine.hli.channels[0]
    history = AlarmHistory(machine.hli)
    commands = ChannelCommands(channel, machine.hli.operator[0])
    wishes: list[Wish] = []
    stop = threading.Event()

    def cycle() -> None:
        while not stop.wait(0.001):
            commands.sample()
            if (order := commands.modes.take(present=False)) is not None:
                wishes.append(order.wish)
                refusal = Problem(catalogue.MODE_RESET_FIRST) if order.wish.parameter == "no.nc" else None
                commands.modes.answer(refusal)
                if order.wish.parameter == "gone.nc":
                    history.add(AlarmLine(0, 6, 7, 300001, Severity.ERROR, "gone.nc: does not exist"))
                    channel.status.line_r = 0
                    channel.control.mode_and_state.state_r = State.ERROR

    thread = threading.Thread(target=cycle)
    thread.start()
    yield wishes
    stop.set()
    thread.join()


def test_commands_reach_the_channel(machine: HliMemory, cnc: list[Wish]) -> None:
    name = ("--name", str(machine.name))
    operator = machine.hli.operator[0]
    run("command", "start", "plate.nc", *name)
    run("command", "stop", *name)
    assert cnc == [Wish(Mode.AUTOMATIC, State.ACTIVE, "plate.nc"), Wish(Mode.AUTOMATIC, State.SELECTED)]
    run("command", "hold", *name)
    run("command", "override", "75", *name)
    run("command", "single-block", "on", *name)
    run("command", "optional-stop", "on", *name)
    assert (operator.feedhold_w, operator.override_w, operator.single_block_w, operator.optional_stop_w) == (
        1,
        750,
        1,
        1,
    )
    run("command", "resume", *name)
    run("command", "single-block", "off", *name)
    assert (operator.feedhold_w, operator.single_block_w) == (0, 0)
    result = CliRunner().invoke(app, ["command", "single-block", "perhaps", *name])
    assert result.exit_code == 2


def test_a_program_that_cannot_begin_says_why(machine: HliMemory, cnc: list[Wish]) -> None:
    machine.hli.channels[0].status.line_r = 0
    result = CliRunner().invoke(app, ["command", "start", "gone.nc", "--name", str(machine.name)])
    assert result.exit_code == 1
    assert "300001: gone.nc: does not exist" in result.output
    assert "304031" not in result.output, "alarms of earlier are not those of this start"


def test_a_machine_that_starts_is_not_one_that_has_ended(machine: HliMemory) -> None:
    head = machine.hli.head
    head.running_r = False
    assert "has ended" in run("watch", "--once", "--name", str(machine.name))
    head.cycle_r = 0
    assert "starting" in run("watch", "--once", "--name", str(machine.name))


def test_a_refused_order_comes_back_with_the_reason(machine: HliMemory, cnc: list[Wish]) -> None:
    with HliMemory.attach(str(machine.name)) as memory, pytest.raises(OrderRefusedError) as refusal:
        Operator(memory, time.sleep).start("no.nc")
    assert refusal.value.problem.entry.id == catalogue.MODE_RESET_FIRST.id
    assert "reset" in refusal.value.problem.text


def test_an_order_that_nobody_takes_is_withdrawn(machine: HliMemory) -> None:
    naps: list[float] = []
    with HliMemory.attach(str(machine.name)) as memory, pytest.raises(HliError, match="304016"):
        Operator(memory, naps.append).start("plate.nc")
    assert sum(naps) == pytest.approx(2.0)
    assert not machine.hli.operator[0].order_semaphor_rw


def test_reset_and_continue_are_handed_over_once(machine: HliMemory) -> None:
    run("command", "reset", "--name", str(machine.name))
    run("command", "continue", "--name", str(machine.name))
    operator = machine.hli.operator[0]
    assert (operator.reset_rw, operator.continue_motion_rw) == (True, True)
