"""CAN FD: the same protocol in faster frames, where the interface has them."""

from __future__ import annotations

import can
import pytest

from runtime.config.machine import Bus
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.fieldbus import bus as module
from runtime.fieldbus import wire
from runtime.fieldbus.bus import open_bus
from runtime.fieldbus.described import make_links
from runtime.fieldbus.network import as_fd
from tests.fieldbus.rig import Rig, demo_description
from tests.fieldbus.test_bus import Answers, refused


def test_a_machine_runs_on_frames_of_can_fd() -> None:
    description = demo_description()
    description["fieldbus"]["bus"]["fd"] = True
    with Rig(description) as rig, open_bus(rig.machine.fieldbus.bus) as listener:
        rig.enabled()
        while listener.recv(0) is not None:
            pass
        rig.cycle(300)
        assert rig.event_ids() == []
        frames = []
        while (message := listener.recv(0)) is not None:
            frames.append(message)
        assert len(frames) > 2000
        assert all(frame.is_fd and frame.bitrate_switch for frame in frames)
        planned = wire.planned_load(make_links(rig.machine), rig.machine.fieldbus.bus, rig.machine.cycle.period)
        assert rig.image.bus_load == pytest.approx(planned, rel=0.01)
        classic = rig.machine.fieldbus.bus.model_copy(update={"fd": False})
        assert planned < 0.7 * wire.planned_load(make_links(rig.machine), classic, rig.machine.cycle.period)


def test_frames_as_long_as_the_standard_says() -> None:
    """Without stuffing: 29 bits at the nominal rate, 33 + 8 n at that of the data; stuffing adds at most a quarter."""
    slow = Bus(fd=True, bitrate=1_000_000, data_bitrate=1_000_000)
    fast = Bus(fd=True, bitrate=1_000_000, data_bitrate=8_000_000)
    for n in range(9):
        bare = 29 + 33 + 8 * n
        assert bare < wire.frame_bits(slow)[n] < bare * 1.25
        assert wire.frame_bits(fast)[n] == pytest.approx(wire.FD_NOMINAL + wire.FD_DATA[n] / 8)
    assert wire.frame_bits(Bus()) == wire.FRAME_BITS


@pytest.fixture
def kernel(monkeypatch: pytest.MonkeyPatch) -> Answers:
    return Answers(monkeypatch)


def test_the_interface_is_asked(kernel: Answers, monkeypatch: pytest.MonkeyPatch) -> None:
    config = Bus(interface="socketcan", channel="can0", fd=True)
    monkeypatch.setattr(module, "_interface_mtu", lambda channel: 16)
    assert "can0 does not take frames of CAN FD" in refused(config, catalogue.BUS_NO_FD)
    assert kernel.opened == {}
    monkeypatch.setattr(module, "_interface_mtu", lambda channel: 72)
    open_bus(config)
    assert kernel.opened["fd"] is True
    open_bus(Bus(interface="socketcan", channel="can0"))
    assert kernel.opened["fd"] is False


def test_questions_to_guarded_nodes_stay_classic() -> None:
    question = can.Message(arbitration_id=0x701, is_remote_frame=True, is_extended_id=False)
    sync = can.Message(arbitration_id=0x80, is_extended_id=False)
    for message in (question, sync):
        as_fd(message)
    assert (question.is_fd, sync.is_fd) == (False, True)
