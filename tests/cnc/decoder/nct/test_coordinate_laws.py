"""Laws of the coordinates: whatever is switched on and off, only motions move, and numbers mean what stands there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.decoder import ChannelMemory
from runtime.cnc.tools.offset_table import MemoryOffsets, Register
from tests.cnc.decoder.nct.programs import SETUP, decode

FOUR = replace(
    SETUP,
    axes=("X", "Y", "Z", "C"),
    linear=(True, True, True, False),
    zero_offsets={54: np.array([1.0, 2, 3, 4]), 55: np.array([100.0, -50, 20, 0])},
    position_limits=((None, None), (None, None), (None, None), (-1e5, 1e5)),
)
NO_MOTION = (
    "G54", "G55", "G52 X5 Y-3", "G91 G52 Z2", "G90 G52 X0 Y0 Z0", "G92 X7 Z-1", "G92 Y0", "G10 X9 L2 P1", "G10 Y4 L2 P0",
    "H1", "H2", "G49", "G90", "G91", "G20", "G21", "D1", "G40",
)  # fmt: skip
ON_OFF = {
    "G68 X3 Y4 R30": "G69", "G68 R-75": "G69", "G51 X1 Y1 Z1 P2": "G50", "G51 P0.5": "G50",
}  # fmt: skip
MIRRORS = ("G51.1 X5", "G51.1 Y0 Z2", "G50.1 X0", "G50.1 Y0 Z0", "G51.1 C10", "G50.1 C0")
MOVES = (
    "G0 X10",
    "G0 Y-20 Z5",
    "G0 XI3",
    "G1 X1 Y2 Z3 C4 F100",
    "G43 Z10 H1",
    "G44 X5 H2",
    "H0 Z1",
    "G0 C30",
    "G53 X50 Z60",
)


@st.composite
def programs(draw: st.DrawFn) -> list[str]:
    """Blocks in which transformations are nested as they have to be."""
    blocks = ["G17"]
    ends: list[str] = []
    for _ in range(draw(st.integers(1, 14))):
        kinds = ["still", "move", "move", "on", "off"] + (["mirror"] if not ends else [])
        kind = draw(st.sampled_from(kinds))
        if kind == "still":
            blocks.append(draw(st.sampled_from(NO_MOTION)))
        elif kind == "move":
            blocks.append(draw(st.sampled_from(MOVES)))
        elif kind == "mirror":
            blocks.append(draw(st.sampled_from(MIRRORS)))
        elif kind == "on":
            code = draw(st.sampled_from(sorted(ON_OFF)))
            if ON_OFF[code] not in ends:
                blocks.append(code)
                ends.append(ON_OFF[code])
        elif ends:
            blocks.append(ends.pop())
    return blocks


@settings(deadline=None, derandomize=True)
@given(programs())
def test_only_motions_move_and_numbers_mean_what_stands_there(blocks: list[str]) -> None:
    registers = {("H", 1): Register(20.0), ("H", 2): Register(-7.5), ("D", 1): Register(5.0)}
    memory = ChannelMemory(FOUR, offsets=MemoryOffsets(registers))
    run = decode("\n".join(blocks), FOUR, memory=memory)
    assert run.problem is None, run.problem
    x = run.decoder.execution
    c = x.coordinates
    lines = [int(str(row["line"])) for row in run.rows if "to" in row]
    assert all(blocks[line - 1] in MOVES for line in lines)
    before = np.zeros(4)
    for line, end in zip(lines, run.ends, strict=True):
        moved = {"XYZC"[axis] for axis in np.flatnonzero(np.abs(np.array(end) - before) > 1e-9)}
        named = {letter for letter in "XYZC" if letter in blocks[line - 1]}
        turned = any(block.startswith("G68") for block in blocks[:line])
        assert moved <= named | ({"X", "Y"} if turned and named & {"X", "Y"} else set())
        before = np.array(end)
    there = c.machine_of(c.numbers)
    for axis in set(range(4)) - c.out_of_step:
        assert abs(there[axis] - c.position[axis]) < 1e-6


@settings(deadline=None, derandomize=True)
@given(programs(), st.lists(st.integers(-300, 300), min_size=4, max_size=4))
def test_absolute_words_lead_to_their_numbers(blocks: list[str], target: list[int]) -> None:
    """Whatever came before: an absolute positioning of all axes is shown as it is programmed, and lies where the chain says."""
    words = " ".join(f"{name}{value}" for name, value in zip("XYZC", target, strict=True))
    memory = ChannelMemory(FOUR, offsets=MemoryOffsets({("H", 1): Register(20.0), ("H", 2): Register(-7.5)}))
    run = decode("\n".join([*blocks, f"G21 G90 G0 {words}"]), FOUR, memory=memory)
    assert run.problem is None, run.problem
    c = run.decoder.execution.coordinates
    assert np.allclose(c.numbers, target)
    offsets = [
        c.offsets.zero[i] + c.common[i] + c.shifted[i] + c.local[i] + c.length[i] + c.displaced[i] for i in range(4)
    ]
    assert np.allclose(c.position, np.array(c.transformations.image([float(t) for t in target])) + offsets, atol=1e-6)
