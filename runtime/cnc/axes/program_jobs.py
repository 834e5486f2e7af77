"""Jobs that a program gives to axes outside of its path: handed over, followed, and waited for.

    path ── order ──▶ ordered ──▶ MachineJobs ──▶ axis
                │                                  │
                └──▶ followed here ◀── answer ─────┘      gate: passable, or the problem that stops the program

A job is over for the program when it is done, or has its velocity or its gear. One that fails stops the program, whether it
waits for it or not. One that another job ends before it is over stops the program that waits for it: what it waits for never
comes.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from runtime.cnc.axes.job_values import Followed, spelt
from runtime.cnc.blocks import AxisJob
from runtime.diagnostics.catalogue import axis_jobs as errors
from runtime.diagnostics.errors import Place, Problem
from runtime.hli.axis_jobs import Answer, Job
from runtime.hli.layout import AxisFunction, JobState

_GOES_ON = (JobState.NONE, JobState.BUSY, JobState.ACTIVE, JobState.REACHED)
_MOST_IDS = 256  # that lead to jobs which are not done
_NO_MOTION = (AxisFunction.STOP, AxisFunction.HOME, AxisFunction.TOUCH_PROBE)


class _Given:
    """A job under way."""

    __slots__ = ("aborted", "followed", "order", "over")

    def __init__(self, order: AxisJob) -> None:
        self.order = order
        self.followed = Followed(order.job)
        self.over = False  # for the program
        self.aborted = False


class ProgramJobs:
    """Of one channel. Everything is bounded: of each axis at most four jobs go on, and what a cycle hands over."""

    def __init__(self, names: Sequence[str]) -> None:
        """`names` of all axes of the machine."""
        self._names = names
        self.ordered: deque[tuple[int, Followed]] = deque()  # with the axis; taken by whoever moves it
        self._given: list[_Given] = []  # those that go on, and those that were aborted and are still waited for
        self._last: dict[int, _Given] = {}  # by id, of those
        self._coasting: set[int] = set()  # axes that go on behind a gear

    def begin(self) -> None:
        """A program starts: jobs of the one before go on, and are no longer followed."""
        self._given.clear()
        self._last.clear()
        self._coasting.clear()

    def order(self, order: AxisJob, *, locked: bool) -> None:
        """The path has come to a job. `locked`: the axes are not moved in this program, so everything is done at once."""
        self._last.pop(order.id, None)
        if locked:
            return
        self._coasting.discard(order.axis)
        if order.job.function is AxisFunction.GEAR_OUT:
            self._coasting.add(order.axis)
        given = _Given(order)
        self._given.append(given)
        if order.id >= 0:
            self._last[order.id] = given
        self.ordered.append((order.axis, given.followed))

    def step(self) -> Problem | None:
        """Once per cycle: what became of the jobs; the problem of one that failed."""
        if not self._given:
            return None
        failed: _Given | None = None
        for given in self._given:
            state = given.followed.answer.state
            given.over |= state in (JobState.REACHED, JobState.DONE)
            given.aborted = state is JobState.ABORTED and not given.over
            if state is JobState.ERROR:
                failed = given
        self._forget()
        if len(self._last) > _MOST_IDS:
            return self._problem(self._given[-1], f"is one too many: {_MOST_IDS} jobs with an id are not done")
        return None if failed is None else self._problem(failed, f"has failed (error {failed.followed.answer.error})")

    def _forget(self) -> None:
        """Jobs of which nothing is to be expected any more; an aborted one as soon as no id leads to it."""
        gone = [given for given in self._given if given.followed.answer.state not in _GOES_ON]
        for given in gone:
            named = self._last.get(given.order.id) is given
            if given.aborted and (named or given.order.waits):
                continue
            self._given.remove(given)
            if named:
                del self._last[given.order.id]

    def passable(self, number: int) -> bool:
        """A gate opens: for the job with this id, or with -1 for all that the block waits for."""
        return all(given.over for given in self._awaited(number))

    def in_vain(self, number: int) -> Problem | None:
        """Why a gate will never open."""
        aborted = next((given for given in self._awaited(number) if given.aborted), None)
        return None if aborted is None else self._problem(aborted, "was aborted by another job, and is waited for")

    def _awaited(self, number: int) -> list[_Given]:
        if number >= 0:
            given = self._last.get(number)
            return [] if given is None else [given]
        return [given for given in self._given if given.order.waits]

    def stop(self) -> None:
        """The program is aborted: the axes that its jobs move come to rest, its probes wait no longer."""
        if not self._given and not self._coasting:
            return
        moved, probed = set(self._coasting), set[int]()
        for given in self._given:
            followed = given.followed
            if followed.job.function is AxisFunction.TOUCH_PROBE and followed.answer.state in _GOES_ON:
                probed.add(given.order.axis)
            if followed.answer.state in _GOES_ON and followed.job.function not in _NO_MOTION:
                moved.add(given.order.axis)
        self.drop()
        self.ordered.extend((axis, Followed(Job(AxisFunction.ABORT_TRIGGER))) for axis in sorted(probed))
        self.ordered.extend((axis, Followed(Job(AxisFunction.STOP))) for axis in sorted(moved))

    def drop(self) -> None:
        """Nothing that was ordered and not yet taken shall move."""
        while self.ordered:
            _, followed = self.ordered.popleft()
            followed.answer = Answer(JobState.ABORTED)
        self.begin()

    def _problem(self, given: _Given, what: str) -> Problem:
        source = given.order.source
        values = {"axis": self._names[given.order.axis], "function": spelt(given.order.job), "what": what}
        return Problem(errors.JOB_OF_PROGRAM, values, Place(source.program, source.line))
