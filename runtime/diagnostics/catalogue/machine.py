"""Alarms of the running machine: axes, program start, preparation, PLC supervision."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity

DRIVE_FAULT = ErrorEntry(
    306001,
    "drive of axis {axis} reports fault 0x{code:04X}",
    reaction=Reaction.STOP_ON_PATH,
    remedy="look up the code in the drive's manual, remove the cause, then reset the channel",
)
DRIVE_OFFLINE = ErrorEntry(
    306002,
    "drive of axis {axis} does not answer",
    reaction=Reaction.STOP_ON_PATH,
    remedy="check the drive's supply, its node id and the CAN cable, then reset the channel",
)
FOLLOWING_ERROR = ErrorEntry(
    306003,
    "following error of axis {axis} is {lag:.3f}, allowed are {limit:.3f}",
    reaction=Reaction.STOP_ON_PATH,
    remedy="is the axis blocked, the servo too weak, or `following_error` too small for this feed?",
)
DRIVE_DROPPED = ErrorEntry(
    50025,
    "drive of axis {axis} left operation enabled by itself",
    reaction=Reaction.STOP_ON_PATH,
    remedy="check the drive's enable input and supply, then reset the channel",
    source="HLI, tracking mode",
)
PLC_WATCHDOG = ErrorEntry(
    270053,
    "the PLC has finished no cycle for {gap_ms:.0f} ms, allowed are {limit_ms:.0f} ms",
    reaction=Reaction.STOP_ON_PATH,
    remedy="the PLC program hangs or its process was killed; reset the channel to start it again",
    source="HLI, watchdog mechanism",
)
PLC_FAILED = ErrorEntry(
    306011,
    "the PLC program failed: {reason}",
    reaction=Reaction.STOP_ON_PATH,
    remedy="correct the program; reset the channel to start it again",
)
AXES_NOT_READY = ErrorEntry(
    306012,
    "the program does not start: axis {axis} is not enabled",
    remedy="switch the drives on, or reset the channel after a fault",
)
PROGRAM_ACTIVE = ErrorEntry(306013, "the program does not start: {program} is active", severity=Severity.WARNING)
CHANNEL_IN_ERROR = ErrorEntry(
    306014, "the program does not start: the channel is in error", remedy="reset the channel first"
)
PREPARATION_SILENT = ErrorEntry(
    306015,
    "the preparation process does not answer",
    reaction=Reaction.STOP_ON_PATH,
    remedy="restart the runtime; the journal says why the process ended",
)
CYCLE_FAILED = ErrorEntry(
    306016,
    "the cycle failed: {reason}",
    severity=Severity.FATAL,
    reaction=Reaction.QUICK_STOP,
    remedy="this is an error of the runtime; keep the journal and report it",
)
PROCESS_LOST = ErrorEntry(
    306017,
    "the {process} process ended: {reason}",
    severity=Severity.FATAL,
    reaction=Reaction.QUICK_STOP,
)
NO_SPINDLE = ErrorEntry(306018, "the channel has no spindle {spindle}", reaction=Reaction.STOP_ON_PATH)
MODE_REFUSED = ErrorEntry(306019, "{reason}", severity=Severity.WARNING)
