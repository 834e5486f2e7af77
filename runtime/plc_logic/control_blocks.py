"""Function blocks beside the standard's: signals, limits, ramps and controllers, as machine builders know them.

Called like the standard's blocks. Times are seconds, measured between the PLC cycles a block is called in; the first
call of a block that integrates or differentiates only remembers.
"""

from __future__ import annotations

import math
from collections import deque
from datetime import datetime, timedelta
from typing import Self

from runtime.plc_logic.cycle_time import now_ns, wall_clock


class _Stepped:
    """What blocks have in common that need the time since their last call."""

    def __init__(self) -> None:
        self._last_ns: int | None = None

    def _elapsed(self) -> float:
        """Seconds since the last call; 0 in the first one."""
        now, before = now_ns(), self._last_ns
        self._last_ns = now
        return 0.0 if before is None else (now - before) * 1e-9


# --------------------------------------------------------------------------------------------- signals and times


class BLINK:
    """While ENABLE is TRUE, OUT is TRUE for TIMEHIGH and FALSE for TIMELOW, beginning with TRUE; else FALSE."""

    def __init__(self, TIMELOW: float = 0.5, TIMEHIGH: float = 0.5) -> None:
        self.OUT = False
        self._low, self._high = TIMELOW, TIMEHIGH
        self._start_ns = 0
        self._on = False

    def __call__(self, ENABLE: bool | None = None, TIMELOW: float | None = None, TIMEHIGH: float | None = None) -> Self:
        self._low = self._low if TIMELOW is None else TIMELOW
        self._high = self._high if TIMEHIGH is None else TIMEHIGH
        on = self._on if ENABLE is None else bool(ENABLE)
        if on and not self._on:
            self._start_ns = now_ns()
        self._on = on
        high, low = max(round(self._high * 1e9), 0), max(round(self._low * 1e9), 0)
        period = high + low
        self.OUT = on and high > 0 and (period == 0 or (now_ns() - self._start_ns) % period < high)
        return self


class TONR:
    """Retentive on-delay: counts the time in which IN is TRUE; Q when it has reached PT, until R."""

    def __init__(self, PT: float = 0.0) -> None:
        self.Q = False
        self._pt_ns = round(PT * 1e9)
        self._et_ns = 0
        self._in = False
        self._last_ns = 0

    @property
    def ET(self) -> float:  # noqa: N802 - a pin
        """Counted time, s."""
        return self._et_ns * 1e-9

    def __call__(self, IN: bool | None = None, R: bool = False, PT: float | None = None) -> Self:
        now = now_ns()
        if PT is not None:
            self._pt_ns = round(PT * 1e9)
        if self._in:
            self._et_ns = min(self._et_ns + now - self._last_ns, self._pt_ns)
        if IN is not None:
            self._in = bool(IN)
        self._last_ns = now
        if R:
            self._et_ns = 0
        self.Q = not R and self._et_ns >= self._pt_ns
        return self


class DEBOUNCE:
    """OUT follows IN when IN has kept its value for TIME: for contacts that bounce in both directions."""

    def __init__(self, TIME: float = 0.01) -> None:
        self.OUT = False
        self._time_ns = round(TIME * 1e9)
        self._since_ns: int | None = None

    def __call__(self, IN: bool, TIME: float | None = None) -> Self:
        if TIME is not None:
            self._time_ns = round(TIME * 1e9)
        if bool(IN) is self.OUT:
            self._since_ns = None
            return self
        now = now_ns()
        if self._since_ns is None:
            self._since_ns = now
        if now - self._since_ns >= self._time_ns:
            self.OUT = bool(IN)
            self._since_ns = None
        return self


class OPERATING_HOURS:  # noqa: N801 - a block's name
    """HOURS in which IN was TRUE."""

    def __init__(self, HOURS: float = 0.0) -> None:
        self._ns = round(HOURS * 3.6e12)
        self._in = False
        self._last_ns = 0

    @property
    def HOURS(self) -> float:  # noqa: N802 - a pin
        return self._ns / 3.6e12

    def __call__(self, IN: bool) -> Self:
        now = now_ns()
        if self._in:
            self._ns += now - self._last_ns
        self._in = bool(IN)
        self._last_ns = now
        return self


class RTC:
    """Clock: CDT is the date and time of day. A rising edge of EN sets it to PDT; without one it is the computer's.

    Q is TRUE while EN is. The computer's clock itself is not changed.
    """

    def __init__(self) -> None:
        self.Q = False
        self._ahead = timedelta()
        self._en = False
        self._cdt: datetime | None = None

    @property
    def CDT(self) -> datetime:  # noqa: N802 - the standard's name
        return wall_clock() + self._ahead if self._cdt is None else self._cdt

    def __call__(self, EN: bool = True, PDT: datetime | None = None) -> Self:
        if EN and not self._en and PDT is not None:
            self._ahead = PDT - wall_clock()
        self._en = self.Q = bool(EN)
        self._cdt = wall_clock() + self._ahead
        return self


# --------------------------------------------------------------------------------------------- limits


class HYSTERESIS:
    """OUT becomes TRUE below LOW and FALSE above HIGH; in between it stays: a heater, a pump of a tank."""

    def __init__(self) -> None:
        self.OUT = False

    def __call__(self, IN: float, HIGH: float, LOW: float) -> Self:
        if IN < LOW:
            self.OUT = True
        elif IN > HIGH:
            self.OUT = False
        return self


class LIMITALARM:
    """O above HIGH, U below LOW, IL inside; a limit that was passed is left again only by EPS."""

    def __init__(self) -> None:
        self.O = self.U = False
        self.IL = True

    def __call__(self, IN: float, HIGH: float, LOW: float, EPS: float = 0.0) -> Self:
        self.O = IN > HIGH or (self.O and HIGH - EPS < IN)
        self.U = IN < LOW or (self.U and LOW + EPS > IN)
        self.IL = not (self.O or self.U)
        return self


class RAMP:
    """OUT follows IN with at most ASCEND per second upwards and DESCEND per second downwards; RESET puts it to 0.

    The first call takes over IN at once unless START gives where to begin.
    """

    def __init__(self, START: float | None = None) -> None:
        self.OUT = 0.0 if START is None else START
        self.BUSY = False
        self._begun = START is not None
        self._step = _Stepped()

    def __call__(self, IN: float, ASCEND: float, DESCEND: float, RESET: bool = False) -> Self:
        seconds = self._step._elapsed()
        if RESET:
            self.OUT, self._begun = 0.0, True
        elif not self._begun:
            self.OUT, self._begun = IN, True
        elif self.OUT < IN:
            self.OUT = min(self.OUT + max(ASCEND, 0.0) * seconds, IN)
        else:
            self.OUT = max(self.OUT - max(DESCEND, 0.0) * seconds, IN)
        self.BUSY = self.OUT != IN and not RESET
        return self


# --------------------------------------------------------------------------------------------- controllers


class DERIVATIVE(_Stepped):
    """OUT is the change of IN per second."""

    def __init__(self) -> None:
        super().__init__()
        self.OUT = 0.0
        self._before = 0.0

    def __call__(self, IN: float, RESET: bool = False) -> Self:
        first = self._last_ns is None
        seconds = self._elapsed()
        if RESET or first:
            self.OUT = 0.0
        elif seconds > 0.0:
            self.OUT = (IN - self._before) / seconds
        self._before = IN
        return self


class INTEGRAL(_Stepped):
    """OUT is the sum of IN over the time (trapezoids), kept within LOW and HIGH; LIMITED tells when that acts."""

    def __init__(self) -> None:
        super().__init__()
        self.OUT = 0.0
        self.LIMITED = False
        self._before = 0.0

    def __call__(self, IN: float, RESET: bool = False, LOW: float = -math.inf, HIGH: float = math.inf) -> Self:
        seconds = self._elapsed()
        wanted = 0.0 if RESET else self.OUT + 0.5 * (IN + self._before) * seconds
        self._before = IN
        self.OUT = min(max(wanted, LOW), HIGH)
        self.LIMITED = wanted != self.OUT
        return self


class LAG(_Stepped):
    """First-order low-pass with time constant T: smooths a measured value. Exact for an IN that stands."""

    def __init__(self) -> None:
        super().__init__()
        self.OUT = 0.0

    def __call__(self, IN: float, T: float) -> Self:
        first = self._last_ns is None
        seconds = self._elapsed()
        if first or T <= 0.0:
            self.OUT = IN
        else:
            self.OUT += (IN - self.OUT) * -math.expm1(-seconds / T)
        return self


class AVERAGE:
    """OUT is the mean of the last N values."""

    def __init__(self, N: int) -> None:
        self.OUT = 0.0
        self._values: deque[float] = deque(maxlen=max(N, 1))

    def __call__(self, IN: float, RESET: bool = False) -> Self:
        if RESET:
            self._values.clear()
        self._values.append(IN)
        self.OUT = math.fsum(self._values) / len(self._values)
        return self


class PID(_Stepped):
    """Controller: Y = Y_OFFSET + KP·(e + 1/TN·∫e dt + TV·de/dt) with e = SET_POINT - ACTUAL, within Y_MIN and Y_MAX.

    TN 0: without the integral, TV 0: without the derivative. The derivative is that of the actual value, so that a step
    of the set-point does not kick. While Y is at a limit the integral does not run further into it (anti-windup).
    MANUAL: Y is Y_MANUAL, and the integral follows, so that the change back is smooth. RESET forgets the integral.
    """

    def __init__(self) -> None:
        super().__init__()
        self.Y = 0.0
        self.LIMITS_ACTIVE = False
        self._integral = 0.0  # share of Y
        self._actual = 0.0

    def __call__(
        self,
        ACTUAL: float,
        SET_POINT: float,
        KP: float,
        TN: float = 0.0,
        TV: float = 0.0,
        Y_MANUAL: float = 0.0,
        Y_OFFSET: float = 0.0,
        Y_MIN: float = -math.inf,
        Y_MAX: float = math.inf,
        MANUAL: bool = False,
        RESET: bool = False,
    ) -> Self:
        first = self._last_ns is None
        seconds = self._elapsed()
        if not (math.isfinite(ACTUAL) and math.isfinite(SET_POINT)):  # a broken sensor: stay where we are
            return self
        error = SET_POINT - ACTUAL
        slope = 0.0 if first or seconds <= 0.0 else (self._actual - ACTUAL) / seconds
        self._actual = ACTUAL
        rest = Y_OFFSET + KP * (error + TV * slope)
        if RESET:
            self._integral = 0.0
        if MANUAL:
            self.Y = min(max(Y_MANUAL, Y_MIN), Y_MAX)
            self._integral = self.Y - rest if TN > 0.0 else 0.0
            self.LIMITS_ACTIVE = self.Y != Y_MANUAL
            return self
        if TN > 0.0 and not RESET:
            gain = KP * error * seconds / TN
            ahead = rest + self._integral + gain
            inwards = Y_MIN <= ahead <= Y_MAX or (ahead > Y_MAX and gain < 0.0) or (ahead < Y_MIN and gain > 0.0)
            self._integral += gain if inwards else 0.0
        elif TN <= 0.0:
            self._integral = 0.0
        wanted = rest + self._integral
        self.Y = min(max(wanted, Y_MIN), Y_MAX)
        self.LIMITS_ACTIVE = wanted != self.Y
        return self
