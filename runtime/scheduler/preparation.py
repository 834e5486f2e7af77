"""The preparation of one channel: program file → decoder → path preparation → motion queue, driven by the link's orders.

It runs ahead of the cycle as far as the queue has room. In a running machine it is a process of its own; the simulation pumps
the same object between two cycles.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from pathlib import Path

from runtime.cnc.blocks import Block
from runtime.cnc.decoder import ChannelMemory, Decoder, DecoderSetup, Program, load_program, located
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.motion_queue import MotionQueue
from runtime.cnc.path_preparation import PumpState, QueueWriter, SoftwareLimits
from runtime.cnc.preparation_link import Failure, Order, PreparationLink, PreparationState
from runtime.config.machine import Machine
from runtime.diagnostics.errors import TandemError

BATCH = 256  # records between two looks at the link


class Preparation:
    """`poll` acts on the waiting order and then moves one batch of blocks; it never blocks on the queue."""

    def __init__(
        self,
        machine: Machine,
        channel: int,
        queue: MotionQueue,
        link: PreparationLink,
        *,
        dialect: str = "isg",
        on_block: Callable[[Block], None] | None = None,
    ) -> None:
        axes = [machine.axes[machine.axis_index(name)] for name in machine.channels[channel].axes]
        self._names = machine.channels[channel].axes
        self._period = machine.cycle.period
        self._setup = DecoderSetup.from_machine(machine, channel)
        self._memory = ChannelMemory(self._setup)  # outlives programs
        self._software_limits = SoftwareLimits.of(machine, channel)
        self._axis_limits = AxisLimits.of(axes)
        self._queue = queue
        self._link = link
        self._dialect = dialect
        self._on_block = on_block
        self._blocks: Iterator[Block] | None = None
        self._writer: QueueWriter | None = None
        self._program: Program | None = None
        self.decoder: Decoder | None = None  # of the last program, for its parameters

    def poll(self) -> PumpState:
        """FULL: waits for the cycle. FINISHED: nothing to do. MORE: call again."""
        order = self._link.waiting_order
        if order is not Order.NONE:
            self._blocks = None
            if order is Order.START:
                self._begin()
            else:
                self._link.finish(PreparationState.IDLE)
            self._link.answer()
        if self._blocks is None or self._writer is None:
            return PumpState.FINISHED
        try:
            state = self._writer.pump(self._blocks, BATCH)
        except TandemError as error:
            self._fail(error)
            return PumpState.FINISHED
        if state is PumpState.FINISHED:
            self._blocks = None
            if self._link.waiting_order is Order.NONE:
                self._link.finish(PreparationState.FINISHED)
        return state

    def _begin(self) -> None:
        order = self._link.read_start()
        if self._program is not None:
            self._program.close()
            self._program = None
        try:
            program = self._program = load_program(Path(order.program), self._setup, self._dialect)
        except TandemError as error:
            self._fail(error)
            return
        self.decoder = Decoder(
            program,
            self._setup,
            start=order.start,
            memory=self._memory,
            skip_levels=lambda: order.skip_levels,
            interrupted=lambda: self._link.waiting_order is not Order.NONE,
        )
        blocks = self._software_limits(self.decoder.blocks())
        if self._on_block is not None:
            blocks = itertools.chain.from_iterable(map(self._observed, blocks))
        self._blocks = blocks
        self._writer = QueueWriter(self._queue, self._axis_limits, self._period, self._names)

    def _observed(self, block: Block) -> tuple[Block]:
        if self._on_block is not None:
            self._on_block(block)
        return (block,)

    def _fail(self, error: TandemError) -> None:
        self._blocks = None
        problem = error.problem if self._program is None else located(self._program, error.problem)
        place = problem.place
        failure = Failure(problem.entry.id, problem.text, place.file, place.line, place.column)
        self._link.finish(PreparationState.FAILED, failure)
