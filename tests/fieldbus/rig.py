"""A machine on a virtual bus in virtual time: master and simulated nodes in one process, nothing waits."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from importlib import resources
from typing import Any

import can
import yaml

from runtime.config.machine import Machine
from runtime.diagnostics.errors import Problem
from runtime.drives import DriveEvent, DriveState, DriveSystem
from runtime.fieldbus.events import problem_of
from runtime.fieldbus.master import CanopenMaster
from runtime.fieldbus.simulator import SimulatedNodes

_CHANNELS = itertools.count()


def demo_description() -> dict[str, Any]:
    """The demo machine as read from its file, to be changed by a test."""
    text = resources.files("runtime.demo").joinpath("machine.yaml").read_text(encoding="utf-8")
    description: dict[str, Any] = yaml.safe_load(text)
    description["fieldbus"]["bus"] = {"interface": "virtual", "channel": f"test-{next(_CHANNELS)}"}
    return description


class Rig:
    """The demo machine (or one described otherwise); `cycle` runs master, then nodes, for one period."""

    def __init__(self, description: dict[str, Any] | None = None, *, nodes: bool = True) -> None:
        self.machine = Machine.model_validate(description or demo_description())
        channel = self.machine.fieldbus.bus.channel
        self.time = 0.0
        self.bus = can.Bus(interface="virtual", channel=channel)
        self.node_bus = can.Bus(interface="virtual", channel=channel)
        self.nodes = SimulatedNodes(self.machine, self.node_bus) if nodes else None
        self.master = CanopenMaster(self.machine, self.bus, now=lambda: self.time, idle=self.idle)
        self.system: DriveSystem = self.master
        self.image = self.system.image
        self.events: list[DriveEvent] = []
        self.master_alive = True

    def __enter__(self) -> Rig:
        return self

    def __exit__(self, *_: object) -> None:
        self.bus.shutdown()
        self.node_bus.shutdown()

    @property
    def simulated(self) -> SimulatedNodes:
        assert self.nodes is not None
        return self.nodes

    def idle(self) -> None:
        """A tenth of a millisecond passes."""
        self.time += 1e-4
        if self.nodes:
            self.nodes.step(self.time)

    def cycle(self, count: int = 1) -> None:
        for _ in range(count):
            if self.master_alive:
                self.master.read()
                self.events.extend(self.image.events)
                self.image.events.clear()
                self.master.write()
            self.time += self.machine.cycle.period
            if self.nodes:
                self.nodes.step(self.time)

    def run_until(self, condition: Callable[[], bool], seconds: float = 2.0) -> bool:
        """Cycles until the condition holds; False if the time went by."""
        end = self.time + seconds
        while not condition():
            if self.time >= end:
                return False
            self.cycle()
        return True

    def started(self) -> Rig:
        self.master.start()
        self.cycle(3)
        return self

    def enabled(self) -> Rig:
        """All drives in operation enabled."""
        self.started()
        self.image.enable[:] = True
        assert self.run_until(lambda: bool((self.image.state == DriveState.OPERATION_ENABLED).all())), self.image.state
        return self

    def problems(self) -> list[Problem]:
        return [problem_of(event, self.machine) for event in self.events]

    def event_ids(self) -> list[int]:
        return [event.error_id for event in self.events]
