"""The demo machine with a rotary table beside its channel, and a PLC program that calls what the test gives it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from runtime.config import load_machine
from runtime.config.loader import DEMO_MACHINE
from runtime.config.machine import Machine
from runtime.plc_logic import Program
from runtime.scheduler.simulation import Simulation

LONG_LINE = "%LONG\nN10 G90 G01 X200 F6000\nN20 M30\n"
TABLE = """  - name: B
    type: rotary
    log_axis: 9
    position_min: -720
    position_max: 720
    velocity: 180
    acceleration: 720
    jerk: 20000
    drive: {node: 9, increments_per_unit: 1000, vendor_id: 0x7A4D, product_code: 0x402}
"""
PLC = """
from runtime.plc_logic import Program, s_function
from runtime.plc_logic.motion import *

class Loader(Program):
    def setup(self):
        self.calls = {}

    def cycle(self):
        for call in list(self.calls.values()):
            call(self)

    @s_function()
    def spindle_told(self, f):
        return True
"""


class Rig:
    """The demo machine with a rotary table beside its channel, and a PLC program that calls what the test gives it."""

    def __init__(
        self,
        folder: Path,
        *,
        ideal: bool = True,
        table: str = TABLE,
        prepare: Callable[[Simulation], None] = lambda simulation: None,
    ) -> None:
        """`prepare` is called before the first cycle."""
        text = DEMO_MACHINE.read_text().replace("channels:\n", table + "channels:\n", 1)
        text = text.replace("runtime.demo.plc:DemoMill", "loader.py").replace("watchdog: 300 ms", "watchdog: 50 ms")
        (folder / "machine.yaml").write_text(text)
        (folder / "loader.py").write_text(PLC)
        self.folder = folder
        self.machine: Machine = load_machine(folder / "machine.yaml")
        self.simulation = Simulation(self.machine, ideal_axes=ideal, base=folder)
        prepare(self.simulation)
        self.image = self.simulation.drives.image
        self.hli = self.simulation.memory.hli
        self.table = self.machine.axis_index("B")
        assert self.simulation.run_until(self.simulation.ready, 20.0)
        self.path: list[float] = []
        self.run(0.01)

    @property
    def program(self) -> Program:
        return self.simulation.plc.host.program  # type: ignore[union-attr, no-any-return]

    def call(self, name: str, call: Callable[[Program], object]) -> None:
        """Call this in every PLC cycle from now on."""
        vars(self.program)["calls"][name] = call

    def cycle(self) -> None:
        self.simulation.cycle()
        self.path.append(float(self.image.target_position[self.table]))

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / self.simulation.period)):
            self.cycle()

    def until(self, condition: Callable[[], bool], limit: float = 20.0) -> None:
        for _ in range(round(limit / self.simulation.period)):
            if condition():
                return
            self.cycle()
        raise AssertionError(f"not within {limit} s: {[str(problem) for problem in self.simulation.problems]}")

    def start(self, text: str) -> None:
        (self.folder / "part.nc").write_text(text)
        self.simulation.start(self.folder / "part.nc")
        self.run(0.01)

    def place(self, name: str) -> float:
        return float(self.image.target_position[self.machine.axis_index(name)])

    def assert_smooth(self, name: str = "B") -> None:
        """The set-points keep what the axis can."""
        axis, period = self.machine.axes[self.machine.axis_index(name)], self.simulation.period
        v = np.diff(self.path) / period
        a = np.diff(v) / period
        assert np.abs(v).max(initial=0.0) <= axis.velocity * 1.001
        assert np.abs(a).max(initial=0.0) <= axis.acceleration * 1.001
        assert np.abs(np.diff(a)).max(initial=0.0) / period <= axis.jerk * 1.01 + 1.0
