"""The package as a systemd service of a Debian system of its own: installed, run, stopped, killed, frozen, and without power.

Several boots of one disk: the guest acts (tests.vm.guest.full), a listener logs the wire, and the tests judge.
"""

from __future__ import annotations

import json
import random
from pathlib import Path
from typing import Any

import pytest

from runtime.diagnostics.catalogue import machine as alarms
from tests.vm import capture, parts, qemu
from tests.vm.guest.machine import PERIOD_MS
from tests.vm.guest.writers import STORES

FIRST_LIMIT = 3600.0  # s
BOOT_LIMIT = 1500.0  # s of each further boot
POWER_CUTS = 3  # one in motion, the others while the service starts
AXES = {"X": (1, 400.0), "Y": (2, 400.0), "Z": (3, 250.0)}  # name: node, mm/s
INCREMENTS = 10_000  # per mm
ORDERED = (0x0F, 0x07, 0x06, 0x00)  # control words of a drive that is switched off: each takes one thing back
SCHED_FIFO, RESET_ON_FORK = 1, 0x4000_0000


class Story:
    """All boots of one disk."""

    def __init__(self, folder: Path) -> None:
        for store in STORES:  # the guest's writers are not root
            (folder / f"promised-{store}").touch()
            (folder / f"promised-{store}").chmod(0o666)
        self.folder = folder
        self.disk = qemu.Disk(folder)
        self.parts: list[dict[str, Any]] = []  # of what was observed after each loss of power
        self.promised: list[dict[str, int]] = []
        self.consoles: list[str] = []

    def play(self) -> None:
        chance = random.Random(11)
        self._boot("first", FIRST_LIMIT)
        self.first = self._seen("first")
        if "stop" not in self.first:  # it did not get so far that there is something to survive
            return
        for number in range(POWER_CUTS):
            part = "after" if number else "power"
            self._boot(part, BOOT_LIMIT, cut=chance.uniform(0.5, 4.0))
            self.promised.append(
                {store: int((self.folder / f"promised-{store}").read_bytes() or b"0") for store in STORES}
            )
            if number:
                self.parts.append(self._seen(part))
        self._boot("last", BOOT_LIMIT)
        self.parts.append(self._seen("last"))

    def _boot(self, part: str, limit: float, cut: float | None = None) -> None:
        self.consoles.append(self.disk.boot(part, limit, cut).console)

    def _seen(self, part: str) -> dict[str, Any]:
        file = self.folder / f"{part}.json"
        if not file.exists():
            pytest.fail(f"the guest observed nothing in {part}; it printed:\n{self.consoles[-1][-4000:]}")
        seen: dict[str, Any] = json.loads(file.read_text())
        file.unlink()
        return seen

    def scene(self, name: str) -> Any:
        if name not in self.first:
            pytest.fail(f"the guest did not get to {name}: {self.first.get('failure', self.consoles[0][-4000:])}")
        if "failure" in self.first[name]:
            pytest.fail(self.first[name]["failure"])
        return self.first[name]

    def frames(self, log: str = "first") -> list[capture.Frame]:
        return capture.read(self.folder / f"wire-{log}.bin")

    def between(self, begin: str, end: str) -> list[capture.Frame]:
        steps = self.first["steps"]
        return capture.between(self.frames(), steps[begin], steps[end])

    def journal(self) -> list[dict[str, str]]:
        return [json.loads(line) for line in (self.folder / "journal.jsonl").read_text().splitlines()]


@pytest.fixture(scope="module")
def story(tmp_path_factory: pytest.TempPathFactory) -> Story:
    folder = tmp_path_factory.mktemp("service")
    folder.chmod(0o777)
    try:
        story = Story(folder)
    except parts.UnavailableError as reason:
        pytest.skip(f"no virtual machine: {reason}")
    story.play()
    return story


def ids(look: dict[str, Any]) -> set[int]:
    return {number for number, _ in look["alarms"]}


def assert_stopped_in_order(frames: list[capture.Frame]) -> None:
    """The axes come to rest step by step, then the drives are switched off one thing after the other."""
    for name, (node, rapid) in AXES.items():
        assert capture.largest_step(frames, node) / INCREMENTS <= rapid * PERIOD_MS / 1000.0 * 1.001, name
        targets = capture.targets(frames, node)
        assert len(targets) > 5, name
        assert targets[-1][1] == targets[-2][1], f"{name} stands before its drive is switched off"
        words = capture.control_words(frames, node)
        last = words.index(ORDERED[0])
        assert words[last:] == list(ORDERED[: len(words[last:])]), f"{name}: {[hex(word) for word in words]}"
        assert len(words[last:]) > 1, f"{name} is switched off"


def test_every_scene_was_played(story: Story) -> None:
    assert "failure" not in story.first, story.first["failure"]
    for seen in story.parts:
        assert "failure" not in seen, seen["failure"]


def test_it_was_installed_as_readme_says(story: Story) -> None:
    commands = story.scene("installed")
    assert any("systemd-sysusers" in command for command in commands)
    assert any("daemon-reload" in command for command in commands)
    assert "PREEMPT_RT" in story.scene("kernel")


def test_every_process_is_without_root_and_without_capabilities(story: Story) -> None:
    found = story.scene("processes")
    assert set(found["who"]) == {"service", "cycle", "preparation", "plc"}
    for name, who in found["who"].items():
        assert set(who["Uid"].split()) == {str(found["uid"])}, name
        assert {who[kind] for kind in ("CapPrm", "CapEff", "CapBnd", "CapAmb")} == {"0" * 16}, name
        assert (who["NoNewPrivs"], who["Seccomp"]) == ("1", "2"), name
    assert found["who"]["cycle"]["policy"] & ~RESET_ON_FORK == SCHED_FIFO, "real-time by a limit, without a privilege"
    assert not found["who"]["cycle"]["VmLck"].startswith("0 "), "its memory is locked"
    assert found["unit"]["User"] == "tandem"
    assert found["unit"]["Type"] == "notify"
    assert float(found["exposure"].split("level for tandem.service:")[1].split()[0]) <= 3.0


def test_the_network_finds_the_metrics_on_the_loopback_interface_and_nothing_else(story: Story) -> None:
    sockets = [socket for socket in story.scene("processes")["sockets"] if socket["listening"]]
    assert sockets == [{"family": "tcp", "address": "127.0.0.1", "port": 9402, "listening": True}]


def test_metrics_are_read_here_only_and_change_nothing(story: Story) -> None:
    found = story.scene("metrics")
    assert 'axis="X"' in found["text"]
    assert "tandem_cycle_work_seconds_bucket" in found["text"]
    assert "refused" in found["elsewhere"]
    assert not any(answer.startswith("answered 2") for answer in found["refused"].values()), found["refused"]


def test_the_group_looks_on_and_only_the_owner_commands(story: Story) -> None:
    found = story.scene("access")
    assert [found["tandem"][what][0] for what in ("watch", "command")] == [0, 0]
    assert [found["watcher"][what][0] for what in ("watch", "command")] == [0, 1]
    assert [found["stranger"][what][0] for what in ("watch", "command")] == [1, 1]
    processes = story.scene("processes")
    assert processes["memory"]["tandem"] == ["0o640", processes["uid"], processes["memory"]["tandem"][2]]
    assert all(int(mode, 8) & 0o007 == 0 for mode, *_ in processes["memory"].values())
    assert all(int(mode, 8) & 0o007 == 0 for mode, _ in processes["state"].values())


def test_a_program_is_milled(story: Story) -> None:
    assert story.scene("milling")["positions"][:3] == pytest.approx([20.0, 20.0, 10.0], abs=0.01)


def test_stop_in_motion_brings_the_axes_to_rest_and_switches_the_drives_off_in_order(story: Story) -> None:
    found = story.scene("stop")
    assert found["refused"] == ""
    assert (found["unit"]["ActiveState"], found["unit"]["Result"]) == ("inactive", "success")
    assert found["left"] == []
    assert found["retained"]["problems"] == []
    frames = story.between("moving before stop", "stop done")
    assert_stopped_in_order(frames)
    for name, (node, _) in AXES.items():
        end = capture.targets(frames, node)[-1][1] / INCREMENTS
        assert found["retained"]["positions"][name] == pytest.approx(end, abs=0.05), "no position was lost"


def test_restart_in_motion_stops_in_order_and_nothing_goes_on_by_itself(story: Story) -> None:
    found = story.scene("restart")
    assert found["unit"] == {"Result": "success", "NRestarts": "0"}
    frames = story.between("moving before restart", "started again")
    off = next(i for i, frame in enumerate(frames) if frame.identifier == 0x201 and frame.data[0] in ORDERED[1:])
    assert_stopped_in_order(frames[: off + 20])
    for name, (node, _) in AXES.items():
        assert len({target for _, target in capture.targets(frames[off + 20 :], node)}) <= 1, f"{name} stays"
    assert found["after"]["state"] == "SELECTED"
    assert alarms.AXIS_MOVED.id not in ids(found["after"])


def test_a_killed_main_process_leaves_the_cycle_the_time_to_brake(story: Story) -> None:
    found = story.scene("killed")
    frames = story.between("killed now", "killed: restarted by systemd")
    assert_stopped_in_order(frames)
    assert alarms.SERVICE_LOST.id in ids(found["after"])
    assert alarms.AXIS_MOVED.id not in ids(found["after"])


def test_a_frozen_cycle_is_noticed_and_started_anew(story: Story) -> None:
    found = story.scene("frozen")
    assert found["noticed_s"] < 120.0
    frames = story.between("frozen now", "frozen: restarted by systemd")
    assert sum(frame.identifier == capture.SYNC for frame in frames) <= 2, "it was frozen"
    assert alarms.CYCLE_LOST.id in ids(found["after"]), "the history tells why"
    assert all(found["after"]["enabled"])


def test_the_journal_has_structured_entries(story: Story) -> None:
    entries = story.journal()
    lost = [entry for entry in entries if entry.get("TANDEM_ERROR_ID") == str(alarms.AXIS_MOVED.id)]
    starts = [entry for entry in entries if entry.get("TANDEM_EVENT")]
    assert starts or lost
    for entry in starts:
        assert entry["SYSLOG_IDENTIFIER"] == "tandem"
        assert entry["_SYSTEMD_UNIT"] == "tandem.service"
        assert entry["PRIORITY"].isdigit()
    assert not any("Traceback" in str(entry.get("MESSAGE")) for entry in entries)


def test_power_losses_lose_nothing_that_was_promised_and_tear_nothing(story: Story) -> None:
    assert len(story.parts) == POWER_CUTS
    for promised, seen in zip(story.promised, story.parts, strict=True):
        assert all(number > 0 for number in promised.values()), "it was written when the power went"
        for store in STORES:
            assert seen["probe"][store] >= promised[store], store
        assert seen["torn"] == []
        assert seen["retained"]["problems"] == []
        assert alarms.SERVICE_LOST.id in seen["retained"]["alarms"], "the history of the first boot is there"
    counted = [seen["counted"] for seen in story.parts]
    assert counted[0] > 0
    assert counted == sorted(counted), "the PLC's variable is never set back"


def test_it_starts_at_boot_behind_its_bus_and_ends_in_order(story: Story) -> None:
    last = story.parts[-1]
    started = int(last["boot"]["tandem.service"]["ExecMainStartTimestampMonotonic"])
    network = int(last["boot"]["systemd-networkd.service"]["ActiveEnterTimestampMonotonic"])
    device = int(last["boot"]["sys-subsystem-net-devices-can0.device"]["ActiveEnterTimestampMonotonic"])
    assert 0 < network < started
    assert 0 < device < started
    frames = story.frames("last")
    begin = last["steps"]["moving before shutdown"]
    assert_stopped_in_order(capture.between(frames, begin, begin + 1e6))
