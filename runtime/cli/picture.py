"""What all pictures share: colours that everybody can tell apart, curves with more samples than pixels, limits."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = npt.NDArray[np.float64]

# Okabe and Ito: distinct for every kind of colour vision
BLUE, ORANGE, GREEN, VERMILION, GREY = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#8C8C8C"
BINS = 2500  # columns of a curve; more samples than twice as many are drawn as the range of each column
CLIP = 2.2  # of a limit: what lies higher is told by a mark at the edge
OVER = 1.05  # of a limit: what lies higher is more than rounding


def use_files() -> None:
    """Draw into files only; where matplotlib keeps its fonts is nobody's concern here."""
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    import matplotlib as mpl

    mpl.use("Agg")
    mpl.rcParams.update({
        "font.size": 8, "axes.titlesize": 9, "axes.labelsize": 8, "axes.spines.top": False, "axes.spines.right": False,
        "axes.grid": True, "grid.linewidth": 0.3, "grid.color": "#c8c8c8", "legend.frameon": False, "legend.fontsize": 8,
    })  # fmt: skip


@dataclass(frozen=True, slots=True)
class Curve:
    """Columns of a curve: their places, and the least and greatest value in each, (columns,)."""

    x: Floats
    low: Floats
    high: Floats


def columns(x: Floats, y: Floats, bins: int = BINS) -> Curve:
    """A curve (k,) of growing `x` in at most twice `bins` columns; no peak is lost."""
    if len(x) <= 2 * bins:
        return Curve(x, y, y)
    size = -(-len(x) // bins)
    edges = np.arange(0, len(x), size)
    return Curve(x[edges], np.minimum.reduceat(y, edges), np.maximum.reduceat(y, edges))


def draw_curve(view: Axes, x: Floats, y: Floats, colour: str, label: str | None = None) -> None:
    """A curve, as a line or, where it has more samples than the picture columns, as their range."""
    curve = columns(x, y)
    if curve.low is curve.high:
        view.plot(x, y, color=colour, linewidth=0.8, label=label)
        return
    view.fill_between(curve.x, curve.low, curve.high, color=colour, linewidth=0.4, step="post", label=label)


def draw_limit(view: Axes, x: Floats, y: Floats, limit: float) -> None:
    """The limit on both sides of 0, and marks where the curve lies higher than the picture reaches."""
    for side in (-1.0, 1.0):
        view.axhline(side * limit, color=VERMILION, linewidth=0.9, linestyle=(0, (5, 2)))
    greatest = float(np.abs(y).max(initial=0.0))
    reach = limit * (1.15 if greatest <= OVER * limit else min(CLIP, 1.15 * greatest / limit))
    view.set_ylim(-reach, reach)
    above = np.flatnonzero(np.abs(y) > reach)
    if len(above):
        places = np.unique(np.round(x[above], 2))
        sides = np.interp(places, x[above], np.sign(y[above]))
        view.scatter(places, sides * reach * 0.97, marker="v", s=9.0, color=VERMILION, linewidths=0.0, zorder=3)
        view.text(
            0.995, 0.03, f"▼ up to {greatest:.4g}", transform=view.transAxes, ha="right", color=VERMILION, fontsize=7
        )
