"""The blocks: what flows from the decoder through the preparation stages to the motion queue. Nothing else does.

Positions are machine coordinates of the channel's axes, in the order of the channel's axis list, shape (n_axes,), mm or
degrees. Feeds are mm/min or degrees/min, as programmed and after unit conversion; `math.inf` stands for rapid.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum, IntEnum, IntFlag
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.cnc.dynamic_settings import DynamicSettings
from runtime.cnc.filter_settings import FilterSettings
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.geometry.control_areas import ControlArea
from runtime.cnc.geometry.frames import Frame
from runtime.diagnostics.errors import ErrorEntry
from runtime.hli.axis_jobs import Job

Floats = npt.NDArray[np.float64]


class Synch(IntFlag):
    """Synchronisation types of technology functions, with the values of P-CHAN-00041 (channel parameters, line 1838)."""

    NOT_VALID = -1
    NO_SYNCH = 0x0
    MOS = 0x1
    MVS_SVS = 0x2
    MVS_SNS = 0x4
    MNS_SNS = 0x8
    MNE_SNS = 0x20
    MVS_SLM = 0x4000
    MVS_SLP = 0x8000
    PLC_INFO = 0x20000
    MOS_TS = 0x40000
    MEP_MOS = 0x100000
    MET_MOS = 0x200000
    BWD_SYNCH = 0x400000
    FWD_SYNCH = 0x800000
    MEP_SVS = 0x1000000
    MET_SVS = 0x2000000
    FAW_SYNCH = 0x10000000

    @property
    def kind(self) -> Synch:
        """The type without the flags that may stand beside it."""
        return self if self < 0 else Synch(int(self) & ~int(SYNCH_FLAGS))

    @property
    def flags(self) -> Synch:
        """The flags beside the type. (With NOT_VALID among its members `~` of this class is of no use.)"""
        return Synch(int(self) & int(SYNCH_FLAGS))


SYNCH_FLAGS = Synch.PLC_INFO | Synch.BWD_SYNCH | Synch.FWD_SYNCH | Synch.FAW_SYNCH
BY_PATH = Synch.MEP_MOS | Synch.MEP_SVS  # put out a distance ahead of their place
BY_TIME = Synch.MET_MOS | Synch.MET_SVS  # a time ahead of it
AHEAD = BY_PATH | BY_TIME
LATE = Synch.MVS_SLM | Synch.MVS_SLP  # waited for in a later block
MICRO_JOINTS = Synch.MOS | Synch.MOS_TS | Synch.MVS_SVS | Synch.MVS_SNS | Synch.MNS_SNS  # may be moved back on the path
# what is waited for at the end of the block in which it was put out
AT_BLOCK_END = Synch.MVS_SVS | Synch.MVS_SNS | Synch.MNS_SNS | Synch.MNE_SNS | Synch.MEP_SVS | Synch.MET_SVS


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


class CornerKind(Enum):
    """What is inserted between a motion and the next one in the plane."""

    CHAMFER_WIDTH = "G301"  # size: distance from the corner on each element
    CHAMFER_LENGTH = "#CHF"  # size: length of the inserted line
    ROUNDING = "G302"  # size: radius


@dataclass(frozen=True, slots=True)
class Corner:
    """A chamfer or rounding asked for at the end of a motion: `size` in mm, `feed` in mm/min, None for the usual one."""

    kind: CornerKind
    size: float
    feed: float | None = None


@dataclass(frozen=True, slots=True)
class Line:
    """A straight move of all axes; `end_pcs` are the programmed coordinates of the target.

    `plane` holds the indices of the two axes of the active plane. `end_feed` is the feed wanted at the end (E word).
    `pcs_gain` is machine way per programmed way: (n_axes,) for mirroring and scale, None for 1 in all axes, (n_axes, n_axes)
    where a rotated coordinate system is active (see `programmed_way`).
    """

    source: Source
    start: Floats
    end: Floats
    feed: float
    rapid: bool
    end_pcs: Floats
    plane: tuple[int, int] = (0, 1)
    corner: Corner | None = None
    end_feed: float | None = None
    override_off: bool = False  # G166: every override counts as 100 %
    pcs_gain: Floats | None = None

    def programmed(self, place: Floats) -> Floats:
        """Programmed coordinates of a place on the way, (n_axes,)."""
        return _programmed(self, place)


@dataclass(frozen=True, slots=True)
class Arc:
    """A circular arc or helix in a main plane; every axis outside the plane moves linearly over it.

    `plane` holds the indices of the two axes that span it, first and second by the right-hand rule (X Y, Z X, Y Z).
    `centre` is their machine coordinates, shape (2,). `angle` is the signed opening angle in degrees, counter-clockwise
    positive, several turns allowed. `pcs_gain` as in Line.
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
    corner: Corner | None = None
    end_feed: float | None = None
    override_off: bool = False
    pcs_gain: Floats | None = None

    def programmed(self, place: Floats) -> Floats:
        """Programmed coordinates of a place on the way, (n_axes,)."""
        return _programmed(self, place)


def _programmed(motion: Line | Arc, place: Floats) -> Floats:
    return motion.end_pcs + programmed_way(place - motion.end, motion.pcs_gain)


def programmed_way(way: Floats, gain: Floats | None) -> Floats:
    """Ways (n_axes,) or (k, n_axes) of the machine as they are programmed: one per axis by itself, or (n_axes, n_axes)."""
    if gain is None:
        return way
    if gain.ndim == 1:
        return way / gain
    made: Floats = np.asarray(np.linalg.solve(gain, way.T).T, dtype=np.float64)
    return made


def machine_way(way: Floats, gain: Floats | None) -> Floats:
    """The other direction: ways (n_axes,) or (k, n_axes) as they are programmed, on the machine."""
    if gain is None:
        return way
    made: Floats = way * gain if gain.ndim == 1 else way @ gain.T
    return made


@dataclass(frozen=True, slots=True)
class SpatialArc:
    """An arc in space: the path turns about `centre` from `start` by `angle` degrees around the unit vector `normal`.

    `start`, `end` (n_axes,); `centre`, `normal` (3,) in the first three axes. The other axes move linearly over it, and so does
    what of the way lies along the normal (a helix); more than one turn is allowed.
    """

    source: Source
    start: Floats
    end: Floats
    feed: float
    end_pcs: Floats
    centre: Floats
    normal: Floats
    angle: float
    pcs_gain: Floats | None = None  # as in Line


@dataclass(frozen=True, slots=True, eq=False)
class FrameChange:
    """The main axes of the motions from here on are those of `frame`, None: those of the machine.

    Behind the radius compensation, whose plane is one of the frame, they are mapped onto the machine
    (`path_preparation/frames.py`); it does not reach the queue. The place stays the same, so its numbers are other ones.
    """

    source: Source
    frame: Frame | None


@dataclass(frozen=True, slots=True)
class Polyline:
    """A run of straight moves, in arrays: CAM output never becomes a million objects.

    `points` (k + 1, n_axes) starts with the position before the first move. `feeds` (k,) in mm/min, inf for rapid.
    `lines` (k,) source lines; `numbers` (k,) block numbers, -1 where there is none. Programmed coordinates are
    (points - pcs_shift) / pcs_gain, equal over the run; the shift is (n_axes,), the gain as in Line. `plane`: the
    active plane, None where it is that of the motion before. `one_block`: the run is a curve of one NC block, in which
    single block does not stop.
    """

    program: str
    points: Floats
    feeds: Floats
    lines: npt.NDArray[np.int64]
    numbers: npt.NDArray[np.int64]
    pcs_shift: Floats
    pcs_gain: Floats | None = None
    plane: tuple[int, int] | None = None
    one_block: bool = False


@dataclass(frozen=True, slots=True)
class Polynomials:
    """A run of k polynomial elements: element i is q(u) = Σ coefficients[i, p] u^p, u from 0 to 1.

    `coefficients` (k, 6, n_axes), mm or degrees; each element begins where the one before ends. `feeds`, `lines`, `numbers`,
    `pcs_shift`, `pcs_gain`, `plane` as in Polyline. `block_ends` (k,): an NC block ends with the element. `end_feed` and
    `override_off` as in Line, for the whole run.
    """

    program: str
    coefficients: Floats
    feeds: Floats
    lines: npt.NDArray[np.int64]
    numbers: npt.NDArray[np.int64]
    block_ends: npt.NDArray[np.bool_]
    pcs_shift: Floats
    pcs_gain: Floats | None = None
    plane: tuple[int, int] | None = None
    end_feed: float | None = None
    override_off: bool = False
    constant_velocity: bool = False  # every element as slow as the slowest of the run
    check_jerk: bool = True  # False: the change of curvature may cause any jerk

    @property
    def start(self) -> Floats:
        """Where the run begins, (n_axes,)."""
        begin: Floats = self.coefficients[0, 0]
        return begin

    @property
    def ends(self) -> Floats:
        """Where each element ends, (k, n_axes)."""
        ends: Floats = self.coefficients.sum(axis=1)
        return ends


@dataclass(frozen=True, slots=True)
class TechnologyFunction:
    """An M, H, S or T function at its place on the path.

    It stands in the stream before the motion of its block if it is put out before it, after it otherwise; `synch` says
    when the path waits. For S, `value` is the speed in rev/min and `number` the M function (3, 4, 5, 19) or 0 for a new
    speed only; `spindle` is the index of the spindle among the channel's spindles, else -1. `area` is the index of the axis
    on whose interface it is put out, among all axes of the machine, -1 for the interface of the channel. `lead` is how far
    ahead of its place it is put out: mm for MEP and for micro-joints, seconds for MET types. `duration`: seconds that it is
    expected to take.
    For T `number` is the basic number of the tool; `sister` and `variant` are 0 for none.

    Of S: `angle` in degrees, where M19 stands; `sense` 3 or 4 the sense of its approach, or of a speed behind an M19 that M3
    or M4 is still modal for, else 0; `override_off` (G167); `plc_spindle` the logical axis number of a spindle that the PLC
    moves, else 0.
    """

    source: Source
    kind: Technology
    number: int
    value: float
    synch: Synch
    spindle: int = -1
    area: int = -1
    lead: float = 0.0
    duration: float = 0.0
    sister: int = 0
    variant: int = 0
    angle: float = 0.0
    sense: int = 0
    override_off: bool = False
    plc_spindle: int = 0


@dataclass(frozen=True, slots=True)
class MicroJointFeed:
    """#CHANNEL SET [M_PRE_OUTPUT]: of the next micro-joint, mm/min; `end_feed` where it begins, `feed` in it, None as programmed.

    `without_limits`: #VECTOR LIMIT does not count in it. Taken by the stage of micro-joints; it does not reach the queue.
    """

    source: Source
    end_feed: float | None = None
    feed: float | None = None
    without_limits: bool = False


@dataclass(frozen=True, slots=True)
class Wait:
    """Where the path waits for acknowledgements: for the functions of these types that were put out so far."""

    source: Source
    kinds: Synch = AT_BLOCK_END


@dataclass(frozen=True, slots=True)
class ExactStop:
    """The path stands here until every axis is within its window of standstill (G60, G360)."""

    source: Source


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


@dataclass(frozen=True, slots=True)
class StepEnd:
    """The end of an NC block without motion at which single step stops (P-CHAN-00015)."""

    source: Source


@dataclass(frozen=True, slots=True)
class StopMark:
    """#STOP REVERSIBLE: the path stops here until continue, if `level` is 0 or shares a bit with that of the PLC.

    `forward`, `again`, `backward`: whether it does for the first time, forward again, and backward. `user` is for the PLC.
    """

    source: Source
    level: int = 0
    forward: bool = True
    again: bool = True
    backward: bool = True
    user: int = 0


class LimitBehaviour(Enum):
    """What happens where the path leads beyond a software limit."""

    ERROR = "refused before it is driven"
    ERROR_LR = "a warning, and the path stops when the axis has got there"
    WARNING = "a warning"


@dataclass(frozen=True, slots=True)
class SoftwareLimitChange:
    """G98, G99, POS_LIMIT: the software limits from here on, (negative, positive) per axis, ±inf where there is none.

    `behaviour` per axis; () is ERROR for all. Taken by the stage that watches the limits, which hands on what the cycle watches.
    """

    source: Source
    limits: tuple[tuple[float, float], ...]
    behaviour: tuple[LimitBehaviour, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class ControlAreaChange:
    """#CONTROL AREA: these work and protection spaces are watched from here on; `tool` (n_axes,): offsets of the tool.

    Where the axes are without the offsets of the tool, its tip is. Taken by the stage that watches; it does not reach the queue.
    """

    source: Source
    areas: tuple[ControlArea, ...]
    tool: Floats
    told: tuple[ErrorEntry, ErrorEntry] | None = (
        None  # where a work space is left, a protection space entered; None: the usual
    )


@dataclass(frozen=True, slots=True)
class ActualLimit:
    """The actual position of an axis is watched from here on; ±inf: no longer. `stops`: the path stops beyond (ERROR_LR)."""

    source: Source
    axis: int
    low: float
    high: float
    stops: bool = False


class Approach(IntEnum):
    """How radius compensation begins and ends, by its G function."""

    TANGENTIAL = 5
    DIRECT = 138
    INDIRECT = 139
    ON_PATH = 236
    PERPENDICULAR = 237
    INSIDE_CORNER = 238
    WITHOUT_BLOCK = 239


@dataclass(frozen=True, slots=True)
class ApproachSplit:
    """#TRC SPLIT: the end of an approach, and the begin of an exit, in one or two segments with feeds of their own."""

    lengths: tuple[float, ...]  # mm; the last one lies at the contour
    feeds: tuple[float, ...]  # mm/min
    axis: int | None  # along which the lengths are measured, None: along the way in the plane
    entering: bool
    leaving: bool


@dataclass(frozen=True, slots=True)
class CompensationSettings:
    """What G functions and #TRC choose for radius compensation; the defaults are the initial state of a program."""

    circular: bool = False  # G26: arcs around outside corners
    adapt_feed: bool = False  # G11: F counts at the cutting edge,
    adapted_from: float = 0.0  # mm: on arcs from this programmed radius on (#TANGFEED)
    reverse: bool = False
    ignore_damage: bool = False  # IGNORE_CONT_DAMAGE
    extended_limit: bool = False  # EXT_ANGLE_BLOCK_INTERSECTION
    stretch: float = 1.0  # STRETCH_FACTOR, radii
    perpendicular_change: bool = False  # PERPENDICULAR_RADIUS_CHANGE
    line_on_path: bool = False  # G236_LIN
    suppress: bool = False  # SUPPRESS_TRC
    split: ApproachSplit | None = None  # SPLIT, SPLIT_PATH


@dataclass(frozen=True, slots=True)
class RadiusCompensation:
    """G40, G41, G42 and everything that changes while they hold: what is valid from here on.

    `side` is +1 where the tool runs left of the contour on the machine, -1 right of it, 0 on it. Taken by the stage of radius
    compensation; it does not reach the queue.
    """

    source: Source
    side: int
    approach: Approach
    plane: tuple[int, int]
    settings: CompensationSettings = CompensationSettings()


class VectorOrder(Enum):
    """What a block says about compensation by vectors."""

    SELECT = 1  # side and radius, from the next motion on
    HOLD = 2  # the next motion ends with the vector with which it begins
    CORNER_ARC = 3  # an arc around the next outside corner
    SUSPEND = 4  # the vector goes with the motion before, what follows is driven as it is
    RESUME = 5  # the next motion ends with a vector again


@dataclass(frozen=True, slots=True)
class VectorSettings:
    """How corners of compensation by vectors are looked after."""

    least_gap: float = 0.0  # mm: of two vectors nearer to each other in both axes, one is left out
    checked: bool = True  # motions against their programmed direction are found,
    repaired: bool = False  # and vectors left out until there are none
    inside_feed: float = (
        1.0  # on an arc that the tool follows on its inside F holds at the contour, at least this share of it
    )


@dataclass(frozen=True, slots=True)
class VectorCompensation:
    """Radius compensation that gives the end of every motion a vector: what holds from here on, or happens here.

    `offset` is how far the tool runs to the left of the contour on the machine, mm, negative to the right; with `active` and 0
    no vector is made, and the compensation goes on; without `active` it is over. `direction` is that of an auxiliary line
    in the plane of the machine. Taken by the stage of radius compensation; it does not reach the queue.
    """

    source: Source
    order: VectorOrder
    plane: tuple[int, int] = (0, 1)
    active: bool = True
    offset: float = 0.0
    direction: tuple[float, float] | None = None
    settings: VectorSettings = VectorSettings()


@dataclass(frozen=True, slots=True)
class DynamicsChange:
    """Other dynamic settings from here on; at program start those of the channel hold. It does not reach the queue."""

    source: Source
    settings: DynamicSettings


class ContourMethod(Enum):
    """How a corner is replaced by a curve (#CONTOUR MODE)."""

    DEVIATION = "DEV"
    DISTANCE = "DIST"
    SOFT = "DIST_SOFT"  # laid out for the acceleration of the axes
    POINT = "POS"  # through an interim point
    WHOLE = "PTP"  # as long as deviation and distance allow, its acceleration rises and falls steadily


class ContourAction(Enum):
    """Where the path is at the border between two blocks with a curve between them."""

    BEFORE = "PRE_ACTION"
    WITHIN = "INTER_ACTION"
    BEHIND = "POST_ACTION"


@dataclass(frozen=True, slots=True)
class Contouring:
    """Settings of contouring: lengths in mm, angles in degrees, shares from 0 to 1.

    `before`, `behind`: corner distances of DISTANCE, POINT and SOFT (infinite: not watched). `whole_deviation`,
    `whole_distance`: of WHOLE, infinite: not watched. `tracking_deviation`: 0 is not watched.
    `tracking_distance` (SOFT): infinite is not watched. `relevant`, `relevant_tracking`: shorter blocks are skipped.
    `remain`: share of a block that stays. `point`: machine coordinates of the main axes, the corner's own where None.
    `greatest_acceleration`, `least_acceleration`, `ramp_time`: of SOFT. `check_jerk` 0 lets curvature cause any jerk.
    """

    method: ContourMethod = ContourMethod.DEVIATION
    deviation: float = 1.0
    before: float = 1.0
    behind: float = 1.0
    whole_deviation: float = 1.0
    whole_distance: float = math.inf
    tracking_deviation: float = 0.0
    tracking_distance: float = 1.0
    relevant: float = 0.0
    relevant_tracking: float = 0.0
    remain: float = 0.0
    greatest_angle: float = 178.0
    point: tuple[float | None, float | None, float | None] = (None, None, None)
    greatest_acceleration: float = 1.0
    least_acceleration: float = 0.5
    ramp_time: float = 1.0
    check_jerk: int = 1
    constant_velocity: bool = False
    action: ContourAction = ContourAction.WITHIN


@dataclass(frozen=True, slots=True)
class ContourChange:
    """Contouring at the ends of the motions from here on, None: none. Taken by the stage; it does not reach the queue.

    `once`: for the motions of the line of `source` only. `keeps`: the corner before it is not concerned.
    """

    source: Source
    contouring: Contouring | None
    once: bool = False
    keeps: bool = False


class SplineKind(Enum):
    """Curves over the targets of straight moves."""

    AKIMA = "AKIMA"  # through the points
    BSPLINE = "BSPLINE"  # the points are control points
    HSC = "HSC"  # as BSPLINE, within a tolerance
    SURFACE = "SURFACE"  # as HSC, over a polygon that does not depend on where the points are
    INTERPOLATING = "OPMODE 2"  # as AKIMA, straight where the part is prismatic


class JoinedBy(Enum):
    """Where a curve that is interrupted is joined to its neighbours (P-CHAN-00239)."""

    NOTHING = 0
    CURVES = 1
    CURVES_AT_ARCS = 2


class Tangent(Enum):
    """Where the direction at the end of an Akima spline comes from."""

    AUTO = "AUTO"  # the points
    TANGENTIAL = "TANGENTIAL"  # the neighbouring motion
    USER = "USER"  # the program


@dataclass(frozen=True, slots=True)
class Spline:
    """A curve over the targets of straight moves; lengths in mm, angles in degrees.

    HSC: `deviation`, `tracking_deviation` 0 are not watched; where they are exceeded the curve follows the programmed path
    nearer to the corner, or with `sharp` (`sharp_tracking`) ends there. `merge`: short moves may become one. Moves longer
    than `longest` (0: none), rapid ones with `without_rapid`, and corners sharper than `greatest_angle` interrupt the curve, and
    moves in which other axes go more than `most_tracking` times as far as the main axes. `delayed`: the first motion is none of
    the curve. What interrupts it is `joined` to it by curves of contouring within the same tolerances.
    SURFACE: `rapid_deviation`, `rapid_tracking` count at corners between two rapid moves, None: no others. With `arcs` an arc of
    less than `least_angle` or `least_radius` is part of the curve, any other is joined to it smoothly; without, arcs end it.
    `check_jerk` 0 lets curvature cause any jerk.
    INTERPOLATING: a corner whose cosine is less than `least_cosine`, and a move longer than `longest_factor` times the median of
    the five before, are prismatic: straight, with corners rounded within `deviation`.
    AKIMA: `start`, `end`, and the vectors (n_axes,) of USER, NaN where an axis has none.
    """

    kind: SplineKind
    deviation: float = 0.0
    tracking_deviation: float = 0.0
    merge: bool = False
    sharp: bool = False
    sharp_tracking: bool = False
    without_rapid: bool = False
    longest: float = 0.0
    greatest_angle: float = 180.0
    most_tracking: float = math.inf
    delayed: bool = False
    joined: JoinedBy = JoinedBy.NOTHING
    start: Tangent = Tangent.AUTO
    end: Tangent = Tangent.AUTO
    start_vector: tuple[float, ...] | None = None
    end_vector: tuple[float, ...] | None = None
    rapid_deviation: float | None = None
    rapid_tracking: float | None = None
    arcs: bool = False
    least_angle: float = 30.0
    least_radius: float = 0.0
    check_jerk: int = 1
    least_cosine: float = 0.7
    longest_factor: float = 3.0


@dataclass(frozen=True, slots=True)
class SplineChange:
    """Straight moves from here on are a curve, None: what they are. Taken by the stage; it does not reach the queue."""

    source: Source
    spline: Spline | None


class ArcPieces(Enum):
    """What an arc becomes: lines of a length, lines within a chord error, arcs of a length."""

    LINES = 0
    CHORD_ERROR = 1
    ARCS = 2


@dataclass(frozen=True, slots=True)
class Segmentation:
    """#SEGMENTATION: lines in pieces of `length`, arcs as `mode` says; `parameter` is a length or a chord error, mm."""

    lines: bool = False
    length: float = 1.0
    arcs: bool = False
    mode: ArcPieces = ArcPieces.LINES
    parameter: float = 0.1


@dataclass(frozen=True, slots=True)
class SegmentationChange:
    """How motions are divided from here on. Taken by the stage; it does not reach the queue."""

    source: Source
    segmentation: Segmentation


@dataclass(frozen=True, slots=True)
class FilterChange:
    """The filters of the set-points (#FILTER) from here on; the path stands."""

    source: Source
    settings: FilterSettings


@dataclass(frozen=True, slots=True)
class ToolRadius:
    """The radius of the active tool from here on, mm; negative: the other side. A program starts with 0.

    For the compensation of the radius; it does not reach the queue.
    """

    source: Source
    radius: float


@dataclass(frozen=True, slots=True)
class AxisLimitChange:
    """What the axes of the channel may do from here on: weights, ramp times, slope types, groups, worked out.

    Taken by the queue writer; no record of its own reaches the queue.
    """

    source: Source
    limits: AxisLimits


class SpindleValue(IntEnum):
    """What a setting of a spindle is."""

    ACCELERATION = 0  # G130: share of the acceleration and jerk
    SPEED = 1  # OVERRIDE SPEED_FACT: share of the speed
    FEED_FORWARD = 2  # G135…G137: weight of the planned speed while positioning
    GEAR = 3  # G112, M40…M45: number of the stage, from 0
    HOMING = 4  # G74


@dataclass(frozen=True, slots=True)
class SpindleSetting:
    """A setting of a spindle when the path is here; `spindle` is its index among the channel's spindles."""

    source: Source
    spindle: int
    what: SpindleValue
    value: float


@dataclass(frozen=True, slots=True)
class RevolutionFeed:
    """G95: the feeds from here on were made with `speed` (rev/min) of a spindle, and follow what it really turns with; 0: they
    are what they are. Rapid moves are not concerned."""

    source: Source
    spindle: int = -1
    speed: float = 0.0


class SpindleRole(IntEnum):
    """How a section of the path and a spindle move together."""

    FREE = 0
    THREAD = 1  # G33: the path follows the angle of the spindle
    TAPPING = 2  # G63, G331, G332: the spindle follows the path


@dataclass(frozen=True, slots=True)
class SpindleSection:
    """A section begins, or with FREE ends, in which path and spindle move together; the path stands at both.

    `angle`: of a thread, where the spindle is when the path would begin if it needed no way to become so fast, degrees.
    `measured`: the path follows what is measured of the spindle and not what it is told, over so many `cycles` in the mean.
    `steady`: its override stays as it is in the section.
    """

    source: Source
    role: SpindleRole
    spindle: int
    angle: float = 0.0
    measured: bool = False
    cycles: int = 0
    steady: bool = False


@dataclass(frozen=True, slots=True)
class SpindleTurn:
    """In a section: the spindle turns by so many degrees per mm of path from here on; of a thread without sign."""

    source: Source
    per_mm: float


@dataclass(frozen=True, slots=True)
class CuttingSpeed:
    """G96: from here on the spindle turns as fast as `velocity` (mm/min) asks for at the distance of an axis from `centre`
    (machine coordinate, mm), at most with `limit` (rev/min, 0: what it can); a velocity of 0: as it turns now."""

    source: Source
    spindle: int
    velocity: float = 0.0
    axis: int = 0
    centre: float = 0.0
    limit: float = 0.0


@dataclass(frozen=True, slots=True)
class AxisJob:
    """A PLCopen job of an axis outside the path, handed over when the path is here; `axis` counts among those of the machine.

    `id`: by which the program can wait for it later, -1 for none. `waits`: the path waits for it at the end of the block.
    """

    source: Source
    axis: int
    job: Job
    id: int = -1
    waits: bool = False


@dataclass(frozen=True, slots=True)
class AxisJobWait:
    """The path waits here for the job with this id; with -1 for all that the block waits for."""

    source: Source
    id: int = -1


class FlushKind(Enum):
    """How the preparation is emptied into the interpolator."""

    STOP = "#FLUSH"  # the path stops briefly here, decoding goes on
    CONTINUE = "#FLUSH CONTINUE"  # everything before is handed over now, no stop is forced
    WAIT = "#FLUSH WAIT"  # decoding goes on when path, functions and messages have come this far


@dataclass(frozen=True, slots=True)
class Flush:
    """Hand over what was decoded so far. After WAIT the decoder is not asked for more until everything is done."""

    source: Source
    kind: FlushKind


@dataclass(frozen=True, slots=True)
class Hold:
    """Nothing to hand over now: the decoder waits for the outside (`reason`, in words) and is to be asked again later."""

    source: Source
    reason: str


class Receiver(Enum):
    """Who gets a message."""

    DIAGNOSIS = "ISG_DIAG_BED"
    HMI = "HMI"
    PLC = "PLC"
    EVENT_LOGGER = "EVENT_LOGGER"


@dataclass(frozen=True, slots=True)
class Message:
    """#MSG, #MSG INFO, #ADD at their place on the path; `acknowledge`: the path waits until the receiver has taken it.

    Messages of decoding time are no blocks: the decoder tells them to its `Outside`.
    """

    source: Source
    text: str
    receiver: Receiver = Receiver.DIAGNOSIS
    acknowledge: bool = False
    information: bool = False


@dataclass(frozen=True, slots=True)
class FeedForward:
    """Feed-forward control when the path is here: `shares` (n_axes,) of what the drives are described to get, 0…1."""

    source: Source
    shares: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Suppression:
    """What of the operator has no effect when the path is here, until the next one: feed hold (`feed_stop`), and every override,
    which counts as 100 %."""

    source: Source
    feed_stop: bool = False
    override: bool = False


class TimerCommand(Enum):
    START = "START"
    STOP = "STOP"
    CLEAR = "CLEAR"
    READ = "READ"


@dataclass(frozen=True, slots=True)
class TimerAction:
    """#TIMER … SYN: acts on counter `timer` (0…127) when the path is here."""

    source: Source
    command: TimerCommand
    timer: int


class LifeCommand(Enum):
    """What happens to the record of tool life."""

    CHANGE = "T"  # the record of the tool before is told, that of another tool begins
    READ = "#TOOL LIFE READ"  # it is told as that of a tool, and goes on
    REMOVE = "#TOOL LIFE REMOVE"  # it begins at 0
    DEFINE = "#TOOL LIFE DEF"  # it goes on from `time` and `distance`
    WEIGHT = "V.TLM"  # `time` and `distance` are factors from here on


@dataclass(frozen=True, slots=True)
class ToolLifeAction:
    """The record of tool life, when the path is here. `time` in s, `distance` in mm; factors for WEIGHT."""

    source: Source
    command: LifeCommand
    basic: int = 0
    sister: int = 0
    variant: int = 0
    time: float = 0.0
    distance: float = 0.0


@dataclass(frozen=True, slots=True)
class ExternalWrite:
    """A synchronous external variable gets its value when the path is here; `offset` in bytes into the V.E area.

    `kind` is its type name (BOOLEAN, SGN08 … REAL64, STRING); `size` in bytes; `value` a number or a text.
    """

    source: Source
    offset: int
    kind: str
    size: int
    value: float | str


@dataclass(frozen=True, slots=True)
class UserError:
    """#ERROR: an error of the program's own. `remedy_class` 0 warning, 2 error (reset), 7 fatal; `values` as told."""

    source: Source
    number: int
    remedy_class: int
    multiple: int
    values: tuple[float | str, ...] = ()
    meanings: tuple[int, ...] = ()
    further: tuple[float, ...] = ()
    text: str = ""  # what is told, if the program gives the whole of it


MANUAL_SHARE = 0.3  # of an axis' velocity, acceleration and jerk that is left to the hand beside the path (G201)


class ManualKind(Enum):
    """Who moves the axes."""

    EXCLUSIVE = "G200"  # the hand alone, until continue
    PARALLEL = "G201"  # the program, and the hand beside it
    END = "G202"  # the program alone


@dataclass(frozen=True, slots=True)
class ManualMotion:
    """From here on `axes` (indices) are moved as `kind` says. At EXCLUSIVE the decoder waits for where they are moved to."""

    source: Source
    kind: ManualKind
    axes: tuple[int, ...]


class ManualValue(Enum):
    """What a parameter of manual mode is of."""

    HANDWHEEL = "#HANDWHEEL"  # mm or degrees per pulse
    CONTINUOUS = "#JOG CONT"  # velocity
    INCREMENTAL = "#JOG INCR"  # width, velocity
    LIMITS = "#MANUAL LIMITS"  # negative, positive


@dataclass(frozen=True, slots=True)
class ManualParameter:
    """Parameters of manual mode of an axis, in mm or degrees and seconds; `stage` 1 to 3, 0 for limits."""

    source: Source
    axis: int
    what: ManualValue
    stage: int
    first: float
    second: float = 0.0


@dataclass(frozen=True, slots=True)
class Homing:
    """G74: the axes look for their reference; `ranks` (n_axes,): their turn from 1, 0 not at all. The decoder waits for it."""

    source: Source
    ranks: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class TakeOver:
    """The path goes on from where the axes were moved to by hand. The decoder waits for the place."""

    source: Source


@dataclass(frozen=True, slots=True)
class PositionSetting:
    """SET_POSITION: the axis stands at `value` from here on, or (`relative`) so much further; machine coordinates, mm or degrees.
    The decoder waits for it."""

    source: Source
    axis: int
    value: float
    relative: bool = False


@dataclass(frozen=True, slots=True)
class IndependentMotion:
    """INDP_SYN, INDP_ASYN: an axis of the channel goes to a machine position by itself, beside the path, which counts the axis
    at `target` from here on. mm or degrees, and seconds."""

    source: Source
    axis: int
    target: float
    velocity: float
    acceleration: float
    jerk: float


@dataclass(frozen=True, slots=True)
class IndependentWait:
    """The path waits here for own motions of these axes; `exact`: until they are in their windows."""

    source: Source
    axes: tuple[int, ...]
    exact: bool = False


class CoupledAxis(NamedTuple):
    """An axis that follows another one, by channel indices; `offset`: how far the slave is ahead, mm or degrees."""

    slave: int
    master: int
    offset: float


@dataclass(frozen=True, slots=True)
class CouplingChange:
    """#AX LINK ON and OFF: these are the axes that follow others from here on.

    `ends`: slaves whose coupling ends here, with where they stand; until here the path had them where it began.
    """

    source: Source
    coupled: tuple[CoupledAxis, ...]
    ends: tuple[tuple[int, float], ...] = ()


class ProbeSignal(IntEnum):
    """Where the signal of a probe comes from."""

    DRIVE = 1  # the drive latches the position
    INPUT = 2  # of the process image
    PLC = 3
    PLC_FIRST_EVENT = 4  # that of one axis counts for all of them
    PLC_TIMESTAMP = 5  # the PLC tells when it was


class Probe(NamedTuple):
    """The probe of an axis (channel index). `number`: touch probe of the drive, 1 or 2; `level`: bit of the process image that
    tells whether it is deflected, -1 none; `rising`: the edge, and the level that is deflected."""

    axis: int
    signal: ProbeSignal
    number: int = 0
    level: int = -1
    rising: bool = True


@dataclass(frozen=True, slots=True)
class Measurement:
    """What is driven from here to `MeasurementEnd` ends at the edge of a probe: the path brakes, and the rest is dropped; with
    `through` it goes on. The path stands at both places.

    `may_be_deflected`: a probe that is deflected already ends the run at once, else it is an error. `signal_needed`: a run
    without a signal is an error. `limited`: the run ends at a software limit.
    """

    source: Source
    probes: tuple[Probe, ...]
    through: bool = False
    may_be_deflected: bool = False
    signal_needed: bool = False
    limited: bool = False


@dataclass(frozen=True, slots=True)
class MeasurementEnd:
    """The end of a measuring run: what was measured is known behind it."""

    source: Source


@dataclass(frozen=True, slots=True)
class PathRestart:
    """The axes stand somewhere else than the last motion has ended: the next one begins there."""

    source: Source


@dataclass(frozen=True, slots=True)
class SearchMark:
    """Block search: the place that is looked for. Taken by the stage of the search; it does not reach the queue."""

    source: Source


@dataclass(frozen=True, slots=True)
class SearchArea:
    """#BLOCKSEARCH: from here on no program may be entered, or it may again. It does not reach the queue."""

    source: Source
    locked: bool


@dataclass(frozen=True, slots=True)
class DistanceMark:
    """#DIST TO GO: the section begins or ends for which the PLC is told what every axis has still to go."""

    source: Source
    begins: bool


@dataclass(frozen=True, slots=True)
class OptionalSection:
    """#OPTIONAL EXECUTION: a section begins or ends that is left out backward and in simulated motion.

    `simulate`: in simulated motion only; `mask`: only if it shares a bit with that of the PLC, None for any.
    """

    source: Source
    begins: bool
    simulate: bool = False
    mask: int | None = None


@dataclass(frozen=True, slots=True)
class ClearStorage:
    """#BACKWARD STORAGE CLEAR: nobody goes back over this place."""

    source: Source


class SearchStep(Enum):
    """Where a block search waits."""

    BEGIN = "the PLC knows that it begins"
    END = "the PLC has done everything that was left out"
    RETURN = "the axes may go back to the contour"
    GO_ON = "the program may go on"


@dataclass(frozen=True, slots=True)
class SearchGate:
    """A step of a block search. Behind BEGIN and RETURN the preparation waits until the cycle has passed it."""

    source: Source
    step: SearchStep
    automatic: bool = False  # nobody is asked


@dataclass(frozen=True, slots=True)
class SearchPlace:
    """The program goes on here: `way` mm and `blocks` ended blocks behind its start."""

    source: Source
    way: float
    blocks: int


Block = (
    Line
    | Arc
    | SpatialArc
    | FrameChange
    | Polyline
    | Polynomials
    | TechnologyFunction
    | MicroJointFeed
    | Wait
    | ExactStop
    | Dwell
    | Stop
    | BlockEnd
    | StepEnd
    | StopMark
    | SoftwareLimitChange
    | ControlAreaChange
    | ActualLimit
    | DynamicsChange
    | RadiusCompensation
    | VectorCompensation
    | ContourChange
    | SplineChange
    | SegmentationChange
    | FilterChange
    | ToolRadius
    | AxisLimitChange
    | Flush
    | Hold
    | Message
    | TimerAction
    | SpindleSetting
    | RevolutionFeed
    | SpindleSection
    | SpindleTurn
    | CuttingSpeed
    | FeedForward
    | Suppression
    | AxisJob
    | AxisJobWait
    | ToolLifeAction
    | ExternalWrite
    | UserError
    | ManualMotion
    | ManualParameter
    | Homing
    | TakeOver
    | PositionSetting
    | Measurement
    | MeasurementEnd
    | IndependentMotion
    | IndependentWait
    | CouplingChange
    | PathRestart
    | OptionalSection
    | DistanceMark
    | ClearStorage
    | SearchMark
    | SearchArea
    | SearchGate
    | SearchPlace
)
