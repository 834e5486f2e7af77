"""The blocks: what flows from the decoder through the preparation stages to the motion queue. Nothing else does.

Positions are machine coordinates of the channel's axes, in the order of the channel's axis list, shape (n_axes,), mm or
degrees. Feeds are mm/min or degrees/min, as programmed and after unit conversion; `math.inf` stands for rapid.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum, IntFlag

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


class Synch(IntFlag):
    """Synchronisation types of technology functions, with the values of P-CHAN-00041 (channel parameters, line 1838)."""

    NOT_VALID = -1
    NO_SYNCH = 0x0
    MOS = 0x1
    MVS_SVS = 0x2
    MVS_SNS = 0x4
    MNS_SNS = 0x8
    PLC_INFO = 0x20000


class Technology(IntEnum):
    """Kinds of technology functions, with the values of `fkt_ctrl_r` in the HLI."""

    M = 1
    H = 2
    S = 3
    T = 4


class StopKind(Enum):
    """Why a program stops by itself."""

    PROGRAMMED = "M00"
    OPTIONAL = "M01"
    PROGRAM_END = "M30"


@dataclass(frozen=True, slots=True)
class Source:
    """Where a block comes from: program name, line (from 1), and block number (N word) if it has one."""

    program: str
    line: int
    n: int | None = None


@dataclass(frozen=True, slots=True)
class Line:
    """A straight move of all axes. `start_pcs` and `end_pcs` are the programmed coordinates."""

    source: Source
    start: Floats
    end: Floats
    feed: float
    rapid: bool
    end_pcs: Floats


@dataclass(frozen=True, slots=True)
class Arc:
    """A circular arc or helix in a main plane; every axis outside the plane moves linearly over it.

    `plane` holds the indices of the two axes that span it, first and second by the right-hand rule (X Y, Z X, Y Z).
    `centre` is their machine coordinates, shape (2,). `angle` is the signed opening angle in degrees, counter-clockwise
    positive, several turns allowed.
    """

    source: Source
    start: Floats
    end: Floats
    feed: float
    end_pcs: Floats
    plane: tuple[int, int]
    centre: Floats
    radius: float
    angle: float


@dataclass(frozen=True, slots=True)
class Polyline:
    """A run of straight moves, in arrays: CAM output never becomes a million objects.

    `points` (k + 1, n_axes) starts with the position before the first move. `feeds` (k,) in mm/min, inf for rapid.
    `lines` (k,) source lines; `numbers` (k,) block numbers, -1 where there is none. `pcs_shift` (n_axes,): machine minus
    programmed coordinates, equal over the run.
    """

    program: str
    points: Floats
    feeds: Floats
    lines: npt.NDArray[np.int64]
    numbers: npt.NDArray[np.int64]
    pcs_shift: Floats


@dataclass(frozen=True, slots=True)
class TechnologyFunction:
    """An M, H, S or T function at its place on the path.

    It stands in the stream before the motion of its block if it is put out before it, after it otherwise; `synch` says
    when the path waits. For S, `value` is the speed in rev/min and `number` the M function (3, 4, 5, 19) or 0 for a new
    speed only; `spindle` is the index of the spindle among the channel's spindles, else -1.
    """

    source: Source
    kind: Technology
    number: int
    value: float
    synch: Synch
    spindle: int = -1


@dataclass(frozen=True, slots=True)
class Wait:
    """Where the path waits for acknowledgements.

    `before` stands in front of the block's motion and waits for the MVS_SVS functions put out so far; otherwise it stands behind
    the motion and waits for every function put out so far.
    """

    source: Source
    before: bool = False


@dataclass(frozen=True, slots=True)
class Dwell:
    """Standstill for `seconds` (G04)."""

    source: Source
    seconds: float


@dataclass(frozen=True, slots=True)
class Stop:
    """M00, M01 or the end of the program."""

    source: Source
    kind: StopKind


@dataclass(frozen=True, slots=True)
class BlockEnd:
    """The end of an NC block that has motion: where single block stops."""

    source: Source


Block = Line | Arc | Polyline | TechnologyFunction | Wait | Dwell | Stop | BlockEnd
