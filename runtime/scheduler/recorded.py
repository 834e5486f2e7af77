"""A controller behind the border of the recorder: in the cycle process, in the simulation, in the bench."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from runtime.cnc.motion_queue import MotionQueue
from runtime.cnc.preparation_link import PreparationLink
from runtime.config.machine import KeyframesWhen, Machine
from runtime.diagnostics.errors import Problem
from runtime.drives import DriveState, DriveSystem
from runtime.hli.memory import HliMemory
from runtime.recorder.border import Border, BorderDrives, BorderPlc, Memories
from runtime.recorder.file import RecordingWriter
from runtime.recorder.header import make_header
from runtime.recorder.ring import RecorderRing
from runtime.scheduler.controller import Controller
from runtime.scheduler.plc_link import PlcPartner

_ENABLED = int(DriveState.OPERATION_ENABLED)


def watch(border: Border, controller: Controller, when: KeyframesWhen = "always") -> None:
    """The controller is built: from here on it is recorded, with keyframes of its state.

    A keyframe makes a cycle longer. `when` one may be taken: "always", at "standstill", or while no drive is enabled.
    """
    states = controller.drives.image.state

    def still() -> bool:
        at_rest = controller.channel.interpolator.standstill and controller.beside.at_rest and controller.jobs.standing
        return at_rest and (when == "standstill" or not bool((states == _ENABLED).any()))

    border.settle(controller, controller.channel.backward.storage)
    if when != "always":
        border.may_take = still


@dataclass(frozen=True, slots=True)
class Seam:
    """Everything through which a controller and the outside meet."""

    drives: DriveSystem
    memory: HliMemory
    queue: MotionQueue
    link: PreparationLink
    plc: PlcPartner | None
    wall_clock: Callable[[], int]


def put_border(
    machine: Machine,
    outside: Seam,
    ring: RecorderRing,
    partner: Callable[[HliMemory], PlcPartner] | None = None,
) -> tuple[Seam, Border]:
    """The seam for a controller that is to be recorded. `settle` of the border follows when the controller is built.

    `partner` makes the one that wakes a PLC in another process, on the memory of the controller, since it is a part of the
    cycle; without it the PLC of `outside` does its cycle in this process.
    """
    memories = Memories(outside.memory, outside.link, outside.queue)
    border = Border(machine, memories, outside.drives.image, ring, outside.wall_clock)
    drives = BorderDrives(outside.drives, border)
    inner = outside.plc if partner is None else partner(memories.hli)
    plc = BorderPlc(inner, border, inline=partner is None) if inner is not None else None
    inside = Seam(drives, memories.hli, memories.queue, memories.link, plc, lambda: border.wall_ns)
    return inside, border


class SimulationRecording:
    """The recorder of a simulation, which writes into one file as it goes."""

    def __init__(
        self, path: Path, machine: Machine, machine_file: Path | None, outside: Seam, *, real_drives: bool
    ) -> None:
        plc = "none" if outside.plc is None else "inline"
        header = make_header(machine, machine_file, outside.drives.image, plc, real=real_drives)
        self._ring = RecorderRing(size=4 << 20)
        self._writer = RecordingWriter(path, header)
        self.seam, self.border = put_border(machine, outside, self._ring)

    def drain(self) -> None:
        """Behind a cycle."""
        if self._ring.waiting > 1 << 20:
            self.flush()

    def flush(self) -> None:
        """Write what has come."""
        while self._ring.waiting:
            self._writer.add(self._ring.take())

    def close(self) -> None:
        """Write what has still come."""
        self.flush()
        self._writer.close()


def told_alarm(problem: Problem, axis: int) -> dict[str, object]:
    """An alarm as a call in a recording."""
    place = problem.place
    values = {
        name: value if isinstance(value, int | float | str) else str(value) for name, value in problem.values.items()
    }
    where = [place.file, place.line, place.column, place.text]
    return {"id": problem.entry.id, "values": values, "place": where, "axis": axis}
