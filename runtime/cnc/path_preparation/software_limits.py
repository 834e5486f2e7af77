"""Software limits: no block is handed on whose path leaves the range of an axis.

A straight move stays within the box if its ends do. An arc also reaches the extremes of the circle that lie on it,
a polynomial its turning points.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
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


class SoftwareLimits:
    """The stage. `names`, `position_min`, `position_max`: one element per axis of the channel; None where there is no
    limit. A program may change them for itself (G98, G99); the next one begins with these again.

    Raises SoftwareLimitError before it yields the block that would leave the range. Where POS_LIMIT says so, the block is let
    through, and `warnings` gets a warning for the line.
    """

    def __init__(
        self, names: Sequence[str], position_min: Sequence[float | None], position_max: Sequence[float | None]
    ) -> None:
        self._names = list(names)
        self._low: Floats = np.array([-np.inf if p is None else p for p in position_min]) - ROUNDING
        self._high: Floats = np.array([np.inf if p is None else p for p in position_max]) + ROUNDING
        self._configured = self._low, self._high
        self._warning_low, self._warning_high = np.full(len(names), -np.inf), np.full(len(names), np.inf)
        self._warns = False
        self._watched: set[int] = set()  # axes whose actual position the cycle watches

    @classmethod
    def of(cls, machine: Machine, channel: int = 0) -> SoftwareLimits:
        """The limits of the axes of a channel."""
        names = machine.channels[channel].axes
        axes = [machine.axes[machine.axis_index(name)] for name in names]
        return cls(names, [axis.position_min for axis in axes], [axis.position_max for axis in axes])

    @property
    def configured(self) -> tuple[tuple[float, float], ...]:
        """The limits with which every program begins, (n_axes,)."""
        low, high = self._configured
        return tuple(zip((low + ROUNDING).tolist(), (high - ROUNDING).tolist(), strict=True))

    def nearest(self, position: Floats) -> Floats:
        """The place within the limits that is nearest to `position`, both (n_axes,)."""
        return np.clip(position, self._low, self._high)

    def __call__(self, blocks: Iterable[Block], warnings: list[Problem] | None = None) -> Iterator[Block]:
        self._low, self._high = self._configured
        self._warns = False
        self._watched.clear()
        for block in blocks:
            if isinstance(block, SoftwareLimitChange):
                yield from self._change(block)
                continue
            if self._warns and warnings is not None:
                self._warn(block, warnings)
            if isinstance(block, Polyline):
                count = first_beyond(block.points, self._low, self._high)
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
        for axis, behaviour in enumerate(change.behaviour):
            lenient[axis] = behaviour is not LimitBehaviour.ERROR
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
            if ((block.end < self._low) | (block.end > self._high)).any():
                self._refuse(block.end, "the target", block.source.program, block.source.line)
        elif isinstance(block, Arc):
            low, high = _reach(block)
            for extreme in (low, high):
                if ((extreme < self._low) | (extreme > self._high)).any():
                    at_target = bool(((block.end < self._low) | (block.end > self._high)).any())
                    self._refuse(
                        block.end if at_target else extreme,
                        "the target" if at_target else "the turning point of the arc",
                        block.source.program,
                        block.source.line,
                    )
        elif isinstance(block, Polynomials):
            for element, coefficients in enumerate(block.coefficients):
                for extreme in polynomial_reach(coefficients, self._low, self._high):
                    if ((extreme < self._low) | (extreme > self._high)).any():
                        self._refuse(extreme, "the smoothed path", block.program, int(block.lines[element]))
        elif isinstance(block, Polyline):
            count = first_beyond(block.points, self._low, self._high)
            if count < len(block.feeds):
                self._refuse_move(block, count)
        elif isinstance(block, IndependentMotion):
            position = np.clip(np.zeros(len(self._low)), self._low, self._high)
            position[block.axis] = block.target
            if not self._low[block.axis] <= block.target <= self._high[block.axis]:
                self._refuse(position, "the target", block.source.program, block.source.line)

    def _refuse_move(self, run: Polyline, move: int) -> None:
        self._refuse(run.points[move + 1], "the target", run.program, int(run.lines[move]))

    def _refuse(self, position: Floats, what: str, program: str, line: int) -> None:
        below = position < self._low
        axis = int(np.argmax(below | (position > self._high)))
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
