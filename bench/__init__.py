"""Measurements: `python -m bench` (or `make bench`). A module here is one subject, its `measure` gives the figures."""
