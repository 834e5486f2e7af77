"""Look-ahead, velocity profile and evaluation of the path, in the cycle."""

from runtime.cnc.interpolator.interpolator import Interpolator, Track

__all__ = ["Interpolator", "Track"]
