"""Measuring with the path: it goes until a probe signals; what counts is where the axes were then, not where they come to rest.

    gate MEASURE            the line                        gate MEASURE_END       #FLUSH WAIT
    ─────●─────────────────────────────────╳────────●          ●                       ●
     probes are got ready,    an edge: latched │    │ stands:   values go to the        the decoder goes on
     none may be deflected    the path brakes ─┘    │ the rest  preparation link        where the path stands
                                                    └ is dropped

A drive latches by itself (0x60B8); the position comes some cycles later, and is that of the edge all the same. A signal that is
sampled once per cycle has come somewhere between two samples: the place half-way is meant, which is wrong by half of the way of a
cycle at most. With a time stamp the place is interpolated in what the last cycles have seen.

Nothing here knows of a dialect: a run is a record of the queue, and its result a list of positions.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum, auto
from typing import Any

import numpy as np
import numpy.typing as npt

from runtime.cnc.blocks import Probe, ProbeSignal
from runtime.cnc.measuring_records import LIMITED, MAY_BE_DEFLECTED, SIGNAL_NEEDED, THROUGH, probes_of
from runtime.diagnostics.catalogue import measuring as errors
from runtime.diagnostics.errors import Problem
from runtime.drives import (
    PROBE_2_SHIFT,
    PROBE_FALLING,
    PROBE_HAS_FALLEN,
    PROBE_HAS_RISEN,
    PROBE_IS_ON,
    PROBE_ON,
    PROBE_RISING,
    DriveImage,
)
from runtime.hli.layout import Axis as AxisArea

Floats = npt.NDArray[np.float64]

KEPT = 64  # cycles whose positions are known, for time stamps
ON_TIME = 1.0  # s that a drive gets to switch its probe on
LATE_TIME = 0.02  # s that a latched position may come later than the path comes to rest


class MeasuringPhase(Enum):
    """What a measuring run is doing."""

    NONE = auto()
    READYING = auto()  # the path stands, the drives switch their probes on
    RUNNING = auto()
    OVER = auto()  # a probe was deflected at the begin, and may be


class Measuring:
    """Of one channel. The gates call `ready` and `finish`, the channel `step` in every cycle in which a run is `active`.

    `axes` (n_axes,): indices of the path axes among those of the image; `areas` (n_axes,): their places in the interface.
    """

    def __init__(
        self, image: DriveImage, areas: Sequence[AxisArea], axes: Sequence[int], names: Sequence[str], period: float
    ) -> None:
        n = len(axes)
        self._image = image
        self._areas = list(areas)
        self._axes = list(axes)
        self._names = list(names)
        self._period = period
        self.phase = MeasuringPhase.NONE
        self.values: Floats = np.zeros(n)
        self.done = np.zeros(n, dtype=np.bool_)
        self.cuts = False  # the path has to brake, and to drop what is left of the run
        self._probes: tuple[Probe, ...] = ()
        self._flags = 0
        self._armed = np.zeros(n, dtype=np.bool_)  # axes whose drive has been told to wait for the edge
        self._waited = 0.0
        self._places: Floats = np.zeros((KEPT, n))
        self._times: Floats = np.zeros(KEPT)
        self._count = 0  # cycles kept since the run began

    # ------------------------------------------------------------------ begin

    @property
    def active(self) -> bool:
        """A run is under way; it is no more when its values are known."""
        return self.phase is not MeasuringPhase.NONE

    def ready(self, record: Any) -> Problem | bool:
        """The path stands at the begin of a run, `record` of its gate. TRUE: it may move; FALSE: ask again; a problem: it must
        not."""
        if self.phase is MeasuringPhase.NONE:
            problem = self._begin(record)
            if problem is not None:
                return problem
        deflected = next((probe for probe in self._probes if self._level(probe)), None)
        if deflected is None:
            waits_for = self._arm()
            if waits_for is not None:
                self._waited += self._period
                if self._waited < ON_TIME:
                    return False
                self.drop()
                by_drive = waits_for.signal is ProbeSignal.DRIVE
                what = "the drive does not switch it on" if by_drive else "the PLC does not tell its signal"
                return Problem(errors.NOT_READY, {"axis": self._names[waits_for.axis], "what": what})
            self._waited = 0.0
            deflected = next((probe for probe in self._probes if self._stored(probe)), None)
        if deflected is None:
            self.phase = MeasuringPhase.RUNNING
            return True
        if self._flags & MAY_BE_DEFLECTED:
            self.phase, self.cuts = MeasuringPhase.OVER, True
            return True
        self.drop()
        return Problem(errors.DEFLECTED, {"axis": self._names[deflected.axis]})

    def _begin(self, record: Any) -> Problem | None:
        probes = probes_of(record, len(self._axes))
        for probe in probes:
            if probe.signal is ProbeSignal.DRIVE and self._image.probe_function[self._axes[probe.axis]]:
                return Problem(errors.PROBE_BUSY, {"axis": self._names[probe.axis]})
        self.phase = MeasuringPhase.READYING
        self._probes, self._flags = probes, int(record["number"])
        self.done[:] = False
        self._armed[:] = False
        self.cuts = False
        self._waited, self._count = 0.0, 0
        for probe in probes:
            status = self._areas[probe.axis].status
            status.measurement_active_r, status.measure_value_ok_r = True, False
        return None

    def _arm(self) -> Probe | None:
        """Switch the probes of the drives on; one that is not on yet, or whose signal nobody tells."""
        waits_for = None
        for probe in self._probes:
            if probe.signal >= ProbeSignal.PLC and not self._claimed(probe):
                waits_for = probe
            if probe.signal is not ProbeSignal.DRIVE:
                continue
            i, shift = self._axes[probe.axis], PROBE_2_SHIFT * (probe.number - 1)
            on = int(self._image.probe_status[i]) >> shift & PROBE_IS_ON
            if not self._armed[probe.axis] and not on:  # what an earlier order has latched is gone
                edge = PROBE_RISING if probe.rising else PROBE_FALLING
                self._image.probe_function[i] = (PROBE_ON | edge) << shift
                self._armed[probe.axis] = True
                waits_for = probe
            elif not self._armed[probe.axis] or not on:
                waits_for = probe
        return waits_for

    def _claimed(self, probe: Probe) -> bool:
        """The PLC is there and tells the signal."""
        area = self._areas[probe.axis]
        control = area.control
        stamped = probe.signal is not ProbeSignal.PLC_TIMESTAMP or control.probing_time.enable_w
        return bool(area.plc_present_w and control.probing_signal.enable_w and stamped)

    # ------------------------------------------------------------------ the cycle

    def step(self, actual: Floats, time: float) -> Problem | None:
        """Look for edges; `actual` (n_axes,): measured positions of the path axes in this cycle, at `time` s. A problem stops the
        path."""
        if self.phase is not MeasuringPhase.RUNNING:
            return None
        slot = self._count % KEPT
        self._places[slot], self._times[slot] = actual, time
        self._count += 1
        found = False
        for probe in self._probes:
            if self.done[probe.axis]:
                continue
            if probe.signal is ProbeSignal.DRIVE:
                if not self._stored(probe):
                    continue
                i = self._axes[probe.axis]
                place = float(self._image.probe_position[i, 2 * (probe.number - 1) + (not probe.rising)])
            elif not self._signals(probe):
                continue
            elif probe.signal is ProbeSignal.PLC_TIMESTAMP:
                stamp = self._areas[probe.axis].control.probing_time.command_w * 1e-9
                stamped = self._at(probe.axis, stamp)
                if stamped is None:
                    self.drop()
                    return Problem(errors.STAMP_OUTSIDE, {"axis": self._names[probe.axis], "late": time - stamp})
                place = stamped
            else:
                place = self._between(probe.axis)
            self._take(probe.axis, place)
            found = True
        if found and not self._flags & THROUGH:
            self.cuts = True
        return None

    def _take(self, axis: int, place: float) -> None:
        self.values[axis], self.done[axis] = place, True
        status = self._areas[axis].status
        status.measure_value_ok_r = status.probe_actuated_r = True

    def _signals(self, probe: Probe) -> bool:
        """The probe of an axis, or with PLC_FIRST_EVENT that of any axis, is deflected in this cycle."""
        if probe.signal is not ProbeSignal.PLC_FIRST_EVENT:
            return self._level(probe)
        return any(self._level(other) for other in self._probes if other.signal is ProbeSignal.PLC_FIRST_EVENT)

    def _level(self, probe: Probe) -> bool:
        """The probe is deflected, as far as it is known."""
        if probe.signal >= ProbeSignal.PLC:
            if not self._claimed(probe):
                return False
            unit = self._areas[probe.axis].control.probing_signal
            level = bool(unit.command_w)
            if unit.state_r != level:
                unit.state_r = level
            return level is probe.rising
        if probe.level < 0:
            return False
        return bool(self._image.digital_in[probe.level // 8] >> (probe.level % 8) & 1) is probe.rising

    def _stored(self, probe: Probe) -> bool:
        """The drive has latched the edge."""
        if probe.signal is not ProbeSignal.DRIVE or not self._armed[probe.axis]:
            return False
        status = int(self._image.probe_status[self._axes[probe.axis]]) >> PROBE_2_SHIFT * (probe.number - 1)
        return bool(status & (PROBE_HAS_RISEN if probe.rising else PROBE_HAS_FALLEN))

    def _between(self, axis: int) -> float:
        """Half-way between this sample and the one before."""
        now = float(self._places[(self._count - 1) % KEPT, axis])
        before = float(self._places[(self._count - 2) % KEPT, axis]) if self._count > 1 else now
        return 0.5 * (now + before)

    def _at(self, axis: int, stamp: float) -> float | None:
        """Where the axis was at `stamp` s; None if that is not known."""
        newest = self._count - 1
        for k in range(newest, max(newest - KEPT + 1, 0) - 1, -1):
            slot = k % KEPT
            if self._times[slot] <= stamp:
                if k == newest:
                    return float(self._places[slot, axis]) if stamp - self._times[slot] < self._period else None
                after = (k + 1) % KEPT
                share = (stamp - self._times[slot]) / (self._times[after] - self._times[slot])
                return float(self._places[slot, axis] + share * (self._places[after, axis] - self._places[slot, axis]))
        return None

    # ------------------------------------------------------------------ end

    def finish(self) -> Problem | bool:
        """The path stands at the end of the run. TRUE: the values are final; FALSE: one may still come; a problem: the program
        ends."""
        missing = next((probe for probe in self._probes if not self.done[probe.axis]), None)
        if self.phase is MeasuringPhase.RUNNING and missing is not None:
            self._waited += self._period
            if self._waited < LATE_TIME:
                return False
        over = self.phase is MeasuringPhase.OVER
        self.drop()
        if missing is None or over:
            return True
        if self._flags & LIMITED and not self.done.any():
            return Problem(errors.LIMIT_WITHOUT_SIGNAL)
        if self._flags & SIGNAL_NEEDED:
            return Problem(errors.NO_SIGNAL, {"axis": self._names[missing.axis]})
        return True

    def drop(self) -> None:
        """The run is over, whatever became of it: the probes are switched off."""
        if self.phase is MeasuringPhase.NONE:
            return
        self.phase, self.cuts = MeasuringPhase.NONE, False
        for probe in self._probes:
            if self._armed[probe.axis]:
                self._image.probe_function[self._axes[probe.axis]] = 0
            status = self._areas[probe.axis].status
            status.measurement_active_r = status.probe_actuated_r = False
        self._armed[:] = False
