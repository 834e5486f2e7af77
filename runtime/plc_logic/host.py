"""The host of a PLC program: binds it to an HLI and runs its cycles, in the PLC process or inside a simulation."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.diagnostics.errors import Place
from runtime.hli.analogue import AnaloguePlaces
from runtime.hli.layout import Axis, Channel, Hli, ManualControl
from runtime.hli.memory import HliMemory, get_text, put_text
from runtime.hli.technology import Taken, TechnologyTaker
from runtime.plc_logic.areas import AxisPort, ChannelPort, SpindlePort
from runtime.plc_logic.cycle_time import cycle_at_ns
from runtime.plc_logic.errors import PlcError, PlcFailure
from runtime.plc_logic.external import external_of
from runtime.plc_logic.handlers import NcFunction, nc_function
from runtime.plc_logic.image import NO_ANALOGUE, Io, io_of
from runtime.plc_logic.loader import failure
from runtime.plc_logic.online_change import TakenOver, start_of, take_over
from runtime.plc_logic.program import ByName, Program
from runtime.plc_logic.reports import Reports
from runtime.plc_logic.retained_variables import RetainJournal, declared, starting_values
from runtime.plc_logic.tasks import Tasks

SPINDLE = 4  # axis_type_r


@dataclass(slots=True)
class _Call:
    """A function that is being carried out. Without a handler, `handler` is empty."""

    taken: Taken
    function: NcFunction
    handler: str
    start_ns: int
    sequence: Iterator[None] | None = None  # of a handler that is a generator


class _Source:
    """Where functions come from: a channel or an axis."""

    def __init__(self, area: Channel | Axis) -> None:
        self.name = get_text(area, "name_r")
        self.taker = TechnologyTaker(area, self._forget)
        self.calls: list[_Call] = []
        self.was_reset = False

    def _forget(self) -> None:
        self.calls = []
        self.was_reset = True


@dataclass(slots=True)
class _Running:
    """A version of the program, and what belongs to it."""

    program: Program
    io: Io
    tasks: Tasks
    retained: dict[str, Any]
    start: dict[str, Any]  # what its setup has made


class PlcHost:
    """Runs one program: `start`, then `cycle` once per PLC cycle, then `stop`; `replace` puts a new version in its place.

    `inputs` and `outputs` give the image bit of every name, `analogue` the places of the others; channels and axes are
    named in the HLI. `clock_ns`, if given, measures how long a cycle takes. `watchdog_us` is the longest gap between two
    cycles that the CNC accepts. `journal` makes the journal of retained variables, when a program has some; without it
    they live as long as the host. `wall_ns` gives the time since 1970.
    """

    def __init__(
        self,
        program: type[Program],
        memory: HliMemory,
        inputs: Mapping[str, int],
        outputs: Mapping[str, int],
        analogue: AnaloguePlaces = NO_ANALOGUE,
        *,
        watchdog_us: int = 50_000,
        clock_ns: Callable[[], int] | None = None,
        journal: Callable[[], RetainJournal] | None = None,
        wall_ns: Callable[[], int] | None = None,
    ) -> None:
        hli = memory.hli
        self._hli: Hli = hli
        self._platform = hli.platform
        self._name = program.__name__
        self._watchdog_us = watchdog_us
        self._clock_ns = clock_ns
        self._wall_ns = wall_ns
        self._open_journal = journal
        self._journal: RetainJournal | None = None
        self._inputs, self._outputs, self._analogue = inputs, outputs, analogue
        self._last_ns: int | None = None
        self._start_ns = 0
        self._channels: list[Channel] = [hli.channels[i] for i in range(hli.head.channels_r)]
        self._axes: list[Axis] = [hli.axes[i] for i in range(hli.head.axes_r)]
        self._areas: list[Channel | Axis] = [*self._channels, *self._axes]
        self._sources = [_Source(area) for area in self._areas]
        self._reports = Reports(hli.platform.lc_error)
        channel_ports = [ChannelPort(channel) for channel in self._channels]
        axis_ports = [SpindlePort(axis) if axis.axis_type_r == SPINDLE else AxisPort(axis) for axis in self._axes]
        self._ports: list[ChannelPort | AxisPort] = [*channel_ports, *axis_ports]
        self._program_type = program
        self._bound: dict[str, object] = {
            "external": external_of(hli),
            "channels": channel_ports,
            "axes": ByName("axis", {port.name: port for port in axis_ports}),
            "spindles": ByName("spindle", {port.name: port for port in axis_ports if isinstance(port, SpindlePort)}),
            "time": 0.0,
            "cycle_time": 0.0,
            "_reports": self._reports,
        }
        self._running: _Running

    @property
    def program(self) -> Program:
        """The program that runs; after `start`."""
        return self._running.program

    @property
    def alarms(self) -> list[str]:
        """Texts of the alarms, warnings and messages that stand."""
        return self._reports.standing

    @property
    def waiting(self) -> list[NcFunction]:
        """The technology functions that are being carried out."""
        return [call.function for source in self._sources for call in source.calls]

    def start(self, time_ns: int) -> None:
        """Make the program, call its setup(), and log on. `time_ns` is the runtime's clock. Raises PlcFailure."""
        self._start_ns = time_ns
        with cycle_at_ns(time_ns, self._wall()):
            try:
                for area in self._areas:
                    _give_back(area)
                self._running = self._made(self._program_type)
            except (Exception, SystemExit) as error:
                raise self._failed(failure(catalogue.PLC_SETUP_RAISED, self._name, error)) from error
        self._platform.plc_error_id_w = 0
        for source in self._sources:
            source.taker.restart()
        for channel in self._channels:
            channel.watchdog.cycle_time_w = self._watchdog_us
            channel.watchdog.alive_rw = True
            channel.watchdog.enable_w = True
        for area in (self._platform, *self._areas):
            area.plc_present_w = True

    def cycle(self, time_ns: int) -> None:
        """One PLC cycle. Raises PlcFailure if the program does; then nothing of this cycle reaches outputs and CNC.

        The log-on flags stay: a PLC that failed has not given up its responsibility, so the CNC goes on waiting.
        """
        cycle = self._begin()
        with cycle_at_ns(time_ns, self._wall()):
            self._take(time_ns)
            try:
                finished = self._think(self._running, time_ns)
            except PlcFailure as error:
                raise self._failed(error) from None
            except (Exception, SystemExit) as error:
                raise self._failed(failure(catalogue.PLC_RAISED, self._name, error)) from error
            self._act(self._running, finished)
        self._end(cycle, time_ns)

    def stop(self) -> None:
        """Log off on purpose: the operator gets all units back, and the CNC no longer waits for acknowledgements."""
        for area in (self._platform, *self._areas):
            area.plc_present_w = False
        for channel in self._channels:
            channel.watchdog.enable_w = False
        for area in self._areas:
            _give_back(area)
        if self._journal is not None:
            self._journal.close()

    # ------------------------------------------------------------------ the versions of the program

    def _made(self, program_type: type[Program]) -> _Running:
        """A program with everything bound, after its setup. The machine knows nothing of it yet."""
        program = program_type()
        io = io_of(program_type, self._hli.image, self._inputs, self._outputs, self._analogue)
        if self._journal is None and self._open_journal is not None and declared(program_type):
            self._journal = self._open_journal()
        retained, problems = starting_values(program_type, self._journal.kept if self._journal else {})
        bound = {**self._bound, "io": io, "_retained": retained, "_saved": self._saved}
        vars(program).update(bound)
        program.time = self._start_ns * 1e-9
        program.setup()
        for problem in problems:
            self._reports.report(problem.entry, problem.text)
        return _Running(program, io, Tasks(program_type), retained, start_of(program, bound))

    @property
    def sequences(self) -> list[str]:
        """The functions whose handlers are sequences under way: they belong to the version that has begun them."""
        return [str(call.function) for source in self._sources for call in source.calls if call.sequence is not None]

    def replace(self, program_type: type[Program], time_ns: int) -> TakenOver:
        """A new version takes the state of the present one over and runs this PLC cycle, in the place of `cycle`.

        Raises PlcFailure if its setup or this first cycle fails; then nothing of it has reached outputs and CNC, the old
        program has lost nothing, and the caller runs the cycle with it.
        """
        cycle = self._begin()
        old, name = self._running, program_type.__name__
        self._take(time_ns)
        calls = [(source, list(source.calls)) for source in self._sources]
        elapsed = self._last_ns
        with cycle_at_ns(self._start_ns, self._wall()):  # what a setup computes from the time is the same again
            try:
                new = self._made(program_type)
            except (Exception, SystemExit) as error:
                raise failure(catalogue.PLC_SETUP_RAISED, name, error) from error
            bound = {**self._bound, "io": new.io, "_retained": None, "_saved": None}
            try:
                taken_over = take_over(old.program, old.start, new.program, bound)
            except ValueError as error:
                raise PlcFailure(catalogue.PLC_RELOAD_STATE, Place(), "", program=name, what=error) from error
        for variable in new.retained.keys() & old.retained.keys():
            if declared(program_type)[variable].fits(old.retained[variable]):
                new.retained[variable] = deepcopy(old.retained[variable])
        new.tasks.keep_times_of(old.tasks)
        new.io.take_outputs_of(old.io)
        self._running, self._name = new, name
        with cycle_at_ns(time_ns, self._wall()):
            try:
                for source in self._sources:
                    for call in source.calls:
                        call.handler = self._handler(call.function)
                finished = self._think(new, time_ns)
            except (Exception, SystemExit) as error:
                self._running, self._name = old, type(old.program).__name__
                self._last_ns = elapsed
                for source, before in calls:
                    source.calls = before
                    for call in before:
                        call.handler, call.sequence = self._handler(call.function), None
                raise failure(catalogue.PLC_RELOAD_RAISED, name, error) from error
            self._act(new, finished)
        self._end(cycle, time_ns)
        return taken_over

    def _saved(self) -> bool:
        return self._journal is None or self._journal.saved

    def _wall(self) -> int:
        return self._wall_ns() if self._wall_ns is not None else 0

    # ------------------------------------------------------------------ the parts of a cycle

    def _begin(self) -> tuple[int, int]:
        """The number of the cycle, and when it begins."""
        return int(self._platform.plc_cycle_request_r), self._clock_ns() if self._clock_ns is not None else 0

    def _end(self, cycle: tuple[int, int], time_ns: int) -> None:
        """The cycle is over; the CNC may see it."""
        self._last_ns = time_ns
        request, begin_ns = cycle
        if self._clock_ns is not None:
            self._platform.plc_cycle_time_ns_w = self._clock_ns() - begin_ns
        self._platform.plc_cycle_done_w = request

    def _think(self, running: _Running, time_ns: int) -> list[Taken]:
        """Everything the program does in a cycle; the technology functions that are finished."""
        program = running.program
        program.time = time_ns * 1e-9
        program.cycle_time = 0.0 if self._last_ns is None else (time_ns - self._last_ns) * 1e-9
        Io.read_inputs(running.io)
        finished = self._carry_out(time_ns)
        running.tasks.run(program, time_ns)
        program.cycle()
        return finished

    def _act(self, running: _Running, finished: list[Taken]) -> None:
        """Let the machine know. First what must survive: then what is acknowledged has been kept and commanded."""
        journal = self._journal
        if journal is not None:
            journal.commit(running.retained)
            while journal.problems:
                problem = journal.problems.pop()
                self._reports.report(problem.entry, problem.text)
        Io.write_outputs(running.io)
        for taken in finished:
            taken.done()
        for port in self._ports:
            port.update()
        self._reports.update()
        for source in self._sources:
            source.was_reset = False  # on_reset was called
        for channel in self._channels:
            channel.watchdog.alive_rw = True

    # ------------------------------------------------------------------ technology functions

    def _take(self, time_ns: int) -> None:
        """Take what the CNC has put out, and forget what it has withdrawn."""
        for source in self._sources:
            for taken in source.taker.take():
                source.calls.append(self._call(taken, source.name, time_ns))

    def _carry_out(self, time_ns: int) -> list[Taken]:
        """Call the handlers of all functions that were taken; the functions that are finished."""
        if any(source.was_reset for source in self._sources):
            self._reports.acknowledge()
            self.program.on_reset()
        finished: list[Taken] = []
        for source in self._sources:
            if source.calls:
                open_calls = []
                for call in source.calls:
                    if self._advance(call, time_ns):
                        finished.append(call.taken)
                    else:
                        open_calls.append(call)
                source.calls = open_calls
        return finished

    def _call(self, taken: Taken, area: str, time_ns: int) -> _Call:
        function = nc_function(taken.function, area)
        return _Call(taken, function, self._handler(function), time_ns)

    def _handler(self, function: NcFunction) -> str:
        """Name of the method that carries it out, "" without."""
        handlers = self.program.handlers
        return handlers.get((function.kind, function.number)) or handlers.get((function.kind, None)) or ""

    def _advance(self, call: _Call, time_ns: int) -> bool:
        """One cycle of a function; whether it is finished."""
        function = call.function
        function.elapsed = (time_ns - call.start_ns) * 1e-9
        if not call.handler:
            entry = catalogue.PLC_NO_HANDLER if function.acknowledged else catalogue.PLC_NO_HANDLER_MOS
            self._reports.report(entry, entry.text.format(function=function, line=function.line), function.line)
            return not function.acknowledged
        self._reports.line = function.line
        result = self._step(call)
        self._reports.line = 0
        if result is not True and result is not False:
            raise PlcError(
                catalogue.PLC_HANDLER_RESULT, handler=f"{self._name}.{call.handler}", result=result, function=function
            )
        return result

    def _step(self, call: _Call) -> object:
        if call.sequence is None:
            result = getattr(self.program, call.handler)(call.function)
            if not isinstance(result, Iterator):
                return result
            call.sequence = result
        try:
            next(call.sequence)
        except StopIteration:
            return True
        return False

    def _failed(self, error: PlcFailure) -> PlcFailure:
        report_failure(self._hli, error)
        return error


def report_failure(hli: Hli, error: PlcFailure) -> None:
    """Tell the CNC and whoever looks into the HLI why the PLC stands."""
    platform = hli.platform
    platform.plc_error_id_w = error.problem.entry.id
    put_text(platform, "plc_error_text_w", "\n".join(part for part in (error.problem.text, error.trace) if part))
    platform.plc_error_count_w += 1


def _units(control: ctypes.Structure) -> Iterator[Any]:
    """The control units of an area, those of manual mode included."""
    for name, *_ in control._fields_:
        part = getattr(control, name)
        if isinstance(part, ManualControl):
            yield from _units(part)
        elif hasattr(part, "enable_w"):
            yield part
        elif isinstance(part, ctypes.Array) and hasattr(part[0], "enable_w"):
            yield from part


def _give_back(area: Channel | Axis) -> None:
    """Take back every claim and command: those of a PLC that logs off, or of one that was killed."""
    for unit in _units(area.control):
        if hasattr(unit, "command_semaphor_rw"):
            unit.request_semaphor_rw = False
            unit.command_semaphor_rw = False
        else:
            unit.command_w = type(unit.command_w)(0)
        unit.enable_w = False
    if isinstance(area, Channel):
        area.lc_mode.enable_w = False
    if isinstance(area, Axis):
        area.job.command_semaphor_rw = False
        area.job.stop_hold_w = False
