"""Whatever is selected in whatever order: the path on the machine has no gap, and ends where the decoder says."""

from __future__ import annotations

from contextlib import suppress

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.blocks import Arc, Block, Floats, Line, Polyline, SpatialArc
from runtime.cnc.decoder.memory import ChannelMemory
from runtime.cnc.path_preparation import Frames, PathError, SpatialArcs
from runtime.cnc.tool_radius_comp import CompensationError, ToolRadiusCompensation
from runtime.cnc.tools.table import MemoryTools
from runtime.cnc.tools.tool import Tool
from tests.cnc.decoder.programs import SETUP, Run, decode

_SYSTEMS = ("10,0,0", "0,5,0,0,0,90", "1,2,3,10,20,30", "0,0,0,0,-45", "0,0,0,180,0,180")
_MOVES = (
    "G00 X5", "G01 Y7 Z2", "X1 Y2 Z3", "G91 X3\nG90", "G02 X10 Y4 R40", "G03 I4 J3", "G91 G03 X2 Y2 Z1 R3\nG90", "X-4",
    "G303 I30 J2 K3 X1 Y9 Z4",
    "G01 #ANG=30 X90", "G01 X40 #RND=0.1\nY44", "X1\nX2\nX3\nY1\nY2\nZ9",
)  # fmt: skip
_SELECTIONS = (
    "#CS OFF", "#CS OFF ALL", "#ACS OFF", "#ACS OFF ALL", "#BCS OFF", "#CS ON", "#ACS ON", "#CS DEF ACT",
    "#CS DEL", "#CS DEL ALL",
    "#CS MODE ON [ROTATION_SEQUENCE=XZX]", "#CS MODE ON [ROTATION_MODE_FIXED]", "#CS SELECT [A]", "#CS SELECT [B]",
    "#CS SET [A] [3,3,3,5,5,5]", "#CS TRACK [A] [1,1,1]", "#MCS ON", "#MCS ON EX TOOL", "#MCS OFF",
    "G53", "G54", "G55", "G92 X3", "G92 Y-2 Z1", "#PSET X8", "#PRESET", "#ROTATION ON [ANGLE=20 CENTER1=3]", "#ROTATION OFF",
    "G68 R10 X1 Y1",
    "#SCALE ON X2 Y2", "#SCALE OFF", "G20", "G21", "G23", "G351 X-1", "G351 X1", "D1", "D2", "D0",
    "G17", "G18", "G19", "G70", "G71",
    "G41 G138", "G40", "#CHANNEL INIT [CMDPOS]",
)  # fmt: skip
_words = st.one_of(
    st.sampled_from(_MOVES),
    st.sampled_from(_SELECTIONS),
    st.builds(
        "#{} {} [{}]".format,
        st.sampled_from(["CS", "ACS", "BCS"]),
        st.sampled_from(["ON", "DEF"]),
        st.sampled_from(_SYSTEMS),
    ),
    st.builds("#CS ADD [{}] [{}]".format, st.sampled_from("ABC"), st.sampled_from(_SYSTEMS)),
)


def _ends(block: Block) -> tuple[Floats, Floats] | None:
    if isinstance(block, Line | Arc | SpatialArc):
        return block.start, block.end
    return (block.points[0], block.points[-1]) if isinstance(block, Polyline) else None


def _on_machine(run: Run) -> list[tuple[Floats, Floats]]:
    made: list[tuple[Floats, Floats]] = []
    stages = SpatialArcs()(Frames()(ToolRadiusCompensation()(run.blocks)))
    with suppress(PathError, CompensationError):
        made.extend(ends for block in stages if (ends := _ends(block)) is not None)
    return made


@settings(max_examples=300)
@given(st.lists(_words, min_size=3, max_size=25))
def test_no_order_of_selections_makes_a_gap(words: list[str]) -> None:
    memory = ChannelMemory(SETUP, MemoryTools((Tool(number=1, length=30.0), Tool(number=2, length=5.0, radius=1.0))))
    run = decode("F500 G01\n" + "\n".join(words) + "\nM30", memory=memory, start=(1.0, 2.0, 3.0))
    motions = _on_machine(run)
    here = np.array([1.0, 2.0, 3.0])
    for start, end in motions:
        assert np.isfinite(end).all()
        np.testing.assert_allclose(start, here, atol=1e-6)
        here = end
    complete = run.problem is None and "G41" not in "".join(words)
    if complete:
        np.testing.assert_allclose(run.decoder.position, here, atol=1e-6)
