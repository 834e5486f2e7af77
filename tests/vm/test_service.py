"""The runtime as a systemd service on a PREEMPT_RT kernel: started, frozen, stopped, and killed with its computer.

Two boots: in the first one everything but the last happens, then the machine's plug is pulled in motion; the second one finds
what was retained.
"""

from __future__ import annotations

import json
from typing import Any

import pytest

from runtime.diagnostics.catalogue import machine as catalogue
from tests.vm import parts, qemu

LIMIT = 420.0  # s for one boot


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Any]]:
    folder, state = tmp_path_factory.mktemp("service"), tmp_path_factory.mktemp("state")
    found = {}
    try:
        for phase in ("first", "second"):
            run = qemu.run_service(phase, folder, state, LIMIT)
            file = folder / f"{phase}.json"
            if not file.exists():
                pytest.fail(f"the {phase} boot observed nothing; it printed:\n{run.console[-4000:]}")
            found[phase] = json.loads(file.read_text())
            assert "failure" not in found[phase], f"{found[phase]['failure']}\n{run.console[-4000:]}"
    except parts.UnavailableError as reason:
        pytest.skip(f"no virtual machine: {reason}")
    return found


@pytest.fixture(scope="module")
def first(runs: dict[str, dict[str, Any]]) -> dict[str, Any]:
    return runs["first"]


def test_it_starts_and_says_so(first: dict[str, Any]) -> None:
    started = first["started"]
    assert (started["ActiveState"], started["SubState"]) == ("active", "running")
    assert started["StatusText"] == "demo mill runs"
    assert started["NRestarts"] == "0"


def test_it_runs_without_root_and_without_capabilities(first: dict[str, Any]) -> None:
    assert first["started"]["User"] == "tandem"
    assert int(first["capabilities"], 16) == 0


def test_the_exposure_is_at_most_3(first: dict[str, Any]) -> None:
    words = first["exposure"].replace(":", " ").split()
    number = next(float(word) for word in words if word.replace(".", "").isdigit())
    assert number <= 3.0, first["exposure"]


def test_the_journal_has_structured_entries(first: dict[str, Any]) -> None:
    assert any("TANDEM_EVENT" in entry for entry in first["journal"])


def test_metrics_answer(first: dict[str, Any]) -> None:
    assert any(line.startswith("tandem_can_") for line in first["metrics"])


def test_a_frozen_cycle_is_ended_by_the_watchdog_and_comes_back(first: dict[str, Any]) -> None:
    after = first["after_watchdog"]
    assert after["NRestarts"] == "1"
    assert after["ActiveState"] == "active"
    assert after["MainPID"] != first["started"]["MainPID"]
    assert first["watchdog_journal"]


def test_stop_in_motion_brings_the_axes_to_rest(first: dict[str, Any]) -> None:
    assert first["stopped"]["ActiveState"] == "inactive"
    assert first["stopped"]["Result"] == "success"
    assert first["stop_seconds"] < 20.0
    assert first["retained_at_stop"]


def test_what_is_retained_survives_the_pulled_plug(runs: dict[str, dict[str, Any]]) -> None:
    assert runs["first"]["alarms"]
    before = [text for _, text in runs["first"]["alarms"]]
    after = [text for _, text in runs["second"]["alarms"]]
    assert set(before) <= set(after)
    assert runs["second"]["state"] in ("SELECTED", "DESELECTED")
    assert catalogue.CYCLE_LOST.id not in {number for number, _ in runs["second"]["alarms"]} - {
        number for number, _ in runs["first"]["alarms"]
    }
