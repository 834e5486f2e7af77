"""Sections of the path in which the operator's stop and override have no effect, as in the thread of a floating tap.

    feed hold before the section ─▶ stays in effect: the path stands, and goes on when it is taken back
    feed hold within it          ─▶ takes effect where the section ends
    hold of an axis, reset, errors, loss of the PLC ─▶ as ever

A program that wants a section whole lets the path stand in front of it (`ExactStop`): what stops the path there does so before it
has begun. Where the path is driven backward, or forward again, everything is in effect.
"""

from __future__ import annotations

from runtime.cnc.queue_record import QueueRecord

FEED_STOP, OVERRIDE = 1, 2  # bits of `number` of the record


class Suppression:
    """Of one channel."""

    def __init__(self) -> None:
        self._feed_stop = self._override = False
        self._held = False  # feed hold is in effect

    def begin(self) -> None:
        """A program begins or ends: nothing is suppressed."""
        self._feed_stop = self._override = False

    def act(self, record: QueueRecord) -> None:
        """The path has come to where a section begins, ends, or changes."""
        self._feed_stop = bool(record.number & FEED_STOP)
        self._override = bool(record.number & OVERRIDE)

    def held(self, feed_hold: bool, replaying: bool) -> bool:
        """Once per cycle: whether feed hold is in effect."""
        self._held = feed_hold and (self._held or replaying or not self._feed_stop)
        return self._held

    def full_override(self, replaying: bool) -> bool:
        """Every override counts as 100 %."""
        return self._override and not replaying
