"""The state of a running program: what G functions, statements and variables read and change.

Handlers get this object. They emit blocks, change the modal state and the coordinates, and ask the outside; the decoder drives
it from block to block.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING, Any

import numpy as np

from runtime.cnc.blocks import Block, BlockEnd, Dwell, ExactStop, Floats, LimitBehaviour, Polyline, Source, StepEnd
from runtime.cnc.decoder.contour_lines import ContourLines
from runtime.cnc.decoder.control_areas import OpenArea
from runtime.cnc.decoder.coordinates import Coordinates, Rotation
from runtime.cnc.decoder.coupling_state import ActiveCouplings
from runtime.cnc.decoder.environment import DecoderEnvironment
from runtime.cnc.decoder.external import ExternalVariables
from runtime.cnc.decoder.feed_group import FeedGroup
from runtime.cnc.decoder.feed_word import FeedChange, enter_feed
from runtime.cnc.decoder.frames import Frame
from runtime.cnc.decoder.isg.registry import syntaxes
from runtime.cnc.decoder.measuring_state import MeasuringState
from runtime.cnc.decoder.memory import ChannelMemory
from runtime.cnc.decoder.modal import INCH, PLANE_AXES, FeedMode, ModalState, Motion, Plane
from runtime.cnc.decoder.modulo import ModuloAxes
from runtime.cnc.decoder.outside import Outside
from runtime.cnc.decoder.own_motions import OwnMotions
from runtime.cnc.decoder.radius_compensation import Compensation
from runtime.cnc.decoder.report_file import Backups
from runtime.cnc.decoder.setup import DecoderSetup
from runtime.cnc.decoder.smoothing import Smoothing
from runtime.cnc.decoder.spindle_sections import SpindleSections
from runtime.cnc.decoder.spindles import Spindles
from runtime.cnc.decoder.steps import CONTROLS, ENDS_STEP, Steps
from runtime.cnc.decoder.tooling import Tooling
from runtime.cnc.decoder.turning import Turning
from runtime.cnc.decoder.user_variables import Scope
from runtime.cnc.dynamic_settings import CornerDeceleration
from runtime.cnc.language.errors import CalculationError, ProgramError
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock, Values, compile_block
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.index import BlockText, Unit
from runtime.cnc.language.isg.macros import MACRO_DEPTH
from runtime.cnc.language.isg.parser import BlockParser, block_parser
from runtime.cnc.language.isg.syntax import Group, Vocabulary
from runtime.cnc.language.isg.words import ParsedBlock
from runtime.cnc.tools.offset_table import OffsetTableError
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import ErrorEntry, Problem

if TYPE_CHECKING:
    from runtime.cnc.decoder.additions import WaitingLine
    from runtime.cnc.decoder.levels import Levels
    from runtime.cnc.decoder.library import Library

COMPILED_BLOCKS = 20_000  # kept at once, some 3 kB each
RUN = 256  # straight moves that are handed over together
_QUOTED = re.compile(r'\\?"((?:\\\\.|[^"\\])*)\\?"')

_LEADING_NUMBER = re.compile(r"[ \t]*(?:/[ \t]*\d*)?[ \t]*[Nn][ \t]*(\d+)(?![\d.*/+-])")

_vocabularies: dict[tuple[bool, bool], Vocabulary] = {}


def vocabulary(setup: DecoderSetup) -> Vocabulary:
    """The words of the dialect as this channel has them (P-CHAN-00116: G90 and G91 mixed in a block; P-CHAN-00148: with an axis
    several times)."""
    mixed = setup.mixed_dimension
    key = mixed, mixed and setup.repeated_axes
    if key not in _vocabularies:
        repeatable = frozenset({Group.DIMENSION}) if mixed else frozenset()
        _vocabularies[key] = Vocabulary(*syntaxes(), repeatable, key[1])
    return _vocabularies[key]


def check_continued(parsed: ParsedBlock, text: BlockText) -> None:
    """Raises LineError for a # statement that goes on in the next line without being allowed to (manual line 1294)."""
    if len(text.lines) > 1 and parsed.statement is not None:
        syntax = parsed.statement.syntax
        if syntax.prefix and not syntax.continued:
            raise LineError(catalogue.CONTINUATION, text.pieces[1])


class Execution:
    """One run of one program. Fields are named after what they are; see the classes they hold."""

    levels: Levels  # set by whoever executes

    def __init__(
        self,
        setup: DecoderSetup,
        memory: ChannelMemory,
        outside: Outside,
        library: Library,
        start: Floats,
        skip_levels: Callable[[], int],
    ) -> None:
        self.setup = setup
        self.memory = memory
        self.keep_cycle_changes = setup.keep_cycle_changes  # V.G.CYCLE_CHANGES_MODAL
        self.outside = outside
        self.library = library
        self.skip_levels = skip_levels
        self.modal = ModalState()
        self.modal.inch = setup.inch
        if setup.feed > 0:
            self.modal.feed = setup.feed
        self.dynamics = setup.dynamics
        self.corner_parameters: CornerDeceleration | None = None  # of #CORNER PARAM
        self.feed_group: FeedGroup = setup.feed_group
        self.smoothing = Smoothing.of(
            setup.poly_jerk, setup.hsc_start, any(given is not None and given.enable for given in setup.filters)
        )
        self.coordinates = Coordinates.at(start)
        self.systems = setup.systems()
        self.direction_limit: tuple[float, ...] = (0.0, 0.0, 0.0)  # of #GET WCS POSLIMIT, programmed coordinates
        self.open_area: OpenArea | None = None  # between #CONTROL AREA BEGIN and END
        self.parameters = memory.start_parameters(setup)
        self.parameter_arrays = memory.start_arrays(setup)
        self.program_scope = Scope("V.P.", setup.limits.program_variables)
        self.frames: list[Frame] = []
        self.out: list[Block] = []
        self.warnings: list[Problem] = []
        self.tools = Tooling(self)
        self.declaring = False  # between #VAR and #ENDVAR
        self.again: str | None = None  # why the block has to be executed once more, after the outside had its turn
        self.waiting: Any = None  # what a block that is executed again keeps
        self.steps = Steps()
        self.pending_transfer: dict[int, float | str] | None = None  # values of a call that are being computed
        self.entry = 0  # of the block in work
        self.source = Source("", 0)
        self.block: CompiledBlock | None = None
        self.values: Values = ()
        self.axis_words: dict[int, float] = {}  # of the block in work, as programmed
        self.letters: dict[int, float] = {}  # I 0, J 1, K 2 of the block in work
        self.additions: dict[str, float] = {}  # #ANG … of the block in work
        self.incremental_words: dict[int, bool] = {}  # where G90 and G91 are mixed in the block
        self.end_feed: float | None = None  # E of the block in work, mm/min
        self.feed_change: tuple[FeedChange, float] | None = None  # G193, G293: the feed to begin with, mm/min
        self.feed_taken = False  # F of the block is entered
        self.exact_stop = 0  # column of G60 in the block in work, 0 without
        self.override_off = False  # G166 in the block in work
        self.brake_in_front = False  # G09 in the block in work
        self.radius_taken = False  # R was the argument of a function
        self.configured_limits = tuple(
            (-math.inf if low is None else low, math.inf if high is None else high)
            for low, high in setup.position_limits or ((None, None),) * len(setup.axes)
        )
        self.soft_limits = list(self.configured_limits)
        self.limit_behaviour = [LimitBehaviour.ERROR] * len(setup.axes)
        self.last_limits: dict[int, tuple[float, float]] = {}  # of POS_LIMIT ON, mm or degrees
        self.independent = OwnMotions()
        probes = list(setup.measuring.probes) or [None] * len(setup.axes)
        self.measuring = MeasuringState(setup.measuring.type, probes)
        self.coupling = ActiveCouplings()
        self.modulo = ModuloAxes.of(setup.modulo_axes, always_shortest=setup.always_shortest)
        self.path_start: list[float] | None = None  # where the path stands, if the decoder counts from somewhere else
        self.manual_axes: set[int] = set()  # moved by hand beside the path (G201)
        self.manual_offsets = [0.0] * len(setup.axes)  # V.A.MANUAL_OFFSETS, mm or degrees
        self.line_waits = (
            False  # a contour line waits for the next one; nothing is handed over meanwhile (see additions)
        )
        self.fast = (  # straight moves need nothing but gain, shift and feed: see modal_changed
            not setup.exact_stop_after_rapid and self.feed_group.plain and setup.single_step <= 0
        )
        self._code: dict[int, dict[int, CompiledBlock]] = {}
        self.axes_taken = False  # the axis words were arguments of a function
        self.block_number = 0  # last N
        self.job_ids: set[int] = set()  # of axis jobs, programmed so far
        self.block_waits_for_jobs = False
        self.spindles = Spindles(setup.spindles, setup.main_spindle, setup.main_name, setup.start_m)
        self.sections = SpindleSections()  # in which path and spindle move together
        self.turning = Turning()
        self.speed_argument = 0  # G function of the block in work whose argument S is, 0 if it is a speed
        self.dwell_revolutions = 0.0  # of the last G04 S
        self.circle: tuple[list[float], list[float], float] = ([0.0] * 3, [0.0, 0.0], 0.0)  # V.G.I/J/K, V.G.MERR, V.G.R
        self.last_rotation: Rotation | None = None  # what #ROTATION ON goes on from
        self.contour_lines = ContourLines()
        self.compensation = Compensation()
        self.waiting_line: WaitingLine | None = None  # what `line_waits` tells of
        self.file_names: dict[str, str] = {}  # of #FILE NAME, by function: MSG, M6, D, G80 …
        self.report_backups = Backups()
        self.found_file: Path | None = None  # of the last #FILE EXIST
        self.random: Random | None = None  # of V.G.RANDOM, made at its first access
        self.stands = False  # the block in work has an exact stop
        self._run: list[list[float]] = []
        self._run_feeds: list[float] = []
        self._run_lines: list[int] = []
        self._run_numbers: list[int] = []
        self._run_shape: tuple[list[float], list[float], Plane] = ([], [], Plane.XY)
        self._run_program = ""
        self.vocabulary = vocabulary(setup)
        self.external = ExternalVariables(setup.external, outside, self)
        self.environment = DecoderEnvironment(self)
        self.parser: BlockParser = block_parser(setup.addresses, self.vocabulary)

    def read_offsets(self) -> None:
        """At program start: what is kept in the offset table. ProgramError if it cannot be read."""
        try:
            self.memory.read_offsets()
        except OffsetTableError as error:
            raise ProgramError(error.problem.entry, self.unit.place(0), **error.problem.values) from None

    # ------------------------------------------------------------------ blocks out

    @property
    def call_shown(self) -> Source | None:
        """The call that stands for all blocks of the level in work, None where they are shown themselves."""
        return self.frames[-1].shown if self.frames else None

    @property
    def running(self) -> bool:
        """A level is in work: the program is not over."""
        return bool(self.frames)

    def emit(self, block: Block) -> None:
        """Hand over a block, behind the moves that were collected before it."""
        if self._run_feeds:
            self.flush_run()
        if self.compensation.watches:
            self.compensation.note(self, block)
        self.out.append(block)

    def block_end(self) -> None:
        """The end of a block with motion, if single block stops behind it. Where the path stands already at an exact stop, a gate
        of its own stops it."""
        stands, self.stands = self.stands, False
        if self.call_shown is None and self.steps.ends(self.source.n):
            self.emit(BlockEnd(self.source))
            if stands:
                self.emit(StepEnd(self.source))

    def step_end(self, since: int) -> None:
        """The end of a block: a step of its own, if it has no motion and is one by P-CHAN-00015. What it has emitted stands in
        `out` from `since` on."""
        emitted = self.out[since:]
        if not self.running or self.call_shown is not None:
            return
        dwells = any(isinstance(block, Dwell) for block in emitted)  # the end of such a block stops nobody who stands
        if not dwells and any(isinstance(block, ENDS_STEP) for block in emitted):
            return
        relevant = self.setup.single_step > 0 or any(isinstance(block, CONTROLS) for block in emitted)
        if relevant and self.steps.ends(self.source.n):
            self.emit(StepEnd(self.source))

    def stop_exactly(self, motion: bool) -> None:
        """The end of what the block moves: the path stops here with G60 or G360, or behind G00 where P-CHAN-00235 says so.
        LineError for G60 without motion."""
        if self.exact_stop and not motion:
            raise LineError(catalogue.EXACT_STOP_ALONE, self.exact_stop)
        rapid = self.setup.exact_stop_after_rapid and self.modal.motion is Motion.RAPID
        if motion and (self.exact_stop or self.modal.exact_stop or rapid):
            self.emit(ExactStop(self.source))
            self.stands = True

    def stepwise(self, run: Polyline) -> Iterable[Block]:
        """A run of moves as it is, or one by one where not every block is a step."""
        shown = self.call_shown
        return (run,) if shown is None and self.steps.everywhere else self.steps.apart(run, shown)

    def straight(self, end: list[float], feed: float, line: int, number: int) -> None:
        """A straight move without any addition: collected, and handed over with others as a polyline."""
        coordinates = self.coordinates
        if not self._run_feeds:
            self._run = [coordinates.position]
            self._run_shape = (coordinates.gain, coordinates.shift, self.modal.plane)
            self._run_program = self.source.program
        elif (
            self._run_shape[1] is not coordinates.shift
            or self._run_shape[2] is not self.modal.plane
            or self._run_program is not self.source.program
        ):
            self.flush_run()
            self.straight(end, feed, line, number)
            return
        self._run.append(end)
        self._run_feeds.append(feed)
        self._run_lines.append(line)
        self._run_numbers.append(number)
        coordinates.moved(end)
        if len(self._run_feeds) >= RUN:
            self.flush_run()

    @property
    def collected(self) -> int:
        """Moves that wait to be handed over."""
        return len(self._run_feeds)

    def flush_run(self) -> None:
        """Hand over what was collected."""
        if not self._run_feeds:
            return
        gain, shift, plane = self._run_shape
        run = Polyline(
            self._run_program,
            np.array(self._run),
            np.array(self._run_feeds),
            np.array(self._run_lines, dtype=np.int64),
            np.array(self._run_numbers, dtype=np.int64),
            np.array(shift),
            None if all(g == 1.0 for g in gain) else np.array(gain),
            PLANE_AXES[plane],
        )
        self.out.extend(self.stepwise(run))
        self._run, self._run_feeds, self._run_lines, self._run_numbers = [], [], [], []

    # ------------------------------------------------------------------ compiled blocks

    def compiled(self, unit: Unit, entry: int) -> CompiledBlock:
        """A block, compiled when it is needed for the first time; ProgramError if it is faulty.

        One with quoted texts is compiled anew when macros have changed.
        """
        code = self._code.get(id(unit))
        if code is None:
            code = self._code[id(unit)] = {}
        block = code.get(entry)
        if block is None or block.macro_version not in (-1, self.memory.macro_version):
            block = self.compile(unit, unit.block_text(entry))
            if len(code) >= COMPILED_BLOCKS:
                code.clear()
            code[entry] = block
        return block

    def compile(self, unit: Unit, text: BlockText) -> CompiledBlock:
        """Compile a block's text; ProgramError if it is faulty."""
        try:
            parsed = self.parser.parse(text.text, self.environment)
            check_continued(parsed, text)
            version = self.memory.macro_version if '"' in text.text else -1
            return compile_block(parsed, text, self.environment.namespace, self.vocabulary, version)
        except LineError as error:
            line, column, shown = text.place(error.column)
            raise ProgramError(error.entry, unit.place(line, column, shown), **error.values) from None

    def modal_changed(self) -> None:
        """To be called after changes of feed mode, feed group, rotation, exact stop, `line_waits`, `path_start` or own motions:
        whether the fast road may be taken."""
        self.fast = (
            not self.setup.exact_stop_after_rapid
            and self.setup.single_step <= 0
            and self.feed_group.plain
            and self.modal.feed_mode is FeedMode.PER_MINUTE
            and self.coordinates.plain
            and not self.line_waits
            and self.path_start is None
            and not self.modal.exact_stop
            and not self.compensation.watches
            and not self.independent.running
            and not self.coupling.slaves
            and not self.sections.watches
            and not self.turning.watches
            and not self.modal.diameter
            and self.open_area is None
        )

    def take_path_start(self) -> list[float]:
        """Where a straight move starts: the position, or where the path stands behind #CHANNEL INIT [ACTPOS]."""
        if self.path_start is None:
            return self.coordinates.position
        start, self.path_start = self.path_start, None
        self.modal_changed()
        return start

    def expect_path_start(self, column: int) -> None:
        """LineError if the path does not stand where the decoder counts from: no arc can start there."""
        if self.path_start is not None:
            raise LineError(catalogue.ACTUAL_FIRST, column)

    # ------------------------------------------------------------------ the block in work

    def source_in_work(self) -> Source:
        """Where the block in work stands; for what is put out while its values are computed, before its N word is."""
        if self.block is None:
            return self.source
        match = _LEADING_NUMBER.match(self.block.text)
        return Source(self.unit.name, self.block.source.line, int(match.group(1)) if match else None)

    def place(self, column: int) -> tuple[int, int, str]:
        """Line, column and text of a column of the block in work."""
        return self.block.source.place(column) if self.block is not None else (self.source.line, column, "")

    @property
    def frame(self) -> Frame:
        """The program level in work."""
        return self.frames[-1]

    @property
    def unit(self) -> Unit:
        return self.frames[-1].unit

    def repeat(self, reason: str) -> None:
        """Execute the block in work once more later: it waits for the outside. Without a machine nobody waits."""
        if not self.outside.waits_in_vain():
            self.again = reason

    def warn(self, entry: ErrorEntry, column: int = 1, **values: object) -> None:
        """A warning at a column of the block in work; the same one at the same place is told once."""
        place = self.unit.place(*self.place(column))
        if not any(known.place == place and known.entry is entry for known in self.warnings):
            self.warnings.append(Problem(entry, values, place))

    def length(self, value: float) -> float:
        """A programmed length in mm (inch converted)."""
        return value * INCH if self.modal.inch else value

    def axis_value(self, axis: int, value: float) -> float:
        """A programmed axis value in mm or degrees."""
        if not self.setup.linear[axis]:
            return value * self.setup.rotary_unit
        return value * INCH if self.modal.inch else value

    def turn_directions(self, words: dict[int, float]) -> dict[int, int] | None:
        """Of axes that turn without end and get an absolute word (mm or degrees): 1, -1 or 0 for the shorter way. None: as the
        signs of the block say."""
        return None

    def shown(self, axis: int, value: float) -> float:
        """A value of an axis as the program sees it: inch where inch is selected, gradians where they are configured."""
        if not self.setup.linear[axis]:
            return value / self.setup.rotary_unit
        return value / INCH if self.modal.inch else value

    def counted(self, axis: int, position: float) -> float:
        """A machine position of an axis as the program counts it: without the turns that it leaves out."""
        return self.modulo.shown(axis, position - self.coordinates.turns[axis])

    def place_of(self, axis: int) -> float:
        """Where an axis stands behind the last motion, as the program counts it; a slave is where its master has led it."""
        return self.counted(axis, self.coupling.place(axis, self.coordinates.machine()))

    def place_in_system(self, axis: int) -> float:
        """The same in the active coordinate system."""
        if axis in self.coupling.slaves:
            return self.place_of(axis)
        return self.counted(axis, self.coordinates.in_system(axis))

    def shown_length(self, value: float) -> float:
        """A length as the program sees it."""
        return value / INCH if self.modal.inch else value

    def take_feed(self) -> None:
        """Enter the F word of the block in work now; it is not entered a second time."""
        block = self.block
        assert block is not None
        if block.feed >= 0 and not self.feed_taken:
            self.feed_taken = True
            enter_feed(self, block, self.values[block.feed])

    def arguments(self, number: int, column: int) -> dict[int, float]:
        """The axis words of the block as arguments of a G function, in mm or degrees; at least one."""
        if not self.axis_words:
            raise LineError(catalogue.AXIS_ARGUMENT, column, number=number)
        self.axes_taken = True
        return {axis: self.axis_value(axis, value) for axis, value in self.axis_words.items()}

    def raw_arguments(self, number: int, column: int) -> dict[int, float]:
        """The axis words of the block as plain numbers."""
        if not self.axis_words:
            raise LineError(catalogue.AXIS_ARGUMENT, column, number=number)
        self.axes_taken = True
        return dict(self.axis_words)

    # ------------------------------------------------------------------ variables of levels

    def local_scope(self, name: str) -> Scope:
        """The innermost level that has this V.L variable; the current one if none has."""
        return next((frame.local for frame in reversed(self.frames) if name in frame.local), self.frame.local)

    def cycle_scope(self, name: str) -> Scope:
        """The innermost level that has this V.CYC variable; the current one if none has."""
        return next((frame.cycle for frame in reversed(self.frames) if name in frame.cycle), self.frame.cycle)

    def own_scope(self, kind: str) -> Scope:
        """The scope in which the level in work makes its variables of a class: P, S, L or CYC."""
        if kind == "P":
            return self.program_scope
        if kind == "S":
            return self.memory.static
        return self.frame.local if kind == "L" else self.frame.cycle

    def check_cycle_memory(self, scope: Scope, name: str) -> None:
        """A V.CYC variable was made in `scope`: CalculationError, and it goes again, if all of them take too much."""
        limit = self.setup.limits.cycle_memory
        if sum(frame.cycle.bytes for frame in self.frames) > limit:
            scope.delete(name)
            raise CalculationError(catalogue.CYCLE_MEMORY, f"V.CYC.{name}", limit=limit)

    def _transfer(self, number: float) -> tuple[dict[int, float | str], int]:
        index = round_half_up(number)
        name = f"@P{index}"
        transfer = next((frame.transfer for frame in reversed(self.frames) if frame.transfer is not None), None)
        if transfer is None:
            raise CalculationError(catalogue.TRANSFER_OUTSIDE, name)
        if not 1 <= index <= 200:
            raise CalculationError(catalogue.ARRAY_INDEX, "@P", value=number, last=200)
        return transfer, index

    def read_transfer(self, number: float) -> float | str:
        """A transfer parameter of the cycle; one that was not given becomes 0, or is an error (P-CHAN-00463)."""
        pending = self.pending_transfer
        if pending is not None and round_half_up(number) in pending:
            return pending[round_half_up(number)]
        transfer, index = self._transfer(number)
        if index not in transfer:
            if not self.setup.create_transfer:
                raise CalculationError(catalogue.TRANSFER_MISSING, f"@P{index}")
            transfer[index] = 0.0
        return transfer[index]

    def write_transfer(self, value: float | str, number: float) -> None:
        transfer, index = self._transfer(number)
        transfer[index] = value

    def begin_transfer(self) -> None:
        """The values of a G80 call are computed one after the other; those that are done can be read as @P already."""
        self.pending_transfer = {}

    def give_transfer(self, number: int, value: float | str) -> None:
        """A value of the call is known."""
        assert self.pending_transfer is not None
        self.pending_transfer[number] = value

    def has_transfer(self, number: float) -> float:
        try:
            transfer, index = self._transfer(number)
        except CalculationError:
            return 0.0
        return float(index in transfer)

    # ------------------------------------------------------------------ macros

    def expand(self, content: str, depth: int = 0) -> str:
        """A macro's content with the macros in it replaced by their text, not evaluated."""
        if depth > MACRO_DEPTH:
            raise CalculationError(catalogue.MACRO_DEPTH, content, name=content[:20], limit=MACRO_DEPTH)

        def inner(match: re.Match[str]) -> str:
            found = self.environment.macro(match.group(1))
            return match.group() if found is None else self.expand(found, depth + 1)

        return _QUOTED.sub(inner, content)
