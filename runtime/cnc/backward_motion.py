"""Backward and forward motion on the path: what was driven is driven again, from its end to its begin and back.

    ONWARD ──wanted──▶ TURNING ──stands──▶ BACKWARD ──taken back──▶ TURNING ──stands──▶ REPEATING ──at its end──▶ ONWARD
                          └──taken back──▶ ONWARD                      ▲ └──inside the element that was in work──▶ ONWARD
                                                                       └──wanted── REPEATING

The program is not decoded again: the records that the path has passed are kept (`interpolator.path_storage`) and filled into a
queue of their own, which the same interpolator drives with the same limits, override, feed hold and single block. What the
preparation makes meanwhile waits in the queue of the program.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto

from runtime.cnc.interpolator import Interpolator, Track
from runtime.cnc.interpolator.path_storage import PathStorage
from runtime.cnc.motion_queue import RecordKind

_MOTION = int(RecordKind.POLYNOMIAL)


class Way(Enum):
    """How the path is driven."""

    ONWARD = auto()  # for the first time
    TURNING = auto()  # brakes, to turn
    BACKWARD = auto()
    REPEATING = auto()  # forward again, to where it was left


@dataclass(frozen=True, slots=True)
class RepeatedStops:
    """Which programmed stops are left out: M00 and M01, backward and forward again (P-CHAN-00276 to 00279)."""

    backward: tuple[bool, bool] = (False, False)
    repeating: tuple[bool, bool] = (False, False)


class BackwardMotion:
    """Of one channel. `step` before the interpolator in every cycle, `follow` behind it.

    `capacity`: records that are kept at most, 0: the function is absent.
    """

    def __init__(self, path: Interpolator, capacity: int, stops: RepeatedStops) -> None:
        self._path = path
        self._stops = stops
        self.storage = PathStorage(path.queue.n_axes, capacity)
        self._track = Track(self.storage.queue)
        self._way = Way.ONWARD
        self._after_turn = Way.ONWARD  # which way the path had before it began to turn
        self._off = False
        self.changed = False  # in the last step the path has gone over to another queue

    @property
    def way(self) -> Way:
        return self._way

    @property
    def replaying(self) -> bool:
        """The path is on what was kept, and not on the queue of the program."""
        return self._path.queue is self.storage.queue

    @property
    def possible(self) -> bool:
        """What this program drives is kept."""
        return self.storage.capacity > 0 and not self._off

    @property
    def holds(self) -> bool:
        """The path has to brake, as it is to turn."""
        return self._way is Way.TURNING

    @property
    def at_begin(self) -> bool:
        """The path stands where what is kept begins: it goes no further backward."""
        path, storage = self._path, self.storage
        return self._way is Way.BACKWARD and storage.ended and path.nothing_known and path.standstill

    @property
    def backward(self) -> bool:
        """The path is driven backward, or is about to turn from that."""
        return self.replaying and (self._way is Way.BACKWARD or self._after_turn is Way.BACKWARD)

    @property
    def stored(self) -> int:
        """Records that are kept."""
        return self.storage.count

    # ------------------------------------------------------------------ the program

    def begin(self, *, off: bool) -> None:
        """A program starts; `off`: nothing of it is kept."""
        self.end()
        self._off = off
        self.storage.begin(self._path.queue.read)

    def end(self) -> None:
        """The program is over, or its path: back to its queue. The caller lets the interpolator begin anew."""
        if self.replaying:
            self._path.exchange(self._track)
        self._way = Way.ONWARD
        self.changed = False

    def clear(self) -> None:
        """Where the path is now, nothing lies behind it."""
        if not self.replaying:
            self.storage.clear()

    # ------------------------------------------------------------------ the cycle

    def step(self, wanted: bool, simulated: bool, mask: int) -> None:
        """Before the interpolator: turn where the path stands, fill what is driven next."""
        self.changed = False
        if not self.possible:
            return
        path = self._path
        if self._way is Way.TURNING:
            self._turn(wanted)
        elif wanted != (self._way is Way.BACKWARD) and (self.replaying or self._anything_behind):
            self._after_turn, self._way = self._way, Way.TURNING
            self._turn(wanted)
        if not self.replaying:
            return
        self.storage.fill(simulated, mask)
        if self._way is Way.REPEATING and self.storage.ended and path.nothing_known and path.standstill:
            self._onward(0.0)

    def follow(self) -> None:
        """Behind the interpolator: keep what it has passed."""
        path = self._path
        if self.possible and not self.replaying:
            self.storage.follow(path.queue, min(path.reported, path.next_index))

    @property
    def _anything_behind(self) -> bool:
        return self.storage.count > 0 or self._path.inside > 0.0

    # ------------------------------------------------------------------ turning

    def _turn(self, wanted: bool) -> None:
        before = self._after_turn
        if wanted == (before is Way.BACKWARD):  # taken back while the path was braking
            self._way = before
            return
        path = self._path
        if path.path_velocity != 0.0 or not path.standstill or not path.all_told:
            return
        if before is Way.ONWARD:
            self._backward_from_program()
        elif before is Way.REPEATING:
            self._backward_again()
        else:
            self._forward_again()

    def _backward_from_program(self) -> None:
        path, storage = self._path, self.storage
        here, way, inside = path.next_index, path.path_position, path.inside
        known = here < path.queue.written and path.queue.kind(here) <= _MOTION
        storage.turn(storage.next - 1, -1, self._stops.backward, inside=False)
        left = 0.0
        if known and inside > 0.0:
            record = path.queue.record(here)
            storage.put(record, path.queue.polynomials[here % path.queue.capacity], storage.next)
            left = float(record["length"]) - inside
        path.exchange(self._track)
        self._drive(way, -1.0, left)
        self._way = Way.BACKWARD

    def _backward_again(self) -> None:
        path, storage = self._path, self.storage
        here, way, inside = path.next_index, path.path_position, path.inside
        at, left = storage.next - 1, 0.0
        turns_inside = False
        if here < path.queue.written:
            at = storage.number(here) - 1
            if path.queue.kind(here) <= _MOTION and inside > 0.0:
                at, left, turns_inside = at + 1, float(path.queue.record(here)["length"]) - inside, True
        storage.turn(at, -1, self._stops.backward, inside=turns_inside)
        self._drive(way, -1.0, left)
        self._way = Way.BACKWARD

    def _forward_again(self) -> None:
        """From where the path stands in what was driven backward; back in the program at once if it has not left its element."""
        path, storage = self._path, self.storage
        here, way = path.next_index, path.path_position
        inside = 0.0
        if here >= path.queue.written:
            at = storage.number(path.queue.written - 1) if path.queue.written > 0 else storage.next
        elif path.queue.kind(here) <= _MOTION:
            at = storage.number(here)
            inside = max(float(path.queue.record(here)["length"]) - path.inside, 0.0)
        else:
            at = storage.number(here) + 1
        if at >= storage.next:
            self._onward(inside)
            return
        storage.turn(at, 1, self._stops.repeating, inside=False)
        self._drive(way, 1.0, inside)
        self._way = Way.REPEATING

    def _drive(self, way: float, sense: float, inside: float) -> None:
        path = self._path
        path.restart(path.position.copy())
        if inside > 0.0:
            path.stand_inside(inside)
        path.count_from(way, sense)
        self.changed = True

    def _onward(self, inside: float) -> None:
        """Back in the queue of the program, `inside` mm of the element that was in work."""
        path = self._path
        path.exchange(self._track)
        here = path.next_index
        if here < path.queue.written and path.queue.kind(here) <= _MOTION:
            path.stand_inside(inside)
        self._way = Way.ONWARD
        self.changed = True
