"""The motion queue: the one way from the preparation of a channel to its interpolator.

A ring of fixed records, one producer and one consumer, in shared memory or in this process only:

    absolute index    read ≤ i < written                slot of i: i % capacity
                      ┌────────────────────────────────────────────┐
      slots      ···  │ LINE  LINE  FUNCTION  GATE  LINE  BLOCK_END │  ···  free: capacity - (written - read)
                      └────────────────────────────────────────────┘
                      ▲ consumer frees here                        ▲ producer appends here

Indices only grow. A counter is stored after the records it covers (x86-64 keeps the order of stores), so neither side
ever sees a half-written record. The producer asks for `free` and never waits here; `append` takes what fits and says
how much.

What the axes may do on an element is the set of limits with the number `limits` (`queue_limits`): per axis velocity,
acceleration and jerk, separately for speeding up and slowing down. `v_corner` is what the corner before the element
allows by itself: jumps of velocity and acceleration, exact stops, the feed at the end of the block before. What the
path velocity may be on the element follows from both and the geometry. `v_limit`, `a_limit`, `j_limit` and `v_entry`
are the same in one box per element. `a_entry` is what the path acceleration may jump by at that corner. `a_hold` and
`j_hold` are what feed hold brakes with if it has a ramp of its own (P-CHAN-00097); 0: as everything else.

What the program itself limits along the path (`path_v`, `path_a`, `path_d`, `path_j`: #VECTOR LIMIT, programmed override
of rapid moves; 0: nothing) holds beside it; the box has it already. `unwatched`: what does not limit the path on this
element although the axes would (G115, G116): bits of `dynamic_settings.LookAhead`.
Where path and spindle move together (G33, G63), `sense` of an element is how (`blocks.SpindleRole`), `spindle` which one, `value`
by how many degrees it turns per mm, and `spindle_angle` how far it has turned in its section where the element begins.
The coefficients of a polynomial lie in a second array, in the slot of its record. It is written for polynomials only, so
that lines cost nothing more.

Units: mm or degrees, per second; angles of arcs in radians.
"""

from __future__ import annotations

import mmap
from copy import copy
from enum import IntEnum, unique
from typing import Any

import numpy as np
import numpy.typing as npt

from runtime.cnc.geometry.polynomial_table import ROWS, WIDTH
from runtime.cnc.queue_limits import QueueLimits, limits_bytes
from runtime.cnc.queue_texts import TEXTS_BYTES, QueueTexts
from runtime.diagnostics.memory import SharedMemory, open_shared

CAPACITY = 16384  # some 6 MB; 16 m of path in segments of 1 mm, 1.6 m in segments of 0.1 mm
MAX_AXES = 8  # config.machine: axes of a channel
PROGRAMS = 64  # names known at the same time
PROGRAM_NAME = 248


class RecordKind(IntEnum):
    """What a record is."""

    LINE = 0
    ARC = 1
    POLYNOMIAL = 2  # its coefficients lie in `MotionQueue.polynomials`. Up to here: motion, with length and limits
    FUNCTION = 3  # technology function, put out when the path arrives here
    GATE = 4  # the path stops here unless the gate has been opened
    BLOCK_END = 5  # the end of an NC block: a gate in single block
    ACTION = 6  # done by the cycle when the path arrives here
    FUNCTION_AHEAD = 7  # technology function, put out some way or time before the path arrives here


class GateReason(IntEnum):
    """Who has to open a gate."""

    WAIT = 0  # acknowledgement of technology functions
    DWELL = 1  # `seconds` at standstill
    PROGRAMMED_STOP = 2  # M00
    OPTIONAL_STOP = 3  # M01
    PROGRAM_END = 4  # M02, M30
    FLUSH = 5  # #FLUSH: the path stops here for a moment
    FLUSH_WAIT = 6  # #FLUSH WAIT: everything before it has been done and taken
    MESSAGE = 7  # a message has to be taken
    USER_ERROR = 8  # #ERROR: the path goes no further
    EXACT_STOP = 9  # every axis within its window of standstill
    OPTIONAL_SECTION = 11  # the section behind it may be left out
    STOP_MARK = 12  # #STOP REVERSIBLE
    STEP = 13  # the end of an NC block without motion: single step stops
    AXIS_JOBS = 10  # jobs of axes outside the path are done
    MANUAL = 20  # G200: moved by hand until continue
    MANUAL_END = 21  # G202: the motion by hand has ended
    HOMING = 22  # G74: the axes have their reference
    TAKE_OVER = 23  # the path goes on from where the axes are
    SET_POSITION = 24  # an axis counts anew where it stands
    INDEPENDENT = 25  # an own motion of an axis begins
    INDEPENDENT_WAIT = 26  # own motions have come to their targets
    COUPLING = 27  # axes follow others from here on, or no longer
    FILTER = (
        28  # the filter of the set-points is changed (#FILTER); what was driven with another one is not driven again
    )
    MEASURE = 29  # a probe is got ready
    SEARCH_BEGIN = 30  # block search: see blocks.SearchStep
    SEARCH_END = 31
    SEARCH_RETURN = 32
    SEARCH_GO_ON = 33
    THREAD = 34  # G33: the spindle is at speed and at its angle; what lies behind is not driven backward
    TAPPING = 35  # G63, G331, G332: the spindle stands, and follows the path from here on
    SPINDLE_FREE = 36  # the end of both
    MEASURE_END = 37  # what was measured comes


@unique
class ActionKind(IntEnum):
    """What an action does."""

    MESSAGE = 0
    TIMER = 1
    EXTERNAL = 2  # an external variable gets its value
    WARNING = 3  # #ERROR without consequences
    SPINDLE = 4  # a setting of a spindle
    TOOL_LIFE = 5
    AXIS_JOB = 6  # a PLCopen job for an axis outside the path
    MANUAL_ON = 7  # G201
    MANUAL_PARAMETER = 8
    OPTIONAL_ON = 9  # #OPTIONAL EXECUTION: a section that may be left out begins
    OPTIONAL_OFF = 10
    CLEAR_STORAGE = 11  # #BACKWARD STORAGE CLEAR
    DISTANCE_BEGIN = 12  # #DIST TO GO
    DISTANCE_END = 13  # `end`: what every axis travels in the section
    SEARCH_PLACE = 14  # the program goes on here after a block search
    NOTHING = 15  # was something that is left out
    ACTUAL_LIMIT = 16  # POS_LIMIT with ERROR_LR or WARNING
    FEED_FORWARD = 17  # G135…G137: `end` are the shares of the axes
    SUPPRESSION = 18  # of feed hold and override
    CUTTING_SPEED = 19  # G96


RECORD = np.dtype(
    [
        ("kind", "i8"),  # RecordKind
        ("line", "i8"),  # source line
        ("n", "i8"),  # block number, -1: none
        ("program", "i8"),  # index into the table of names
        # LINE, ARC, POLYNOMIAL
        ("start", "f8", (MAX_AXES,)),
        ("end", "f8", (MAX_AXES,)),
        ("length", "f8"),  # path length
        ("feed", "f8"),  # programmed path velocity per s, inf for rapid
        ("rapid", "i8"),
        ("v_limit", "f8"),  # path velocity, acceleration and jerk at which no axis exceeds its limits on this element
        ("a_limit", "f8"),
        ("j_limit", "f8"),
        ("a_hold", "f8"),  # what feed hold brakes with, 0: with the limits of the element
        ("j_hold", "f8"),
        ("v_entry", "f8"),  # greatest path velocity over the corner between the element before and this one
        (
            "a_entry",
            "f8",
        ),  # braking with no more than that the path may accelerate with as much from there on; 0: a goes on
        ("block_end", "i8"),  # 1: an NC block ends with this element (segment of a polyline)
        # ARC
        ("axis0", "i8"),
        ("axis1", "i8"),
        ("centre0", "f8"),
        ("centre1", "f8"),
        ("angle", "f8"),  # signed, radians
        # FUNCTION, FUNCTION_AHEAD
        ("function", "i8"),  # runtime.cnc.blocks.Technology
        ("number", "i8"),
        ("synch", "i8"),
        ("spindle", "i8"),
        ("value", "f8"),
        # GATE
        ("reason", "i8"),  # GateReason
        ("seconds", "f8"),
        # ACTION, and gates of messages and errors; what the other fields mean for them stands in queue_record
        ("action", "i8"),  # ActionKind
        ("text", "i8"),  # index into the texts, -1: none
        ("offset", "i8"),
        ("size", "i8"),
        # FUNCTION, FUNCTION_AHEAD
        ("area", "i8"),  # index of the axis on whose interface it is put out, -1: of the channel
        ("lead", "f8"),  # how far ahead, mm or s
        ("spindle_angle", "f8"),  # degrees, of M19
        ("sense", "i8"),  # of M19: 3, 4, or 0 for the shorter way
        ("plc_spindle", "i8"),  # logical axis number of a spindle that the PLC moves, 0 else
        # LINE, ARC, POLYNOMIAL
        (
            "override_off",
            "i8",
        ),  # 1: every override counts as 100 % while the path is on this element (G166); of S: G167
        ("limits", "i8"),  # number of the set of axis limits
        ("v_corner", "f8"),  # greatest path velocity over the corner before this element, whatever its curvature
        (
            "path_v",
            "f8",
        ),  # greatest path velocity, acceleration, deceleration and jerk that the program allows, 0: any
        ("path_a", "f8"),
        ("path_d", "f8"),
        ("path_j", "f8"),
        # weight of a feed that the PLC commands, 0: it does not act here; below 0: the feed is per revolution (G95), made with
        # so many rev/min of the `spindle`
        ("external", "f8"),
        ("f_word", "f8"),  # the feed as programmed, per s, where `feed` is less than that; else 0
        ("unwatched", "i8"),
        ("brake_late", "i8"),  # 1: a lower feed than that of the element before is reached behind the border (G901)
    ],
    align=True,
)

Records = npt.NDArray[np.void]
Floats = npt.NDArray[np.float64]
Counters = npt.NDArray[np.int64]

_HEAD = 64  # bytes: written, read, number of programs ever named, functions to be put out ahead ever written
_NAMES = PROGRAMS * PROGRAM_NAME


class MotionQueue:
    """The ring. `name`: of the shared memory (None: private); `create` makes it, otherwise a running one is opened."""

    def __init__(self, n_axes: int, name: str | None = None, create: bool = True, capacity: int = CAPACITY) -> None:
        if not 1 <= n_axes <= MAX_AXES:
            raise ValueError(f"a channel has 1 to {MAX_AXES} axes, not {n_axes}")
        self.n_axes = n_axes
        self.capacity = capacity
        self._memory: SharedMemory | None = None
        sets = _HEAD + _NAMES + TEXTS_BYTES
        records = sets + limits_bytes(MAX_AXES)
        polynomials = records + capacity * RECORD.itemsize
        size = polynomials + capacity * ROWS * WIDTH * 8
        if name is None:
            buffer: mmap.mmap | bytearray = bytearray(size)
        else:
            self._memory = open_shared(name, size if create else None)
            buffer = self._memory.buf
        self.counters: Counters = np.frombuffer(buffer, dtype=np.int64, count=8)  # written, read, programs
        self._names = np.frombuffer(buffer, dtype=f"S{PROGRAM_NAME}", count=PROGRAMS, offset=_HEAD)
        self.texts = QueueTexts(buffer, _HEAD + _NAMES)
        self.limits = QueueLimits(buffer, sets, MAX_AXES, n_axes, self.counters)
        self.records: Records = np.frombuffer(buffer, dtype=RECORD, count=capacity, offset=records)
        self._kinds = self.records["kind"]
        numbers = np.frombuffer(buffer, dtype=np.float64, count=capacity * ROWS * WIDTH, offset=polynomials)
        self.polynomials: Floats = numbers.reshape(capacity, ROWS, WIDTH)  # tables of geometry.polynomials
        self._known: dict[str, int] = {}

    # ------------------------------------------------------------------ producer

    @property
    def written(self) -> int:
        """Absolute index of the next record to be appended."""
        return int(self.counters[0])

    @property
    def free(self) -> int:
        """Records that `append` will take now."""
        return self.capacity - (int(self.counters[0]) - int(self.counters[1]))

    def append(self, records: Records, tables: Floats | None = None) -> int:
        """Append as many of `records` (k,) of dtype `RECORD` as fit, in order; returns how many. Producer only.

        `tables` (k, ROWS, WIDTH) go along with polynomials.
        """
        written = int(self.counters[0])
        count = min(len(records), self.free)
        slot = written % self.capacity
        first = min(count, self.capacity - slot)
        self.records[slot : slot + first] = records[:first]
        self.records[: count - first] = records[first:count]
        if tables is not None:
            self.polynomials[slot : slot + first] = tables[:first]
            self.polynomials[: count - first] = tables[first:count]
        self.counters[3] += np.count_nonzero(records["kind"][:count] == RecordKind.FUNCTION_AHEAD)
        self.counters[0] = written + count
        return count

    def program_id(self, name: str) -> int:
        """Index of a program name in the table; the oldest name gives way when the table is full. Producer only."""
        known = self._known.get(name)
        if known is None:
            known = int(self.counters[2])
            self._names[known % PROGRAMS] = name.encode("utf-8", "replace")[-PROGRAM_NAME:]
            self.counters[2] = known + 1
            self._known[name] = known
            if len(self._known) > PROGRAMS:
                del self._known[next(iter(self._known))]
        return known

    # ------------------------------------------------------------------ consumer

    def consumer(self) -> MotionQueue:
        """The same queue with counters of its own, for a consumer who takes over at moments of his choice what has come."""
        other = copy(self)
        other.counters = self.counters.copy()
        other._memory = None
        return other

    @property
    def names(self) -> npt.NDArray[np.bytes_]:
        """The names of programs, the one with number n in slot n % PROGRAMS."""
        return self._names

    @property
    def read(self) -> int:
        """Absolute index of the first record that is not free again."""
        return int(self.counters[1])

    def record(self, index: int) -> Any:
        """The record of an absolute index; valid while it is not freed. Fields by name, as in `RECORD`."""
        return self.records[index % self.capacity]

    def kind(self, index: int) -> int:
        """RecordKind of the record of an absolute index, as a plain number."""
        return int(self._kinds[index % self.capacity])

    @property
    def functions_ahead(self) -> int:
        """Functions to be put out ahead of their place that were ever written."""
        return int(self.counters[3])

    def program_name(self, program: int) -> str:
        """The name behind a program id."""
        return bytes(self._names[program % PROGRAMS]).decode("utf-8", "replace")

    def discard_all(self) -> None:
        """Free everything that has been written so far. Consumer only, at standstill."""
        self.counters[1] = self.counters[0]
        self.texts.discard_all()

    # ------------------------------------------------------------------ memory

    def close(self, *, unlink: bool = False) -> None:
        """Let go of the memory; `unlink` also removes it (its creator does)."""
        if self._memory is None:
            return
        memory, self._memory = self._memory, None
        del self.counters, self._names, self.texts, self.limits, self.records, self._kinds, self.polynomials
        if unlink:
            memory.remove()
        else:
            memory.close()
