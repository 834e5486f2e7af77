"""The standard function blocks of IEC 61131-3 (tables 43 to 46 of edition 3), under their names and with their pins.

A block is called with its inputs and returns itself: `if self.delay(IN=door_open, PT=0.5).Q: ...`. An input that is
not given keeps its last value, as in the standard. Times are seconds; a timer measures between the times of the PLC
cycles it is called in.
"""

from __future__ import annotations

from typing import Self

from runtime.plc_logic.cycle_time import now_ns

INT_MAX = 32767  # PVmax and PVmin of the counters
INT_MIN = -32768


def _ns(seconds: float) -> int:
    return round(seconds * 1e9)


# --------------------------------------------------------------------------------------------- bistable elements


class SR:
    """Bistable, set dominant: Q1 = S1 OR (Q1 AND NOT R)."""

    def __init__(self) -> None:
        self.Q1 = False
        self._s1 = False
        self._r = False

    def __call__(self, S1: bool | None = None, R: bool | None = None) -> Self:
        self._s1 = self._s1 if S1 is None else bool(S1)
        self._r = self._r if R is None else bool(R)
        self.Q1 = self._s1 or (self.Q1 and not self._r)
        return self


class RS:
    """Bistable, reset dominant: Q1 = NOT R1 AND (S OR Q1)."""

    def __init__(self) -> None:
        self.Q1 = False
        self._s = False
        self._r1 = False

    def __call__(self, S: bool | None = None, R1: bool | None = None) -> Self:
        self._s = self._s if S is None else bool(S)
        self._r1 = self._r1 if R1 is None else bool(R1)
        self.Q1 = not self._r1 and (self._s or self.Q1)
        return self


# --------------------------------------------------------------------------------------------- edge detection


class R_TRIG:  # noqa: N801 - the standard's name
    """Rising edge: Q is TRUE in the one call in which CLK has changed to TRUE, and in a first call with CLK TRUE."""

    def __init__(self) -> None:
        self.Q = False
        self._clk = False
        self._memory = False

    def __call__(self, CLK: bool | None = None) -> Self:
        self._clk = self._clk if CLK is None else bool(CLK)
        self.Q = self._clk and not self._memory
        self._memory = self._clk
        return self


class F_TRIG:  # noqa: N801 - the standard's name
    """Falling edge. By the standard's body a first call with CLK FALSE gives Q TRUE once."""

    def __init__(self) -> None:
        self.Q = False
        self._clk = False
        self._memory = False

    def __call__(self, CLK: bool | None = None) -> Self:
        self._clk = self._clk if CLK is None else bool(CLK)
        self.Q = not self._clk and not self._memory
        self._memory = not self._clk
        return self


# --------------------------------------------------------------------------------------------- counters


class CTU:
    """Up counter: counts rising edges of CU, R sets CV to 0; Q when CV has reached PV."""

    def __init__(self, PV: int = 0) -> None:
        self.Q = False
        self.CV = 0
        self._pv = PV
        self._r = False
        self._cu = R_TRIG()

    def __call__(self, CU: bool | None = None, R: bool | None = None, PV: int | None = None) -> Self:
        self._pv = self._pv if PV is None else PV
        self._r = self._r if R is None else bool(R)
        up = self._cu(CLK=CU).Q
        if self._r:
            self.CV = 0
        elif up and self.CV < INT_MAX:
            self.CV += 1
        self.Q = self._pv <= self.CV
        return self


class CTD:
    """Down counter: LD loads PV, rising edges of CD count down; Q when CV is 0 or less."""

    def __init__(self, PV: int = 0) -> None:
        self.Q = False
        self.CV = 0
        self._pv = PV
        self._ld = False
        self._cd = R_TRIG()

    def __call__(self, CD: bool | None = None, LD: bool | None = None, PV: int | None = None) -> Self:
        self._pv = self._pv if PV is None else PV
        self._ld = self._ld if LD is None else bool(LD)
        down = self._cd(CLK=CD).Q
        if self._ld:
            self.CV = self._pv
        elif down and self.CV > INT_MIN:
            self.CV -= 1
        self.Q = self.CV <= 0
        return self


class CTUD:
    """Up and down counter: R before LD before counting; edges of CU and CD in the same call cancel each other."""

    def __init__(self, PV: int = 0) -> None:
        self.QU = False
        self.QD = False
        self.CV = 0
        self._pv = PV
        self._r = False
        self._ld = False
        self._cu = R_TRIG()
        self._cd = R_TRIG()

    def __call__(
        self,
        CU: bool | None = None,
        CD: bool | None = None,
        R: bool | None = None,
        LD: bool | None = None,
        PV: int | None = None,
    ) -> Self:
        self._pv = self._pv if PV is None else PV
        self._r = self._r if R is None else bool(R)
        self._ld = self._ld if LD is None else bool(LD)
        up, down = self._cu(CLK=CU).Q, self._cd(CLK=CD).Q
        if self._r:
            self.CV = 0
        elif self._ld:
            self.CV = self._pv
        elif up and not down and self.CV < INT_MAX:
            self.CV += 1
        elif down and not up and self.CV > INT_MIN:
            self.CV -= 1
        self.QU = self._pv <= self.CV
        self.QD = self.CV <= 0
        return self


# --------------------------------------------------------------------------------------------- timers


class _Timer:
    """What the timers have in common: pins, and the time since the start, which never exceeds PT."""

    def __init__(self, PT: float = 0.0) -> None:
        self.Q = False
        self._in = False
        self._pt_ns = _ns(PT)
        self._start_ns = 0
        self._et_ns = 0

    @property
    def ET(self) -> float:  # noqa: N802 - the standard's name
        """Elapsed time, s."""
        return self._et_ns * 1e-9

    def _inputs(self, IN: bool | None, PT: float | None) -> bool:
        """Take the inputs; whether IN has just risen."""
        before = self._in
        if PT is not None:
            self._pt_ns = _ns(PT)
        if IN is not None:
            self._in = bool(IN)
        return self._in and not before

    def _measure(self) -> bool:
        """Update ET of a running timer; whether PT has passed."""
        self._et_ns = max(min(now_ns() - self._start_ns, self._pt_ns), 0)
        return self._et_ns >= self._pt_ns


class TON(_Timer):
    """On-delay: Q follows IN when it has been TRUE for PT, and falls with IN.

    IN  ___┌─────────────┐____┌──┐___
    Q   ________┌────────┐___________
            PT
    """

    def __call__(self, IN: bool | None = None, PT: float | None = None) -> Self:
        if self._inputs(IN, PT):
            self._start_ns = now_ns()
        if not self._in:
            self.Q = False
            self._et_ns = 0
        elif not self.Q:  # reached is reached, even if PT grows later
            self.Q = self._measure()
        return self


class TOF(_Timer):
    """Off-delay: Q rises with IN and falls when IN has been FALSE for PT.

    IN  ___┌──────┐__________┌──┐_┌──┐______
    Q   ___┌───────────┐_____┌────────────┐_
                    PT
    """

    def __call__(self, IN: bool | None = None, PT: float | None = None) -> Self:
        before = self._in
        self._inputs(IN, PT)
        if self._in:
            self.Q = True
            self._et_ns = 0
        else:
            if before:
                self._start_ns = now_ns()
            if self.Q:
                self.Q = not self._measure()
        return self


class TP(_Timer):
    """Pulse: a rising edge of IN gives Q for PT, whatever IN does meanwhile; ET stays at PT while IN is still TRUE.

    IN  ___┌─────────┐___┌─┐_┌─┐____
    Q   ___┌─────┐_______┌─────┐____
             PT            PT
    """

    def __call__(self, IN: bool | None = None, PT: float | None = None) -> Self:
        rising = self._inputs(IN, PT)
        if self.Q and self._measure():
            self.Q = False
        if rising and not self.Q:
            self._start_ns = now_ns()
            self.Q = not self._measure()
        if not self.Q and not self._in:
            self._et_ns = 0
        return self
