"""Errors of axis jobs: PLCopen motion blocks of the PLC, and `X[MC_...]` of the NC program."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity


def _entry(number: int, text: str, remedy: str) -> ErrorEntry:
    return ErrorEntry(number, text, severity=Severity.ERROR, reaction=Reaction.NONE, remedy=remedy)


JOB_UNKNOWN = _entry(
    308001,
    "a job whose function, direction or buffer mode is no number of the interface",
    "tandem hli header tells them",
)
JOB_DISABLED = _entry(
    308002,
    "axis {axis}: {function} without an enabled drive",
    "switch the axis on first (MC_Power) and wait for Status",
)
JOB_IN_PATH = _entry(
    308003,
    "axis {axis}: {function} while an NC program or a mode of the channel uses the axis",
    "wait for the end of the program, or take the axis out of the channel",
)
JOB_ERROR_STOP = _entry(308004, "axis {axis}: {function} in the state ErrorStop", "remove the cause, then MC_Reset")
JOB_STOPPING = _entry(308005, "axis {axis}: {function} in the state Stopping", "take Execute of MC_Stop back first")
JOB_LIMIT = _entry(
    308006,
    "axis {axis}: {function} would lead to {position:.4f}, beyond the software limits {least:.4f} ... {greatest:.4f}",
    "correct the target, or the limits in the machine description",
)
JOB_AT_LIMIT = _entry(
    308007, "axis {axis}: {function} has come to a software limit, the axis stands there", "move it back"
)
JOB_VALUE = _entry(308008, "axis {axis}: {function}: {what}", "correct the inputs of the block")
JOB_BUFFER_FULL = _entry(
    308009, "axis {axis}: {function} cannot be buffered: one job waits already", "give it when the one before is active"
)
JOB_SPINDLE = _entry(
    308010,
    "{axis} is a speed-controlled spindle: {function} needs an axis with position control",
    "command the spindle by S functions, or describe it as a rotary axis",
)
JOB_NO_GEAR = _entry(308011, "axis {axis}: {function} without a gear", "MC_GearIn first")
JOB_NO_ROOM = _entry(
    308012,
    "axis {axis}: {function} leaves the axis no room: {what}",
    "give both motions lower velocities and accelerations, so that their sum is what the axis can",
)
JOB_GEAR_LOST = _entry(
    308013,
    "axis {axis} cannot follow its master: {what}; it has stopped",
    "slow the master down, lower the ratio, or move the slave away from its limit",
)
JOB_MASTER = _entry(
    308014, "axis {axis}: there is no master axis with number {master}, or it is the axis itself", "name another"
)
JOB_STOPPED = _entry(
    308015, "axis {axis}: {function} was stopped: {reason}", "remove the cause, then MC_Reset and the job again"
)
JOB_HOME = _entry(
    308016,
    "axis {axis}: MC_Home cannot look for the reference, nobody tells when the axis is on its cam",
    "name an input in the machine description (homing.switch), let the PLC give reference_cam, or the drive home (homing.method)",
)
JOB_HOME_FAILED = _entry(
    308041,
    "axis {axis}: the reference was not found",
    "check the switch, its wiring and the direction; a drive may not know the method (0x6098), or need more time",
)
JOB_HOMES = _entry(
    308042,
    "axis {axis}: {function} is refused while the axis looks for its reference",
    "wait for MC_Home, or stop it (MC_Stop)",
)
JOB_HOME_MOVES = _entry(
    308043,
    "axis {axis}: MC_Home begins at rest only, and a job moves the axis",
    "wait for the end of the job, or stop it (MC_Stop)",
)
JOB_NO_PROBE = _entry(
    308040,
    "axis {axis}: its drive does not exchange this edge of its touch probe {number}",
    "name it in `process_data` of the drive (probe_1_rising, probe_1_falling, probe_2_rising, probe_2_falling)",
)
JOB_BY_DRIVE = _entry(
    308044,
    "axis {axis}: {function} is refused while the drive moves the axis by itself",
    "stop it first (MC_Halt, MC_Stop); only another order to the drive takes its place at once",
)
JOB_NO_DRIVE_MODE = _entry(
    308045,
    "axis {axis}: {function} is nothing that its drive does: {what}",
    "name them in the machine description, if the drive has them",
)
JOB_DRIVE_MOVES = _entry(
    308046,
    "axis {axis}: {function} begins at rest only, and a job moves the axis",
    "wait for the end of the job, or stop it (MC_Stop)",
)
JOB_DRIVE_LATE = _entry(
    308047,
    "axis {axis}: {function} was stopped, the drive has not gone into the mode that it needs",
    "the manual of the drive tells whether it changes its mode while it is enabled",
)
JOB_RUNS_AWAY = ErrorEntry(
    308048,
    "axis {axis} goes at {speed:.4g} although MC_TorqueControl allows it {allowed:.4g}: something drives it on; all drives "
    "brake by themselves",
    reaction=Reaction.QUICK_STOP,
    remedy="look at what drives it on, at the sign of the torque (0x607E) and at `torque_gain`; then reset",
)
JOB_RUNS = ErrorEntry(
    308017,
    "a job of the PLC moves axis {axis}: no program can start",
    remedy="wait for its end, or stop the axis (MC_Stop, reset)",
)
JOB_OF_PROGRAM = ErrorEntry(
    308018,
    "axis {axis}: {function} of the program {what}",
    severity=Severity.ERROR,
    reaction=Reaction.STOP_ON_PATH,
    remedy="the alarm of the axis tells why; remove the cause, reset, and start the program again",
)
JOB_PATH_AXIS = ErrorEntry(
    308019,
    "{function}: axis {axis} is in the path of the program",
    remedy="jobs are for axes outside of the channel; move this one with G00 or G01",
)
JOB_OF_SPINDLE = ErrorEntry(
    308020,
    "{function}: {axis} is a speed-controlled spindle, and a job needs an axis with position control",
    remedy="command it by S functions, or describe it as a rotary axis outside of the channel",
)
JOB_NO_AXIS = ErrorEntry(
    308021, "{function}: the machine has no axis {axis}", remedy="axes that take jobs of this program: {known}"
)
JOB_FUNCTION = ErrorEntry(308022, "{function!r} is no job of an axis", remedy="known: {known}")
JOB_INPUT = ErrorEntry(
    308024,
    "{function}: {key} = {value:.9g} is not allowed, it is {range}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="correct the value",
)
JOB_ID = ErrorEntry(
    308025,
    "no job with the id {id} was programmed up to here",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="X[MC_... Id={id}] in front of #WAIT MC_STATUS",
)
JOB_RATIO = ErrorEntry(308026, "{function} needs {what}, once", remedy="B[MC_GearIn Master=X RN=1 RD=2 Mode=0]")
JOB_OTHER_MASTER = _entry(
    308027, "axis {axis}: {function} names master {master}, and it follows another one", "name the master of MC_GearIn"
)
SPINDLE_ORDER = _entry(
    308028,
    "spindle {spindle}: the order {order} of the PLC is refused: {what}",
    "correct what the PLC program writes into ext_to_ipo, or wait until the spindle can take it",
)
SPINDLE_ERROR = ErrorEntry(
    308029,
    "spindle {spindle}: the PLC reports an error",
    reaction=Reaction.STOP_ON_PATH,
    remedy="the PLC program knows the cause; when it takes spdl_error back, reset",
)
