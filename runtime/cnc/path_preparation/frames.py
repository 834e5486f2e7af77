"""Rotated coordinate systems (#CS, #ACS, #BCS): what the decoder and the radius compensation have made in the axes of the
system becomes motion of the machine.

    decoder, radius compensation ─ motions in the frame ─▶ this stage ─ motions of the machine axes ─▶ arcs in space, smoothing …

A rotation keeps lengths and angles: a line becomes a line, an arc an arc in space, a polynomial a polynomial, and the feed is
the same. So nothing behind this stage knows of a frame, and software limits are those of the machine. As long as no frame is
active, every block passes as it is.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from runtime.cnc.blocks import Arc, Block, Floats, FrameChange, Line, Polyline, Polynomials, SpatialArc
from runtime.cnc.geometry.frames import Frame
from runtime.cnc.path_preparation.errors import PathError
from runtime.cnc.path_preparation.spatial_arcs import in_parts
from runtime.diagnostics.catalogue import coordinates as catalogue
from runtime.diagnostics.errors import Place

MAIN = 3
POSITION_LIMIT = 214_000.0  # mm (programming manual line 1974): what a position on the machine may be

_Motion = Line | Arc | SpatialArc | Polyline | Polynomials


class Frames:
    """The stage. Raises PathError for a place beyond the range of positions, and for a tilted arc with a feed at its end."""

    def __call__(self, blocks: Iterable[Block]) -> Iterator[Block]:
        frame: _Mapped | None = None
        for block in blocks:
            if isinstance(block, FrameChange):
                frame = None if block.frame is None else _Mapped(block.frame)
            elif frame is not None and isinstance(block, _Motion):
                yield frame.motion(block)
            else:
                yield block


class _Mapped:
    """Motions in a frame, on the machine."""

    def __init__(self, frame: Frame) -> None:
        self._frame = frame

    def motion(self, block: _Motion) -> Block:
        if isinstance(block, Polyline):
            points = self._places(block.points)
            _expect_in_range(points[1:], block.program, block.lines)
            return replace(
                block,
                points=points,
                pcs_shift=self._place(block.pcs_shift),
                pcs_gain=self._gain(block.pcs_gain, len(points[0])),
            )
        if isinstance(block, Polynomials):
            return self._polynomials(block)
        gain = self._gain(block.pcs_gain, len(block.start))
        start, end = self._place(block.start), self._place(block.end)
        _expect_in_range(end[None, :], block.source.program, [block.source.line])
        if isinstance(block, Line):
            return replace(block, start=start, end=end, pcs_gain=gain)
        if isinstance(block, SpatialArc):
            return replace(
                block, start=start, end=end, pcs_gain=gain,
                centre=self._frame.outer(block.centre), normal=self._frame.rotation @ block.normal,
            )  # fmt: skip
        return self._arc(block, start, end, gain)

    def _place(self, place: Floats) -> Floats:
        """A place (n,) on the machine."""
        made = place.copy()
        made[:MAIN] = self._frame.outer(place[:MAIN])
        return made

    def _places(self, places: Floats) -> Floats:
        """Places (k, n) on the machine."""
        made = places.copy()
        made[:, :MAIN] = self._frame.outer(places[:, :MAIN])
        return made

    def _gain(self, gain: Floats | None, axes: int) -> Floats:
        """Machine way per programmed way, (n, n)."""
        made = np.eye(axes)
        made[:MAIN, :MAIN] = self._frame.rotation
        return made if gain is None else made * gain

    def _polynomials(self, run: Polynomials) -> Polynomials:
        made = run.coefficients.copy()
        made[:, :, :MAIN] = made[:, :, :MAIN] @ self._frame.rotation.T
        made[:, 0, :MAIN] += self._frame.origin
        axes = made.shape[2]
        _expect_in_range(made.sum(axis=1), run.program, run.lines)
        return replace(
            run, coefficients=made, pcs_shift=self._place(run.pcs_shift), pcs_gain=self._gain(run.pcs_gain, axes)
        )

    def _arc(self, arc: Arc, start: Floats, end: Floats, gain: Floats) -> Block:
        """An arc of a main plane of the frame: one of the machine where their planes are parallel, else one in space."""
        first, second = arc.plane
        third = MAIN - first - second
        centre = np.empty(MAIN)
        centre[first], centre[second], centre[third] = arc.centre[0], arc.centre[1], arc.start[third]
        sense = 1.0 if arc.angle >= 0.0 else -1.0  # the planes are right-handed: positive turns about the third axis
        spatial = SpatialArc(
            arc.source, start, end, arc.feed, arc.end_pcs, self._frame.outer(centre),
            self._frame.rotation[:, third] * sense, abs(arc.angle), gain,
        )  # fmt: skip
        flat = in_parts(spatial)
        if isinstance(flat, Arc):
            return replace(flat, end_feed=arc.end_feed, override_off=arc.override_off)
        if arc.end_feed is not None or arc.override_off:
            word = "E" if arc.end_feed is not None else "G166"
            raise PathError(catalogue.TILTED_ARC, Place(arc.source.program, arc.source.line), word=word)
        return spatial


def _expect_in_range(places: Floats, program: str, lines: Iterable[int]) -> None:
    """PathError for a place (k, n) on the machine that is further away than positions may be; `lines`: of each."""
    if places.size and np.abs(places[:, :MAIN]).max() > POSITION_LIMIT:
        beyond = np.abs(places[:, :MAIN]) > POSITION_LIMIT
        at = int(np.argmax(beyond.any(axis=1)))
        axis = int(np.argmax(beyond[at]))
        place = Place(program, int(list(lines)[at]))
        raise PathError(catalogue.BEYOND, place, number=axis + 1, value=float(places[at, axis]), limit=POSITION_LIMIT)
