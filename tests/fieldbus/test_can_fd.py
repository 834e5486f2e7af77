"""CAN FD: the same protocol in faster frames, where the interface has them."""

from __future__ import annotations

import can
import pytest

from runtime.config.machine import Bus
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.diagnostics.errors import ErrorEntry
from runtime.fieldbus import bus as module
from runtime.fieldbus import wire
from runtime.fieldbus.bus import open_bus
from runtime.fieldbus.described import make_links
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.network import as_fd
from runtime.fieldbus.simulator import Fault
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


# -- devices of CANopen FD -------------------------------------------------------------------------------------------


class FdDevice:
    """A device of CANopen FD with node id 2 in the place of Y's drive: it boots, beats and answers by USDO, and has no SDO."""

    def __init__(self, rig: Rig, *, emergency: bool = False, usdo: bool = True) -> None:
        self._bus = can.Bus(interface="virtual", channel=rig.machine.fieldbus.bus.channel)
        self._emergency, self._usdo = emergency, usdo
        rig.simulated.inject(2, Fault.SILENT)
        step = rig.simulated.step

        def both(now: float) -> None:
            step(now)
            self.poll()

        rig.simulated.step = both  # type: ignore[method-assign]

    def _send(self, cob_id: int, data: bytes) -> None:
        message = can.Message(arbitration_id=cob_id, data=data, is_extended_id=False, is_fd=True, bitrate_switch=True)
        self._bus.send(message)

    def poll(self) -> None:
        while (message := self._bus.recv(0)) is not None:
            if message.arbitration_id == 0 and message.data[0] in (129, 130):
                self._send(0x702, b"\x00")
                if self._emergency:
                    self._send(0x082, bytes(20))
            elif message.arbitration_id == 0x600 + 127 and message.data[0] == 2 and self._usdo:
                assert message.is_fd
                _, _, session, sub, low, high = message.data[:6]
                # destination, command, session, sub-index, index, type, size, the device type
                answer = bytes((127, 0x31, session, sub, low, high, 7, 4)) + (402).to_bytes(4, "little")
                self._send(0x582, answer)

    def close(self) -> None:
        self._bus.shutdown()


@pytest.mark.parametrize(
    ("emergency", "usdo", "entry"),
    [
        (True, False, catalogue.CANOPEN_FD),
        (False, True, catalogue.CANOPEN_FD),
        (False, False, catalogue.SDO_NO_ANSWER),  # nothing gives it away
    ],
)
def test_a_device_of_canopen_fd_is_refused_by_its_name(emergency: bool, usdo: bool, entry: ErrorEntry) -> None:
    description = demo_description()
    description["fieldbus"]["bus"]["fd"] = True
    with Rig(description) as rig:
        device = FdDevice(rig, emergency=emergency, usdo=usdo)
        try:
            with pytest.raises(FieldbusError) as error:
                rig.master.start()
            assert error.value.problem.entry is entry
            assert "node 2 (axis Y)" in error.value.problem.text
            if entry is catalogue.CANOPEN_FD:
                assert "CiA 1301" in error.value.problem.text
        finally:
            device.close()


def test_nobody_is_asked_by_usdo_on_a_classic_bus() -> None:
    with Rig() as rig, open_bus(rig.machine.fieldbus.bus) as listener:
        device = FdDevice(rig)
        try:
            with pytest.raises(FieldbusError) as error:
                rig.master.start()
        finally:
            device.close()
        assert error.value.problem.entry is catalogue.SDO_NO_ANSWER
        ids = set()
        while (message := listener.recv(0)) is not None:
            ids.add(message.arbitration_id)
        assert 0x602 in ids
        assert 0x600 + 127 not in ids
