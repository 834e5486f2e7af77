"""Zero offsets, G92, position preset, offsets left out in a block, software limits."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.blocks import SoftwareLimitChange
from runtime.cnc.decoder.memory import ChannelMemory
from runtime.diagnostics.catalogue import language as catalogue
from tests.cnc.decoder.paths import contours, ends, path, programmed
from tests.cnc.decoder.programs import SETUP, decode, found

_OPEN = (-math.inf, math.inf)


def entries(text: str) -> list[tuple[object, int]]:
    return [(entry, line) for entry, line, _ in found(text)]


def x_of(text: str) -> list[float]:
    return [end[0] for end in ends(text)]


@pytest.mark.spec("isg.g.reference-offset-g92", "isg.g.zero-offset-g53-g59")
@settings(max_examples=40)
@given(contours(), st.permutations(["G56", "G92 X3 Y-4 Z2", "#PSET X10"]))
def test_offsets_add_up_in_any_order(contour: str, order: list[str]) -> None:
    """The preset takes what is left: the position under it becomes 10 where it stands."""
    plain = decode(f"{contour}\nM30")
    moved = decode("G53 G00 X-20\n" + "\n".join(order) + f"\n{contour}\nM30")
    behind = order[order.index("#PSET X10") + 1 :]
    preset = -20 - 10 + sum({"G56": 300, "G92 X3 Y-4 Z2": 3}[word] for word in behind)
    np.testing.assert_allclose(path(moved)[1:], path(plain) + np.array([preset, 30 - 4, 3 + 2]), atol=1e-6)
    np.testing.assert_allclose(programmed(moved)[1:], programmed(plain), atol=1e-6)


@pytest.mark.spec("isg.g.reference-offset-g92")
def test_the_reference_offset_is_absolute_or_added_and_moves_nothing() -> None:
    text = "G00 X1 Y1\nG92 X10\nG91 X0\nG90 Y2\nX2\nG91\nG92 X5 Y3\nX1\nG90 X2 Y2\nG92 X0\nX2\nM30"
    assert ends(text) == [[1, 1, 0], [1, 1, 0], [1, 2, 0], [12, 2, 0], [13, 2, 0], [17, 5, 0], [2, 5, 0]]
    assert entries("G92\nM30") == [(catalogue.AXIS_ARGUMENT, 1)]
    assert x_of("G54\nG92 X5\nG55 G00 X0\nM30") == [205]


@pytest.mark.spec("isg.g.zero-offset-g159")
def test_extended_zero_offsets() -> None:
    assert x_of("G159=1 G00 X1\nG159=6 X1\nG159=0 X1\nP1 = 2\nG159=P1 X1\nG159=96 X1\nG54\nG91 G159=2 X1\nM30") == [
        101,
        601,
        1,
        201,
        1,
        2,
    ]
    for value in ("97", "-1", "1e9"):
        assert entries(f"G159={value}\nM30") == [(catalogue.ZERO_OFFSET_INDEX, 1)]
    assert entries("G54 G159=2\nM30") == [(catalogue.G_GROUP_TWICE, 1)]


@pytest.mark.spec("isg.g.zero-offset-g160")
def test_zero_offsets_of_single_axes() -> None:
    text = "G160=1 X0 Y1 Z0\nG54\nG00 X1 Y1 Z1\nG160=1 X1 Y0\nX1 Y1\nG54\nX1 Y1\nG55\nX1 Y1\nM30"
    assert ends(text) == [[101, 1, 2], [101, 1, 2], [1, 11, 2], [201, 21, 2]]
    assert entries("G160=1 X2\nM30") == [(catalogue.FLAG_VALUE, 1)]
    assert entries("G160=97 X1\nM30") == [(catalogue.ZERO_OFFSET_INDEX, 1)]
    assert entries("G160=1\nM30") == [(catalogue.AXIS_ARGUMENT, 1)]


@pytest.mark.spec("isg.g.zero-offset-g53-g59")
def test_a_configured_set_0_holds_from_program_start_on() -> None:
    setup = replace(SETUP, zero_offsets={53: np.array([7.0, 0.0, 0.0]), 54: np.array([1.0, 0.0, 0.0])})
    assert [end[0] for end in ends("G00 X1\nG54 X1\nG53 X1\nM30", setup=setup)] == [8, 2, 8]
    assert ChannelMemory(setup).zero_default == 0


# -- preset


@pytest.mark.spec("isg.add.pset", "isg.add.preset")
def test_position_preset() -> None:
    text = "G00 X40 Y10\n#PSET X20 Y30\nX10\nY30\nG91 X5\n#PSET X0\nG90 X1\n#PRESET X10\nX30 Y31\n#PRESET\nX30 Y31\nM30"
    assert [end[:2] for end in ends(text)] == [
        [40, 10],
        [30, 10],
        [30, 10],
        [35, 10],
        [36, 10],
        [30, 11],
        [30, 31],
    ]


@pytest.mark.spec("isg.add.pset")
def test_a_preset_under_scale_rotation_and_offsets() -> None:
    before = "G54\nG92 X1\n#SCALE ON X2\n#ROTATION ON [ANGLE=30 CENTER1=4]\nG00 X11 Y12\n#PSET X5 Y6\n"
    run = decode(f"{before}X5 Y6\nX6 Y6\nM30")
    first, again, further = run.ends
    np.testing.assert_allclose(again, first, atol=1e-9)
    np.testing.assert_allclose(np.array(further[:2]) - again[:2], [2 * math.cos(math.pi / 6), 1.0], atol=1e-9)
    single = decode(f"{before.replace(' Y6', '')}X5\nM30").ends
    np.testing.assert_allclose(single[1], single[0], atol=1e-9)  # the other coordinate is what it was


@pytest.mark.spec("isg.add.pset", "isg.add.preset")
@pytest.mark.parametrize("mirror", ["G21", "G22", "G351 Z-1"])
@pytest.mark.parametrize("statement", ["#PSET X1", "#PRESET", "#PRESET X0"])
def test_no_preset_while_mirroring_is_on(mirror: str, statement: str) -> None:
    assert entries(f"{mirror}\n{statement}\nM30") == [(catalogue.PRESET_MIRRORED, 2)]


# -- suppress


@pytest.mark.spec("isg.add.suppress-offsets")
def test_offsets_are_left_out_in_one_block() -> None:
    text = (
        "G54\nG92 X10 Y20\nG00 X100 Y150\n#SUPPRESS OFFSETS X50 Y100\n#SUPPRESS OFFSETS [ADD_ZERO] X50 Y100\n"
        "#SUPPRESS OFFSETS [ZERO ADD_ZERO] X7\nX200 Y250\n#PSET X0\n#SUPPRESS OFFSETS [PSET] X0 Y0\nX0\nM30"
    )
    run = decode(text)
    assert [end[:2] for end in run.ends] == [
        [210, 180],
        [50, 100],
        [150, 110],
        [7, 110],
        [310, 280],
        [110, 30],
        [310, 30],
    ]
    assert programmed(run)[1, :2].tolist() == [50, 100]


@pytest.mark.spec("isg.add.suppress-offsets")
def test_what_a_block_selects_holds_behind_it_too() -> None:
    assert x_of("G00 G54 X1\nG55 #SUPPRESS OFFSETS X1\nX1\nG91 #SUPPRESS OFFSETS X1\nG90 X1\nM30") == [
        101,
        1,
        201,
        202,
        201,
    ]
    assert x_of("G21\nG54 G00 X1\n#SUPPRESS OFFSETS X1\nX1\nM30") == [99, -1, 99]
    assert entries("#SUPPRESS OFFSETS\nM30") == [(catalogue.SUPPRESS_AXES, 1)]
    assert entries("#SUPPRESS OFFSETS [OTHER] X1\nM30") == [(catalogue.KEY_UNKNOWN, 1)]


@pytest.mark.spec("isg.add.suppress-offsets")
def test_a_rotation_is_not_left_out() -> None:
    np.testing.assert_allclose(
        ends("G54\n#ROTATION ON [ANGLE=90 CENTER1=5]\nG00 #SUPPRESS OFFSETS X10 Y0\nM30"), [[5, 10, 0]], atol=1e-12
    )


# -- software limits

_LIMITED = replace(SETUP, position_limits=((-100.0, 100.0), (None, None), (0.0, 50.0)))


def limits(text: str, clamped: bool = False) -> list[tuple[tuple[float, float], ...]]:
    run = decode(text, replace(_LIMITED, clamp_limits=clamped))
    assert run.problem is None, run.problem
    return [block.limits for block in run.blocks if isinstance(block, SoftwareLimitChange)]


@pytest.mark.spec("isg.g.soft-limits-g98-g99", "isg.g.soft-limits-extension")
def test_software_limits_are_changed_in_their_order() -> None:
    text = "G98 X-500 Y-5\nG99 X20\nG91\nG98 X10\nG99 X-5 Z1\nG70 G90\nG99 X1\nM30"
    assert limits(text) == [
        ((-500, 100), (-5, math.inf), (0, 50)),
        ((-500, 20), (-5, math.inf), (0, 50)),
        ((-490, 20), (-5, math.inf), (0, 50)),
        ((-490, 15), (-5, math.inf), (0, 51)),
        ((-490, 25.4), (-5, math.inf), (0, 51)),
    ]
    kinds = [type(block).__name__ for block in decode("G00 X1\nG98 X-1\nX2\nM30", _LIMITED).blocks]
    assert kinds == ["Polyline", "SoftwareLimitChange", "Polyline", "Stop"]


@pytest.mark.spec("isg.g.soft-limits-extension", "chan.sls.programmed")
def test_limits_may_be_kept_from_growing() -> None:
    assert limits("G98 X-500\nG99 X500 Z40\nG98 X-50\nM30", clamped=True) == [
        ((-100, 100), _OPEN, (0, 50)),
        ((-100, 100), _OPEN, (0, 40)),
        ((-50, 100), _OPEN, (0, 40)),
    ]
    run = decode("G98 X-500\nG99 X500\nM30", replace(_LIMITED, clamp_limits=True))
    assert [warning.entry for warning in run.decoder.warnings] == [
        catalogue.LIMIT_CLAMPED_NEGATIVE,
        catalogue.LIMIT_CLAMPED_POSITIVE,
    ]
    assert [warning.entry.id for warning in run.decoder.warnings] == [21648, 21650]


@pytest.mark.spec("isg.g.soft-limits-g98-g99")
def test_wrong_limits() -> None:
    assert [entry for entry, _, _ in found("G98 X100\nM30", _LIMITED)] == [catalogue.LIMITS_REVERSED]
    assert [entry for entry, _, _ in found("G99 Z-1\nM30", _LIMITED)] == [catalogue.LIMITS_REVERSED]
    assert [entry for entry, _, _ in found("G91\nG98 Y1\nM30", _LIMITED)] == [catalogue.LIMIT_OPEN]
    assert [entry for entry, _, _ in found("G98\nM30", _LIMITED)] == [catalogue.AXIS_ARGUMENT]
    assert [entry for entry, _, _ in found("G98 X1 G99 Y1\nM30", _LIMITED)] == [catalogue.G_GROUP_TWICE]
