"""A test bench for PLC programs: the program, its inputs and outputs, and a CNC that hands out functions. No CNC
needed.

    bench = Bench(MyMachine, inputs=["clamp_closed"], outputs=["clamp_valve"])
    m20 = bench.m(20)
    bench.run(0.1)
    assert bench.output("clamp_valve") and not m20.done
    bench.set(clamp_closed=True)
    bench.run(0.01)
    assert m20.done

Time is virtual: `run(2.0)` runs 500 cycles of 4 ms at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Generic, TypeVar, cast

from runtime.diagnostics.errors import ErrorEntry, Place
from runtime.hli.alarms import Report, take_report
from runtime.hli.analogue import AnaloguePlaces, OutputPlace
from runtime.hli.control import AxisCommands, ChannelCommands
from runtime.hli.external import ExternalEntry, describe_external
from runtime.hli.layout import Channel
from runtime.hli.memory import HliMemory, get_text, put_text
from runtime.hli.messages import MessagePort, Waiting
from runtime.hli.modes import Wish
from runtime.hli.technology import Function, Kind, Sent, TechnologyPort
from runtime.hli.units import REV_PER_MIN, to_int32
from runtime.plc_logic.errors import PlcFailure
from runtime.plc_logic.exchange import ProgramExchange
from runtime.plc_logic.host import SPINDLE, PlcHost
from runtime.plc_logic.program import Program
from runtime.plc_logic.retained_variables import RetainJournal

P = TypeVar("P", bound=Program)
WAIT = 0x2  # MVS_SVS
NO_WAIT = 0x1  # MOS
_EPOCH_NS = 1_000_000_000_000_000_000  # the wall clock of the bench starts here


class Bench(Generic[P]):
    """One channel with axes and spindles, as the program finds them in the HLI, and the CNC's answers to it."""

    def __init__(
        self,
        program: type[P],
        inputs: Sequence[str] = (),
        outputs: Sequence[str] = (),
        *,
        analogue_inputs: Sequence[str] = (),
        analogue_outputs: Mapping[str, tuple[float, float]] | None = None,
        axes: Sequence[str] = ("X", "Y", "Z"),
        spindles: Sequence[str] = ("S",),
        external: Sequence[ExternalEntry] = (),
        cycle_time: float = 0.004,
        plant: Callable[[Bench[P]], None] | None = None,
        journal: Callable[[], RetainJournal] | None = None,
    ) -> None:
        """`plant` is called before every cycle: it may look at outputs and set inputs, as the real machine would.

        `analogue_outputs`: name → limits. `external`: the external variables of the machine. `journal`: that of the
        retained variables.
        """
        self.memory = HliMemory.private()
        hli = self.hli = self.memory.hli
        self._inputs = {name: bit for bit, name in enumerate(inputs)}
        self._outputs = {name: bit for bit, name in enumerate(outputs)}
        self._analogue = AnaloguePlaces(
            {name: k for k, name in enumerate(analogue_inputs)},
            {
                name: OutputPlace(k, low, high, max(low, min(0.0, high)))
                for k, (name, (low, high)) in enumerate((analogue_outputs or {}).items())
            },
        )
        hli.image.analogue_valid_r = (1 << len(analogue_inputs)) - 1
        self._period_ns = round(cycle_time * 1e9)
        self._plant = plant
        self.time_ns = 0
        describe_external(hli, external)
        hli.head.channels_r = 1
        hli.head.axes_r = len(axes) + len(spindles)
        self.channel: Channel = hli.channels[0]
        put_text(self.channel, "name_r", "bench")
        self._axis_index = {name: i for i, name in enumerate((*axes, *spindles))}
        for name, index in self._axis_index.items():
            put_text(hli.axes[index], "name_r", name)
            hli.axes[index].axis_type_r = SPINDLE if name in spindles else 1
        self._port = TechnologyPort(self.channel)
        self._messages = MessagePort(self.channel)
        self._axis_ports = {name: TechnologyPort(hli.axes[i]) for name, i in self._axis_index.items()}
        self.commands = ChannelCommands(self.channel, hli.operator[0], max_override=2000)
        self.axis_commands = {name: AxisCommands(hli.axes[i]) for name, i in self._axis_index.items()}
        self.reports: list[Report] = []  # what the program has reported, coming and going
        self.orders: list[Wish] = []  # orders of the mode unit that reached the CNC
        self.host = PlcHost(
            program,
            self.memory,
            self._inputs,
            self._outputs,
            self._analogue,
            journal=journal,
            wall_ns=lambda: _EPOCH_NS + self.time_ns,
        )
        self.host.start(0)
        self._new: type[Program] | None = None
        self._exchange = ProgramExchange(self.host, hli, lambda: lambda: self._new)

    # ------------------------------------------------------------------ the machine

    def set(self, **inputs: float) -> None:
        """Set inputs by name; an analogue one that is no number is not valid."""
        image = self.hli.image.digital_in_r
        for name, value in inputs.items():
            if (place := self._analogue.inputs.get(name)) is not None:
                self._set_value(place, value)
                continue
            byte, bit = divmod(self._inputs[name], 8)
            image[byte] = image[byte] | 1 << bit if value else image[byte] & ~(1 << bit)

    def _set_value(self, place: int, value: float) -> None:
        image = self.hli.image
        if math.isfinite(value):
            image.analogue_in_r[place] = value
            image.analogue_valid_r |= 1 << place
        else:
            image.analogue_valid_r &= ~(1 << place)

    def output_value(self, name: str) -> float:
        """An analogue output as it stands in the process image."""
        return float(self.hli.image.analogue_out_w[self._analogue.outputs[name].place])

    def output(self, name: str) -> bool:
        """An output as it stands in the process image."""
        byte, bit = divmod(self._outputs[name], 8)
        return bool(self.hli.image.digital_out_w[byte] & 1 << bit)

    def spindle(self, name: str, speed: float, *, at_speed: bool = True) -> None:
        """Let a spindle report this speed, rev/min."""
        status = self.hli.axes[self._axis_index[name]].spindle
        status.actual_speed_r = status.command_speed_r = to_int32(speed, REV_PER_MIN)
        status.rev_erreicht_r = at_speed and speed != 0
        status.rev_null_r = speed == 0

    @property
    def program(self) -> P:
        """The program that runs."""
        return cast(P, self.host.program)

    @property
    def alarms(self) -> list[str]:
        """Texts that stand."""
        return self.host.alarms

    @property
    def time(self) -> float:
        """Seconds since the start."""
        return self.time_ns * 1e-9

    # ------------------------------------------------------------------ the NC program

    def m(self, number: int, value: int = 0, *, wait: bool = True, line: int = 0) -> Sent:
        """Put out an M function; `done` of the result tells when it is acknowledged."""
        return self._put(self._port, Function(Kind.M, number, value, WAIT if wait else NO_WAIT, line))

    def h(self, number: int, value: int = 0, *, wait: bool = True, line: int = 0) -> Sent:
        """Put out an H function."""
        return self._put(self._port, Function(Kind.H, number, value, WAIT if wait else NO_WAIT, line))

    def t(self, tool: int, *, wait: bool = False, line: int = 0) -> Sent:
        """Put out a T function."""
        return self._put(self._port, Function(Kind.T, tool, 0, WAIT if wait else NO_WAIT, line))

    def s(self, number: int, speed: float = 0.0, *, spindle: str = "S", wait: bool = True, line: int = 0) -> Sent:
        """Put out a spindle function (3, 4, 5, 19), speed in rev/min."""
        function = Function(
            Kind.S, number, 0, WAIT if wait else NO_WAIT, line, revolutions=to_int32(speed, REV_PER_MIN)
        )
        return self._put(self._axis_ports[spindle], function)

    def message(self, text: str, *, information: bool = False) -> None:
        """Put out a message for the PLC, #MSG PLC or #MSG INFO PLC."""
        self._messages.put(Waiting(text, information, 0))

    @property
    def untaken_messages(self) -> int:
        """Messages that the program has not acknowledged."""
        return self._messages.waiting

    def reset(self) -> None:
        """Let the CNC reset its channel: all functions and messages are withdrawn."""
        for port in (self._port, *self._axis_ports.values()):
            port.drop_all()
        self._messages.drop_all()

    # ------------------------------------------------------------------ online change

    def replace(self, program: type[Program], seconds: float = 20.0) -> str:
        """Replace the program as `tandem plc reload` does; what the PLC answered. PlcFailure if it was refused."""
        self._new = program
        platform = self.hli.platform
        platform.reload_request_w += 1
        self.run_until(lambda: bool(platform.reload_done_w == platform.reload_request_w), seconds)
        text = get_text(platform, "reload_text_w")
        if platform.reload_error_w:
            told = ErrorEntry(platform.reload_error_w, "{text}")
            raise PlcFailure(told, Place(), text.partition("\n")[2], text=text.partition("\n")[0])
        return text

    # ------------------------------------------------------------------ time

    def cycle(self) -> None:
        """One PLC cycle, with the CNC around it."""
        self.time_ns += self._period_ns
        if self._plant is not None:
            self._plant(self)
        self.commands.sample()
        for axis in self.axis_commands.values():
            axis.sample()
        if (order := self.commands.modes.take(bool(self.channel.plc_present_w))) is not None:
            self.orders.append(order.wish)
            self.commands.modes.answer()
        self._messages.poll()
        self.hli.platform.plc_cycle_request_r += 1
        self._exchange.cycle(self.time_ns)
        for port in (self._port, *self._axis_ports.values()):
            port.poll()
        self._messages.poll()
        if (report := take_report(self.hli.platform.lc_error)) is not None:
            self.reports.append(report)

    def run(self, seconds: float) -> None:
        """Run cycles for this time."""
        end_ns = self.time_ns + round(seconds * 1e9)
        while self.time_ns < end_ns:
            self.cycle()

    def run_until(self, condition: Callable[[], bool], seconds: float = 10.0) -> float:
        """Run until the condition holds; returns the seconds that took. TimeoutError after `seconds`."""
        begin_ns = self.time_ns
        while not condition():
            if self.time_ns - begin_ns > seconds * 1e9:
                raise TimeoutError(f"not fulfilled within {seconds} s; alarms: {self.alarms}")
            self.cycle()
        return (self.time_ns - begin_ns) * 1e-9

    def _put(self, port: TechnologyPort, function: Function) -> Sent:
        sent = port.put(function)
        assert sent is not None, "all technology units are in use: let the program run"
        return sent
