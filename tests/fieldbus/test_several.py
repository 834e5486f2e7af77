"""A machine on two buses: one cycle, one image, a SYNC each; what befalls one bus stops the other under control."""

from __future__ import annotations

import errno
import itertools
import math
from collections.abc import Callable, Iterator
from typing import Any

import can
import numpy as np
import pytest

from runtime.config.loader import ConfigurationError, parse_machine
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import CATALOGUE, configuration
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.diagnostics.errors import Reaction
from runtime.drives import DriveEvent, DriveState
from runtime.fieldbus import wire
from runtime.fieldbus.described import make_links
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.events import problem_of
from runtime.fieldbus.several import SeveralMasters, drive_system
from runtime.fieldbus.simulator import Fault, SimulatedNodes
from tests.fieldbus.rig import demo_description
from tests.fieldbus.test_operation import ENABLED, Failing, X, Y, Z

_CHANNELS = itertools.count()


def two_buses() -> dict[str, Any]:
    """Z is node 1 of the second bus, as X is of the first; an I/O node 10 on both."""
    description = demo_description()
    first = description["fieldbus"]["bus"]["channel"]
    description["fieldbus"]["buses"] = {"b": {"interface": "virtual", "channel": f"{first}-b"}}
    description["axes"][2]["drive"] |= {"node": 1, "bus": "b"}
    description["fieldbus"]["io"].append({"node": 10, "bus": "b", "inputs": ["late"], "outputs": ["lamp"]})
    return description


class TwoBuses:
    """The rig of tests.fieldbus.rig, for two buses."""

    def __init__(self, description: dict[str, Any] | None = None) -> None:
        self.machine = Machine.model_validate(description or two_buses())
        self.time = 0.0
        names = self.machine.fieldbus.all_buses()
        self.buses, node_buses, self.listeners = (
            {name: can.Bus(interface="virtual", channel=bus.channel) for name, bus in names.items()} for _ in range(3)
        )
        self.opened = [*self.buses.values(), *node_buses.values(), *self.listeners.values()]
        self.nodes = SimulatedNodes(self.machine, node_buses)
        system = drive_system(self.machine, self.buses, now=lambda: self.time, idle=self.idle)
        assert isinstance(system, SeveralMasters)
        self.system = system
        self.image = system.image
        self.events: list[DriveEvent] = []

    def idle(self) -> None:
        self.time += 1e-4
        self.nodes.step(self.time)

    def cycle(self, count: int = 1) -> None:
        for _ in range(count):
            self.system.read()
            self.events.extend(self.image.events)
            self.image.events.clear()
            self.system.write()
            self.time += self.machine.cycle.period
            self.nodes.step(self.time)

    def run_until(self, condition: Callable[[], bool], seconds: float = 5.0) -> bool:
        end = self.time + seconds
        while not condition() and self.time < end:
            self.cycle()
        return condition()

    def enabled(self) -> TwoBuses:
        self.system.start()
        self.cycle(3)
        self.image.enable[:] = True
        assert self.run_until(lambda: bool((self.image.state == DriveState.OPERATION_ENABLED).all()))
        return self


@pytest.fixture
def rig() -> Iterator[TwoBuses]:
    rig = TwoBuses()
    try:
        yield rig.enabled()
    finally:
        for bus in rig.opened:
            bus.shutdown()


def test_axes_of_both_buses_move_in_one_cycle(rig: TwoBuses) -> None:
    for cycle in range(500):
        rig.image.target_position[:3] = 10.0 * (1.0 - math.cos(0.01 * cycle))
        rig.cycle()
    rig.cycle(200)
    assert np.allclose(rig.image.actual_position[:3], rig.image.target_position[:3], atol=1e-3)
    assert rig.events == []
    assert rig.nodes.drives[1].servo.position == pytest.approx(rig.nodes.drives[128 + 1].servo.position, abs=1.0)


def test_the_syncs_follow_all_set_points_of_the_cycle() -> None:
    """On each bus one SYNC per cycle; when the first one goes out, the set-points of both buses are there."""
    rig = TwoBuses()
    sent: list[tuple[str, int]] = []
    try:
        rig.enabled()
        for name, bus in rig.buses.items():
            send = bus.send

            def logged(msg: can.Message, timeout: float | None = None, *, name: str = name, send: Any = send) -> None:
                sent.append((name, msg.arbitration_id))
                send(msg, timeout)

            bus.send = logged  # type: ignore[method-assign]
        rig.cycle(50)
        for _ in range(10):
            sent.clear()
            rig.cycle()
            frames = [(name, can_id) for name, can_id in sent if can_id < 0x700]
            assert frames[-2:] == [("", 0x80), ("b", 0x80)]
            assert {("", 0x201), ("", 0x202), ("", 0x206), ("b", 0x201)} <= set(frames[:-2])
            assert len(frames) <= 2 + 4 + 2
    finally:
        for bus in rig.opened:
            bus.shutdown()


def test_the_bits_of_both_buses_make_one_image(rig: TwoBuses) -> None:
    first_input = sum(len(io.inputs) for io in rig.machine.fieldbus.io[:1])
    first_output = sum(len(io.outputs) for io in rig.machine.fieldbus.io[:1])
    rig.nodes.ios[128 + 10].set_inputs({"late": True})
    bits = bytearray(64)
    bits[first_output // 8] |= 1 << first_output % 8
    rig.image.digital_out[:] = np.frombuffer(bits, dtype=np.uint8)
    before = int.from_bytes(rig.image.digital_in.tobytes(), "little")
    rig.nodes._step_plant = lambda: None  # type: ignore[method-assign]
    rig.cycle(5)
    after = int.from_bytes(rig.image.digital_in.tobytes(), "little")
    assert after == before | 1 << first_input
    assert rig.nodes.ios[128 + 10].output_states() == {"lamp": True}
    assert not any(rig.nodes.ios[10].output_states().values())
    rig.nodes.inject(128 + 10, Fault.SILENT)  # the inputs of a lost node are FALSE, those of the other bus stay
    assert rig.run_until(lambda: bool(rig.events))
    assert int.from_bytes(rig.image.digital_in.tobytes(), "little") == before
    assert problem_of(rig.events[0], rig.machine).values["owner"] == "I/O node 1"


def test_a_bus_that_is_gone_leaves_the_other_in_operation(rig: TwoBuses) -> None:
    master = rig.system.masters[1]
    bus = master.frames.bus
    failing = Failing(bus, can.CanOperationError("Failed to transmit", errno.ENETDOWN))
    master.frames.bus = failing  # type: ignore[assignment]
    assert rig.run_until(lambda: bool(rig.events), 0.1)
    (event,) = rig.events
    assert (event.error_id, event.bus) == (catalogue.ONE_BUS_GONE.id, "b")
    assert CATALOGUE[event.error_id].reaction is Reaction.STOP_ON_PATH
    channel = rig.machine.fieldbus.buses["b"].channel
    assert f"the bus {channel} is gone" in problem_of(event, rig.machine).text
    assert rig.image.state[Z] == DriveState.OFFLINE
    assert [rig.image.state[axis] for axis in (X, Y)] == [ENABLED, ENABLED]
    for cycle in range(300):  # the others follow their set-points
        rig.image.target_position[X] = cycle * 0.01
        rig.cycle()
    assert rig.image.actual_position[X] == pytest.approx(2.99, abs=0.2)
    rig.events.clear()
    failing.fails = False
    rejoined = catalogue.NODE_REJOINED.id
    assert rig.run_until(lambda: sorted(e.node for e in rig.events if e.error_id == rejoined) == [1, 10])
    assert {event.bus for event in rig.events if event.axis < 0} == {"b"}
    assert rig.image.state[Z] != DriveState.OFFLINE
    assert [rig.image.state[axis] for axis in (X, Y)] == [ENABLED, ENABLED]


def test_a_node_on_the_second_bus_is_named_with_its_axis(rig: TwoBuses) -> None:
    rig.nodes.inject(128 + 1, Fault.REBOOT)
    assert rig.run_until(lambda: bool(rig.events))
    problem = problem_of(rig.events[0], rig.machine)
    assert (problem.entry, problem.values["owner"]) == (catalogue.NODE_RESTARTED, "axis Z")
    assert rig.image.state[X] == ENABLED


def test_whatever_a_drive_of_the_second_bus_tells_names_its_bus(rig: TwoBuses) -> None:
    """A fault, a drive that disables itself, a set-point that jumps: events of the drive, not of the watch over its node."""
    rig.nodes.inject(128 + 1, Fault.DRIVE, 0x2310)
    assert rig.run_until(lambda: len(rig.events) >= 2)
    rig.image.target_position[X] += 50.0
    rig.cycle(3)
    told = {(event.error_id, event.axis): event.bus for event in rig.events}
    assert told == {
        (catalogue.DRIVE_FAULT.id, Z): "b",
        (catalogue.EMERGENCY.id, Z): "b",
        (catalogue.SETPOINT_JUMP.id, X): "",
    }


def test_loads_are_planned_and_measured_per_bus(rig: TwoBuses) -> None:
    rig.cycle(300)
    links = make_links(rig.machine)
    for master, own in zip(rig.system.masters, ([0, 1, 3, 4], [2, 5]), strict=True):
        config = rig.machine.fieldbus.all_buses()[master.name]
        planned = wire.planned_load([links[k] for k in own], config, rig.machine.cycle.period)
        assert master.frames.figures.load == pytest.approx(planned, rel=0.01)
    assert rig.image.bus_load == max(master.frames.figures.load for master in rig.system.masters)


def test_stop_leaves_both_buses(rig: TwoBuses) -> None:
    rig.system.stop()
    rig.cycle(10)
    assert {drive.state for drive in rig.nodes.drives.values()} == {DriveState.SWITCH_ON_DISABLED}
    assert not any(node.operational for node in rig.nodes.nodes.values())
    rig.enabled()  # and again


def test_a_node_missing_on_the_second_bus_is_named() -> None:
    description = two_buses()
    description["fieldbus"]["buses"]["b"]["boot_timeout"] = 0.3
    rig = TwoBuses(description)
    try:
        rig.nodes.inject(128 + 1, Fault.SILENT)
        with pytest.raises(FieldbusError, match=r"node 1 \(axis Z\)"):
            rig.system.start()
        rig.cycle(10)
        assert not any(node.operational for node in rig.nodes.nodes.values())  # no bus was started
    finally:
        for bus in rig.opened:
            bus.shutdown()


BUSES = """
name: m
axes:
  - {name: X, log_axis: 1, velocity: 1 m/s, acceleration: 1 m/s^2, jerk: 1 m/s^3, drive: {node: 1, bus: BUS}}
  - {name: Y, log_axis: 2, velocity: 1 m/s, acceleration: 1 m/s^2, jerk: 1 m/s^3, drive: {node: 1}}
channels: [{name: c, axes: [X, Y]}]
fieldbus: {buses: {b: {channel: CHANNEL, master_node: MASTER}}}
"""


@pytest.mark.parametrize(
    ("bus", "channel", "master", "entry"),
    [
        ("c", "can1", "127", configuration.BUS_UNKNOWN),
        ("b", "can0", "127", configuration.BUS_TWICE),
        ("b", "can1", "1", configuration.NODE_TWICE),
    ],
)
def test_buses_that_do_not_fit_together(bus: str, channel: str, master: str, entry: object) -> None:
    text = BUSES.replace("BUS", bus).replace("CHANNEL", channel).replace("MASTER", master)
    with pytest.raises(ConfigurationError) as refusal:
        parse_machine(text)
    assert refusal.value.problem.entry is entry
    assert refusal.value.problem.explained()
    parse_machine(BUSES.replace("BUS", "b").replace("CHANNEL", "can1").replace("MASTER", "127"))
