"""Boot of the bus, as CiA 302-2 has it: reset, wait for the boot-up messages, check who is there, configure, start.

Everything here happens before the first cycle. Whoever is missing or wrong stops the start with an error that
names it; a node that is optional may be missing, and comes in later (runtime.fieldbus.rejoin).
"""

from __future__ import annotations

from typing import Final

from canopen.nmt import NmtMaster
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError

from runtime.config.machine import Bus, Machine
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.fieldbus.canopen_fd import USDO_REQUEST, WAIT, Heard, device_type_question
from runtime.fieldbus.dialogue import Dialogue, NodeDialogues, aborted, decoded, encoded, refused, silent
from runtime.fieldbus.error_codes import nmt_state_text
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.links import DriveLink, IoLink, Links
from runtime.fieldbus.network import PolledNetwork, PumpedSdoClient, Wait

OPERATIONAL: Final = 5
SECOND_BOOT_UP: Final = 0.05  # s in which a second node with the same id would boot too


class BootSequence:
    """One boot. `heard`: filled by whoever receives; `wait` lets bus and time run."""

    def __init__(
        self,
        machine: Machine,
        bus: Bus,
        network: PolledNetwork,
        links: Links,
        dialogues: NodeDialogues,
        wait: Wait,
        heard: Heard,
    ) -> None:
        self._heard = heard
        self._machine = machine
        self._bus = bus
        self._network = network
        self._links = links
        self._dialogues = dialogues
        self._wait = wait
        self.clients = {link.node: PumpedSdoClient(link.node, link.od, wait) for link in links}
        for client in self.clients.values():
            client.network = network

    def prepare(self) -> None:
        """Check and configure every node; raises FieldbusError. Optional nodes that are missing stay `booted` = False."""
        self._listen()
        self._reset()
        present = [link for link in self._links if link.booted]
        for link in present:
            self._identify(link)
        for link in present:
            self._hold(link, self._dialogues.configure(link))
            self._hold(link, self._dialogues.first_values(link))

    def _identify(self, link: DriveLink | IoLink) -> None:
        """Raises FieldbusError for another device than is described, and for one of another application layer."""
        node, heard = link.node, self._heard
        if node in heard.long_frames:
            raise refused(catalogue.CANOPEN_FD, link)
        try:
            self._hold(link, self._dialogues.identify(link))
        except FieldbusError as error:
            if self._bus.fd and error.problem.entry is catalogue.SDO_NO_ANSWER:
                self._network.send_message(USDO_REQUEST + self._bus.master_node, device_type_question(node))
                if self._wait(lambda: node in heard.usdo_answers, WAIT):
                    raise refused(catalogue.CANOPEN_FD, link) from error
            raise

    def launch(self) -> None:
        """Bring every node that is there to OPERATIONAL; raises FieldbusError."""
        present = [link for link in self._links if link.booted]
        for link in present:
            self._command(link.node, "OPERATIONAL")
            if link.guarded:
                self._network.send_message(0x700 + link.node, b"", remote=True)
        self._wait_operational(present)

    def _listen(self) -> None:
        """Two masters on one bus would move the axes by turns."""
        if self._wait(lambda: self._heard.master, max(1.5 * self._bus.heartbeat, 2 * self._machine.cycle.period)):
            raise FieldbusError(catalogue.OTHER_MASTER, channel=self._bus.channel)

    def _reset(self) -> None:
        self._reset_once()
        if self._doubled():  # one that was just being switched on boots twice too
            self._reset_once()
            if doubled := self._doubled():
                raise refused(catalogue.NODE_DOUBLE, doubled[0])
        if absent := [link for link in self._links if not link.booted and not link.optional]:
            missing = ", ".join(f"node {link.node} ({link.owner})" for link in absent)
            raise FieldbusError(catalogue.NODE_MISSING, nodes=missing, seconds=self._bus.boot_timeout)

    def _reset_once(self) -> None:
        for link in self._links:
            link.booted = False
        self._heard.boot_ups.clear()
        # Reset of the communication only: a fault of the drive and its cause stay to be seen.
        self._command(0, "RESET COMMUNICATION")
        self._wait(lambda: all(link.booted for link in self._links), self._bus.boot_timeout)
        self._wait(lambda: False, SECOND_BOOT_UP)

    def _doubled(self) -> Links:
        return [link for link in self._links if self._heard.boot_ups[link.node] > 1]

    def _wait_operational(self, links: Links) -> None:
        if not self._bus.heartbeat:
            return
        if not self._wait(lambda: all(link.nmt_state == OPERATIONAL for link in links), self._bus.boot_timeout):
            link = next(link for link in links if link.nmt_state != OPERATIONAL)
            raise refused(catalogue.NODE_NOT_OPERATIONAL, link, state=nmt_state_text(link.nmt_state))

    def _command(self, node: int, state: str) -> None:
        nmt = NmtMaster(node)
        nmt.network = self._network
        nmt.state = state

    def _hold(self, link: DriveLink | IoLink, dialogue: Dialogue) -> None:
        """Carry a dialogue out, waiting for each answer."""
        client = self.clients[link.node]
        try:
            access = next(dialogue)
            while True:
                answer = 0
                try:
                    if access.reads:
                        answer = decoded(link, access, client.upload(access.index, access.subindex))
                    else:
                        client.download(access.index, access.subindex, encoded(link, access))
                except SdoAbortedError as error:
                    raise aborted(link, access, error.code) from error
                except SdoCommunicationError as error:
                    raise silent(link, access, str(error)) from error
                access = dialogue.send(answer)
        except StopIteration:
            return
