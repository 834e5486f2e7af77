"""Channel parameters of the dynamics: slope at program start, path limits, weights by path length and by radius."""

from __future__ import annotations

from runtime.config.model import Model

TENTH_OF_MICRON = 1e-4  # mm or degrees
PER_MILLE = 1e-3


class SlopeAtStart(Model):
    """`prog_start.slope.*`."""

    profile: int | None = None  # P-CHAN-00071; not given: as the axes are described, with limited jerk
    acceleration: int = 0  # P-CHAN-00001, weights of acceleration act on: 0 all, 1 speeding up, 2 braking
    ramp_time: int = 0  # P-CHAN-00073, weights of ramp times act on: 0 all, 1 and 2 speeding up, 3 and 4 braking


class VectorParameters(Model):
    """`vector.*`: what #VECTOR LIMIT takes for limits that are not programmed."""

    acceleration: float = 100_000_000.0  # P-CHAN-00002
    deceleration: float = 100_000_000.0  # P-CHAN-00208
    radial_acceleration: float = 100_000_000.0  # P-CHAN-00361
    acc_dec_unit: str = "MM_M2"  # P-CHAN-00351: mm/min² or, MM_S2, mm/s²
    velocity: float = 2_000_000_000.0  # P-CHAN-00090, mm/min
    cir_radial_acc_limit: bool = False  # P-CHAN-00350: the limit of the path acceleration acts on circles too

    @property
    def per_second(self) -> bool:
        return self.acc_dec_unit == "MM_S2"

    def per_square_second(self, name: str) -> float:
        """An acceleration in mm/s². A default counts in mm/min², whatever the unit is (lines 3293, 3305)."""
        value: float = getattr(self, name)
        return value if self.per_second and name in self.model_fields_set else value / 3600.0


class PathWeight(Model):
    """`dynamic_weighting[i].*`: weights of straight moves that are shorter than `path_limit`."""

    path_limit: int = 0  # P-CHAN-00191, 0.1 µm
    velocity_fact: int = 0  # P-CHAN-00192, 0.1 %
    acceleration_fact: int = 0  # P-CHAN-00193, 0.1 %
    ramp_time_fact: int = 0  # P-CHAN-00194, 0.1 %

    @property
    def limit(self) -> float:
        """mm."""
        return self.path_limit * TENTH_OF_MICRON

    @property
    def factors(self) -> tuple[float, float, float]:
        """Of velocity, acceleration and ramp time."""
        return self.velocity_fact * PER_MILLE, self.acceleration_fact * PER_MILLE, self.ramp_time_fact * PER_MILLE


class RadiusWeight(Model):
    """`curve_dynamic_weighting[i].*`: weights of circles with a radius below `radius_limit`."""

    radius_limit: int = 0  # P-CHAN-00231, 0.1 µm
    velocity_fact: int = 0  # P-CHAN-00232, 0.1 %
    acceleration_fact: int = 0  # P-CHAN-00233, 0.1 %
    ramp_time_fact: int = 0  # P-CHAN-00234, 0.1 %

    @property
    def limit(self) -> float:
        """mm."""
        return self.radius_limit * TENTH_OF_MICRON

    @property
    def factors(self) -> tuple[float, float, float]:
        """Of velocity, acceleration and ramp time."""
        return self.velocity_fact * PER_MILLE, self.acceleration_fact * PER_MILLE, self.ramp_time_fact * PER_MILLE


class HscBsplineParameters(Model):
    """Start values of #HSC [BSPLINE], 0.1 µm and 0.0001 degrees."""

    path_deviation: float = 2000.0  # P-CHAN-00122
    track_deviation: float = 50_000.0  # P-CHAN-00123
    max_path_length: float = 0.0  # P-CHAN-00124
    max_angle: float = 0.0  # P-CHAN-00125
    auto_off_g00: bool = False  # P-CHAN-00128
    auto_off_path: bool = False  # P-CHAN-00129
    auto_off_track: bool = False  # P-CHAN-00130
    auto_contour_mode: int = 0  # P-CHAN-00239
    no_hsc_for_deviation_zero: bool = False  # P-CHAN-00241


class HscGeneralParameters(Model):
    """What else is said of HSC."""

    on_delay_output_one_block: bool = False  # P-CHAN-00217
    max_track_ratio: float = 100.0  # P-CHAN-00405, degrees per mm


class HscParameters(Model):
    """Start values of HSC."""

    bspline: HscBsplineParameters = HscBsplineParameters()
    gen: HscGeneralParameters = HscGeneralParameters()
