"""The picture of `tandem drive tune --plot`: following error, velocity and torque of a drive over the time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from runtime.cli.picture import BLUE, GREEN, GREY, ORANGE, draw_curve, use_files
from runtime.fieldbus.jog import Sample


def plot(samples: Sequence[Sample], path: Path, axis: str, unit: str) -> None:
    """Draw a tuning run into a PNG file. Raises OSError."""
    use_files()
    from matplotlib import pyplot

    table = np.array([
        (s.time, s.following_error, s.target_velocity, s.velocity, s.torque) for s in samples
    ])  # fmt: skip
    time, error, target, velocity, torque = table.T
    time = time - time[0]
    told = not math.isnan(float(np.nanmax(torque, initial=-math.inf))) and bool((~np.isnan(torque)).any())
    figure, views = pyplot.subplots(3 if told else 2, 1, sharex=True, figsize=(10, 7), layout="constrained")
    draw_curve(views[0], time, velocity, BLUE, "drive")
    draw_curve(views[0], time, target, ORANGE, "set-point")
    views[0].set_ylabel(f"velocity, {unit}/s")
    draw_curve(views[1], time, error, GREEN)
    views[1].set_ylabel(f"following error, {unit}")
    if told:
        draw_curve(views[2], time, torque, GREY)
        views[2].set_ylabel("torque, ‰ of rated")
    views[0].legend(loc="upper right")
    views[0].set_title(f"Drive of axis {axis}")
    views[-1].set_xlabel("time, s")
    figure.savefig(path, dpi=120)
    pyplot.close(figure)
