"""Boot of the bus against simulated nodes: what it configures, and every way in which it is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import can
import pytest

from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.diagnostics.errors import ErrorEntry
from runtime.drives import DriveState
from runtime.fieldbus.dialogue import interpolation_time
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.simulator import Fault
from tests.fieldbus.rig import Rig, demo_description


def refused(rig: Rig, entry: ErrorEntry) -> str:
    """The text of the error that `start` raises, which must be of this entry."""
    with pytest.raises(FieldbusError) as error:
        rig.master.start()
    assert error.value.problem.entry is entry
    assert error.value.problem.explained()
    assert all(state == DriveState.OFFLINE or not rig.image.enable.any() for state in rig.image.state)
    return error.value.problem.text


def object_of(rig: Rig, node: int, index: int, subindex: int = 0) -> int:
    """What stands in a node's dictionary now."""
    local = rig.simulated.nodes[node].local
    variable = local.object_dictionary.get_variable(index, subindex)
    assert variable is not None
    return int(variable.decode_raw(local.get_data(index, subindex)))


def test_the_demo_machine_boots() -> None:
    with Rig() as rig:
        rig.started()
        assert rig.event_ids() == []
        assert set(rig.image.state.tolist()) == {DriveState.SWITCH_ON_DISABLED}
        # clamp_open, tool_in_spindle, door_closed, e_stop_ok are there before the first cycle
        assert rig.image.digital_in[0] == 0b111_0010


def test_what_a_drive_is_told() -> None:
    description = demo_description()
    description["axes"][0]["drive"]["sdo"] = {"0x6085": 123_456, "0x60C2:1": 2}
    with Rig(description) as rig:
        rig.master.start()
        assert object_of(rig, 1, 0x1017) == 100
        assert object_of(rig, 1, 0x1016, 1) == 127 << 16 | 300
        assert object_of(rig, 1, 0x6060) == 8
        assert object_of(rig, 6, 0x6060) == 9
        assert object_of(rig, 1, 0x1600, 0) == 2
        assert object_of(rig, 1, 0x1600, 2) == 0x607A0020
        assert object_of(rig, 6, 0x1600, 2) == 0x60FF0020
        assert object_of(rig, 1, 0x1400, 1) == 0x201
        assert object_of(rig, 1, 0x1800, 2) == 1  # with every SYNC
        assert object_of(rig, 1, 0x1801, 1) & 0x8000_0000  # not used by an axis
        assert object_of(rig, 6, 0x1801, 2) == 10
        assert object_of(rig, 2, 0x6085) == 40_000_000  # 4 m/s²
        assert object_of(rig, 1, 0x6085) == 123_456  # the start-up list has the last word
        assert (object_of(rig, 2, 0x60C2, 1), object_of(rig, 2, 0x60C2, 2)) == (1, -3)
        assert object_of(rig, 1, 0x60C2, 1) == 2


def test_start_again_after_stop() -> None:
    with Rig() as rig:
        rig.enabled()
        rig.master.stop()
        assert set(rig.image.state.tolist()) == {DriveState.SWITCH_ON_DISABLED}
        rig.events.clear()
        rig.enabled()
        assert rig.event_ids() == []


def test_missing_nodes_are_named() -> None:
    with Rig() as rig:
        rig.simulated.inject(2, Fault.SILENT)
        rig.simulated.inject(10, Fault.SILENT)
        text = refused(rig, catalogue.NODE_MISSING)
        assert "node 2 (axis Y), node 10 (I/O node 0)" in text
        assert "node 1 " not in text


def test_an_empty_bus() -> None:
    with Rig(nodes=False) as rig:
        assert "node 6 (axis S)" in refused(rig, catalogue.NODE_MISSING)


def test_a_node_that_comes_late_is_waited_for() -> None:
    with Rig() as rig:
        rig.simulated.inject(3, Fault.SILENT)
        idle = rig.idle

        def late() -> None:
            idle()
            if rig.time > 2.0 and rig.simulated.nodes[3].silent:
                rig.simulated.heal(3)
                rig.simulated.inject(3, Fault.REBOOT)

        rig.master._idle = late
        rig.started()
        assert rig.time > 2.0
        assert rig.image.state[2] == DriveState.SWITCH_ON_DISABLED


def test_wrong_vendor() -> None:
    with Rig() as rig:
        rig.simulated.inject(3, Fault.WRONG_VENDOR)
        assert "node 3 (axis Z) is of vendor 0x1234" in refused(rig, catalogue.WRONG_VENDOR)


def test_wrong_product() -> None:
    description = demo_description()
    description["axes"][1]["drive"]["product_code"] = 0x999
    with Rig(description) as rig:
        assert "0x402" in refused(rig, catalogue.WRONG_PRODUCT)


def test_a_drive_where_io_should_be() -> None:
    description = demo_description()
    with Rig(description) as rig:
        device_type = rig.simulated.drives[1].local.object_dictionary.get_variable(0x1000)
        assert device_type is not None
        device_type.default = 0x00030191
        assert "401, expected is 402" in refused(rig, catalogue.WRONG_DEVICE_TYPE)


def test_a_drive_without_the_cyclic_mode() -> None:
    with Rig() as rig:
        drive = rig.simulated.drives[6]
        rig.idle()
        drive.values[0x6502, 0] = 0x80  # position only; S is a spindle
        assert "cyclic synchronous velocity" in refused(rig, catalogue.MODE_UNSUPPORTED)


def test_another_master_on_the_bus() -> None:
    with Rig() as rig:
        rig.started()
        with can.Bus(interface="virtual", channel=rig.machine.fieldbus.bus.channel) as other:
            idle = rig.idle

            def with_other_master() -> None:
                idle()
                other.send(can.Message(arbitration_id=0x80, is_extended_id=False))

            rig.master._idle = with_other_master
            refused(rig, catalogue.OTHER_MASTER)


def test_a_node_that_refuses_a_start_up_write() -> None:
    description = demo_description()
    description["axes"][0]["drive"]["sdo"] = {"0x60C2:1": 0}  # fits the type, but not the object's limits
    with Rig(description) as rig:
        text = refused(rig, catalogue.SDO_ABORTED)
        assert "0x60C2:1" in text
        assert "too low" in text


def test_a_node_that_falls_silent_during_configuration() -> None:
    with Rig() as rig:
        network = rig.simulated._network
        answers = 0
        send = network.send_message

        def send_some(can_id: int, data: bytes, remote: bool = False) -> None:
            nonlocal answers
            answers += can_id == 0x582
            if can_id != 0x582 or answers < 10:
                send(can_id, data, remote)

        network.send_message = send_some  # type: ignore[method-assign]
        assert "node 2 (axis Y)" in refused(rig, catalogue.SDO_NO_ANSWER)


def test_a_node_that_does_not_become_operational() -> None:
    with Rig() as rig:
        rig.idle()
        node = rig.simulated.ios[10]
        rig.simulated._network.unsubscribe(0, node.local.nmt.on_command)
        rig.simulated._network.unsubscribe(0, node._on_nmt)
        rig.master._idle = reboot_once(rig)
        text = refused(rig, catalogue.NODE_NOT_OPERATIONAL)
        assert "pre-operational" in text


def reboot_once(rig: Rig) -> Any:
    """A node that hears no NMT commands boots by itself when the master waits for it."""
    idle, done = rig.idle, False

    def step() -> None:
        nonlocal done
        idle()
        if not done and rig.time > 0.2:
            done = True
            rig.simulated.inject(10, Fault.REBOOT)

    return step


@pytest.mark.parametrize(
    ("sdo", "reason"),
    [
        ({"6085h": 1}, "no object"),
        ({"0x6999": 1}, "no such object"),
        ({"0x60C2:7": 1}, "no such object"),
        ({"0x6041": 1}, "read-only"),
        ({"0x60C2:1": 256}, "0 to 255"),
        ({"0x6085": -1}, "0 to 4294967295"),
    ],
)
def test_start_up_writes_that_cannot_be(sdo: dict[str, int], reason: str) -> None:
    description = demo_description()
    description["axes"][0]["drive"]["sdo"] = sdo
    with Rig(description) as rig:
        assert reason in refused(rig, catalogue.STARTUP_OBJECT)


@pytest.mark.parametrize(
    "content", [None, b"", b"\x00\xff\x00binary", b"[1000\nParameterName", b"[1000]\nParameterName=x\n", b"hello"]
)
def test_eds_files_that_cannot_be_read(tmp_path: Path, content: bytes | None) -> None:
    file = tmp_path / "device.eds"
    if content is not None:
        file.write_bytes(content)
    description = demo_description()
    description["axes"][0]["drive"]["eds"] = str(file)
    with Rig(description) as rig:
        assert "node 1 (axis X)" in refused(rig, catalogue.EDS_UNREADABLE)


def eds_without(tmp_path: Path, change: tuple[str, str]) -> str:
    from runtime.fieldbus.described import DRIVE_EDS, eds_path

    text = Path(eds_path(None, DRIVE_EDS)).read_text(encoding="utf-8")
    assert change[0] in text
    file = tmp_path / "changed.eds"
    file.write_text(text.replace(*change), encoding="utf-8")
    return str(file)


def test_an_eds_without_a_needed_object(tmp_path: Path) -> None:
    description = demo_description()
    description["axes"][0]["drive"]["eds"] = eds_without(tmp_path, ("[607A]", "[2FFF]"))
    with Rig(description) as rig:
        assert "0x607A" in refused(rig, catalogue.EDS_OBJECT_MISSING)


def test_an_eds_whose_types_are_not_those_of_the_profile(tmp_path: Path) -> None:
    description = demo_description()
    change = ("ParameterName=Target position\nObjectType=0x7\nDataType=0x0004", "ParameterName=T\nDataType=0x0007")
    description["axes"][0]["drive"]["eds"] = eds_without(tmp_path, change)
    with Rig(description) as rig:
        assert "0x607A" in refused(rig, catalogue.EDS_UNREADABLE)


@pytest.mark.parametrize("direction", ["inputs", "outputs"])
def test_too_many_bits_for_one_node(direction: str) -> None:
    description = demo_description()
    description["fieldbus"]["io"][0][direction] = [f"b{k}" for k in range(65)]
    with Rig(description, nodes=False) as rig:
        assert "65" in refused(rig, catalogue.TOO_MANY_BITS)


def test_too_many_bits_for_the_image() -> None:
    description = demo_description()
    description["fieldbus"]["io"] = [{"node": 20 + n, "inputs": [f"n{n}b{k}" for k in range(64)]} for n in range(9)]
    with Rig(description, nodes=False) as rig:
        assert "576" in refused(rig, catalogue.TOO_MANY_BITS)


@pytest.mark.parametrize(
    ("period", "expected"),
    [(0.001, (1, -3)), (0.002, (2, -3)), (0.00025, (25, -5)), (0.0005, (5, -4)), (0.01, (10, -3))],
)
def test_interpolation_periods(period: float, expected: tuple[int, int]) -> None:
    assert interpolation_time(period) == expected


def test_a_period_that_no_drive_can_be_told() -> None:
    description = demo_description()
    description["cycle"]["period"] = 0.00123456789
    with Rig(description, nodes=False) as rig:
        assert "1234.57 µs" in refused(rig, catalogue.CYCLE_NOT_REPRESENTABLE)


def test_the_bus_goes_away_during_boot() -> None:
    with Rig(nodes=False) as rig:
        rig.bus.shutdown()
        refused(rig, catalogue.BUS_GONE)


def test_the_stored_configuration_is_checked_when_it_is_described() -> None:
    description = demo_description()
    description["axes"][1]["drive"]["configuration"] = [15_000, 3_600_000]
    with Rig(description) as rig, pytest.raises(FieldbusError) as refusal:
        rig.master.start()
    assert refusal.value.problem.entry is catalogue.WRONG_CONFIGURATION
    assert "node 2 (axis Y) is of date and time (0, 0) (object 0x1020), expected is (15000, 3600000)" in str(
        refusal.value
    )
    description = demo_description()
    description["axes"][1]["drive"]["configuration"] = [0, 0]
    with Rig(description) as rig:
        rig.master.start()
