"""Inside an arc with cutter compensation F holds at the contour: its centre goes F · Rc / R (manual lines 2123–2136)."""

from __future__ import annotations

from dataclasses import replace

import pytest

from runtime.cnc.blocks import Arc, Line
from runtime.config.nct import NctParameters
from tests.cnc.decoder.nct.programs import SETUP
from tests.cnc.decoder.nct.test_compensation import R, tool_path

LIMITED = replace(SETUP, nct=NctParameters(circover=80.0))


def feeds(text: str, limited: bool = False) -> list[tuple[str, float]]:
    path = tool_path(text, LIMITED if limited else SETUP)
    assert path.error is None, path.error
    return [(type(m).__name__, m.feed) for m in path.motions if isinstance(m, Line | Arc) and m.feed < 1e6]


@pytest.mark.spec("nct.feed.internal-circle-override")
def test_the_tool_is_slower_inside_an_arc() -> None:
    """D1 is 5 mm, so that the centre runs on a radius of 15 mm inside an arc of 20 mm."""
    text = "G0 X-20\nG41 G1 X0 D1 F100\nX40\nG3 X60 Y20 R20\nG1 Y40\nG40 X80\n"
    inside = feeds(text)
    assert [feed for name, feed in inside if name == "Arc"] == [pytest.approx(100 * (20 - R) / 20)]
    assert {feed for name, feed in inside if name == "Line"} == {100}
    assert [feed for name, feed in feeds(text, limited=True) if name == "Arc"] == [80.0]  # not below CIRCOVER
    outside = feeds(text.replace("G41", "G42"))
    assert {feed for _, feed in outside} == {100}
    uncompensated = feeds(text.replace("D1", "D0"))
    assert {feed for _, feed in uncompensated} == {100}
