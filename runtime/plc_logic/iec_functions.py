"""The standard functions of IEC 61131-3: selection, comparison, numbers, bits, strings, under their names.

Python has its own words for most of them (`min`, `<<`, slices); these are for who thinks in the standard, and where the two
differ: shifts within a width, positions of strings from 1, DIV and MOD of whole numbers towards zero.
"""

from __future__ import annotations

import itertools
import math
from typing import TypeVar

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.plc_logic.errors import PlcError

T = TypeVar("T")
N = TypeVar("N", int, float, str)

# --------------------------------------------------------------------------------------------- selection (table 33)


def SEL(G: bool, IN0: T, IN1: T) -> T:  # noqa: N802
    """IN1 if G, else IN0."""
    return IN1 if G else IN0


def MUX(K: int, *inputs: T) -> T:  # noqa: N802
    """The input number K, from 0. Raises PlcError for a K without input."""
    if not 0 <= K < len(inputs):
        raise PlcError(catalogue.PLC_ARGUMENT, function="MUX", what=f"there is no input {K} of {len(inputs)}")
    return inputs[K]


def LIMIT(MN: N, IN: N, MX: N) -> N:  # noqa: N802
    """IN, but not below MN and not above MX."""
    return min(max(IN, MN), MX)


def MAX(*inputs: N) -> N:  # noqa: N802
    return max(inputs)


def MIN(*inputs: N) -> N:  # noqa: N802
    return min(inputs)


# --------------------------------------------------------------------------------------------- comparison (table 33)


def GT(*inputs: N) -> bool:  # noqa: N802
    """Each is greater than the next."""
    return all(a > b for a, b in itertools.pairwise(inputs))


def GE(*inputs: N) -> bool:  # noqa: N802
    """Each is the next or greater."""
    return all(a >= b for a, b in itertools.pairwise(inputs))


def EQ(*inputs: N) -> bool:  # noqa: N802
    """All are the same."""
    return all(a == b for a, b in itertools.pairwise(inputs))


def LE(*inputs: N) -> bool:  # noqa: N802
    """Each is the next or less."""
    return all(a <= b for a, b in itertools.pairwise(inputs))


def LT(*inputs: N) -> bool:  # noqa: N802
    """Each is less than the next."""
    return all(a < b for a, b in itertools.pairwise(inputs))


def NE(IN1: N, IN2: N) -> bool:  # noqa: N802
    return IN1 != IN2


# --------------------------------------------------------------------------------------------- numbers (tables 28, 29)


def DIV(IN1: float, IN2: float) -> float:  # noqa: N802
    """Whole numbers: towards zero, 7 DIV -2 = -3; others as usual. Raises PlcError for a division by 0."""
    if IN2 == 0:
        raise PlcError(catalogue.PLC_ARGUMENT, function="DIV", what="division by 0")
    if isinstance(IN1, int) and isinstance(IN2, int):
        quotient = abs(IN1) // abs(IN2)
        return quotient if (IN1 < 0) == (IN2 < 0) else -quotient
    return IN1 / IN2


def MOD(IN1: int, IN2: int) -> int:  # noqa: N802
    """What DIV leaves, with the sign of IN1; IN2 = 0 gives 0 (table 29)."""
    return 0 if IN2 == 0 else IN1 - IN2 * int(DIV(IN1, IN2))


def TRUNC(IN: float) -> int:  # noqa: N802
    """The whole part, towards zero."""
    return math.trunc(IN)


def EXPT(IN1: float, IN2: float) -> float:  # noqa: N802
    """IN1 to the power of IN2. Raises PlcError where there is none."""
    try:
        return math.pow(IN1, IN2)
    except (ValueError, OverflowError):
        what = f"there is no {IN1} to the power of {IN2}"
        raise PlcError(catalogue.PLC_ARGUMENT, function="EXPT", what=what) from None


def SQRT(IN: float) -> float:  # noqa: N802
    """Raises PlcError below 0."""
    if IN < 0:
        raise PlcError(catalogue.PLC_ARGUMENT, function="SQRT", what=f"{IN} is below 0")
    return math.sqrt(IN)


def SIGN(IN: float) -> int:  # noqa: N802
    """-1, 0 or 1."""
    return (IN > 0) - (IN < 0)


def SCALE(IN: float, IN_MIN: float, IN_MAX: float, OUT_MIN: float, OUT_MAX: float) -> float:  # noqa: N802
    """Straight line through two points: 4...20 mA to 0...10 bar. Not limited. Raises PlcError if the points are one."""
    if IN_MAX == IN_MIN:
        raise PlcError(catalogue.PLC_ARGUMENT, function="SCALE", what=f"IN_MIN and IN_MAX are both {IN_MIN}")
    return OUT_MIN + (IN - IN_MIN) * (OUT_MAX - OUT_MIN) / (IN_MAX - IN_MIN)


def CHARCURVE(IN: float, *points: tuple[float, float]) -> float:  # noqa: N802
    """Straight lines between points (x, y) with rising x; outside the first or last y."""
    if not points or any(a[0] >= b[0] for a, b in itertools.pairwise(points)):
        raise PlcError(catalogue.PLC_ARGUMENT, function="CHARCURVE", what="the x of the points have to rise")
    if points[0][0] >= IN:
        return points[0][1]
    for (x0, y0), (x1, y1) in itertools.pairwise(points):
        if x1 >= IN:
            return y0 + (IN - x0) * (y1 - y0) / (x1 - x0)
    return points[-1][1]


# --------------------------------------------------------------------------------------------- bits (table 30)


def _mask(width: int) -> int:
    if width not in (1, 8, 16, 32, 64):
        raise PlcError(catalogue.PLC_ARGUMENT, function="bit string", what=f"width {width} is none of 1, 8, 16, 32, 64")
    return (1 << width) - 1


def _count(function: str, N: int) -> int:
    if N < 0:
        raise PlcError(catalogue.PLC_ARGUMENT, function=function, what=f"N is {N}; it may not be below 0")
    return N


def SHL(IN: int, N: int, width: int = 32) -> int:  # noqa: N802
    """IN shifted left by N bits within `width` (8, 16, 32, 64) bits, filled with 0."""
    mask = _mask(width)
    return (IN & mask) << min(_count("SHL", N), width) & mask


def SHR(IN: int, N: int, width: int = 32) -> int:  # noqa: N802
    """IN shifted right, filled with 0."""
    return (IN & _mask(width)) >> min(_count("SHR", N), width)


def ROL(IN: int, N: int, width: int = 32) -> int:  # noqa: N802
    """IN rotated left by N bits."""
    mask, N = _mask(width), _count("ROL", N) % width
    IN &= mask
    return (IN << N | IN >> (width - N)) & mask


def ROR(IN: int, N: int, width: int = 32) -> int:  # noqa: N802
    """IN rotated right."""
    return ROL(IN, width - _count("ROR", N) % width, width)


def NOT(IN: int, width: int = 32) -> int:  # noqa: N802
    """Every bit of `width` turned round (`width` 1: a BOOL)."""
    return ~IN & _mask(width)


def BIT(IN: int, N: int) -> bool:  # noqa: N802
    """Bit N, from 0."""
    return bool(IN >> _count("BIT", N) & 1)


def SET_BIT(IN: int, N: int, value: bool = True) -> int:  # noqa: N802
    """IN with bit N set to `value`."""
    return IN | 1 << _count("SET_BIT", N) if value else IN & ~(1 << _count("SET_BIT", N))


def PACK(*bits: bool) -> int:  # noqa: N802
    """The number whose bits they are, the lowest first."""
    return sum(1 << i for i, bit in enumerate(bits) if bit)


def UNPACK(IN: int, count: int = 8) -> tuple[bool, ...]:  # noqa: N802
    """The bits of a number, the lowest first."""
    return tuple(bool(IN >> i & 1) for i in range(_count("UNPACK", count)))


def GRAY_TO_INT(IN: int) -> int:  # noqa: N802
    """Of an encoder with Gray code."""
    shift = 1
    while IN >> shift:
        IN ^= IN >> shift
        shift *= 2
    return IN


def INT_TO_GRAY(IN: int) -> int:  # noqa: N802
    return IN ^ IN >> 1


# --------------------------------------------------------------------------------------------- strings (table 34)


def _place(function: str, text: str, L: int, P: int) -> tuple[int, int]:
    """Begin and end of L characters from position P; what lies outside of the text is an error (6.6.2.5.12)."""
    if L < 0 or P < 1 or len(text) < P + L - 1:
        what = f"{L} characters from position {P} do not lie in a text of {len(text)}"
        raise PlcError(catalogue.PLC_ARGUMENT, function=function, what=what)
    return P - 1, P - 1 + L


def LEN(IN: str) -> int:  # noqa: N802
    return len(IN)


def LEFT(IN: str, L: int) -> str:  # noqa: N802
    """The first L characters."""
    begin, end = _place("LEFT", IN, L, 1)
    return IN[begin:end]


def RIGHT(IN: str, L: int) -> str:  # noqa: N802
    """The last L characters."""
    begin, end = _place("RIGHT", IN, L, len(IN) - L + 1)
    return IN[begin:end]


def MID(IN: str, L: int, P: int) -> str:  # noqa: N802
    """L characters from position P, which counts from 1."""
    begin, end = _place("MID", IN, L, P)
    return IN[begin:end]


def CONCAT(*texts: str) -> str:  # noqa: N802
    return "".join(texts)


def INSERT(IN1: str, IN2: str, P: int) -> str:  # noqa: N802
    """IN2 put into IN1 after position P; P = 0 puts it in front."""
    if not 0 <= P <= len(IN1):
        what = f"there is no position {P} in a text of {len(IN1)}"
        raise PlcError(catalogue.PLC_ARGUMENT, function="INSERT", what=what)
    return IN1[:P] + IN2 + IN1[P:]


def DELETE(IN: str, L: int, P: int) -> str:  # noqa: N802
    """IN without L characters from position P."""
    begin, end = _place("DELETE", IN, L, P)
    return IN[:begin] + IN[end:]


def REPLACE(IN1: str, IN2: str, L: int, P: int) -> str:  # noqa: N802
    """IN1 with IN2 in the place of L characters from position P."""
    begin, end = _place("REPLACE", IN1, L, P)
    return IN1[:begin] + IN2 + IN1[end:]


def FIND(IN1: str, IN2: str) -> int:  # noqa: N802
    """Position from 1 where IN2 begins in IN1 for the first time; 0 if it does not."""
    return IN1.find(IN2) + 1 if IN2 else 0
