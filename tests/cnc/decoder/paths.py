"""The path of a decoded program as points, and random contours: the ground of the laws of coordinates."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import strategies as st

from runtime.cnc.blocks import Arc, Block, Floats, Line, Polyline, SpatialArc
from tests.cnc.decoder.programs import SETUP, Run, decode

PLACES = 8  # points of an arc


def motions(run: Run) -> list[Line | Arc | Polyline | SpatialArc]:
    return [block for block in run.blocks if isinstance(block, Line | Arc | Polyline | SpatialArc)]


def path(run: Run) -> Floats:
    """Points of the path in machine coordinates, (k, n): the ends of lines, PLACES points of every arc."""
    assert run.problem is None, run.problem
    return np.vstack([points for block in run.blocks for points in _points(block)])


def programmed(run: Run) -> Floats:
    """Programmed coordinates of the ends of all motions, (k, n)."""
    assert run.problem is None, run.problem
    return np.array([list(row["to_pcs"].values()) for row in run.rows if "to_pcs" in row])  # type: ignore[attr-defined]


def _points(block: Block) -> list[Floats]:
    if isinstance(block, Line):
        return [block.end]
    if isinstance(block, Polyline):
        return list(block.points[1:])
    return [_on_arc(block, place / PLACES) for place in range(1, PLACES + 1)] if isinstance(block, Arc) else []


def _on_arc(arc: Arc, share: float) -> Floats:
    first, second = arc.plane
    x, y = arc.start[first] - arc.centre[0], arc.start[second] - arc.centre[1]
    turn = math.radians(arc.angle * share)
    point: Floats = arc.start + share * (arc.end - arc.start)
    point[first] = arc.centre[0] + x * math.cos(turn) - y * math.sin(turn)
    point[second] = arc.centre[1] + x * math.sin(turn) + y * math.cos(turn)
    return point


def ends(text: str, start: tuple[float, ...] = (0, 0, 0), setup: object = SETUP) -> list[list[float]]:
    run = decode(text, setup, start=start)  # type: ignore[arg-type]
    assert run.problem is None, run.problem
    return run.ends


_steps = st.integers(-60, 60).map(lambda n: n / 2)
_sizes = st.integers(1, 40).map(lambda n: n / 2)


@st.composite
def contours(draw: st.DrawFn) -> str:
    """A contour in the plane X Y with lines, circles of every kind, contour lines and corners; its first block is absolute."""
    x, y = draw(_steps), draw(_steps)
    lines = [f"G00 X{x} Y{y} Z1", "F500"]
    for _ in range(draw(st.integers(1, 6))):
        to_x, to_y = draw(_steps), draw(_steps)
        circle = f"G0{draw(st.sampled_from('23'))}"
        i, j = draw(_sizes), draw(_steps)
        match draw(
            st.sampled_from(["line", "incremental", "radius", "full", "absolute centre", "opening", "angle", "corner"])
        ):
            case "line":
                lines.append(f"G01 X{to_x} Y{to_y}")
                x, y = to_x, to_y
            case "incremental":
                lines.append(f"G91 G01 X{to_x}\nG90")
                x += to_x
            case "radius":
                chord = math.hypot(to_x - x, to_y - y)
                if chord == 0:
                    continue
                sign = draw(st.sampled_from(["", "-"]))
                lines.append(f"{circle} X{to_x} Y{to_y} Z{i} R{sign}{chord / 2 + i:.3f}")
                x, y = to_x, to_y
            case "full":
                lines.append(f"{circle} I{i} J{j}")
            case "absolute centre":
                lines.append(f"G161 {circle} I{x + i} J{y + j}\nG162")
            case "opening":
                lines.append(f"{circle} I{i} J{j} #CANG=60")
                turn = math.radians(-60 if circle == "G02" else 60)
                centre = (x + i, y + j)
                x = centre[0] - i * math.cos(turn) + j * math.sin(turn)
                y = centre[1] - i * math.sin(turn) - j * math.cos(turn)
            case "angle":
                lines.append(f"G01 #ANG=30 X{x + i:.9f}")
                x, y = x + i, y + i * math.tan(math.radians(30))
            case "corner":
                kind = draw(st.sampled_from(["#RND=0.25", "#CHR=0.25", "#CHF=0.25", "G302=0.25", "G301=0.25"]))
                lines.append(f"G91 G01 X{i} {kind}\nY{i}\nX-{i}\nG301 I0.1\nX-1 Y2\nG90")
                x, y = x - 1, y + i + 2
    return "\n".join(lines)
