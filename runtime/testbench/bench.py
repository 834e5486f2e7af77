"""A whole machine under test: CNC, PLC program, drives and the plant around them, in virtual time.

Nothing is replaced but clock and bus, so what a test sees is what the machine does; ten seconds of it take less than one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from runtime.config.loader import DEMO_MACHINE, load_machine
from runtime.diagnostics.events import Event, EventKind
from runtime.fieldbus.simulator.drive import Fault
from runtime.fieldbus.simulator.plant import DEMO_PLANT, Rule, SimulatedPlant
from runtime.hli.alarms import alarm_lines
from runtime.hli.describe import analogue_places, io_bits
from runtime.hli.layout import Mode, State, StopCondition
from runtime.hli.memory import get_text
from runtime.hli.operator import Operator
from runtime.plc_logic.host import PlcHost
from runtime.plc_logic.program import Program
from runtime.scheduler.plc_inline import InlinePlc
from runtime.scheduler.simulation import Simulation

READY_LIMIT = 30.0  # s
PRESS = 0.1  # s that a key is held
_FUNCTIONS = {EventKind.M_OUT: "M", EventKind.H_OUT: "H", EventKind.T_OUT: "T"}


@dataclass(frozen=True, slots=True)
class ProgramResult:
    """What an NC program did: how long it took (s), where the axes stand, what it has put out, and the alarms."""

    time: float
    positions: dict[str, float]
    functions: tuple[str, ...]  # "M20", "H12", "T3" in their order
    messages: tuple[str, ...]
    alarms: tuple[str, ...]

    @property
    def good(self) -> bool:
        """It came to its end without an alarm."""
        return not self.alarms


class MachineBench:
    """A machine that is ready. Times are virtual seconds, positions mm or degrees."""

    def __init__(
        self,
        description: Path | None = None,
        *,
        plc: str | None = None,
        simulated_drives: bool = False,
        plant: Sequence[Rule] = DEMO_PLANT,
        folder: Path | None = None,
    ) -> None:
        """`description`: machine description, None for the demo machine. `plc`: another PLC program than it names.

        `simulated_drives`: CANopen drives that can fail, instead of ideal ones, which are faster. `plant`: which input
        follows from which output. `folder`: where NC texts are written. Raises TimeoutError if the machine does not get ready.
        """
        file = description or DEMO_MACHINE
        machine = load_machine(file)
        if plc is not None:
            machine = machine.model_copy(update={"plc": machine.plc.model_copy(update={"program": plc})})
        self.description = machine
        self.plant = SimulatedPlant(tuple(plant))
        self._folder = folder or Path()
        self._inputs, self._outputs = io_bits(machine)
        self._analogue = analogue_places(machine)
        self.simulation = Simulation(
            machine, ideal_axes=not simulated_drives, base=file.parent, plant=self.plant, samples=False
        )
        self.hli = self.simulation.memory.hli
        self.operator = Operator(self.simulation.memory, self.run)
        self.wait_until(self.simulation.ready, READY_LIMIT, "drives enabled and PLC running")

    # ------------------------------------------------------------------ time

    @property
    def time(self) -> float:
        """Since the start of the runtime."""
        return self.simulation.time

    def run(self, seconds: float) -> None:
        """Let the time go on."""
        for _ in range(max(round(seconds / self.simulation.period), 1)):
            self.simulation.cycle()

    def wait_until(self, condition: Callable[[], object], seconds: float = 10.0, what: str = "") -> float:
        """Until the condition holds; the seconds that took. TimeoutError after `seconds`, with what stands."""
        begin = self.time
        while not condition():
            if self.time - begin >= seconds:
                raise TimeoutError(
                    f"{what or 'the condition'}: not within {seconds} s; {self.mode.name} {self.state.name},"
                    f" line {self.line}, waits for {self.waits_for.name or 'nothing'}, alarms: {list(self.alarms) or 'none'}"
                )
            self.simulation.cycle()
        return self.time - begin

    # ------------------------------------------------------------------ the operator

    def press(self, key: str, seconds: float = PRESS) -> None:
        """A key of the operator, or an input of the machine that is TRUE for this time (a button).

        Keys: start (the program that ran last), stop, reset, hold, resume, continue.
        """
        keys: dict[str, Callable[[], None]] = {
            "start": lambda: self.operator.start(""),
            "stop": self.operator.stop,
            "reset": self.operator.reset,
            "hold": self.operator.hold,
            "resume": self.operator.resume,
            "continue": self.operator.continue_motion,
        }
        if key in self._inputs:
            self.plant.force(key, True)
            self.run(seconds)
            self.plant.force(key, None)
        elif key not in keys:
            raise KeyError(f"{key} is no key ({', '.join(keys)}) and no input ({', '.join(self._inputs)})")
        else:
            keys[key]()
        self.run(seconds)

    def load(self, program: str | Path) -> Path:
        """The file of an NC program: a path as it is, a text written into the folder of the test."""
        if isinstance(program, Path):
            return program
        file = self._folder / "program.nc"
        text = program if program.lstrip().startswith("%") else f"%TEST\n{program}"
        file.write_text(text if text.endswith("\n") else text + "\n")
        return file

    def start_program(self, program: str | Path) -> None:
        """Cycle start; the program is active when this returns. OrderRefusedError or TimeoutError if not."""
        self.operator.start(str(self.load(program)))
        self.wait_until(
            lambda: self.state in (State.ACTIVE, State.HOLD, State.ERROR) or self.alarms, 5.0, "cycle start"
        )

    def run_program(self, program: str | Path, seconds: float = 600.0) -> ProgramResult:
        """From cycle start to the end of the program or to the error that ends it."""
        seen, begin = len(self.simulation.log), self.time
        problems = len(self.simulation.errors)
        self.start_program(program)
        self.wait_until(lambda: not self.simulation.controller.channel.active, seconds, "end of the program")
        took = self.time - begin
        self.run(2 * self.description.plc.every * self.simulation.period)  # the PLC takes what was put out last
        events = self.simulation.log[seen:]
        return ProgramResult(
            took,
            {name: self.position(name) for name in self.description.channels[0].axes},
            tuple(f"{_FUNCTIONS[event.kind]}{event.number}" for event in events if event.kind in _FUNCTIONS),
            tuple(event.text for event in events if event.kind is EventKind.MESSAGE),
            tuple(problem.text for problem in self.simulation.errors[problems:]),
        )

    def set_value(self, name: str, value: float) -> None:
        """What an analogue input measures from now on, in its unit. KeyError for an unknown name."""
        if name not in self._analogue.inputs:
            raise KeyError(f"{name} is no analogue input ({', '.join(self._analogue.inputs) or 'there are none'})")
        self.plant.values[name] = value

    # ------------------------------------------------------------------ what goes wrong

    def inject_fault(self, where: str, what: bool | str) -> Callable[[], None]:
        """Something fails; the function that is handed back heals it.

            inject_fault("clamp_closed", False)      an input that is stuck
            inject_fault("X", "drive")               a drive: drive, silent, reboot, following_error, encoder_freeze
            inject_fault("plc", "hang")              the PLC program does not come back

        Raises KeyError or ValueError for what this machine does not have.
        """
        if where == "plc":
            if what != "hang":
                raise ValueError("the PLC can hang; a program that raises is written by the test")
            self.plc.frozen = True
            return lambda: setattr(self.plc, "frozen", False)
        if where in self._inputs:
            if not isinstance(what, bool):
                raise ValueError(f"{where} is an input: stuck at True or at False")
            self.plant.force(where, what)
            return lambda: self.plant.force(where, None)
        node = {axis.name: axis.drive.node for axis in self.description.axes if axis.drive is not None}.get(where)
        if node is None:
            raise KeyError(f"{where} is no axis with a drive, no input, and not plc")
        if not hasattr(self.simulation, "nodes"):
            raise ValueError("ideal drives do not fail: @pytest.mark.tandem(simulated_drives=True)")
        nodes = self.simulation.nodes
        nodes.inject(node, Fault(str(what)))
        return lambda: nodes.heal(node)

    # ------------------------------------------------------------------ looking

    @property
    def plc(self) -> InlinePlc:
        """Whoever runs the PLC program."""
        plc = self.simulation.plc
        assert isinstance(plc, InlinePlc), "the machine has no PLC program"
        return plc

    @property
    def host(self) -> PlcHost:
        """The host of the PLC program."""
        return self.plc.host

    @property
    def program(self) -> Program:
        """The PLC program that runs, with its variables."""
        return self.host.program

    def input(self, name: str) -> bool:
        """An input as the PLC sees it. KeyError for an unknown name."""
        byte, bit = divmod(self._inputs[name], 8)
        return bool(self.hli.image.digital_in_r[byte] >> bit & 1)

    def output(self, name: str) -> bool:
        """An output as the PLC has set it. KeyError for an unknown name."""
        byte, bit = divmod(self._outputs[name], 8)
        return bool(self.hli.image.digital_out_w[byte] >> bit & 1)

    def value(self, name: str) -> float:
        """An analogue input as the PLC sees it, or an analogue output as the device puts it out, in its unit. KeyError."""
        if name in self._analogue.inputs:
            return float(self.hli.image.analogue_in_r[self._analogue.inputs[name]])
        if name not in self._analogue.outputs:
            raise KeyError(f"{name} is no analogue input or output")
        return self.plant.values_out.get(name, 0.0)

    def position(self, axis: str) -> float:
        """The set-point of an axis."""
        return float(self.simulation.drives.image.target_position[self.description.axis_index(axis)])

    def speed(self, spindle: str) -> float:
        """Actual speed of a spindle, rev/min."""
        return float(self.simulation.drives.image.actual_velocity[self.description.axis_index(spindle)]) / 6.0

    @property
    def moving(self) -> bool:
        """The path moves."""
        return not self.simulation.controller.interpolator.standstill

    @property
    def mode(self) -> Mode:
        """Operating mode of the channel."""
        return Mode(self.hli.channels[0].control.mode_and_state.mode_r)

    @property
    def state(self) -> State:
        """State of the channel in its mode."""
        return State(self.hli.channels[0].control.mode_and_state.state_r)

    @property
    def line(self) -> int:
        """Line of the NC program that moves."""
        return int(self.hli.channels[0].status.line_r)

    @property
    def waits_for(self) -> StopCondition:
        """Why the path stands although a program is active."""
        return StopCondition(self.hli.channels[0].status.stop_condition_r)

    @property
    def alarms(self) -> tuple[str, ...]:
        """Texts of the alarms that stand, those of the PLC program included; the newest first."""
        return tuple(line.text for line in alarm_lines(self.hli, active_only=True))

    @property
    def events(self) -> list[Event]:
        """Everything that has happened."""
        return self.simulation.log

    def reload(self, seconds: float = 20.0) -> str:
        """As `tandem plc reload`: the answer of the PLC, the traceback if it refuses."""
        platform = self.hli.platform
        platform.reload_request_w += 1
        self.wait_until(lambda: platform.reload_done_w == platform.reload_request_w, seconds, "online change")
        return get_text(platform, "reload_text_w")

    def close(self) -> None:
        """Leave the simulated bus."""
        self.simulation.close()
