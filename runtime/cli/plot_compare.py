"""The picture of a comparison: both paths, their distance, speed and time over the way."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from runtime.cli.picture import BLUE, GREEN, GREY, ORANGE, VERMILION, draw_curve, use_files
from runtime.scheduler.trace_difference import Difference, Trace

Floats = npt.NDArray[np.float64]
_MAX_POINTS = 60_000


def plot_difference(path: Path, difference: Difference) -> None:
    """Draw a comparison as PNG. Both stand over the way of the first path, so that the same places lie above each other."""
    use_files()
    import matplotlib.pyplot as plt

    a, b = difference.first, difference.second
    names = _names(a, b)
    figure = plt.figure(figsize=(15.0, 8.5), layout="constrained")
    figure.suptitle(f"{names[0]}  {a.time:.3f} s     {names[1]}  {b.time:.3f} s", fontsize=11)
    left, right = figure.subfigures(1, 2, squeeze=False, width_ratios=[1.0, 1.5])[0]
    plan = left.add_subplot()
    for trace, colour, name, width, style in (
        (a, BLUE, names[0], 2.4, "solid"), (b, ORANGE, names[1], 1.0, "solid"),
    ):  # fmt: skip
        stride = max(1, len(trace.t) // _MAX_POINTS)
        plan.plot(*_plane(trace, stride), color=colour, linewidth=width, linestyle=style, label=name)
    worst = difference.place
    if difference.deviation > 0.0:
        text = f"{difference.deviation:.4g} mm, line {difference.line}"
        plan.plot(
            worst[0], worst[1] if len(worst) > 1 else 0.0, marker="o", markersize=9, markerfacecolor="none",
            markeredgecolor=VERMILION, linestyle="none", label=f"greatest deviation: {text}",
        )  # fmt: skip
    plan.set_aspect("equal", adjustable="datalim")
    plan.set_xlabel(f"{a.axes[0]} [mm]")
    plan.set_ylabel(f"{a.axes[1]} [mm]" if len(a.axes) > 1 else "")
    plan.legend(loc="upper left", bbox_to_anchor=(0.0, -0.06))
    speed, time, off = right.subplots(3, 1, sharex=True, height_ratios=[2.0, 1.2, 1.0])
    way = a.s
    draw_curve(speed, way, a.v_path * 0.06, BLUE, names[0])
    order = np.maximum.accumulate(difference.at)
    draw_curve(speed, order, b.v_path * 0.06, ORANGE, names[1])
    speed.set_ylabel("path velocity [m/min]")
    speed.set_ylim(bottom=0.0)
    speed.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=2)
    there, lead = _lead(a, way, b, order)
    time.axhline(0.0, color=GREY, linewidth=0.8)
    draw_curve(time, there, lead, GREEN)
    time.set_ylabel(f"time of {names[1]}\nafter {names[0]} [s]")
    draw_curve(off, order, difference.distance * 1e3, VERMILION)
    off.set_ylabel("distance of\nthe paths [µm]")
    off.set_ylim(bottom=0.0)
    off.set_xlabel(f"way along the path of {names[0]} [mm]")
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _names(a: Trace, b: Trace) -> tuple[str, str]:
    first, second = a.folder.name or str(a.folder), b.folder.name or str(b.folder)
    return (first, second) if first != second else (str(a.folder), str(b.folder))


def _plane(trace: Trace, stride: int) -> tuple[Floats, Floats]:
    x = trace.positions[::stride, 0]
    return x, trace.positions[::stride, 1] if trace.positions.shape[1] > 1 else np.zeros_like(x)


def _lead(a: Trace, way: Floats, b: Trace, order: Floats) -> tuple[Floats, Floats]:
    """Places of the first path, and how much later the second trace leaves each of them, s."""
    places, last = np.unique(way[::-1], return_index=True)
    there, behind = np.unique(order[::-1], return_index=True)
    lead: Floats = b.t[len(order) - 1 - behind] - np.interp(there, places, a.t[len(way) - 1 - last])
    return there, lead
