"""What the decoder needs to know of the channel, from the machine description."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from runtime.cnc.blocks import Floats, Spline, Synch
from runtime.cnc.decoder.feed_group import MAIN_GROUP, FeedGroup
from runtime.cnc.decoder.measuring_setup import MeasuringChannel
from runtime.cnc.decoder.smoothing import HSC_DEFAULT, hsc_start
from runtime.cnc.decoder.system_state import Systems
from runtime.cnc.dynamic_settings import NO_LIMITS, USUAL, DynamicSettings, Slope, VectorLimits, WeightedPart
from runtime.cnc.geometry.frames import USUAL_SEQUENCE
from runtime.cnc.language.addresses import Addresses
from runtime.cnc.language.isg.index import Rules
from runtime.cnc.tools.setup import ToolSetup
from runtime.config.channel.dynamics import VectorParameters
from runtime.config.channel.parameters import ChannelParameters, ChannelSpindle, PathKind
from runtime.config.channel.synchronisation import (
    SYNCH_TYPES,
    SYNCH_VALUES,
    SynchCountError,
    SynchNameError,
    synch_names,
)
from runtime.config.external import ExternalLayout
from runtime.config.fir_filter import FirFilter
from runtime.config.machine import AxisType, Machine, TurningAxis
from runtime.config.nct import NctParameters
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import Place, TandemError
from runtime.hli.describe import io_bits
from runtime.hli.external import ExternalEntry, directory_of
from runtime.hli.layout import Mode
from runtime.hli.units import MICROSECOND

ZERO_OFFSETS = range(53, 60)
CENTRE_SHIFT = 2.0  # mm, default of P-CHAN-00059 (20000 · 0.1 µm)
GRADIAN = 0.9  # degrees
CYCLE_MEMORY = 8000  # bytes for V.CYC without P-CHAN-00418 (line 1313)
CENTRE_SHIFT_SHARE = 0.05  # of the radius, default of P-CHAN-00060 (50 · 0.1 %)


class DecoderSetupError(TandemError):
    """The channel cannot be set up as configured."""


def parse_synch(text: str, parameter: str = "synchronisation type") -> Synch:
    """A synchronisation type from names joined by "|" or a hexadecimal (or decimal) value.

    Exactly one type is allowed, flags beside it. DecoderSetupError names `parameter`.
    """
    try:
        names = synch_names(text)
    except SynchNameError:
        raise DecoderSetupError(
            catalogue.SYNCH_UNKNOWN, Place(), parameter=parameter, text=text, known=", ".join(SYNCH_VALUES)
        ) from None
    except SynchCountError:
        names = ()
    if not names or ("NOT_VALID" in names and len(names) > 1):
        supported = ", ".join(SYNCH_TYPES)
        raise DecoderSetupError(catalogue.SYNCH_NOT_ONE, Place(), parameter=parameter, text=text, supported=supported)
    if "NOT_VALID" in names:
        return Synch.NOT_VALID
    synch = Synch.NO_SYNCH
    for name in names:
        synch |= Synch[name]
    return synch


@dataclass(frozen=True, slots=True)
class GearRange:
    """Speeds of a gear stage, rev/min; a greatest of 0: the stage is not used."""

    least: float = 0.0
    greatest: float = 0.0

    @property
    def usable(self) -> bool:
        """The spindle has this stage."""
        return self.greatest > 0.0

    def covers(self, speed: float) -> bool:
        """The stage can turn so fast."""
        return self.usable and self.least <= speed <= self.greatest


class AxisDynamics(NamedTuple):
    """What an axis can: mm or degrees, and seconds."""

    velocity: float
    acceleration: float
    jerk: float


_ANYTHING = AxisDynamics(math.inf, math.inf, math.inf)


@dataclass(frozen=True, slots=True)
class SpindleSetup:
    """A spindle of the channel with the synchronisation of its functions: `m` for M3, M4, M5, M19.

    `plc`: the PLC moves it. `area` is its index among the axes of the machine. `gears`: M40 and following; `stages` how many
    data sets its axis has, `dynamics` the least of them (without: its own), degrees and seconds.
    """

    name: str
    s: Synch = Synch.NO_SYNCH
    m: Mapping[int, Synch] = field(default_factory=dict)
    s_duration: float = 0.0  # P-CHAN-00080, s
    m_duration: Mapping[int, float] = field(default_factory=dict)  # P-CHAN-00042 to 00048, s
    plc: bool = False
    area: int = -1
    log_axis: int = 0
    gears: tuple[GearRange, ...] = ()
    automatic_gear: bool = False
    gears_from_top: bool = False
    stages: int = 0
    dynamics: AxisDynamics = _ANYTHING

    @classmethod
    def of(cls, machine: Machine, spindle: ChannelSpindle, key: str) -> SpindleSetup:
        """The setup of a configured spindle; DecoderSetupError for a synchronisation type that cannot be used."""
        index = machine.axis_index(spindle.bezeichnung)
        axis = machine.axes[index]
        numbers = (3, 4, 5, 19)
        table = spindle.range_table
        sets = axis.gear_stages or (axis,)
        ranges = [table.get(stage) for stage in range(max(table, default=-1) + 1)]
        return cls(
            spindle.bezeichnung,
            parse_synch(spindle.s_synch, f"{key}.s_synch"),
            {number: parse_synch(getattr(spindle, f"m{number}_synch"), f"{key}.m{number}_synch") for number in numbers},
            spindle.s_prozess_zeit * MICROSECOND,
            {number: getattr(spindle, f"m{number}_prozess_zeit") * MICROSECOND for number in numbers},
            plc=spindle.plc_control,
            area=index,
            log_axis=axis.log_axis,
            gears=tuple(GearRange(r.min_speed, r.max_speed) if r else GearRange() for r in ranges),
            automatic_gear=spindle.autom_range,
            gears_from_top=spindle.range_way > 0,
            stages=len(axis.gear_stages),
            dynamics=AxisDynamics(
                min(known.velocity for known in sets),
                min(known.acceleration for known in sets),
                min(known.jerk for known in sets),
            ),
        )


@dataclass(frozen=True, slots=True)
class OtherAxis:
    """An axis of the machine outside of the channel; `index` among those of the machine."""

    name: str
    index: int
    log_axis: int


Pairs = tuple[tuple[int, int], ...]  # logical axis numbers of slave and master


@dataclass(frozen=True, slots=True)
class Limits:
    """How much of each kind a channel holds (configuration.decoder.*), and how deep programs may be nested."""

    parameters: int = 20_000
    program_variables: int = 20_000
    levels: int = 50
    macros: int = 1000
    macro_name: int = 30
    macro_content: int = 200
    cycle_memory: int = CYCLE_MEMORY  # bytes for V.CYC, with what P-CHAN-00418 adds


@dataclass(frozen=True, slots=True)
class DecoderSetup:
    """The channel as the decoder sees it; n axes in channel order, the first three are the main axes.

    `linear` tells which axes are linear (inch applies to them only). `zero_offsets` maps 53…59 to mm or degrees,
    shape (n,). `m_synch` and `h_synch` hold the usable functions. `feed` is the feed at program start in mm/min, 0
    for none. `centre_shift` (mm) and `centre_shift_share` (of the radius) bound the correction of circle centres.
    """

    axes: tuple[str, ...]
    linear: tuple[bool, ...]
    spindles: tuple[SpindleSetup, ...] = ()
    zero_offsets: Mapping[int, Floats] = field(default_factory=dict)
    m_synch: Mapping[int, Synch] = field(default_factory=dict)
    h_synch: Mapping[int, Synch] = field(default_factory=dict)
    micro_joints: bool = False  # P-CHAN-00600 has FCT_M_PRE_OUTPUT
    m_ahead: Mapping[int, int] = field(default_factory=dict)  # P-CHAN-00070, 0.1 µm or µs
    h_ahead: Mapping[int, int] = field(default_factory=dict)  # P-CHAN-00107
    m_area: Mapping[int, int] = field(default_factory=dict)  # P-CHAN-00039: index among the axes of the machine
    h_area: Mapping[int, int] = field(default_factory=dict)  # P-CHAN-00025
    m_duration: Mapping[int, float] = field(default_factory=dict)  # P-CHAN-00040, s
    h_duration: Mapping[int, float] = field(default_factory=dict)  # P-CHAN-00026, s
    tool_duration: float = 0.0  # P-CHAN-00072, s
    tool_synch: Synch = Synch.NO_SYNCH
    tools: ToolSetup = field(default_factory=ToolSetup)
    program_paths: tuple[Path, ...] = ()
    message_paths: tuple[Path, ...] = ()  # where #MSG SAVE writes, the first one counts
    start_m: int = 5  # M3, M4 or M5 that is modal for the main spindle from program start on (prog_start.m_gruppe)
    start_g: tuple[int, ...] = ()  # G functions that hold from program start on (prog_start.g_gruppe)
    feed: float = 0.0
    centre_shift: float = CENTRE_SHIFT
    centre_shift_share: float = CENTRE_SHIFT_SHARE
    macros: Mapping[str, str] = field(default_factory=dict)  # makro_def[]
    feed_factor: float = 1.0  # F to mm/min, from P-CHAN-00108
    mixed_dimension: bool = False  # P-CHAN-00116
    repeated_axes: bool = False  # P-CHAN-00148, with P-CHAN-00116
    inch: bool = False  # P-CHAN-00054: programs begin with G70
    rotary_unit: float = 1.0  # degrees of a programmed unit of rotary axes, P-CHAN-00079
    clamp_limits: bool = False  # P-CHAN-00498: G98 and G99 may only narrow the configured limits
    radius_change: float = 0.0  # mm, P-CHAN-00171: greatest difference of radii of an arc with G164, 0 is none
    radius_change_share: float = 0.0  # of the radius, P-CHAN-00172
    create_transfer: bool = True  # P-CHAN-00463
    keep_cycle_changes: bool = False  # P-CHAN-00210
    keep_parameters: bool = False  # P-CHAN-00067
    hide_cycles: bool = False  # P-CHAN-00211
    rules: Rules = field(default_factory=Rules)
    tool_change_program: str = ""  # P-CHAN-00118
    tool_data_program: str = ""  # P-CHAN-00429
    start_program: str = ""  # P-CHAN-00119
    final_program: str = ""  # P-CHAN-00252
    start_in: frozenset[str] = frozenset({"AUTOMATIC"})  # P-CHAN-00260: AUTOMATIC, MDI
    final_in: frozenset[str] = frozenset({"AUTOMATIC"})  # P-CHAN-00433
    g_programs: Mapping[int, str] = field(default_factory=dict)  # P-CHAN-00160…00169, 00187: G number → file
    axis_velocity: tuple[float, ...] = ()  # mm/s or degrees/s, (n,); for G194
    axis_dynamics: tuple[AxisDynamics, ...] = ()  # (n,)
    position_limits: tuple[tuple[float | None, float | None], ...] = ()  # software limits, (n,)
    reference_points: tuple[float, ...] = ()  # where homing finds them, mm or degrees, (n,)
    external: tuple[ExternalEntry, ...] = ()
    channel_number: int = 1  # V.G.CNC_CHANNEL
    measuring: MeasuringChannel = field(default_factory=MeasuringChannel)
    dynamics: DynamicSettings = USUAL  # at program start
    vector_limits: VectorLimits = NO_LIMITS  # vector.*: what #VECTOR LIMIT ON takes by itself
    vector_per_second: bool = False  # P-CHAN-00351: accelerations of #VECTOR LIMIT count per s², not per min²
    feed_group: FeedGroup = MAIN_GROUP  # P-CHAN-00011, P-CHAN-00096
    feed_axes_configured: bool = False
    exact_stop_after_rapid: bool = False  # P-CHAN-00235
    single_step: int = -1  # P-CHAN-00015
    stop_marks: tuple[bool, bool, bool] = (True, True, True)  # first time, again, backward (P-CHAN-00309, 00310, 00308)
    no_corners: bool = False  # P-CHAN-00273: chamfers and roundings are refused
    log_axes: tuple[int, ...] = ()  # logical axis numbers, (n,)
    log_spindles: tuple[int, ...] = ()  # of the spindles
    main_spindle: int = 0  # index of the configured one
    main_name: str = ""  # P-CHAN-00053
    gear_change: bool = False  # P-CHAN-00052
    turning: tuple[TurningAxis | None, ...] = ()  # (n,): what the axes are in turning
    offset_diameters: bool = False  # P-CHAN-00091
    cutting_feet: bool = False  # P-CHAN-00360
    spindle_m_free: bool = False  # P-CHAN-00098
    areas: Mapping[str, int] = field(default_factory=dict)  # axis of the channel → index among those of the machine
    poly_jerk: int = 1  # P-CHAN-00110
    contouring_inch: bool = False  # P-CHAN-00439
    hsc_start: Spline = HSC_DEFAULT  # what #HSC [BSPLINE] begins with
    no_hsc_at_zero: bool = False  # P-CHAN-00241
    limits: Limits = Limits()
    radius_compensation: bool = True  # P-CHAN-00092
    other_axes: tuple[OtherAxis, ...] = ()  # without spindles
    job_units: bool = False  # P-CHAN-00182
    jobs_wait: bool = False  # P-CHAN-00359
    couplings: Mapping[int, Pairs] = field(default_factory=dict)  # of synchro_data: group -> pairs
    couplings_after_reset: bool = False  # P-CHAN-00104
    couplings_after_end: bool = False  # P-CHAN-00105
    independent_exact_stop: int = 0  # P-CHAN-00297
    independent_waits_named: bool = False  # P-CHAN-00451
    modal_centre: bool = False  # P-CHAN-00159: I, J, K hold for following circles
    always_shortest: bool = False  # P-CHAN-00346: signs choose no direction of axes that turn without end
    period: float = 0.001  # of the cycle, s
    filters: tuple[FirFilter | None, ...] = ()  # of the axes, (n,)
    coordinate_systems: Mapping[str, tuple[float, ...]] = field(default_factory=dict)  # name → 3 shifts in mm, 3 angles
    rotation_sequence: str = USUAL_SEQUENCE  # P-CHAN-00394
    rotation_fixed: bool = False  # P-CHAN-00393
    offsets_of_systems: bool = True  # P-CHAN-00397, of axes behind the main axes too
    fixed_points: tuple[tuple[float, ...], ...] = ()  # the second to the fourth reference point, mm or degrees, (n,)
    nct: NctParameters = field(default_factory=NctParameters)
    skip_inputs: tuple[int, ...] = ()  # bits of the process image that are the skip signals of G31

    @classmethod
    def from_machine(cls, machine: Machine, channel: int = 0) -> DecoderSetup:
        """The setup of a channel of the machine; DecoderSetupError for synchronisation types that cannot be used."""
        described = machine.channels[channel]
        parameters = described.parameters
        offsets = {}
        for number in ZERO_OFFSETS:
            values = described.zero_offsets.get(f"G{number}", {})
            offsets[number] = np.array([values.get(axis, 0.0) for axis in described.axes])
        spindles = tuple(
            SpindleSetup.of(machine, spindle, f"spindel[{i}]") for i, spindle in enumerate(parameters.spindel)
        )
        axes = [machine.axes[machine.axis_index(axis)] for axis in described.axes]
        return cls(
            axes=described.axes,
            channel_number=described.number(channel),
            measuring=MeasuringChannel.of(machine, axes, parameters),
            main_spindle=next((i for i, s in enumerate(spindles) if s.log_axis == parameters.main_spindle_ax_nr), 0),
            main_name=parameters.main_spindle_name,
            gear_change=parameters.main_spindle_gear_change,
            turning=tuple(axis.turning for axis in axes),
            offset_diameters=parameters.versch_im_durchm,
            cutting_feet=parameters.enable_unit_feet_cut_speed,
            spindle_m_free=parameters.spindle_m_fct_free,
            areas={name: machine.axis_index(name) for name in described.axes},
            log_axes=tuple(axis.log_axis for axis in axes),
            log_spindles=tuple(
                machine.axes[machine.axis_index(spindle.bezeichnung)].log_axis for spindle in parameters.spindel
            ),
            axis_velocity=tuple(axis.velocity for axis in axes),
            axis_dynamics=tuple(AxisDynamics(axis.velocity, axis.acceleration, axis.jerk) for axis in axes),
            position_limits=tuple((axis.position_min, axis.position_max) for axis in axes),
            reference_points=tuple(axis.homing.position if axis.homing else 0.0 for axis in axes),
            linear=tuple(machine.axes[machine.axis_index(axis)].type is AxisType.LINEAR for axis in described.axes),
            spindles=spindles,
            zero_offsets=offsets,
            m_synch=_table(parameters.m_synch, "m_synch"),
            h_synch=_table(parameters.h_synch, "h_synch"),
            micro_joints=parameters.configuration.path_preparation.has_micro_joints,
            m_ahead=parameters.m_pre_outp,
            h_ahead=parameters.h_pre_outp,
            m_area={n: machine.axis_index(name) for n, name in parameters.m_default_outp_ax_name.items() if name},
            h_area={n: machine.axis_index(name) for n, name in parameters.h_default_outp_ax_name.items() if name},
            m_duration={number: time * MICROSECOND for number, time in parameters.m_prozess_zeit.items()},
            h_duration={number: time * MICROSECOND for number, time in parameters.h_prozess_zeit.items()},
            tool_duration=parameters.tool.prozess_zeit * MICROSECOND,
            tool_synch=parse_synch(parameters.tool.synch, "tool.synch"),
            tools=ToolSetup.of(parameters, round(machine.tools.answer_timeout / machine.cycle.period)),
            program_paths=tuple(Path(folder) for folder in described.folders(PathKind.SUBROUTINE)),
            message_paths=tuple(Path(folder) for folder in described.folders(PathKind.MESSAGES)),
            feed=parameters.prog_start.feedrate,
            feed_factor=parameters.prog_start.feed_unit,
            start_m=parameters.prog_start.spindle_m,
            start_g=tuple(parameters.prog_start.g_functions.values()),
            centre_shift=parameters.centre_shift,
            centre_shift_share=parameters.centre_shift_share,
            radius_change=parameters.radius_difference,
            radius_change_share=parameters.radius_difference_share,
            macros=parameters.macros,
            mixed_dimension=bool(parameters.multi_dimension_in_block),
            repeated_axes=parameters.multi_axes_in_block,
            inch=bool(parameters.mass_einh),
            rotary_unit=GRADIAN if parameters.rund_mass_einh else 1.0,
            clamp_limits=bool(parameters.range_check_prog_soft_limits),
            create_transfer=bool(parameters.create_cycle_param_on_read),
            keep_cycle_changes=bool(parameters.cycle_changes_modal),
            keep_parameters=bool(parameters.p_param_haltend),
            tool_change_program=parameters.m6_prog_file,
            tool_data_program=parameters.d_prog_file,
            start_program=parameters.start_init_prog_file,
            final_program=parameters.final_prog_file,
            start_in=_words(parameters.start_init_prog_file_mode),
            final_in=_words(parameters.final_prog_file_mode),
            g_programs=parameters.g_prog_files,
            dynamics=_dynamics(parameters),
            vector_limits=_vector_limits(parameters.vector),
            vector_per_second=parameters.vector.per_second,
            feed_group=_feed_group(parameters, len(axes)),
            feed_axes_configured=parameters.feed_axes_configured or parameters.feed_to_weakest_axis,
            no_corners=parameters.disable_chamfers_roundings,
            exact_stop_after_rapid=parameters.exact_stop_after_g00,
            single_step=parameters.einzelstschrittmodus,
            stop_marks=(
                not parameters.forward_backward.disable_stop_1st_forward,
                not parameters.forward_backward.disable_stop_2nd_forward,
                not parameters.forward_backward.disable_stop_backward,
            ),
            external=tuple(directory_of(ExternalLayout.of(machine).elements)),
            poly_jerk=parameters.check_jerk_on_poly_path,
            contouring_inch=bool(parameters.contouring_consider_inch),
            hsc_start=hsc_start(parameters.hsc),
            no_hsc_at_zero=parameters.hsc.bspline.no_hsc_for_deviation_zero,
            limits=Limits(
                parameters=parameters.configuration.decoder.p_param_number,
                macros=parameters.configuration.decoder.macro_number,
                macro_name=parameters.configuration.decoder.macro_symbol_len,
                macro_content=parameters.configuration.decoder.macro_nc_code_len,
                cycle_memory=CYCLE_MEMORY + parameters.configuration.decoder.var_memory,
            ),
            rules=Rules(
                labels=parameters.configuration.decoder.expression_label_number,
                names=parameters.configuration.decoder.string_label_number,
                local_programs=parameters.configuration.decoder.max_local_subroutine_definitions,
            ),
            hide_cycles=bool(parameters.suppress_cycle_logging),
            other_axes=tuple(
                OtherAxis(axis.name, index, axis.log_axis)
                for index, axis in enumerate(machine.axes)
                if axis.name not in described.axes and axis.type is not AxisType.SPINDLE
            ),
            period=machine.cycle.period,
            nct=described.nct,
            skip_inputs=tuple(io_bits(machine)[0][name] for name in described.nct.skip),
            filters=tuple(axis.fir_filter for axis in axes),
            coordinate_systems=parameters.coordinate_system.definitions,
            rotation_sequence=parameters.coordinate_system.rotation_sequence,
            rotation_fixed=parameters.coordinate_system.rotation_mode_fixed,
            offsets_of_systems=parameters.coordinate_system.axes_offsets_layer_specific,
            fixed_points=tuple(axis.reference_points for axis in axes),
            job_units=parameters.plcopen_std_unit,
            jobs_wait=parameters.plcopen_implicit_sync,
            couplings=parameters.synchro_data.axis_pairs,
            couplings_after_reset=parameters.synchro_data.restore_coupling_after_reset,
            couplings_after_end=parameters.synchro_data.preserve_coupling_after_prog_end,
            independent_exact_stop=parameters.mode_exact_stop_indp_axis,
            independent_waits_named=bool(parameters.mode_implicite_sync_indp_asyn_axis),
            modal_centre=parameters.modal_i_j_k_for_circle,
            always_shortest=parameters.enable_mod_axis_always_shortest_way,
            radius_compensation=parameters.wrk_im_kanal_vorhanden is not False,
        )

    def systems(self) -> Systems:
        """The coordinate systems with which a program begins."""
        return Systems(
            self.coordinate_systems,
            self.rotation_sequence,
            fixed=self.rotation_fixed,
            specific=self.offsets_of_systems,
            axes=len(self.axes),
        )

    @property
    def modulo_axes(self) -> frozenset[int]:
        """Rotary axes without software limits: they turn without end."""
        limits = self.position_limits or ((None, None),) * len(self.axes)
        return frozenset(i for i, linear in enumerate(self.linear) if not linear and limits[i] == (None, None))

    @property
    def addresses(self) -> Addresses:
        """The names that programs of this channel may use."""
        return Addresses(
            self.axes,
            tuple(spindle.name for spindle in self.spindles),
            frozenset(self.m_synch),
            frozenset(self.h_synch),
            self.main_name,
            self.gear_change,
            tuple(axis.name for axis in self.other_axes),
        )

    def in_mode(self, mode: Mode) -> DecoderSetup:
        """The same for a start in this mode: the programs at start and end run in those that are chosen for them.

        Manual mode counts as MDI; homing has neither of them.
        """
        name = {Mode.AUTOMATIC: "AUTOMATIC", Mode.MDI: "MDI", Mode.MANUAL: "MDI"}.get(mode, "")
        start = self.start_program if name in self.start_in else ""
        final = self.final_program if name in self.final_in else ""
        if (start, final) == (self.start_program, self.final_program):
            return self
        return replace(self, start_program=start, final_program=final)

    @property
    def configured_programs(self) -> frozenset[str]:
        """Files that the configuration of the channel names; they may lie anywhere."""
        named = (self.start_program, self.final_program, self.tool_change_program, self.tool_data_program)
        return frozenset(filter(None, (*named, *self.g_programs.values())))

    @property
    def m_numbers(self) -> frozenset[int]:
        """M functions that are configured."""
        return frozenset(self.m_synch)

    @property
    def h_numbers(self) -> frozenset[int]:
        """H functions that are configured."""
        return frozenset(self.h_synch)

    @property
    def spindle_names(self) -> tuple[str, ...]:
        """Names of the spindles, and behind them that of the main spindle if it is none of these."""
        own = tuple(spindle.name for spindle in self.spindles)
        return own if not own or self.main_name in ("", *own) else (*own, self.main_name)

    def zero_offset(self, number: int) -> Floats:
        """The offset of G53…G59, shape (n,)."""
        offset = self.zero_offsets.get(number)
        return np.zeros(len(self.axes)) if offset is None else offset


def _dynamics(parameters: ChannelParameters) -> DynamicSettings:
    """What holds at program start."""
    slope = parameters.prog_start.slope
    profile = slope.profile
    return DynamicSettings(
        slope=Slope.TRAPEZ if profile is None else Slope(profile),
        weighted_acceleration=WeightedPart(slope.acceleration),
        weighted_ramps=WeightedPart((slope.ramp_time + 1) // 2),
        path_weights=parameters.dynamic_weighting_active,
        curve_weights=parameters.curve_dynamic_weighting_active,
    )


def _vector_limits(vector: VectorParameters) -> VectorLimits:
    return VectorLimits(
        acceleration=vector.per_square_second("acceleration"),
        deceleration=vector.per_square_second("deceleration"),
        radial_acceleration=vector.per_square_second("radial_acceleration"),
        velocity=vector.velocity / 60.0,
    )


def _feed_group(parameters: ChannelParameters, axes: int) -> FeedGroup:
    """The axes that F refers to where no #FGROUP stands."""
    if parameters.feed_to_weakest_axis:
        return FeedGroup(weakest=True)
    if not parameters.feed_axes_configured:
        return FeedGroup()
    chosen = parameters.feed_axes(axes)
    return FeedGroup(tuple(1.0 if axis in chosen else 0.0 for axis in range(axes)))


def _words(flags: str) -> frozenset[str]:
    return frozenset(word.strip() for word in flags.split("|"))


def _table(texts: Mapping[int, str], name: str) -> dict[int, Synch]:
    table = {number: parse_synch(text, f"{name}[{number}]") for number, text in texts.items()}
    return {number: synch for number, synch in table.items() if synch != Synch.NOT_VALID}
