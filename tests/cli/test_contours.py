"""The contour in the picture of a simulation, and contour errors as `tandem check` and `tandem blocks` tell them."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from runtime.cli import main as cli
from runtime.cli.contours import contours_of, draw_contours
from runtime.config import load_machine

PART = """%PART
V.G.WZ_AKT.R = 5
G00 X-10 Y-10 Z5
G41 G01 X0 Y0 F1500
Y40
G02 X8 Y48 I8 J0
G01 X60
Y0
X-6
G40 X-12 Y-12
M30
"""


def test_programmed_contour_and_tool_are_told(tmp_path: Path) -> None:
    program = tmp_path / "part.nc"
    program.write_text(PART)
    (contour,) = contours_of(program, load_machine(None))
    assert contour.radius == 5.0
    assert contour.programmed[1].tolist() == [[0, 0], [0, 40]]
    for place in contour.discs()[1:-1]:
        nearest = min(
            float(np.hypot(*(place - (a + share * (b - a)))))
            for points in contour.programmed
            for a, b in pairwise(points)
            for share in np.linspace(0, 1, 200)
        )
        assert nearest == pytest.approx(5.0, abs=0.1)


def test_the_contour_of_an_nct_program(tmp_path: Path) -> None:
    program = tmp_path / "O0001.nc"
    program.write_text("%O0001\nG10 R5 L12 P1\nG0 X-10 Y-10\nG41 G1 X0 Y0 D1 F1500\nY40\nX60\nG40 X70 Y-12\nM30\n")
    (contour,) = contours_of(program, load_machine(None), "nct")
    assert contour.radius == 5.0
    g54 = load_machine(None).channels[0].zero_offsets["G54"]
    assert contour.programmed[1].tolist() == [[g54["X"], g54["Y"]], [g54["X"], g54["Y"] + 40]]


def test_they_are_drawn(tmp_path: Path) -> None:
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    program = tmp_path / "part.nc"
    program.write_text(PART)
    contours = contours_of(program, load_machine(None))
    figure, plan = plt.subplots()
    draw_contours(plan, contours)
    assert len(plan.collections) == 1
    assert len(plan.patches) == 2 * len(contours[0].discs())
    plt.close(figure)


@pytest.mark.spec("isg.trc.violation-detection")
@pytest.mark.parametrize("command", ["check", "blocks"])
def test_contour_errors_are_told_with_line_and_hint(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    program = tmp_path / "slot.nc"
    program.write_text("%SLOT\nV.G.WZ_AKT.R = 5\nG41 G01 X10 F1000\nX40\nY-20\nX48\nY0\nX80\nG40 X90\nM30\n")
    assert cli.main([command, str(program)]) == 1
    told = capsys.readouterr()
    text = told.out + told.err
    assert f"{program}:6:1: 309001: the tool of radius 5 mm does not fit" in text
    assert "    X48\n" in text
    assert "hint: use a smaller tool" in text
