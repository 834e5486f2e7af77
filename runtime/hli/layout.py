"""The layout of the High-Level Interface: one tree of ctypes structures over shared memory.

Every element has one writer, told by its suffix: `_r` the CNC writes and the PLC reads, `_w` the PLC writes, `_rw` a
flag that both hand to and fro. In the operator area the operator's process stands in the PLC's place: there `_w` is
the operator's. A flag is always the last store of a write and the last store of taking. Only elementary aligned items
may be read without a flag; text is guarded by one, or changes only while nothing runs.

Units: lengths 0.1 µm, angles 0.0001 degrees, speeds 1 µm/s or 0.001 degrees/s, shares 0.1 %, times µs: the
interface's own whole numbers. `runtime.hli.client` and the PLC library convert to mm, degrees and seconds, once.

Adding an element here is all it takes: hash, C header and `tandem hli` follow from these classes.
"""

from __future__ import annotations

import ctypes as c
from enum import IntEnum, IntFlag

MAX_CHANNELS = 4
MAX_AXES = 16  # path axes and spindles
MAX_BUSES = 4
MAX_CHANNEL_AXES = 8
TECHNO_UNITS = 16  # technology functions of one block
ALARMS = 64
IMAGE_BYTES = 64
IMAGE_ANALOGUE = 32
NAME = 32
TEXT = 240
LONG_TEXT = 1000
MESSAGE_TEXT = 256  # of a message of the NC program, with its end mark
TIMERS = 128  # counters of #TIMER
KEYS = 8  # units of key presses, which may be given at the same time
KEY_PAIRS = 32  # logical key pairs, from 1
HANDWHEELS = 8  # logical handwheels, from 1
TOOL_OFFSETS = 32  # axis offsets of a tool
TOOL_PARAMETERS = 60  # free values of a tool
TOOL_KIN_PARAMETERS = 70
TOOL_REASON = 128  # why a tool management refuses a tool
EXTERNAL_BYTES = 65536  # area of the external variables
EXTERNAL_NAMES = 1024  # external variables and elements of structures with a name
EXTERNAL_PATH = 96
EXTERNAL_INDICES = 6
JOBS = 16  # axis jobs whose state is still told
MAGIC = 0x314D444E4154  # "TANDM1"
VERSION = "1.0"  # of the layout; its hash tells every other difference


class Mode(IntEnum):
    """Operating modes (HLI_IMCM_*)."""

    STANDBY = 1
    AUTOMATIC = 2
    MDI = 3
    MANUAL = 4
    HOMING = 5


class State(IntEnum):
    """States inside a mode."""

    DESELECTED = 1
    SELECTED = 2
    READY = 3
    ACTIVE = 4
    HOLD = 5
    ERROR = 6


class StopCondition(IntFlag):
    """Bits of `stop_condition_r`: why the path does not move although a program is active (our own list)."""

    NONE = 0
    FEED_HOLD = 0x1
    AXIS_FEED_HOLD = 0x2
    OVERRIDE_ZERO = 0x4
    WAIT_TECHNOLOGY = 0x8
    WAIT_CONTINUE = 0x10
    DWELL = 0x20
    WAIT_SPINDLE = 0x40
    SINGLE_BLOCK = 0x80
    NO_BLOCKS = 0x100  # the preparation is behind
    AXIS_NOT_READY = 0x200
    ERROR = 0x400
    TECHNOLOGY_FULL = 0x800  # no free unit: the PLC does not take its functions
    MESSAGE = 0x1000  # a message has to be taken: by SYN_ACK, by #FLUSH WAIT, or since ten of them wait
    PROGRAM_WAITS = 0x2000  # nothing is known as the decoder waits for something outside (#WAIT FOR, ACK)
    EXACT_STOP = 0x4000  # an axis is not yet within its window of standstill
    MANUAL = 0x8000  # G200: the axes are moved by hand until continue; or G202: such a motion ends
    HOMING = 0x10000  # axes look for their reference
    READ_DISABLE = 0x20000  # the PLC keeps the interpolator from taking blocks
    AXIS_LIMIT = 0x40000  # an axis would leave its dynamic limits, or move in a blocked direction
    DELETE_DISTANCE = 0x80000  # brakes, to drop the rest of the block
    MEASURING = 0x4000000  # a probe is got ready, or its value is to come
    AXIS_JOB = 0x100000  # a job of an axis outside the path has to be done
    BLOCK_SEARCH = 0x200000  # the PLC has to confirm that a block search begins, or that it has done what it got
    TURNING = 0x800000  # brakes, to be driven backward or forward again
    OPTIONAL_SECTION = 0x2000000  # a section that is left out has to be known to its end
    BACKWARD_END = 0x1000000  # driven backward, and nothing more is kept
    RETURN_TO_CONTOUR = 0x400000  # behind a block search: the axes may go back, or the program may go on, when told to


class PathWay(IntEnum):
    """`path_way_r`: how the path is driven."""

    ONWARD = 0
    TURNING = 1
    BACKWARD = 2
    REPEATING = 3  # forward again, up to where it was left


class SearchState(IntEnum):
    """`block_search_state_r`."""

    INACTIVE = 0
    WAIT_FOR_PLC_ON = 1  # until block_search_on is TRUE, if the PLC has claimed it
    ACTIVE = 2
    WAIT_FOR_PLC_OFF = 3  # until it is FALSE again
    WAIT_FOR_RETURN = 4  # the axes may be moved by hand, until continue
    RETURNING = 5
    WAIT_TO_CONTINUE = 6


class ManualMode(IntEnum):
    """How an axis is moved by hand (`operation_mode`)."""

    NONE = 0
    HANDWHEEL = 1  # any way, at any speed
    CONTINUOUS = 2  # as long as the key is pressed
    INCREMENTAL = 3  # one increment per press
    INTERRUPTIBLE = 4  # the same, but it ends when the key is released (our number)


class ManualState(IntEnum):
    """`state_r` of the display of manual mode."""

    OFF = 0
    RELEASED = 1  # by G200 or G201, without an element
    LINKED = 2  # with an element


class Blocked(IntEnum):
    """Bits of the directional feed hold of an axis."""

    PLUS = 1
    MINUS = 2


class AxisState(IntEnum):
    """`axis_state_r`."""

    READY = 1
    ACTIVE = 3
    HOLD = 5  # also: tracking, or the drive is not enabled
    ERROR = 7


class AxisFunction(IntEnum):
    """Jobs of an axis: the motion blocks of PLCopen part 1."""

    STOP = 1
    HALT = 2
    MOVE_ABSOLUTE = 3
    MOVE_RELATIVE = 4
    MOVE_ADDITIVE = 5
    MOVE_SUPERIMPOSED = 6
    MOVE_VELOCITY = 7
    GEAR_IN = 8
    GEAR_OUT = 9
    PHASING = 10
    TOUCH_PROBE = 11
    ABORT_TRIGGER = 12
    HOME = 13
    RESET = 14
    TORQUE_CONTROL = 15  # by the drive, in a torque mode or as the limit of a velocity
    VELOCITY_BY_DRIVE = 16


class BufferMode(IntEnum):
    """When a job begins that finds another one (mcBufferMode of PLCopen)."""

    ABORTING = 0
    BUFFERED = 1
    BLENDING_LOW = 2
    BLENDING_PREVIOUS = 3
    BLENDING_NEXT = 4
    BLENDING_HIGH = 5


class Direction(IntEnum):
    """Way of an absolute motion, and sense of an endless one."""

    POSITIVE = 1
    SHORTEST = 2
    NEGATIVE = 3
    CURRENT = 4


class JobState(IntEnum):
    """What became of a job."""

    NONE = 0
    BUSY = 1  # taken, another one is still before it
    ACTIVE = 2
    REACHED = 3  # goes on, and has its velocity or its gear
    DONE = 4
    ABORTED = 5  # by another job
    ERROR = 6


class MotionState(IntEnum):
    """State of an axis in the state diagram of PLCopen part 1."""

    DISABLED = 0
    STANDSTILL = 1
    HOMING = 2
    STOPPING = 3
    DISCRETE_MOTION = 4
    CONTINUOUS_MOTION = 5
    SYNCHRONIZED_MOTION = 6
    ERROR_STOP = 7


# --------------------------------------------------------------------------------------------- control units


class BoolUnit(c.Structure):
    """Control unit without usage check, BOOL: the command counts as long as it stands and enable_w is TRUE."""

    _fields_ = [("request_r", c.c_bool), ("enable_w", c.c_bool), ("command_w", c.c_bool), ("state_r", c.c_bool)]


class Uns32Unit(c.Structure):
    """Control unit without usage check, UNS32."""

    _fields_ = [
        ("request_r", c.c_uint32),
        ("command_w", c.c_uint32),
        ("state_r", c.c_uint32),
        ("enable_w", c.c_bool),
    ]


class Uns64Unit(c.Structure):
    """Control unit without usage check, UNS64."""

    _fields_ = [
        ("request_r", c.c_uint64),
        ("command_w", c.c_uint64),
        ("state_r", c.c_uint64),
        ("enable_w", c.c_bool),
    ]


class Sgn32Unit(c.Structure):
    """Control unit without usage check, SGN32; `state_r` tells what is in force."""

    _fields_ = [
        ("request_r", c.c_int32),
        ("command_w", c.c_int32),
        ("state_r", c.c_int32),
        ("enable_w", c.c_bool),
    ]


class Activation(c.Structure):
    """Links a control element to an axis; `control_element` 0 takes it away. `parameter_set` 0 are the values of the
    parameter units, 1 to 3 the stages of #HANDWHEEL, #JOG CONT and #JOG INCR."""

    _fields_ = [
        ("log_ax_n", c.c_uint16),
        ("control_element", c.c_uint16),  # logical key pair or handwheel
        ("operation_mode", c.c_uint16),  # ManualMode
        ("parameter_set", c.c_uint16),
    ]


class JogParameter(c.Structure):
    """What an axis does at a key press or a pulse; a value of 0 is left as it was."""

    _fields_ = [
        ("log_ax_n", c.c_uint16),
        ("width", c.c_int32),  # incremental: 0.1 µm; handwheel: 0.1 µm per pulse
        ("velocity", c.c_int32),  # continuous and incremental: 1 µm/s
    ]


class KeyPress(c.Structure):
    """A key of a pair: `direction` 1 or -1 is pressed, 0 released. It is released by itself after `hold_time` (µs, 0 never),
    so that nobody who has gone keeps an axis moving: who presses renews it."""

    _fields_ = [("key", c.c_uint16), ("direction", c.c_int16), ("hold_time", c.c_uint32)]


class ActivationUnit(c.Structure):
    """Control unit with usage check; what came of it shows in the display of manual mode."""

    _fields_ = [
        ("request_r", Activation),
        ("command_w", Activation),
        ("enable_w", c.c_bool),
        ("request_semaphor_rw", c.c_bool),
        ("command_semaphor_rw", c.c_bool),
    ]


class JogParameterUnit(c.Structure):
    """Control unit with usage check; the values are those of set 0 from the next activation on."""

    _fields_ = [
        ("request_r", JogParameter),
        ("command_w", JogParameter),
        ("enable_w", c.c_bool),
        ("request_semaphor_rw", c.c_bool),
        ("command_semaphor_rw", c.c_bool),
    ]


class KeyUnit(c.Structure):
    """Control unit with usage check for key presses."""

    _fields_ = [
        ("request_r", KeyPress),
        ("command_w", KeyPress),
        ("enable_w", c.c_bool),
        ("request_semaphor_rw", c.c_bool),
        ("command_semaphor_rw", c.c_bool),
    ]


class OperatorActivation(c.Structure):
    """The operator's side of an activation: he raises the flag, the CNC lowers it."""

    _fields_ = [("data_w", Activation), ("semaphor_rw", c.c_bool)]


class OperatorJogParameter(c.Structure):
    """The operator's side of the parameters of manual mode."""

    _fields_ = [("data_w", JogParameter), ("semaphor_rw", c.c_bool)]


class OperatorKey(c.Structure):
    """The operator's side of a key press."""

    _fields_ = [("data_w", KeyPress), ("semaphor_rw", c.c_bool)]


class ManualControl(c.Structure):
    """Control units of manual mode (hb_mc_control); `handwheel_w` counts pulses, up and down, through the overflow."""

    _fields_ = [
        ("activation", ActivationUnit),
        ("handwheel_parameter", JogParameterUnit),
        ("continuous_parameter", JogParameterUnit),
        ("jog_parameter", JogParameterUnit),
        ("key", KeyUnit * KEYS),
        ("handwheel_w", c.c_int32 * HANDWHEELS),
    ]


class ManualDisplay(c.Structure):
    """How an axis of the channel can be moved by hand, and how far it was (hb_display_r)."""

    _fields_ = [
        ("state_r", c.c_uint32),  # ManualState
        ("operation_mode_r", c.c_uint32),  # ManualMode
        ("control_element_r", c.c_uint32),
        ("hr_aufloesung_r", c.c_int32),  # 0.1 µm per pulse
        ("tipp_geschw_r", c.c_int32),  # 1 µm/s, continuous
        ("jog_geschw_r", c.c_int32),  # 1 µm/s, incremental
        ("jog_weg_r", c.c_int32),  # 0.1 µm
        ("offset_r", c.c_int64),  # 0.1 µm: way by hand that is not part of the path
    ]


class ModeState(c.Structure):
    """A wish of the mode unit: where from (0 = not checked), where to, and what with (program name, NC blocks)."""

    _fields_ = [
        ("from_mode", c.c_uint32),
        ("from_state", c.c_uint32),
        ("to_mode", c.c_uint32),
        ("to_state", c.c_uint32),
        ("parameter", c.c_char * 304),
    ]


class ModeStateUnit(c.Structure):
    """Control unit with usage check: one order at a time; a lowered flag means taken, `state_r` shows the result."""

    _fields_ = [
        ("request_r", ModeState),
        ("command_w", ModeState),
        ("mode_r", c.c_uint32),
        ("state_r", c.c_uint32),
        ("enable_w", c.c_bool),
        ("request_semaphor_rw", c.c_bool),
        ("command_semaphor_rw", c.c_bool),
    ]


class LcUnit(c.Structure):
    """The CNC wants something of the PLC: it lowers done_w and raises please_rw; the PLC lowers please_rw and raises
    done_w."""

    _fields_ = [("please_rw", c.c_bool), ("done_w", c.c_bool)]


class LcModeUnit(c.Structure):
    """The CNC asks the PLC whether it may change to `mode_r` (Mode): as LcUnit, where `enable_w` is TRUE."""

    _fields_ = [("mode_r", c.c_uint32), ("please_rw", c.c_bool), ("done_w", c.c_bool), ("enable_w", c.c_bool)]


class SearchOrder(c.Structure):
    """Where a program is entered that is started next, and how the axes get there.

    `type`: 0 at its beginning, 1 file offset, 3 block counter, 4 block number, 5 line, 6 where it was interrupted; `value`
    that number. `passes`: how often the block is come to, 0 as 1. `covered`: share of its first motion that is left out too.
    `return_feed` 0: that of the motion. `ranks`: the turn of each axis on the way back; all 0: the tool axis last, or first if
    it moves in its positive direction. `program`: file of the subprogram that the block stands in, "" for the main program.
    """

    _fields_ = [
        ("value", c.c_uint64),
        ("type", c.c_uint32),
        ("passes", c.c_uint32),
        ("covered", c.c_uint32),  # 0.1 %
        ("return_feed", c.c_uint32),  # 1 µm/s
        ("ranks", c.c_uint16 * MAX_CHANNEL_AXES),
        ("program", c.c_char * 128),
        ("automatic_return", c.c_bool),  # nobody is asked before the axes go back
        ("no_hold", c.c_bool),  # nobody is asked before the program goes on
    ]


class SearchUnit(c.Structure):
    """Control unit of the block search: `command_w` holds for every program that is started while it stands there."""

    _fields_ = [
        ("request_r", SearchOrder),  # what the operator has asked for, if the PLC has claimed the unit
        ("command_w", SearchOrder),
        ("type_r", c.c_uint32),  # of the program that runs
        ("enable_w", c.c_bool),
    ]


class OperatorSearch(c.Structure):
    """The operator's side of a block search: for one start, whether it is taken or refused."""

    _fields_ = [("data_w", SearchOrder), ("semaphor_rw", c.c_bool)]


class Interruption(c.Structure):
    """Where the program of mode AUTOMATIC is, or was when it ended before its end; kept when the power goes."""

    _fields_ = [
        ("program_r", c.c_char * 304),
        ("begin_r", c.c_double * MAX_CHANNEL_AXES),  # 0.1 µm or 0.0001 degrees: of the axes at the start of the program
        ("line_r", c.c_uint32),
        ("block_number_r", c.c_int32),
        ("way_r", c.c_double),  # 0.1 µm of path since the start of the program
        ("valid_r", c.c_bool),
    ]


class OperatorUnit(c.Structure):
    """What the operator asks of a channel; `_w` is the operator's, who may be another process (`tandem hli command`).

    The order of the mode unit is guarded by `order_semaphor_rw`: the operator raises it, the CNC answers and lowers it.
    `answer_r` is 0 when the order was taken (or handed to the PLC that claimed the unit), else the id of the refusal.
    """

    _fields_ = [
        ("order_w", ModeState),
        ("order_semaphor_rw", c.c_bool),
        ("answer_r", c.c_uint32),
        ("answer_text_r", c.c_char * TEXT),
        ("override_w", c.c_uint32),  # 0.1 %
        ("program_block_ignore_w", c.c_uint32),
        ("feedhold_w", c.c_bool),
        ("single_block_w", c.c_bool),
        ("optional_stop_w", c.c_bool),
        ("continue_motion_rw", c.c_bool),  # the operator raises it, the CNC lowers it
        ("reset_rw", c.c_bool),
        ("machine_lock_w", c.c_bool),
        ("backward_motion_w", c.c_bool),
        ("simulate_motion_w", c.c_bool),
        ("activation", OperatorActivation),
        ("handwheel_parameter", OperatorJogParameter),
        ("continuous_parameter", OperatorJogParameter),
        ("jog_parameter", OperatorJogParameter),
        ("key", OperatorKey),
        ("handwheel_w", c.c_int32 * HANDWHEELS),  # added to what the PLC counts
        ("block_search", OperatorSearch),
    ]


# --------------------------------------------------------------------------------------------- technology


class TechnologyUnit(c.Structure):
    """One technology function on its way to the PLC.

    CNC: fills the data, lowers done_w, raises please_rw. PLC: copies, lowers please_rw (taken); raises done_w when the
    action is finished (executed). Kinds without acknowledgement (MOS) end when they are taken: their done_w is left
    alone. `value` is the additional value of M and H; for S `position` and `revolutions` in 0.0001 degrees and 0.001
    degrees/s; for T `number` is the tool, `sister` and `variant` count if their flag is TRUE. `time` of MOS_TS is the moment
    within the cycle in which please_rw is raised, µs from its start. `sequence_r` counts the functions of the area from 1, both
    arrays together: the order in which they were put out. `nr_late_sync_r` counts the late functions of the area that are not
    done, this one included. `spindle_r` is the logical axis number of a spindle that the PLC itself moves, else 0.
    """

    _fields_ = [
        ("number_r", c.c_int32),
        ("value_r", c.c_int32),
        ("synch_r", c.c_int32),
        ("time_r", c.c_int32),
        ("line_r", c.c_uint32),
        ("block_number_r", c.c_int32),
        ("position_r", c.c_int32),
        ("revolutions_r", c.c_int32),
        ("sequence_r", c.c_uint32),
        ("nr_late_sync_r", c.c_uint16),
        ("spindle_r", c.c_uint16),
        ("sister_r", c.c_int32),
        ("variant_r", c.c_int32),
        ("fkt_ctrl_r", c.c_uint16),
        ("sister_valid_r", c.c_bool),
        ("variant_valid_r", c.c_bool),
        ("please_rw", c.c_bool),
        ("done_w", c.c_bool),
    ]


class MessageText(c.Structure):
    """A message of the NC program for the PLC; `typ` 0 none yet, 1 #MSG, 2 #MSG INFO."""

    _fields_ = [("contents", c.c_char * MESSAGE_TEXT), ("typ", c.c_uint32)]


class MessageUnit(c.Structure):
    """Messages for the PLC, one at a time: the CNC fills `request_r` and raises the flag, the PLC reads and lowers it. Those of
    the PLC for whoever operates the channel go the other way with `command_w` and its flag.

    `sequence_r` counts the messages: a PLC that reads one while a reset withdraws it sees another number.
    """

    _fields_ = [
        ("request_r", MessageText),
        ("sequence_r", c.c_uint32),
        ("request_semaphor_rw", c.c_bool),
        ("command_w", MessageText),
        ("command_semaphor_rw", c.c_bool),
    ]


# --------------------------------------------------------------------------------------------- tool management


class ToolIdentity(c.Structure):
    """What names a tool; sister and variant count if their flag is TRUE."""

    _fields_ = [
        ("basic", c.c_int32),
        ("sister", c.c_int32),
        ("variant", c.c_int32),
        ("sister_valid", c.c_bool),
        ("variant_valid", c.c_bool),
    ]


class ToolData(c.Structure):
    """The data of a tool: lengths 0.1 µm (offsets of axes that turn 0.0001 degrees), speeds 0.001 degrees/s, acceleration
    degrees/s^2; `kin_parameters` 0.1 µm or 0.0001 degrees. `parameters` are free values."""

    _fields_ = [
        ("id", ToolIdentity),
        ("valid", c.c_bool),
        ("tool_fixed", c.c_bool),
        ("type", c.c_uint16),  # 0 milling, 1 turning, 2 grinding
        ("cutter_position", c.c_uint16),
        ("sub_type", c.c_uint32),
        ("kin_id", c.c_uint32),
        ("spindle", c.c_uint32),  # logical axis number, 0 none
        ("radius", c.c_int32),
        ("length", c.c_int32),
        ("offsets", c.c_int32 * TOOL_OFFSETS),
        ("min_speed", c.c_uint32),
        ("max_speed", c.c_uint32),  # 0: not limited by the tool
        ("max_acceleration", c.c_uint32),  # 0: not limited by the tool
        ("parameters", c.c_double * TOOL_PARAMETERS),
        ("kin_parameters", c.c_double * TOOL_KIN_PARAMETERS),
    ]


class ToolRequest(c.Structure):
    """`kind` 1: data of the tool are wanted, 2: it comes next (T), 3: `parameters` are those that it has now."""

    _fields_ = [
        ("kind", c.c_uint32),
        ("sequence", c.c_uint32),
        ("id", ToolIdentity),
        ("parameters", c.c_double * TOOL_PARAMETERS),
    ]


class ToolAnswer(c.Structure):
    """To the request of kind 1 with this `sequence`: the tool, or that it is refused, and why."""

    _fields_ = [
        ("sequence", c.c_uint32),
        ("refused", c.c_bool),
        ("reason", c.c_char * TOOL_REASON),
        ("data", ToolData),
    ]


class ToolManagementUnit(c.Structure):
    """An external tool management. The CNC fills `request_r` and raises its flag, the PLC copies and lowers it; for kind 1 it
    fills `answer_w` then and raises that flag, the CNC takes and lowers it."""

    _fields_ = [
        ("request_r", ToolRequest),
        ("answer_w", ToolAnswer),
        ("request_semaphor_rw", c.c_bool),
        ("answer_semaphor_rw", c.c_bool),
    ]


class ToolLifeReport(c.Structure):
    """How long, and how far, a tool was in use since the report before."""

    _fields_ = [
        ("id", ToolIdentity),
        ("time_ms", c.c_uint32),
        ("distance", c.c_int64),  # 0.1 µm
        ("sequence", c.c_uint32),
    ]


class ToolLifeUnit(c.Structure):
    """Reports of tool life: the CNC fills one and raises the flag, the PLC copies and lowers it."""

    _fields_ = [("report_r", ToolLifeReport), ("report_semaphor_rw", c.c_bool)]


# --------------------------------------------------------------------------------------------- areas


class Watchdog(c.Structure):
    """Sign of life of the PLC: it raises alive_rw, the CNC lowers it; too long a gap is error 270053."""

    _fields_ = [
        ("cycle_time_w", c.c_uint32),  # longest allowed gap, µs
        ("enable_w", c.c_bool),
        ("alive_rw", c.c_bool),
        ("alive_state_r", c.c_bool),
        ("lc_alive_rw", c.c_bool),  # the mirror: the CNC raises it in every cycle, the PLC may lower it and watch
    ]


class Head(c.Structure):
    """First of all: who attaches reads magic, size and hash before anything else."""

    _fields_ = [
        ("magic_r", c.c_uint64),
        ("layout_hash_r", c.c_char * 65),
        ("version_r", c.c_char * 16),
        ("size_r", c.c_uint32),
        ("platform_size_r", c.c_uint32),
        ("channel_size_r", c.c_uint32),
        ("axis_size_r", c.c_uint32),
        ("channel_capacity_r", c.c_uint16),
        ("axis_capacity_r", c.c_uint16),
        ("owner_pid_r", c.c_uint32),
        ("machine_name_r", c.c_char * NAME),
        ("cycle_time_r", c.c_uint32),  # µs
        ("channels_r", c.c_uint16),
        ("axes_r", c.c_uint16),
        ("cycle_r", c.c_uint64),
        ("time_ns_r", c.c_uint64),  # the runtime's clock at the start of the cycle
        ("running_r", c.c_bool),  # the cycle runs; FALSE before start and after stop or crash
    ]


class PlcReport(c.Structure):
    """An alarm of the PLC program on its way to the CNC: the PLC fills it and raises the flag, the CNC takes and
    lowers it."""

    _fields_ = [
        ("id_w", c.c_uint32),
        ("number_w", c.c_uint32),  # counts the PLC's alarms; coming and going of an alarm carry the same number
        ("line_w", c.c_uint32),  # program line of the technology function it belongs to, 0 none
        ("active_w", c.c_bool),  # TRUE comes, FALSE goes
        ("text_w", c.c_char * TEXT),
        ("semaphor_rw", c.c_bool),
    ]


class BusStatus(c.Structure):
    """One bus of the drives and I/O nodes."""

    _fields_ = [
        ("channel_r", c.c_char * NAME),  # the CAN interface
        ("load_r", c.c_double),  # 0...1
        ("gone_r", c.c_bool),  # off, or out of order
    ]


class Platform(c.Structure):
    """What belongs to no single channel or axis: log-on of the PLC, timing figures, process states."""

    _fields_ = [
        ("plc_present_w", c.c_bool),
        ("plc_running_r", c.c_bool),
        ("plc_cycle_request_r", c.c_uint64),  # the CNC counts up: a PLC cycle is due
        ("plc_cycle_done_w", c.c_uint64),  # the PLC sets it to the request it has finished
        ("plc_cycle_time_ns_w", c.c_uint64),
        ("plc_overruns_r", c.c_uint64),
        ("work_time_ns_r", c.c_uint64),  # last cycle
        ("lateness_ns_r", c.c_uint64),  # last wake-up
        ("overruns_r", c.c_uint64),
        ("bus_load_r", c.c_double),  # 0...1, of the busiest bus
        ("bus_count_r", c.c_uint16),
        ("bus_r", BusStatus * MAX_BUSES),
        ("emcy_count_r", c.c_uint64),
        ("frames_sent_r", c.c_uint64),
        ("frames_received_r", c.c_uint64),
        ("reload_request_w", c.c_uint64),  # whoever replaces the PLC program counts up: load it anew
        ("reload_done_w", c.c_uint64),  # the PLC sets it to the request it has answered, after what follows
        ("reload_error_w", c.c_uint32),  # 0 the new program runs, else the id of the refusal
        ("reload_text_w", c.c_char * LONG_TEXT),  # what was kept, or why it was refused, with the traceback
        ("lc_error", PlcReport),
        ("plc_error_id_w", c.c_uint32),  # why the PLC program stands, 0 it does not
        ("plc_error_text_w", c.c_char * LONG_TEXT),
        ("plc_error_count_w", c.c_uint64),  # written last
        ("plc_restart_request_r", c.c_uint64),  # the CNC counts up: start the PLC program again
        ("service_ready_w", c.c_bool),  # the service process: every other process is up, the bus may boot
        ("process_lost_w", c.c_uint64),  # the service process counts up, after the text
        ("process_lost_text_w", c.c_char * TEXT),
        ("not_retained_w", c.c_bool),  # the service process: retained data cannot be written; set after the text
        ("not_retained_text_w", c.c_char * TEXT),
    ]


class Alarm(c.Structure):
    """One line of the alarm history; `sequence_r` is written last, 0 is an empty line."""

    _fields_ = [
        ("time_ns_r", c.c_uint64),  # wall clock, nanoseconds since 1970
        ("cycle_r", c.c_uint64),
        ("id_r", c.c_uint32),
        ("severity_r", c.c_uint32),
        ("axis_r", c.c_int32),  # logical axis number, 0 = none
        ("line_r", c.c_uint32),
        ("active_r", c.c_bool),
        ("text_r", c.c_char * TEXT),
        ("sequence_r", c.c_uint64),
    ]


class ChannelControl(c.Structure):
    """Control units of a channel."""

    _fields_ = [
        ("mode_and_state", ModeStateUnit),
        ("feedhold", BoolUnit),
        ("override", Uns32Unit),  # 0.1 %
        ("override_valid", BoolUnit),
        ("rapid_override", Uns32Unit),  # 0.1 %, of rapid moves where P-CHAN-00181 says so
        ("rapid_override_valid", BoolUnit),
        ("ext_command_speed", Sgn32Unit),  # 1 µm/s, in place of the programmed feed; below 0: backward on the path
        ("ext_command_speed_valid", BoolUnit),  # it counts while this is TRUE
        ("time_override", Uns32Unit),  # 0.1 %, scales the time of the path and, where configured, that of dwells
        ("time_override_valid", BoolUnit),
        ("single_block", BoolUnit),
        ("continue_motion", BoolUnit),
        ("optional_stop", BoolUnit),
        ("program_block_ignore", Uns32Unit),  # skip levels, bit n-1 = level n
        ("reset", BoolUnit),
        ("machine_lock", BoolUnit),  # from the start of a program on, no axis moves; spindles and functions do
        ("read_disable", BoolUnit),
        ("delete_distance_to_go", BoolUnit),
        ("backward_motion", BoolUnit),  # TRUE: the path is driven back as far as it is kept; FALSE: forward
        ("backward_storage_off", BoolUnit),  # taken over at the start of a program: nothing of it is kept
        ("simulate_motion", BoolUnit),  # sections of #OPTIONAL EXECUTION are left out
        ("simulate_motion_mask", Uns64Unit),
        ("stop_level", Uns32Unit),  # marks of #STOP REVERSIBLE that stop: bits of their LEVEL
        ("manual", ManualControl),
        ("block_search", SearchUnit),
        (
            "block_search_on",
            BoolUnit,
        ),  # request_r: the CNC waits; TRUE: it may begin, FALSE: all that was put out is done
    ]


class ChannelStatus(c.Structure):
    """Status of a channel, of the block in the interpolator."""

    _fields_ = [
        ("command_feed_r", c.c_int32),  # 1 µm/s; 2147483647: rapid
        ("active_feed_r", c.c_int32),  # below 0: a feed of the PLC drives the path backward
        ("active_override_r", c.c_uint32),
        ("covered_distance_r", c.c_uint32),  # 0.1 % of the block
        ("path_position_r", c.c_double),  # 0.1 µm since program start
        ("block_number_r", c.c_int32),
        ("line_r", c.c_uint32),
        ("block_counter_r", c.c_uint64),
        ("program_name_r", c.c_char * TEXT),
        ("stop_condition_r", c.c_uint32),
        ("interpolation_active_r", c.c_bool),
        ("decoder_program_end_r", c.c_bool),
        ("program_end_r", c.c_bool),
        ("axes_in_position_r", c.c_bool),
        ("wait_techno_acknowledge_r", c.c_bool),
        ("wait_continue_r", c.c_bool),
        ("wait_error_removal_r", c.c_bool),
        ("dwell_time_active_r", c.c_bool),
        ("prepared_blocks_r", c.c_uint32),  # elements in the motion queue
        ("waiting_functions_r", c.c_uint32),  # technology functions not yet acknowledged
        ("error_id_r", c.c_uint32),  # of the error that stopped the channel, 0 none
        ("machine_locked_r", c.c_bool),
        ("hb_display_r", ManualDisplay * MAX_CHANNEL_AXES),
        (
            "techno_path_to_go_r",
            c.c_uint32,
        ),  # 0.1 µm to where functions that were put out ahead are waited for (P-CHAN-00212)
        ("techno_time_to_go_r", c.c_uint32),  # µs, the same; 4294967295: not to be foreseen
        ("path_way_r", c.c_uint32),  # PathWay
        ("path_kept_r", c.c_uint32),  # records that can be driven backward
        ("dist_to_geom_end_r", c.c_int64 * MAX_CHANNEL_AXES),  # 0.1 µm, of each axis to the end of #DIST TO GO
        ("is_stopped_r", c.c_bool),  # at a mark of #STOP REVERSIBLE
        ("stop_user_value_r", c.c_uint32),  # its USR_VAL
        ("block_search_state_r", c.c_uint32),  # SearchState
        ("block_search_active_r", c.c_bool),  # the PLC gets the functions that were left out
        ("interruption", Interruption),
    ]


class ErrorRecord(c.Structure):
    """An error of the CNC. `body_type_r`: 1 it belongs to an NC program, which `program_r` and `line_r` name, 9 it does not."""

    _fields_ = [
        ("time_ns_r", c.c_uint64),  # wall clock, nanoseconds since 1970
        ("cycle_r", c.c_uint64),
        ("error_id_r", c.c_uint32),
        ("severity_r", c.c_uint32),  # 0 message, 1 warning, 2 error, 3 fatal
        ("reaction_r", c.c_uint32),  # what the machine does because of it, as the error catalogue counts
        ("axis_r", c.c_int32),  # logical axis number, 0 = none
        ("body_type_r", c.c_uint32),
        ("line_r", c.c_uint32),
        ("channel_r", c.c_uint32),  # number of the channel (P-CHAN-00400)
        ("program_r", c.c_char * TEXT),
        ("text_r", c.c_char * TEXT),
    ]


class ErrorUnit(c.Structure):
    """Errors of the CNC for the PLC, one at a time: the CNC fills the record and raises the flag, the PLC copies and lowers it.

    `left_out_r`: those for which there was no room as the PLC took none; the alarm history has them.
    """

    _fields_ = [
        ("message_r", ErrorRecord),
        ("sequence_r", c.c_uint32),
        ("left_out_r", c.c_uint32),
        ("semaphor_rw", c.c_bool),
    ]


class Channel(c.Structure):
    """One NC channel."""

    _fields_ = [
        ("name_r", c.c_char * NAME),
        ("number_r", c.c_uint32),  # P-CHAN-00400, else the place among the channels, from 1
        ("plc_present_w", c.c_bool),
        ("axis_count_r", c.c_uint16),
        ("axis_index_r", c.c_uint16 * MAX_CHANNEL_AXES),  # into the axis areas
        ("watchdog", Watchdog),
        ("control", ChannelControl),
        ("status", ChannelStatus),
        ("lc_reset", LcUnit),  # the PLC forgets the technology functions of this area
        ("lc_mode", LcModeUnit),
        ("used_units_std_sync_r", c.c_uint16),
        ("techno_unit_std_sync", TechnologyUnit * TECHNO_UNITS),
        ("used_units_late_sync_r", c.c_uint16),
        ("techno_unit_late_sync", TechnologyUnit * TECHNO_UNITS),  # demanded in a later block: MVS_SLM, MVS_SLP
        ("msg_mc_control", MessageUnit),
        ("mc_error", ErrorUnit),
        ("tool_management", ToolManagementUnit),
        ("tool_life", ToolLifeUnit),
    ]


class AxisJob(c.Structure):
    """A job for one axis; what a function does not need is 0. Dynamics of 0 or less are those of the axis."""

    _fields_ = [
        ("number", c.c_uint32),  # counts the PLC's jobs of the axis from 1; its state stands at number % JOBS
        ("function", c.c_uint16),  # AxisFunction
        ("buffer_mode", c.c_uint16),
        ("direction", c.c_uint16),
        ("mode", c.c_uint16),  # gear: 0 command, 128 actual values, 256 phase as well; probe: 1 falling, 2 rising edge
        ("master", c.c_uint16),  # logical axis number; probe: number of the input, from 1
        ("position", c.c_int64),  # 0.1 µm: position, distance or phase, of a gear as well
        ("velocity", c.c_int64),  # 1 µm/s
        ("acceleration", c.c_double),  # mm/s² or degrees/s²
        ("deceleration", c.c_double),
        ("jerk", c.c_double),  # mm/s³ or degrees/s³
        ("numerator", c.c_double),  # gear: velocity of the slave = that of the master * numerator / denominator
        ("denominator", c.c_double),
        ("torque", c.c_double),  # share of the rated torque
        ("torque_ramp", c.c_double),  # shares per second, 0: at once
    ]


class JobAnswer(c.Structure):
    """What became of a job; `number_r` is written last."""

    _fields_ = [
        ("state_r", c.c_uint32),  # JobState
        ("error_r", c.c_uint32),  # id of the error, 0 none
        ("position_r", c.c_int64),  # 0.1 µm: recorded by the probe
        ("number_r", c.c_uint32),
    ]


class AxisJobUnit(c.Structure):
    """The slot for jobs of an axis, one per PLC cycle: the PLC fills it and raises the flag, the CNC takes and lowers it.

    Only a stop may overwrite what waits. `stop_hold_w`: the axis stays in the state Stopping.
    """

    _fields_ = [
        ("command_w", AxisJob),
        ("command_semaphor_rw", c.c_bool),
        ("stop_hold_w", c.c_bool),
        ("motion_state_r", c.c_uint32),  # MotionState
        ("error_id_r", c.c_uint32),  # why the axis is in ErrorStop, 0 it is not
        ("commands_taken_r", c.c_uint32),
        ("answers_r", JobAnswer * JOBS),
        ("probe_recorded_r", c.c_bool),  # the last probe of the axis, of the PLC or of a program, has seen its edge
        ("probe_position_r", c.c_int64),  # 0.1 µm: where the axis was
    ]


class AxisControl(c.Structure):
    """Control units of an axis.

    The limits are those of the machine description where the PLC does not claim them; their `state_r` is 0 without a
    limit, 1 inside, 2 at the limit, -1 beyond it.
    """

    _fields_ = [
        ("drive_on", BoolUnit),
        ("torque_permission", BoolUnit),  # the drive is enabled with both
        ("release_feedhold", BoolUnit),
        ("feedhold", BoolUnit),
        ("reset", BoolUnit),
        ("follow_up", BoolUnit),  # tracking: the drive is not enabled, the set-point is the actual position
        ("parked", BoolUnit),  # out of use: programs start without the axis; taken over while no program runs
        ("directional_feedhold", Uns32Unit),  # Blocked
        ("reference_cam", BoolUnit),  # the axis is on its reference cam
        ("dyn_pos_limit_low", Sgn32Unit),  # 0.1 µm or 0.0001 degrees
        ("dyn_pos_limit_high", Sgn32Unit),
        ("lag_monitoring_off", BoolUnit),
        ("spdl_stop_at_prog_end", BoolUnit),  # spindles: the end of a program stops it
        ("spdl_reset", BoolUnit),  # it stops and forgets what was ordered; `state_r` is TRUE until it stands
        ("spdl_error", BoolUnit),  # the PLC reports an error: it stops, and takes no order
        ("override", Uns32Unit),  # spindles and axes moved alone, 0.1 %
        ("override_valid", BoolUnit),
        # 0.1 % of the rated torque; `state_r`: that in force, 4294967295: none of the machine
        ("torque_limit", Uns32Unit),
        ("torque_limit_valid", BoolUnit),  # it counts while this is TRUE
        ("probing_signal", BoolUnit),  # level of the probe of a measuring axis; `state_r` follows while it measures
        ("probing_time", Uns64Unit),  # ns, on the clock of head.time_ns_r: when it changed (P-AXIS-00516 PLC_TIMESTAMP)
    ]


class AxisStatus(c.Structure):
    """Status of an axis and of its drive."""

    _fields_ = [
        ("axis_state_r", c.c_uint32),
        ("command_position_r", c.c_int64),
        ("actual_position_r", c.c_int64),
        ("target_position_r", c.c_int64),
        ("position_lag_r", c.c_int64),
        ("actual_velocity_r", c.c_int64),
        ("actual_torque_r", c.c_int32),  # 0.1 % of the rated torque; 0 if the drive does not tell it
        ("drive_type_r", c.c_uint32),  # 4 simulation, 8 CANopen, 16 virtual: an axis without a drive
        ("drive_state_r", c.c_uint32),  # runtime.drives.DriveState
        ("drive_mode_r", c.c_uint32),  # 0x6061, mode of operation that it shows; 0 if the drive does not tell it
        ("fault_code_r", c.c_uint32),
        ("ready_for_power_on_r", c.c_bool),  # the drive is there and in no fault: it can be enabled
        ("ready_for_control_loop_on_r", c.c_bool),  # it is enabled
        ("in_position_r", c.c_bool),
        ("referenced_r", c.c_bool),
        ("measurement_active_r", c.c_bool),  # a measuring run waits for the probe of the axis
        ("probe_actuated_r", c.c_bool),  # its edge has come in this run
        ("measure_value_ok_r", c.c_bool),  # the last run has a value of the axis
    ]


class SpindleCommandKind(IntEnum):
    """What the PLC orders of a spindle: the numbers of the functions by which a program does it."""

    SPEED = 0
    M3 = 3
    M4 = 4
    M5 = 5
    M19 = 19
    HOMING = 74
    GEAR = 112
    ACCELERATION = 130
    FEED_FORWARD = 136
    OVERRIDE_OFF = 167
    SPEED_FACTOR = 1000


class SpindleWay(IntFlag):
    """`geo_gm_fkt` of a position of a spindle."""

    SHORTEST = 0x10
    ABSOLUTE = 0x100


class SpindleCommand(c.Structure):
    """An order to a spindle; what its kind does not need stays 0."""

    _fields_ = [
        ("satz_typ", c.c_uint32),  # SpindleCommandKind
        ("vb_prog", c.c_int32),  # 0.001 degrees/s, not negative; 0: the speed that is programmed (with SPEED: 0)
        ("geo_gm_fkt", c.c_uint32),  # SpindleWay
        ("fahrweg", c.c_int32),  # 0.0001 degrees: M19, the angle, or without ABSOLUTE the way to it, less than a turn
        ("value", c.c_double),  # ACCELERATION, FEED_FORWARD, SPEED_FACTOR: a share; GEAR: the stage, from 1
    ]


class SpindleCommandUnit(c.Structure):
    """The slot for orders of the PLC to a spindle: the PLC fills it and raises the flag, the CNC takes and lowers it."""

    _fields_ = [
        ("command_w", SpindleCommand),
        ("command_semaphor_rw", c.c_bool),
        ("commands_taken_r", c.c_uint32),
        ("error_r", c.c_uint32),  # id of why the last one was refused, 0 it was not
    ]


class SpindleStatus(c.Structure):
    """Status of an axis that is a spindle; 0.001 degrees/s."""

    _fields_ = [
        ("mode_r", c.c_uint32),  # 1 M5, 2 M3, 4 M4, 8 M19
        ("programmed_speed_r", c.c_int32),
        ("command_speed_r", c.c_int32),
        ("actual_speed_r", c.c_int32),
        ("rev_erreicht_r", c.c_bool),  # speed reached
        ("rev_null_r", c.c_bool),  # standing
    ]


class ReferenceState(IntEnum):
    """`state_r` of a reference."""

    UNKNOWN = 0  # nothing is said yet
    NONE = 1
    KEPT = 2


class KeptReference(c.Structure):
    """What is kept of an axis with an absolute encoder; mm or degrees."""

    _fields_ = [
        ("origin_r", c.c_double),  # position of the axis where its drive counts 0
        ("place_r", c.c_double),  # where it stands
        ("vendor_r", c.c_uint32),  # object 0x1018 of its drive
        ("product_r", c.c_uint32),
        ("serial_r", c.c_uint32),
        ("state_r", c.c_uint32),  # ReferenceState; written last
    ]


class Axis(c.Structure):
    """One axis or spindle."""

    _fields_ = [
        ("name_r", c.c_char * NAME),
        ("log_ax_n_r", c.c_uint16),
        ("axis_type_r", c.c_uint16),  # 1 linear, 2 rotary, 4 spindle
        ("plc_present_w", c.c_bool),
        ("error_r", c.c_bool),
        ("reset_error_locked_r", c.c_bool),
        ("control", AxisControl),
        ("status", AxisStatus),
        ("reference", KeptReference),
        ("spindle", SpindleStatus),
        ("ext_to_ipo", SpindleCommandUnit),
        ("job", AxisJobUnit),
        ("lc_reset", LcUnit),
        ("used_units_std_sync_r", c.c_uint16),
        ("techno_unit_std_sync", TechnologyUnit * TECHNO_UNITS),
        ("used_units_late_sync_r", c.c_uint16),
        ("techno_unit_late_sync", TechnologyUnit * TECHNO_UNITS),
    ]


class ProcessImage(c.Structure):
    """Inputs and outputs of the machine; bit n of the image is bit n % 8 of byte n // 8."""

    _fields_ = [
        ("digital_in_r", c.c_uint8 * IMAGE_BYTES),
        ("digital_out_w", c.c_uint8 * IMAGE_BYTES),
        ("analogue_in_r", c.c_double * IMAGE_ANALOGUE),  # in the units of the machine description
        ("analogue_valid_r", c.c_uint32),  # bit n: input n is that of a node that is there, and within its range
        ("analogue_out_w", c.c_double * IMAGE_ANALOGUE),
    ]


class Timer(c.Structure):
    """A counter of #TIMER: what it has counted before `started_ns_r`, and whether it goes on since then.

    `latched_r`: its count in ms when it was last read on the path.
    """

    _fields_ = [
        ("counted_ns_r", c.c_uint64),
        ("started_ns_r", c.c_uint64),
        ("latched_r", c.c_uint32),
        ("running_r", c.c_bool),
    ]


class ExternalName(c.Structure):
    """An external variable, or an element of a structure: where it lies in the area, and what it is.

    `path_r` is its name below V.E, elements separated by dots, [] where an index belongs. `offset_r` is where the value with all
    indices 0 begins, `size_r` the bytes of one value, `extents_r` and `strides_r` (bytes) belong to the indices from the left.
    """

    _fields_ = [
        ("path_r", c.c_char * EXTERNAL_PATH),
        ("kind_r", c.c_char * 16),
        ("access_r", c.c_char * 16),  # of the NC program
        ("offset_r", c.c_uint32),
        ("size_r", c.c_uint32),
        ("extents_r", c.c_uint32 * EXTERNAL_INDICES),
        ("strides_r", c.c_uint32 * EXTERNAL_INDICES),
        ("synchronous_r", c.c_bool),
    ]


class Hli(c.Structure):
    """The whole interface."""

    _fields_ = [
        ("head", Head),
        ("platform", Platform),
        ("channels", Channel * MAX_CHANNELS),
        ("axes", Axis * MAX_AXES),
        ("operator", OperatorUnit * MAX_CHANNELS),
        ("image", ProcessImage),
        ("alarm_count_r", c.c_uint64),  # alarms since start; the newest stands at (alarm_count_r - 1) % ALARMS
        ("alarms", Alarm * ALARMS),
        ("timers", Timer * TIMERS),
        ("external_count_r", c.c_uint32),
        ("external_names", ExternalName * EXTERNAL_NAMES),
        ("external", c.c_uint64 * (EXTERNAL_BYTES // 8)),  # NC program and PLC both write; zero at start
    ]
