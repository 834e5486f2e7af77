"""Hypothesis without deadlines (first calls compile kernels) and with the same examples in every run."""

from hypothesis import settings

settings.register_profile("tandem", deadline=None, derandomize=True)
settings.load_profile("tandem")
