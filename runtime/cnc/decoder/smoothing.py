"""What a program has selected of the smoothing methods: travels as small blocks to the stages of the path preparation."""

from __future__ import annotations

from dataclasses import dataclass, field

from runtime.cnc.blocks import Contouring, Segmentation, Spline, SplineKind

HSC_DEFAULT = Spline(SplineKind.HSC, deviation=0.2, tracking_deviation=5.0, greatest_angle=160.0)  # lines 9050–9100


@dataclass(slots=True)
class Smoothing:
    """State of a program: settings last until they are programmed anew, also while their method is off."""

    contouring: Contouring = field(default_factory=Contouring)
    contouring_on: bool = False
    own_track_distance: bool = False  # TRACK_DIST was programmed; until then it is PATH_DIST
    spline_kind: SplineKind = SplineKind.AKIMA
    akima: Spline = field(default_factory=lambda: Spline(SplineKind.AKIMA))
    spline_on: bool = False
    hsc: Spline = HSC_DEFAULT
    hsc_bspline: bool = False  # what #HSC ON selects: a B-spline, else transition polynomials
    contour_error: float = 0.1  # mm, of the transition polynomials
    hsc_on: bool = False
    segmentation: Segmentation = field(default_factory=Segmentation)
