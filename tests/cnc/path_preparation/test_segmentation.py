"""#SEGMENTATION: long blocks in pieces; the path stays, or is as far from it as the chord error says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from runtime.cnc.blocks import Arc, Polyline
from runtime.diagnostics.catalogue import smoothing as catalogue
from tests.cnc.decoder.programs import decode
from tests.cnc.path_preparation.smoothed_paths import Smoothed, deviation, ends_meet, smoothed

pytestmark = pytest.mark.spec("isg.add.segmentation")


def lengths(program: Smoothed) -> list[float]:
    """Lengths of the straight pieces."""
    runs = [block.points for block in program.blocks if isinstance(block, Polyline)]
    return [float(length) for run in runs for length in np.linalg.norm(np.diff(run, axis=0), axis=1)]


@pytest.mark.parametrize(("text", "longest"), [("LIN", 1.0), ("LIN LENGTH 0.5", 0.5), ("LIN LENGTH=7", 7.0)])
def test_lines_in_pieces(text: str, longest: float) -> None:
    program = smoothed(
        f"#SEGMENTATION ON [{text}]\nG01 F1000 X3 Y25\nX15 Y15\nX15 Y15.2\n#SEGMENTATION OFF [LIN]\nX90\nM30"
    )
    pieces = lengths(program)
    assert max(pieces[:-1]) <= longest * (1 + 1e-9)
    assert pieces[-1] == pytest.approx(75.0)
    assert len(pieces) == math.ceil(math.hypot(3, 25) / longest) + math.ceil(math.hypot(12, 10) / longest) + 2
    assert deviation(program) < 1e-9
    ends = sum(len(b.feeds) if not b.one_block else 0 for b in program.blocks if isinstance(b, Polyline))
    assert ends == 4  # each block still ends once


def test_arcs_as_lines_within_an_error_or_of_a_length() -> None:
    arc = "G02 F1000 X20 Y0 I10 J0 Z3\nM30"
    within = smoothed(f"#SEGMENTATION ON [CIR OPMODE=1 PARAM=0.05]\n{arc}")
    assert 0.03 < deviation(within) <= 0.05 + 1e-6
    pieces = lengths(smoothed(f"#SEGMENTATION ON [CIR OPMODE=0 PARAM=2]\n{arc}"))
    assert max(pieces) <= 2.0
    assert len(pieces) == math.ceil(math.hypot(10 * math.pi, 3) / 2)
    assert ends_meet(within.blocks) < 1e-12


def test_arcs_as_shorter_arcs() -> None:
    program = smoothed("#SEGMENTATION ON [CIR OPMODE=2 PARAM=5]\nG03 F1000 X20 Y0 I10 J0 Z3\nM30")
    arcs = [block for block in program.blocks if isinstance(block, Arc)]
    assert len(arcs) == math.ceil(math.hypot(10 * math.pi, 3) / 5)
    assert sum(arc.angle for arc in arcs) == pytest.approx(180.0)
    assert deviation(program) < 2e-4  # chords of the judge
    assert arcs[-1].end.tolist() == pytest.approx([20.0, 0.0, 3.0])


def test_lines_and_arcs_are_switched_separately() -> None:
    text = "G01 F1000 X10\nG02 X20 Y0 I5 J0\nM30"
    both = smoothed(f"#SEGMENTATION ON ALL\n{text}")
    assert not any(isinstance(block, Arc) for block in both.blocks)
    assert max(lengths(both)) <= 1.0 + 1e-9
    lines = smoothed(f"#SEGMENTATION ON ALL\n#SEGMENTATION OFF [CIR]\n{text}")
    assert any(isinstance(block, Arc) for block in lines.blocks)
    assert smoothed(f"#SEGMENTATION ON ALL\n#SEGMENTATION OFF ALL\n{text}").motions[0] is not None
    assert lengths(smoothed(f"#SEGMENTATION ON ALL\n#SEGMENTATION OFF ALL\n{text}")) == [pytest.approx(10.0)]


@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("[LIN LENGTH=0]", catalogue.VALUE_RANGE),
        ("[LIN LENGTH=-1]", catalogue.VALUE_RANGE),
        ("[CIR OPMODE=3]", catalogue.VALUE_RANGE),
        ("[LIN PARAM=1]", catalogue.OF_OTHER_METHOD),
    ],
)
def test_wrong_arguments(text: str, entry: object) -> None:
    run = decode(f"#SEGMENTATION ON {text}\nG01 F1000 X1\nM30")
    assert run.problem is not None
    assert run.problem.entry is entry
