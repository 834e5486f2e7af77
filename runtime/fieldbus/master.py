"""The CANopen master: carries the drive image over the bus, once per cycle, without threads.

    read()   take every frame that has come, by a table of COB-IDs; feedback and inputs into the image; watch nodes
    write()  set-points and outputs of this cycle as RPDOs, then SYNC: all drives take them over at the same moment
             and answer with their feedback, which the next read() finds

A node that is lost, or a bus that is gone, does not end the run: the node is taken into operation again, step by step between
the set-points (runtime.fieldbus.rejoin); the bus is tried until a frame comes.

Time and bus are passed in. While the master must wait (boot, stop) it calls `idle` again and again: in real time that
sleeps a little, in virtual time it lets the simulated nodes and the clock go on.
"""

from __future__ import annotations

import errno
import struct
import time
from collections.abc import Callable
from functools import partial
from typing import Final

import can
import numpy as np

from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.drives import DIGITAL_BYTES, DriveEvent, DriveImage, DriveState
from runtime.fieldbus import wire
from runtime.fieldbus.boot import OPERATIONAL, BootSequence
from runtime.fieldbus.described import make_links
from runtime.fieldbus.dialogue import SYNC, TIME, NodeDialogues
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.exchange import IO_REFRESH
from runtime.fieldbus.links import DriveLink, IoLink, Links, Receiver
from runtime.fieldbus.network import PolledNetwork, PumpedSdoClient, fill
from runtime.fieldbus.questions import Questions
from runtime.fieldbus.rejoin import Rejoin

MAX_FRAMES_PER_READ: Final = 256  # what comes faster than this waits for the next cycle
MAX_STALE_FRAMES: Final = 10_000
LOAD_WINDOW: Final = 100  # cycles over which the bus load is taken
HIGH_LOAD: Final = 0.9  # share of the bus, from which on a repeated frame makes a cycle late
STOP_TIME: Final = 3.0  # s, the longest that stop() waits for the drives
FAILURES_UNTIL_GONE: Final = 3  # cycles in a row with an error of the bus; a full transmit queue may pass by
GONE_AT_ONCE: Final = frozenset({errno.ENETDOWN, errno.ENODEV, errno.ENXIO, errno.EBADF, errno.ENETUNREACH})
BUS_ERRORS: Final = (can.CanError, OSError, ValueError)  # ValueError: select() on a closed socket
ERROR_FRAME_BUS_OFF: Final = 0x40  # SocketCAN: CAN_ERR_BUSOFF
BOOT_UP: Final = 0
DAYS_1970_TO_1984: Final = 5113
RECOVERY_PAUSE: Final = 0.2  # s after which a bus that is gone may be found working
EMERGENCY_PAUSE: Final = 1.0  # s in which the same emergency of a node is told once
RESTING: Final = (
    DriveState.OFFLINE,
    DriveState.NOT_READY_TO_SWITCH_ON,
    DriveState.SWITCH_ON_DISABLED,
    DriveState.FAULT,
)


class CanopenMaster:
    """A `DriveSystem` (runtime.drives) over CANopen.

    `now()` gives seconds of a clock that only goes forward; `idle()` must let it go forward; `wall_clock()` gives seconds since
    1970, for the time stamps that nodes are told. The bus is the caller's:
    it opens it and shuts it down.
    """

    def __init__(
        self,
        machine: Machine,
        bus: can.BusABC,
        *,
        now: Callable[[], float],
        idle: Callable[[], None],
        wall_clock: Callable[[], float] = time.time,
    ) -> None:
        self.image = DriveImage(len(machine.axes))
        self._machine = machine
        self._config = machine.fieldbus.bus
        self._period = machine.cycle.period
        self._bus = bus
        self._now = now
        self._wall_clock = wall_clock
        self._idle = idle
        self._network = PolledNetwork(bus)
        self._links: Links = []
        self._drives: list[DriveLink] = []
        self._ios: list[IoLink] = []
        self._guards: list[can.Message] = []  # requests to nodes without a heartbeat
        self._table: dict[int, Receiver] = {}
        self._rejoins: dict[int, Rejoin] = {}  # by node id: those on their way back
        self._clients: dict[int, PumpedSdoClient] = {}  # of the boot
        self._questions: dict[int, Questions] = {}  # by node id: to nodes in operation
        self._sync = can.Message(arbitration_id=SYNC, is_extended_id=False, dlc=1 if self._config.sync_counter else 0)
        self._heartbeat = can.Message(
            arbitration_id=0x700 + self._config.master_node, data=[OPERATIONAL], is_extended_id=False
        )
        self._virtual = [i for i, axis in enumerate(machine.axes) if axis.drive is None]
        self._forget()

    def _forget(self) -> None:
        """The state before the first cycle."""
        self._running = False
        self._gone: DriveEvent | None = None
        self._gone_at = 0.0
        self._error_frames = 0
        self._sending_works = False
        self._rejoins = {}
        self._questions = {}
        self._watching = False
        self._failed = False  # an error of the bus in this cycle
        self._failures = 0
        self._heard_master = False
        self._next_heartbeat = 0.0
        self._next_outputs = 0.0
        self._next_time_stamp = 0.0
        self._sync_count = 0
        self._cycle_time = 0.0
        self._bits = 0.0
        self._cycles = 0
        self._input_bits = 0
        self._last_outputs = b""
        self.image.events.clear()
        self.image.state[:] = DriveState.OFFLINE
        self.image.fault_code[:] = 0

    # -- before the first cycle --------------------------------------------------------------------------------------

    def start(self) -> None:
        """Boot, check and configure all nodes, and start them; the drives stay disabled.

        May be called again after `stop` or after nodes were lost. Raises FieldbusError (ids 303010 to 303040).
        """
        self._forget()
        self._links = make_links(self._machine)
        self._drives = [link for link in self._links if isinstance(link, DriveLink)]
        self._ios = [link for link in self._links if isinstance(link, IoLink)]
        self._guards = [
            can.Message(arbitration_id=0x700 + link.node, is_extended_id=False, is_remote_frame=True, dlc=1)
            for link in self._links
            if link.guarded
        ]
        self._plan_load()
        self._dialogues = NodeDialogues(self._machine, self.image)
        boot = BootSequence(
            self._machine, self._network, self._links, self._dialogues, self._wait, lambda: self._heard_master
        )
        self._clients = boot.clients
        self._table = self._receivers()
        try:
            for _ in range(MAX_STALE_FRAMES):  # what was on the bus before is of no interest
                if self._bus.recv(0) is None:
                    break
            boot.run()
        except BUS_ERRORS as error:
            raise FieldbusError(catalogue.BUS_GONE, meaning=str(error)) from error
        self._publish_inputs()
        self._running = True
        self._cycle_time = self._now()
        for link in self._links:
            if not link.booted:
                self._lose(link, catalogue.NODE_ABSENT.id)

    def _receivers(self) -> dict[int, Receiver]:
        table: dict[int, Receiver] = {SYNC: self._on_foreign_master}
        table[self._heartbeat.arbitration_id] = self._on_foreign_master
        for link in self._links:
            table |= link.receivers()
            table[0x080 + link.node] = partial(self._on_emergency, link)
            table[0x580 + link.node] = partial(self._on_sdo, link)
            table[0x700 + link.node] = partial(self._on_heartbeat, link)
        return table

    def _on_sdo(self, link: DriveLink | IoLink, data: bytearray) -> None:
        if rejoin := self._rejoins.get(link.node):
            rejoin.on_answer(data)
        elif questions := self._questions.get(link.node):
            questions.on_answer(data)
        elif not self._running:
            self._clients[link.node].take(data)

    def _on_foreign_master(self, data: bytearray) -> None:
        self._heard_master = True

    def _wait(self, condition: Callable[[], bool], seconds: float) -> bool:
        """Let bus and time run until `condition` holds; False after `seconds`. Raises can.CanError."""
        deadline = self._now() + seconds
        while True:
            self._receive()
            if condition():
                return True
            if self._now() >= deadline:
                return False
            self._idle()

    def _plan_load(self) -> None:
        """Refuse what the wire cannot carry, before anybody is told to send it. Raises FieldbusError."""
        if self._config.interface != "socketcan":
            return  # no wire
        planned = wire.planned_load(self._links, self._machine)
        if planned > 1.0:
            period_us = self._period * 1e6
            raise FieldbusError(
                catalogue.BUS_TOO_SLOW,
                bitrate=self._config.bitrate,
                needed=round(planned * period_us),
                period=round(period_us),
                excess=round((planned - 1.0) * period_us),
            )
        if planned > HIGH_LOAD:
            self.image.events.append(DriveEvent(catalogue.BUS_OVERLOADED.id, -1, 0, round(planned * 100)))

    # -- the cycle ---------------------------------------------------------------------------------------------------

    def read(self) -> None:
        """Start of a cycle: bring the feedback into the image. Never blocks, never raises."""
        image = self.image
        if self._virtual:
            self._move_virtual_axes()
        if not self._running:
            return
        self._cycle_time = now = self._now()
        if self._gone:
            self._look_for_bus(now)
            return
        self._failures = self._failures + 1 if self._failed else 0
        self._failed = False
        try:
            drained = self._receive()
        except BUS_ERRORS as error:
            self._bus_failed(error)
            return
        for link in self._drives:
            if link.fresh and not link.lost:
                link.last_data = now
            if not link.lost:
                link.feedback(image, self._period)
        if drained:
            self._watch(now)
        self._publish_inputs()
        self._measure_load()

    def write(self) -> None:
        """End of a cycle: send set-points, outputs and SYNC. Never blocks, never raises."""
        if not self._running:
            return
        if self._gone:
            if self._cycle_time >= self._next_heartbeat:
                self._next_heartbeat = self._cycle_time + self._config.heartbeat
                self._try_bus()
            return
        image = self.image
        positions, velocities = (image.target_position - image.origin).tolist(), image.target_velocity.tolist()
        enable, quick_stop, reset = image.enable.tolist(), image.quick_stop.tolist(), image.reset_fault.tolist()
        try:
            for link in self._drives:
                i = link.axis
                link.command(image, (velocities if link.spindle else positions)[i], enable[i], quick_stop[i], reset[i])
                self._send(link.message)
            if self._ios:
                self._send_outputs()
            if self._rejoins:
                self._step_rejoins()
            self._send_sync()
            self._send_heartbeat()
        except BUS_ERRORS as error:
            self._bus_failed(error)

    def _send_sync(self) -> None:
        """SYNC, counted if so configured; now and then the time before it."""
        if self._config.time_stamp and self._cycle_time >= self._next_time_stamp:
            self._next_time_stamp = self._cycle_time + self._config.time_stamp
            self._send_data(TIME, time_of_day(self._wall_clock()))
        if self._config.sync_counter:
            self._sync_count = self._sync_count % self._config.sync_counter + 1
            fill(self._sync, bytes((self._sync_count,)))
        self._send(self._sync)

    def _send_heartbeat(self) -> None:
        if self._config.heartbeat and self._cycle_time >= self._next_heartbeat:
            self._next_heartbeat = max(self._next_heartbeat + self._config.heartbeat, self._cycle_time)
            self._send(self._heartbeat)
            for request in self._guards:
                self._send(request)

    def _send(self, message: can.Message) -> None:
        self._bus.send(message)
        self.image.frames_sent += 1
        self._bits += wire.FRAME_BITS[len(message.data)]

    def _receive(self) -> bool:
        """Hand every frame that has come to its receiver; False if more may be waiting. Raises can.CanError."""
        receive, table = self._bus.recv, self._table
        for count in range(MAX_FRAMES_PER_READ):
            message = receive(0)
            if message is None:
                self.image.frames_received += count
                return True
            if message.is_error_frame:
                self._error_frames += 1
                self._on_error_frame(message.arbitration_id)
                continue
            data = message.data
            if message.is_extended_id or message.is_remote_frame or data is None or len(data) > 8:
                continue
            self._bits += wire.FRAME_BITS[len(data)]
            receiver = table.get(message.arbitration_id)
            if receiver is not None:
                receiver(data)
        self.image.frames_received += MAX_FRAMES_PER_READ
        return False

    def _send_outputs(self) -> None:
        """Outputs go out when they change, and now and then for nodes that missed it."""
        outputs = self.image.digital_out.tobytes()
        due = self._cycle_time >= self._next_outputs
        if outputs == self._last_outputs and not due:
            return
        if due:
            self._next_outputs = self._cycle_time + IO_REFRESH
        self._last_outputs = outputs
        bits = int.from_bytes(outputs, "little")
        for link in self._ios:
            if (link.command(bits) or due) and link.message is not None:
                self._send(link.message)

    def _publish_inputs(self) -> None:
        bits = 0
        for link in self._ios:
            bits |= link.input_bits()
        if bits != self._input_bits:
            self._input_bits = bits
            self.image.digital_in[:] = np.frombuffer(bits.to_bytes(DIGITAL_BYTES, "little"), dtype=np.uint8)

    def _move_virtual_axes(self) -> None:
        """Axes without a drive follow at once."""
        image = self.image
        for i in self._virtual:
            enabled = bool(image.enable[i]) and not image.quick_stop[i]
            image.state[i] = DriveState.OPERATION_ENABLED if enabled else DriveState.SWITCH_ON_DISABLED
            if enabled:
                image.actual_position[i] = image.target_position[i]
            image.actual_velocity[i] = image.target_velocity[i] if enabled else 0.0

    def _measure_load(self) -> None:
        self._cycles += 1
        if self._cycles == LOAD_WINDOW:
            self.image.bus_load = self._bits / (LOAD_WINDOW * self._period * self._config.bitrate)
            self._cycles, self._bits = 0, 0.0

    # -- what goes wrong ---------------------------------------------------------------------------------------------

    def _watch(self, now: float) -> None:
        """Heartbeats of all nodes, process data of the drives. Time runs from the first cycle on, not the boot."""
        timeout = self._config.heartbeat_timeout
        if not self._watching:
            self._watching = True
            for link in self._links:
                link.last_heartbeat = link.last_data = now
        if not timeout or not self._config.heartbeat:
            return
        latest = now - timeout
        for link in self._links:
            if link.last_heartbeat < latest:
                self._lose(link, catalogue.HEARTBEAT_LOST.id)
        for drive in self._drives:
            if drive.last_data < latest:
                self._lose(drive, catalogue.PROCESS_DATA_LOST.id)

    def _lose(self, link: DriveLink | IoLink, error_id: int, code: int = 0) -> None:
        """The node is gone, its configuration may be lost: it has to go the whole way of the boot to come back."""
        if link.lost:
            return
        link.loss = link.event(error_id, code)
        self.image.events.append(link.loss)
        self._put_out(link)

    def _put_out(self, link: DriveLink | IoLink) -> None:
        link.lost = True
        self._rejoins[link.node] = Rejoin(link, self._dialogues, self._send_data, self._cycle_time)
        if isinstance(link, DriveLink):
            link.control.lose()
            self.image.state[link.axis] = DriveState.OFFLINE
            self.image.actual_velocity[link.axis] = 0.0

    def _step_rejoins(self) -> None:
        """Nodes on their way back, one step each. Raises can.CanError."""
        for rejoin in list(self._rejoins.values()):
            joined = rejoin.step(self._cycle_time)
            if refusal := rejoin.refusal:
                rejoin.refusal = None
                event = rejoin.link.event(catalogue.REJOIN_REFUSED.id, refusal.problem.entry.id, refusal.problem.text)
                if rejoin.told is None or event.code != rejoin.told.code:  # tried again and again, told once
                    rejoin.told = event
                    self.image.events.append(event)
            if joined:
                self._take_in(rejoin.link)

    def _take_in(self, link: DriveLink | IoLink) -> None:
        """The node is in operation again; a drive is disabled, and its axis in tracking."""
        del self._rejoins[link.node]
        link.lost, link.loss = False, None
        link.last_heartbeat = link.last_data = self._cycle_time
        if isinstance(link, DriveLink):
            link.fresh = False
        else:
            self._next_outputs = 0.0  # it has to hear them, changed or not
        self.image.events.append(link.event(catalogue.NODE_REJOINED.id, 0, _moved(link)))

    def _send_data(self, cob_id: int, data: bytes) -> None:
        message = can.Message(arbitration_id=cob_id, is_extended_id=False, dlc=len(data))
        fill(message, data)
        self._send(message)

    def _on_heartbeat(self, link: DriveLink | IoLink, data: bytearray) -> None:
        if not data:
            return
        state = data[0] & 0x7F
        if link.guarded and state != BOOT_UP:
            toggle = data[0] >> 7
            if toggle == link.toggle:  # the answer before, once more: no sign of life (CiA 301, node guarding)
                return
            link.toggle = toggle
        link.nmt_state = state
        link.last_heartbeat = self._cycle_time
        if state == BOOT_UP:
            link.booted = True
        if self._running and not link.lost and state != OPERATIONAL:
            entry = catalogue.NODE_RESTARTED if state == BOOT_UP else catalogue.NODE_LEFT_OPERATIONAL
            self._lose(link, entry.id, state)
        if rejoin := self._rejoins.get(link.node):
            rejoin.on_heartbeat(state)

    def _on_emergency(self, link: DriveLink | IoLink, data: bytearray) -> None:
        if len(data) < 3 or not self._running:
            return
        code = data[0] | data[1] << 8
        if code & 0xFF00:
            self.image.emcy_count += 1
            before, told = link.last_emergency
            if code != before or self._cycle_time - told >= EMERGENCY_PAUSE:  # a storm must not bury the other alarms
                link.last_emergency = code, self._cycle_time
                self.image.events.append(link.event(catalogue.EMERGENCY.id, code))
        else:
            code = 0  # error reset
        if link.axis >= 0:
            self.image.fault_code[link.axis] = code

    def _on_error_frame(self, error_class: int) -> None:
        if error_class & ERROR_FRAME_BUS_OFF and self._running:
            self._bus_gone(catalogue.BUS_OFF.id, 0)

    def _bus_failed(self, error: Exception) -> None:
        if self._gone:
            return
        self._failed = True
        code = getattr(error, "error_code", None) or getattr(error, "errno", None) or 0
        if code in GONE_AT_ONCE or self._failures >= FAILURES_UNTIL_GONE - 1:
            self._bus_gone(catalogue.BUS_GONE.id, code)

    def _bus_gone(self, error_id: int, code: int) -> None:
        self._sending_works = False
        if self._gone:
            return
        self._gone = DriveEvent(error_id, -1, 0, code)
        self._gone_at = self._cycle_time
        for link in self._links:
            link.loss = link.loss or link.event(catalogue.HEARTBEAT_LOST.id)
            self._put_out(link)
        self._publish_inputs()
        self.image.bus_load = 0.0
        self.image.events.append(self._gone)

    def _look_for_bus(self, now: float) -> None:
        """The bus is gone: that frames go out and a frame of somebody else comes in is the proof that it works again.

        That sending succeeds proves little: an interface without carrier takes frames into its queue.
        """
        before = self.image.frames_received - self._error_frames
        try:
            self._receive()
        except BUS_ERRORS:
            return
        heard = self.image.frames_received - self._error_frames > before
        if not (heard and self._sending_works and now - self._gone_at >= RECOVERY_PAUSE):
            return
        self._gone = None
        self._failures, self._failed = 0, False
        self._cycles, self._bits = 0, 0.0
        self.image.events.append(DriveEvent(catalogue.BUS_BACK.id, -1, 0, 0))

    def _try_bus(self) -> None:
        """Heartbeats into a bus that is gone: nodes that have fallen silent hear that the master lives."""
        try:
            self._send(self._heartbeat)
        except BUS_ERRORS:
            self._sending_works = False
        else:
            self._sending_works = True

    def questions(self, link: DriveLink | IoLink) -> Questions:
        """For SDO accesses to a node in operation, between the set-points. What sending raises comes through."""
        return self._questions.setdefault(link.node, Questions(link, self._send_data))

    def drive(self, axis: int) -> DriveLink:
        """The drive of an axis; raises KeyError for an axis without one."""
        for link in self._drives:
            if link.axis == axis:
                return link
        raise KeyError(axis)

    def tell_again(self) -> None:
        """After a reset: what is still lost, because the machine must not go on without it."""
        if self._gone is not None:
            self.image.events.append(self._gone)
            return
        self.image.events.extend(link.loss for link in self._links if link.loss is not None and not link.optional)

    # -- the end -----------------------------------------------------------------------------------------------------

    def stop(self) -> None:
        """Disable the drives in order, outputs off, nodes to pre-operational. At most some seconds; never raises."""
        if not self._running:
            return
        image = self.image
        image.enable[:] = False
        image.reset_fault[:] = False
        end = self._now() + STOP_TIME
        while not self._gone and self._now() < end:
            self._stop_cycle()
            if all(link.control.state in RESTING for link in self._drives):
                break
        image.digital_out[:] = 0
        self._next_outputs = 0.0
        if not self._gone:
            self._stop_cycle()
        self._running = False
        try:
            for link in self._links:
                self._network.send_message(0, bytes((128, link.node)))
        except BUS_ERRORS:
            pass  # a bus that is gone needs no good-bye

    def _stop_cycle(self) -> None:
        self.read()
        self.write()
        try:
            self._wait(lambda: False, self._period)
        except BUS_ERRORS as error:
            self._bus_failed(error)


def _moved(link: DriveLink | IoLink) -> str:
    """How far a drive was moved while nobody looked."""
    if not isinstance(link, DriveLink) or not link.moved:
        return ""
    return f"; it was moved by {link.moved / link.increments_per_unit:+.3f} meanwhile"


def time_of_day(seconds: float) -> bytes:
    """TIME_OF_DAY of CiA 301 for a time in s since 1970: ms since midnight, days since 1984, UTC."""
    days, in_day = divmod(seconds, 86_400.0)
    return struct.pack("<IH", int(in_day * 1000.0), int(days) - DAYS_1970_TO_1984)
