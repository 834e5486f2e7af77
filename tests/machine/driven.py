"""The machine with its CANopen drives on the virtual bus, watched cycle by cycle: for tests of what goes wrong in motion."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt

from runtime.config.machine import AxisType, Machine
from runtime.diagnostics.errors import ErrorEntry
from runtime.diagnostics.events import Event, EventKind
from runtime.drives import DriveState
from runtime.fieldbus.simulator.drive import SimulatedDrive
from runtime.hli.alarms import AlarmLine, alarm_lines
from runtime.hli.layout import Mode, State
from runtime.scheduler.simulation import Simulation

Floats = npt.NDArray[np.float64]

# X and Y together on one straight line, X twice as fast, with the spindle turning
LONG_LINE = "%LONG\nN10 G90 M3 S1200\nN20 G01 F9000 X400 Y200\nN30 M30\n"
SECOND = "%SECOND\nN10 G90 G00 X20 Y15 Z5\nN20 G01 X30 F6000\nN30 M30\n"


class Driven:
    """A machine in operation; `watch` records what the drives are told."""

    def __init__(self, machine: Machine, folder: Path, **options: object) -> None:
        self.machine = machine
        self.folder = folder
        self.simulation = Simulation(machine, **options)  # type: ignore[arg-type]
        self.hli = self.simulation.memory.hli
        self.operator = self.hli.operator[0]
        self.image = self.simulation.drives.image
        self.channel = self.simulation.controller.channel
        self.targets: list[Floats] = []
        self.states: list[npt.NDArray[np.int8]] = []
        self._logged = 0
        assert self.simulation.run_until(self.simulation.ready, 20.0)

    # ------------------------------------------------------------------ doing

    def program(self, text: str) -> Path:
        path = self.folder / f"{text.split()[0].strip('%').lower()}.nc"
        path.write_text(text)
        return path

    def start(self, text: str) -> None:
        """Cycle start; the program is taken, or refused, within two cycles."""
        self.simulation.start(self.program(text))
        self.watch(2)

    def watch(self, cycles: int) -> None:
        """Cycles with recorded set-points."""
        for _ in range(cycles):
            self.simulation.cycle()
            self.targets.append(self.image.target_position.copy())
            self.states.append(self.image.state.copy())

    def until(self, condition: Callable[[], bool], limit: float = 20.0) -> int:
        """Recorded cycles until `condition` holds; how many."""
        for count in range(round(limit / self.simulation.period)):
            if condition():
                return count
            self.watch(1)
        raise AssertionError(f"did not happen within {limit} s: {self.alarms}")

    def until_x(self, x: float) -> None:
        self.until(lambda: float(self.image.target_position[0]) >= x)

    def until_done(self) -> None:
        self.until(lambda: not self.channel.active)

    def reset(self) -> None:
        self.operator.reset_rw = True
        self.watch(1)

    def forget(self) -> None:
        """Begin a new record, whose first line is the present."""
        self.targets = [self.image.target_position.copy()]
        self.states = [self.image.state.copy()]
        self._logged = len(self.simulation.log)

    # ------------------------------------------------------------------ looking

    def state(self) -> State:
        return State(self.hli.channels[0].control.mode_and_state.state_r)

    @property
    def mode(self) -> Mode:
        return Mode(self.hli.channels[0].control.mode_and_state.mode_r)

    @property
    def alarms(self) -> list[AlarmLine]:
        """Oldest first."""
        return alarm_lines(self.hli)[::-1]

    def alarm(self, entry: ErrorEntry) -> AlarmLine:
        """The one alarm of this kind in the history."""
        (line,) = [line for line in self.alarms if line.id == entry.id]
        return line

    @property
    def errors(self) -> list[Event]:
        """Errors told since `forget`."""
        return [event for event in self.simulation.log[self._logged :] if event.kind is EventKind.ERROR]

    def drive(self, axis: int) -> SimulatedDrive:
        described = self.machine.axes[axis].drive
        assert described is not None
        return self.simulation.nodes.drives[described.node]

    def moving(self, axis: int) -> bool:
        """Faster than 0.1 mm/s: servos and axes without torque creep into their standstill."""
        described = self.machine.axes[axis].drive
        assert described is not None
        return abs(self.drive(axis).servo.velocity) > 0.1 * described.increments_per_unit

    def place_of(self, axis: int) -> float:
        """Where the axis really is, mm."""
        described = self.machine.axes[axis].drive
        assert described is not None
        return self.drive(axis).servo.position / described.increments_per_unit

    def assert_brakes_within_limits(self, axes: list[int]) -> None:
        """The recorded set-points keep velocity, acceleration and jerk of each axis, from cycle to cycle."""
        period = self.simulation.period
        places = np.array(self.targets)
        velocity = np.diff(places, axis=0) / period
        acceleration = np.diff(velocity, axis=0) / period
        jerk = np.diff(acceleration, axis=0) / period
        for i in axes:
            axis = self.machine.axes[i]
            assert np.abs(velocity[:, i]).max() <= axis.velocity * 1.0001
            assert np.abs(acceleration[:, i]).max() <= axis.acceleration * 1.001
            assert np.abs(jerk[:, i]).max() <= axis.jerk * 1.01

    def assert_no_jump(self) -> None:
        """No enabled drive was ever told to go further in a cycle than its axis' velocity allows."""
        places, states = np.array(self.targets), np.array(self.states)
        enabled = (states[1:] == DriveState.OPERATION_ENABLED) & (states[:-1] == DriveState.OPERATION_ENABLED)
        steps = np.abs(np.diff(places, axis=0))
        for i, axis in enumerate(self.machine.axes):
            if axis.type is not AxisType.SPINDLE:
                most = axis.velocity * self.simulation.period
                assert np.where(enabled[:, i], steps[:, i], 0.0).max() <= most * 1.0001, axis.name
        for k in np.flatnonzero((states[1:, :3] == 5).any(axis=1) & (states[:-1, :3] != 5).any(axis=1)):
            for i in range(3):  # taken over where the drive stands, when it is enabled
                if states[k + 1, i] == 5 and states[k, i] != 5:
                    assert (
                        abs(places[k + 1, i] - places[k, i]) <= self.machine.axes[i].velocity * self.simulation.period
                    )
