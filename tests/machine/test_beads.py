"""A dispensing program with contouring, M functions with values and a field of dots on the whole machine."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from runtime.config.machine import Machine
from runtime.diagnostics.events import EventKind
from runtime.scheduler.simulation import Simulation

PROGRAM = Path(__file__).parents[1] / "programs" / "beads.nc"


def with_valves(machine: Machine) -> Machine:
    """The demo machine with the M functions of a dispensing head."""
    channel = machine.channels[0]
    synch = dict.fromkeys((110, 160, 161, 162, 200), "MOS")
    parameters = channel.parameters.model_copy(update={"m_synch": {**channel.parameters.m_synch, **synch}})
    changed = channel.model_copy(update={"parameters": parameters})
    return machine.model_copy(update={"channels": (changed, *machine.channels[1:])})


@pytest.mark.spec("isg.smooth.contour-select", "isg.g.polynomial-contouring")
def test_beads_are_dispensed_within_the_tolerance(demo: Machine) -> None:
    simulation = Simulation(with_valves(demo), ideal_axes=True, samples=True)
    result = simulation.run_program(PROGRAM)
    assert result.good, result.problems
    functions = [(event.number, event.value) for event in result.events if event.kind is EventKind.M_OUT]
    assert functions.count((162, 30.0)) == 6
    assert [value for number, value in functions if number == 110] == [0, 100, 200, 300, 400, 550, 600]
    assert sum(number == 160 for number, _ in functions) == sum(number == 161 for number, _ in functions) == 4
    assert simulation.samples is not None
    samples = simulation.samples.arrays()
    path = np.column_stack([samples[axis] for axis in "XYZ"])
    for frame in range(4):
        x, y = 20.0 * (frame % 2), 20.0 * (frame // 2)
        for corner in ((x + 6, y), (x + 6, y + 6), (x, y + 6)):
            nearest = np.linalg.norm(path - [*corner, 0.6], axis=1).min()
            assert 0.01 < nearest <= 0.08 + 1e-3  # of the samples
    assert math.isclose(path[-1, 2], 50.0, abs_tol=1e-9)
