"""The cycle once more: the same controller, on what was recorded, compared word by word with what it gave out then.

    recording ─▶ inputs ─▶ controller ─▶ outputs ─┬─ equal: next cycle
                                          recorded ┘   not: where they part (cycle, element, recorded and replayed value)

Nothing else runs: no drives, no PLC, no preparation; the time is the recorded one.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt

from runtime.cnc.motion_queue import PROGRAMS, MotionQueue
from runtime.cnc.preparation_link import PreparationLink
from runtime.cnc.queue_limits import SETS
from runtime.cnc.queue_texts import TEXTS
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import CATALOGUE
from runtime.diagnostics.catalogue import recorder as errors
from runtime.diagnostics.errors import Place, Problem
from runtime.diagnostics.events import EventRing
from runtime.drives import BusFigures, DriveEvent, DriveImage
from runtime.hli.layout import Platform
from runtime.hli.memory import HliMemory
from runtime.recorder.areas import WHOLE_WORDS, Area, apply_changes
from runtime.recorder.border import outside_of
from runtime.recorder.elements import Element
from runtime.recorder.file import RecordingError, RecordingFile
from runtime.recorder.header import described_machine, image_words, processor, source_hash
from runtime.recorder.keyframes import put_records, ring_slots
from runtime.recorder.layouts import AREAS, elements_of_area, layouts
from runtime.recorder.machine_areas import hli_area, link_area
from runtime.recorder.record import GAP, KEYFRAME, CycleRecord, Section, value_of
from runtime.recorder.state import restore
from runtime.scheduler.controller import Controller
from runtime.scheduler.replay_source import ReplaySource
from runtime.scheduler.retained import RetainedAlarm
from runtime.scheduler.trace import SampleRecorder, TraceWriter

Words = npt.NDArray[np.int64]
_NOTHING: Words = np.zeros(0, dtype=np.int64)
# plain numbers: an enum is slow to compare. Changes of a section belong to an area, by its place in AREAS.
_TAKEN = {int(Section.HLI): 0, int(Section.LINK): 1, int(Section.IMAGE): 2, int(Section.FIGURES): 3}
_FIGURES, _GIVEN_OUT = int(Section.FIGURES), int(Section.BEFORE_PLC)
_EVENTS_TAKEN = 64  # cycles, so that the ring of events never fills


@dataclass(frozen=True, slots=True)
class Difference:
    """Where a replay parts from its recording; `element` is the first one that differs."""

    cycle: int
    time: float  # s since the start of the runtime
    area: str
    element: str
    recorded: str
    replayed: str

    def __str__(self) -> str:
        return (
            f"parts in cycle {self.cycle} ({self.time:.3f} s): {self.area}, {self.element}: "
            f"recorded {self.recorded}, replayed {self.replayed}"
        )


@dataclass(frozen=True, slots=True)
class ReplayResult:
    """`cycles` were the same; `seconds` of the machine; `gaps`: how often something was missing, and a keyframe went on."""

    cycles: int
    seconds: float
    difference: Difference | None
    gaps: int = 0

    @property
    def same(self) -> bool:
        return self.difference is None


class _Drives:
    """The drives of a replay: their feedback is what was recorded."""

    def __init__(self, replay: Replay, image: DriveImage) -> None:
        self.image = image
        self._replay = replay

    def start(self) -> None:
        """There are none."""

    def read(self) -> None:
        self._replay.take_in()

    def write(self) -> None:
        self._replay.give_out()

    def tell_again(self) -> None:
        """What is still lost is told by the recording, in the next cycle."""

    def stop(self) -> None:
        """There are none."""


class _Plc:
    """The PLC of a replay: what it did is in the recording."""

    def __init__(self, replay: Replay, platform: Platform, *, process: bool) -> None:
        self._replay, self._platform, self._process = replay, platform, process

    def wake(self, time: float) -> None:
        self._replay.plc_woken()

    def restart(self) -> None:
        if self._process:
            self._platform.plc_restart_request_r += 1


class Replay:
    """`run` does it; `machine` and the description in the file may differ where a change is to be tried."""

    def __init__(
        self, file: RecordingFile, machine: Machine | None = None, *, trace: Path | None = None, samples: bool = False
    ) -> None:
        self.file = file
        header = file.header
        if machine is None:
            with TemporaryDirectory() as folder:
                machine = described_machine(header, Path(folder))
        self.machine = machine
        self.image = DriveImage(len(machine.axes))
        self._check(header)
        self._header = header
        self._writer = TraceWriter(trace) if trace else None
        self.samples = SampleRecorder(machine.channels[0].axes)
        self._sampled = samples or trace is not None
        self._wall_ns = 0
        self.difference: Difference | None = None
        self._record: CycleRecord | None = None
        self._woken = False
        self._cut_off = False
        self._read = -1  # records of the queue that were read in the recording
        self._scratch: Words = np.zeros(1 << 17, dtype=np.int64)

    def _check(self, header: Mapping[str, Any]) -> None:
        for what, expected in layouts(self.image).items():
            found = header["layouts"].get(what, "none")
            if found != expected:
                values = {"what": what, "found": found[:12], "expected": expected[:12], "version": header["version"]}
                raise RecordingError(errors.OTHER_LAYOUT, Place(str(self.file.path)), **values)

    @property
    def warnings(self) -> list[Problem]:
        """What makes it likely that they part."""
        found = []
        header, place = self.file.header, Place(str(self.file.path))
        if (sources := source_hash()) != header["sources"]:
            values = {"found": header["sources"], "expected": sources, "version": header["version"]}
            found.append(Problem(errors.OTHER_SOURCES, values, place))
        if processor() != header["processor"]:
            values = {"found": header["processor"], "expected": processor()}
            found.append(Problem(errors.OTHER_PROCESSOR, values, place))
        return found

    # ------------------------------------------------------------------ building

    def _build(self) -> None:
        """A machine as it was in front of the first cycle of its process."""
        machine, header = self.machine, self._header
        n_axes = len(machine.channels[0].axes)
        self.image = DriveImage(len(machine.axes))
        self.image.words[:] = image_words(header)
        self.memory = HliMemory.private()
        self.link = PreparationLink(n_axes)
        self.queue = MotionQueue(n_axes)
        self._source.attach(self.queue)
        self.events = EventRing()
        plc = None
        if header["plc"] != "none":
            plc = _Plc(self, self.memory.hli.platform, process=header["plc"] == "process")
        self.controller = Controller(
            machine,
            _Drives(self, self.image),
            self.memory,
            self.events,
            self.queue,
            self.link,
            plc,
            wall_clock=lambda: self._wall_ns,
            real_drives=header["real_drives"],
        )
        self.controller.channel.trace_blocks = self._writer is not None
        self._figures = np.zeros(4)
        self.hli = hli_area(machine, HliMemory.private().hli, self.memory.hli)
        self.link_area = link_area(PreparationLink(n_axes), self.link)
        words, figures = self.image.words, self._figures.view(np.int64)
        self.drives_area, self.figures_area = Area(words, words, WHOLE_WORDS), Area(figures, figures, WHOLE_WORDS)
        self.areas = (self.hli, self.link_area, self.drives_area, self.figures_area)

    # ------------------------------------------------------------------ running

    def run(self, *, stop_at: int | None = None) -> ReplayResult:
        """From the first keyframe to the end of the recording, to the cycle `stop_at`, or to where they part."""
        cycles, gaps = 0, 0
        begin = end = 0.0
        self._source = ReplaySource(self.file.records())
        running = False
        for record in self._source.records():
            if record.marks & GAP and not record.marks & KEYFRAME:
                running = False
            if not running:
                if not record.marks & KEYFRAME:
                    continue
                if not self._begin(record):
                    continue
                gaps += cycles > 0
                running = True
                begin = record.time if cycles == 0 else begin
            self._cycle(record)
            if self._cut_off:
                break
            if self.difference is not None:
                break
            cycles, end = cycles + 1, record.time
            if stop_at is not None and record.cycle >= stop_at:
                break
        if cycles == 0 and self.difference is None:
            raise RecordingError(errors.NO_BEGINNING, Place(str(self.file.path)))
        result = ReplayResult(cycles, end - begin + self.machine.cycle.period, self.difference, gaps)
        if self._writer is not None:
            self._writer.close(self.samples, self._summary(result))
        return result

    def _begin(self, record: CycleRecord) -> bool:
        """The state in front of a record with a keyframe; FALSE if the recording ends before it is whole."""
        beginning = self._source.begin(record)
        if beginning is None:
            return False
        self._build()
        for number, first, words in beginning.areas:
            area = self.areas[number]
            area.own[first : first + len(words)] = words
            area.agreed[first : first + len(words)] = words
        counters = record.section(Section.KEYFRAME_QUEUE)
        assert counters is not None
        self.queue.counters[:] = counters
        self._source.filled = int(counters[1])
        self._read = -1
        self._take_figures()
        storage = self.controller.channel.backward.storage
        if beginning.state:
            outside = outside_of(self.memory, self.link, self.queue, self.image, storage)
            restore(self.controller, beginning.state, outside)
        for ring, first, words in beginning.rings:
            put_records(words, first, *ring_slots(storage, ring))
        return True

    def _cycle(self, record: CycleRecord) -> None:
        self._record, self._woken = record, False
        self._cut_off = False
        calls = record.section(Section.CALLS)
        if calls is not None:
            for name, wall_ns, values in value_of(calls):
                self._wall_ns = wall_ns
                self._call(name, values)
        self._wall_ns = record.wall_ns
        self.controller.cycle(record.time)
        if not self._woken and record.section(Section.BEFORE_PLC) is not None and not self._cut_off:
            self._part("PLC", "woken", "yes", "no")
        if self._sampled or record.cycle % _EVENTS_TAKEN == 0:
            self._trace(record)

    def _trace(self, record: CycleRecord) -> None:
        taken = self.events.take()
        if not self._sampled:
            return
        if self._writer is not None:
            for event in taken:
                self._writer.event(event)
        channel = self.controller.channel
        if channel.active:
            path = channel.interpolator
            rapid = not 0.0 < channel.programmed_feed < float("inf")
            self.samples.add(record.time, path.set_point, path.path_velocity, max(path.line, 0), rapid)

    def _summary(self, result: ReplayResult) -> dict[str, object]:
        names = self.machine.channels[0].axes
        targets = self.image.target_position
        return {
            "time_s": round(result.seconds, 9),
            "path_length_mm": round(self.controller.channel.path_length, 9),
            "positions": {name: float(targets[self.machine.axis_index(name)]) for name in names},
            "cycles": result.cycles,
            "same": result.same,
            "parts": str(result.difference) if result.difference else "",
        }

    def _call(self, name: str, values: Mapping[str, Any]) -> None:
        """What the process did with the controller between two cycles."""
        controller = self.controller
        if name == "alarm":
            entry = CATALOGUE[values["id"]]
            controller.alarm(Problem(entry, values["values"], Place(*values["place"])), values["axis"])
        elif name == "restore":
            controller.alarms.restore(RetainedAlarm(**alarm) for alarm in values["alarms"])
        elif name == "references":
            controller.references.restore(values["references"])
        elif name == "stop":
            controller.stop()

    # ------------------------------------------------------------------ the seam

    def take_in(self) -> None:
        """Behind the read of the drives: apply what had come."""
        record, image = self._record, self.image
        assert record is not None
        image.events.clear()
        for kind, words in record.sections:
            if kind >= _GIVEN_OUT:
                break
            if kind in _TAKEN:
                area = self.areas[_TAKEN[kind]]
                apply_changes(words, area.own, area.agreed)
                if kind == _FIGURES:
                    self._take_figures()
            elif kind == Section.BUSES:
                image.buses = [_bus(*told) for told in value_of(words)]
                image.buses_changed = True
            elif kind == Section.DRIVE_EVENTS:
                image.events.extend(DriveEvent(*event) for event in value_of(words))
            elif Section.QUEUE <= kind <= Section.QUEUE_LIMITS:
                self._fill_queue(kind, words)

    def _take_figures(self) -> None:
        image = self.image
        image.bus_load = float(self._figures[0])
        image.emcy_count, image.frames_sent, image.frames_received = map(int, self._figures[1:])

    def _fill_queue(self, kind: int, words: Words) -> None:
        queue = self.queue
        if kind == Section.QUEUE:
            counters = queue.counters
            if not self._source.fill_to(int(words[0])):
                self._cut_off = True
                return
            counters[0], counters[2], counters[3] = words[0], words[1], words[4]
            queue.texts.counters[0], queue.limits.counters[0] = words[2], words[3]
            return
        slots = {
            Section.QUEUE_NAMES: queue.names.view(np.int64).reshape(PROGRAMS, -1),
            Section.QUEUE_TEXTS: queue.texts.slots.view(np.int64).reshape(TEXTS, -1),
            Section.QUEUE_LIMITS: queue.limits.sets.view(np.int64).reshape(SETS, -1),
        }[Section(kind)]
        rows = words[1:].reshape(-1, slots.shape[1])
        slots[np.arange(int(words[0]), int(words[0]) + len(rows)) % len(slots)] = rows

    def plc_woken(self) -> None:
        """Compare what the PLC gets to see, apply what it did."""
        self._woken = True
        self._compare(0, self.hli, Section.BEFORE_PLC)
        assert self._record is not None
        done = self._record.section(Section.AFTER_PLC)
        if done is not None:
            apply_changes(done, self.hli.own, self.hli.agreed)

    def give_out(self) -> None:
        """In front of the write to the drives: compare everything that was given out."""
        self._compare(2, self.drives_area, Section.IMAGE_OUT)
        self._compare(0, self.hli, Section.HLI_OUT)
        self._compare(1, self.link_area, Section.LINK_OUT)
        assert self._record is not None
        read = self._record.section(Section.QUEUE_READ)
        here = int(self.queue.counters[1])
        if read is not None:
            self._read = int(read[0])
        if here != self._read and self._read >= 0 and not self._cut_off:
            self._part("motion queue", "records read", str(self._read), str(here))

    def _compare(self, number: int, area: Area, kind: Section) -> None:
        assert self._record is not None
        recorded = self._record.section(kind)
        end = area.give_out(kind, self._scratch, 0)
        replayed = self._scratch[1:end]
        expected = _NOTHING if recorded is None else recorded
        if replayed.tobytes() == expected.tobytes() or self.difference is not None or self._cut_off:
            return
        before, now = _values(expected), _values(replayed)
        for word in sorted(before.keys() | now.keys()):
            # whoever has no new value of a word has the old one; the replay's is at hand
            old = int(area.own[word])
            was, is_now = before.get(word), now.get(word, old)
            if was is not None and was != is_now:
                self._part_at(number, word, was, is_now)
                return
            if was is None:
                self._part_at(number, word, None, is_now)
                return

    def _part_at(self, area: int, word: int, recorded: int | None, replayed: int) -> None:
        elements = [e for e in elements_of_area(area, self.image) if e.offset < 8 * word + 8]
        for element in elements:
            if element.offset + element.size * element.count <= 8 * word:
                continue
            then = "unchanged" if recorded is None else _told(element, word, recorded)
            now = _told(element, word, replayed)
            if then != now:
                name = element.name
                if element.count > 1:
                    name += f"[{max(0, 8 * word - element.offset) // element.size}]"
                self._part(AREAS[area], name, then, now)
                return
        self._part(AREAS[area], f"word {word}", str(recorded), str(replayed))

    def _part(self, area: str, element: str, recorded: str, replayed: str) -> None:
        if self.difference is None and self._record is not None:
            record = self._record
            self.difference = Difference(record.cycle, record.time, area, element, recorded, replayed)


def _bus(channel: str, load: float, gone: bool) -> BusFigures:
    figures = BusFigures(channel)
    figures.load, figures.gone = load, gone
    return figures


def _values(changes: Words) -> dict[int, int]:
    """Word -> new value of words of changes."""
    found: dict[int, int] = {}
    at = 0
    while at < len(changes):
        word, count = int(changes[at]) >> 32, int(changes[at]) & 0xFFFFFFFF
        found |= {word + k: int(changes[at + 1 + k]) for k in range(count)}
        at += 1 + count
    return found


def _told(element: Element, word: int, value: int) -> str:
    """What an element has of a word, as a number; text as letters."""
    data = struct.pack("<q", value)
    begin = max(element.offset - 8 * word, 0)
    end = min(element.offset + element.size * element.count - 8 * word, 8)
    part = data[begin:end]
    if element.size == 1 and element.count > 1:
        return repr(part.rstrip(b"\0").decode("latin-1")) if element.kind in "cSB" else part.hex(" ")
    numbers = np.frombuffer(part[: len(part) // element.size * element.size], dtype=element.kind)
    return ", ".join(repr(number.item()) for number in numbers)
