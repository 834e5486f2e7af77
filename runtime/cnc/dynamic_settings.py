"""What a program may set about the dynamics of its path: weights, limits, slope, transitions, overrides.

One frozen value holds all of it. The decoder replaces it, `blocks.DynamicsChange` carries it through the stages, and
`path_preparation.dynamic_limits` makes limits of it. Everything in mm or degrees and seconds, shares as factors.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum, IntEnum

Shares = tuple[float, ...]  # a factor per axis of the channel; () is 1 for all of them


class Slope(IntEnum):
    """How acceleration builds up on the path, with the values of P-CHAN-00071."""

    STEP = 0  # at once: limited acceleration, unlimited jerk
    TRAPEZ = 1  # with constant jerk
    SIN2 = 2  # as sin² over the ramp time
    HSC = 3  # trapezoidal, planned across blocks


class WeightedPart(Enum):
    """What weights of acceleration and of ramp time act on (P-CHAN-00001, P-CHAN-00073)."""

    ALL = 0
    SPEEDING_UP = 1
    BRAKING = 2


class LookAhead(IntEnum):
    """The limits of the path speed that G115 chooses, by the bits of its number; that of the axis velocities always holds."""

    TRANSITION = 2  # acceleration of the axes at block transitions
    CHORD = 4  # chord error on curves
    CURVE = 8  # acceleration of the axes on curves


ALL_LIMITS = int(LookAhead.TRANSITION | LookAhead.CHORD | LookAhead.CURVE)


@dataclass(frozen=True, slots=True)
class VectorLimits:
    """#VECTOR LIMIT: limits along the path that hold if they are smaller than what axes and contour allow."""

    acceleration: float = math.inf
    deceleration: float = math.inf
    radial_acceleration: float = math.inf
    radial_jerk: float = math.inf
    jerk: float = math.inf
    transition_acceleration: float = math.inf
    velocity: float = math.inf

    @property
    def unlimited(self) -> bool:
        return self == NO_LIMITS


NO_LIMITS = VectorLimits()


@dataclass(frozen=True, slots=True)
class MoveSettings:
    """What holds for the moves of one kind, G01 to G03 or G00.

    `acceleration` and `ramp_time` weight what the machine description gives. `override` is programmed for the path,
    `axis_override` for the axes: the least of those that move counts.
    """

    acceleration: Shares = ()
    ramp_time: Shares = ()
    override: float = 1.0
    axis_override: Shares = ()
    vector: VectorLimits = NO_LIMITS


_MOVES = MoveSettings()


class HoldUse(Enum):
    """What the path brakes with in feed hold, and at the signal of a probe."""

    CONFIGURED = 0  # the ramp of feed hold if the channel has one (P-CHAN-00097)
    AS_ELSE = 1  # as everywhere
    RAMP = 2  # the ramp of feed hold


class CornerFeedUnit(Enum):
    """What FEED of #CORNER PARAM means."""

    FWORD = "FWORD"  # a feed, in the unit of F
    PERCENT = "PERCENT"  # of the feed of the block


@dataclass(frozen=True, slots=True)
class CornerDeceleration:
    """#CORNER PARAM: over the last `distance` mm of a block the feed falls to `feed`, in mm/min or as a share."""

    distance: float
    unit: CornerFeedUnit
    feed: float

    def feed_of(self, programmed: float) -> float:
        """The feed in the corner for a programmed one, both mm/min; never more than that."""
        wanted = self.feed if self.unit is CornerFeedUnit.FWORD else self.feed * programmed
        return min(wanted, programmed)


@dataclass(frozen=True, slots=True)
class DynamicSettings:
    """All of it; the defaults are those of a channel without parameters.

    `velocity` weights the greatest velocity of the axes, `rapid_velocity` that of rapid traverse (G129; None: not programmed,
    else it takes the place of the weights by path length). `hold_*` weight the braking of feed hold. `late_braking`: a lower
    feed is reached behind the border (G901). `free_corners`: axes whose jump at corners limits nothing (G116).
    `least_transition`: #TRANSVELMIN, mm/s. `path_weights`, `curve_weights`: the tables of the channel parameters are in force.
    `by_axis`: names of the fields of weights that were programmed for single axes last.
    """

    slope: Slope = Slope.TRAPEZ
    feed: MoveSettings = _MOVES
    rapid: MoveSettings = _MOVES
    velocity: Shares = ()
    rapid_velocity: float | None = None
    geometric_ramp_time: float = 1.0
    hold_acceleration: Shares = ()
    hold_ramp_time: Shares = ()
    hold_use: HoldUse = HoldUse.CONFIGURED
    late_braking: bool = False
    look_ahead: int = ALL_LIMITS
    free_corners: frozenset[int] = frozenset()
    least_transition: float = 0.0
    weighted_acceleration: WeightedPart = WeightedPart.ALL
    weighted_ramps: WeightedPart = WeightedPart.ALL
    path_weights: int = 0  # bits: 1 for G00, 2 for G01
    curve_weights: bool = False
    corner: CornerDeceleration | None = None  # G13
    external_feed: float = 1.0  # #FF
    by_axis: frozenset[str] = frozenset()

    def of(self, rapid: bool) -> MoveSettings:
        """What holds for a rapid move, or for one at feed."""
        return self.rapid if rapid else self.feed

    def with_moves(self, rapid: bool, moves: MoveSettings) -> DynamicSettings:
        """The same with other settings for one kind of moves."""
        return replace(self, rapid=moves) if rapid else replace(self, feed=moves)


USUAL = DynamicSettings()


def share_of(shares: Shares, axis: int) -> float:
    """The factor of an axis."""
    return shares[axis] if shares else 1.0


def with_share(shares: Shares, axes: int, chosen: dict[int, float]) -> Shares:
    """Other factors for some of so many axes."""
    return tuple(chosen.get(axis, share_of(shares, axis)) for axis in range(axes))
