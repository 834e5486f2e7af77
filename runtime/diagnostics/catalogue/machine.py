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
AXIS_TRACKING = ErrorEntry(
    50025,
    "axis {axis} is in tracking although it shall be able to move: its drive is not enabled",
    reaction=Reaction.STOP_ON_PATH,
    remedy="check the drive's enable input and supply; does the PLC take drive_on back while a program runs? Then reset",
    source="HLI, tracking mode",
)
PLC_NOT_RUNNING = ErrorEntry(
    306011,
    "the program does not start: the PLC does not run",
    remedy="reset the channel to start the PLC again; an earlier alarm says why it ended",
)
AXES_NOT_READY = ErrorEntry(
    306012,
    "the program does not start: axis {axis} is not enabled",
    remedy="switch the drives on, or reset the channel after a fault",
)
CHANNEL_IN_ERROR = ErrorEntry(
    306014, "the program does not start: the channel is in error", remedy="reset the channel first"
)
PREPARATION_FAILED = ErrorEntry(
    306015,
    "the preparation has failed without an id of the catalogue",
    remedy="this is an error of the runtime; keep the journal and report it",
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
    "a process of the runtime ended: {process}",
    severity=Severity.FATAL,
    reaction=Reaction.STOP_ON_PATH,
    remedy="the journal has its last words; reset the channel to go on",
)
NOT_READY = ErrorEntry(
    306020,
    "drives and PLC are not ready after {seconds:.0f} s",
    remedy="the alarms before this one tell what is missing",
)
SIMULATION_STANDS = ErrorEntry(
    306021,
    "the program has been standing for {seconds:.0f} s and waits for {waits}",
    remedy="does the PLC program acknowledge every function?",
)
STOP_ORDERED = ErrorEntry(
    306022,
    "the machine is brought to rest and switched off ({reason})",
    severity=Severity.MESSAGE,
    reaction=Reaction.NONE,
)
CYCLE_NOT_STARTED = ErrorEntry(
    306023,
    "the cycle process did not start: {reason}",
    severity=Severity.FATAL,
    remedy="the lines before this one tell why",
)
AXIS_MOVED = ErrorEntry(
    306024,
    "axis {axis} stands at {now:.3f}, at the end of the last run it stood at {before:.3f}",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
    remedy="was it moved while the control was off? if not, check its encoder before the first move",
)
PATH_APART = ErrorEntry(
    306025,
    "the next block begins at {start:.6f} of axis {axis}, but it stands at {position:.6f}; nothing was moved",
    reaction=Reaction.STOP_ON_PATH,
    remedy="this is an error of the runtime; keep the program and report it",
)
STATE_IN_USE = ErrorEntry(
    306026,
    "another runtime uses the state directory {folder}",
    remedy="stop it, or give this machine a state_directory (and a bus) of its own",
)
CYCLE_LOST = ErrorEntry(
    306027,
    "the runtime has lost its cycle: {reason}; the drives brake by themselves",
    severity=Severity.FATAL,
    remedy="the journal has its last words; start the runtime again, as systemd does by itself",
)
SERVICE_LOST = ErrorEntry(
    306028,
    "the service process has ended: the machine is brought to rest and switched off",
    severity=Severity.FATAL,
    reaction=Reaction.STOP_ON_PATH,
    remedy="the system's journal says how it ended; start the runtime again, as systemd does by itself",
)

# ------------------------------------------------------------------------------------------- beside the path

HOMING_NO_SIGNAL = ErrorEntry(
    306030,
    "axis {axis} cannot be homed: nobody tells when it is on its reference cam",
    reaction=Reaction.STOP_ON_PATH,
    remedy="name an input in the machine description (homing.switch), or let the PLC give reference_cam",
)
HOMING_NO_CAM = ErrorEntry(
    306031,
    "axis {axis} has not found its reference within {way:.1f}",
    reaction=Reaction.STOP_ON_PATH,
    remedy="check the switch and its wiring, the direction, and `homing.way` of the machine description; then reset",
)
NOT_REFERENCED = ErrorEntry(
    306032,
    "the program does not start: axis {axis} has no reference",
    remedy="home it: mode HOMING with the blocks G74 {axis}1",
)
REFERENCE_OTHER_DRIVE = ErrorEntry(
    306047,
    "the reference of axis {axis} is lost: it has another drive than the one that it was found with (object 0x1018)",
    reaction=Reaction.STOP_ON_PATH,
    remedy="home the axis",
)
REFERENCE_MOVED = ErrorEntry(
    306048,
    "the reference of axis {axis} is lost: it stands at {now:.3f} and stood at {before:.3f}, and may be moved by {moved:g}",
    reaction=Reaction.STOP_ON_PATH,
    remedy="home the axis; one that may be moved further without supply needs a greater homing.absolute.moved",
)
TORQUE_LIMIT_UNKNOWN = ErrorEntry(
    306049,
    "the PLC limits the torque of axis {axis}, and its drive gets no torque limit",
    reaction=Reaction.STOP_ON_PATH,
    remedy="name torque_limit in `process_data` of the drive",
)
OFFSET_LEAVES = ErrorEntry(
    306033,
    "the program would take axis {axis}, which stands {offset:.3f} beside the path, over its software limit",
    reaction=Reaction.STOP_ON_PATH,
    remedy="move the axis back by hand, or end manual mode (G202, #CHANNEL INIT [CMDPOS]); then start again",
)
MANUAL_MOVING = ErrorEntry(
    306034,
    "axis {axis} is still moved by hand where manual mode ends",
    reaction=Reaction.STOP_ON_PATH,
    remedy="wait until it stands before G202, or let the way be finished (err_outp_manual_mode_move 0)",
    source="P-CHAN-00437",
)
PARKED_MOVED = ErrorEntry(
    306035,
    "the program moves axis {axis}, which is parked",
    reaction=Reaction.STOP_ON_PATH,
    remedy="take the axis back into use, or leave it out of the program",
)
HOMING_BY_DRIVE = ErrorEntry(
    306036,
    "the drive of axis {axis} has not found its reference: homing method {method} has failed",
    reaction=Reaction.STOP_ON_PATH,
    remedy="check switches and index pulse, whether the drive knows the method (0x6098), and that nothing holds one of two ends "
    "back; then reset",
    source="IEC 61800-7-201, homing mode",
)
HOMING_LATE = ErrorEntry(
    306037,
    "the drive of axis {axis} has not found its reference within {seconds:g} s",
    reaction=Reaction.STOP_ON_PATH,
    remedy="check the switch, the speeds and the direction of the method, or give it more time (`homing.timeout`); then reset",
)
PRE_OUTPUT_LATE = ErrorEntry(
    120815,
    "{letter}{number} would be put out {late:.4f} mm behind its planned place, allowed are {limit:.4f} mm",
    reaction=Reaction.STOP_ON_PATH,
    remedy="give it a shorter lead, program more path in front of it, or raise pre_output_tolerance (P-CHAN-00760)",
    source="channel parameters, line 2437",
)

# ------------------------------------------------------------------------------------------- #ERROR of an NC program

_USER_ERROR = "programming manual, line 15348"
USER_WARNING = ErrorEntry(
    306050, "{text}", severity=Severity.WARNING, reaction=Reaction.NONE, source=_USER_ERROR,
    remedy="a warning of the NC program (#ERROR); the machine's manual explains its number",
)  # fmt: skip
USER_ERROR = ErrorEntry(
    306051, "{text}", reaction=Reaction.STOP_ON_PATH, source=_USER_ERROR,
    remedy="an error of the NC program (#ERROR); the machine's manual explains its number; then reset the channel",
)  # fmt: skip
USER_FATAL = ErrorEntry(
    306052, "{text}", severity=Severity.FATAL, reaction=Reaction.STOP_ON_PATH, source=_USER_ERROR,
    remedy="a fatal error of the NC program (#ERROR): remove its cause and start the runtime again; a reset is not enough",
)  # fmt: skip
RESTART_NEEDED = ErrorEntry(
    306053,
    "the channel stays in error until the runtime is started again: a program has told a fatal error",
    severity=Severity.FATAL,
    reaction=Reaction.NONE,
    remedy="the alarm before this one tells which; remove its cause, then start the runtime again",
)
SECTION_WAITS = ErrorEntry(
    306110,
    "the section of #OPTIONAL EXECUTION cannot be left out: {why}",
    reaction=Reaction.STOP_ON_PATH,
    remedy="a section that is left out in simulated motion has to fit into the motion queue, and nothing in it may wait for the "
    "machine (#FLUSH WAIT, synchronous variables, G74, G200)",
)
DISTANCE_WRONG = ErrorEntry(
    51047,
    "a distance to go was deleted within #DIST TO GO: what is shown to the end of the section is too much",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
    source="programming manual, line 18455",
)
DISTANCE_LATE = ErrorEntry(
    51048,
    "the motion queue is shorter than the section of #DIST TO GO: nothing is shown until its end is known",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
    source="programming manual, line 18462",
)
