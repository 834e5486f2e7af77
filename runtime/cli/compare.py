"""`tandem compare A B`: what differs between two traces of `tandem simulate --trace`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from runtime.scheduler.trace_difference import Difference


def command(
    first: Annotated[Path, typer.Argument(help="Folder of the trace to compare with.", show_default=False)],
    second: Annotated[Path, typer.Argument(help="Folder of the other trace.", show_default=False)],
    plot: Annotated[Path | None, typer.Option(help="Draw both into this PNG file.")] = None,
    lines: Annotated[int, typer.Option(min=0, help="Program lines shown, those with the most time won or lost.")] = 10,
) -> None:
    """Overlay two traces: time, greatest deviation of the paths, lines in which time is won or lost."""
    from runtime.scheduler.trace_difference import compare, read_trace

    if plot is not None:
        plot.open("ab").close()  # fails now, not after the work
    difference = compare(read_trace(first), read_trace(second))
    for text in told(difference, lines):
        print(text)
    if plot is not None:
        from runtime.cli.plot_compare import plot_difference

        plot_difference(plot, difference)
        print(f"picture {plot}")


def told(difference: Difference, lines: int) -> list[str]:
    """The comparison in words; times in s, signs as seen from the first trace."""
    a, b = difference.first, difference.second
    share = f" ({(b.time / a.time - 1.0) * 100.0:+.2f} %)" if a.time > 0.0 else ""
    found = [
        f"time {a.time:.3f} s and {b.time:.3f} s, difference {b.time - a.time:+.3f} s{share}",
        f"path {a.s[-1]:.3f} mm and {b.s[-1]:.3f} mm",
        f"greatest deviation {difference.deviation:.6f} mm in line {difference.line} at "
        + "  ".join(f"{axis} {value:.4f}" for axis, value in zip(a.axes, difference.place, strict=True)),
    ]
    ends = {axis: way for axis, way in difference.axes.items() if way > 1e-6}
    if ends:
        found.append("end positions differ by " + "  ".join(f"{axis} {way:.6f}" for axis, way in ends.items()))
    for name, trace, other in (("first", a, b), ("second", b, a)):
        found += [f"only the {name} one: {error}" for error in trace.errors if error not in other.errors]
    changed = [line for line in difference.lines if abs(line.won) > 0.5 * min(a.period, b.period)]
    if not changed:
        return [*found, "no line takes another time"]
    if lines:
        found.append(f"{'line':>8}  {'first [s]':>10}  {'second [s]':>10}  {'difference':>10}")
    found += [f"{one.line:>8}  {one.first:>10.3f}  {one.second:>10.3f}  {one.won:>+10.3f}" for one in changed[:lines]]
    rest = changed[lines:]
    if rest:
        found.append(f"and {len(rest)} more lines, together {sum(one.won for one in rest):+.3f} s")
    return found
