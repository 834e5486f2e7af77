"""Nodes and buses that are lost and come back while the machine runs; nothing jumps, nobody else notices."""

from __future__ import annotations

import errno
import itertools
from collections.abc import Iterator

import can
import pytest
from canopen.sdo.exceptions import SdoAbortedError

from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.drives import DriveState
from runtime.fieldbus.beat import time_of_day
from runtime.fieldbus.cia402 import POSITION_ACTUAL
from runtime.fieldbus.simulator import Fault
from tests.fieldbus.rig import Rig, demo_description
from tests.fieldbus.test_operation import ENABLED, Failing, X, Y, Z, ids, move


@pytest.fixture
def rig() -> Iterator[Rig]:
    with Rig() as rig:
        yield rig.enabled()


def back(rig: Rig, node: int) -> bool:
    return (catalogue.NODE_REJOINED.id, node) in [(event.error_id, event.node) for event in rig.events]


def take_over(rig: Rig, axis: int) -> None:
    """As the axes do it: track, acknowledge, enable."""
    image = rig.image
    image.enable[axis] = False
    for _ in range(20):
        image.target_position[axis] = image.actual_position[axis]
        rig.cycle()
    image.reset_fault[axis] = True
    rig.cycle(20)
    image.reset_fault[axis] = False
    image.target_position[axis] = image.actual_position[axis]
    image.enable[axis] = True
    assert rig.run_until(lambda: image.state[axis] == ENABLED)


@pytest.mark.parametrize("fault", [Fault.SILENT, Fault.REBOOT])
def test_a_lost_drive_comes_back_and_moves_on_without_a_jump(rig: Rig, fault: Fault) -> None:
    move(rig, Y, 100.0, 100)
    rig.simulated.inject(2, fault)
    assert rig.run_until(lambda: rig.image.state[Y] == DriveState.OFFLINE)
    rig.cycle(500)
    rig.simulated.heal(2)
    assert rig.run_until(lambda: back(rig, 2), 5.0)
    assert rig.image.state[Y] != ENABLED
    assert rig.image.state[X] == rig.image.state[Z] == ENABLED  # nobody else noticed
    drive = rig.simulated.drives[2]
    rig.cycle(3000)  # it lost its supply in motion and coasts
    before = drive.servo.position
    take_over(rig, Y)
    assert drive.servo.position == pytest.approx(before, abs=1.0)
    move(rig, Y, 100.0, 100)
    rig.cycle(100)
    assert rig.image.actual_position[Y] == pytest.approx(rig.image.target_position[Y], abs=1e-3)
    assert drive.local.get_data(0x1016, 1)  # configured anew, not only started


def test_a_drive_that_comes_back_is_configured_whole(rig: Rig) -> None:
    def configuration() -> dict[tuple[int, int], bytes]:
        store = rig.simulated.drives[3].local.data_store
        return {(index, sub): bytes(data) for index, subs in store.items() for sub, data in subs.items()}

    at_boot = configuration()
    rig.simulated.inject(3, Fault.REBOOT)
    assert rig.run_until(lambda: back(rig, 3), 5.0)
    assert configuration() == at_boot


def test_one_frame_per_cycle_is_all_that_a_return_costs(rig: Rig) -> None:
    rig.cycle(200)
    rig.simulated.inject(3, Fault.REBOOT)
    worst = 0
    while not back(rig, 3):
        before = rig.image.frames_sent
        rig.cycle()
        worst = max(worst, rig.image.frames_sent - before)
    # four set-points, SYNC, now and then outputs and a heartbeat, one request
    assert worst <= 4 + 1 + 1 + 1 + 1


def test_how_far_it_was_moved_meanwhile_is_told(rig: Rig) -> None:
    rig.simulated.inject(3, Fault.SILENT)
    rig.cycle(600)
    rig.simulated.drives[3].servo.position -= 25_000
    rig.simulated.heal(3)
    assert rig.run_until(lambda: back(rig, 3), 5.0)
    assert rig.problems()[-1].text == "node 3 (axis Z) is back in operation; it was moved by -2.500 meanwhile"
    assert rig.image.actual_position[Z] == pytest.approx(-2.5, abs=1e-3)


def test_another_device_in_its_place_is_refused_until_the_right_one_comes(rig: Rig) -> None:
    rig.simulated.inject(2, Fault.WRONG_VENDOR)
    rig.simulated.inject(2, Fault.REBOOT)
    rig.cycle(6000)
    refusals = [problem for problem in rig.problems() if problem.entry is catalogue.REJOIN_REFUSED]
    assert len(refusals) == 1  # tried every two seconds, told once
    assert "is of vendor 0x1234, the machine description expects 0x7A4D" in refusals[0].text
    assert rig.image.state[Y] == DriveState.OFFLINE
    rig.simulated.heal(2)
    assert rig.run_until(lambda: back(rig, 2), 5.0)


def test_a_refused_object_is_told_in_words(rig: Rig) -> None:
    drive = rig.simulated.drives[1]
    write = drive._on_write

    def refuse(index: int, subindex: int, od: object, data: bytes) -> None:
        if index == 0x6085:
            raise SdoAbortedError(0x06090031)
        write(index, subindex, od, data)  # type: ignore[arg-type]

    drive.local._write_callbacks[:] = [refuse]
    rig.simulated.inject(1, Fault.REBOOT)
    rig.cycle(1000)
    (refusal,) = [problem for problem in rig.problems() if problem.entry is catalogue.REJOIN_REFUSED]
    assert "refuses to write object 0x6085: value of parameter written too high (0x06090031)" in refusal.text


def test_an_answer_of_another_length_is_a_refusal_and_no_fault_of_the_cycle(rig: Rig) -> None:
    drive = rig.simulated.drives[2]
    get_data = drive.local.get_data

    def shorter(index: int, subindex: int, check_readable: bool = False) -> bytes:
        data: bytes = get_data(index, subindex, check_readable)
        return data[:2] if index == POSITION_ACTUAL else data

    drive.local.get_data = shorter  # type: ignore[method-assign]
    rig.simulated.inject(2, Fault.REBOOT)
    assert rig.run_until(lambda: catalogue.REJOIN_REFUSED.id in rig.event_ids(), 5.0)
    told = next(problem.text for problem in rig.problems() if problem.entry is catalogue.REJOIN_REFUSED)
    assert "0x6064: its 2 bytes are no value" in told
    assert rig.image.state[X] == ENABLED


def test_a_node_that_falls_silent_again_on_its_way_back(rig: Rig) -> None:
    rig.simulated.inject(2, Fault.REBOOT)
    rig.cycle(20)
    rig.simulated.inject(2, Fault.SILENT)
    rig.cycle(2000)
    assert not back(rig, 2)
    rig.simulated.heal(2)
    assert rig.run_until(lambda: back(rig, 2), 8.0)


def test_a_lost_answer_is_asked_for_again(rig: Rig) -> None:
    send = rig.simulated._network.send_message
    lost = 0

    def every_tenth_lost(can_id: int, data: bytes, remote: bool = False) -> None:
        nonlocal lost
        if can_id == 0x582:
            lost += 1
            if lost % 10 == 0:
                return
        send(can_id, data, remote)

    rig.simulated._network.send_message = every_tenth_lost  # type: ignore[method-assign]
    rig.simulated.inject(2, Fault.REBOOT)
    assert rig.run_until(lambda: back(rig, 2), 10.0)
    assert lost > 40
    assert catalogue.REJOIN_REFUSED.id not in rig.event_ids()


def test_an_io_node_comes_back_with_its_outputs(rig: Rig) -> None:
    rig.image.digital_out[0] = 0b10
    rig.cycle(300)
    assert rig.simulated.ios[10].output_states()["coolant_pump"]
    rig.simulated.inject(10, Fault.REBOOT)
    rig.cycle(5)
    assert not rig.simulated.ios[10].output_states()["coolant_pump"]
    assert rig.run_until(lambda: back(rig, 10), 5.0)
    assert rig.problems()[-1].text == "node 10 (I/O node 0) is back in operation"
    rig.cycle(10)
    assert rig.simulated.ios[10].output_states()["coolant_pump"]
    assert rig.image.digital_in[0] & 0b10_0000  # the door is closed


def test_lost_nodes_are_told_again_only_until_they_are_back(rig: Rig) -> None:
    rig.simulated.inject(2, Fault.SILENT)
    rig.cycle(1000)
    rig.events.clear()
    rig.master.tell_again()
    rig.cycle()
    assert len(rig.events) == 1
    rig.simulated.heal(2)
    assert rig.run_until(lambda: back(rig, 2), 5.0)
    rig.events.clear()
    rig.master.tell_again()
    rig.cycle()
    assert rig.event_ids() == []


def test_an_interface_that_comes_up_again(rig: Rig) -> None:
    move(rig, X, 100.0, 100)
    failing = Failing(rig.bus, can.CanOperationError("Failed to transmit", errno.ENETDOWN))
    rig.master.frames.bus = failing  # type: ignore[assignment]
    rig.cycle(1000)
    # what it hears does not count as long as nothing can be sent; the drives tell that they miss their master
    assert [number for number in rig.event_ids() if number != catalogue.EMERGENCY.id] == ids(catalogue.BUS_GONE)
    failing.fails = False
    assert rig.run_until(lambda: all(back(rig, node) for node in (1, 2, 3, 6, 10)), 10.0)
    assert catalogue.BUS_BACK.id in rig.event_ids()
    assert set(rig.image.state.tolist()) == {DriveState.FAULT}  # they heard no master
    before = rig.simulated.drives[1].servo.position
    take_over(rig, X)
    assert rig.simulated.drives[1].servo.position == pytest.approx(before, abs=1.0)


def test_bus_off_and_the_restart_of_the_controller(rig: Rig) -> None:
    rig.node_bus.send(can.Message(arbitration_id=0x40, is_error_frame=True, is_extended_id=False, data=bytes(8)))
    rig.cycle()
    assert rig.event_ids() == ids(catalogue.BUS_OFF)
    assert rig.run_until(lambda: all(back(rig, node) for node in (1, 2, 3, 6, 10)), 10.0)


def test_error_frames_do_not_prove_that_a_bus_works(rig: Rig) -> None:
    rig.simulated.power_on = lambda now: None  # type: ignore[method-assign]
    for node in rig.simulated.nodes:
        rig.simulated.inject(node, Fault.SILENT)
    off = can.Message(arbitration_id=0x40, is_error_frame=True, is_extended_id=False, data=bytes(8))
    for _ in range(50):
        rig.node_bus.send(off)
        rig.cycle(20)
    assert rig.event_ids() == ids(catalogue.BUS_OFF)


def test_an_optional_node_is_missed_told_and_taken_in() -> None:
    description = demo_description()
    description["fieldbus"]["io"][0]["optional"] = True
    description["axes"][2]["drive"]["optional"] = True
    description["fieldbus"]["bus"]["boot_timeout"] = "0.5 s"
    with Rig(description) as rig:
        for node in (3, 10):
            rig.simulated.inject(node, Fault.SILENT)
        rig.started()
        assert sorted((event.error_id, event.node) for event in rig.events) == [
            (catalogue.NODE_ABSENT.id, 3),
            (catalogue.NODE_ABSENT.id, 10),
        ]
        assert rig.image.state[Z] == DriveState.OFFLINE
        for node in (3, 10):
            rig.simulated.heal(node)
            rig.simulated.inject(node, Fault.REBOOT)
        assert rig.run_until(lambda: back(rig, 3) and back(rig, 10), 5.0)
        assert rig.image.state[Z] == DriveState.SWITCH_ON_DISABLED


def test_a_storm_of_emergencies_is_counted_and_told_once_a_second(rig: Rig) -> None:
    for _ in range(2000):
        rig.simulated.drives[1].local.emcy.send(0x4310, 0x09)
        rig.cycle()
    assert rig.image.emcy_count == 2000
    assert rig.event_ids() == ids(catalogue.EMERGENCY) * 2
    assert rig.image.state[X] == ENABLED


def test_sync_is_counted() -> None:
    description = demo_description()
    description["fieldbus"]["bus"]["sync_counter"] = 4
    with Rig(description) as rig, can.Bus(interface="virtual", channel=rig.machine.fieldbus.bus.channel) as listener:
        rig.enabled()
        while listener.recv(0) is not None:
            pass
        rig.cycle(10)
        counts = []
        while (message := listener.recv(0)) is not None:
            if message.arbitration_id == 0x80:
                counts += list(message.data)
        assert len(counts) == 10
        assert all(after == before % 4 + 1 for before, after in itertools.pairwise(counts))
        assert set(counts) == {1, 2, 3, 4}


def test_the_time_of_day() -> None:
    assert time_of_day(441_763_200.0) == bytes(6)  # 1984-01-01
    assert time_of_day(441_763_200.0 + 86_400.0 + 1.5) == (1500).to_bytes(4, "little") + b"\1\0"
    description = demo_description()
    description["fieldbus"]["bus"]["time_stamp"] = "0.5 s"
    with Rig(description) as rig, can.Bus(interface="virtual", channel=rig.machine.fieldbus.bus.channel) as listener:
        rig.started()
        rig.cycle(1000)
        stamps = 0
        while (message := listener.recv(0)) is not None:
            stamps += message.arbitration_id == 0x100
        assert stamps == 3
