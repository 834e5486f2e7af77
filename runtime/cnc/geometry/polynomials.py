"""Polynomial path elements: place and derivatives at a share of the length, and how the parameter follows the length.

An element is q(u) = c0 + c1 u + … + c5 u⁵ for u from 0 to 1. The interpolator knows path lengths only, so each element
carries u(σ), σ = s/L the share of its length, as a polynomial of degree 7 with the exact values

    σ = 0, 1      u, u', u''      the speed along the path is right there and does not jump to the neighbours
    σ = 1/2       u, u'

What is driven lies on the element whatever u(σ) is; between these places only the speed is off, by at most SPEED_ERROR.
Elements for which that is not enough are split.

A table (`polynomial_table`) holds an element.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from runtime.cnc.geometry.polynomial_table import DEGREE, MAP, ROWS, TERMS, WIDTH
from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Flags = npt.NDArray[np.bool_]

SPEED_ERROR = 5e-4  # |dq/ds| - 1
MOST_PARTS = 64  # of one element
LEAST_PART = 2.0**-16  # near a place where it almost stands still: two control points that nearly coincide
GREATEST_SPEED_ERROR = 0.2  # of such a part: what it costs is speed, as the limits are those of what is driven
MAIN_AXES = 3

_PIECES = 4  # of the integral of the length
_TEST_PLACES = 12

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)
GAUSS_PLACES = 0.5 * (_NODES + 1.0)
GAUSS_WEIGHTS = 0.5 * _WEIGHTS


def _map_matrix() -> Floats:
    """Coefficients of u(σ) from its eight conditions: values and two derivatives at both ends, value and slope in the middle."""
    conditions = np.zeros((WIDTH, WIDTH))
    for row, (order, place) in enumerate(
        ((0, 0.0), (1, 0.0), (2, 0.0), (0, 1.0), (1, 1.0), (2, 1.0), (0, 0.5), (1, 0.5))
    ):
        for power in range(order, WIDTH):
            conditions[row, power] = math.perm(power, order) * place ** (power - order)
    return np.linalg.inv(conditions).astype(np.float64)


MAP_MATRIX = _map_matrix()


@kernel
def polynomial_at(table: Floats, share: float, length: float, n: int, q: Floats, dq: Floats) -> None:
    """Write q and q' = dq/ds at a share of the `length` to the first `n` of `q`, `dq`."""
    u, speed = 0.0, 0.0
    for power in range(WIDTH - 1, -1, -1):
        speed = speed * share + u
        u = u * share + table[MAP, power]
    speed /= length
    for axis in range(n):
        value, slope = table[DEGREE, axis], 0.0
        for power in range(DEGREE - 1, -1, -1):
            slope = slope * u + value
            value = value * u + table[power, axis]
        q[axis], dq[axis] = value, slope * speed


@kernel
def polynomial_derivatives(
    table: Floats, share: float, length: float, n: int, q: Floats, dq: Floats, ddq: Floats, dddq: Floats
) -> None:
    """Write q, q', q'' and q''' (by the path length) at a share of the `length` to the first `n` of each."""
    u, u1, u2, u3 = 0.0, 0.0, 0.0, 0.0
    for power in range(WIDTH - 1, -1, -1):
        u3 = u3 * share + u2
        u2 = u2 * share + u1
        u1 = u1 * share + u
        u = u * share + table[MAP, power]
    u1, u2, u3 = u1 / length, 2.0 * u2 / length**2, 6.0 * u3 / length**3
    for axis in range(n):
        p, p1, p2, p3 = 0.0, 0.0, 0.0, 0.0
        for power in range(DEGREE, -1, -1):
            p3 = p3 * u + p2
            p2 = p2 * u + p1
            p1 = p1 * u + p
            p = p * u + table[power, axis]
        p2, p3 = 2.0 * p2, 6.0 * p3
        q[axis] = p
        dq[axis] = p1 * u1
        ddq[axis] = p2 * u1 * u1 + p1 * u2
        dddq[axis] = p3 * u1**3 + 3.0 * p2 * u1 * u2 + p1 * u3


@kernel
def speed_at(coefficients: Floats, u: float, first: int, last: int) -> tuple[float, float]:
    """|dq/du| over the axes first … last - 1, and its derivative by u; (6, n) coefficients."""
    square, product = 0.0, 0.0
    for axis in range(first, last):
        p, p1, p2 = 0.0, 0.0, 0.0
        for power in range(DEGREE, -1, -1):
            p2 = p2 * u + p1
            p1 = p1 * u + p
            p = p * u + coefficients[power, axis]
        square += p1 * p1
        product += p1 * 2.0 * p2
    speed = math.sqrt(square)
    return speed, product / speed if speed > 0.0 else 0.0


@kernel
def way_between(coefficients: Floats, low: float, high: float, first: int, last: int) -> float:
    """Length from u = low to high, by one Gauss rule."""
    way = 0.0
    for node in range(GAUSS_PLACES.shape[0]):
        speed, _ = speed_at(coefficients, low + (high - low) * GAUSS_PLACES[node], first, last)
        way += GAUSS_WEIGHTS[node] * speed
    return way * (high - low)


@kernel
def fit_parameter(coefficients: Floats, first: int, last: int, table: Floats) -> tuple[float, float]:
    """Fill the map row of `table`; returns the length of the element (6, n) and the greatest error of the speed.

    An error of inf: the element stands still somewhere, or the map would run backwards.
    """
    straight = 0.0
    for power in range(2, TERMS):
        for axis in range(coefficients.shape[1]):
            straight = max(straight, abs(coefficients[power, axis]))
    if straight == 0.0:
        length, _ = speed_at(coefficients, 0.0, first, last)
        for power in range(WIDTH):
            table[MAP, power] = 1.0 if power == 1 else 0.0
        return length, 0.0 if length > 0.0 else np.inf
    borders = np.zeros(_PIECES + 1)
    for piece in range(_PIECES):
        borders[piece + 1] = borders[piece] + way_between(
            coefficients, piece / _PIECES, (piece + 1) / _PIECES, first, last
        )
    length = borders[_PIECES]
    if not length > 0.0:
        return length, np.inf
    half = 0.5 * length
    piece = 0
    while piece < _PIECES - 1 and borders[piece + 1] < half:
        piece += 1
    start = piece / _PIECES
    low, high = start, (piece + 1) / _PIECES
    middle = 0.5 * (low + high)
    for _ in range(40):
        off = borders[piece] + way_between(coefficients, start, middle, first, last) - half
        if off < 0.0:
            low = middle
        else:
            high = middle
        speed, _ = speed_at(coefficients, middle, first, last)
        step = middle - off / speed if speed > 0.0 else -1.0
        new = step if low <= step <= high else 0.5 * (low + high)
        if abs(new - middle) < 1e-15:
            break
        middle = new
    conditions = np.zeros(WIDTH)
    places = (0.0, 1.0, middle)
    for k in range(3):
        speed, change = speed_at(coefficients, places[k], first, last)
        if not speed > 1e-6 * length:
            return length, np.inf
        conditions[3 * k] = places[k]
        conditions[3 * k + 1] = length / speed
        if k < 2:
            conditions[3 * k + 2] = -length * length * change / speed**3
    for power in range(WIDTH):
        value = 0.0
        for row in range(WIDTH):
            value += MAP_MATRIX[power, row] * conditions[row]
        table[MAP, power] = value
    error = 0.0
    for k in range(1, _TEST_PLACES):
        share = k / _TEST_PLACES
        u, slope = 0.0, 0.0
        for power in range(WIDTH - 1, -1, -1):
            slope = slope * share + u
            u = u * share + table[MAP, power]
        speed, _ = speed_at(coefficients, u, first, last)
        if not (slope > 0.0 and 0.0 < u < 1.0):
            return length, np.inf
        error = max(error, abs(speed * slope / length - 1.0))
    return length, error


@kernel
def part_of(coefficients: Floats, low: float, high: float, part: Floats) -> None:
    """The coefficients of the part from u = low to high, with a parameter of its own from 0 to 1; both (6, n)."""
    for axis in range(coefficients.shape[1]):
        for power in range(TERMS):
            part[power, axis] = coefficients[power, axis]
        for done in range(TERMS):  # Taylor shift by repeated Horner steps
            for power in range(DEGREE - 1, done - 1, -1):
                part[power, axis] += low * part[power + 1, axis]
        scale = 1.0
        for power in range(TERMS):
            part[power, axis] *= scale
            scale *= high - low


@kernel
def arrange(
    coefficients: Floats, no_length: float, tables: Floats, lengths: Floats, main: Flags, parent: Ints
) -> tuple[int, int]:
    """Tables of k elements (k, 6, n), split where needed: how many were written, and the element that can't be driven or -1.

    The length is measured along the main axes where they move, else along the others. `tables` (m, ROWS, WIDTH), `lengths`,
    `main`, `parent` (m,): if m is too small the first number is -1. An element without length gets one row, length 0.
    """
    count = 0
    k, _, n = coefficients.shape
    part = np.zeros((TERMS, n))
    for element in range(k):
        c = coefficients[element]
        split = min(MAIN_AXES, n)
        along_main, along_others = 0.0, 0.0
        along_main = way_between(c, 0.0, 1.0, 0, split)
        if n > split or along_main <= 1e3 * no_length:
            along_others = way_between(c, 0.0, 1.0, split, n)
        by_main = along_main > no_length and along_main > 1e-6 * along_others
        first, last = (0, split) if by_main else (split, n)
        empty = max(along_main, along_others) <= no_length
        low, width = 0.0, 1.0
        while low < 1.0:
            if count >= lengths.shape[0]:
                return -1, -1
            part_of(c, low, low + width, part)
            length, error = fit_parameter(part, first, last, tables[count])
            if empty:
                length, width = 0.0, 1.0
            elif error > SPEED_ERROR:
                width *= 0.5
                if width >= 1.0 / MOST_PARTS or (error > GREATEST_SPEED_ERROR and width >= LEAST_PART):
                    continue
                if error > GREATEST_SPEED_ERROR:
                    return count, element
                width *= 2.0
            for power in range(TERMS):
                for axis in range(n):
                    tables[count, power, axis] = part[power, axis]
            lengths[count], main[count], parent[count] = length, by_main, element
            count += 1
            low += width
            while width < 1.0 and (low / (2.0 * width)) % 1.0 == 0.0 and low + 2.0 * width <= 1.0:
                width *= 2.0
    return count, -1


@warms("polynomials")
def _warm_up() -> None:
    coefficients = np.zeros((1, TERMS, 2))
    coefficients[0, 1, 0] = 1.0
    tables = np.zeros((2, ROWS, WIDTH))
    arrange(coefficients, 1e-9, tables, np.zeros(2), np.zeros(2, dtype=np.bool_), np.zeros(2, dtype=np.int64))
    a, b, c, d = np.zeros(8), np.zeros(8), np.zeros(8), np.zeros(8)
    polynomial_at(tables[0], 0.5, 1.0, 2, a, b)
    polynomial_derivatives(tables[0], 0.5, 1.0, 2, a, b, c, d)
