"""The picture of a milled path: plan view, side view, and the path velocity over time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import numpy.typing as npt

from runtime.config.machine import Machine

Arrays = Mapping[str, npt.NDArray[np.generic]]
_MAX_POINTS = 60_000  # more than the picture has room for


def rapid_threshold(machine: Machine) -> float:
    """Path velocity (mm/s) above which a move is drawn as rapid: 80 % of the slowest path axis."""
    return 0.8 * min(machine.axes[machine.axis_index(name)].velocity for name in machine.channels[0].axes)


def plot_path(path: Path, samples: Arrays, axes: tuple[str, ...], title: str, rapid_above: float) -> None:
    """Draw samples (`t` s, one array per axis in mm, `v_path` mm/s) into a PNG file.

    Parts faster than `rapid_above` mm/s are drawn thin and grey: they are rapid moves.
    """
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.collections import LineCollection

    stride = max(1, len(samples["t"]) // _MAX_POINTS)
    t = np.asarray(samples["t"][::stride], dtype=float)
    v = np.asarray(samples["v_path"][::stride], dtype=float)
    q = [np.asarray(samples[name][::stride], dtype=float) for name in axes[:3]]
    while len(q) < 3:
        q.append(np.zeros_like(t))
    figure = plt.figure(figsize=(11, 8.5), layout="constrained")
    grid = figure.add_gridspec(3, 1, height_ratios=[4, 1.4, 1.4])
    plan, side, speed = (figure.add_subplot(grid[i]) for i in range(3))
    depth = q[2]
    colours = plt.get_cmap("viridis")
    low, high = (float(depth.min()), float(depth.max())) if len(depth) else (0.0, 1.0)
    cut = v[1:] <= rapid_above
    for axes_, a, b, names in ((plan, q[0], q[1], (0, 1)), (side, q[0], q[2], (0, 2))):
        segments = np.stack([np.column_stack([a[:-1], b[:-1]]), np.column_stack([a[1:], b[1:]])], axis=1)
        axes_.add_collection(LineCollection(list(segments[~cut]), colors="#c0c0c0", linewidths=0.6))
        lines = LineCollection(list(segments[cut]), cmap=colours, linewidths=1.3)
        lines.set_array(depth[1:][cut])
        lines.set_clim(low, high)
        axes_.add_collection(lines)
        axes_.autoscale_view()
        labels = [axes[k] if k < len(axes) else "" for k in names]
        axes_.set_xlabel(f"{labels[0]} [mm]")
        axes_.set_ylabel(f"{labels[1]} [mm]")
        axes_.grid(visible=True, linewidth=0.3)
        if axes_ is plan:
            axes_.set_aspect("equal", adjustable="datalim")
            axes_.set_title(title)
            bar = figure.colorbar(lines, ax=axes_)
            bar.set_label(f"{axes[2] if len(axes) > 2 else ''} [mm]")
    speed.plot(t, v * 0.06, linewidth=0.7)
    speed.set_xlabel("time [s]")
    speed.set_ylabel("path velocity [m/min]")
    speed.grid(visible=True, linewidth=0.3)
    figure.savefig(path, dpi=110)
    plt.close(figure)
