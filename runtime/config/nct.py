"""Parameters of the NCT dialect in the description of a channel, under the names that the control gives them.

Lengths in mm. `g`, `m`: which codes call which programs (G(9010) to G(9019), M(9000) to M(9009), M(9020) to M(9029)).
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator

from runtime.config.contradictions import Contradiction, ContradictionError
from runtime.config.model import Model, Several
from runtime.config.quantity_fields import Length, Velocity
from runtime.diagnostics.catalogue import nct as errors

RotaryAddress = Literal["A", "B", "C"]
StartCode = Literal["G00", "G01", "G17", "G18", "G20", "G21", "G90", "G91", "G94", "G95"]
_PAIRS = (("G00", "G01"), ("G17", "G18"), ("G20", "G21"), ("G90", "G91"), ("G94", "G95"))
_USUAL = ("G00", "G17", "G21", "G90", "G94")
DECIMALS = {"IS-A": 2, "IS-B": 3, "IS-C": 4}

_CALLS = (65.0, 66.0, 66.1, 67.0)
_PROGRAM_FLOW = (0, 1, 2, 30, 98, 99)

GCodeNumber = Annotated[float, Field(ge=-999.9, le=999.9)]
Common = Annotated[int, Field(ge=500, le=599)]


def _callable_g(codes: dict[int, float]) -> dict[int, float]:
    for program, code in codes.items():
        if not 9010 <= program <= 9019:
            raise ValueError(f"{program}: G codes call the programs 9010 to 9019")
        if abs(code) in _CALLS:
            raise ValueError(f"G{abs(code):g} is a macro call itself")
    return codes


def _callable_m(codes: dict[int, int]) -> dict[int, int]:
    for program, code in codes.items():
        if not (9000 <= program <= 9009 or 9020 <= program <= 9029):
            raise ValueError(f"{program}: M codes call the subprograms 9000 to 9009 and the macros 9020 to 9029")
        if not 1 <= code <= 999 or code in _PROGRAM_FLOW:
            raise ValueError(f"M{code} cannot call a program")
    return codes


class NctParameters(Model):
    """What the machine builder chooses for programs of the NCT dialect."""

    deltv: Annotated[Length, Field(ge=0)] = 0.0  # corner vectors nearer to each other in both axes become one
    interfer: bool = True  # cutter compensation looks whether the tool would run against the programmed direction,
    anglal: bool = True  # which is an error at once; false: vectors of the corners are left out until it does not
    abshort: Several[str] = ()  # axes that turn without end, and go the shorter way to absolute positions
    relround: Several[str] = ()  # axes that turn without end, of which incremental ways are less than a turn
    ang_accu: bool = False  # angles of G68 count in 0.00001 degrees, false: in 0.001
    retg73: Annotated[Length, Field(ge=0)] = 1.0  # G73: retraction between two cuts without E
    cleg83: Annotated[Length, Field(ge=0)] = 1.0  # G83: clearance over the last depth without E
    tapdwell: bool = False  # G74, G84: P is a dwell at the bottom
    index1: bool = False  # the spindle can follow the path: rigid tapping
    orient1: bool = False  # the spindle can be oriented: G76, G87 as back boring
    sbstm: bool = True  # macro blocks are executed while the block before them moves; else when it is done
    wrprot1: Common | None = None  # first and
    wrprot2: Common | None = None  # last of #500 to #599 that programs cannot write
    g: Annotated[dict[int, GCodeNumber], AfterValidator(_callable_g)] = Field(default_factory=dict)  # program: code
    m: Annotated[dict[int, int], AfterValidator(_callable_m)] = Field(default_factory=dict)
    t9034: bool = False  # T calls O9034, its value in #199
    a9030: bool = False  # A calls O9030, its value in #195, if it is an auxiliary function (miscel)
    b9031: bool = False  # B calls O9031, its value in #196
    c9032: bool = False  # C calls O9032, its value in #197
    s9033: bool = False  # S calls O9033, its value in #198
    fgmac: bool = False  # such codes call also within programs that they have called
    i_line: str = ""  # external variable (UNS16) with the inputs #1000 to #1015
    o_line: str = ""  # external variable (UNS16) with the outputs #1100 to #1115
    modgequ: bool = False  # modal G codes call in the place of each block, else behind each motion
    codes: Several[StartCode] = ()  # what holds at program start where the table of G codes leaves a choice
    increment: Literal["IS-A", "IS-B", "IS-C"] = "IS-B"  # input increment: 0.01, 0.001, 0.0001 mm or degrees
    feed: Velocity = 0.0  # at program start, 0: a program has to give one
    raddif: Length = 0.01  # by which the radii at start and end of an arc may differ
    helicalf: bool = False  # F holds on the path of a helix, and not on its circle
    second: bool = False  # G04 P are always seconds
    ctsurfsp: Annotated[float, Field(ge=0)] = 0.0  # m/min: constant surface speed of G96 before a program has given one
    axis: Literal["X", "Y", "Z", "U", "V", "W", "A", "B", "C"] = (
        "X"  # whose place G96 takes, before a program has given P
    )
    circover: Annotated[float, Field(gt=0, le=100)] = 10.0  # %: least share of F inside an arc with cutter compensation
    poscheck: bool = False  # exact stop behind G00
    skip: Annotated[Several[str], Field(max_length=4)] = ()  # inputs that are the skip signals 1 to 4 of G31
    skipf: bool = False  # G31 is driven with g31fd, and not with F
    g31fd: Velocity = 0.0  # feed of G31 with skipf
    feedmax: dict[str, Velocity] = Field(default_factory=dict)  # axis -> greatest feed, without override
    miscel: dict[RotaryAddress, Annotated[int, Field(ge=0)]] = Field(default_factory=dict)  # address -> H function

    @property
    def protected(self) -> tuple[int, int]:
        """First and last of the common variables that programs cannot write, (0, 0) for none."""
        first, last = self.wrprot1 or self.wrprot2, self.wrprot2 or self.wrprot1
        return (0, 0) if first is None or last is None else (first, last)

    @model_validator(mode="after")
    def _one_of_each_pair(self) -> NctParameters:
        for first, second in _PAIRS:
            if first in self.codes and second in self.codes:
                values = {"first": first, "second": second}
                raise ContradictionError([Contradiction(errors.START_CODES, ("codes",), values)])
        return self

    @property
    def start_codes(self) -> tuple[str, ...]:
        """One code of each pair."""
        return tuple(
            next((code for code in pair if code in self.codes), usual)
            for pair, usual in zip(_PAIRS, _USUAL, strict=True)
        )

    @property
    def decimals(self) -> int:
        """Decimals of a length in mm and of an angle; one more in inch."""
        return DECIMALS[self.increment]
