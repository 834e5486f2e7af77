"""The picture of a milled path: plan view, side view, and the path velocity over time."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import LineCollection

Arrays = Mapping[str, npt.NDArray[np.generic]]
Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
_MAX_POINTS = 60_000  # more than the picture has room for
_MARGIN = 0.12  # of the size of what is cut, left free around it
_RAPID_COLOUR = "#b0b0b0"


def plot_path(path: Path, samples: Arrays, rapid: Flags, axes: tuple[str, ...], title: str) -> None:
    """Draw samples (`t` s, one array per axis in mm, `v_path` mm/s; `rapid` where a sample is of a rapid move) as PNG.

    Cuts are coloured by their depth, the third axis; rapid moves are thin and grey, and end where the picture does.
    """
    logging.getLogger("matplotlib").setLevel(logging.ERROR)  # where it keeps its fonts is nobody's concern here
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    stride = max(1, len(rapid) // _MAX_POINTS)
    t = np.asarray(samples["t"][::stride], dtype=float)
    v = np.asarray(samples["v_path"][::stride], dtype=float)
    q = [np.asarray(samples[name][::stride], dtype=float) for name in axes[:3]]
    while len(q) < 3:
        q.append(np.zeros_like(t))
    names = [f"{name} [mm]" for name in axes[:3]] + [""] * (3 - len(axes))
    standing = np.zeros(len(t), dtype=np.bool_)
    standing[1:] = np.all([np.diff(values) == 0.0 for values in q], axis=0)
    cut = ~np.asarray(rapid[::stride], dtype=np.bool_) & ~standing
    cut[:1] = False

    figure = plt.figure(figsize=(9, 9), layout="constrained")
    grid = figure.add_gridspec(3, 1, height_ratios=[5, 1.3, 1.3])
    plan, side, speed = (figure.add_subplot(grid[i]) for i in range(3))
    depth = (float(q[2][cut].min()), float(q[2][cut].max())) if cut.any() else (0.0, 1.0)
    for view, a, b in ((plan, 0, 1), (side, 0, 2)):
        lines = _draw(view, q[a], q[b], q[2], cut, depth)
        view.set_xlabel(names[a])
        view.set_ylabel(names[b])
        view.grid(visible=True, linewidth=0.3)
    _dots(plan, q, cut, depth)
    plan.set_aspect("equal")
    plan.set_title(title)
    figure.colorbar(lines, ax=plan, label=names[2])
    speed.plot(t - t[0], v * 0.06, linewidth=0.7)
    speed.set_xlabel("time [s]")
    speed.set_ylabel("path velocity\n[m/min]")
    speed.grid(visible=True, linewidth=0.3)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw(view: Axes, a: Floats, b: Floats, depth: Floats, cut: Flags, range_: tuple[float, float]) -> LineCollection:
    """The path in the plane of `a` and `b` (n,), n ≥ 2; `cut` says of each point whether the way to it was a cut."""
    from matplotlib.collections import LineCollection

    points = np.column_stack([a, b])
    segments = np.stack([points[:-1], points[1:]], axis=1)
    rapid = list(segments[~cut[1:]])
    view.add_collection(LineCollection(rapid, colors=_RAPID_COLOUR, linewidths=0.7, linestyles="dashed"))
    lines = LineCollection(list(segments[cut[1:]]), cmap="viridis", linewidths=1.4)
    lines.set_array(depth[cut])
    lines.set_clim(*range_)
    view.add_collection(lines)
    seen = points[cut] if cut.any() else points
    low, high = seen.min(axis=0), seen.max(axis=0)
    margin = np.maximum((high - low) * _MARGIN, 1.0)
    view.set_xlim(low[0] - margin[0], high[0] + margin[0])
    view.set_ylim(low[1] - margin[1], high[1] + margin[1])
    return lines


def _dots(plan: Axes, q: list[Floats], cut: Flags, range_: tuple[float, float]) -> None:
    """A cut along the line of sight, as of a drill, has no length in the plan: a dot where it ends."""
    upright = cut.copy()
    upright[1:] &= (np.diff(q[0]) == 0.0) & (np.diff(q[1]) == 0.0)
    ends = upright & ~np.append(upright[1:], False)
    plan.scatter(q[0][ends], q[1][ends], c=q[2][ends], s=16.0, cmap="viridis", vmin=range_[0], vmax=range_[1])
