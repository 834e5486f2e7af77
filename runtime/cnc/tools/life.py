"""Tool life: how long, and how far, the tool in the spindle was in use (programming manual 29344–29356, 29426–29530).

The path tells where a tool begins and ends; what it travels at feed in between counts, weighted by the factors of the program.
Where rapid traverse ends, the resolution is a cycle. Nothing is recorded before a program has named a tool, and nothing at all
without an external tool management that wants to know: then no such action stands in the path.
"""

from __future__ import annotations

from runtime.cnc.blocks import LifeCommand
from runtime.cnc.queue_record import QueueRecord
from runtime.config.channel.parameters import ChannelParameters
from runtime.hli.layout import Channel
from runtime.hli.tools import Identity, ToolLife, ToolLifePort

_COMMANDS = tuple(LifeCommand)
_NOBODY = Identity(0)


class ToolLifeRecorder:
    """Of one channel, in the cycle.

    Per cycle: `moves`, then the actions that the path has come by (a tool begins exactly at its place), then `moved`. Nobody
    need call them as long as it is not `wanted`.
    """

    def __init__(self, channel: Channel) -> None:
        self._port = ToolLifePort(channel)
        self._tool = _NOBODY
        self._time = self._distance = 0.0  # s, mm, weighted
        self._time_factor = self._distance_factor = 1.0
        self._place = 0.0  # mm along the path, up to which is recorded
        self._suppress_zero = False
        self._rapid_too = False
        self._pace = 0.0  # s/mm of this cycle
        self._rapid = self._rapid_before = False  # the element of this cycle, and that of the one before
        self.wanted = False

    def configure(self, parameters: ChannelParameters) -> None:
        """P-CHAN-00016 and P-CHAN-00076, P-CHAN-00243 and P-CHAN-00255."""
        self.wanted = parameters.ext_wzv_vorhanden and parameters.tool_life_to_wzv
        self._suppress_zero = parameters.tool_life_to_wzv_suppress_zero
        self._rapid_too = parameters.tool_life_capture_all_movements

    @property
    def lost(self) -> int:
        """Reports for which there was no room, because the PLC does not take them."""
        return self._port.lost

    def begin(self) -> None:
        """A program starts, the path begins at 0."""
        self._place = 0.0

    def step(self) -> None:
        """Once per cycle."""
        self._port.step()

    def moves(self, place: float, period: float, rapid: bool) -> None:
        """The path comes to `place` (mm) in a cycle of `period` (s), on an element that is rapid or not."""
        way = place - self._place
        self._pace = period / way if way > 0.0 else 0.0
        self._rapid_before, self._rapid = self._rapid, rapid

    def moved(self, place: float) -> None:
        """All that the path has come by in this cycle was carried out."""
        self._count(place, self._rapid)

    def _count(self, place: float, rapid: bool) -> None:
        way = place - self._place
        if way <= 0.0:
            return
        self._place = place
        if self._tool != _NOBODY and (self._rapid_too or not rapid):
            self._time += way * self._pace * self._time_factor
            self._distance += way * self._distance_factor

    def carry_out(self, record: QueueRecord, place: float) -> None:
        """The path has come to an action of tool life, at `place`."""
        self._count(place, self._rapid_before)
        command = _COMMANDS[record.number]
        tool = Identity(record.offset, record.size, round(record.feed))
        if command is LifeCommand.CHANGE:
            if self._tool != _NOBODY and not (self._suppress_zero and self._nothing):
                self._report(self._tool)
            self._clear()
            self._tool = tool
        elif command is LifeCommand.READ:
            self._report(tool)
        elif command is LifeCommand.REMOVE:
            self._clear()
        elif command is LifeCommand.DEFINE:
            self._time, self._distance = record.seconds, record.value
        else:
            self._time_factor, self._distance_factor = record.seconds, record.value

    def save(self) -> None:
        """Reset, or a program that was aborted: what was recorded so far is told."""
        if self._tool != _NOBODY and not self._nothing:
            self._report(self._tool)
            self._clear()

    @property
    def _nothing(self) -> bool:
        return self._time == 0.0 and self._distance == 0.0

    def _report(self, tool: Identity) -> None:
        self._port.put(ToolLife(tool, self._time, self._distance))

    def _clear(self) -> None:
        self._time = self._distance = 0.0
