"""The machine with a list of blocks in the place of a program file: for tests of what the cycle makes of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from runtime.cnc.blocks import Block, BlockEnd, Floats, Line, Source, Stop, StopKind
from runtime.cnc.decoder.outside import Outside
from runtime.config.machine import Machine
from runtime.diagnostics.events import Event, EventKind
from runtime.hli.layout import StopCondition
from runtime.hli.memory import HliMemory
from runtime.hli.messages import MessageTaker
from runtime.scheduler.plc_link import PlcPartner
from runtime.scheduler.preparation import Preparation
from runtime.scheduler.simulation import Simulation


class Contour:
    """Makes blocks in the place of the decoder; `x` is where the path has come to."""

    def __init__(self, start: Floats) -> None:
        self.place = start.copy()

    def to(self, x: float, line: int, feed: float = 6000.0) -> Iterator[Block]:
        """A move of X with its block end."""
        end = self.place.copy()
        end[0] = x
        source = Source("script", line, line * 10)
        yield Line(source, self.place.copy(), end, feed, False, end.copy())
        yield BlockEnd(source)
        self.place = end


Script = Callable[[Contour, Outside], Iterator[Block]]


def at(line: int) -> Source:
    """The source of a block in this line."""
    return Source("script", line, line * 10)


class MessagePlc:
    """A PLC that takes the messages while `takes`; functions are nobody's."""

    def __init__(self, memory: HliMemory, *, takes: bool = False) -> None:
        self._hli = memory.hli
        self._taker = MessageTaker(memory.hli.channels[0])
        self.takes = takes
        self.texts: list[str] = []
        self.information: list[bool] = []

    def wake(self, time: float) -> None:
        channel = self._hli.channels[0]
        channel.plc_present_w = True
        channel.watchdog.cycle_time_w, channel.watchdog.enable_w = 50_000, True
        channel.watchdog.alive_rw = True
        self._hli.platform.plc_cycle_done_w = self._hli.platform.plc_cycle_request_r
        message = self._taker.offered()
        if self.takes and message is not None:
            self.texts.append(message.text)
            self.information.append(message.information)
            self._taker.take(message)

    def restart(self) -> None:
        """It never fails."""


class Scripted:
    """A machine that has started a script."""

    def __init__(
        self,
        machine: Machine,
        script: Script,
        partner: Callable[[HliMemory], PlcPartner] | None = None,
        *,
        ideal: bool = True,
        trace: Path | None = None,
    ) -> None:
        self.simulation = Simulation(machine, ideal_axes=ideal, plc=False, partner=partner, trace=trace)
        self.hli = self.simulation.memory.hli
        self.channel = self.simulation.controller.channel
        self.path = self.simulation.controller.interpolator
        self.script = script
        simulation = self.simulation
        simulation.preparation = Preparation(
            machine,
            0,
            simulation.queue,
            simulation.link,
            simulation.outside,
            on_block=simulation._trace_block if trace else None,
            source=lambda order, outside: self._blocks(order.start, outside),
        )
        assert simulation.run_until(simulation.ready, 20.0)
        self.start()

    def _blocks(self, start: Floats, outside: Outside) -> Iterator[Block]:
        yield from self.script(Contour(start), outside)
        yield Stop(at(99), StopKind.PROGRAM_END)

    def start(self) -> None:
        self.begin = self.simulation.time
        self.simulation.start(Path("script.nc"))
        self.simulation.cycle()
        self.simulation.cycle()

    # ------------------------------------------------------------------ time

    def until(self, condition: Callable[[], bool], limit: float = 10.0) -> None:
        assert self.simulation.run_until(condition, limit), f"waits for {self.stop!r}, {self.simulation.problems}"

    def run(self, seconds: float) -> None:
        end = self.simulation.time + seconds
        while self.simulation.time < end:
            self.simulation.cycle()

    def finish(self) -> None:
        self.until(lambda: not self.channel.active)

    # ------------------------------------------------------------------ looking

    @property
    def x(self) -> float:
        return float(self.path.position[0])

    @property
    def stop(self) -> StopCondition:
        return StopCondition(self.channel.stop_condition)

    def events(self, kind: EventKind) -> list[Event]:
        return [event for event in self.simulation.log if event.kind is kind]

    @property
    def texts(self) -> list[str]:
        return [event.text for event in self.events(EventKind.MESSAGE)]

    @property
    def alarms(self) -> list[int]:
        return [problem.entry.id for problem in self.simulation.problems]


def speeds_at(scripted: Scripted, x: float) -> float:
    """Path speed in the cycle in which X comes to `x` or beyond, mm/s."""
    scripted.until(lambda: scripted.x >= x - 1e-9)
    return scripted.path.path_velocity


def positions(value: Floats | None) -> list[float]:
    """Rounded to the increments of the drives."""
    assert value is not None
    rounded: list[float] = np.round(value, 4).tolist()
    return rounded
