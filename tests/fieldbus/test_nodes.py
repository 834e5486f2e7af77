"""What every simulated node does: SDO and its refusals, PDO mapping as written, NMT, heartbeats, plant, encoders."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import can
import canopen
import pytest
from canopen.sdo.exceptions import SdoAbortedError

from runtime.fieldbus import wire
from runtime.fieldbus.error_codes import EMERGENCY_TEXTS, emergency_text
from runtime.fieldbus.links import wrap32
from runtime.fieldbus.network import PolledNetwork, PumpedSdoClient
from runtime.fieldbus.simulator import EncoderFile, SimulatedNodes, SimulatedPlant
from tests.fieldbus.rig import Rig


class Tool:
    """A configuration tool on the bus: SDO to one node, and all frames that pass."""

    def __init__(self, rig: Rig, node: int = 1) -> None:
        self.rig, self.node = rig, node
        self.network = PolledNetwork(rig.bus)
        self.frames: list[can.Message] = []
        self.client = PumpedSdoClient(node, rig.simulated.nodes[node].local.object_dictionary, self.wait)
        self.client.network = self.network
        rig.idle()
        self.collect()

    def collect(self) -> None:
        while (message := self.rig.bus.recv(0)) is not None:
            self.frames.append(message)
            if message.arbitration_id == 0x580 + self.node:
                self.client.responses.put(bytes(message.data))

    def wait(self, condition: object, seconds: float) -> bool:
        end = self.rig.time + seconds
        while not condition():  # type: ignore[operator]
            if self.rig.time > end:
                return False
            self.rig.idle()
            self.collect()
        return True

    def run(self, seconds: float) -> list[can.Message]:
        """Let time pass; the frames of that time."""
        self.frames.clear()
        self.wait(lambda: False, seconds)
        return list(self.frames)

    def write(self, index: int, subindex: int, value: int, size: int) -> None:
        self.client.download(index, subindex, value.to_bytes(size, "little"))

    def send(self, can_id: int, data: bytes = b"") -> None:
        self.rig.bus.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False))


@pytest.fixture
def tool() -> Iterator[Tool]:
    with Rig() as rig:
        yield Tool(rig)


def test_boot_up_messages(tool: Tool) -> None:
    booted = [m.arbitration_id for m in tool.frames if bytes(m.data) == b"\0"]
    assert sorted(booted) == [0x701, 0x702, 0x703, 0x706, 0x70A]


def test_sdo_reads_numbers_and_long_texts(tool: Tool) -> None:
    assert tool.client.upload(0x1018, 1) == (0x7A4D).to_bytes(4, "little")
    assert tool.client.upload(0x1008, 0) == b"Tandem simulated CiA 402 drive"  # segmented


@pytest.mark.parametrize(
    ("index", "subindex", "value", "size", "code"),
    [
        (0x6999, 0, 0, 1, 0x06020000),
        (0x60C2, 9, 0, 1, 0x06090011),
        (0x6041, 0, 0, 2, 0x06010002),
        (0x6085, 0, 0, 1, 0x06070010),
        (0x60C2, 1, 0, 1, 0x06090032),
        (0x6007, 0, 4, 2, 0x06090031),
        (0x1600, 0, 0, 1, 0x08000022),  # the PDO is switched on
        (0x1400, 2, 1, 1, 0x08000022),
        (0x1003, 0, 3, 1, 0x06090030),
    ],
)
def test_sdo_refusals(tool: Tool, index: int, subindex: int, value: int, size: int, code: int) -> None:
    with pytest.raises(SdoAbortedError) as error:
        tool.write(index, subindex, value, size)
    assert error.value.code == code


def test_mapping_is_what_was_written(tool: Tool) -> None:
    tool.write(0x1801, 1, 0x80000281, 4)
    tool.write(0x1A01, 0, 0, 1)
    tool.write(0x1A01, 1, 0x606C0020, 4)
    tool.write(0x1A01, 2, 0x60610008, 4)
    tool.write(0x1A01, 0, 2, 1)
    tool.write(0x1801, 2, 3, 1)  # with every third SYNC
    tool.write(0x1801, 1, 0x281, 4)
    tool.write(0x6060, 0, 9, 1)
    tool.send(0, bytes((1, 1)))
    tool.run(0.001)
    for _ in range(9):
        tool.send(0x80)
    frames = [bytes(m.data) for m in tool.run(0.002) if m.arbitration_id == 0x281]
    assert frames == [b"\0\0\0\0\x09"] * 3


def test_mappings_that_cannot_be(tool: Tool) -> None:
    tool.write(0x1801, 1, 0x80000281, 4)
    tool.write(0x1A01, 0, 0, 1)
    for entry, code in ((0x60850020, 0x06040041), (0x606C0010, 0x06040041), (0x69990020, 0x06040041)):
        tool.write(0x1A01, 1, entry, 4)
        with pytest.raises(SdoAbortedError) as error:
            tool.write(0x1A01, 0, 1, 1)
        assert error.value.code == code
    for sub in (1, 2, 3):
        tool.write(0x1A01, sub, 0x606C0020, 4)
    with pytest.raises(SdoAbortedError) as error:
        tool.write(0x1A01, 0, 3, 1)
    assert error.value.code == 0x06040042


def test_no_process_data_unless_operational(tool: Tool) -> None:
    tool.send(0x80)
    assert not [m for m in tool.run(0.001) if m.arbitration_id == 0x181]
    # the defaults are event-driven: sent on entering the state
    tool.send(0, bytes((1, 1)))
    assert [m for m in tool.run(0.001) if m.arbitration_id == 0x181]
    tool.send(0, bytes((2, 1)))
    tool.run(0.001)
    tool.rig.simulated.drives[1].servo.position = 1000.0
    assert not [m for m in tool.run(0.001) if m.arbitration_id == 0x181]


def test_heartbeats_at_the_written_period(tool: Tool) -> None:
    tool.write(0x1017, 0, 20, 2)
    beats = [bytes(m.data) for m in tool.run(0.1001) if m.arbitration_id == 0x701]
    assert len(beats) in (4, 5)
    assert set(beats) == {b"\x7f"}
    tool.send(0, bytes((1, 1)))
    assert {bytes(m.data) for m in tool.run(0.05) if m.arbitration_id == 0x701} == {b"\x05"}


def test_reset_communication_forgets_the_configuration_but_not_the_fault(tool: Tool) -> None:
    drive = tool.rig.simulated.drives[1]
    drive.fail(0x2310)
    tool.rig.idle()
    tool.write(0x1017, 0, 20, 2)
    tool.send(0, bytes((130, 1)))
    frames = tool.run(0.1)
    assert [bytes(m.data) for m in frames if m.arbitration_id == 0x701] == [b"\0"]
    assert tool.client.upload(0x603F, 0) == (0x2310).to_bytes(2, "little")
    tool.send(0, bytes((129, 1)))
    tool.run(0.01)
    assert tool.client.upload(0x603F, 0) == b"\0\0"


def test_the_error_history(tool: Tool) -> None:
    drive = tool.rig.simulated.drives[1]
    drive.emergency(0x4310)
    drive.emergency(0x3210)
    assert tool.client.upload(0x1003, 0) == b"\2"
    assert tool.client.upload(0x1003, 1) == (0x3210).to_bytes(4, "little")
    assert tool.client.upload(0x1003, 2) == (0x4310).to_bytes(4, "little")
    assert tool.client.upload(0x1001, 0) == b"\x05"  # generic, voltage
    tool.write(0x1003, 0, 0, 1)
    assert tool.client.upload(0x1003, 0) == b"\0"


@pytest.mark.parametrize("data", [b"", b"\x60", b"\xff" * 8, b"\x60" + bytes(7), b"\x00" * 3, b"\xc0" + bytes(7)])
def test_broken_sdo_requests_harm_nobody(tool: Tool, data: bytes) -> None:
    tool.send(0x601, data)
    tool.run(0.001)
    assert tool.client.upload(0x1018, 1) == (0x7A4D).to_bytes(4, "little")


def test_inputs_are_sent_when_they_change_and_every_tenth_of_a_second() -> None:
    with Rig() as rig:
        rig.started()
        tool = Tool(rig, 10)
        tool.run(0.02)
        assert len([m for m in tool.run(0.2) if m.arbitration_id == 0x18A]) == 2
        rig.simulated.plant.force("door_closed", False)
        values = [m.data[0] for m in tool.run(0.05) if m.arbitration_id == 0x18A]
        assert values == [0b101_0010]


def test_plant_times() -> None:
    plant = SimulatedPlant()
    names = "clamp_closed", "clamp_open", "coolant_pressure", "tool_unlocked", "tool_in_spindle", "door_closed"

    def at(time: float, **outputs: bool) -> list[bool]:
        inputs = plant.step(time, outputs)
        return [inputs[name] for name in names]

    assert at(0.0) == [False, True, False, False, True, True]
    assert at(1.0, clamp_valve=True, coolant_pump=True)[:3] == [False, True, False]
    assert at(1.1, clamp_valve=True, coolant_pump=True)[:3] == [False, False, False]
    assert at(1.25, clamp_valve=True, coolant_pump=True)[:3] == [False, False, True]
    assert at(1.31, clamp_valve=True, coolant_pump=True)[:3] == [True, False, True]
    assert at(1.4, clamp_valve=False, coolant_pump=True)[:2] == [True, False]
    assert at(1.5, clamp_valve=False, coolant_pump=True)[:2] == [False, False]
    assert at(1.75, clamp_valve=False, coolant_pump=True)[:2] == [False, True]
    assert at(2.0, tool_unlock=True)[3] is False
    assert at(2.2, tool_unlock=True)[3:5] == [True, True]
    assert at(2.3, tool_unlock=True, magazine_step=True)[4] is True
    assert at(2.45, tool_unlock=True, magazine_step=False)[4] is False
    assert at(2.81, tool_unlock=True)[4] is True
    plant.force("door_closed", False)
    assert at(3.0)[5] is False
    plant.force("door_closed", None)
    assert at(3.1)[5] is True


def test_encoders_survive_the_process(tmp_path: Path) -> None:
    file = tmp_path / "state" / "encoders"
    encoders = EncoderFile(file)
    with Rig() as rig:
        nodes = SimulatedNodes(rig.machine, rig.bus, encoders=encoders)
        nodes.step(0.0)
        nodes.drives[2].servo.position = -123_456.5
        nodes.step(0.001)
        # not closed: killed
        again = SimulatedNodes(rig.machine, rig.bus, encoders=EncoderFile(file))
        assert again.drives[2].servo.position == -123_456.5
        assert again.drives[1].servo.position == 0.0


def test_a_spoiled_encoder_file_starts_at_zero(tmp_path: Path) -> None:
    file = tmp_path / "encoders"
    file.write_bytes(b"rubbish")
    assert EncoderFile(file)[5] == 0.0
    file.write_bytes(b"\xff" * 1024)  # no numbers
    assert EncoderFile(file)[5] == 0.0


def test_error_codes_have_texts() -> None:
    for code in range(0x10000):
        assert emergency_text(code)
    assert emergency_text(0x2310) == EMERGENCY_TEXTS[0x2310]
    assert emergency_text(0x2315) == EMERGENCY_TEXTS[0x2310]  # the family
    assert emergency_text(0x23F5) == EMERGENCY_TEXTS[0x2000]
    assert emergency_text(0xFF42) == "device specific"
    assert emergency_text(0x0001) == "error reset"
    assert emergency_text(0xB000) == "unknown error"


def test_frame_lengths() -> None:
    assert wire.FRAME_BITS[0] == 47 + 4
    assert 111 <= wire.FRAME_BITS[8] <= 135  # without and with all stuff bits
    assert wire.load([8, 8], 0.001, 1e6) == pytest.approx(2 * wire.FRAME_BITS[8] / 1000)


@pytest.mark.parametrize(
    ("value", "wrapped"),
    [(0, 0), (2**31 - 1, 2**31 - 1), (2**31, -(2**31)), (-(2**31) - 1, 2**31 - 1), (2**32 + 5, 5), (-(2**32) - 5, -5)],
)
def test_wrapping(value: int, wrapped: int) -> None:
    assert wrap32(value) == wrapped


def test_canopens_network_gets_no_threads() -> None:
    import threading

    before = threading.active_count()
    with Rig() as rig:
        rig.enabled()
        assert isinstance(rig.master._network, canopen.Network)
        assert threading.active_count() == before
