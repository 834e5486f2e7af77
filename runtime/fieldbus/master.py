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

import math
import time
from collections.abc import Callable
from functools import partial
from typing import Final

import can

from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.diagnostics.errors import ErrorEntry
from runtime.drives import DriveEvent, DriveImage, DriveState
from runtime.fieldbus import wire
from runtime.fieldbus.beat import Beat
from runtime.fieldbus.boot import BootSequence
from runtime.fieldbus.described import make_links
from runtime.fieldbus.dialogue import SYNC, NodeDialogues, downloads
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.frames import BUS_ERRORS, Frames
from runtime.fieldbus.io_exchange import IoExchange
from runtime.fieldbus.leaving import stop_all
from runtime.fieldbus.links import DriveLink, IoLink, Links, Receiver
from runtime.fieldbus.network import PolledNetwork, PumpedSdoClient
from runtime.fieldbus.node_watch import NodeWatch
from runtime.fieldbus.outage import Outage
from runtime.fieldbus.questions import Questions

HIGH_LOAD: Final = 0.9  # share of the bus, from which on a repeated frame makes a cycle late
ERROR_FRAME_BUS_OFF: Final = 0x40  # SocketCAN: CAN_ERR_BUSOFF
BOOT_UP: Final = 0
DEVICE_TYPE_QUESTION: Final = bytes((0x40, 0x00, 0x10, 0, 0, 0, 0, 0))  # SDO upload of object 0x1000
TOLD_PAUSE: Final = 1.0  # s after which a foreign SYNC is told again
RESTING: Final = (
    DriveState.OFFLINE,
    DriveState.NOT_READY_TO_SWITCH_ON,
    DriveState.SWITCH_ON_DISABLED,
    DriveState.FAULT,
)


class CanopenMaster:
    """A `DriveSystem` (runtime.drives) over CANopen, or the part of one that is on the bus `name` of the machine description.

    Several masters of a machine share an `image` (runtime.fieldbus.several). `now()` gives seconds of a clock that only goes
    forward; `idle()` must let it go forward; `wall_clock()` gives seconds since 1970, for the time stamps that nodes are told.
    The bus is the caller's: it opens it and shuts it down.
    """

    def __init__(
        self,
        machine: Machine,
        bus: can.BusABC,
        *,
        now: Callable[[], float],
        idle: Callable[[], None],
        wall_clock: Callable[[], float] = time.time,
        name: str = "",
        image: DriveImage | None = None,
    ) -> None:
        self.image = DriveImage(len(machine.axes)) if image is None else image
        self._shares_image = image is not None
        self.name = name
        self._machine = machine
        self._config = machine.fieldbus.all_buses()[name]
        self.frames = Frames(bus, self._config, machine.cycle.period, self.image, self._on_error_frame)
        self._outage = Outage(self._config)
        self._period = machine.cycle.period
        self._now = now
        self._wall_clock = wall_clock
        self._idle = idle
        self._network = PolledNetwork(bus, fd=self._config.fd)
        self._links: Links = []
        self._drives: list[DriveLink] = []
        self._clients: dict[int, PumpedSdoClient] = {}  # of the boot
        self._questions: dict[int, Questions] = {}  # by node id: to nodes in operation
        self._virtual = [i for i, axis in enumerate(machine.axes) if axis.drive is None and not name]
        self._forget()

    def _forget(self) -> None:
        """The state before the first cycle."""
        self._running = False
        self._outage.forget()
        self._questions = {}
        self.frames.forget()
        self._foreign_sync_told = -math.inf
        self._flooded_since = math.inf  # s, the first of the cycles that have left frames in the queue
        self._flood_told = False
        self._asked = 0  # index of the node that was asked last on a bus that is gone
        self._cycle_time = 0.0
        guarded = [link.node for link in self._links if link.guarded]
        self._beat = Beat(self._config, guarded, self.frames.send, self._wall_clock)
        self._io = IoExchange(self.image, self._links, self.frames.send)
        self._watch = NodeWatch(
            self.image,
            self._config,
            self._links,
            self.frames.send_data,
            self._io.refresh,
            self.frames.heard.boot_ups,
        )
        if not self._shares_image:
            forget(self.image)

    # -- before the first cycle --------------------------------------------------------------------------------------

    def start(self) -> None:
        """Boot, check and configure all nodes, and start them; the drives stay disabled.

        May be called again after `stop` or after nodes were lost. Raises FieldbusError (ids 303010 to 303040).
        """
        self.prepare()
        self.launch()

    def prepare(self) -> None:
        """The first part of `start`: nothing moves yet, and no node misses a heartbeat. Raises FieldbusError."""
        self._links = self._own(make_links(self._machine))
        self._forget()
        self._drives = [link for link in self._links if isinstance(link, DriveLink)]
        self._plan_load()
        self._dialogues = NodeDialogues(self._machine, self._config, self.image, downloads(self._machine, self.name))
        self._boot = BootSequence(
            self._machine,
            self._config,
            self._network,
            self._links,
            self._dialogues,
            self._wait,
            self.frames.heard,
        )
        self._watch.begin(self._dialogues)
        self._clients = self._boot.clients
        self.frames.table = self._receivers()
        try:
            self.frames.discard()
            self._boot.prepare()
        except BUS_ERRORS as error:
            raise self._gone_at_start(error) from error

    def launch(self) -> None:
        """The second part of `start`: all nodes into operation. Cycles have to follow. Raises FieldbusError."""
        try:
            self._boot.launch()
        except BUS_ERRORS as error:
            raise self._gone_at_start(error) from error
        self._running = self._watch.running = True
        self._cycle_time = self._watch.now = self._now()
        self._io.publish(self._cycle_time)
        for link in self._links:
            if not link.booted:
                self._watch.lose(link, catalogue.NODE_ABSENT.id)

    def _gone_at_start(self, error: Exception) -> FieldbusError:
        return FieldbusError(catalogue.BUS_GONE, meaning=str(error), bus=f" {self._config.channel}")

    def _own(self, links: Links) -> Links:
        """The nodes of this bus, of those of the machine."""
        ios = iter(self._machine.fieldbus.io)
        own: Links = []
        for link in links:
            described = self._machine.axes[link.axis].drive if isinstance(link, DriveLink) else next(ios)
            if described is not None and (described.bus or "") == self.name:
                own.append(link)
        return own

    def _receivers(self) -> dict[int, Receiver]:
        table: dict[int, Receiver] = {SYNC: self._on_foreign_sync}
        table[self._beat.heartbeat.arbitration_id] = self._on_foreign_master
        for link in self._links:
            table |= link.receivers()
            table[0x580 + link.node] = partial(self._on_sdo, link)
        return table | self._watch.receivers()

    def _on_sdo(self, link: DriveLink | IoLink, data: bytearray) -> None:
        if self._watch.on_answer(link, data):
            return
        if questions := self._questions.get(link.node):
            questions.on_answer(data)
        elif not self._running:
            self._clients[link.node].take(data)

    def _on_foreign_master(self, data: bytearray) -> None:
        self.frames.heard.master = True

    def _on_foreign_sync(self, data: bytearray) -> None:
        self.frames.heard.master = True
        if self._running and self._cycle_time - self._foreign_sync_told >= TOLD_PAUSE:
            self._foreign_sync_told = self._cycle_time
            self._tell(catalogue.FOREIGN_SYNC)

    def _wait(self, condition: Callable[[], bool], seconds: float) -> bool:
        """Let bus and time run until `condition` holds; False after `seconds`. Raises can.CanError."""
        deadline = self._now() + seconds
        while True:
            self.frames.receive()
            if condition():
                return True
            if self._now() >= deadline:
                return False
            self._idle()

    def _plan_load(self) -> None:
        """Refuse what the wire cannot carry, before anybody is told to send it. Raises FieldbusError."""
        if self._config.interface != "socketcan":
            return  # no wire
        planned = wire.planned_load(self._links, self._config, self._period)
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
            self._tell(catalogue.BUS_OVERLOADED, round(planned * 100))

    # -- the cycle ---------------------------------------------------------------------------------------------------

    def read(self) -> None:
        """Start of a cycle: bring the feedback into the image. Never blocks, never raises."""
        image = self.image
        if self._virtual:
            self._move_virtual_axes()
        if not self._running:
            return
        self._cycle_time = self._watch.now = now = self._now()
        if self._outage.gone:
            self._look_for_bus(now)
            return
        self._outage.cycle()
        try:
            drained = self.frames.receive()
        except BUS_ERRORS as error:
            self._bus_failed(error)
            return
        for link in self._drives:
            if link.fresh and not link.lost:
                link.last_data = now
            if not link.lost:
                link.feedback(image, self._period)
        if drained:
            self._flooded_since, self._flood_told = math.inf, False
            self._watch.look(now)
        else:  # what has come while no cycle ran is no flood
            self._flooded_since = min(self._flooded_since, now)
            if now - self._flooded_since > self._config.heartbeat_timeout and not self._flood_told:
                self._flood_told = True
                self._tell(catalogue.BUS_FLOODED)
        self._io.publish(self._cycle_time)
        self.frames.measure()

    def write(self) -> None:
        """End of a cycle: send set-points, outputs and SYNC. Never blocks, never raises."""
        self.write_set_points()
        self.write_sync()

    def write_set_points(self) -> None:
        """The first part of `write`: what the nodes take over at the SYNC."""
        if not self._running:
            return
        if self._outage.gone:
            if self._outage.tried(self._cycle_time) and self._beat.heartbeat_due(self._cycle_time):
                self._try_bus()
            return
        image = self.image
        positions = (image.target_position + image.correction - image.origin).tolist()
        velocities = image.target_velocity.tolist()
        enable, quick_stop, reset = image.enable.tolist(), image.quick_stop.tolist(), image.reset_fault.tolist()
        send = self.frames.send
        try:
            for link in self._drives:
                i = link.axis
                link.command(image, (velocities if link.spindle else positions)[i], enable[i], quick_stop[i], reset[i])
                send(link.message)
                for message in link.further:
                    send(message)
            self._io.send_outputs(self._cycle_time)
            self._watch.step()
        except BUS_ERRORS as error:
            self._bus_failed(error)

    def write_sync(self) -> None:
        """The second part of `write`."""
        if not self._running or self._outage.gone:
            return
        try:
            self._beat.sync(self._cycle_time)
        except BUS_ERRORS as error:
            self._bus_failed(error)

    def _move_virtual_axes(self) -> None:
        """Axes without a drive follow at once."""
        image = self.image
        for i in self._virtual:
            enabled = bool(image.enable[i]) and not image.quick_stop[i]
            image.state[i] = DriveState.OPERATION_ENABLED if enabled else DriveState.SWITCH_ON_DISABLED
            if enabled:
                image.actual_position[i] = image.target_position[i]
            image.actual_velocity[i] = image.target_velocity[i] if enabled else 0.0

    # -- what goes wrong ---------------------------------------------------------------------------------------------

    def _on_error_frame(self, error_class: int) -> None:
        if error_class & ERROR_FRAME_BUS_OFF and self._running:
            self._bus_gone(catalogue.ONE_BUS_OFF if self._machine.fieldbus.buses else catalogue.BUS_OFF, 0)

    def _bus_failed(self, error: Exception) -> None:
        code = getattr(error, "error_code", None) or getattr(error, "errno", None) or 0
        if not self._outage.gone and self._outage.failed(code):
            self._bus_gone(catalogue.ONE_BUS_GONE if self._machine.fieldbus.buses else catalogue.BUS_GONE, code)

    def _bus_gone(self, entry: ErrorEntry, code: int) -> None:
        outage = self._outage
        outage.sending_works = False
        if outage.gone:
            return
        self._watch.lose_all()
        self._io.publish(self._cycle_time)
        self.frames.begin_load(gone=True)
        outage.begin(self._tell(entry, code), self._cycle_time)
        if outage.waits:
            self._tell(catalogue.BUS_WAITS, outage.recoveries)

    def _look_for_bus(self, now: float) -> None:
        """The bus is gone: that frames go out and a frame of somebody else comes in is the proof that it works again."""
        before = self.frames.taken
        try:
            self.frames.receive()
        except BUS_ERRORS:
            return
        if self.frames.taken > before and self._outage.heard(now):
            self.frames.begin_load(gone=False)
            self._tell(catalogue.BUS_BACK)

    def _try_bus(self) -> None:
        """Heartbeats into a bus that is gone: nodes that have fallen silent hear that the master lives.

        And a question to one node after the other: nodes that were just being reset have no heartbeat to be heard by.
        """
        try:
            self.frames.send(self._beat.heartbeat)
            if self._links:
                self._asked = (self._asked + 1) % len(self._links)
                self.frames.send_data(0x600 + self._links[self._asked].node, DEVICE_TYPE_QUESTION)
        except BUS_ERRORS:
            self._outage.sending_works = False
        else:
            self._outage.sending_works = True

    def tell_again(self) -> None:
        """After a reset: what is still lost, because the machine must not go on without it."""
        self._outage.reset()
        if self._outage.gone is not None:
            self.image.events.append(self._outage.gone)
            return
        self.image.events.extend(self._watch.lost_again())

    def _tell(self, entry: ErrorEntry, code: int = 0) -> DriveEvent:
        """An event of the bus itself."""
        event = DriveEvent(entry.id, -1, 0, code, bus=self.name)
        self.image.events.append(event)
        return event

    def questions(self, link: DriveLink | IoLink) -> Questions:
        """For SDO accesses to a node in operation, between the set-points. What sending raises comes through."""
        return self._questions.setdefault(link.node, Questions(link, self.frames.send_data))

    def drive(self, axis: int) -> DriveLink:
        """The drive of an axis; raises KeyError for an axis without one."""
        for link in self._drives:
            if link.axis == axis:
                return link
        raise KeyError(axis)

    # -- the end -----------------------------------------------------------------------------------------------------

    def stop(self) -> None:
        """Disable the drives in order, outputs off, nodes to pre-operational. At most some seconds; never raises."""
        stop_all([self], self.image, self._now)

    @property
    def resting(self) -> bool:
        """Nothing on this bus moves any more, or nobody can be told to stop."""
        return (
            bool(self._outage.gone) or not self._running or all(link.control.state in RESTING for link in self._drives)
        )

    @property
    def running(self) -> bool:
        """Whether cycles are to follow."""
        return self._running

    def refresh_outputs(self) -> None:
        """The next outputs go out whether they changed or not."""
        self._io.refresh()

    def switch_off_outputs(self) -> None:
        """The outputs as they are without a machine that runs."""
        self._io.switch_off()

    def pass_a_cycle(self) -> None:
        """Let a period go by, with the frames that come. Never raises."""
        try:
            self._wait(lambda: False, self._period)
        except BUS_ERRORS as error:
            self._bus_failed(error)

    def leave(self) -> None:
        """The last word: all nodes to pre-operational. Never raises."""
        self._running = self._watch.running = False
        try:
            for link in self._links:
                self._network.send_message(0, bytes((128, link.node)))
        except BUS_ERRORS:
            pass  # a bus that is gone needs no good-bye


def forget(image: DriveImage) -> None:
    """The image before the first cycle."""
    image.events.clear()
    image.state[:] = DriveState.OFFLINE
    image.fault_code[:] = 0
