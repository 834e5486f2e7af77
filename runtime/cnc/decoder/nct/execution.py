"""The state of a running NCT program: the shared `Execution` of the decoder, and what this dialect has beside it.

What handlers use of the shared part: `modal`, `coordinates`, `spindles`, `tools`, `compensation`, `memory`, `outside`, `setup`,
`emit`, `warn`, `repeat` (execute the block in work once more later), `axis_value` and `length` (inch → mm). What they use of
this one: `words`, `axes`, `levels`, `active`, `stack`, `variables`, `macros`, `cycle`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from runtime.cnc.blocks import Corner, Floats, Source, Suppression
from runtime.cnc.decoder.block_functions import Functions
from runtime.cnc.decoder.execution import COMPILED_BLOCKS, Execution
from runtime.cnc.decoder.library import Library as IsgLibrary
from runtime.cnc.decoder.memory import ChannelMemory
from runtime.cnc.decoder.modal import INCH
from runtime.cnc.decoder.nct.coordinates import NumberedCoordinates
from runtime.cnc.decoder.nct.cycle_data import CycleData
from runtime.cnc.decoder.nct.flow import Flow
from runtime.cnc.decoder.nct.frames import Frame
from runtime.cnc.decoder.nct.macros import MacroCalls, UserCodes
from runtime.cnc.decoder.nct.names import namespace
from runtime.cnc.decoder.nct.registry import G_CODES, GCall, GCode, Group, find_variable
from runtime.cnc.decoder.nct.surface_speed import SurfaceSpeed
from runtime.cnc.decoder.nct.used_registers import UsedRegisters
from runtime.cnc.decoder.nct.variables import Variables
from runtime.cnc.decoder.nct.vector_selection import VectorSelection
from runtime.cnc.decoder.nct.words import BlockWords
from runtime.cnc.decoder.outside import Outside
from runtime.cnc.decoder.setup import DecoderSetup
from runtime.cnc.language.errors import CalculationError, LineError, ProgramError
from runtime.cnc.language.nct.addresses import COORDINATES, rounded
from runtime.cnc.language.nct.compiler import CompiledBlock, compile_block
from runtime.cnc.language.nct.functions import Value
from runtime.cnc.language.nct.parser import block_parser
from runtime.cnc.language.nct.program_file import BlockText, Unit
from runtime.cnc.tools.offset_table import OffsetTableError
from runtime.diagnostics.catalogue import nct as catalogue
from runtime.diagnostics.catalogue import nct_macros as macros
from runtime.diagnostics.errors import ErrorEntry, Problem

if TYPE_CHECKING:
    from runtime.cnc.decoder.nct.levels import Levels
    from runtime.cnc.decoder.nct.library import Library

NOTHING = BlockWords((), {})
NO_CYCLE, TO_INITIAL = 800, 980  # G80, G98


@dataclass(slots=True)
class Suppressed:
    """What #3004 and G63 have taken away: the operator's stop and override, the exact stops of the program."""

    feed_stop: bool = False
    override: bool = False
    exact_stop: bool = False
    tapping: bool = False  # G63


class OutOfStepError(Exception):
    """A block reads something of the interpolator: the path has to come to this block first, then it is executed anew."""


class NctExecution(Execution):
    """One run of one NCT program."""

    levels: Levels  # type: ignore[assignment]  # of this dialect; set by whoever executes
    coordinates: NumberedCoordinates

    def __init__(
        self,
        setup: DecoderSetup,
        memory: ChannelMemory,
        outside: Outside,
        library: Library,
        start: Floats,
        skip_levels: Callable[[], int],
    ) -> None:
        self.nct = setup.nct
        if self.nct.poscheck and not setup.exact_stop_after_rapid:
            setup = replace(setup, exact_stop_after_rapid=True)
        super().__init__(setup, memory, outside, IsgLibrary(setup.addresses, ()), start, skip_levels)
        self.modal.feed = self.nct.feed * 60.0 or None
        self.programs = library
        self.axis_of = {
            name: index for index, name in enumerate(setup.axes) if name in COORDINATES and name not in self.nct.miscel
        }
        self.stack: list[Frame] = []
        self.words: BlockWords = NOTHING  # of the block in work
        self.work: CompiledBlock | None = None  # the block in work
        self.active: dict[Group, int] = {}  # tenths of the code of each modal group that holds
        self.cycle = CycleData()
        self.block_functions = Functions(self.source)  # M, S and T of the block in work
        self.suppressed = Suppressed()
        self.macros = MacroCalls(self, UserCodes.of(setup.nct))
        self.flow = Flow(self)
        self.variables = Variables(memory.common, lambda: self.stack[-1].locals, self.read_system, self.write_system)
        self.in_step = False  # the path has come to the block in work
        self.polar_angle: float | None = None  # of the last point that was programmed by one, degrees
        self.surface = SurfaceSpeed(memory.surface)
        self.speed_taken = False  # S of the block in work is no speed: G92
        self.stops_here = False  # G09 in the block in work
        self.corner: Corner | None = None  # of ,C or ,R of the block in work
        self.sequence_number = 0  # the last N word
        self.number_before = 0  # that of the block before
        self.length_before: tuple[float, ...] = (0.0,) * len(setup.axes)  # tool lengths before the block in work, mm
        self.outputs: int | None = None  # of the interface, as this program has put them out last
        self.last_words: dict[str, float] = {}  # values of the modal words, as programmed
        self.assigned = 0  # assignments of the block in work that are done
        self.actions: list[Callable[[], None]] = []  # of the block in work, when everything else is done
        self.namespace: dict[str, Any] = namespace(self)
        self._compiled: dict[tuple[int, int], CompiledBlock] = {}
        self.coordinates = NumberedCoordinates.at(start)
        self.compensation = self.vectors = VectorSelection(setup.nct)
        self.used = UsedRegisters()

    # ------------------------------------------------------------------ words of the block in work

    def axes(self) -> dict[int, float]:
        """The axis words of the block in mm or degrees, as arguments of a code: they move nothing afterwards."""
        self.words.take(self.axis_of)
        self.axes_taken = True
        return {axis: self.axis_value(axis, value) for axis, value in self.axis_words.items()}

    def mover(self) -> GCode:
        """The code that moves the axes: that of the drilling cycles if one is active, else that of the motions."""
        cycle = self.active.get(Group.CYCLE, -1)
        if cycle in G_CODES and G_CODES[cycle].moves is not None:
            return G_CODES[cycle]
        return G_CODES[self.active[Group.MOTION]]

    def select(self, tenths: int) -> None:
        """A modal code holds from now on; its handler is called without a block (program start, reset)."""
        code = G_CODES[tenths]
        self.active[code.group] = tenths
        code.handler(self, GCall(tenths, 1, modal=True))

    def expect_in_step(self) -> None:
        """Before something of the interpolator is read."""
        if not self.in_step:
            raise OutOfStepError

    def group_of(self, tenths: int) -> int:
        """The number of the group of a G code, 0 if it is not modal or not known."""
        code = G_CODES.get(tenths)
        return 0 if code is None else code.group.value

    def stop_exactly(self, motion: bool) -> None:
        if not self.suppressed.exact_stop:
            super().stop_exactly(motion)

    def tell_suppression(self, threads: bool = False) -> None:
        """From this place of the path on: what holds of stop and override; `threads`: within a thread of a cycle."""
        now = self.suppressed
        all_of_it = threads or now.tapping
        self.emit(Suppression(self.source, all_of_it or now.feed_stop, all_of_it or now.override))

    def end_of_cycle(self) -> None:
        """G80, or a path condition: what the drilling cycles have stored is deleted, and G98 holds again."""
        if self.cycle.mode:
            self.active[Group.CYCLE] = NO_CYCLE
            self.active[Group.RETURN_LEVEL] = TO_INITIAL
            self.cycle.clear()

    # ------------------------------------------------------------------ system variables

    def read_system(self, number: int) -> Value:
        """A system variable by its number. CalculationError if there is none, or none that can be read."""
        found = find_variable(number)
        if found is None or found.read is None:
            entry = macros.VARIABLE_UNKNOWN if found is None else macros.VARIABLE_WRITE_ONLY
            raise CalculationError(entry, f"#{number}", number=number)
        if found.in_step:
            self.expect_in_step()
        return found.read(self, number)

    def write_system(self, number: int, value: Value) -> None:
        """Give a system variable a value. CalculationError if there is none, or none that can be written."""
        found = find_variable(number)
        if found is None or found.write is None:
            entry = macros.VARIABLE_UNKNOWN if found is None else macros.VARIABLE_READ_ONLY
            raise CalculationError(entry, f"#{number}", number=number)
        found.write(self, number, value)

    # ------------------------------------------------------------------ values in the units of the program

    def axis_value(self, axis: int, value: float) -> float:
        """A programmed axis value in mm or degrees, rounded to the input increment (line 1658)."""
        decimals = self.nct.decimals
        if self.modal.inch and self.setup.linear[axis]:
            return rounded(value, decimals + 1) * INCH
        return rounded(value, decimals)

    def length(self, value: float) -> float:
        """A programmed length in mm, rounded to the input increment."""
        decimals = self.nct.decimals
        return rounded(value, decimals + 1) * INCH if self.modal.inch else rounded(value, decimals)

    def angle(self, value: float) -> float:
        """A programmed angle in degrees, rounded to the input increment."""
        return rounded(value, self.nct.decimals)

    # ------------------------------------------------------------------ compiled blocks

    def compiled_block(self, unit: Unit, text: BlockText) -> CompiledBlock:
        """A block, compiled when it is needed for the first time; ProgramError if it is faulty."""
        key = (id(unit), text.offset)
        block = self._compiled.get(key)
        if block is None:
            try:
                block = compile_block(block_parser().parse(text.text), text, self.namespace)
            except LineError as error:
                line, column, shown = text.place(error.column)
                raise ProgramError(error.entry, unit.place(line, column, shown), **error.values) from None
            if len(self._compiled) >= COMPILED_BLOCKS:
                self._compiled.clear()
            self._compiled[key] = block
        return block

    # ------------------------------------------------------------------ what the shared part asks for

    def turn_directions(self, words: dict[int, float]) -> dict[int, int] | None:
        """The sign of an absolute position is the direction in which an axis turns, 0 is positive; with ABSHORT it goes the
        shorter way. With RELROUND an incremental way is less than a turn (manual lines 1741-1836)."""
        directions = {}
        parameters = self.setup.nct
        for axis in words.keys() & self.modulo.ranges:
            name = self.setup.axes[axis]
            if self.incremental_words.get(axis, self.modal.incremental):
                if name in parameters.relround:
                    words[axis] = math.fmod(words[axis], self.modulo.size(axis))
            elif name in parameters.abshort:
                directions[axis] = 0
            else:
                directions[axis] = -1 if self.words.signed(name) or words[axis] < 0.0 else 1
        return directions

    def read_offsets(self) -> None:
        """At program start: work offsets as they are kept, the common one among them. ProgramError if they cannot be read."""
        try:
            self.memory.read_offsets()
        except OffsetTableError as error:
            raise ProgramError(error.problem.entry, self.level.unit.place(0), **error.problem.values) from None
        self.coordinates.common = [float(offset) for offset in self.memory.common_offset]

    @property
    def level(self) -> Frame:
        """The program level in work."""
        return self.stack[-1]

    @property
    def call_shown(self) -> Source | None:
        return self.stack[-1].shown if self.stack else None

    @property
    def running(self) -> bool:
        return bool(self.stack)

    def place(self, column: int) -> tuple[int, int, str]:
        return self.work.source.place(column) if self.work is not None else (self.source.line, column, "")

    def source_in_work(self) -> Source:
        return self.source

    def warn(self, entry: ErrorEntry, column: int = 1, **values: object) -> None:
        place = self.stack[-1].unit.place(*self.place(column))
        if not any(known.place == place and known.entry is entry for known in self.warnings):
            self.warnings.append(Problem(entry, values, place))

    def take_feed(self) -> None:
        """The F word is entered with the modal words of its block."""

    def expect_axis(self, address: str, column: int) -> int:
        """The channel index of an axis address; LineError if the channel has no such axis."""
        index = self.axis_of.get(address)
        if index is None:
            raise LineError(catalogue.AXIS_MISSING, column, address=address, axes=", ".join(self.setup.axes))
        return index
