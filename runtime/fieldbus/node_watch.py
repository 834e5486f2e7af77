"""The nodes of one bus while the machine runs: who is heard, who is lost, what they report, who is on the way back."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import Final

from runtime.config.machine import Bus
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.drives import DriveEvent, DriveImage, DriveState
from runtime.fieldbus.boot import OPERATIONAL
from runtime.fieldbus.dialogue import NodeDialogues
from runtime.fieldbus.links import DriveLink, IoLink, Links, Receiver
from runtime.fieldbus.rejoin import BOOT_UP, Rejoin

EMERGENCY_PAUSE: Final = 1.0  # s in which the same emergency of a node is told once


class NodeWatch:
    """`send(cob_id, data)` puts a frame on the bus; what it raises comes through. `boot_ups`: counted by node id.

    `running` and `now` (s, of this cycle) are set by the master.
    """

    def __init__(
        self,
        image: DriveImage,
        bus: Bus,
        links: Links,
        send: Callable[[int, bytes], None],
        refresh_outputs: Callable[[], None],
        boot_ups: Counter[int],
    ) -> None:
        self.running = False
        self.now = 0.0
        self._image = image
        self._config = bus
        self._links = links
        self._send = send
        self._refresh_outputs = refresh_outputs
        self._boot_ups = boot_ups
        self._rejoins: dict[int, Rejoin] = {}  # by node id: those on their way back
        self._watching = False

    def begin(self, dialogues: NodeDialogues) -> None:
        """Before the boot: how nodes are talked to that come back later."""
        self._dialogues = dialogues

    def receivers(self) -> dict[int, Receiver]:
        """COB-ID → who takes its data: emergencies and heartbeats."""
        table: dict[int, Receiver] = {}
        for link in self._links:
            table[0x080 + link.node] = partial(self.on_emergency, link)
            table[0x700 + link.node] = partial(self.on_heartbeat, link)
        return table

    def on_answer(self, link: DriveLink | IoLink, data: bytearray) -> bool:
        """An SDO answer; False if the node is not on its way back."""
        rejoin = self._rejoins.get(link.node)
        if rejoin is not None:
            rejoin.on_answer(data)
        return rejoin is not None

    def lost_again(self) -> list[DriveEvent]:
        """How the nodes were lost that the machine must not go on without."""
        return [link.loss for link in self._links if link.loss is not None and not link.optional]

    def lose_all(self) -> None:
        """The bus is gone."""
        for link in self._links:
            link.loss = link.loss or link.event(catalogue.HEARTBEAT_LOST.id)
            self.put_out(link)

    def look(self, now: float) -> None:
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
                self.lose(link, catalogue.HEARTBEAT_LOST.id)
        for link in self._links:
            if isinstance(link, DriveLink) and link.last_data < latest:
                self.lose(link, catalogue.PROCESS_DATA_LOST.id)

    def lose(self, link: DriveLink | IoLink, error_id: int, code: int = 0) -> None:
        """The node is gone, its configuration may be lost: it has to go the whole way of the boot to come back."""
        if link.lost:
            return
        link.loss = link.event(error_id, code)
        self._image.events.append(link.loss)
        self.put_out(link)

    def put_out(self, link: DriveLink | IoLink) -> None:
        link.lost = True
        self._rejoins[link.node] = Rejoin(link, self._dialogues, self._send, self.now)
        if isinstance(link, DriveLink):
            link.lose()
            self._image.state[link.axis] = DriveState.OFFLINE
            self._image.actual_velocity[link.axis] = 0.0

    def step(self) -> None:
        """Nodes on their way back, one step each. Raises can.CanError."""
        for rejoin in list(self._rejoins.values()):
            joined = rejoin.step(self.now)
            if refusal := rejoin.refusal:
                rejoin.refusal = None
                event = rejoin.link.event(catalogue.REJOIN_REFUSED.id, refusal.problem.entry.id, refusal.problem.text)
                if rejoin.told is None or event.code != rejoin.told.code:  # tried again and again, told once
                    rejoin.told = event
                    self._image.events.append(event)
            if joined:
                self._take_in(rejoin.link)

    def _take_in(self, link: DriveLink | IoLink) -> None:
        """The node is in operation again; a drive is disabled, and its axis in tracking."""
        del self._rejoins[link.node]
        link.lost, link.loss = False, None
        link.last_heartbeat = link.last_data = self.now
        if isinstance(link, DriveLink):
            link.fresh = False
        else:
            self._refresh_outputs()  # it has to hear them, changed or not
        self._image.events.append(link.event(catalogue.NODE_REJOINED.id, 0, _moved(link)))

    def on_heartbeat(self, link: DriveLink | IoLink, data: bytearray) -> None:
        if not data:
            return
        state = data[0] & 0x7F
        if link.guarded and state != BOOT_UP:
            toggle = data[0] >> 7
            if toggle == link.toggle:  # the answer before, once more: no sign of life (CiA 301, node guarding)
                return
            link.toggle = toggle
        link.nmt_state = state
        link.last_heartbeat = self.now
        if state == BOOT_UP:
            link.booted = True
            self._boot_ups[link.node] += 1
        if self.running and not link.lost and state != OPERATIONAL:
            entry = catalogue.NODE_RESTARTED if state == BOOT_UP else catalogue.NODE_LEFT_OPERATIONAL
            self.lose(link, entry.id, state)
        if rejoin := self._rejoins.get(link.node):
            rejoin.on_heartbeat(state)

    def on_emergency(self, link: DriveLink | IoLink, data: bytearray) -> None:
        if len(data) < 3 or not self.running:
            return
        code = data[0] | data[1] << 8
        if code & 0xFF00:
            self._image.emcy_count += 1
            before, told = link.last_emergency
            if code != before or self.now - told >= EMERGENCY_PAUSE:  # a storm must not bury the other alarms
                link.last_emergency = code, self.now
                self._image.events.append(link.event(catalogue.EMERGENCY.id, code))
        else:
            code = 0  # error reset
        if link.axis >= 0:
            self._image.fault_code[link.axis] = code


def _moved(link: DriveLink | IoLink) -> str:
    """How far a drive was moved while nobody looked."""
    if not isinstance(link, DriveLink) or not link.moved:
        return ""
    return f"; it was moved by {link.moved / link.increments_per_unit:+.3f} meanwhile"
