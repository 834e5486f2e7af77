"""The preparation of one channel: program file → decoder → path preparation → motion queue, driven by the link's orders.

It runs ahead of the cycle as far as the queue has room. In a running machine it is a process of its own; the simulation pumps
the same object between two cycles.
"""

from __future__ import annotations

import itertools
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from runtime.cnc.blocks import Block, Floats
from runtime.cnc.decoder import (
    AnyDecoder,
    AnyProgram,
    ChannelMemory,
    DecoderSetup,
    decoder_of,
    load_program,
    located,
)
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.motion_queue import MotionQueue
from runtime.cnc.path_preparation import (
    BlockSearchStage,
    LateSynchronisation,
    MicroJointSettings,
    PumpState,
    QueueWriter,
    SoftwareLimits,
)
from runtime.cnc.path_preparation.channel_dynamics import channel_dynamics
from runtime.cnc.preparation_link import Failure, Order, PreparationLink, PreparationState, StartOrder
from runtime.cnc.stages import prepared
from runtime.cnc.tools.offset_table import OffsetTable
from runtime.cnc.tools.table import ToolTable
from runtime.config.machine import Machine
from runtime.diagnostics.errors import Problem, TandemError
from runtime.hli.layout import Mode
from runtime.scheduler.outside import RunningMachine
from runtime.scheduler.run_ahead import RunAhead

BATCH = 256  # records between two looks at the link
MOST_WARNINGS = 20  # told per program; a check tells all of them
Source = Callable[[StartOrder, RunningMachine], Iterator[Block]]


class Preparation:
    """`poll` acts on the waiting order and then moves one batch of blocks; it never blocks on the queue.

    `outside` is what the decoder sees of the machine, `tools` its tool table, `offsets` its offset table, `dialect` that of the
    programs, "" as described. `source` takes the place of file and decoder: it makes the blocks of a program that is started.
    """

    def __init__(
        self,
        machine: Machine,
        channel: int,
        queue: MotionQueue,
        link: PreparationLink,
        outside: RunningMachine,
        *,
        tools: ToolTable | None = None,
        offsets: OffsetTable | None = None,
        dialect: str = "",
        on_block: Callable[[Block], None] | None = None,
        source: Source | None = None,
    ) -> None:
        axes = [machine.axes[machine.axis_index(name)] for name in machine.channels[channel].axes]
        self._names = machine.channels[channel].axes
        self._period = machine.cycle.period
        self._setup = DecoderSetup.from_machine(machine, channel)
        self._memory = ChannelMemory(self._setup, tools, offsets)
        self._late = LateSynchronisation()
        self._machine, self._channel = machine, channel
        self._run_ahead = RunAhead.of(machine.channels[channel].parameters)
        self._axis_limits = AxisLimits.of(axes)
        self._queue = queue
        self._link = link
        self._outside = outside
        self._source = source or self._decoded
        self._flushes = 0  # places of #FLUSH WAIT in the queue
        self._dialect = dialect or machine.channels[channel].dialect
        self._on_block = on_block
        self._blocks: Iterator[Block] | None = None
        self._writer: QueueWriter | None = None
        self._program: AnyProgram | None = None
        self._blocks_folder: tempfile.TemporaryDirectory[str] | None = None  # for NC blocks that are no file
        self.decoder: AnyDecoder | None = None  # of the last program, for its parameters
        self._warnings: list[Problem] = []  # of the stages behind the decoder
        self._warned = [0, 0]  # how many of the decoder's, and of these, were told

    def poll(self) -> PumpState:
        """FULL, FLUSH: waits for the cycle. HELD: the decoder waits for the outside. FINISHED: nothing to do.

        MORE: call again at once.
        """
        order = self._link.waiting_order
        if order is not Order.NONE:
            self._blocks = None
            self._outside.forget()
            if order is Order.START:
                self._begin()
            else:
                self._link.finish(PreparationState.IDLE)
            self._link.answer()
        waits = self._outside.hand_over()
        if self._blocks is None or self._writer is None:
            return PumpState.HELD if waits else PumpState.FINISHED
        if waits or self._link.reached < self._flushes:
            return PumpState.HELD if waits else PumpState.FLUSH
        if self._run_ahead.reached(self._queue):
            return PumpState.FULL
        try:
            state = self._writer.pump(self._blocks, BATCH if self._run_ahead.unlimited else 1)
        except TandemError as error:
            self._tell_warnings()
            self._fail(error)
            return PumpState.FINISHED
        self._tell_warnings()
        self._link.set_holds(state is PumpState.HELD)
        if state is PumpState.FLUSH:
            self._flushes += 1
        elif state is PumpState.FINISHED:
            self._blocks = None
            if self._link.waiting_order is Order.NONE:
                self._link.finish(PreparationState.FINISHED)
            if self._outside.hand_over():
                return PumpState.HELD
        return state

    def close(self) -> None:
        """Give back the files of the last program."""
        if self._program is not None:
            self._program.close()
            self._program = None

    def end(self) -> None:
        """Give back everything; nothing is prepared any more."""
        self.close()
        if self._blocks_folder is not None:
            self._blocks_folder.cleanup()
            self._blocks_folder = None

    def _begin(self) -> None:
        order = self._link.read_start()
        self.close()
        self._flushes = 0
        self._warnings, self._warned = [], [0, 0]
        self._memory.came_to_end = order.after_end
        try:
            source = self._source(order, self._outside)
        except TandemError as error:
            self._fail(error)
            return
        limits = SoftwareLimits.of(self._machine, self._channel)
        joints = MicroJointSettings.of(self._machine.channels[self._channel].parameters)
        blocks = prepared(source, self._axis_limits, limits, self._late, warnings=self._warnings, joints=joints)
        if order.search is not None:
            begin = order.start if order.begin is None else order.begin
            search = BlockSearchStage(order.search, Path(order.program).name, begin, self._standing, self._ordered)
            self._outside.search = search
            blocks = search(blocks)
        if self._on_block is not None:
            blocks = itertools.chain.from_iterable(map(self._observed, blocks))
        self._blocks = blocks
        self._writer = QueueWriter(
            self._queue,
            self._axis_limits,
            self._period,
            self._names,
            self._outside.error_texts.describe,
            channel_dynamics(self._machine, self._channel),
            self._setup.filters,
        )

    def _decoded(self, order: StartOrder, outside: RunningMachine) -> Iterator[Block]:
        """The blocks of the program file. Raises TandemError."""
        setup = self._setup.in_mode(Mode(order.mode))
        program = self._program = load_program(self._file(order), setup, self._dialect)
        self.decoder = decoder_of(
            program,
            setup,
            start=order.start if order.begin is None else order.begin,
            memory=self._memory,
            outside=outside,
            skip_levels=lambda: outside.skip_levels(order.skip_levels),
            interrupted=self._ordered,
            search=order.search,
        )
        return self.decoder.blocks()

    def _standing(self) -> Floats:
        """Where the axes stood when the path came to the last place that the decoder has waited for, (n_axes,)."""
        return self._link.command_position

    def _ordered(self) -> bool:
        """An order waits: what is being prepared is over."""
        return self._link.waiting_order is not Order.NONE

    def _file(self, order: StartOrder) -> Path:
        """The program file. NC blocks that came with the order become one, named after their mode."""
        if not order.text:
            path = Path(order.program)
            found = order.mode == Mode.HOMING and next(
                (folder / path for folder in map(Path, self._setup.program_paths) if (folder / path).is_file()), None
            )
            return found or path
        if self._blocks_folder is None:
            self._blocks_folder = tempfile.TemporaryDirectory(prefix="tandem-")
        file = Path(self._blocks_folder.name) / f"{Mode(order.mode).name.lower()}.nc"
        file.write_text(
            order.program.replace("\r\n", "\n").replace("\r", "\n") + "\n", encoding="latin-1", errors="replace"
        )
        return file

    def _observed(self, block: Block) -> tuple[Block]:
        if self._on_block is not None:
            self._on_block(block)
        return (block,)

    def _tell_warnings(self) -> None:
        """What the decoder and the stages have warned of since the last look, as far as not too many were told."""
        decoded = self.decoder.warnings if self.decoder is not None else []
        for which, warnings in enumerate((decoded, self._warnings)):
            for problem in warnings[self._warned[which] :]:
                if sum(self._warned) < MOST_WARNINGS:
                    self._outside.warn(problem if self._program is None else located(self._program, problem))
                self._warned[which] += 1

    def _fail(self, error: TandemError) -> None:
        self._blocks = None
        problem = error.problem if self._program is None else located(self._program, error.problem)
        place = problem.place
        file = place.file
        if self._blocks_folder is not None and file.startswith(self._blocks_folder.name):
            file = Path(file).name  # NC blocks of an order: their folder tells nobody anything
        failure = Failure(problem.entry.id, problem.text, file, place.line, place.column)
        self._link.finish(PreparationState.FAILED, failure)
