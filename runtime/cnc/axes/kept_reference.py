"""References that outlive the supply: an absolute encoder, whose axis was homed once (`homing.absolute`).

What is kept of an axis is its origin (where its drive counts 0), where it stood last, and which drive it was. When the drive
comes, at the start or later, the axis has its reference again, if

- it is the same drive (vendor, product, serial number: object 0x1018), and
- the axis stands no further from where it stood than `moved`, the nearest place counting that looks so to the encoder.

Else it has none, an alarm tells why, and it has to be homed. A reference that is not trusted is forgotten at once.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import machine as alarms
from runtime.diagnostics.errors import Problem
from runtime.drives import DriveImage, DriveState
from runtime.hli.layout import Hli, ReferenceState

_OFFLINE: Final = int(DriveState.OFFLINE)


class KeptReferences:
    """Of all axes with such an encoder. `step` once per cycle, behind the status; nothing is done for other machines.

    `referenced(i)` tells whether axis i has its reference now; `shift` and `refer` are those of the controller.
    """

    def __init__(
        self,
        machine: Machine,
        hli: Hli,
        image: DriveImage,
        referenced: Callable[[int], bool],
        shift: Callable[[int, float], None],
        refer: Callable[[int, bool], None],
    ) -> None:
        self._names = [axis.name for axis in machine.axes]
        self._setups = [None if axis.homing is None else axis.homing.absolute for axis in machine.axes]
        self.axes = [i for i, setup in enumerate(self._setups) if setup is not None]
        self._scales = [axis.drive.increments_per_unit if axis.drive else 1.0 for axis in machine.axes]
        self._image, self._referenced, self._shift, self._refer = image, referenced, shift, refer
        self._areas = [hli.axes[i].reference for i in range(len(machine.axes))]
        n = len(machine.axes)
        self._kept = [False] * n
        self._origin = np.zeros(n)
        self._place = np.zeros(n)
        self._identity: npt.NDArray[np.uint32] = np.zeros((n, 3), dtype=np.uint32)
        self._online = [False] * n

    def restore(self, kept: Mapping[str, Mapping[str, Any]]) -> None:
        """What was kept, by the names of the axes; before the first cycle."""
        for i in self.axes:
            values = kept.get(self._names[i])
            if values is not None and values["increments_per_unit"] == self._scales[i]:
                self._kept[i] = True
                self._origin[i], self._place[i] = values["origin"], values["place"]
                self._identity[i] = values["identity"]
            self._show(i)

    def came(self) -> Sequence[tuple[int, Problem]]:
        """At the begin of a cycle: drives that have come, and what is to be told of their axes."""
        found = []
        for i in self.axes:
            online = int(self._image.state[i]) != _OFFLINE
            if online and not self._online[i] and self._kept[i]:
                problem = self._take(i)
                if problem is not None:
                    found.append((i, problem))
            self._online[i] = online
        return found

    def _take(self, i: int) -> Problem | None:
        """The reference of an axis whose drive has come, or why it is forgotten."""
        image, setup, name = self._image, self._setups[i], self._names[i]
        assert setup is not None
        problem = None
        turn = setup.turn(self._scales[i])
        place = float(image.actual_position[i] - image.origin[i] + self._origin[i])
        turns = round((float(self._place[i]) - place) / turn)
        place += turns * turn
        if image.identity[i].tolist() != self._identity[i].tolist():
            problem = Problem(alarms.REFERENCE_OTHER_DRIVE, {"axis": name})
        elif abs(place - self._place[i]) > setup.moved:
            values = {"axis": name, "before": float(self._place[i]), "now": place, "moved": setup.moved}
            problem = Problem(alarms.REFERENCE_MOVED, values)
        if problem is not None:
            self._kept[i] = False
            self._refer(i, False)
        else:
            self._origin[i] += turns * turn
            self._shift(i, float(self._origin[i] - image.origin[i]))
            self._refer(i, True)
        self._show(i)
        return problem

    def step(self) -> None:
        """At the end of a cycle: references that were found or lost, and where the axes are."""
        image = self._image
        for i in self.axes:
            if not self._online[i]:
                continue  # what is kept waits for the drive
            referenced = self._referenced(i)
            if referenced is not self._kept[i] or (referenced and image.origin[i] != self._origin[i]):
                self._kept[i] = referenced
                self._origin[i] = image.origin[i]
                self._identity[i] = image.identity[i]
                self._show(i)
            if referenced:
                self._place[i] = self._areas[i].place_r = image.actual_position[i]

    def _show(self, i: int) -> None:
        """Into the interface, from where it is kept; the state is the last store."""
        area = self._areas[i]
        area.state_r = ReferenceState.UNKNOWN
        area.origin_r, area.place_r = self._origin[i], self._place[i]
        area.vendor_r, area.product_r, area.serial_r = self._identity[i].tolist()
        area.state_r = ReferenceState.KEPT if self._kept[i] else ReferenceState.NONE
