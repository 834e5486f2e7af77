"""One drive system over several buses: a master each, one image, one cycle.

    read()   every bus              write()  set-points of every bus, then the SYNCs, one straight behind the other

So all drives take their set-points over within the time that the SYNCs need to be sent. A bus that is gone is lost like its
nodes: the path is braked, and the axes on the other buses follow it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

import can

from runtime.config.machine import Machine
from runtime.drives import DriveImage, DriveSystem
from runtime.fieldbus.leaving import stop_all
from runtime.fieldbus.master import CanopenMaster, forget


class SeveralMasters:
    """A `DriveSystem` over the buses of a machine, by their names; the arguments are those of `CanopenMaster`."""

    def __init__(
        self,
        machine: Machine,
        buses: Mapping[str, can.BusABC],
        *,
        now: Callable[[], float],
        idle: Callable[[], None],
        wall_clock: Callable[[], float] = time.time,
    ) -> None:
        self.image = DriveImage(len(machine.axes))
        self._now = now
        self.masters = [
            CanopenMaster(machine, bus, now=now, idle=idle, wall_clock=wall_clock, name=name, image=self.image)
            for name, bus in buses.items()
        ]

    def start(self) -> None:
        """Boot all buses, then start all nodes: none waits in operation for another bus. Raises FieldbusError."""
        forget(self.image)
        for master in self.masters:
            master.prepare()
        for master in self.masters:
            master.launch()

    def read(self) -> None:
        """Start of a cycle. Never blocks, never raises."""
        for master in self.masters:
            master.read()

    def write(self) -> None:
        """End of a cycle. Never blocks, never raises."""
        for master in self.masters:
            master.write_set_points()
        for master in self.masters:
            master.write_sync()

    def tell_again(self) -> None:
        """After a reset: what is still lost."""
        for master in self.masters:
            master.tell_again()

    def stop(self) -> None:
        """Disable all drives in order, and leave all buses. At most some seconds; never raises."""
        stop_all(self.masters, self.image, self._now)


def drive_system(
    machine: Machine,
    buses: Mapping[str, can.BusABC],
    *,
    now: Callable[[], float],
    idle: Callable[[], None],
) -> DriveSystem:
    """The master of a machine with one bus, or the masters of one with several."""
    if len(buses) == 1:
        return CanopenMaster(machine, buses[""], now=now, idle=idle)
    return SeveralMasters(machine, buses, now=now, idle=idle)
