"""How the cycle orders a program and how the preparation answers: one record in shared memory.

    cycle:        fills the order, then counts `order` up                      (start a program, abort it)
    preparation:  sees order != answer, acts, then sets `answer` = `order`     (has begun, or has stopped writing)
    preparation:  sets `state`, and the problem before it, when it ends

    preparation:  has written a #FLUSH WAIT into the queue, asks the decoder for nothing more
    cycle:        has come there: writes the positions, then counts `reached` up

What is told at decoding time goes from the preparation to the cycle through `told`.

After an abort is answered the preparation writes no record into the motion queue until the next start, so the cycle may
throw away what is left in it.
"""

from __future__ import annotations

import mmap
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.cnc.decoder_reports import REPORTS_BYTES, DecoderReports
from runtime.cnc.search_target import BlockSearch, SearchKind
from runtime.diagnostics.memory import SharedMemory, open_shared
from runtime.hli.layout import Mode

AXES = 8
TEXT = 400
FILE = 304


class Order(IntEnum):
    NONE = 0
    START = 1
    ABORT = 2


class PreparationState(IntEnum):
    IDLE = 0
    RUNNING = 1
    FINISHED = 2  # everything up to the program end is in the queue
    FAILED = 3  # the problem tells why; what was prepared before it is in the queue


_SEARCH = ("value", "passes", "covered", "way", "line", "automatic", "without_stop", "feed")  # of BlockSearch, numbers
_RUNNING = int(PreparationState.RUNNING)
GUARDS = ("order", "answer", "kind", "state", "ready", "reached", "holds")  # written behind what they tell of
RECORD = np.dtype(
    [
        ("order", "u4"),
        ("answer", "u4"),
        ("kind", "i4"),
        ("state", "i4"),
        ("ready", "i4"),
        ("skip_levels", "u4"),
        ("problem_id", "i4"),
        ("problem_line", "i4"),
        ("problem_column", "i4"),
        ("reached", "u4"),  # places of #FLUSH WAIT since the start of the program
        ("holds", "i4"),  # the decoder waits for something outside
        ("start", "f8", (AXES,)),
        ("command", "f8", (AXES,)),  # positions at the place reached last
        ("actual", "f8", (AXES,)),
        ("manual", "f8", (AXES,)),  # offsets by hand there
        ("measured", "f8", (AXES,)),  # where the probes of the last measuring run saw their edges
        ("measured_axes", "u4"),  # bits: axes that have such a value
        ("text", "i4"),  # 1: `program` is NC blocks
        ("mode", "i4"),  # of the mode unit
        ("after_end", "i4"),
        ("program", f"S{FILE}"),
        ("search", "i4"),  # SearchKind, and the fields of BlockSearch
        ("search_passes", "u4"),
        ("search_line", "i4"),
        ("search_automatic", "i4"),
        ("search_without_stop", "i4"),
        ("search_value", "i8"),
        ("search_covered", "f8"),
        ("search_way", "f8"),
        ("search_feed", "f8"),
        ("search_ranks", "i4", (AXES,)),
        ("begin", "f8", (AXES,)),  # where the program begins
        ("search_program", f"S{FILE}"),
        ("problem_file", f"S{FILE}"),
        ("problem_text", f"S{TEXT}"),
    ],
    align=True,
)


@dataclass(frozen=True, slots=True)
class StartOrder:
    """Which program, from which machine position (n_axes,), with which skip levels (bit n-1 = level n), in which mode.

    `text`: the program is NC blocks, and no file. `search`: where it is entered, None at its beginning; `begin` (n_axes,) is
    where the program takes the axes to be at its beginning then, None where they are. `after_end`: the program before has come to
    its end.
    """

    program: str
    start: npt.NDArray[np.float64]
    skip_levels: int
    mode: int = int(Mode.AUTOMATIC)
    text: bool = False
    search: BlockSearch | None = None
    begin: npt.NDArray[np.float64] | None = None
    after_end: bool = False


class Failure(NamedTuple):
    """What stopped the preparation: catalogue id (0: nothing), text, and the place in the program."""

    id: int
    text: str
    file: str = ""
    line: int = 0  # 0: unknown
    column: int = 0


NO_FAILURE = Failure(0, "")


class PreparationLink:
    """Both ends of the link; in shared memory when `name` is given."""

    def __init__(self, n_axes: int, name: str | None = None, *, create: bool = True) -> None:
        self._n_axes = n_axes
        self._memory: SharedMemory | None = None
        if name is None:
            buffer: mmap.mmap | bytearray = bytearray(RECORD.itemsize + REPORTS_BYTES)
        else:
            self._memory = open_shared(name, RECORD.itemsize + REPORTS_BYTES if create else None)
            buffer = self._memory.buf
        self.buffer = buffer
        self._record = np.frombuffer(buffer, dtype=RECORD, count=1)[0:1]
        self._fields = {name: self._record[name] for name in RECORD.names or ()}  # views: making one takes its time
        self.told = DecoderReports(buffer, RECORD.itemsize)

    def _get(self, name: str) -> int:
        return int(self._fields[name][0])

    # ------------------------------------------------------------------ the cycle's side

    def start(self, order: StartOrder) -> None:
        """Order a program; the answer comes in a later cycle."""
        record = self._record
        record["program"][0] = order.program.encode()
        record["start"][0, : self._n_axes] = order.start
        record["skip_levels"][0] = order.skip_levels
        record["mode"][0], record["text"][0] = order.mode, order.text
        record["after_end"][0] = order.after_end
        record["begin"][0, : self._n_axes] = order.start if order.begin is None else order.begin
        self._write_search(order.search)
        record["state"][0] = PreparationState.RUNNING
        record["problem_id"][0] = 0
        record["reached"][0] = 0
        record["holds"][0] = 0
        self._order(Order.START)

    def _write_search(self, search: BlockSearch | None) -> None:
        record = self._record
        record["search"][0] = SearchKind.NONE if search is None else search.kind
        if search is None:
            return
        for name in _SEARCH:
            record[f"search_{name}"][0] = getattr(search, name)
        record["search_program"][0] = search.program.encode()
        record["search_ranks"][0] = 0
        record["search_ranks"][0, : len(search.ranks)] = search.ranks

    def _read_search(self) -> BlockSearch | None:
        record = self._record
        kind = SearchKind(self._get("search"))
        if kind is SearchKind.NONE:
            return None
        return BlockSearch(
            kind,
            value=self._get("search_value"),
            passes=self._get("search_passes"),
            program=bytes(record["search_program"][0]).decode(),
            covered=float(record["search_covered"][0]),
            way=float(record["search_way"][0]),
            line=self._get("search_line"),
            automatic=bool(self._get("search_automatic")),
            without_stop=bool(self._get("search_without_stop")),
            feed=float(record["search_feed"][0]),
            ranks=tuple(record["search_ranks"][0, : self._n_axes].tolist()),
        )

    def abort(self) -> None:
        """Order the preparation to stop writing."""
        self._order(Order.ABORT)

    def _order(self, kind: Order) -> None:
        self._record["kind"][0] = kind
        self._record["order"][0] += np.uint32(1)

    @property
    def ready(self) -> bool:
        """The preparation has loaded everything and looks at the link."""
        return bool(self._get("ready"))

    @property
    def answered(self) -> bool:
        """The last order has been taken."""
        return self._get("order") == self._get("answer")

    @property
    def state(self) -> PreparationState:
        return PreparationState(self._get("state"))

    @property
    def running(self) -> bool:
        """More blocks may come."""
        return self._get("state") == _RUNNING

    @property
    def holds(self) -> bool:
        """The decoder waits for something outside: no blocks will come meanwhile."""
        return bool(self._get("holds"))

    def reach(
        self,
        command: npt.NDArray[np.float64],
        actual: npt.NDArray[np.float64],
        manual: npt.NDArray[np.float64] | None = None,
    ) -> None:
        """The path stands at the next place where the decoder waits, and everything is done; positions (n_axes,), machine
        coordinates, and the offsets by hand."""
        record = self._record
        record["manual"][0, : self._n_axes] = 0.0 if manual is None else manual
        record["command"][0, : self._n_axes] = command
        record["actual"][0, : self._n_axes] = actual
        record["reached"][0] += np.uint32(1)

    def measure(self, values: npt.NDArray[np.float64], done: npt.NDArray[np.bool_]) -> None:
        """A measuring run is over: positions (n_axes,) in machine coordinates of the axes that have one; `reach` comes behind."""
        record = self._record
        record["measured"][0, : self._n_axes] = values
        record["measured_axes"][0] = sum(1 << k for k, one in enumerate(done.tolist()) if one)

    @property
    def problem(self) -> Failure:
        """What stopped the preparation."""
        text, file = (
            bytes(self._record[name][0]).decode("utf-8", "replace") for name in ("problem_text", "problem_file")
        )
        return Failure(self._get("problem_id"), text, file, self._get("problem_line"), self._get("problem_column"))

    # ------------------------------------------------------------------ the preparation's side

    @property
    def waiting_order(self) -> Order:
        """The order that is not yet answered, or NONE."""
        return Order.NONE if self.answered else Order(self._get("kind"))

    def announce(self) -> None:
        """Tell that the preparation looks at the link from now on."""
        self._record["ready"][0] = 1

    def read_start(self) -> StartOrder:
        record = self._record
        return StartOrder(
            program=bytes(record["program"][0]).decode(),
            start=np.array(record["start"][0, : self._n_axes]),
            skip_levels=self._get("skip_levels"),
            mode=self._get("mode"),
            text=bool(self._get("text")),
            search=self._read_search(),
            begin=np.array(record["begin"][0, : self._n_axes]),
            after_end=bool(self._get("after_end")),
        )

    @property
    def reached(self) -> int:
        """Places of #FLUSH WAIT that the path has come to since the start of the program."""
        return self._get("reached")

    @property
    def command_position(self) -> npt.NDArray[np.float64]:
        """Where the path stood at the place reached last, (n_axes,), mm or degrees."""
        return np.array(self._record["command"][0, : self._n_axes])

    @property
    def actual_position(self) -> npt.NDArray[np.float64]:
        """Where the axes really were there, (n_axes,), mm or degrees."""
        return np.array(self._record["actual"][0, : self._n_axes])

    @property
    def manual_offsets(self) -> npt.NDArray[np.float64]:
        """What the axes were moved by hand there, beside the path; (n_axes,), mm or degrees."""
        return np.array(self._record["manual"][0, : self._n_axes])

    @property
    def measured(self) -> dict[int, float]:
        """What the last measuring run before that place has found: axis (index in the channel) → its position, mm, degrees."""
        axes = self._get("measured_axes")
        values = self._record["measured"][0]
        return {k: float(values[k]) for k in range(self._n_axes) if axes >> k & 1}

    def set_holds(self, holds: bool) -> None:
        """Tell whether the decoder waits for something outside."""
        self._record["holds"][0] = holds

    def answer(self) -> None:
        self._record["answer"][0] = self._record["order"][0]

    def finish(self, state: PreparationState, failure: Failure = NO_FAILURE) -> None:
        """Tell how it ended; the state is written last."""
        record = self._record
        record["problem_text"][0] = failure.text.encode("utf-8", "replace")[:TEXT]
        record["problem_file"][0] = failure.file.encode("utf-8", "replace")[:FILE]
        record["problem_line"][0] = failure.line
        record["problem_column"][0] = failure.column
        record["problem_id"][0] = failure.id
        record["state"][0] = state

    def close(self, *, unlink: bool = False) -> None:
        if self._memory is None:
            return
        memory, self._memory = self._memory, None
        del self.buffer, self._record, self._fields, self.told
        if unlink:
            memory.remove()
        else:
            memory.close()
