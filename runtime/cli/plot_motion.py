"""The picture of a simulated program: path, path velocity, and what every axis does beside what it may do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from runtime.cli.picture import BLUE, GREY, VERMILION, draw_curve, draw_limit, use_files
from runtime.config.machine import Axis, AxisType, Machine

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import LineCollection

Arrays = Mapping[str, npt.NDArray[np.generic]]
Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
_MAX_POINTS = 40_000  # of the path: more than the picture has room for
_MARGIN = 0.06


@dataclass(frozen=True, slots=True)
class AxisPicture:
    """An axis: its limits, and for velocity, acceleration and jerk the unit and what a value is multiplied with."""

    name: str
    limits: tuple[float, float, float]
    units: tuple[str, str, str]
    scales: tuple[float, float, float]

    @classmethod
    def of(cls, axis: Axis) -> AxisPicture:
        limits = (axis.velocity, axis.acceleration, axis.jerk)
        if axis.type is AxisType.LINEAR:
            return cls(axis.name, limits, ("m/min", "m/s²", "m/s³"), (0.06, 1e-3, 1e-3))
        return cls(axis.name, limits, ("rev/min", "rev/s²", "rev/s³"), (1 / 6, 1 / 360, 1 / 360))


def pictures_of(machine: Machine, channel: int = 0) -> list[AxisPicture]:
    """The axes of a channel."""
    return [AxisPicture.of(machine.axes[machine.axis_index(name)]) for name in machine.channels[channel].axes]


def derivatives(position: Floats, period: float) -> tuple[Floats, Floats, Floats]:
    """Velocity, acceleration and jerk of set-points (k,), each (k,), differentiated from one cycle to the next."""
    values: list[Floats] = []
    value = position
    for _ in range(3):
        value = np.diff(value, prepend=value[:1]) / period
        values.append(value)
    return values[0], values[1], values[2]


def plot_motion(
    path: Path, samples: Arrays, rapid: Flags, axes: Sequence[AxisPicture], period: float, title: str
) -> None:
    """Draw samples of every cycle (`t` s, one array per axis, `v_path` mm/s) as PNG; `rapid` (k,): of a rapid move."""
    use_files()
    import matplotlib.pyplot as plt

    t = np.asarray(samples["t"], dtype=float)
    t = t - t[0]
    v = np.asarray(samples["v_path"], dtype=float) * 0.06
    positions = [np.asarray(samples[axis.name], dtype=float) for axis in axes]
    rows = len(axes)
    figure = plt.figure(figsize=(15.0, 2.0 + 1.75 * (rows + 1)), layout="constrained")
    figure.suptitle(f"{title}    {t[-1]:.3f} s", fontsize=11)
    left, right = figure.subfigures(1, 2, squeeze=False, width_ratios=[1.0, 1.75])[0]
    _path(left, positions, v, rapid, axes)
    grid = right.add_gridspec(rows + 1, 3)
    speed = right.add_subplot(grid[0, :])
    draw_curve(speed, t, v, BLUE)
    speed.set_ylabel("path velocity\n[m/min]")
    speed.set_ylim(bottom=0.0)
    for row, (axis, position) in enumerate(zip(axes, positions, strict=True)):
        for column, values in enumerate(derivatives(position, period)):
            view = right.add_subplot(grid[row + 1, column], sharex=speed)
            scale = axis.scales[column]
            draw_curve(view, t, values * scale, BLUE)
            draw_limit(view, t, values * scale, axis.limits[column] * scale)
            view.set_ylabel(f"{axis.name} [{axis.units[column]}]")
            if row == 0:
                view.set_title(("velocity", "acceleration", "jerk")[column])
            if row == rows - 1:
                view.set_xlabel("time [s]")
            else:
                view.tick_params(labelbottom=False)
    speed.plot([], [], color=VERMILION, linestyle=(0, (5, 2)), label="limit of the axis")
    speed.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98))
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _path(figure: object, positions: list[Floats], v: Floats, rapid: Flags, axes: Sequence[AxisPicture]) -> None:
    """Plan and side view; cuts are coloured by their speed."""
    stride = max(1, len(v) // _MAX_POINTS)
    q = [position[::stride] for position in positions[:3]]
    while len(q) < 3:
        q.append(np.zeros_like(q[0]))
    names = [f"{axis.name} [mm]" for axis in axes[:3]] + [""] * (3 - len(axes[:3]))
    speed, slow = v[::stride], ~np.asarray(rapid[::stride], dtype=np.bool_)
    moving = np.zeros(len(speed), dtype=np.bool_)
    moving[1:] = np.any([np.diff(values) != 0.0 for values in q], axis=0)
    cut = slow & moving
    grid = figure.add_gridspec(2, 1, height_ratios=[2.4, 1.0])  # type: ignore[attr-defined]
    plan, side = (figure.add_subplot(grid[i]) for i in range(2))  # type: ignore[attr-defined]
    top = float(speed[cut].max()) if cut.any() else 1.0
    for view, a, b in ((plan, 0, 1), (side, 0, 2)):
        lines = _draw(view, q[a], q[b], speed, cut, moving, top)
        view.set_xlabel(names[a])
        view.set_ylabel(names[b])
    plan.set_aspect("equal", adjustable="datalim")
    plan.plot([], [], color=GREY, linestyle="dashed", linewidth=0.8, label="rapid")
    plan.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98))
    figure.colorbar(lines, ax=[plan, side], label="path velocity [m/min]", location="bottom", shrink=0.8, aspect=40)  # type: ignore[attr-defined]


def _draw(view: Axes, a: Floats, b: Floats, speed: Floats, cut: Flags, moving: Flags, top: float) -> LineCollection:
    """The path in the plane of `a` and `b` (k,); `cut` and `moving` say of each point how the way to it was."""
    from matplotlib.collections import LineCollection

    points = np.column_stack([a, b])
    segments = np.stack([points[:-1], points[1:]], axis=1)
    way = (moving & ~cut)[1:]
    view.add_collection(LineCollection(list(segments[way]), colors=GREY, linewidths=0.6, linestyles="dashed"))
    lines = LineCollection(list(segments[cut[1:]]), cmap="viridis_r", linewidths=1.5)
    lines.set_array(speed[cut])
    lines.set_clim(0.0, top)
    view.add_collection(lines)
    seen = points[cut] if cut.any() else points
    low, high = seen.min(axis=0), seen.max(axis=0)
    margin = np.maximum((high - low) * _MARGIN, 1.0)
    view.set_xlim(low[0] - margin[0], high[0] + margin[0])
    view.set_ylim(low[1] - margin[1], high[1] + margin[1])
    return lines
