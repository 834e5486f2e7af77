"""Constant surface speed (manual lines 2542–2624): n = v / (2 π r), by what the program gives the cycle and orders itself."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from runtime.cnc.blocks import CuttingSpeed, Line, Polyline, Technology, TechnologyFunction
from runtime.cnc.decoder import DecoderSetup
from runtime.cnc.decoder.memory import ChannelMemory
from runtime.cnc.decoder.setup import AxisDynamics
from runtime.config.nct import NctParameters
from runtime.diagnostics.catalogue import nct as C  # noqa: N812
from tests.cnc.decoder.nct.programs import SETUP, decode

SPINDLE = replace(SETUP.spindles[0], dynamics=AxisDynamics(6.0 * 8000.0, 1.0, 1.0))
TURNED = replace(SETUP, spindles=(SPINDLE,))


def told(text: str, setup: DecoderSetup = TURNED, memory: ChannelMemory | None = None) -> list[object]:
    """M for a motion; n of an order to the spindle; (velocity, axis) of what the cycle follows."""
    run = decode(text, setup, memory=memory, start=(100.0, 50.0, 0.0))
    assert run.problem is None, run.problem
    found: list[object] = []
    for block in run.blocks:
        if isinstance(block, CuttingSpeed):
            found.append((block.velocity, block.axis))
        elif isinstance(block, TechnologyFunction) and block.kind is Technology.S:
            found.append(round(block.value, 3))
        elif isinstance(block, Line | Polyline):
            found.append("M")
    return found


def n(metres: float, radius: float) -> float:
    return round(metres * 1000 / (2 * math.pi * radius), 3)


@pytest.mark.spec("nct.spindle.css-g96-g97")
def test_the_speed_follows_the_axis() -> None:
    assert told("G96 S100 M3\nG1 X50 F100\nZ5\nG97 S1500\nG1 X40\n") == [
        n(100, 100), (100_000, 0), "M", "M", (0.0, 0), 1500, "M"
    ]  # fmt: skip
    # in rapid only the speed of the end is ordered, in front of the motion
    assert told("G96 S100 M3\nG0 X50\nG1 X40 F100\nG0 X20\n") == [
        n(100, 100), n(100, 50), "M", (100_000, 0), "M", (0.0, 0), n(100, 20), "M"
    ]  # fmt: skip
    # without a turning spindle nothing follows
    assert told("G96 S100\nG1 X50 F100\nM3\nG1 X40\n") == ["M", n(100, 50), (100_000, 0), "M"]


@pytest.mark.spec("nct.spindle.css-g96-g97")
def test_what_is_remembered() -> None:
    # the example of the manual: G97 and a bare G96 take their own values again
    text = "G96 S100 M3\nG97 S1500\nG96 G1 X90 F100\n"
    assert told(text) == [n(100, 100), 1500, (100_000, 0), "M"]
    run = decode("G96 S100 M3\nG1 X50 F100\nG97\nM30\n", TURNED, start=(100.0, 0.0, 0.0))
    assert run.decoder.modal.speed == pytest.approx(100_000 / (2 * math.pi * 50))  # the last speed stays
    memory = ChannelMemory(TURNED)
    told("G96 S100 P2\nG92 S300\n", memory=memory)
    assert told("G96 M3\n", memory=memory) == [300]  # 318 at Y50, but not more than G92 S
    assert told("G96 M3\n", replace(TURNED, nct=NctParameters(ctsurfsp=50.0, axis="Y"))) == [n(50, 50)]
    feet = n(100 * 0.3048, 100)
    assert told("G20 G96 S100 M3\n") == [feet]


@pytest.mark.spec("nct.spindle.css-clamp-axis")
def test_greatest_speed_and_axis() -> None:
    assert told("G92 S200\nG96 S100 M3\n") == [n(100, 100)]
    assert told("G92 S100\nG96 S100 M3\n") == [100]
    assert told("G96 S100 P2 M3\nG1 Y20 F100\n") == [n(100, 50), (100_000, 1), "M"]
    assert told("G96 S9000 M3\n") == [8000]  # what the spindle can
    for text, entry in (
        ("G96 P10\n", C.FAULTY_P),
        ("G96 P9\n", C.AXIS_MISSING),
        ("G92 S0\n", C.VALUE_EXCESS),
    ):
        problem = decode(text, TURNED).problem
        assert problem is not None
        assert problem.entry is entry
    problem = decode("G96 S1\n", replace(SETUP, spindles=())).problem
    assert problem is not None
    assert problem.entry is C.SURFACE_SPINDLE
