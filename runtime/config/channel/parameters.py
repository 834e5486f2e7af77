"""The channel parameters in use, typed, under the manual's names and in the manual's units."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntFlag
from typing import Literal

from pydantic import Field, PrivateAttr

from runtime.config.channel.dynamics import HscParameters, PathWeight, RadiusWeight, SlopeAtStart, VectorParameters
from runtime.config.channel.key import Key
from runtime.config.contradictions import Contradiction, Location
from runtime.config.model import Model, Several
from runtime.diagnostics.errors import Place

INTERNAL = 1e-4  # mm or degrees per internal unit (0.1 µm, 0.0001°)


class PathKind(IntFlag):
    """What the programs or files of a folder are for (P-CHAN-00403)."""

    MAIN = 0x1
    SUBROUTINE = 0x2
    MESSAGES = 0x4  # #MSG SAVE
    DEBUG = 0x8


class SpeedRange(Model):
    """`spindel[i].range_table[j].*`: the speeds of a gear stage, rev/min; 0 and 0: not used."""

    min_speed: int = 0  # P-CHAN-00058
    max_speed: int = 0  # P-CHAN-00055


class ChannelSpindle(Model):
    """`spindel[i].*`: a spindle of the channel (manual line 3741 and following)."""

    bezeichnung: str  # P-CHAN-00007, name of the axis
    log_achs_nr: int | None = None  # P-CHAN-00036, has to be that of the axis
    s_synch: str = "NO_SYNCH"  # P-CHAN-00081
    m3_synch: str = "NO_SYNCH"  # P-CHAN-00045
    m4_synch: str = "NO_SYNCH"  # P-CHAN-00047
    m5_synch: str = "NO_SYNCH"  # P-CHAN-00049
    m19_synch: str = "NO_SYNCH"  # P-CHAN-00043
    s_prozess_zeit: int = 0  # P-CHAN-00080, µs
    m3_prozess_zeit: int = 0  # P-CHAN-00044
    m4_prozess_zeit: int = 0  # P-CHAN-00046
    m5_prozess_zeit: int = 0  # P-CHAN-00048
    m19_prozess_zeit: int = 0  # P-CHAN-00042
    optional: bool = False  # P-CHAN-00415, left out where the machine has no such axis
    plc_control: bool = False  # P-CHAN-00069, the PLC moves it
    autom_range: bool = False  # P-CHAN-00004, the gear stage follows from the speed
    range_way: int = 0  # P-CHAN-00074, 0: the lowest fitting stage, else the highest
    range_table: dict[int, SpeedRange] = Field(default_factory=dict)


class ChannelTool(Model):
    """`tool.*`."""

    synch: str = "NO_SYNCH"  # P-CHAN-00086
    prozess_zeit: int = 0  # P-CHAN-00072, µs
    minimum_length: int = 0  # P-CHAN-00156, 0.1 µm; 0: not checked
    minimum_radius: int = 0  # P-CHAN-00157, 0.1 µm; 0: not checked


class ChannelFlush(Model):
    """`flush.*`: functions that wait for the path."""

    d_cmd: str = "D"  # P-CHAN-00271: D, or FAW_D for #FLUSH WAIT before a D word


_SPINDLE_STANDS = 5  # M5


class StartFunction(Model):
    """`prog_start.g_gruppe[i]` and `prog_start.m_gruppe[i]`."""

    nr: int = -1  # P-CHAN-00063, P-CHAN-00064; -1: the built-in one


class ForwardBackward(Model):
    """`forward_backward.*`: programmed stops that are left out where the path is driven again."""

    disable_m00_backward: bool = False  # P-CHAN-00276
    disable_m00_2nd_forward: bool = False  # P-CHAN-00277
    disable_m01_backward: bool = False  # P-CHAN-00278
    disable_m01_2nd_forward: bool = False  # P-CHAN-00279
    disable_stop_backward: bool = False  # P-CHAN-00308, marks of #STOP REVERSIBLE that say nothing else
    disable_stop_1st_forward: bool = False  # P-CHAN-00309
    disable_stop_2nd_forward: bool = False  # P-CHAN-00310


class CouplingPair(Model):
    """`synchro_data.koppel_gruppe[0].paar[j].*`: two axes, of which one follows the other."""

    log_achs_nr_slave: int = 0  # P-CHAN-00038
    log_achs_nr_master: int = 0  # P-CHAN-00037


class CouplingGroup(Model):
    """`synchro_data.koppel_gruppe[0].*`."""

    paar: dict[int, CouplingPair] = Field(default_factory=dict)


class SynchroData(Model):
    """`synchro_data.*`: the coupling group 0, and what becomes of couplings."""

    koppel_gruppe: dict[int, CouplingGroup] = Field(default_factory=dict)
    restore_coupling_after_reset: bool = False  # P-CHAN-00104
    preserve_coupling_after_prog_end: bool = False  # P-CHAN-00105

    @property
    def axis_pairs(self) -> dict[int, tuple[tuple[int, int], ...]]:
        """Group -> pairs of axes, slave first."""
        return {
            number: tuple((pair.log_achs_nr_slave, pair.log_achs_nr_master) for pair in group.paar.values())
            for number, group in self.koppel_gruppe.items()
            if group.paar
        }


class ProgramStart(Model):
    """`prog_start.*`: what holds when a program starts."""

    feedrate: float = 0.0  # P-CHAN-00099, feed before the first F word; 0: the program has to give one
    feedrate_factor: float = 100.0  # P-CHAN-00108, unit of F: 100 is mm/min, 0.1 is m/min
    g_gruppe: dict[int, StartFunction] = Field(default_factory=dict)
    m_gruppe: dict[int, StartFunction] = Field(default_factory=dict)
    late_sync_ready: bool = False  # P-CHAN-00033, the end of a program waits for late functions
    slope: SlopeAtStart = SlopeAtStart()

    @property
    def g_functions(self) -> dict[int, int]:
        """G group → number of the function that is active at program start, where one is chosen."""
        return {group: function.nr for group, function in self.g_gruppe.items() if function.nr != -1}

    @property
    def spindle_m(self) -> int:
        """M3, M4 or M5 of the main spindle at program start."""
        chosen = self.m_gruppe.get(0, StartFunction()).nr
        return _SPINDLE_STANDS if chosen == -1 else chosen

    @property
    def feed_unit(self) -> float:
        """mm/min per unit of the F word: 1 or 1000."""
        return 1000.0 if self.feedrate_factor == 0.1 else 1.0


class AxisOfGroup(Model):
    """`gruppe[0].achse[j].*`; name and number have to be those of the channel's axis j."""

    bezeichnung: str = ""  # P-CHAN-00006
    log_achs_nr: int | None = None  # P-CHAN-00035
    default_feed_axis: bool = False  # P-CHAN-00011


class AxisGroup(Model):
    """`gruppe[0].*`: the axes of the channel."""

    bezeichnung: str = ""  # P-CHAN-00005
    achs_anzahl: int = 0  # P-CHAN-00003
    achse: dict[int, AxisOfGroup] = Field(default_factory=dict)


class MacroDefinition(Model):
    """`makro_def[i].*`: a macro that every program of the channel has."""

    symbol: str  # P-CHAN-00085
    nc_code: str  # P-CHAN-00062


class ProgramPath(Model):
    """`path[i].*`: a folder for programs or other files."""

    dir: str  # P-CHAN-00401
    id: int = 0  # P-CHAN-00402
    type: int  # P-CHAN-00403, bits of PathKind
    priority: int = 0  # P-CHAN-00404, 0 is looked at first

    @property
    def kind(self) -> PathKind:
        return PathKind(self.type)


class DecoderConfiguration(Model):
    """`configuration.decoder.*`: limits and message receivers; sizes in bytes."""

    var_memory: int = 0  # P-CHAN-00418, for V.CYC on top of 8000
    max_number_of_tools: int = -1  # P-CHAN-00419; -1 stands for 200
    max_local_subroutine_definitions: int = 50  # P-CHAN-00505
    macro_number: int = 100  # P-CHAN-00509, of the list and of programs together
    macro_definition_number: int = 50  # P-CHAN-00510, of the list
    macro_symbol_len: int = 30  # P-CHAN-00511, characters
    macro_nc_code_len: int = 80  # P-CHAN-00512, characters
    string_label_number: int = 200  # P-CHAN-00515
    expression_label_number: int = 200  # P-CHAN-00516
    p_param_number: int = 1000  # P-CHAN-00517
    msg_diag_memory: int = 0  # P-CHAN-00514; 0: no diagnosis messages
    msg_to_default: str = "STANDARD"  # P-CHAN-00518: STANDARD, DISABLED, WARNING (22194) or ERROR (22195)
    msg_to_hmi: str = "STANDARD"  # P-CHAN-00519
    msg_to_plc: str = "STANDARD"  # P-CHAN-00520

    @property
    def tools(self) -> int:
        """Greatest number of tools in a list."""
        return 200 if self.max_number_of_tools == -1 else self.max_number_of_tools


class PathPreparationConfiguration(Model):
    """`configuration.path_preparation.*`."""

    function: str = "FCT_DEFAULT"  # P-CHAN-00600, words joined by "|"
    m_pre_output_lookahead: int = 10  # P-CHAN-00603, NC blocks over which micro-joints reach
    m_pre_output_max_distance: int = 0  # P-CHAN-00604, 0.1 µm; 0: however long they are

    @property
    def has_micro_joints(self) -> bool:
        """FCT_M_PRE_OUTPUT is among the functions."""
        return "FCT_M_PRE_OUTPUT" in (word.strip() for word in self.function.split("|"))


class Configuration(Model):
    """`configuration.*`: read at start only."""

    decoder: DecoderConfiguration = DecoderConfiguration()
    path_preparation: PathPreparationConfiguration = PathPreparationConfiguration()


class SystemShift(Model):
    """`coordinate_system.def[i].path[j].translation.*`, mm."""

    t1: float = 0.0  # P-CHAN-00491
    t2: float = 0.0  # P-CHAN-00492
    t3: float = 0.0  # P-CHAN-00493


class SystemRotation(Model):
    """`coordinate_system.def[i].path[j].rotation.*`, degrees."""

    a1: float = 0.0  # P-CHAN-00494
    a2: float = 0.0  # P-CHAN-00495
    a3: float = 0.0  # P-CHAN-00496


class SystemPlacement(Model):
    """`coordinate_system.def[i].path[j].*`."""

    translation: SystemShift = SystemShift()
    rotation: SystemRotation = SystemRotation()


class SystemDefinition(Model):
    """`coordinate_system.def[i].*`: a coordinate system that programs use by its name."""

    id: str = ""  # P-CHAN-00490
    path: dict[int, SystemPlacement] = Field(default_factory=dict)  # 0 is the first path, the only one here


class CoordinateSystemParameters(Model):
    """`coordinate_system.*`."""

    rotation_mode_fixed: bool = False  # P-CHAN-00393
    rotation_sequence: str = "ZYX"  # P-CHAN-00394
    axes_offsets_layer_specific: bool = True  # P-CHAN-00397
    def_: dict[int, SystemDefinition] = Field(default_factory=dict, alias="def")

    @property
    def definitions(self) -> dict[str, tuple[float, ...]]:
        """Name → three shifts in mm and three angles in degrees, of those that have a name."""
        made: dict[str, tuple[float, ...]] = {}
        for definition in self.def_.values():
            if definition.id:
                placed = definition.path.get(0, SystemPlacement())
                shift, turn = placed.translation, placed.rotation
                made[definition.id] = (shift.t1, shift.t2, shift.t3, turn.a1, turn.a2, turn.a3)
        return made


class ChannelParameters(Model):
    """Channel parameters under their manual names."""

    # technology functions
    m_synch: dict[int, str] = Field(default_factory=dict)  # P-CHAN-00041
    h_synch: dict[int, str] = Field(default_factory=dict)  # P-CHAN-00027
    m_pre_outp: dict[int, int] = Field(default_factory=dict)  # P-CHAN-00070, 0.1 µm, or µs for the MET types
    h_pre_outp: dict[int, int] = Field(default_factory=dict)  # P-CHAN-00107
    m_default_outp_ax_name: dict[int, str] = Field(default_factory=dict)  # P-CHAN-00039, name of an axis
    h_default_outp_ax_name: dict[int, str] = Field(default_factory=dict)  # P-CHAN-00025
    m_prozess_zeit: dict[int, int] = Field(default_factory=dict)  # P-CHAN-00040, µs
    h_prozess_zeit: dict[int, int] = Field(default_factory=dict)  # P-CHAN-00026, µs
    m_h_pre_outp_time_calc_mode: bool = False  # P-CHAN-00209, both values take the slope of the axes into account
    m_h_pre_outp_calc_value_to_go: bool = False  # P-CHAN-00212
    m_h_pre_outp_nbr_block: int = 50  # P-CHAN-00274
    pre_output_tolerance: int = 0  # P-CHAN-00760, 0.1 µm; 0: not checked
    tool: ChannelTool = ChannelTool()
    # tools
    flush: ChannelFlush = ChannelFlush()
    ext_wzv_vorhanden: bool = False  # P-CHAN-00016, the tools are those of an external tool management
    t_info_to_wzv: bool = False  # P-CHAN-00087, it is told of T
    t_with_implicit_flush: bool = False  # P-CHAN-00106, #FLUSH CONTINUE with T
    tool_life_to_wzv: bool = False  # P-CHAN-00076, it is told how long tools are in use
    tool_life_to_wzv_suppress_zero: bool = False  # P-CHAN-00243, unless they were not
    tool_life_capture_all_movements: bool = False  # P-CHAN-00255, rapid traverse counts too
    tool_life_with_d: bool = False  # P-CHAN-00482, a tool is in use from D on, and not from T on
    d_clear_to_wzv: bool = False  # P-CHAN-00103, a program start saves the tool of the program before
    einrechnen_mit_t: bool = False  # P-CHAN-00014, T executes D with its number
    move_tool_offsets_directly: bool = False  # P-CHAN-00100, D moves the axes at once
    remain_tool_length_in_ax: bool = False  # P-CHAN-00420, the length stays in Z in every plane
    # spindles and axes
    spdl_anzahl: int = 0  # P-CHAN-00082, number of spindles when given
    spindel: Several[ChannelSpindle] = ()
    main_spindle_ax_nr: int = 0  # P-CHAN-00051; 0: the first spindle
    main_spindle_name: str = ""  # P-CHAN-00053, of whichever spindle is the main one
    main_spindle_gear_change: bool = False  # P-CHAN-00052, M40 to M45 change its gear
    spindle_m_fct_free: bool = False  # P-CHAN-00098, M3, M4, M5, M19 are as in m_synch
    grp_anzahl: int = 1  # P-CHAN-00023
    gruppe: dict[int, AxisGroup] = Field(default_factory=dict)
    feed_to_weakest_axis: bool = False  # P-CHAN-00096
    # what holds at program start, and from one program to the next
    prog_start: ProgramStart = ProgramStart()
    einzelstschrittmodus: int = 0  # P-CHAN-00015, blocks without motion that are steps: -1 none, 0 of functions, 1 all
    forward_backward: ForwardBackward = ForwardBackward()
    p_param_haltend: bool = False  # P-CHAN-00067, P parameters outlive the program
    # motion words
    multi_dimension_in_block: bool = False  # P-CHAN-00116, G90 and G91 in one block
    multi_axes_in_block: bool = False  # P-CHAN-00148, an axis several times in a block
    mass_einh: int = Field(default=0, ge=0, le=1)  # P-CHAN-00054, unit of linear axes: 1 inch
    rund_mass_einh: int = Field(default=0, ge=0, le=1)  # P-CHAN-00079, unit of rotary axes: 1 gradians
    channel_id: int = Field(default=0, ge=0, le=65535)  # P-CHAN-00400, number of the channel; 0: its place in the list
    mittelpkt_diff: float = 20000.0  # P-CHAN-00059, 0.1 µm
    mittelpkt_faktor: int = 50  # P-CHAN-00060, 0.1 % of the radius
    max_radius_diff_circle: int = 0  # P-CHAN-00171, 0.1 µm; 0: off
    max_proz_radius_diff_circle: int = 0  # P-CHAN-00172, 0.1 % of the radius; 0: off
    soft_limit_tolerance: bool = False  # P-CHAN-00120, axes at rest may lie beyond their limits a little
    soft_limit_warning_axes: int = 0  # P-CHAN-00147, bits of axes whose limits only warn
    suppress_soft_limit_monitoring_axes: int = 0  # P-CHAN-00459, bits of axes without limits on the path
    range_check_prog_soft_limits: bool = False  # P-CHAN-00498, G98 and G99 clamp to the limits of the axis
    versch_im_durchm: bool = False  # P-CHAN-00091, offsets of the facing axis are diameters
    enable_unit_feet_cut_speed: bool = False  # P-CHAN-00360, cutting speed in ft/min with G70
    max_vb_override: int = Field(default=1000, ge=0, le=2000)  # P-CHAN-00056, 0.1 %
    # measuring
    messtyp: int = Field(default=1, ge=1, le=7)  # P-CHAN-00057, type of measuring
    meas_error_no_signal: bool = False  # P-CHAN-00176, of types 1, 3 and 4
    meas_deceleration_mode: int = Field(
        default=0, ge=0, le=1
    )  # P-CHAN-00214, 1: brakes as rapid traverse, not as feed hold
    meas_soft_limit_move_path: bool = False  # P-CHAN-00268, a run ends at the software limits
    meas_use_std_dynamic: bool = False  # P-CHAN-00296, planned as feed blocks are
    meas_pcs_value_no_probe_radius: bool = False  # P-CHAN-00311, the ball of the probe does not count
    meas_allow_actuated_probe: bool = False  # P-CHAN-00312, a deflected probe ends a run at once
    meas_error_no_move_path: bool = True  # P-CHAN-00313, a run without way is an error
    meas_trafo_with_cmd_pos: bool = False  # P-CHAN-00440, axes that rest count where they stand
    meas_all_axes: bool = False  # P-CHAN-00327, in a coordinate system every axis that can measures
    mode_exact_stop_indp_axis: int = 0  # P-CHAN-00297: 1 at G60, 2 at #WAIT INDP
    mode_implicite_sync_indp_asyn_axis: int = 0  # P-CHAN-00451: 1 where the axis is named, 0 where it is moved
    modal_i_j_k_for_circle: bool = False  # P-CHAN-00159, they hold for the circles behind
    enable_mod_axis_always_shortest_way: bool = False  # P-CHAN-00346, of axes that turn without end
    hli_input_disable_condition: Literal["DEFAULT", "NEXT_NON_RAPID_BLOCK", "NEXT_RAPID_BLOCK"] = (
        "DEFAULT"  # P-CHAN-00267
    )
    # manual mode
    path_reject_std_manual_mode: bool = False  # P-CHAN-00113
    rel_offset_limits_std_manual_mode: bool = False  # P-CHAN-00114
    override_v_handwheel: bool = False  # P-CHAN-00186
    err_outp_manual_mode_move: bool = False  # P-CHAN-00437
    # dynamics
    vector: VectorParameters = VectorParameters()
    use_drive_curr_limit: bool = False  # P-CHAN-00097, feed hold has a ramp of its own
    dynamic_weighting_active: int = 0  # P-CHAN-00190, straight moves: 1 G00, 2 G01, 3 both
    dynamic_weighting: dict[int, PathWeight] = Field(default_factory=dict)
    curve_dynamic_weighting_active: bool = False  # P-CHAN-00230
    curve_dynamic_weighting: dict[int, RadiusWeight] = Field(default_factory=dict)
    exact_stop_after_g00: bool = False  # P-CHAN-00235
    independent_axis_error_stop: bool = (
        False  # P-CHAN-00218, a faulty axis makes all axes leave the path on their own ramps
    )
    hsc: HscParameters = HscParameters()
    g00_override_mode: Literal["NOT_USED", "MINIMUM_OF_G0_G1", "ACTIVE", "ACTIVE_EXTENDED"] = "NOT_USED"  # P-CHAN-00181
    plc_command_rapid_feed: bool = False  # P-CHAN-00102, a feed of the PLC acts on rapid moves, too
    disable_feed_factor: bool = False  # P-CHAN-00422, #FF does not weight it
    override_delay: int = 10  # P-CHAN-00065, µs between two changes of the override, ten cycles at least
    override_weight_prog_feed: int = 0  # P-CHAN-00066: 1 scales the programmed feed, 0 and 2 what the axes leave of it
    feed_override_weight_dwell_time: bool = False  # P-CHAN-00353, the feed override stretches dwells
    time_override_weight_dwell_time: bool = False  # P-CHAN-00111, the time override stretches dwells
    suppress_ax_group_in_pos_check: bool = False  # P-CHAN-00173, continue does not look at the axes
    plcopen_std_unit: bool = False  # P-CHAN-00182, values of axis jobs in mm instead of 0.1 µm, and so on
    plcopen_implicit_sync: bool = False  # P-CHAN-00359, the path waits for every axis job at the end of its block
    disable_chamfers_roundings: bool = False  # P-CHAN-00273
    max_nc_blocks_ahead: int = 0  # P-CHAN-00216; 0: the decoder runs ahead as far as the queue has room
    max_motion_blocks_ahead: int = 0  # P-CHAN-00246
    max_time_ahead: float = 0.0  # P-CHAN-00269, µs
    dec_max_ahead_protected: str = "NONE"  # P-CHAN-00270: NONE or ACTIVE
    # couplings
    synchro_data: SynchroData = SynchroData()
    # coordinate systems
    coordinate_system: CoordinateSystemParameters = CoordinateSystemParameters()
    # tool radius compensation
    wrk_im_kanal_vorhanden: bool | None = None  # P-CHAN-00092; there is one as long as nobody takes it away
    # smoothing
    check_jerk_on_poly_path: int = Field(default=1, ge=0, le=3)  # P-CHAN-00110
    contouring_consider_inch: bool = False  # P-CHAN-00439, lengths of smoothing in inch under G70
    # subroutines
    path: dict[int, ProgramPath] = Field(default_factory=dict)
    m6_prog_file: str = ""  # P-CHAN-00118
    d_prog_file: str = ""  # P-CHAN-00429
    start_init_prog_file: str = ""  # P-CHAN-00119
    start_init_prog_file_mode: str = "AUTOMATIC"  # P-CHAN-00260: AUTOMATIC, MDI or both with " | "
    final_prog_file: str = ""  # P-CHAN-00252
    final_prog_file_mode: str = "AUTOMATIC"  # P-CHAN-00433
    g80_prog_file: str = ""  # P-CHAN-00160
    g81_prog_file: str = ""  # P-CHAN-00161
    g82_prog_file: str = ""  # P-CHAN-00162
    g83_prog_file: str = ""  # P-CHAN-00163
    g84_prog_file: str = ""  # P-CHAN-00164
    g85_prog_file: str = ""  # P-CHAN-00165
    g86_prog_file: str = ""  # P-CHAN-00166
    g87_prog_file: str = ""  # P-CHAN-00167
    g88_prog_file: str = ""  # P-CHAN-00168
    g89_prog_file: str = ""  # P-CHAN-00169
    g800_prog_file: dict[int, str] = Field(default_factory=dict)  # P-CHAN-00187: 5 belongs to G805
    # cycles
    cycle_changes_modal: bool = False  # P-CHAN-00210
    suppress_cycle_logging: bool = False  # P-CHAN-00211
    create_cycle_param_on_read: bool = True  # P-CHAN-00463
    cycle_stack_memory: int = 0  # P-CHAN-00481, bytes for @P parameters on top of the usual ones
    # macros and limits
    makro_def: dict[int, MacroDefinition] = Field(default_factory=dict)
    configuration: Configuration = Configuration()

    _origins: Mapping[Key, tuple[Location, Place | None]] = PrivateAttr(default_factory=dict)
    _warnings: tuple[Contradiction, ...] = PrivateAttr(default=())

    @classmethod
    def of(
        cls,
        tree: Mapping[str | int, object],
        origins: Mapping[Key, tuple[Location, Place | None]],
        warnings: tuple[Contradiction, ...],
    ) -> ChannelParameters:
        """The parameters of a tree of checked values, with where they were given and what has no effect."""
        parameters = cls.model_validate(tree)
        parameters._origins, parameters._warnings = origins, warnings
        return parameters

    @property
    def g_prog_files(self) -> dict[int, str]:
        """Number of a G function (80…89, 800…839) → global subroutine that it calls, where one is given."""
        files = {number: str(getattr(self, f"g{number}_prog_file")) for number in range(80, 90)}
        files |= {800 + index: name for index, name in self.g800_prog_file.items()}
        return {number: name for number, name in files.items() if name}

    @property
    def macros(self) -> dict[str, str]:
        """Name → NC code of the macros of the list."""
        return {macro.symbol: macro.nc_code for macro in self.makro_def.values()}

    @property
    def centre_shift(self) -> float:
        """Greatest correction of a circle centre, mm."""
        return self.mittelpkt_diff * INTERNAL

    @property
    def centre_shift_share(self) -> float:
        """The same as a share of the radius."""
        return self.mittelpkt_faktor / 1000.0

    @property
    def radius_difference(self) -> float:
        """Greatest difference of the radii at start and end of an arc with G164, mm; 0: no difference is blended."""
        return self.max_radius_diff_circle * INTERNAL

    @property
    def radius_difference_share(self) -> float:
        """The same as a share of the radius; 0: no such limit."""
        return self.max_proz_radius_diff_circle / 1000.0

    @property
    def feed_axes_configured(self) -> bool:
        """Feed axes are chosen."""
        return any(axis.default_feed_axis for axis in self.gruppe.get(0, AxisGroup()).achse.values())

    def feed_axes(self, axes: int) -> tuple[int, ...]:
        """Indices of the default feed axes in a channel with so many axes: those chosen, else the main axes."""
        chosen = tuple(
            index for index, axis in sorted(self.gruppe.get(0, AxisGroup()).achse.items()) if axis.default_feed_axis
        )
        return chosen or tuple(range(min(axes, 3)))

    def folders(self, kind: PathKind) -> tuple[str, ...]:
        """The folders of a kind in the order in which they are searched."""
        chosen = [path for path in self.path.values() if path.kind & kind]
        return tuple(path.dir for path in sorted(chosen, key=lambda path: path.priority))

    def origin(self, *key: str | int) -> tuple[Location, Place | None]:
        """Where a parameter was given: its location in the YAML tree of the parameters, or its place in the list."""
        return self._origins.get(key, (key, None))

    @property
    def warnings(self) -> tuple[Contradiction, ...]:
        """What was given and has no effect; locations count from the parameters."""
        return self._warnings
