"""From what the machine can do to what the program allows: weights, slopes, path limits, corners (see dynamic_settings).

    axis limits ─ weights of the program, of path length or radius ─▶ limits of a kind of move ─ dynamics ─▶ v, a, j, v_entry
                                                                                                   └ path limits, G115…G117

Moves of one kind (feed or rapid, row of the weight table) share their limits. A run of lines is cut where the kind changes;
over such a border, and where the settings have changed, the lower of both corner speeds counts.

No weight exceeds what the machine description gives. With the slope STEP the acceleration may jump: within one cycle.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace

import numpy as np
import numpy.typing as npt

from runtime.cnc.dynamic_settings import (
    ALL_LIMITS,
    USUAL,
    DynamicSettings,
    HoldUse,
    LookAhead,
    MoveSettings,
    Shares,
    Slope,
    WeightedPart,
)
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.geometry.polynomial_table import ROWS, WIDTH
from runtime.cnc.geometry.polynomials import MAIN_AXES, polynomial_derivatives
from runtime.cnc.path_preparation.channel_dynamics import ChannelDynamics
from runtime.cnc.path_preparation.dynamics import TANGENTIAL, Border, Dynamics, arc_dynamics, line_dynamics
from runtime.cnc.path_preparation.polynomial_dynamics import PLACES, polynomial_dynamics
from runtime.kernels import kernel, warms

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

    @property
    def direction_at_start(self) -> Floats:
        """q' where the arc begins, (n,)."""
        first, second = self.plane
        direction = self.linear / self.length
        share = self.radius * self.angle / self.length
        direction[first], direction[second] = -share * math.sin(self.begin), share * math.cos(self.begin)
        return direction


@dataclass(frozen=True, slots=True)
class PathLimits:
    """What the program itself allows along the path, in mm and s; the velocity may be one for each element."""

    velocity: float | Floats = math.inf
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

    def each(self, name: str) -> Floats:
        """A limit along the path for each element, (count,)."""
        limit: Floats = np.broadcast_to(getattr(self.path, name), self.count)
        return limit


Hold = tuple[Floats, Floats]  # acceleration and jerk of feed hold along the path, each (k,)


@dataclass(frozen=True, slots=True)
class Limited:
    """Limits of successive elements, how the last one ends, where the limits come from, and the ramp of feed hold if it has
    one of its own."""

    dynamics: Dynamics
    after: Border
    kinds: list[Kind]
    hold: Hold | None = None


Made = tuple[Dynamics, Border]


@dataclass(frozen=True, slots=True)
class _Part:
    """Elements of one kind: what makes limits of them, the change of direction at the entry of each (k, n), whether the path
    goes on there in the same measure (k,), and, if they are curved, their greatest curvature (k,)."""

    make: Callable[[AxisLimits], Made]
    turn: Callable[[], Floats]
    goes_on: Flags
    bend: Callable[[], Floats] | None = None
    circle: bool = False

    @property
    def curved(self) -> bool:
        return self.bend is not None


def _goes_on(main: Flags, before: Border | None) -> Flags:
    """Whether the path goes on in the same measure at the entry of each element, (k,)."""
    kept: Flags = main == np.concatenate([[main[0] if before is None else before.main], main[:-1]])
    kept[0] &= before is not None
    return kept


def _array(shares: Shares, n: int) -> Floats:
    return np.array(shares) if shares else np.ones(n)


class DynamicLimits:
    """The limits of the elements of one program; `change` follows its settings.

    `limits`: of the axes, from the machine description; `period` of the cycle, s.
    """

    def __init__(self, limits: AxisLimits, period: float, weights: ChannelDynamics | None = None) -> None:
        self._machine = limits
        self._period = period
        self._weights = weights or ChannelDynamics()
        self._asked = self._settings = USUAL
        self._kept: dict[tuple[bool, Factors], AxisLimits] = {}
        self._before: AxisLimits | None = None  # of the element before
        self._plain = True
        self._corner_factors: Floats | None = None  # of the jumps of velocity, (n_axes,); #FILTER
        self._watched = False  # the filter keeps a deviation: no jump at a corner is free

    @property
    def settings(self) -> DynamicSettings:
        return self._settings

    def change_axes(self, limits: AxisLimits) -> None:
        """The axes can do something else from here on."""
        self._machine = limits
        self._kept.clear()

    def change_filter(self, corner_factors: Floats, *, watched: bool) -> None:
        """A filter behind the interpolator spreads jumps of velocity: axes may jump by so many times as much at corners,
        (n_axes,). `watched`: it counts on that, so no axis may jump by more."""
        self._corner_factors = corner_factors if (corner_factors != 1.0).any() else None
        self._watched = watched
        self.change(self._asked)

    @property
    def kinds(self) -> int:
        """How many different sets of axis limits the elements may need under the present settings."""
        return 1 if self._plain else 2 * (len(self._weights.by_length.limits) + len(self._weights.by_radius.limits) + 1)

    def change(self, settings: DynamicSettings) -> None:
        """Other settings hold from here on."""
        self._asked = settings
        if self._watched:
            settings = replace(settings, look_ahead=ALL_LIMITS, free_corners=frozenset(), least_transition=0.0)
        self._settings = settings
        self._kept.clear()
        self._plain = settings == USUAL and not self._weights.by_length.limits and self._corner_factors is None

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
        step = limits.velocity_step if self._corner_factors is None else limits.velocity_step * self._corner_factors
        return replace(
            limits,
            acceleration=np.where(unlimited, UNLIMITED, limits.acceleration),
            jerk=np.where(unlimited, UNLIMITED / self._period, limits.jerk),
            deceleration=np.where(unlimited, UNLIMITED, limits.deceleration),
            braking_jerk=np.where(unlimited, UNLIMITED / self._period, limits.braking_jerk),
            velocity_step=np.where(free, UNLIMITED, step),
        )

    def _entry_differs(self, curve: bool) -> bool:
        settings = self._settings
        chosen = settings.look_ahead
        return (
            self._corner_factors is not None
            or bool(settings.free_corners)
            or not chosen & LookAhead.TRANSITION
            or (curve and not chosen & LookAhead.CURVE)
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

    # ------------------------------------------------------------------ elements

    def lines(
        self, direction: Floats, length: Floats, main: Flags, feed: Floats, rapid: Flags, before: Border | None
    ) -> Limited:
        """Limits of k successive lines, as `line_dynamics`; `feed` (k,) per s, `rapid` (k,)."""

        def part(begin: int, end: int, before: Border | None) -> _Part:
            here = slice(begin, end)

            def make(limits: AxisLimits) -> Made:
                return line_dynamics(
                    limits, self._period, direction[here], length[here], main[here], feed[here], before
                )

            def turn() -> Floats:
                first = direction[begin] if before is None else before.direction
                return np.diff(np.vstack([first, direction[here]]), axis=0)

            return _Part(make, turn, _goes_on(main[here], before))

        return self._run(part, rapid, self._rows(length, rapid), before)

    def polynomials(
        self,
        tables: Floats,
        length: Floats,
        main: Flags,
        feed: Floats,
        rapid: Flags,
        before: Border | None,
        *,
        check_jerk: bool,
        constant_velocity: bool,
    ) -> Limited:
        """Limits of m successive polynomials, as `polynomial_dynamics`."""

        def part(begin: int, end: int, before: Border | None) -> _Part:
            here = slice(begin, end)

            def make(limits: AxisLimits) -> Made:
                return polynomial_dynamics(
                    limits, self._period, tables[here], length[here], main[here], feed[here], before,
                    check_jerk=check_jerk, constant_velocity=constant_velocity,
                )  # fmt: skip

            def bend() -> Floats:
                return greatest_curvature(tables[here], length[here], self._machine.n)

            straight = np.zeros((end - begin, self._machine.n))
            return _Part(make, lambda: straight, _goes_on(main[here], before), bend)

        return self._run(part, rapid, np.full(len(length), -1), before)

    def arc(self, arc: ArcGeometry, feed: float, before: Border | None) -> Limited:
        """Limits of an arc or helix, arrays of shape (1,); `feed` per s, inf for rapid."""
        factors = _NONE
        if self._settings.curve_weights and self._weights.by_radius.limits:
            row = int(self._weights.by_radius.row(np.array([arc.radius]))[0])
            velocity, acceleration, ramp = self._weights.by_radius.factors[row]
            factors = (min(velocity, 1.0), min(acceleration, 1.0), ramp)

        def make(limits: AxisLimits) -> Made:
            return arc_dynamics(
                limits, self._period, arc.plane, arc.begin, arc.angle, arc.radius, arc.linear, arc.length, feed, before
            )

        def turn() -> Floats:
            there = arc.direction_at_start
            return (there - (there if before is None else before.direction))[None, :]

        def bend() -> Floats:
            return np.array([(arc.radius * arc.angle / arc.length) ** 2 / arc.radius])

        part = _Part(make, turn, _goes_on(np.array([True]), before), bend, circle=True)
        dynamics, after, kind = self._limited(part, math.isinf(feed), factors, 1)
        return Limited(dynamics, after, [kind], self._hold(part, math.isinf(feed), dynamics, kind))

    def _rows(self, length: Floats, rapid: Flags) -> Ints:
        """The row of the weights by path length of each straight move, -1 without."""
        active = self._settings.path_weights
        if not active or not self._weights.by_length.limits:
            return np.full(len(length), -1)
        rows = self._weights.by_length.row(length)
        if not active & _FEED_PATHS:
            rows[~rapid] = -1
        if not active & _RAPID_PATHS or self._settings.rapid_velocity is not None:
            rows[rapid] = -1
        return rows

    def _run(
        self, part: Callable[[int, int, Border | None], _Part], rapid: Flags, rows: Ints, before: Border | None
    ) -> Limited:
        """A run of elements, cut where their kind changes."""
        ends = [len(rapid)]
        if not self._plain:
            ends = [*(np.flatnonzero((np.diff(rows) != 0) | (np.diff(rapid) != 0)) + 1).tolist(), len(rapid)]
        parts: list[Dynamics] = []
        kinds: list[Kind] = []
        holds: list[Hold] = []
        begin = 0
        for end in ends:
            factors = self._weights.by_length.factors[rows[begin]] if rows[begin] >= 0 else _NONE
            piece = part(begin, end, before)
            dynamics, before, kind = self._limited(piece, bool(rapid[begin]), factors, end - begin)
            hold = self._hold(piece, bool(rapid[begin]), dynamics, kind)
            if hold is not None:
                holds.append(hold)
            parts.append(dynamics)
            kinds.append(kind)
            begin = end
        assert before is not None
        if len(parts) == 1:
            return Limited(parts[0], before, kinds, holds[0] if holds else None)
        names = [field.name for field in fields(Dynamics)]
        joined = Dynamics(*(np.concatenate([getattr(one, name) for one in parts]) for name in names))
        both = (np.concatenate([a for a, _ in holds]), np.concatenate([j for _, j in holds])) if holds else None
        return Limited(joined, before, kinds, both)

    def _limited(self, part: _Part, rapid: bool, factors: Factors, count: int) -> tuple[Dynamics, Border, Kind]:
        """Elements of one kind."""
        limits = self.axis_limits(rapid, factors)
        dynamics, after = part.make(limits)
        other, self._before = self._before, limits
        changed = other is not None and other is not limits
        if self._plain and not changed:
            return dynamics, after, Kind(count, limits)
        settings = self._settings
        differs = self._entry_differs(part.curved)
        if differs:
            free, _ = part.make(self._for_entry(limits, part.curved))
            dynamics = replace(dynamics, v_entry=free.v_entry, v_corner=free.v_corner)
            if part.curved and not settings.look_ahead & LookAhead.CURVE:
                dynamics = replace(dynamics, v_limit=free.v_limit)
        if other is not None and changed:  # the first corner is passed as both of them allow
            there, _ = part.make(self._for_entry(other, part.curved) if differs else other)
            dynamics.v_entry[0] = min(dynamics.v_entry[0], there.v_entry[0])
            dynamics.v_corner[0] = min(dynamics.v_corner[0], there.v_corner[0])
            dynamics.a_entry[0] = min(dynamics.a_entry[0], there.a_entry[0])
        if part.curved and settings.geometric_ramp_time > 1.0 and settings.slope is not Slope.STEP:
            longer = settings.geometric_ramp_time
            slower = replace(limits, jerk=limits.jerk / longer, braking_jerk=limits.braking_jerk / longer)
            across, _ = part.make(slower)
            lower = ("v_limit", "a_limit", "v_entry", "v_corner")
            dynamics = replace(
                dynamics, **{name: np.minimum(getattr(dynamics, name), getattr(across, name)) for name in lower}
            )
        path = self._along_path(part, settings.of(rapid))
        return self._path_limits(dynamics, path, settings.of(rapid), part), after, Kind(count, limits, path)

    # ------------------------------------------------------------------ feed hold

    def _hold_limits(self, rapid: bool, active: AxisLimits) -> tuple[Floats, Floats] | None:
        """Deceleration and jerk of each axis in feed hold, (n,), None if it has no ramp of its own.

        A weight counts if what it leads to is no less than what the moves brake with.
        """
        settings, machine = self._settings, self._machine
        hold = self._weights.ramp if settings.hold_use is HoldUse.RAMP else self._weights.hold
        if hold is None or settings.hold_use is HoldUse.AS_ELSE:
            return None
        n, greatest = machine.n, machine.deceleration
        plain = np.minimum(hold.deceleration, greatest)
        weighted = np.minimum(plain * _array(settings.hold_acceleration, n), greatest)
        deceleration = np.where(weighted >= active.least_acceleration * (1.0 - 1e-9), weighted, plain)
        least_time = plain / machine.braking_jerk
        ramp = np.maximum(hold.ramp_time, least_time) * np.maximum(_array(settings.hold_ramp_time, n), LEAST_WEIGHT)
        return deceleration, self._jerk(
            machine.braking_jerk, deceleration / (ramp * machine.braking_jerk), deceleration
        )

    def _hold(self, part: _Part, rapid: bool, dynamics: Dynamics, kind: Kind) -> Hold | None:
        """What feed hold brakes with on elements of one kind.

        Two boxes: what the axes stand at the speeds of `dynamics` (of each axis the harder of both brakings), and what is asked
        for. The smaller one counts.
        """
        limits = self._hold_limits(rapid, kind.axes)
        if limits is None:
            return None
        deceleration, jerk = limits
        hardest = np.maximum(deceleration, kind.axes.least_acceleration)
        harder_jerk = np.maximum(jerk, kind.axes.least_jerk)
        hard = self._box(part, kind.axes, hardest, harder_jerk)
        # Curvature takes what it takes at the speeds that hold: a box for lower ones says nothing.
        slower = (hard.v_limit < dynamics.v_limit * (1.0 - 1e-9)) | (hard.v_entry < dynamics.v_entry * (1.0 - 1e-9))
        slower[:-1] |= slower[1:]
        a = np.where(slower, dynamics.a_limit, hard.a_limit)
        j = np.where(slower, dynamics.j_limit, hard.j_limit)
        if (deceleration < hardest).any() or (jerk < harder_jerk).any():
            asked = self._box(part, kind.axes, deceleration, jerk)
            a, j = np.minimum(a, asked.a_limit), np.minimum(j, asked.j_limit)
        return np.minimum(a, kind.path.deceleration), np.minimum(j, kind.path.jerk)

    def _box(self, part: _Part, axes: AxisLimits, acceleration: Floats, jerk: Floats) -> Dynamics:
        limits = replace(axes, acceleration=acceleration, deceleration=acceleration, jerk=jerk, braking_jerk=jerk)
        return part.make(limits)[0]

    # ------------------------------------------------------------------ along the path

    @property
    def unwatched(self) -> int:
        """Bits of LookAhead that do not hold for all axes (G115)."""
        return ALL_LIMITS & ~self._settings.look_ahead

    def _along_path(self, part: _Part, moves: MoveSettings) -> PathLimits:
        """#VECTOR LIMIT. On circles the limits of the acceleration hold if P-CHAN-00350 says so."""
        vector = moves.vector
        if vector.unlimited:
            return ANY
        free = part.circle and not self._weights.limit_on_circles
        acceleration = math.inf if free else vector.acceleration
        deceleration = math.inf if free else vector.deceleration
        velocity: float | Floats = vector.velocity
        if part.bend is not None and min(vector.radial_acceleration, vector.radial_jerk) < math.inf:
            kappa = np.maximum(part.bend(), 1e-12)
            radial = np.minimum(np.sqrt(vector.radial_acceleration / kappa), np.cbrt(vector.radial_jerk / kappa**2))
            velocity = np.minimum(velocity, radial)
        return PathLimits(velocity, acceleration, deceleration, vector.jerk)

    def _path_limits(self, dynamics: Dynamics, path: PathLimits, moves: MoveSettings, part: _Part) -> Dynamics:
        """#VECTOR LIMIT and #TRANSVELMIN."""
        v_entry, v_corner, a_entry = dynamics.v_entry, dynamics.v_corner, dynamics.a_entry
        v_limit = np.minimum(dynamics.v_limit, path.velocity)
        a_limit = np.minimum(dynamics.a_limit, min(path.acceleration, path.deceleration))
        j_limit = np.minimum(dynamics.j_limit, path.jerk)
        most, least = moves.vector.transition_acceleration, self._settings.least_transition
        if most < math.inf or least > 0.0:
            change = np.linalg.norm(part.turn(), axis=1)
            with np.errstate(divide="ignore"):
                speed = most * self._period / change
            v_entry, v_corner = np.minimum(v_entry, speed), np.minimum(v_corner, speed)
            a_entry = np.zeros_like(a_entry)
            knee = part.goes_on & (change > TANGENTIAL)
            v_entry = np.where(knee, np.maximum(v_entry, least), v_entry)
            v_corner = np.where(knee, np.maximum(v_corner, least), v_corner)
        return Dynamics(v_limit, a_limit, j_limit, v_entry, v_corner, np.minimum(a_entry, a_limit))


@kernel
def greatest_curvature(tables: Floats, length: Floats, n: int) -> Floats:
    """Of m polynomials in the main axes, 1/mm, (m,)."""
    found = np.zeros(length.shape[0])
    q, u, k, r = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    for element in range(length.shape[0]):
        for place in range(PLACES):
            polynomial_derivatives(tables[element], place / (PLACES - 1), length[element], n, q, u, k, r)
            square = 0.0
            for axis in range(min(MAIN_AXES, n)):
                square += k[axis] * k[axis]
            found[element] = max(found[element], math.sqrt(square))
    return found


@warms("curvature of polynomials")
def _warm_up() -> None:
    greatest_curvature(np.zeros((1, ROWS, WIDTH)), np.ones(1), 2)
