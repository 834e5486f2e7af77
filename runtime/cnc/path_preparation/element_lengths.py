"""How long the elements of a motion are, as the queue writer will measure them, and what lies before and behind a place."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from runtime.cnc.blocks import Arc, Floats, Line, Polyline, Polynomials
from runtime.cnc.geometry.polynomials import MAIN_AXES, MOST_PARTS, part_of, way_between
from runtime.cnc.path_preparation.errors import PathError
from runtime.cnc.path_preparation.motion_pieces import NO_LENGTH, lines_of, moves, shortened
from runtime.cnc.path_preparation.polynomial_dynamics import fit
from runtime.cnc.path_preparation.queue_writer import path_length
from runtime.diagnostics.catalogue.motion import POLYNOMIAL_GEOMETRY
from runtime.diagnostics.errors import Place

Motion = Line | Arc | Polyline | Polynomials
MOTIONS = (Line, Arc, Polyline, Polynomials)


def element_lengths(motion: Motion) -> Floats:
    """Path lengths (k,), mm or degrees; k is 1 for lines and arcs. Raises PathError for a curve that can't be driven."""
    if isinstance(motion, Polyline):
        lengths, _ = path_length(np.diff(motion.points, axis=0))
        return lengths
    if isinstance(motion, Polynomials):
        fitted = fit(motion, motion.start, NO_LENGTH)
        if fitted is None:
            raise PathError(POLYNOMIAL_GEOMETRY, Place(motion.program, int(motion.lines[0])))
        lengths = np.zeros(len(motion.feeds))
        np.add.at(lengths, fitted.parent, fitted.length)
        return lengths
    way = motion.end - motion.start
    if isinstance(motion, Arc):
        first, second = motion.plane
        radius = math.hypot(motion.start[first] - motion.centre[0], motion.start[second] - motion.centre[1])
        way[first] = way[second] = 0.0
        along = radius * math.radians(abs(motion.angle))
        if along > NO_LENGTH:
            return np.array([math.hypot(along, float(np.linalg.norm(way[:MAIN_AXES])))])
        way = motion.end - motion.start
    lengths, _ = path_length(way[None, :])
    return lengths


def element_ends(motion: Motion) -> Floats:
    """Where the elements end, (k, n_axes)."""
    if isinstance(motion, Polyline):
        return motion.points[1:]
    if isinstance(motion, Polynomials):
        return motion.ends
    return motion.end[None, :]


def behind(motion: Motion, element: int, taken: float, length: float) -> Iterator[Motion]:
    """What is left behind the place `taken` mm into an element of `length`."""
    if isinstance(motion, Polyline):
        count = len(motion.feeds)
        if taken > 0.0:
            rest = shortened(moves(motion, element, element + 1), taken, 0.0, length)
            if rest is not None:
                yield rest
            element += 1
        if element < count:
            yield moves(motion, element, count)
    elif isinstance(motion, Polynomials):
        yield _polynomials_behind(motion, element, taken, length)
    else:
        rest = shortened(motion, taken, 0.0, length)
        if rest is not None:
            yield rest


def before(motion: Motion, element: int, taken: float, length: float) -> Iterator[Motion]:
    """What is in front of that place. A piece of a move of a run is a line, as no NC block ends with it."""
    if isinstance(motion, Polyline):
        if element:
            yield moves(motion, 0, element)
        if taken > 0.0:
            for line in lines_of(moves(motion, element, element + 1)):
                rest = shortened(line, 0.0, length - taken, length)
                if rest is not None:
                    yield rest
    elif isinstance(motion, Polynomials):
        count = element + (taken > 0.0)
        if count:
            yield _polynomials_before(motion, count, taken, length)
    else:
        rest = shortened(motion, 0.0, length - taken, length)
        if rest is not None:
            yield rest


def begin_of(motion: Motion) -> Floats:
    """Where a motion begins, (n_axes,)."""
    if isinstance(motion, Polyline):
        begin: Floats = motion.points[0]
        return begin
    return motion.start


def _polynomials_behind(run: Polynomials, element: int, taken: float, length: float) -> Polynomials:
    coefficients = run.coefficients[element:].copy()
    if taken > 0.0:
        end = coefficients[0].sum(axis=0)
        part_of(run.coefficients[element], _parameter(run.coefficients[element], taken, length), 1.0, coefficients[0])
        coefficients[0, 1] += end - coefficients[0].sum(axis=0)  # rounding: the end stays
    return replace(
        run,
        coefficients=coefficients,
        feeds=run.feeds[element:],
        lines=run.lines[element:],
        numbers=run.numbers[element:],
        block_ends=run.block_ends[element:],
    )


def _polynomials_before(run: Polynomials, count: int, taken: float, length: float) -> Polynomials:
    coefficients, ends = run.coefficients[:count].copy(), run.block_ends[:count].copy()
    if taken > 0.0:
        last = run.coefficients[count - 1]
        part_of(last, 0.0, _parameter(last, taken, length), coefficients[-1])
        ends[-1] = False
    return replace(
        run,
        coefficients=coefficients,
        feeds=run.feeds[:count],
        lines=run.lines[:count],
        numbers=run.numbers[:count],
        block_ends=ends,
        end_feed=None,
    )


def _parameter(coefficients: Floats, taken: float, length: float) -> float:
    """The parameter at which a polynomial (6, n) is `taken` mm behind its begin."""
    n = coefficients.shape[1]
    split = min(MAIN_AXES, n)
    pieces = MOST_PARTS

    def lengths(first: int, last: int) -> Floats:
        ways = [way_between(coefficients, k / pieces, (k + 1) / pieces, first, last) for k in range(pieces)]
        return np.concatenate([[0.0], np.cumsum(ways)])

    first, last = 0, split
    borders = lengths(0, split)
    if abs(borders[-1] - length) > 0.5 * length:  # the main axes stand: measured along the others
        first, last = split, n
        borders = lengths(split, n)
    asked = taken * borders[-1] / length
    piece = min(int(np.searchsorted(borders, asked, side="right")) - 1, pieces - 1)
    low, high = piece / pieces, (piece + 1) / pieces
    for _ in range(50):  # halves the piece down to the last bit
        middle = 0.5 * (low + high)
        if borders[piece] + way_between(coefficients, piece / pieces, middle, first, last) < asked:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)
