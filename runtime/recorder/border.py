"""The border of the cycle: everything that it takes in and gives out passes here, and is recorded.

    cycle(time):   drives.read ─ take in ─▶ … ─ give out ─ PLC woken (takes in what it did) ─▶ … ─ give out ─ drives.write

The controller has memories of its own (HLI, preparation link, counters of the motion queue). What others have written comes into
them at `read`, and what the controller has written goes to the others before the PLC is woken and before `write`. In between the
outside stands still for the cycle, so that a recording knows all of it, and a replay does the same bit by bit.

The two protocols that the controller knows are the seam: `BorderDrives` stands before the drives, `BorderPlc` before the PLC.
Nothing here waits, and nothing grows.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
import numpy.typing as npt

from runtime.cnc.interpolator.path_storage import PathStorage
from runtime.cnc.motion_queue import MotionQueue, RecordKind
from runtime.cnc.preparation_link import PreparationLink
from runtime.cnc.queue_limits import SETS
from runtime.cnc.queue_texts import TEXTS
from runtime.config.machine import Machine
from runtime.drives import DriveImage, DriveSystem
from runtime.hli.memory import HliMemory
from runtime.kernels import kernel, warms
from runtime.recorder.areas import WHOLE_WORDS, Area, words_of
from runtime.recorder.keyframes import RECORD_WORDS, Keyframes, stage_records
from runtime.recorder.machine_areas import hli_area, link_area
from runtime.recorder.record import GAP, HEAD, KEYFRAME, Section, text_words
from runtime.recorder.ring import RecorderRing
from runtime.recorder.state import Outside, StateError

Words = npt.NDArray[np.int64]
Numbers = npt.NDArray[np.int64]
STAGE = 1 << 17  # words of the longest record: the first keyframe has some 46000, a cycle some 30
RECORDS_PER_CYCLE = 256  # of the motion queue
AGAIN_PER_CYCLE = 64  # behind a keyframe, since all of the queue comes again
# plain numbers: an enum as the argument of a kernel is slow
_FIGURES, _IMAGE, _HLI, _LINK = (int(kind) for kind in (Section.FIGURES, Section.IMAGE, Section.HLI, Section.LINK))
_BEFORE_PLC, _AFTER_PLC = int(Section.BEFORE_PLC), int(Section.AFTER_PLC)
_HLI_OUT, _LINK_OUT, _IMAGE_OUT = int(Section.HLI_OUT), int(Section.LINK_OUT), int(Section.IMAGE_OUT)
_QUEUE_READ = int(Section.QUEUE_READ) << 32 | 1  # with its length
_AHEAD = int(RecordKind.FUNCTION_AHEAD)


class Plc(Protocol):
    """A partner of the scheduler (`runtime.scheduler.plc_link.PlcPartner`)."""

    def wake(self, time: float) -> None: ...
    def restart(self) -> None: ...


class Memories:
    """What the cycle works on: copies of its own of the memories that it shares with others."""

    def __init__(self, hli: HliMemory, link: PreparationLink, queue: MotionQueue) -> None:
        self.shared_hli, self.shared_link, self.shared_queue = hli, link, queue
        self.hli = HliMemory.private()
        _copy(hli.hli, self.hli.hli)
        self.link = PreparationLink(queue.n_axes)
        self.queue = queue.consumer()


def _copy(source: object, target: object) -> None:
    np.frombuffer(target, dtype=np.uint8)[:] = np.frombuffer(source, dtype=np.uint8)  # type: ignore[call-overload]


@kernel
def _count_ahead(kinds: Numbers, first: int, end: int, kind: int) -> int:
    found = 0
    for index in range(first, end):
        if kinds[index % kinds.shape[0]] == kind:
            found += 1
    return found


@warms("border of the cycle")
def _warm() -> None:
    # a column of several rows: that of one row counts as contiguous, which those of the queue are not
    _count_ahead(np.zeros((2, 2), dtype=np.int64)[:, 0], 0, 1, 7)


class Border:
    """Of one machine; `ring` takes the records. Made with the memories that the controller is made with, before it is."""

    def __init__(
        self, machine: Machine, memories: Memories, image: DriveImage, ring: RecorderRing, wall_clock: Callable[[], int]
    ) -> None:
        self._machine, self._memories, self._image, self._ring = machine, memories, image, ring
        self._wall_clock = wall_clock
        self.out: Words = np.zeros(STAGE, dtype=np.int64)
        self._time = self.out[2:3].view(np.float64)
        self._at = HEAD
        self._calls: list[object] = []
        self._gap = False
        self.wall_ns = 0
        self.may_take: Callable[[], bool] = lambda: True  # a keyframe, in this cycle
        self._figures = np.zeros(4)
        self.cycle = 0
        own = memories.queue
        self._records: Words = own.records.view(np.int64).reshape(own.capacity, RECORD_WORDS)
        self._polynomials: Words = own.polynomials.view(np.int64).reshape(own.capacity, -1)
        self._kinds: Numbers = own.records["kind"]
        self._names: Words = own.names.view(np.int64).reshape(len(own.names), -1)
        self._texts: Words = own.texts.slots.view(np.int64).reshape(TEXTS, -1)
        self._sets: Words = own.limits.sets.view(np.int64).reshape(SETS, -1)
        self._seen = [0, 0, 0]  # names, texts, sets that are recorded
        self._recorded = 0  # records of the queue
        self._at_once = RECORDS_PER_CYCLE
        self._read = -1  # the record that the cycle has told last
        self._own_counters, self._shared_counters = own.counters, memories.shared_queue.counters
        self.keyframe_wanted = True

    def settle(self, root: object = None, storage: PathStorage | None = None) -> None:
        """The controller is built and has described the machine: everybody sees it, and from here on changes are told apart.

        `root`: whose state stands in keyframes, without it only the first cycle has one; `storage`: its way that is kept.
        """
        memories = self._memories
        self.hli = hli_area(self._machine, memories.shared_hli.hli, memories.hli.hli)
        _copy(memories.hli.hli, memories.shared_hli.hli)
        self.link = link_area(memories.shared_link, memories.link)
        words, figures = self._image.words, self._figures.view(np.int64)
        self.image, self.figures = Area(words, words, WHOLE_WORDS), Area(figures, figures, WHOLE_WORDS)
        self.areas = (self.hli, self.link, self.image, self.figures)
        outside = outside_of(memories.hli, memories.link, memories.queue, self._image, storage)
        self._keyframes = Keyframes(self.areas, root, outside, storage)
        self._no_more = root is None

    @property
    def busy(self) -> bool:
        """A keyframe is wanted, or not yet told to its end."""
        return self.keyframe_wanted or self._keyframes.telling

    # ------------------------------------------------------------------ the cycle

    def begin(self, time: float) -> None:
        """A cycle begins at `time` (s since the start of the runtime)."""
        wall_ns = self.wall_ns = self._wall_clock()
        self.cycle += 1
        out = self.out
        out[1] = self.cycle
        self._time[0] = time
        out[3] = wall_ns
        out[4] = 0
        self._at = HEAD
        if self._ring.take_wish():
            self.keyframe_wanted = not self._no_more
        if self._keyframes.telling:
            if self._at_once == RECORDS_PER_CYCLE:  # the queue is told: one thing after the other
                kind, words = self._keyframes.tell()
                self._section(kind, words)
                if kind == Section.KEYFRAME_END and not words[0]:
                    self.keyframe_wanted = True  # given up
        elif self.keyframe_wanted:
            self._keyframe()
        if self._calls:
            calls, self._calls = self._calls, []
            self._section(Section.CALLS, text_words(calls))

    def call(self, name: str, **values: object) -> None:
        """The process does something with the controller between two cycles: told before it does."""
        self.wall_ns = self._wall_clock()
        self._calls.append([name, self.wall_ns, values])

    def take_in(self) -> None:
        """Behind the read of the drives: what has come from everywhere."""
        image, figures, out = self._image, self._figures, self.out
        figures[0], figures[1] = image.bus_load, image.emcy_count
        figures[2], figures[3] = image.frames_sent, image.frames_received
        if image.buses_changed or out[4] & KEYFRAME:
            self._section(Section.BUSES, text_words([[bus.channel, bus.load, bus.gone] for bus in image.buses]))
        if image.events:
            self._section(Section.DRIVE_EVENTS, text_words([list(event) for event in image.events]))
        at = self.figures.take_in(_FIGURES, out, self._at)
        at = self.image.take_in(_IMAGE, out, at)
        at = self.hli.take_in(_HLI, out, at)
        self._at = self.link.take_in(_LINK, out, at)
        self._take_queue()

    def _take_queue(self) -> None:
        """How far the queue is filled: the link first, so that whatever it tells of is in the queue."""
        own, counters, shared = self._memories.queue, self._own_counters, self._shared_counters
        written, before = int(shared[0]), int(counters[0])
        if written != before:
            counters[3] += _count_ahead(self._kinds, before, written, _AHEAD)
            counters[0] = written
        put = [int(shared[2]), int(own.texts.counters[0]), int(own.limits.counters[0])]
        if written != before or put != self._seen:
            counters[2] = put[0]
            self._section(Section.QUEUE, np.array([written, *put, counters[3]], dtype=np.int64))
            seen = self._seen
            self._slots(Section.QUEUE_NAMES, self._names, seen[0], put[0])
            self._slots(Section.QUEUE_TEXTS, self._texts, seen[1], put[1])
            self._slots(Section.QUEUE_LIMITS, self._sets, seen[2], put[2])
            self._seen = put
        first = self._recorded
        if first < written:
            count = min(written - first, self._at_once)
            at = self._at
            if at + 2 + count * (RECORD_WORDS + self._polynomials.shape[1]) > len(self.out):
                return  # with a keyframe; in the next cycle then
            self.out[at + 1] = first
            end = stage_records(self._records, self._polynomials, self._kinds, first, count, self.out, at + 2)
            self.out[at] = int(Section.QUEUE_RECORDS) << 32 | (end - at - 1)
            self._at, self._recorded = end, first + count
        if self._recorded >= written:
            self._at_once = RECORDS_PER_CYCLE

    def _slots(self, kind: Section, slots: Words, first: int, end: int) -> None:
        """What was put into a small ring: slots first … end - 1, the newest of them if there are more than it has."""
        first = max(first, end - len(slots))
        if first < end:
            rows = slots[np.arange(first, end) % len(slots)]
            self._section(kind, np.concatenate([np.array([first], dtype=np.int64), rows.ravel()]))

    def before_plc(self) -> None:
        """The PLC is woken: it sees what the cycle has written so far."""
        self._at = self.hli.give_out(_BEFORE_PLC, self.out, self._at)

    def after_plc(self) -> None:
        """A PLC in this process has done its cycle."""
        self._at = self.hli.take_in(_AFTER_PLC, self.out, self._at)

    def give_out(self) -> None:
        """In front of the write to the drives: what the cycle has done goes to everybody, and into the ring."""
        out = self.out
        at = self.hli.give_out(_HLI_OUT, out, self._at)
        at = self.link.give_out(_LINK_OUT, out, at)
        at = self.image.give_out(_IMAGE_OUT, out, at)
        read = int(self._own_counters[1])
        if read != self._read or self._recorded < read:
            self._read = read
            self._shared_counters[1] = min(read, self._recorded)  # nothing is written over that is not recorded
            if at + 2 <= len(out):
                out[at], out[at + 1] = _QUEUE_READ, read
            at += 2
        if at > len(out):  # cannot be replayed: as if it was dropped
            self._gap = True
            return
        out[0] = at
        if self._gap:
            out[4] |= GAP
        self._gap = not self._ring.put(out[:at])

    def _section(self, kind: Section, words: Words) -> None:
        at, count = self._at, len(words)
        end = at + 1 + count
        if end <= len(self.out):
            self.out[at] = int(kind) << 32 | count
            self.out[at + 1 : end] = words
        self._at = end

    # ------------------------------------------------------------------ keyframes

    def _keyframe(self) -> None:
        """Take one, if it is time: then a replay can begin in front of this cycle."""
        if self.cycle == 1:  # everything is as it was built
            for piece in self._keyframes.first():
                self._section(*piece)
        else:
            try:
                if not self._keyframes.prepare() or not self._may_take_keyframe() or not self._keyframes.take():
                    return
            except StateError:
                self.keyframe_wanted, self._no_more = False, True
                self._ring.refuse_keyframes()
                return
        self.keyframe_wanted = False
        self.out[4] |= KEYFRAME
        counters = self._memories.queue.counters
        self._section(Section.KEYFRAME_QUEUE, counters)
        self._recorded = int(counters[1])  # what is in the queue follows, some records in each cycle
        self._at_once = AGAIN_PER_CYCLE
        self._seen = [0, 0, 0]
        self._read = -1

    def _may_take_keyframe(self) -> bool:
        """Calls of this cycle are in the state already; records of the queue that are not recorded yet would be missing."""
        return not self._calls and self._recorded >= int(self._own_counters[0]) and self.may_take()


def outside_of(
    hli: HliMemory, link: PreparationLink, queue: MotionQueue, image: DriveImage, storage: PathStorage | None
) -> Outside:
    """What a keyframe has in its areas, or follows it: no state of objects."""
    rings = [queue.records, queue.polynomials, queue.counters, queue.names, queue.texts.slots, queue.limits.sets]
    queues = [queue]
    if storage is not None:
        again = storage.queue
        rings += [storage.kept, storage.tables, again.records, again.polynomials]
        queues.append(again)
    return Outside(words_of(hli.hli), words_of(link.buffer), image.words, *rings, queues=queues)


class BorderDrives:
    """The drives as the controller knows them."""

    def __init__(self, drives: DriveSystem, border: Border) -> None:
        self.image = drives.image
        self._drives, self._border = drives, border

    def start(self) -> None:
        self._drives.start()

    def read(self) -> None:
        self._drives.read()
        self._border.take_in()

    def write(self) -> None:
        self._border.give_out()
        self._drives.write()

    def tell_again(self) -> None:
        self._drives.tell_again()

    def stop(self) -> None:
        self._drives.stop()


class BorderPlc:
    """The PLC as the controller knows it. `inline`: it runs in this process, and has done its cycle when `wake` returns."""

    def __init__(self, partner: Plc, border: Border, *, inline: bool) -> None:
        self._partner, self._border, self._inline = partner, border, inline

    def wake(self, time: float) -> None:
        self._border.before_plc()
        self._partner.wake(time)
        if self._inline:
            self._border.after_plc()

    def restart(self) -> None:
        self._partner.restart()
