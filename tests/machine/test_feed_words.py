"""E word and G166 on the whole machine: what the path speed does."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from runtime.config.machine import Machine
from tests.machine.driven import Driven

PERIOD = 0.001


def speeds(driven: Driven, text: str, override: int) -> tuple[np.ndarray, np.ndarray]:
    """X and its velocity in mm/s over the cycles of a program at an override in 0.1 %."""
    driven.operator.override_w = override
    driven.start(text)
    while driven.channel.active and len(driven.targets) < 30_000:
        driven.watch(1)
    x = np.array(driven.targets)[:, 0]
    return x[1:], np.diff(x) / PERIOD


@pytest.mark.spec("isg.g.override-off-g166")
def test_override_counts_as_100_percent_in_a_block_with_g166(demo: Machine, tmp_path: Path) -> None:
    driven = Driven(demo, tmp_path)
    x, v = speeds(driven, "%P\nG01 F3000 X50\nG166 X100\nX150\nM30\n", 500)
    assert np.median(v[(x > 10) & (x < 45)]) == pytest.approx(25.0, abs=0.1)
    assert np.median(v[(x > 65) & (x < 95)]) == pytest.approx(50.0, abs=0.1)
    assert np.median(v[(x > 115) & (x < 145)]) == pytest.approx(25.0, abs=0.1)


@pytest.mark.spec("isg.mh.feed-e")
def test_the_speed_at_the_end_of_a_block_is_that_of_e(demo: Machine, tmp_path: Path) -> None:
    driven = Driven(demo, tmp_path)
    x, v = speeds(driven, "%P\nG01 F3000 X50 E600\nX100\nM30\n", 1000)
    assert v[np.argmin(np.abs(x - 50.0))] == pytest.approx(10.0, abs=0.5)
    assert v[(x > 10) & (x < 40)].max() == pytest.approx(50.0, abs=0.1)
    assert v[(x > 60) & (x < 90)].max() == pytest.approx(50.0, abs=0.1)
