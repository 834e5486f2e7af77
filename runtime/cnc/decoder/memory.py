"""What of a channel outlives a program; everything else begins anew with the next start.

    survives the end and a reset                          begins anew
    ---------------------------------------------------   --------------------------------------------------------
    V.S variables; #100 to #199, #500 to #599             V.P, V.L, V.CYC, @P; #1 to #33
    P parameters with P-CHAN-00067, arrays too            P parameters otherwise
    macros (until #INIT MACRO TAB, manual line 26013)     file names of #FILE NAME (line 16103)
    tool table, factors of tool life                      selected tool, T
    stored zero offsets, their default (line 4633)        G functions, feed, active offsets, mirroring, rotation
    compensation registers, the common offset             what was read from a register
    intermediate points of G28 and G30
    G20, G21 of NCT programs
    synchronisation of M and H functions                  loops, modal cycles, single-step locks
    work and protection spaces, which are active          coordinate systems

The table is true because the first column is in `ChannelMemory` and the second in `Execution`, which is made per start.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from runtime.cnc.blocks import Floats, Synch
from runtime.cnc.decoder.common_variables import CommonVariables
from runtime.cnc.decoder.setup import DecoderSetup, Pairs
from runtime.cnc.decoder.surface_settings import PER_METRE, SurfaceSettings
from runtime.cnc.decoder.user_variables import Scope
from runtime.cnc.geometry.control_areas import ControlArea
from runtime.cnc.language.isg.compiler import Parameters
from runtime.cnc.tools.offset_table import COMMON, MemoryOffsets, OffsetTable, WorkOffset
from runtime.cnc.tools.table import MemoryTools, ToolTable
from runtime.cnc.tools.tool import Tool

INPUT_UNIT = -6  # beside the common variables: the group of G20 and G21, which outlive the machine
INCH_INPUT, METRIC_INPUT = 20.0, 21.0
TIMERS = 128  # counters of #TIMER (line 15524)
ZERO_OFFSET_SETS = 97  # data sets 0 (G53) to 96 (programming manual line 21179)


@dataclass(slots=True)
class ReportCount:
    """Writes to the report file since its last backup, and the number of that backup."""

    path: Path | None = None
    lines: int = 0
    backup: int = 0


class ChannelMemory:
    """Made once per start of the runtime, handed to every decoder of the channel.

    `zero_offsets` (97, n): stored data sets; `zero_enabled` the flags of G160; `macros` those of programs, in front of
    the configured ones. `tools`: the tool table of the machine; without it an empty one. `offsets`: the compensation
    registers, and the work offsets that programs and operators have set; `common_offset` (n,) is added to every data set.
    """

    def __init__(self, setup: DecoderSetup, tools: ToolTable | None = None, offsets: OffsetTable | None = None) -> None:
        self.tools = MemoryTools() if tools is None else tools
        self.offsets: OffsetTable = MemoryOffsets() if offsets is None else offsets
        self._channel, self._axes = setup.channel_number, setup.axes
        self.tool_left: Tool | None = None  # of an external management, that the last program has selected
        self.life_factors = [1.0, 1.0]  # V.TLM.TIME_FACT, V.TLM.DIST_FACT
        self.tool_writes = 0  # V.G.TOOL_LIST_INVOKE
        n = len(setup.axes)
        self.zero_offsets: Floats = np.zeros((ZERO_OFFSET_SETS, n))
        for number in range(53, 60):
            self.zero_offsets[number - 53] = setup.zero_offset(number)
        self._described: Floats = self.zero_offsets.copy()
        self.common_offset: Floats = np.zeros(n)
        self.intermediate: Floats = np.zeros(
            n
        )  # points of the last G28 or G30 of the NCT dialect, in program coordinates
        self.zero_enabled: Floats = np.ones((ZERO_OFFSET_SETS, n))
        self.zero_default = 0
        self.zero_writes = np.zeros(ZERO_OFFSET_SETS, np.int64)  # V.G.NP[j].INVOKE_COUNT
        self.static = Scope("V.S.")
        self.macros: dict[str, str] = {}
        self.macro_version = 0
        self.m_synch: dict[int, Synch] = dict(setup.m_synch)
        self.h_synch: dict[int, Synch] = dict(setup.h_synch)
        self.m_ahead: dict[int, int] = dict(setup.m_ahead)  # 0.1 µm or µs
        self.h_ahead: dict[int, int] = dict(setup.h_ahead)
        self.gears: dict[int, int] = {}  # spindle → stage that was told last
        self.gear_data: dict[int, int] = {}  # spindle → stage whose data it was given last (G112, M40…M45)
        self.spindle_m_free = setup.spindle_m_free  # V.SPDL.M_FCT_FREE
        self.timers = [0.0] * TIMERS  # ms, V.G.TIMER: what the last #TIMER READ has found
        self.report = ReportCount()
        self.couplings: dict[int, Pairs] = dict(setup.couplings)  # group -> logical numbers of slaves and masters
        self.coupled: tuple[int, ...] = ()  # groups that are active, or were when the last program was over
        self.common = CommonVariables(protected=setup.nct.protected)  # of the NCT dialect
        self.timer_begin = 0.0  # ms of the runtime at which #3001 would be 0
        self.control_areas: dict[int, ControlArea] = {}  # defined by #CONTROL AREA
        self.active_areas: list[int] = []  # in the order of their selection
        self.surface = SurfaceSettings(setup.nct.ctsurfsp * PER_METRE, setup.nct.axis)  # G96, G92 S of NCT programs
        self.skip: list[float] | None = None  # machine positions of the last G31 of NCT programs, None before the first
        self.inch: bool | None = None  # G20, G21 of NCT programs, None until one has said it
        self.came_to_end = False  # the last program was not reset
        self.parameters: Parameters | None = None  # kept over program starts if the channel is configured so
        self.parameter_arrays: Scope | None = None

    def read_offsets(self) -> None:
        """Take over what is set in the offset table: when a program starts. Raises OffsetTableError."""
        if not self.common.restored:
            kept = self.offsets.variables(self._channel)
            self.common.restore(kept)
            if INPUT_UNIT in kept:
                self.inch = kept[INPUT_UNIT] == INCH_INPUT
        for (data_set, name), offset in self.offsets.work_offsets(self._channel).items():
            if name not in self._axes or not COMMON <= data_set < ZERO_OFFSET_SETS:
                continue
            axis = self._axes.index(name)
            if offset.described == self._described_offset(data_set, axis):
                (self.common_offset if data_set == COMMON else self.zero_offsets[data_set])[axis] = offset.value

    def select_input(self, inch: bool) -> None:
        """G20, G21 of an NCT program: it is kept with the common variables."""
        if inch is not self.inch:
            self.inch = inch
            self.common.changed[INPUT_UNIT] = INCH_INPUT if inch else METRIC_INPUT

    def keep_variables(self) -> None:
        """Keep the common variables that have changed. Raises OffsetTableError; they are still to be kept then."""
        if self.common.changed:
            self.offsets.set_variables(self._channel, self.common.changed)
            self.common.changed = {}

    def set_work_offset(self, data_set: int, axis: int, value: float) -> None:
        """Set the offset of an axis, mm or degrees, in a data set or in COMMON; it is kept. Raises OffsetTableError."""
        described = self._described_offset(data_set, axis)
        self.offsets.set_work_offset(self._channel, data_set, self._axes[axis], WorkOffset(value, described))
        if data_set == COMMON:
            self.common_offset[axis] = value
        else:
            self.zero_offsets[data_set, axis] = value
            self.zero_writes[data_set] += 1

    def _described_offset(self, data_set: int, axis: int) -> float:
        return 0.0 if data_set == COMMON else float(self._described[data_set, axis])

    def start_parameters(self, setup: DecoderSetup) -> Parameters:
        """The P parameters that a program starts with: those of the one before it, or none (P-CHAN-00067)."""
        if not setup.keep_parameters:
            return Parameters()
        if self.parameters is None:
            self.parameters = Parameters()
        return self.parameters

    def start_arrays(self, setup: DecoderSetup) -> Scope:
        """The P arrays that a program starts with."""
        if self.parameter_arrays is None or not setup.keep_parameters:
            self.parameter_arrays = Scope("P", setup.limits.parameters)
        return self.parameter_arrays

    def define_macro(self, name: str, content: str) -> None:
        """Define a macro of a program."""
        self.macros[name] = content
        self.macro_version += 1

    def clear_macros(self) -> None:
        """Remove the macros of programs; configured ones remain."""
        self.macros.clear()
        self.macro_version += 1
