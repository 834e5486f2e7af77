"""The pytest plugin: fixtures with a whole machine in virtual time.

    def test_the_clamp_closes(machine, run_program):
        assert run_program("N10 M20").good
        assert machine.input("clamp_closed")

The machine is the demo machine, that of `tandem_machine` in the pytest configuration, or what the test says:
`@pytest.mark.tandem(machine="machine.yaml", plc="mill.py", simulated_drives=True)`. Its plant is the fixture `plant`, which
a test suite replaces by its own rules.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:  # a run that uses no machine does not load one
    from runtime.fieldbus.simulator.plant import Rule
    from runtime.testbench.bench import MachineBench, ProgramResult

_MARK = "tandem(machine, plc, simulated_drives): the machine of a test: description, PLC program, drives that can fail"


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addini("tandem_machine", "machine description for the fixtures of Tandem; default: the demo machine")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", _MARK)


@pytest.fixture
def plant() -> Sequence[Rule]:
    """Which input follows from which output; replace it by the rules of your machine."""
    from runtime.fieldbus.simulator.plant import DEMO_PLANT

    return DEMO_PLANT


@pytest.fixture
def machine(request: pytest.FixtureRequest, plant: Sequence[Rule], tmp_path: Path) -> Iterator[MachineBench]:
    """A machine that is ready: drives enabled, PLC program running."""
    from runtime.testbench.bench import MachineBench

    mark = request.node.get_closest_marker("tandem")
    said = dict(mark.kwargs) if mark is not None else {}
    unknown = said.keys() - {"machine", "plc", "simulated_drives"}
    if unknown or (mark is not None and mark.args):
        raise pytest.UsageError(
            f"@pytest.mark.tandem takes machine, plc and simulated_drives, not {unknown or mark.args}"
        )
    file = said.get("machine") or request.config.getini("tandem_machine")
    bench = MachineBench(
        request.config.rootpath / file if file else None,
        plc=said.get("plc"),
        simulated_drives=bool(said.get("simulated_drives")),
        plant=plant,
        folder=tmp_path,
    )
    yield bench
    bench.close()


@pytest.fixture
def press(machine: MachineBench) -> Callable[..., None]:
    """`press("reset")`: a key of the operator; `press("start_button")`: an input that is TRUE for a moment."""
    return machine.press


@pytest.fixture
def wait_until(machine: MachineBench) -> Callable[..., float]:
    """`wait_until(lambda: machine.input("clamp_closed"), seconds=2)`: virtual time goes on; the seconds it took."""
    return machine.wait_until


@pytest.fixture
def run_program(machine: MachineBench) -> Callable[..., ProgramResult]:
    """`run_program("N10 G01 X50 F3000")`, or a path: from cycle start to the end."""
    return machine.run_program


@pytest.fixture
def inject_fault(machine: MachineBench) -> Callable[..., Callable[[], None]]:
    """`heal = inject_fault("clamp_closed", False)`: a stuck input, a drive that fails, a PLC that hangs."""
    return machine.inject_fault
