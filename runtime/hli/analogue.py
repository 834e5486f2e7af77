"""Where analogue inputs and outputs stand in the process image, by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple


class OutputPlace(NamedTuple):
    """Place of an output, the limits of its value, and what it is without the machine; in its unit."""

    place: int
    least: float
    greatest: float
    off: float


class AnaloguePlaces(NamedTuple):
    """Those of a machine, counted through over the I/O nodes, in their order."""

    inputs: Mapping[str, int]
    outputs: Mapping[str, OutputPlace]
