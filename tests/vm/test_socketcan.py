"""The runtime on a PREEMPT_RT kernel with real SocketCAN: master on can0, drives on can1, two cards on one wire.

One boot for all tests of this file: the guest acts (tests.vm.guest.quick), a listener logs the wire, and the tests judge.
"""

from __future__ import annotations

import json
from typing import Any

import pytest

from runtime.diagnostics.catalogue import fieldbus, plc
from tests.vm import capture, parts, qemu
from tests.vm.guest.machine import PERIOD_MS

LIMIT = 2400.0  # s for the whole run in the guest; a quiet computer needs three minutes
AXES = {"X": 1, "Y": 2, "Z": 3}  # name: node
INCREMENTS = 10_000  # per mm
RAPID = {"X": 400.0, "Y": 400.0, "Z": 250.0}  # mm/s
BITRATE = 1_000_000
PATIENCE_OF_THE_PLC = {plc.PLC_ALARM.id}  # its clamp has two seconds, which an emulator on a busy host may miss


class Seen:
    """The observations of the guest and the log of the wire."""

    def __init__(self, run: qemu.GuestRun) -> None:
        self.run = run
        file = run.folder / "observations.json"
        if not file.exists():
            pytest.fail(f"the guest observed nothing; it printed:\n{run.console[-4000:]}")
        self.all: dict[str, Any] = json.loads(file.read_text())
        log = run.folder / "wire.bin"
        self.frames = capture.read(log) if log.exists() else []

    def scene(self, name: str) -> Any:
        if name not in self.all:
            pytest.fail(f"the guest did not get to {name}: {self.all.get('failure', self.run.console[-4000:])}")
        return self.all[name]

    def during(self, begin: str, end: str) -> list[capture.Frame]:
        steps = self.scene("steps")
        return capture.between(self.frames, steps[begin], steps[end])


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> Seen:
    folder = tmp_path_factory.mktemp("vm")
    try:
        return Seen(qemu.run_quick("tests.vm.guest.quick", ["/run/out"], folder, LIMIT))
    except parts.UnavailableError as reason:
        pytest.skip(f"no virtual machine: {reason}")


def test_every_scene_was_played(seen: Seen) -> None:
    assert "failure" not in seen.all, seen.all["failure"]
    assert seen.run.code == 0


def test_the_kernel_is_a_real_time_kernel(seen: Seen) -> None:
    assert "PREEMPT_RT" in seen.scene("kernel")


def test_figures_of_the_master_beside_bare_python_can(seen: Seen, capsys: pytest.CaptureFixture[str]) -> None:
    figures = seen.scene("figures")
    master, bare = figures["master"], figures["bare"]
    with capsys.disabled():
        print(
            f"\nvcan in the emulator, 8 drives and an I/O node, {master['cycles']} cycles: master median "
            f"{master['median_us']:.0f} µs, 99 % {master['p99_us']:.0f} µs; bare python-can, as many frames: "
            f"{bare['median_us']:.0f}, {bare['p99_us']:.0f} µs"
        )
    assert master["cycles"] == bare["cycles"]
    # An RPDO per drive and the SYNC, a TPDO back from each. Heartbeats and outputs come by time: more on a slow computer.
    assert master["sent_per_cycle"] >= 9.0
    assert master["received_per_cycle"] >= 8.0


def test_a_program_is_milled(seen: Seen) -> None:
    scene = seen.scene("milling")
    assert scene["refused"] == ""
    assert ids_of(scene["alarms"]) <= PATIENCE_OF_THE_PLC
    assert scene["positions"][:3] == pytest.approx([20.0, 20.0, 10.0], abs=0.01)
    for (name, node), end in zip(AXES.items(), (20.0, 20.0, 10.0), strict=True):
        on_the_wire = capture.targets(seen.during("enabled", "milled"), node)
        assert on_the_wire[-1][1] == round(end * INCREMENTS), name
    x = [target for _, target in capture.targets(seen.during("enabled", "milled"), AXES["X"])]
    assert max(x) == 80 * INCREMENTS  # the arc's end, no further


def test_a_cycle_is_one_frame_per_drive_and_the_sync(seen: Seen) -> None:
    cycles = list(capture.cycles(seen.during("milling", "milled")))
    assert len(cycles) > 50
    drives = {0x200 + node for node in (1, 2, 3, 6)}
    for cycle in cycles:
        sent = [frame.identifier for frame in cycle if 0x200 < frame.identifier < 0x280 and frame.identifier != 0x20A]
        assert sorted(sent) == sorted(drives)


def test_the_set_points_never_jump(seen: Seen) -> None:
    assert len(seen.frames) > 1000
    for name, node in AXES.items():
        step = capture.largest_step(seen.frames, node) / INCREMENTS
        assert step <= RAPID[name] * PERIOD_MS / 1000.0 * 1.001, name


def test_the_bus_load_is_that_of_the_frames(seen: Seen) -> None:
    frames = seen.during("milling", "milled")
    syncs = sum(frame.identifier == capture.SYNC for frame in frames)
    counted = capture.load(frames, syncs * PERIOD_MS / 1000.0, BITRATE)
    assert seen.scene("milling")["bus_load"] == pytest.approx(
        counted, rel=0.3
    )  # of the last cycles, on a host that may be busy


def ids_of(alarms: list[tuple[int, str]]) -> set[int]:
    return {number for number, _ in alarms}


def test_an_unplugged_node_stops_the_path_and_comes_back(seen: Seen) -> None:
    scene = seen.scene("unplug")
    assert scene["refused"] == ""
    assert scene["after"]["state"] == "ERROR"
    # a moving axis is missed by its following error before its heartbeat is; then its heartbeat is
    assert ids_of(scene["after"]["alarms"]) & {fieldbus.HEARTBEAT_LOST.id, fieldbus.PROCESS_DATA_LOST.id}
    assert scene["after"]["enabled"][1] is False
    after = seen.during("unplugged", "plugged")
    stand = capture.targets(after, AXES["X"])[-50:]
    assert len({target for _, target in stand}) <= 1, "the other axes stand"
    assert seen.scene("steps")["enabled again"] > seen.scene("steps")["plugged"]


def test_a_node_that_booted_again_is_taken_in(seen: Seen) -> None:
    assert {fieldbus.NODE_RESTARTED.id, fieldbus.NODE_REJOINED.id} <= ids_of(seen.scene("reboot")["after"]["alarms"])


def test_a_flood_harms_nobody_or_is_told(seen: Seen) -> None:
    scene = seen.scene("flood")
    flooded = seen.during("flood", "flood over")
    assert sum(frame.identifier == 0x7F0 for frame in flooded) > 100
    assert scene["sent"] > 100
    told = ids_of(scene["after"]["alarms"])
    assert scene["after"]["state"] == "ACTIVE" or told, "it goes on, or says why not"


def test_a_babbling_node_harms_nobody_or_is_told(seen: Seen) -> None:
    scene = seen.scene("babble")
    assert sum(frame.identifier == 0x001 for frame in seen.during("babble", "babble over")) > 100
    told = ids_of(scene["after"]["alarms"])
    assert scene["after"]["state"] == "ACTIVE" or told, "it goes on, or says why not"


def test_bus_off_stops_the_machine_and_every_node_comes_back(seen: Seen) -> None:
    told = ids_of(seen.scene("bus_off")["after"]["alarms"])
    assert {fieldbus.BUS_OFF.id, fieldbus.NODE_REJOINED.id} <= told


def test_an_interface_that_goes_down_and_comes_up(seen: Seen) -> None:
    scene = seen.scene("interface_down")
    assert fieldbus.BUS_GONE.id in ids_of(scene["after"]["alarms"])
    assert not any(scene["after"]["enabled"])
    assert {fieldbus.BUS_BACK.id, fieldbus.NODE_REJOINED.id} <= ids_of(scene["up"]["alarms"])


def test_after_all_that_the_same_program_ends_at_the_same_place(seen: Seen) -> None:
    scene = seen.scene("mill_again")
    assert scene["refused"] == ""
    assert ids_of(scene["alarms"]) <= PATIENCE_OF_THE_PLC
    assert scene["positions"][:3] == pytest.approx(seen.scene("milling")["positions"][:3], abs=0.01)


def test_the_machine_ends_in_order(seen: Seen) -> None:
    assert seen.scene("exit_code") == 0


def test_two_buses_one_of_can_fd_carry_one_machine(seen: Seen) -> None:
    scene = seen.scene("two_buses")
    assert scene["refused"] == ""
    assert ids_of(scene["alarms"]) <= PATIENCE_OF_THE_PLC
    assert scene["positions"][:3] == pytest.approx([20.0, 20.0, 10.0], abs=0.01)
    assert scene["exit_code"] == 0
    fast, classical = scene["fast"], scene["classical"]
    assert set(fast) >= {"0x80", "0x201", "0x203", "0x181", "0x183"}, "Y and Z, with a SYNC of their own"
    assert all(kinds == [True] for kinds in fast.values()), "every frame there is one of CAN FD"
    assert set(classical) >= {"0x80", "0x201", "0x206"}, "X, which shares its number with Y, and the spindle"
    assert all(kinds == [False] for kinds in classical.values())
    assert "0x203" not in classical
