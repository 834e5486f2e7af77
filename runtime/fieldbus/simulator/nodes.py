"""All simulated nodes of a machine on one bus: drives, I/O nodes, and the plant around them.

Nothing runs by itself: `poll` handles the frames that have come, `step` lets time pass. In one process with the
master both are called between its write() and its read(); in a process of their own, by the loop in `__main__`.
"""

from __future__ import annotations

from collections.abc import Mapping

import can

from runtime.config.machine import Axis, Drive, Machine, SimulatedServo
from runtime.fieldbus.described import DRIVE_EDS, IO_EDS, eds_path
from runtime.fieldbus.dialogue import SYNC
from runtime.fieldbus.lss import TO_SLAVES
from runtime.fieldbus.network import PolledNetwork
from runtime.fieldbus.pdo import FREE_COB_IDS
from runtime.fieldbus.simulator.drive import OVER_CURRENT, Fault, SimulatedDrive
from runtime.fieldbus.simulator.encoder import EncoderFile
from runtime.fieldbus.simulator.io import SimulatedIo
from runtime.fieldbus.simulator.node import SimulatedNode
from runtime.fieldbus.simulator.plant import SimulatedPlant
from runtime.fieldbus.simulator.servo import Motor
from runtime.fieldbus.simulator.workpiece import SimulatedWorkpiece

OTHER_VENDOR = 0x1234
MAX_FRAMES_PER_POLL = 128
NODES_PER_BUS = 128


class NodeNetwork(PolledNetwork):
    """A network that several nodes share; the frames of nodes in `silent`, known by the COB-ID, don't go out."""

    def __init__(self, bus: can.BusABC, *, fd: bool = False) -> None:
        super().__init__(bus, fd=fd)
        self.silent: set[int] = set()

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        if can_id in FREE_COB_IDS or can_id & 0x7F not in self.silent:  # the node looks itself at those
            super().send_message(can_id, data, remote)


def _motor_of(axis: Axis, drive: Drive, increments_per_unit: float) -> Motor:
    strongest = max([axis.acceleration, *(stage.acceleration for stage in axis.gear_stages)])
    rated = drive.simulated.rated_acceleration or 2.0 * strongest
    return Motor(increments_per_unit, rated * increments_per_unit)


class SimulatedBus:
    """One bus and the nodes on it, by their node id at the start."""

    def __init__(self, bus: can.BusABC, *, fd: bool = False) -> None:
        self.bus = bus
        self.network = NodeNetwork(bus, fd=fd)
        self.nodes: dict[int, SimulatedNode] = {}
        self._now = 0.0
        self.network.subscribe(SYNC, self._on_sync)
        self.network.subscribe(TO_SLAVES, self._on_lss)
        for node in range(1, 128):
            self.network.subscribe(0x700 + node, self._on_heartbeat)

    def poll(self, now: float) -> int:
        """Handle the frames that have come, at the time `now` (s); their number.

        Bounded: on a busy computer frames can come as fast as they are handled, and heartbeats must go out all the
        same.
        """
        for count in range(MAX_FRAMES_PER_POLL):
            message = self.bus.recv(0)
            if message is None:
                return count
            self.hear(message, now)
        return MAX_FRAMES_PER_POLL

    def hear(self, message: can.Message, now: float) -> None:
        """Handle one frame."""
        self._now = now
        if message.is_remote_frame:
            for node in self.nodes.values():
                if node.id == message.arbitration_id - 0x700:
                    node.on_guard(now)
            return
        self.network.receive(message)

    def _on_sync(self, can_id: int, data: bytearray, timestamp: float) -> None:
        for node in self.nodes.values():
            node.now = self._now
            node.on_sync()

    def _on_lss(self, can_id: int, data: bytearray, timestamp: float) -> None:
        for node in self.nodes.values():
            node.on_lss(data)

    def _on_heartbeat(self, can_id: int, data: bytearray, timestamp: float) -> None:
        for node in self.nodes.values():
            if not node.silent:
                node.on_heartbeat(can_id - 0x700, self._now)


class SimulatedNodes:
    """The nodes of `machine` on its bus or buses, by the node id that the machine description gives them.

    Those of the second bus count on from 128, those of the third from 256. `encoders` keeps the positions across restarts.
    """

    def __init__(
        self,
        machine: Machine,
        bus: can.BusABC | Mapping[str, can.BusABC],
        *,
        plant: SimulatedPlant | None = None,
        encoders: EncoderFile | None = None,
    ) -> None:
        buses = bus if isinstance(bus, Mapping) else {"": bus}
        configs = machine.fieldbus.all_buses()
        self.buses = {name: SimulatedBus(opened, fd=configs[name].fd) for name, opened in buses.items()}
        self._encoders = encoders
        self._now = 0.0
        self._powered = False
        self.plant = plant or SimulatedPlant()
        self.drives: dict[int, SimulatedDrive] = {}
        self.ios: dict[int, SimulatedIo] = {}
        # A simulated node has the dictionary of our own EDS, whatever the real device would have.
        for axis in machine.axes:
            if drive := axis.drive:
                self._add_drive(drive, drive.node, drive.simulated, _motor_of(axis, drive, drive.increments_per_unit))
                if gantry := drive.gantry:
                    scale = gantry.increments_per_unit or drive.increments_per_unit
                    self._add_drive(drive, gantry.node, gantry.simulated, _motor_of(axis, drive, scale))
        for io in machine.fieldbus.io:
            number, on = self._place(io.bus, io.node)
            eds = eds_path(None, IO_EDS)
            self.ios[number] = SimulatedIo(io, eds, on.network)
            on.nodes[io.node] = self.ios[number]
        self.nodes: dict[int, SimulatedNode] = {**self.drives, **self.ios}
        self.workpiece = self._workpiece(machine)

    def _workpiece(self, machine: Machine) -> SimulatedWorkpiece | None:
        """What the touch probes meet, if the machine description has something."""
        box = machine.fieldbus.workpiece
        drives = {}
        for name in box:
            drive = machine.axes[machine.axis_index(name)].drive
            assert drive is not None
            number, _ = self._place(drive.bus, drive.node)
            drives[name] = [(self.drives[number], drive.increments_per_unit)]
        return SimulatedWorkpiece(box, drives) if box else None

    def _add_drive(self, drive: Drive, node: int, servo: SimulatedServo, motor: Motor) -> None:
        number, on = self._place(drive.bus, node)
        position = self._encoders[number] if self._encoders else 0.0
        eds = eds_path(None, DRIVE_EDS)
        self.drives[number] = on.nodes[node] = SimulatedDrive(node, eds, on.network, servo, position, motor)

    def _place(self, bus: str | None, node: int) -> tuple[int, SimulatedBus]:
        """Number of a node among all, and its bus."""
        name = bus or ""
        return list(self.buses).index(name) * NODES_PER_BUS + node, self.buses[name]

    @property
    def _network(self) -> NodeNetwork:
        """Of the first bus."""
        return self.buses[""].network

    def power_on(self, now: float) -> None:
        """All nodes boot; done by the first `step` if not before."""
        self._powered = True
        self._now = now
        for bus in self.buses.values():
            bus.network.step(now)
        self._step_plant()
        for node in self.nodes.values():
            node.power_on(now)

    def poll(self, now: float) -> int:
        """Handle the frames that have come, at the time `now` (s); their number, which is bounded."""
        self._now = now
        return sum(bus.poll(now) for bus in self.buses.values())

    def step(self, now: float) -> None:
        """Let the time be `now` (s): heartbeats, frames, plant, motion, event-driven frames."""
        if not self._powered:
            self.power_on(now)
        self._now = now
        for bus in self.buses.values():
            bus.network.step(now)
            bus.poll(now)
        self._step_plant()
        for node in self.nodes.values():
            node.step(now)
        if self.workpiece is not None:
            self.workpiece.step()
        if self._encoders:
            for number, drive in self.drives.items():
                self._encoders[number] = drive.servo.position

    def _step_plant(self) -> None:
        outputs: dict[str, bool] = {}
        for io in self.ios.values():
            outputs |= io.output_states()
        inputs = self.plant.step(self._now, outputs)
        for io in self.ios.values():
            io.set_inputs(inputs)
            self.plant.values_out |= io.output_values()
            io.set_input_values(self.plant.values)

    def _bus_of(self, node: SimulatedNode) -> NodeNetwork:
        return next(bus.network for bus in self.buses.values() if bus.network is node.network)

    def inject(self, node: int, fault: Fault, code: int = OVER_CURRENT) -> None:
        """Do something bad to a node; `code` is the error code of a drive fault. Raises KeyError: no such node."""
        target = self.nodes[node]
        match fault:
            case Fault.SILENT:
                target.silent = True
                self._bus_of(target).silent.add(target.id)
            case Fault.REBOOT:
                target.power_on(self._now)
            case Fault.WRONG_VENDOR:
                target.vendor_id = OTHER_VENDOR
            case Fault.DRIVE:
                self.drives[node].fail(code)
            case Fault.FOLLOWING_ERROR:
                self.drives[node].blocked = True
            case Fault.ENCODER_FREEZE:
                self.drives[node].freeze_encoder(True)

    def heal(self, node: int) -> None:
        """Undo what was injected; a fault of the drive stays until it is acknowledged."""
        target = self.nodes[node]
        target.silent = False
        target.vendor_id = None
        self._bus_of(target).silent.discard(target.id)
        if node in self.drives:
            self.drives[node].blocked = False
            self.drives[node].freeze_encoder(False)
