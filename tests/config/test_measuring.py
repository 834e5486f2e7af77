"""What the machine description says of probes has to fit together."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.config import load_machine
from runtime.config.loader import DEMO_MACHINE, ConfigurationError

PROBE = "    measuring: {{{0}}}\n    drive: {{node: 2, process_data: [{1}], "


def described(folder: Path, measuring: str, data: str = "probe_1_rising", fieldbus: str = "") -> Path:
    text = DEMO_MACHINE.read_text()
    assert "    drive: {node: 2, " in text
    text = text.replace("    drive: {node: 2, ", PROBE.format(measuring, data), 1).replace(
        "fieldbus:\n", f"fieldbus:\n{fieldbus}", 1
    )
    path = folder / "machine.yaml"
    path.write_text(text)
    return path


def test_a_probe_with_everything_is_loaded(tmp_path: Path) -> None:
    machine = load_machine(described(tmp_path, "signal: drive, touch_probe: 1, input: clamp_closed, feed: 120 mm/min"))
    setup = machine.axes[1].measuring
    assert setup is not None
    assert (setup.feed, setup.edge) == (2.0, "rising")
    assert machine.axes[0].measuring is None


@pytest.mark.parametrize(
    ("measuring", "data", "fieldbus", "reason"),
    [
        ("signal: drive, edge: falling", "probe_1_rising", "", "probe_1_falling"),
        ("signal: drive, touch_probe: 2", "probe_1_rising", "", "probe_2_rising"),
        ("signal: input", "torque", "", "does not name the signal"),
        ("signal: input, input: nowhere", "torque", "", "no node has an input nowhere"),
        ("signal: plc, touch_probe: 3", "torque", "", "touch_probe"),
        ("signal: plc", "torque", "  workpiece: {Q: [1, 2]}\n", "has no drive"),
        ("signal: plc", "torque", "  workpiece: {X: [2, 1]}\n", "it is empty"),
    ],
)
def test_what_does_not_fit_is_told(tmp_path: Path, measuring: str, data: str, fieldbus: str, reason: str) -> None:
    with pytest.raises(ConfigurationError, match=reason):
        load_machine(described(tmp_path, measuring, data, fieldbus))
