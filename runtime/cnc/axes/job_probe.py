"""The probe of an axis: a job that moves nothing, and waits for an edge."""

from __future__ import annotations

from runtime.cnc.axes.job_values import Followed
from runtime.hli.axis_jobs import Job

_FALLING = 1  # edge
DRIVE_PROBES = 513  # number of the first touch probe of the axis's own drive: behind the inputs of the image


class JobProbe:
    """At most one job waits. What the probe does tells its caller, who answers the job."""

    def __init__(self, of_drive: frozenset[tuple[int, int]] = frozenset()) -> None:
        """`of_drive`: number (from `DRIVE_PROBES` on) and edge of the touch probes that the drive latches itself."""
        self._of_drive = of_drive
        self._waiting: Followed | None = None
        self._before: bool | None = None  # level of the input in the cycle before

    def wait(self, followed: Followed | None) -> Followed | None:
        """A job waits from now on, or none; the one that has waited and does no longer."""
        before, self._waiting, self._before = self._waiting, followed, None
        return before

    def known(self, job: Job) -> bool:
        """The input can be asked for this edge."""
        return job.master < DRIVE_PROBES or (job.master, job.mode) in self._of_drive

    def edge(self, level: bool) -> bool:
        """The level of the input in this cycle; TRUE if that is the edge that a job waits for."""
        before, self._before = self._before, level
        if self._waiting is None or before is None or before is level:
            return False
        return level is self.rises

    @property
    def rises(self) -> bool:
        """The edge that a job waits for is a rising one."""
        return self._waiting is not None and self._waiting.job.mode != _FALLING

    @property
    def input(self) -> int:
        """Number of the input that a job waits for, 0 none."""
        return 0 if self._waiting is None else self._waiting.job.master
