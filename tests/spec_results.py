"""A plugin of pytest: `--spec-results FILE` writes which tests name which catalogue entries, and how they ended.

    {"tests": {"tests/cnc/…::test_if": {"ids": ["isg.flow.if"], "outcome": "passed"}}}

`tests.coverage_spec` reads the file. Works with pytest-xdist: the ids travel with the reports as properties of the
test, and only the process that gives out the tests writes.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

PROPERTY = "spec"


def pytest_addoption(parser: pytest.Parser) -> None:
    """The option `--spec-results`; without it nothing is recorded."""
    parser.addoption("--spec-results", metavar="FILE", help="write the outcome of tests marked `spec` to FILE (JSON)")


def pytest_configure(config: pytest.Config) -> None:
    """Record if it is asked for."""
    file = config.getoption("--spec-results")
    if file:
        writes = not hasattr(config, "workerinput")  # a worker of pytest-xdist has it
        config.pluginmanager.register(SpecResults(config.rootpath / file if writes else None))


class SpecResults:
    """Collects the ids of tests and how the tests ended; `file` None: only adds the ids to the reports."""

    def __init__(self, file: Path | None) -> None:
        self._file = file
        self._ids: dict[str, list[str]] = {}
        self._outcomes: dict[str, str] = {}

    def pytest_itemcollected(self, item: pytest.Item) -> None:
        """Put the ids of the markers among the properties of the test."""
        ids = {id_ for marker in item.iter_markers("spec") for id_ in marker.args}
        item.user_properties += [(PROPERTY, id_) for id_ in sorted(ids)]

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """A test passed if its call did and neither set-up nor tear-down failed; a skipped one did not."""
        ids = [str(value) for name, value in report.user_properties if name == PROPERTY]
        if not ids:
            return
        self._ids[report.nodeid] = ids
        before = self._outcomes.get(report.nodeid, "passed")
        self._outcomes[report.nodeid] = report.outcome if before == "passed" else before

    def pytest_sessionfinish(self) -> None:
        """Write the file."""
        if self._file is None:
            return
        tests = {test: {"ids": self._ids[test], "outcome": self._outcomes[test]} for test in sorted(self._ids)}
        self._file.parent.mkdir(parents=True, exist_ok=True)
        self._file.write_text(json.dumps({"tests": tests}, indent=1) + "\n", encoding="utf-8")
