"""Software limits: no block is handed on whose path leaves the range of an axis.

A straight move stays within the box if its ends do. An arc also reaches the extremes of the circle that lie on it,
a polynomial its turning points.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from runtime.cnc.blocks import (
    ActualLimit,
    Arc,
    Block,
    IndependentMotion,
    LimitBehaviour,
    Line,
    Polyline,
    Polynomials,
    SoftwareLimitChange,
    Source,
)
from runtime.cnc.geometry.elements import cosine_range
from runtime.cnc.path_preparation.errors import SoftwareLimitError
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue.axes import LIMIT_WARNING
from runtime.diagnostics.catalogue.motion import SOFTWARE_LIMIT
from runtime.diagnostics.errors import Place, Problem
from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]

# Control points of a polynomial of degree 5 over 0…1 from its coefficients: b_i = Σ_p C(i, p) / C(5, p) c_p.
BERNSTEIN = np.array([[math.comb(i, p) / math.comb(5, p) for p in range(6)] for i in range(6)])
ROUNDING = 1e-7  # mm or degrees: a target that was programmed as the limit is not beyond it


def _reach(arc: Arc) -> tuple[Floats, Floats]:
    """Smallest and greatest position of every axis on an arc, each (n_axes,)."""
    low, high = np.minimum(arc.start, arc.end), np.maximum(arc.start, arc.end)
    first, second = arc.plane
    x, y = arc.start[first] - arc.centre[0], arc.start[second] - arc.centre[1]
    begin = math.atan2(y, x)
    end = begin + math.radians(arc.angle)
    radius = math.hypot(x, y)
    for axis, centre, shift in ((first, arc.centre[0], 0.0), (second, arc.centre[1], math.pi / 2)):
        least, greatest = cosine_range(begin - shift, end - shift)
        low[axis] = min(low[axis], centre + radius * least)
        high[axis] = max(high[axis], centre + radius * greatest)
    return low, high


def polynomial_reach(coefficients: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Smallest and greatest position of every axis on an element (6, n_axes), each (n_axes,).

    The turning points are only looked for where the control points, between which the element lies, leave `low` … `high`.
    """
    control = BERNSTEIN @ coefficients
    least, greatest = control.min(axis=0), control.max(axis=0)
    for axis in np.flatnonzero((least < low) | (greatest > high)):
        column = coefficients[::-1, axis]
        roots = np.roots(np.polyder(column))
        turning = roots[(np.abs(roots.imag) < 1e-6) & (roots.real > 0.0) & (roots.real < 1.0)].real
        values = np.polyval(column, np.concatenate([turning, [0.0, 1.0]]))
        least[axis], greatest[axis] = values.min(), values.max()
    return least, greatest


@kernel
def first_beyond(points: Floats, low: Floats, high: Floats) -> int:
    """How many moves of a run `points` (k + 1, n) end within `low` and `high` (n,) before one does not; k if all do."""
    moves: int = points.shape[0] - 1
    axes = points.shape[1]
    for move in range(moves):
        for axis in range(axes):
            target = points[move + 1, axis]
            if target < low[axis] or target > high[axis]:
                return move
    return moves


def _first_moves(run: Polyline, count: int) -> Polyline:
    return replace(
        run,
        points=run.points[: count + 1],
        feeds=run.feeds[:count],
        lines=run.lines[:count],
        numbers=run.numbers[:count],
    )


def axes_of(mask: int, axes: int) -> frozenset[int]:
    """The axes of the channel whose bit is set."""
    return frozenset(axis for axis in range(axes) if mask >> axis & 1)


class SoftwareLimits:
    """The stage. `names`, `position_min`, `position_max`: one element per axis of the channel; None where there is no
    limit. A program may change them for itself (G98, G99); the next one begins with these again.

    Raises SoftwareLimitError before it yields the block that would leave the range. Where POS_LIMIT says so, or for an axis of
    `warning` (P-CHAN-00147), the block is let through, and `warnings` gets a warning for the line; the cycle watches where the
    axis is. Axes of `free` (P-CHAN-00459) have no limits here. `tolerance` (P-CHAN-00120): by how much an axis that rests may
    lie beyond, mm or degrees.
    """

    def __init__(
        self,
        names: Sequence[str],
        position_min: Sequence[float | None],
        position_max: Sequence[float | None],
        *,
        warning: Collection[int] = (),
        free: Collection[int] = (),
        tolerance: Sequence[float] = (),
    ) -> None:
        self._names = list(names)
        self._warning, self._free = frozenset(warning) - frozenset(free), frozenset(free)
        self._tolerance: Floats | None = np.array(tolerance, dtype=np.float64) if any(tolerance) else None
        self._low: Floats = np.array([-np.inf if p is None else p for p in position_min]) - ROUNDING
        self._high: Floats = np.array([np.inf if p is None else p for p in position_max]) + ROUNDING
        self._low[list(self._free)], self._high[list(self._free)] = -np.inf, np.inf
        self._configured = self._low, self._high
        self._warning_low, self._warning_high = np.full(len(names), -np.inf), np.full(len(names), np.inf)
        self._warns = False
        self._watched: set[int] = set()  # axes whose actual position the cycle watches

    @classmethod
    def of(cls, machine: Machine, channel: int = 0) -> SoftwareLimits:
        """The limits of the axes of a channel."""
        names = machine.channels[channel].axes
        axes = [machine.axes[machine.axis_index(name)] for name in names]
        parameters = machine.channels[channel].parameters
        return cls(
            names,
            [axis.position_min for axis in axes],
            [axis.position_max for axis in axes],
            warning=axes_of(parameters.soft_limit_warning_axes, len(names)),
            free=axes_of(parameters.suppress_soft_limit_monitoring_axes, len(names)),
            tolerance=[axis.limit_tolerance for axis in axes] if parameters.soft_limit_tolerance else (),
        )

    @property
    def configured(self) -> tuple[tuple[float, float], ...]:
        """The limits with which every program begins, (n_axes,)."""
        low, high = self._configured
        return tuple(zip((low + ROUNDING).tolist(), (high - ROUNDING).tolist(), strict=True))

    def nearest(self, position: Floats) -> Floats:
        """The place within the limits that is nearest to `position`, both (n_axes,)."""
        return np.clip(position, self._low, self._high)

    def __call__(self, blocks: Iterable[Block], warnings: list[Problem] | None = None) -> Iterator[Block]:
        self._watched.clear()
        behaviour = (LimitBehaviour.ERROR,) * len(self._names)
        yield from self._change(SoftwareLimitChange(Source("", 0), self.configured, behaviour))
        for block in blocks:
            if isinstance(block, SoftwareLimitChange):
                yield from self._change(block)
                continue
            if self._warns and warnings is not None:
                self._warn(block, warnings)
            if isinstance(block, Polyline):
                count = self._moves_within(block)
                if count < len(block.feeds):
                    if count:
                        yield _first_moves(block, count)  # they are blocks of their own, which are right
                    self._refuse_move(block, count)
            else:
                self.check(block)
            yield block

    def _change(self, change: SoftwareLimitChange) -> Iterator[Block]:
        """Other limits from here on; what the cycle has to know of them."""
        low = np.array([low for low, _ in change.limits]) - ROUNDING
        high = np.array([high for _, high in change.limits]) + ROUNDING
        lenient = np.zeros(len(low), dtype=np.bool_)
        low[list(self._free)], high[list(self._free)] = -np.inf, np.inf
        for axis, behaviour in enumerate(change.behaviour or (LimitBehaviour.ERROR,) * len(low)):
            if axis in self._free:
                continue
            lenient[axis] = behaviour is not LimitBehaviour.ERROR or axis in self._warning
            if lenient[axis] or axis in self._watched:
                limits = change.limits[axis] if lenient[axis] else (-np.inf, np.inf)
                yield ActualLimit(change.source, axis, *limits, behaviour is LimitBehaviour.ERROR_LR)
                (self._watched.add if lenient[axis] else self._watched.discard)(axis)
        self._low, self._high = np.where(lenient, -np.inf, low), np.where(lenient, np.inf, high)
        self._warning_low, self._warning_high = np.where(lenient, low, -np.inf), np.where(lenient, high, np.inf)
        self._warns = bool(lenient.any())

    def _warn(self, block: Block, warnings: list[Problem]) -> None:
        """Every line that leads beyond a limit which only warns is told once."""
        strict = self._low, self._high
        self._low, self._high = self._warning_low, self._warning_high
        try:
            self.check(block)
        except SoftwareLimitError as error:
            problem = error.problem
            values = {key: value for key, value in problem.values.items() if key != "limit_name"}
            if not any(known.place == problem.place and known.values == values for known in warnings):
                warnings.append(Problem(LIMIT_WARNING, values, problem.place))
        finally:
            self._low, self._high = strict

    def check(self, block: Block) -> None:
        """Raise SoftwareLimitError if `block` leaves the range of an axis."""
        if isinstance(block, Line):
            low, high = self._range(block.start, block.end)
            if ((block.end < low) | (block.end > high)).any():
                self._refuse(block.end, low, high, "the target", block.source.program, block.source.line)
        elif isinstance(block, Arc):
            low, high = self._range(block.start, block.end, block.plane)
            for extreme in _reach(block):
                if ((extreme < low) | (extreme > high)).any():
                    at_target = bool(((block.end < low) | (block.end > high)).any())
                    self._refuse(
                        block.end if at_target else extreme,
                        low,
                        high,
                        "the target" if at_target else "the turning point of the arc",
                        block.source.program,
                        block.source.line,
                    )
        elif isinstance(block, Polynomials):
            for element, coefficients in enumerate(block.coefficients):
                low, high = self._low, self._high
                if self._tolerance is not None:
                    low, high = self._range(coefficients[0], coefficients[0] + np.abs(coefficients[1:]).sum(axis=0))
                for extreme in polynomial_reach(coefficients, low, high):
                    if ((extreme < low) | (extreme > high)).any():
                        self._refuse(extreme, low, high, "the smoothed path", block.program, int(block.lines[element]))
        elif isinstance(block, Polyline):
            count = self._moves_within(block)
            if count < len(block.feeds):
                self._refuse_move(block, count)
        elif isinstance(block, IndependentMotion):
            position = np.clip(np.zeros(len(self._low)), self._low, self._high)
            position[block.axis] = block.target
            if not self._low[block.axis] <= block.target <= self._high[block.axis]:
                self._refuse(position, self._low, self._high, "the target", block.source.program, block.source.line)

    def _range(self, start: Floats, end: Floats, turning: Sequence[int] = ()) -> tuple[Floats, Floats]:
        """Where the axes of a motion from `start` to `end` may be, (n_axes,) each; those of `turning` do not rest."""
        if self._tolerance is None:
            return self._low, self._high
        rests = np.abs(end - start) <= ROUNDING
        rests[list(turning)] = False
        more = np.where(rests, self._tolerance, 0.0)
        return self._low - more, self._high + more

    def _moves_within(self, run: Polyline) -> int:
        """How many moves of a run come before one that does not stay within the limits; all of them if they do."""
        count = first_beyond(run.points, self._low, self._high)
        while self._tolerance is not None and count < len(run.feeds):  # the axis may rest there
            low, high = self._range(run.points[count], run.points[count + 1])
            beyond = (run.points[count + 1] < low) | (run.points[count + 1] > high)
            if beyond.any():
                break
            count += 1 + first_beyond(run.points[count + 1 :], self._low, self._high)
        return int(count)

    def _refuse_move(self, run: Polyline, move: int) -> None:
        low, high = self._range(run.points[move], run.points[move + 1])
        self._refuse(run.points[move + 1], low, high, "the target", run.program, int(run.lines[move]))

    def _refuse(self, position: Floats, low: Floats, high: Floats, what: str, program: str, line: int) -> None:
        below = position < low
        axis = int(np.argmax(below | (position > high)))
        limit = float(self._low[axis] + ROUNDING if below[axis] else self._high[axis] - ROUNDING)
        raise SoftwareLimitError(
            SOFTWARE_LIMIT,
            Place(program, line),
            what=what,
            axis=self._names[axis],
            position=float(position[axis]),
            limit=limit,
            limit_name="position_min" if below[axis] else "position_max",
        )


@warms("software limits")
def _warm() -> None:
    first_beyond(np.zeros((2, 3)), np.zeros(3), np.zeros(3))
