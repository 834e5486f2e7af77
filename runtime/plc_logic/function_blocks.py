"""The standard function blocks of IEC 61131-3 (tables 43 to 46 of edition 3), under their names and with their pins.

A block is called with its inputs and returns itself: `if self.delay(IN=door_open, PT=0.5).Q: ...`. An input that is
not given keeps its last value, as in the standard. Times are seconds (`TIME("T#1m30s")` gives them); a timer measures
between the times of the PLC cycles it is called in.

A program calls thousands of blocks per cycle, so each block does its work in one function.
"""

from __future__ import annotations

from typing import Self

from runtime.plc_logic.cycle_time import MOMENT, now_ns

INT_MAX = 32767  # PVmax and PVmin of the counters
INT_MIN = -32768


def _ns(seconds: float) -> int:
    return round(seconds * 1e9)


# --------------------------------------------------------------------------------------------- bistable elements


class SR:
    """Bistable, set dominant: Q1 = S1 OR (Q1 AND NOT R)."""

    __slots__ = ("Q1", "_r", "_s1")

    def __init__(self) -> None:
        self.Q1 = self._s1 = self._r = False

    def __call__(self, S1: bool | None = None, R: bool | None = None) -> Self:
        if S1 is not None:
            self._s1 = True if S1 else False  # noqa: SIM210 - half the time of bool()
        if R is not None:
            self._r = True if R else False  # noqa: SIM210
        self.Q1 = self._s1 or (self.Q1 and not self._r)
        return self


class RS:
    """Bistable, reset dominant: Q1 = NOT R1 AND (S OR Q1)."""

    __slots__ = ("Q1", "_r1", "_s")

    def __init__(self) -> None:
        self.Q1 = self._s = self._r1 = False

    def __call__(self, S: bool | None = None, R1: bool | None = None) -> Self:
        if S is not None:
            self._s = True if S else False  # noqa: SIM210
        if R1 is not None:
            self._r1 = True if R1 else False  # noqa: SIM210
        self.Q1 = not self._r1 and (self._s or self.Q1)
        return self


# --------------------------------------------------------------------------------------------- edge detection


class R_TRIG:  # noqa: N801 - the standard's name
    """Rising edge: Q is TRUE in the one call in which CLK has changed to TRUE, and in a first call with CLK TRUE."""

    __slots__ = ("Q", "_clk")

    def __init__(self) -> None:
        self.Q = self._clk = False

    def __call__(self, CLK: bool | None = None) -> Self:
        before = self._clk
        if CLK is not None:
            self._clk = True if CLK else False  # noqa: SIM210
        self.Q = self._clk and not before
        return self


class F_TRIG:  # noqa: N801 - the standard's name
    """Falling edge. By the standard's body a first call with CLK FALSE gives Q TRUE once."""

    __slots__ = ("Q", "_clk", "_memory")

    def __init__(self) -> None:
        self.Q = self._clk = self._memory = False

    def __call__(self, CLK: bool | None = None) -> Self:
        if CLK is not None:
            self._clk = True if CLK else False  # noqa: SIM210
        self.Q = not self._clk and not self._memory
        self._memory = not self._clk
        return self


# --------------------------------------------------------------------------------------------- counters


class CTU:
    """Up counter: counts rising edges of CU, R sets CV to 0; Q when CV has reached PV."""

    __slots__ = ("CV", "Q", "_cu", "_pv", "_r")

    def __init__(self, PV: int = 0) -> None:
        self.Q = self._r = self._cu = False
        self.CV = 0
        self._pv = PV

    def __call__(self, CU: bool | None = None, R: bool | None = None, PV: int | None = None) -> Self:
        if PV is not None:
            self._pv = PV
        if R is not None:
            self._r = True if R else False  # noqa: SIM210
        up = False
        if CU is not None:
            up = bool(CU and not self._cu)
            self._cu = True if CU else False  # noqa: SIM210
        if self._r:
            self.CV = 0
        elif up and self.CV < INT_MAX:
            self.CV += 1
        self.Q = self._pv <= self.CV
        return self


class CTD:
    """Down counter: LD loads PV, rising edges of CD count down; Q when CV is 0 or less."""

    __slots__ = ("CV", "Q", "_cd", "_ld", "_pv")

    def __init__(self, PV: int = 0) -> None:
        self.Q = self._ld = self._cd = False
        self.CV = 0
        self._pv = PV

    def __call__(self, CD: bool | None = None, LD: bool | None = None, PV: int | None = None) -> Self:
        if PV is not None:
            self._pv = PV
        if LD is not None:
            self._ld = True if LD else False  # noqa: SIM210
        down = False
        if CD is not None:
            down = bool(CD and not self._cd)
            self._cd = True if CD else False  # noqa: SIM210
        if self._ld:
            self.CV = self._pv
        elif down and self.CV > INT_MIN:
            self.CV -= 1
        self.Q = self.CV <= 0
        return self


class CTUD:
    """Up and down counter: R before LD before counting; edges of CU and CD in the same call cancel each other."""

    __slots__ = ("CV", "QD", "QU", "_cd", "_cu", "_ld", "_pv", "_r")

    def __init__(self, PV: int = 0) -> None:
        self.QU = self.QD = self._r = self._ld = self._cu = self._cd = False
        self.CV = 0
        self._pv = PV

    def __call__(
        self,
        CU: bool | None = None,
        CD: bool | None = None,
        R: bool | None = None,
        LD: bool | None = None,
        PV: int | None = None,
    ) -> Self:
        if PV is not None:
            self._pv = PV
        if R is not None:
            self._r = True if R else False  # noqa: SIM210
        if LD is not None:
            self._ld = True if LD else False  # noqa: SIM210
        up = down = False
        if CU is not None:
            up = bool(CU and not self._cu)
            self._cu = True if CU else False  # noqa: SIM210
        if CD is not None:
            down = bool(CD and not self._cd)
            self._cd = True if CD else False  # noqa: SIM210
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

    __slots__ = ("Q", "_et_ns", "_in", "_pt", "_pt_ns", "_start_ns")

    def __init__(self, PT: float = 0.0) -> None:
        self.Q = False
        self._in = False
        self._pt = PT
        self._pt_ns = _ns(PT)
        self._start_ns = 0
        self._et_ns = 0

    @property
    def ET(self) -> float:  # noqa: N802 - the standard's name
        """Elapsed time, s."""
        return self._et_ns * 1e-9

    def _preset(self, PT: float) -> None:
        self._pt = PT
        self._pt_ns = _ns(PT)

    def _measure(self) -> bool:
        """Update ET of a running timer; whether PT has passed."""
        now = MOMENT.now_ns
        if now < 0:
            now_ns()  # says what is wrong
        passed = now - self._start_ns
        if passed >= self._pt_ns:
            self._et_ns = self._pt_ns if self._pt_ns > 0 else 0
            return True
        self._et_ns = passed if passed > 0 else 0
        return False


class TON(_Timer):
    """On-delay: Q follows IN when it has been TRUE for PT, and falls with IN.

    IN  ___┌─────────────┐____┌──┐___
    Q   ________┌────────┐___________
            PT
    """

    __slots__ = ()

    def __call__(self, IN: bool | None = None, PT: float | None = None) -> Self:
        if PT is not None and self._pt != PT:
            self._preset(PT)
        if IN is None:
            IN = self._in
        if not IN:
            self._in = self.Q = False
            self._et_ns = 0
            return self
        if not self._in:
            self._in = True
            self._start_ns = now_ns()
        if not self.Q:  # reached is reached, even if PT grows later
            self.Q = self._measure()
        return self


class TOF(_Timer):
    """Off-delay: Q rises with IN and falls when IN has been FALSE for PT.

    IN  ___┌──────┐__________┌──┐_┌──┐______
    Q   ___┌───────────┐_____┌────────────┐_
                    PT
    """

    __slots__ = ()

    def __call__(self, IN: bool | None = None, PT: float | None = None) -> Self:
        if PT is not None and self._pt != PT:
            self._preset(PT)
        if IN is None:
            IN = self._in
        if IN:
            self._in = self.Q = True
            self._et_ns = 0
            return self
        if self._in:
            self._in = False
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

    __slots__ = ()

    def __call__(self, IN: bool | None = None, PT: float | None = None) -> Self:
        if PT is not None and self._pt != PT:
            self._preset(PT)
        rising = False
        if IN is not None:
            rising = bool(IN and not self._in)
            self._in = True if IN else False  # noqa: SIM210
        if self.Q and self._measure():
            self.Q = False
        if rising and not self.Q:
            self._start_ns = now_ns()
            self.Q = not self._measure()
        if not self.Q and not self._in:
            self._et_ns = 0
        return self
