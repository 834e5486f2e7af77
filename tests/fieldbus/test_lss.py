"""Node ids and bit rates by the layer setting services, on simulated nodes that are LSS slaves."""

from __future__ import annotations

import itertools

import can
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cli import bus as command
from runtime.cli.main import main
from runtime.diagnostics.catalogue import commissioning as errors
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.diagnostics.errors import ErrorEntry
from runtime.fieldbus.commissioning import Commissioning
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.lss import FROM_SLAVES, TO_SLAVES, UNCONFIGURED, Identity, LssMaster
from runtime.fieldbus.network import PolledNetwork
from runtime.fieldbus.simulator import Fault
from runtime.fieldbus.simulator.lss import LssSlave
from runtime.fieldbus.simulator.node import SimulatedNode
from tests.fieldbus.rig import Rig
from tests.fieldbus.test_commissioning import look

X, Y = Identity(0x7A4D, 0x402, 0x10000, 1), Identity(0x7A4D, 0x402, 0x10000, 2)


def refusal(entry: ErrorEntry) -> pytest.RaisesExc[FieldbusError]:
    return pytest.raises(FieldbusError, check=lambda error: error.problem.entry is entry)


def take_node_id(node: SimulatedNode) -> None:
    """As a device that comes from its vendor."""
    node.lss.stored = UNCONFIGURED
    node.power_on(0.0)


def test_a_node_gets_another_id_and_keeps_it() -> None:
    with Rig() as rig:
        looking = look(rig)
        assert looking.set_node(X, 33, 500_000, store=True) == (X, 33)
        drive = rig.simulated.nodes[1]
        assert (drive.id, drive.lss.stored, drive.lss.bitrate) == (33, 33, 500_000)
        assert [node.node for node in looking.scan()] == [2, 3, 6, 10, 33]
        drive.power_on(rig.time)
        assert (drive.id, next(n.serial for n in looking.scan() if n.node == 33)) == (33, 1)
        assert looking.set_node(X, 1, None, store=False) == (X, 1)
        drive.power_on(rig.time)
        assert drive.id == 33  # what is not stored is forgotten


def test_the_machine_runs_with_a_node_that_was_set() -> None:
    with Rig() as rig:
        take_node_id(rig.simulated.nodes[2])
        with refusal(catalogue.NODE_MISSING):
            rig.master.start()
        assert look(rig).set_node(Y, 2, None, store=True) == (Y, 2)
        rig.enabled()
        assert rig.event_ids() == []


def test_nodes_without_an_id_are_found_one_by_one() -> None:
    with Rig() as rig:
        looking = look(rig)
        assert looking.unconfigured() == []
        for node in (1, 2, 10):
            take_node_id(rig.simulated.nodes[node])
        found = looking.unconfigured()
        rig.idle()
        assert sorted(found) == sorted(rig.simulated.nodes[node].lss.identity for node in (1, 2, 10))
        assert not any(node.lss.configuring for node in rig.simulated.nodes.values())
        assert [node.node for node in looking.scan()] == [3, 6]


def test_what_cannot_be_set_is_refused() -> None:
    with Rig() as rig:
        looking = look(rig)
        with refusal(errors.NODE_ID_TAKEN):
            looking.set_node(X, 2, None, store=True)
        with refusal(errors.LSS_BITRATE):
            looking.set_node(X, None, 123_456, store=True)
        with refusal(errors.LSS_SEVERAL):
            looking.set_node(None, 40, None, store=True)
        with refusal(errors.LSS_NO_NODE):
            looking.set_node(X._replace(serial=77), 40, None, store=True)
        assert [node.id for node in rig.simulated.nodes.values()] == [1, 2, 3, 6, 10]
        assert not any(node.lss.configuring for node in rig.simulated.nodes.values())
        for node in (2, 3, 6, 10):
            rig.simulated.inject(node, Fault.SILENT)
        assert looking.set_node(None, 40, None, store=True) == (X, 40)
        rig.simulated.inject(1, Fault.SILENT)
        with refusal(errors.LSS_NO_NODE):
            looking.set_node(None, 41, None, store=True)


def test_a_running_machine_is_left_alone() -> None:
    with Rig() as rig, can.Bus(interface="virtual", channel=rig.machine.fieldbus.bus.channel) as visitor:
        rig.enabled()
        looking = Commissioning(visitor, lambda: rig.time, rig.cycle)
        with refusal(catalogue.OTHER_MASTER):
            looking.set_node(X, 33, None, store=True)
        with refusal(catalogue.OTHER_MASTER):
            looking.unconfigured()


class Loop(PolledNetwork):
    """A master and its slaves without a bus: who is sent a frame has it at once."""

    def __init__(self) -> None:
        super().__init__(None)  # type: ignore[arg-type]
        self.slaves: list[LssSlave] = []
        self.answer: bytes | None = None  # instead of those of the slaves

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        if can_id == TO_SLAVES and self.answer is not None:
            self.notify(FROM_SLAVES, bytearray(self.answer), 0.0)
        elif can_id == TO_SLAVES:
            for slave in self.slaves:
                slave.on_frame(bytearray(data))
        else:
            self.notify(can_id, bytearray(data), 0.0)


def master_of(identities: list[Identity]) -> tuple[LssMaster, Loop]:
    loop = Loop()
    loop.slaves = [LssSlave(identity, UNCONFIGURED, loop.send_message) for identity in identities]
    return LssMaster(loop, lambda condition, seconds: condition()), loop


words = st.integers(0, 0xFFFF_FFFF) | st.sampled_from([0, 1, 0x8000_0000, 0xFFFF_FFFF])


@settings(max_examples=60, deadline=None)
@given(st.sets(st.builds(Identity, words, words, words, words), max_size=5))
def test_a_fast_scan_finds_every_identity(identities: set[Identity]) -> None:
    """Law: whatever the identities are, each is found once; each one alone can be selected by it."""
    master, loop = master_of(sorted(identities))
    assert sorted(master.find_all()) == sorted(identities)
    for slave in loop.slaves:
        master.select(slave.identity)
        assert [other.configuring for other in loop.slaves] == [other is slave for other in loop.slaves]
        assert master.identity() == slave.identity


def test_what_a_node_answers_is_told_in_plain_text() -> None:
    master, loop = master_of([X])
    master.select(X)
    assert master.node_id() is None
    with pytest.raises(FieldbusError, match="outside of 1 to 127"):
        master.set_node_id(200)
    master.set_node_id(5)
    master.activate(0.25)
    assert (loop.slaves[0].activated, master.node_id()) == (0.25, 5)
    loop.answer = bytes((0x17, 2, 0, 0, 0, 0, 0, 0))
    with pytest.raises(FieldbusError, match="cannot be written"):
        master.store()
    loop.answer = bytes((0x17, 255, 9, 0, 0, 0, 0, 0))
    with pytest.raises(FieldbusError, match="error 255, 9 of the device"):
        master.store()


@pytest.mark.parametrize("order", list(itertools.permutations(range(4))))
def test_a_slave_wants_its_whole_identity_in_order(order: tuple[int, ...]) -> None:
    _, loop = master_of([X])
    for part in order:
        loop.send_message(TO_SLAVES, bytes((0x40 + part,)) + X[part].to_bytes(4, "little") + bytes(3))
    assert loop.slaves[0].configuring == (order == (0, 1, 2, 3))


def test_from_the_command_line(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    with Rig() as rig:
        take_node_id(rig.simulated.nodes[1])

        class Looking(Commissioning):
            def __init__(self, bus: can.BusABC, *_: object) -> None:
                super().__init__(bus, lambda: rig.time, rig.idle)

        monkeypatch.setattr(command, "Commissioning", Looking)
        channel = rig.machine.fieldbus.bus.channel
        monkeypatch.setattr(command, "open_bus", lambda bus: can.Bus(interface="virtual", channel=channel))
        assert main(["bus", "lss", "find"]) == 0
        written = capsys.readouterr().out.split()[0]
        assert written == "0x7A4D:0x402:0x10000:0x1"
        assert main(["bus", "lss", "set", written, "--node", "34", "--bitrate", "500000"]) == 0
        assert "node 34, 500000 bit/s" in capsys.readouterr().out
        assert rig.simulated.nodes[1].id == 34
        assert main(["bus", "lss", "set", written]) == 2
        assert main(["bus", "lss", "set", "1:2", "--node", "4"]) == 2
        assert main(["bus", "lss", "set", written, "--node", "2"]) == 1
        assert "303104" in capsys.readouterr().err
