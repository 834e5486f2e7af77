"""The whole machine in one process under a virtual clock: `tandem simulate` and every test of behaviour.

Same preparation, same controller, same PLC program, same CANopen master against simulated nodes as in the real machine; only
the clock and the bus differ. Two runs do the same, bit by bit.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import numpy.typing as npt

from runtime.cnc.block_json import rows
from runtime.cnc.blocks import Block
from runtime.cnc.motion_queue import CAPACITY, MotionQueue
from runtime.cnc.path_preparation import PumpState
from runtime.cnc.preparation_link import PreparationLink
from runtime.cnc.tools.offset_table import OffsetTable
from runtime.cnc.tools.table import ToolTable
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import machine as alarms
from runtime.diagnostics.errors import Problem, Severity
from runtime.diagnostics.events import Event, EventKind, EventRing
from runtime.drives import DriveImage, DriveSystem, IdealDrives
from runtime.fieldbus.simulator.plant import SimulatedPlant
from runtime.hli.describe import analogue_places, io_bits
from runtime.hli.layout import Mode, SearchOrder, State, StopCondition
from runtime.hli.memory import HliMemory
from runtime.scheduler.clock import VirtualClock
from runtime.scheduler.controller import Controller
from runtime.scheduler.outside import RunningMachine
from runtime.scheduler.plc_inline import InlinePlc
from runtime.scheduler.plc_link import PlcPartner
from runtime.scheduler.preparation import BATCH, Preparation
from runtime.scheduler.recorded import Seam, SimulationRecording, watch
from runtime.scheduler.tool_tables import listed_tools
from runtime.scheduler.trace import SampleRecorder, TraceWriter

Floats = npt.NDArray[np.float64]
START_LIMIT = 30.0  # s until the drives and the PLC must be ready
STANDING_LIMIT = 120.0  # s without any event or motion: nobody will answer any more
CONTINUE_AFTER = 1.0  # s that the simulated operator takes to press continue after M00
_EPOCH_NS = 1_000_000_000_000_000_000  # the wall clock of the virtual machine starts here
_EPOCH = datetime(2001, 9, 9, 1, 46, 40)  # the same moment
_BLOCK_EVENTS = (EventKind.BLOCK_START, EventKind.BLOCK_END)
_ROOM = {PumpState.FULL: BATCH, PumpState.FINISHED: CAPACITY + 1}  # a queue never has so much room: nothing more comes
_instances = itertools.count()


@dataclass(slots=True)
class Result:
    """What a simulated program did."""

    time: float = 0.0  # s, from cycle start to program end
    path_length: float = 0.0  # mm
    positions: dict[str, float] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    parameters: dict[int, float] = field(default_factory=dict)
    cycles: int = 0

    @property
    def good(self) -> bool:
        return not self.problems

    def summary(self) -> dict[str, object]:
        """The object of summary.json."""
        return {
            "time_s": round(self.time, 9),
            "path_length_mm": round(self.path_length, 9),
            "positions": self.positions,
            "errors": self.problems,
            "variables": {f"P{number}": value for number, value in sorted(self.parameters.items())},
            "messages": [event.text for event in self.events if event.kind is EventKind.MESSAGE],
        }


class Simulation:
    """A machine in virtual time. `cycle` moves it one cycle on; `run_program` does a program from start to end.

    `partner` takes the place of the PLC program that the machine description names; `plc=False` runs without any. `tools` are
    those of the machine's initial list if none are given, and what a program writes into them ends with the simulation. `record`:
    a recording for `tandem replay`, in which the description `machine_file` stands.
    """

    def __init__(
        self,
        machine: Machine,
        *,
        ideal_axes: bool = False,
        dialect: str = "",  # "": as the description says
        trace: Path | None = None,
        samples: bool = False,
        plc: bool = True,
        partner: Callable[[HliMemory], PlcPartner] | None = None,
        base: Path | None = None,
        start_position: Floats | None = None,
        tools: ToolTable | None = None,
        offsets: OffsetTable | None = None,
        plant: SimulatedPlant | None = None,
        record: Path | None = None,
        machine_file: Path | None = None,
    ) -> None:
        self.machine = machine
        self.period = machine.cycle.period
        self.clock = VirtualClock(machine.cycle.period)
        channel = machine.channels[0]
        self.memory = HliMemory.private()
        self.events = EventRing()
        self.queue = MotionQueue(len(channel.axes))
        self.link = PreparationLink(len(channel.axes))
        self.writer = TraceWriter(trace) if trace else None
        self.samples = SampleRecorder(channel.axes) if trace or samples else None
        self.outside = RunningMachine(machine, self.memory.hli, self.link, now=self._date)
        self.preparation = Preparation(
            machine,
            0,
            self.queue,
            self.link,
            self.outside,
            tools=listed_tools(machine) if tools is None else tools,
            offsets=offsets,
            dialect=dialect,
            on_block=self._trace_block if trace else None,
        )
        self.plant = plant or SimulatedPlant()
        self._leave_bus: list[Callable[[], None]] = []
        self.drives, self._step_nodes = self._build_drives(ideal_axes, start_position)
        self.plc: PlcPartner | None = None
        if partner is not None:
            self.plc = partner(self.memory)
        elif plc and machine.plc.program:
            self.plc = InlinePlc(machine, self.memory, base)
        self.drives.start()
        self.recording: SimulationRecording | None = None
        seam = Seam(self.drives, self.memory, self.queue, self.link, self.plc, self._wall_ns)
        if record is not None:
            self.recording = SimulationRecording(record, machine, machine_file, seam, real_drives=not ideal_axes)
            seam = self.recording.seam
        self.controller = Controller(
            machine,
            seam.drives,
            seam.memory,
            self.events,
            seam.queue,
            seam.link,
            seam.plc,
            wall_clock=seam.wall_clock,
            real_drives=not ideal_axes,
        )
        if self.recording is not None:
            watch(self.recording.border, self.controller)
        self.controller.channel.trace_blocks = trace is not None
        self.memory.hli.head.running_r = True
        self.log: list[Event] = []  # every event so far; those of single blocks only go into the trace
        self.problems: list[Problem] = []  # every alarm so far
        self.controller.alarms.on_problem = self.problems.append
        self._quiet_since = 0.0
        self._room = 0  # free records in the queue from which the preparation goes on

    # ------------------------------------------------------------------ building

    def _build_drives(self, ideal: bool, start: Floats | None) -> tuple[DriveSystem, Callable[[], None]]:
        if ideal:
            drives = IdealDrives(len(self.machine.axes), start, self.period)
            plant = PlantOnImage(self.machine, drives.image, self.plant, lambda: self.time)
            plant.step()  # the first cycle sees the inputs as they are
            every = self.machine.plc.every  # nobody looks at the inputs more often

            def step_plant() -> None:
                if self.clock.cycle % every == 0:
                    plant.step()

            return drives, step_plant
        import can

        from runtime.fieldbus.several import drive_system
        from runtime.fieldbus.simulator import SimulatedNodes

        instance = next(_instances)
        nodes_buses, master_buses = (
            {
                name: can.Bus(f"tandem-simulation-{instance}-{name}", interface="virtual")
                for name in self.machine.fieldbus.all_buses()
            }
            for _ in range(2)
        )
        self._leave_bus = [bus.shutdown for bus in (*nodes_buses.values(), *master_buses.values())]
        self.nodes = SimulatedNodes(self.machine, nodes_buses, plant=self.plant)

        def step() -> None:
            self.nodes.step(self.time)

        def idle() -> None:  # while the master boots: the nodes and the virtual time go on
            self.clock.wait()
            step()

        return drive_system(self.machine, master_buses, now=lambda: self.time, idle=idle), step

    def _trace_block(self, block: Block) -> None:
        if self.writer is not None:
            for row in rows(block, self.machine.channels[0].axes):
                self.writer.block(row)

    @property
    def time(self) -> float:
        """Virtual seconds since the start."""
        return self.clock.now()

    # ------------------------------------------------------------------ time

    def _wall_ns(self) -> int:
        return _EPOCH_NS + int(self.time * 1e9)

    def _date(self) -> datetime:
        """The wall clock of the virtual machine."""
        return _EPOCH + timedelta(microseconds=round(self.time * 1e6))

    def cycle(self) -> None:
        """One cycle of the machine, with all that the other processes do meanwhile."""
        self.before_cycle()
        self.controller.cycle(self.time)
        self.after_cycle()

    def before_cycle(self) -> None:
        """The preparation fills the queue, a batch at a time, and the time goes on."""
        if self.queue.free >= self._room or not self.link.answered:
            while (state := self.preparation.poll()) is PumpState.MORE:
                pass
            self._room = _ROOM.get(state, 0)
        self.clock.wait()
        if self.recording is not None:
            self.recording.border.begin(self.time)

    def after_cycle(self) -> None:
        """The simulated nodes answer, trace, log and recording take what has come."""
        if self.recording is not None:
            self.recording.drain()
        self._step_nodes()
        if self.samples is not None and self.controller.channel.active:
            path = self.controller.interpolator
            rapid = not 0.0 < self.controller.channel.programmed_feed < float("inf")
            self.samples.add(self.time, path.set_point, path.path_velocity, max(path.line, 0), rapid)
        for event in self.events.take():
            if self.writer is not None:
                self.writer.event(event)
            if self.writer is None or event.kind not in _BLOCK_EVENTS:
                self.log.append(event)
            self._quiet_since = self.time

    def run_until(self, condition: Callable[[], bool], limit: float) -> bool:
        """Cycles until `condition` holds; FALSE if it does not within `limit` s of virtual time."""
        end = self.time + limit
        while not condition():
            if self.time >= end:
                return False
            self.cycle()
        return True

    def ready(self) -> bool:
        """Drives enabled, PLC running: a program can start."""
        plc = self.controller.plc
        return bool(self.controller.supervision.enabled.all()) and (plc is None or plc.running)

    # ------------------------------------------------------------------ operator

    def order(self, mode: Mode, state: State, parameter: str = "") -> None:
        """Give an order to the mode unit as the operator."""
        operator = self.memory.hli.operator[0]
        order = operator.order_w
        order.from_mode = order.from_state = 0
        order.to_mode, order.to_state = mode, state
        order.parameter = parameter.encode()
        operator.order_semaphor_rw = True

    def start(self, program: Path, search: SearchOrder | None = None) -> None:
        """Order a program, entered where `search` tells; it is active a cycle later."""
        if search is not None:
            unit = self.memory.hli.operator[0].block_search
            unit.data_w, unit.semaphor_rw = search, True
        self.order(Mode.AUTOMATIC, State.ACTIVE, str(program))

    # ------------------------------------------------------------------ a whole program

    def run_program(
        self,
        program: Path,
        *,
        progress: Callable[[float, int], None] | None = None,
        search: SearchOrder | None = None,
    ) -> Result:
        """From cycle start, or from where `search` enters it, to program end, or to the error that ends it."""
        channel = self.controller.channel
        if not self.run_until(lambda: self.ready() or channel.error is not None, START_LIMIT):
            self.problems.append(Problem(alarms.NOT_READY, {"seconds": START_LIMIT}))
        if not self.ready():
            return self._result(0.0)
        self.start(program, search)
        begin = self.time
        self.cycle()
        for count in itertools.count():
            if not channel.active:
                break
            self.cycle()
            self._simulated_operator()
            if not channel.interpolator.standstill:
                self._quiet_since = self.time
            if self.time - self._quiet_since > STANDING_LIMIT:
                waits = StopCondition(channel.stop_condition)
                self.problems.append(
                    Problem(alarms.SIMULATION_STANDS, {"seconds": STANDING_LIMIT, "waits": waits.name})
                )
                break
            if progress and count % 1000 == 0:
                progress(self.time - begin, channel.interpolator.line)
        took = self.time - begin
        self.cycle()  # the state that the program leaves is told a cycle later
        return self._result(took)

    def _simulated_operator(self) -> None:
        """Presses continue where the program waits for it (M00, single block)."""
        waits = self.controller.channel.stop_condition & StopCondition.WAIT_CONTINUE
        if waits and self.time - self._quiet_since > CONTINUE_AFTER:
            self.memory.hli.operator[0].continue_motion_rw = True

    def _result(self, time: float) -> Result:
        image = self.drives.image
        names = self.machine.channels[0].axes
        decoder = self.preparation.decoder
        return Result(
            time=time,
            path_length=self.controller.channel.path_length,
            positions={name: float(image.target_position[self.machine.axis_index(name)]) for name in names},
            problems=[_told(problem) for problem in self.errors],
            events=list(self.log),
            parameters=dict(decoder.parameters) if decoder else {},
            cycles=self.controller.cycle_number,
        )

    @property
    def errors(self) -> list[Problem]:
        """The alarms so far, without warnings."""
        return [problem for problem in self.problems if problem.entry.severity >= Severity.ERROR]

    def close(self, result: Result | None = None) -> None:
        """Write what stands at the end of the trace, leave the bus, give back the program's files."""
        self.drives.stop()
        self.preparation.end()
        if self.recording is not None:
            self.recording.close()
        while self._leave_bus:
            self._leave_bus.pop()()
        if self.writer is not None and self.samples is not None:
            self.writer.close(self.samples, (result or Result()).summary())
        self.memory.close()

    def __enter__(self) -> Simulation:
        return self

    def __exit__(self, *_exception: object) -> None:
        if self.writer is None:
            self.close()


def _told(problem: Problem) -> str:
    """`file:line:column: id: text`, without the place if there is none."""
    return str(problem) if problem.place.file or problem.place.line else f"{problem.entry.id}: {problem.text}"


class PlantOnImage:
    """The plant around ideal drives: inputs follow outputs in the drive image, without a bus."""

    def __init__(self, machine: Machine, image: DriveImage, plant: SimulatedPlant, now: Callable[[], float]) -> None:
        self._image = image
        self._plant = plant
        self._now = now
        self._inputs, self._outputs = io_bits(machine)
        self._values = analogue_places(machine)
        self._described = {one.name: one for node in machine.fieldbus.io for one in node.analogue_inputs}

    def step(self) -> None:
        """One cycle of the plant."""
        image = self._image
        if self._described:
            self._step_values()
        for name, place in self._values.outputs.items():
            self._plant.values_out[name] = float(image.analogue_out[place.place])
        outputs = {name: bool(image.digital_out[bit // 8] >> (bit % 8) & 1) for name, bit in self._outputs.items()}
        inputs = self._plant.step(self._now(), outputs)
        for name, bit in self._inputs.items():
            mask = 1 << bit % 8
            if inputs.get(name, False):
                image.digital_in[bit // 8] |= mask
            else:
                image.digital_in[bit // 8] &= 0xFF ^ mask

    def _step_values(self) -> None:
        image = self._image
        for name, place in self._values.inputs.items():
            one = self._described[name]
            low, high = one.bounds
            value = max(low, min(high, self._plant.values.get(name, 0.0)))
            image.analogue_in[place] = value
            image.analogue_valid[place] = one.range is None or one.range[0] <= value <= one.range[1]
