"""What a program has selected of the smoothing methods: travels as small blocks to the stages of the path preparation."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import Enum
from typing import TYPE_CHECKING

from runtime.cnc.blocks import ContourChange, Contouring, JoinedBy, Segmentation, Spline, SplineKind
from runtime.cnc.filter_settings import FilterSettings
from runtime.config.channel.dynamics import HscParameters

if TYPE_CHECKING:
    from runtime.cnc.decoder.execution import Execution

HSC_DEFAULT = Spline(SplineKind.HSC, deviation=0.2, tracking_deviation=5.0, greatest_angle=160.0)  # lines 9050–9100
SURFACE_DEFAULT = Spline(  # lines 9223–9365
    SplineKind.SURFACE, deviation=0.2, tracking_deviation=2.0, greatest_angle=160.0, arcs=True
)


class HscMethod(Enum):
    """What #HSC ON selects, by the key of the statement."""

    TRANSITIONS = "OPMODE"
    BSPLINE = "BSPLINE"
    SURFACE = "SURFACE"


@dataclass(slots=True)
class Smoothing:
    """State of a program: settings last until they are programmed anew, also while their method is off."""

    contouring: Contouring = field(default_factory=Contouring)
    own_track_distance: bool = False  # TRACK_DIST was programmed; until then it is PATH_DIST
    spline_kind: SplineKind = SplineKind.AKIMA
    akima: Spline = field(default_factory=lambda: Spline(SplineKind.AKIMA))
    spline_on: bool = False
    hsc: Spline = HSC_DEFAULT
    surface: Spline = SURFACE_DEFAULT
    hsc_method: HscMethod = HscMethod.TRANSITIONS
    hsc_interpolating: bool = False  # OPMODE 2: curves through the points where the part is not prismatic
    contour_error: float = 0.1  # mm, of the transition polynomials
    least_cosine: float = 0.7  # of the change of direction, OPMODE 2
    longest_factor: float = 3.0  # of the median block length, OPMODE 2
    hsc_on: bool = False
    segmentation: Segmentation = field(default_factory=Segmentation)
    filter: FilterSettings = field(default_factory=FilterSettings)

    @classmethod
    def of(cls, check_jerk: int, hsc: Spline, filtered: bool) -> Smoothing:
        """The state at the start of a program; `check_jerk`: P-CHAN-00110, `hsc`: of #HSC [BSPLINE], `filtered`: an axis has
        its filter on (P-AXIS-00573)."""
        surface = replace(SURFACE_DEFAULT, check_jerk=check_jerk)
        return cls(Contouring(check_jerk=check_jerk), hsc=hsc, surface=surface, filter=FilterSettings(on=filtered))


def hsc_start(chosen: HscParameters) -> Spline:
    """What #HSC [BSPLINE] begins with (P-CHAN-00122 to 00130, 00217, 00239, 00405); an angle of 0 is the usual one."""
    given, general = chosen.bspline, chosen.gen
    return replace(
        HSC_DEFAULT,
        deviation=given.path_deviation * 1e-4,
        tracking_deviation=given.track_deviation * 1e-4,
        longest=given.max_path_length * 1e-4,
        greatest_angle=min(given.max_angle * 1e-4, 180.0) or HSC_DEFAULT.greatest_angle,
        without_rapid=given.auto_off_g00,
        sharp=given.auto_off_path,
        sharp_tracking=given.auto_off_track,
        most_tracking=general.max_track_ratio,
        delayed=general.on_delay_output_one_block,
        joined=JoinedBy(given.auto_contour_mode),
    )


def select_contouring(x: Execution, on: bool, keeps: bool = True) -> None:
    """G261, G260; `keeps`: the corner at the end of the motion before is not concerned."""
    x.modal.contouring = on
    x.emit(ContourChange(x.source, x.smoothing.contouring if on else None, keeps=keeps))
