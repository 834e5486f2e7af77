"""From what the machine can do to what the program allows: weights, slopes, path limits, corners (see dynamic_settings).

    axis limits ─ weights of the program, of path length or radius ─▶ limits of a kind of move ─ dynamics ─▶ v, a, j, v_entry
                                                                                                   └ path limits, G115…G117

Moves of one kind (feed or rapid, row of the weight table) share their limits. A run of lines is cut where the kind changes;
over such a border, and where the settings have changed, the lower of both corner speeds counts.

No weight exceeds what the machine description gives. With the slope STEP the acceleration may jump: within one cycle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

import numpy as np
import numpy.typing as npt

from runtime.cnc.dynamic_settings import (
    ALL_LIMITS,
    USUAL,
    DynamicSettings,
    LookAhead,
    MoveSettings,
    Shares,
    Slope,
    WeightedPart,
)
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.path_preparation.dynamics import TANGENTIAL, Border, Dynamics, arc_dynamics, line_dynamics
from runtime.cnc.path_preparation.weight_tables import PathWeights

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
Ints = npt.NDArray[np.int64]
Factors = tuple[float, float, float]  # of velocity, acceleration, ramp time

LEAST_VELOCITY = 1e-3  # mm/s: what the weight 0 leaves (programming manual lines 5033, 5089)
LEAST_WEIGHT = 0.01  # of acceleration and ramp time (channel parameters line 6332)
SIN2_MEAN = 2.0 / math.pi  # of its greatest jerk: sin² takes so much longer for the same change of acceleration
UNLIMITED = 1e9  # mm/s², mm/s³ … of an axis that limits nothing
_NONE: Factors = (1.0, 1.0, 1.0)
_RAPID_PATHS, _FEED_PATHS = 1, 2  # bits of P-CHAN-00190


@dataclass(frozen=True, slots=True)
class ArcGeometry:
    """What `arc_dynamics` needs to know of an arc: radians, mm; `linear` (n,): way of the axes outside the plane."""

    plane: tuple[int, int]
    begin: float
    angle: float
    radius: float
    linear: Floats
    length: float


@dataclass(frozen=True, slots=True)
class PathLimits:
    """What the program itself allows along the path, in mm and s."""

    velocity: float = math.inf
    acceleration: float = math.inf
    deceleration: float = math.inf
    jerk: float = math.inf


ANY = PathLimits()


@dataclass(frozen=True, slots=True)
class Kind:
    """Successive elements that share their limits: how many, those of the axes, and those along the path."""

    count: int
    axes: AxisLimits
    path: PathLimits = ANY


@dataclass(frozen=True, slots=True)
class Limited:
    """Limits of successive elements, how the last one ends, and where the limits come from."""

    dynamics: Dynamics
    after: Border
    kinds: list[Kind]


def _array(shares: Shares, n: int) -> Floats:
    return np.array(shares) if shares else np.ones(n)


class DynamicLimits:
    """The limits of the elements of one program; `change` follows its settings.

    `limits`: of the axes, from the machine description; `period` of the cycle, s.
    """

    def __init__(self, limits: AxisLimits, period: float, weights: PathWeights | None = None) -> None:
        self._machine = limits
        self._period = period
        self._weights = weights or PathWeights()
        self._settings = USUAL
        self._kept: dict[tuple[bool, Factors], AxisLimits] = {}
        self._before: AxisLimits | None = None  # of the element before
        self._plain = True

    @property
    def settings(self) -> DynamicSettings:
        return self._settings

    def change_axes(self, limits: AxisLimits) -> None:
        """The axes can do something else from here on."""
        self._machine = limits
        self._kept.clear()

    @property
    def kinds(self) -> int:
        """How many different sets of axis limits the elements may need under the present settings."""
        return 1 if self._plain else 2 * (len(self._weights.by_length.limits) + len(self._weights.by_radius.limits) + 1)

    def change(self, settings: DynamicSettings) -> None:
        """Other settings hold from here on."""
        self._settings = settings
        self._kept.clear()
        self._plain = settings == USUAL and not self._weights.by_length.limits

    # ------------------------------------------------------------------ limits of a kind of move

    def axis_limits(self, rapid: bool, factors: Factors = _NONE) -> AxisLimits:
        """What the axes may do in moves of a kind; `factors` of a weight table."""
        if self._plain and factors == _NONE:
            return self._machine
        key = rapid, factors
        found = self._kept.get(key)
        if found is None:
            found = self._kept[key] = self._weighted(rapid, factors)
        return found

    def _weighted(self, rapid: bool, factors: Factors) -> AxisLimits:
        settings, machine, n = self._settings, self._machine, self._machine.n
        moves = settings.of(rapid)
        velocity = machine.velocity * np.minimum(_array(settings.velocity, n), 1.0)
        if rapid and settings.rapid_velocity is not None:
            velocity = np.minimum(velocity, machine.velocity * settings.rapid_velocity)
        velocity = np.maximum(
            np.minimum(velocity * factors[0], machine.velocity), np.minimum(LEAST_VELOCITY, machine.velocity)
        )
        share = np.clip(_array(moves.acceleration, n) * factors[1], LEAST_WEIGHT, 1.0)
        ramp = np.maximum(_array(moves.ramp_time, n) * factors[2], LEAST_WEIGHT)
        ones = np.ones(n)
        up = share if settings.weighted_acceleration is not WeightedPart.BRAKING else ones
        down = share if settings.weighted_acceleration is not WeightedPart.SPEEDING_UP else ones
        ramp_up = ramp if settings.weighted_ramps is not WeightedPart.BRAKING else ones
        ramp_down = ramp if settings.weighted_ramps is not WeightedPart.SPEEDING_UP else ones
        acceleration, deceleration = machine.acceleration * up, machine.deceleration * down
        return AxisLimits(
            velocity,
            acceleration,
            self._jerk(machine.jerk, up / ramp_up, acceleration),
            machine.velocity_step * share,
            deceleration,
            self._jerk(machine.braking_jerk, down / ramp_down, deceleration),
        )

    def _jerk(self, greatest: Floats, factor: Floats, acceleration: Floats) -> Floats:
        """The jerk of the slope: acceleration over ramp time, never above what the axis may have. STEP: over a cycle."""
        if self._settings.slope is Slope.STEP:
            return acceleration / self._period
        jerk: Floats = greatest * np.minimum(factor, 1.0)
        return jerk * SIN2_MEAN if self._settings.slope is Slope.SIN2 else jerk

    def _for_entry(self, limits: AxisLimits, curve: bool) -> AxisLimits:
        """The limits that count for corner speeds; `curve`: that of an arc."""
        settings = self._settings
        free = np.zeros(limits.n, dtype=np.bool_)
        free[[axis for axis in settings.free_corners if axis < limits.n]] = True
        if not settings.look_ahead & LookAhead.TRANSITION:
            free[:] = True
        unlimited = free | (curve and not settings.look_ahead & LookAhead.CURVE)
        return replace(
            limits,
            acceleration=np.where(unlimited, UNLIMITED, limits.acceleration),
            jerk=np.where(unlimited, UNLIMITED / self._period, limits.jerk),
            deceleration=np.where(unlimited, UNLIMITED, limits.deceleration),
            braking_jerk=np.where(unlimited, UNLIMITED / self._period, limits.braking_jerk),
            velocity_step=np.where(free, UNLIMITED, limits.velocity_step),
        )

    def _entry_differs(self, curve: bool) -> bool:
        settings = self._settings
        chosen = settings.look_ahead
        return (
            bool(settings.free_corners) or not chosen & LookAhead.TRANSITION or (curve and not chosen & LookAhead.CURVE)
        )

    # ------------------------------------------------------------------ feeds

    def override(self, rapid: bool, moving: Flags) -> Floats:
        """The programmed override of moves (k,) whose axes `moving` (k, n) say: path override times the least of the axes."""
        moves = self._settings.of(rapid)
        least = np.ones(len(moving))
        if moves.axis_override:
            least = np.where(moving, np.array(moves.axis_override), np.inf).min(axis=1)
        return np.where(np.isfinite(least), least, 1.0) * moves.override

    def overrides_nothing(self) -> bool:
        """No override is programmed."""
        feed, rapid = self._settings.feed, self._settings.rapid
        return feed.override == rapid.override == 1.0 and not feed.axis_override and not rapid.axis_override

    # ------------------------------------------------------------------ lines

    def lines(
        self, direction: Floats, length: Floats, main: Flags, feed: Floats, rapid: Flags, before: Border | None
    ) -> Limited:
        """Limits of k successive lines, as `line_dynamics`; `feed` (k,) per s, `rapid` (k,)."""
        if self._plain:
            limits = self._machine
            found = line_dynamics(limits, self._period, direction, length, main, feed, before)
            found = self._lower_entry(found, direction, length, main, feed, before, limits)
            return Limited(*found, [Kind(len(length), limits)])
        rows = self._rows(length, rapid)
        cuts = np.flatnonzero((np.diff(rows) != 0) | (np.diff(rapid) != 0)) + 1
        parts: list[Dynamics] = []
        kinds: list[Kind] = []
        for begin, end in zip([0, *cuts.tolist()], [*cuts.tolist(), len(length)], strict=True):
            part = slice(begin, end)
            is_rapid = bool(rapid[begin])
            factors = self._weights.by_length.factors[rows[begin]] if rows[begin] >= 0 else _NONE
            found = self._part(is_rapid, factors, direction[part], length[part], main[part], feed[part], before)
            parts.append(found[0])
            path = self._along_path(self._settings.of(is_rapid), on_arc=False)
            kinds.append(Kind(end - begin, self.axis_limits(is_rapid, factors), path))
            before = found[1]
        assert before is not None
        if len(parts) == 1:
            return Limited(parts[0], before, kinds)
        names = [field.name for field in fields(Dynamics)]
        joined = Dynamics(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))
        return Limited(joined, before, kinds)

    def _rows(self, length: Floats, rapid: Flags) -> Ints:
        """The row of the weights by path length of each move, -1 without."""
        active = self._settings.path_weights
        rows = self._weights.by_length.row(length)
        if not active & _FEED_PATHS:
            rows[~rapid] = -1
        if not active & _RAPID_PATHS or self._settings.rapid_velocity is not None:
            rows[rapid] = -1
        return rows

    def _part(
        self,
        rapid: bool,
        factors: Factors,
        direction: Floats,
        length: Floats,
        main: Flags,
        feed: Floats,
        before: Border | None,
    ) -> tuple[Dynamics, Border]:
        """Lines of one kind."""
        limits = self.axis_limits(rapid, factors)
        arguments = (direction, length, main, feed, before)
        found = line_dynamics(limits, self._period, *arguments)
        found = self._lower_entry(found, *arguments, limits)
        dynamics, after = found
        if self._entry_differs(curve=False):
            free, _ = line_dynamics(self._for_entry(limits, curve=False), self._period, *arguments)
            dynamics = replace(dynamics, v_entry=free.v_entry, v_corner=free.v_corner)
        first = direction[:1] if before is None else before.direction[None, :]
        turn = direction - np.concatenate([first, direction[:-1]])
        kept = main == np.concatenate([[main[0] if before is None else before.main], main[:-1]])
        if before is None:
            kept[0] = False
        return self._path_limits(dynamics, self._settings.of(rapid), turn, kept, on_arc=False), after

    def _lower_entry(
        self,
        found: tuple[Dynamics, Border],
        direction: Floats,
        length: Floats,
        main: Flags,
        feed: Floats,
        before: Border | None,
        limits: AxisLimits,
    ) -> tuple[Dynamics, Border]:
        """Where the element before had other limits: the first corner is passed as both of them allow."""
        other, self._before = self._before, limits
        if other is None or other is limits:
            return found
        dynamics, after = found
        first = slice(0, 1)
        if self._entry_differs(curve=False):
            other = self._for_entry(other, curve=False)
        there, _ = line_dynamics(other, self._period, direction[first], length[first], main[first], feed[first], before)
        dynamics.v_entry[0] = min(dynamics.v_entry[0], there.v_entry[0])
        dynamics.v_corner[0] = min(dynamics.v_corner[0], there.v_corner[0])
        return dynamics, after

    # ------------------------------------------------------------------ arcs

    def arc(self, arc: ArcGeometry, feed: float, before: Border | None) -> Limited:
        """Limits of an arc or helix, arrays of shape (1,); `feed` per s, inf for rapid."""
        rapid = math.isinf(feed)
        factors = _NONE
        if self._settings.curve_weights and self._weights.by_radius.limits:
            row = int(self._weights.by_radius.row(np.array([arc.radius]))[0])
            velocity, acceleration, ramp = self._weights.by_radius.factors[row]
            factors = (min(velocity, 1.0), min(acceleration, 1.0), ramp)
        limits = self.axis_limits(rapid, factors)
        dynamics, after = self._arc(limits, arc, feed, before)
        other, self._before = self._before, limits
        if self._plain and (other is None or other is limits):
            return Limited(dynamics, after, [Kind(1, limits)])
        if self._entry_differs(curve=True):
            free, _ = self._arc(self._for_entry(limits, curve=True), arc, feed, before)
            v_limit = dynamics.v_limit if self._settings.look_ahead & LookAhead.CURVE else free.v_limit
            dynamics = replace(dynamics, v_entry=free.v_entry, v_corner=free.v_corner, v_limit=v_limit)
        if other is not None and other is not limits:
            if self._entry_differs(curve=True):
                other = self._for_entry(other, curve=True)
            there, _ = self._arc(other, arc, feed, before)
            dynamics = replace(
                dynamics,
                v_entry=np.minimum(dynamics.v_entry, there.v_entry),
                v_corner=np.minimum(dynamics.v_corner, there.v_corner),
            )
        if self._settings.geometric_ramp_time > 1.0 and self._settings.slope is not Slope.STEP:
            longer = self._settings.geometric_ramp_time
            slower = replace(limits, jerk=limits.jerk / longer, braking_jerk=limits.braking_jerk / longer)
            across, _ = self._arc(slower, arc, feed, before)
            dynamics = replace(
                dynamics,
                v_limit=np.minimum(dynamics.v_limit, across.v_limit),
                a_limit=np.minimum(dynamics.a_limit, across.a_limit),
                v_entry=np.minimum(dynamics.v_entry, across.v_entry),
                v_corner=np.minimum(dynamics.v_corner, across.v_corner),
            )
        moves = self._settings.of(rapid)
        turn = np.zeros((1, limits.n))
        if before is not None:
            turn[0] = self._direction_at_start(arc) - before.direction
        kept = np.array([before is not None and before.main])
        dynamics = self._path_limits(dynamics, moves, turn, kept, on_arc=True)
        dynamics = replace(dynamics, v_limit=np.minimum(dynamics.v_limit, self._radial_speed(arc, moves)))
        path = self._along_path(moves, on_arc=True)
        path = replace(path, velocity=min(path.velocity, self._radial_speed(arc, moves)))
        return Limited(dynamics, after, [Kind(1, limits, path)])

    def _arc(self, limits: AxisLimits, arc: ArcGeometry, feed: float, before: Border | None) -> tuple[Dynamics, Border]:
        return arc_dynamics(
            limits, self._period, arc.plane, arc.begin, arc.angle, arc.radius, arc.linear, arc.length, feed, before
        )

    def _direction_at_start(self, arc: ArcGeometry) -> Floats:
        first, second = arc.plane
        direction = arc.linear / arc.length
        share = arc.radius * arc.angle / arc.length
        direction[first], direction[second] = -share * math.sin(arc.begin), share * math.cos(arc.begin)
        return direction

    def _radial_speed(self, arc: ArcGeometry, moves: MoveSettings) -> float:
        """Greatest speed for the radial acceleration k v² and the radial jerk k² v³."""
        kappa = (arc.radius * arc.angle / arc.length) ** 2 / arc.radius
        vector = moves.vector
        return min(math.sqrt(vector.radial_acceleration / kappa), math.cbrt(vector.radial_jerk / kappa**2))

    # ------------------------------------------------------------------ along the path

    @property
    def unwatched(self) -> int:
        """Bits of LookAhead that do not hold for all axes (G115)."""
        return ALL_LIMITS & ~self._settings.look_ahead

    def _along_path(self, moves: MoveSettings, *, on_arc: bool) -> PathLimits:
        """#VECTOR LIMIT. On circles the limits of the acceleration hold if P-CHAN-00350 says so."""
        vector = moves.vector
        if vector.unlimited:
            return ANY
        free = on_arc and not self._weights.limit_on_circles
        acceleration = math.inf if free else vector.acceleration
        deceleration = math.inf if free else vector.deceleration
        return PathLimits(vector.velocity, acceleration, deceleration, vector.jerk)

    def _path_limits(
        self, dynamics: Dynamics, moves: MoveSettings, turn: Floats, kept: Flags, *, on_arc: bool
    ) -> Dynamics:
        """#VECTOR LIMIT and #TRANSVELMIN. `turn` (k, n): change of direction at the entry; `kept` (k,): the path goes on there
        in the same measure."""
        vector = moves.vector
        v_entry, v_corner = dynamics.v_entry, dynamics.v_corner
        change = np.linalg.norm(turn, axis=1)
        path = self._along_path(moves, on_arc=on_arc)
        v_limit = np.minimum(dynamics.v_limit, path.velocity)
        a_limit = np.minimum(dynamics.a_limit, min(path.acceleration, path.deceleration))
        j_limit = np.minimum(dynamics.j_limit, path.jerk)
        if not vector.unlimited:
            with np.errstate(divide="ignore"):
                most = vector.transition_acceleration * self._period / change
            v_entry, v_corner = np.minimum(v_entry, most), np.minimum(v_corner, most)
        if self._settings.least_transition > 0.0:
            knee = kept & (change > TANGENTIAL)
            least = self._settings.least_transition
            v_entry = np.where(knee, np.maximum(v_entry, least), v_entry)
            v_corner = np.where(knee, np.maximum(v_corner, least), v_corner)
        return Dynamics(v_limit, a_limit, j_limit, v_entry, v_corner)
