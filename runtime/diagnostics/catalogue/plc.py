"""Errors of the PLC program, its process and the HLI."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity

# ------------------------------------------------------------------------------------------- start-up check of the HLI

_INIT_CHECK = "MCV_HliInterface, table of error identifiers"
_REBUILD = "build both sides from the same version; a C program needs a new header (tandem hli header)"

HLI_VERSION = ErrorEntry(
    40015,
    "shared memory {name} has layout version {found}, this program knows {expected}",
    remedy=_REBUILD,
    source=_INIT_CHECK,
)
HLI_CAPACITY = ErrorEntry(
    40016,
    "shared memory {name} has {found} {area} areas, this program expects {expected}",
    remedy=_REBUILD,
    source=_INIT_CHECK,
)
HLI_AXIS_SIZE = ErrorEntry(
    40017,
    "shared memory {name}: an axis area has {found} bytes, this program expects {expected}",
    remedy=_REBUILD,
    source=_INIT_CHECK,
)
HLI_CHANNEL_SIZE = ErrorEntry(
    40018,
    "shared memory {name}: a channel area has {found} bytes, this program expects {expected}",
    remedy=_REBUILD,
    source=_INIT_CHECK,
)
HLI_NO_SHAPE = ErrorEntry(
    40019,
    "shared memory {name} is no HLI of Tandem, or its owner has not finished making it",
    remedy="wait until the runtime has started; check the name",
    source=_INIT_CHECK,
)
HLI_PLATFORM_SIZE = ErrorEntry(
    40022,
    "shared memory {name}: the platform area has {found} bytes, this program expects {expected}",
    remedy=_REBUILD,
    source=_INIT_CHECK,
)
HLI_NOT_RUNNING = ErrorEntry(
    304001,
    "no runtime named {name} is running on this computer",
    remedy="start one (tandem run), or give its name (--name)",
)
HLI_NO_ACCESS = ErrorEntry(
    304002,
    "no access to shared memory {name}: it belongs to another user",
    remedy="join the group of the runtime, or become its user",
)
HLI_NAME = ErrorEntry(
    304003,
    "{name!r} is no name of a shared memory",
    remedy="use letters, digits, '_', '-' and '.' only",
)
HLI_LAYOUT = ErrorEntry(
    304004,
    "shared memory {name} has another layout (hash {found}, this program {expected})",
    remedy=_REBUILD,
)
HLI_ALREADY_RUNS = ErrorEntry(
    304005,
    "a runtime named {name} already runs (process {pid})",
    remedy="stop it, or start this one under another name",
)
HLI_NO_ELEMENT = ErrorEntry(
    304006,
    "the HLI has no element {path}: {part} is not among {known}",
    remedy="tandem hli show prints everything",
)

# ------------------------------------------------------------------------------------------- operating modes

MODE_NOT_AVAILABLE = ErrorEntry(
    304010,
    "there is no operating mode {mode}",
    remedy="select STANDBY, AUTOMATIC, MDI, MANUAL or HOMING (1 to 5)",
)
MODE_TRANSITION = ErrorEntry(
    304011,
    "channel is in {mode} {state}: there is no way to {to_mode} {to_state}",
    severity=Severity.WARNING,
    remedy="see the states of the operating modes; reset leads back to the basic state",
)
MODE_NO_PROGRAM = ErrorEntry(
    304012,
    "no NC program is loaded and the order names none",
    remedy="name the program to start, or in MDI the NC blocks",
)
MODE_FROM = ErrorEntry(
    304013,
    "order expects {from_mode} {from_state}, but the channel is in {mode} {state}; it is not carried out",
    severity=Severity.WARNING,
    remedy="look at the state and order again, or leave the start state open (0)",
)
MODE_PROGRAM_RUNS = ErrorEntry(
    304014,
    "a program is {state}; {what} is not possible now",
    severity=Severity.WARNING,
    remedy="stop the program first, or wait for its end",
)
MODE_NOT_AGREED = ErrorEntry(
    306320,
    "a reset came before the PLC had agreed to mode {mode}",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
    remedy="see what the PLC program waits for before it agrees, then order the mode again",
)
MODE_RESET_FIRST = ErrorEntry(
    304015,
    "channel is in ERROR; only a reset leads on",
    severity=Severity.WARNING,
    remedy="remove the cause and reset the channel",
)
OPERATOR_NO_ANSWER = ErrorEntry(
    304016,
    "the runtime {name} has not taken the order within {seconds} s",
    remedy="is its cycle running? (tandem hli watch); has the PLC claimed the unit and not answered?",
)

MODE_MANUAL_TEXT = ErrorEntry(
    304017,
    "the NC blocks of MANUAL do not end with G200",
    severity=Severity.WARNING,
    remedy="end them with a block G200, or leave them out: G200 alone is the default",
    source="programming manual, line 6020",
)
MANUAL_NOT_NOW = ErrorEntry(
    150048,
    "axis {axis} cannot be linked to a control element now",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
    remedy="select MANUAL, or release the axis by G200 or G201 in the program",
    source="HLI, activation of control elements",
)
MANUAL_VALUE = ErrorEntry(
    304018,
    "manual mode of axis {axis}: {what} {value} is not possible",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
    remedy="key pairs are 1 to 32, handwheels 1 to 8, modes 1 to 4, parameter sets 0 to 3; 0 takes the element away",
)

# ------------------------------------------------------------------------------------------- the PLC and its program

PLC_WATCHDOG = ErrorEntry(
    270053,
    "the PLC gave no sign of life for {milliseconds} ms (allowed {allowed} ms)",
    reaction=Reaction.STOP_ON_PATH,
    remedy="look for an endless loop or a stopped process of the PLC; then restart the PLC and reset",
    source="watchdog mechanism of the HLI",
)
PLC_LOGGED_OFF = ErrorEntry(
    304019,
    "the PLC has ended while the machine runs",
    reaction=Reaction.STOP_ON_PATH,
    remedy="reset the channel to start it again",
)
PLC_MODULE_MISSING = ErrorEntry(
    304020,
    "PLC program {program}: {what}",
    remedy='write "file.py" (beside the machine description) or "package.module:Class"; check the spelling',
)
PLC_SYNTAX = ErrorEntry(
    304021,
    "PLC program {program} has a syntax error: {what}",
    remedy="correct the line",
)
PLC_NO_PROGRAM = ErrorEntry(
    304022,
    "PLC program {program} contains no subclass of Program",
    remedy="from runtime.plc_logic import Program, and derive one class from it",
)
PLC_SEVERAL_PROGRAMS = ErrorEntry(
    304023,
    "PLC program {program} contains several programs: {names}",
    remedy='name one of them: "{program}:{first}"',
)
PLC_IMPORT_RAISED = ErrorEntry(
    304024,
    "PLC program {program} cannot be loaded: {what}",
    remedy="the traceback shows the line",
)
PLC_SETUP_RAISED = ErrorEntry(
    304025,
    "setup() of PLC program {program} failed: {what}",
    remedy="the traceback shows the line",
)
PLC_RAISED = ErrorEntry(
    304026,
    "PLC program {program} failed: {what}",
    reaction=Reaction.STOP_ON_PATH,
    remedy="correct the program, restart the PLC, then reset the channel",
)
PLC_HANDLER_RESULT = ErrorEntry(
    304027,
    "{handler} returned {result!r} for {function}; a handler returns True when it is finished, False while it is not",
    reaction=Reaction.STOP_ON_PATH,
    remedy="end the handler with a return of True or False on every way through it",
)
PLC_TWO_HANDLERS = ErrorEntry(
    304028,
    "{program}: {first} and {second} both handle {function}",
    remedy="give each function one handler",
)
PLC_NO_HANDLER = ErrorEntry(
    304029,
    "PLC program has no handler for {function} (line {line}); it stays unacknowledged and the path waits",
    remedy="write a handler (@m_function and so on) or take the function out of the channel parameters; then reset",
)
PLC_NO_HANDLER_MOS = ErrorEntry(
    304030,
    "PLC program has no handler for {function} (line {line})",
    severity=Severity.WARNING,
    remedy="write a handler, or set its synchronisation to NO_SYNCH",
)
PLC_ALARM = ErrorEntry(304031, "{text}", reaction=Reaction.NONE)
PLC_WARNING = ErrorEntry(304032, "{text}", severity=Severity.WARNING, reaction=Reaction.NONE)
PLC_MESSAGE = ErrorEntry(304033, "{text}", severity=Severity.MESSAGE, reaction=Reaction.NONE)
PLC_IO_NAME = ErrorEntry(
    304034,
    "the machine has no input or output {name}; known: {known}",
    reaction=Reaction.STOP_ON_PATH,
    remedy="name it in the machine description (fieldbus.io) or correct the spelling",
)
PLC_INPUT_ASSIGNED = ErrorEntry(
    304035,
    "{name} is an input; the PLC program cannot set it",
    reaction=Reaction.STOP_ON_PATH,
    remedy="inputs are only read",
)
PLC_VALUE = ErrorEntry(
    304037,
    "the analogue output {name} cannot be {value}",
    remedy="assign a finite number in the unit of the machine description",
)
PLC_NAME = ErrorEntry(
    304036,
    "the machine has no {kind} {name}; known: {known}",
    reaction=Reaction.STOP_ON_PATH,
    remedy="use a name of the machine description",
)

# ------------------------------------------------------------------------------------------- external variables

EXTERNAL_NOT_LAID_OUT = ErrorEntry(
    304050,
    "external variable {path} does not fit into the area of {bytes} bytes and {names} names",
    remedy="correct its type, size, dimensions and place in the description of the external variables",
)
PLC_EXTERNAL_NAME = ErrorEntry(
    304051,
    "there is no external variable V.E.{path}; known: {known}",
    reaction=Reaction.STOP_ON_PATH,
    remedy="name it in the description of the external variables or correct the spelling",
)
PLC_EXTERNAL_VALUE = ErrorEntry(
    304052,
    "V.E.{path} of type {kind} cannot be {value!r}",
    reaction=Reaction.STOP_ON_PATH,
    remedy="texts belong to STRING, numbers to all other types; arrays and structures are set element by element",
)
PLC_EXTERNAL_INDEX = ErrorEntry(
    304053,
    "V.E.{path} has no element {index}; indices go from 0 to {last}",
    reaction=Reaction.STOP_ON_PATH,
    remedy="correct the index, or the dimensions in the description",
)

# ------------------------------------------------------------------------------------------- the PLC library

PLC_CONVERSION = ErrorEntry(
    304060,
    "{value!r} is no {kind}: {why}",
    reaction=Reaction.STOP_ON_PATH,
    remedy="limit or check the value before it is converted",
)
PLC_ARGUMENT = ErrorEntry(
    304061,
    "{function}: {what}",
    reaction=Reaction.STOP_ON_PATH,
    remedy="check the arguments of the function before it is called",
)

# ------------------------------------------------------------------------------------------- retained variables

PLC_RETAIN_VALUE = ErrorEntry(
    304062,
    "retained variable {name} of kind {kind} cannot be {value!r}",
    reaction=Reaction.STOP_ON_PATH,
    remedy="give it a value of the kind it was declared with; lists and dictionaries hold numbers, texts and BOOL",
)
PLC_RETAIN_KIND = ErrorEntry(
    304063,
    "retained variable {name} was {value!r}, which is no {kind}: it begins with its initial value",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
    remedy="its declaration has changed; set it again",
)
PLC_RETAIN_TORN = ErrorEntry(
    304064,
    "the end of {file} is torn, by a power loss or a fault of the disk: its last whole record counts",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
    remedy="check what the program has counted last",
)
PLC_RETAIN_NOT_WRITTEN = ErrorEntry(
    304065,
    "retained variables cannot be written to {file}: {reason}",
    severity=Severity.ERROR,
    reaction=Reaction.NONE,
    remedy="make room on the disk and check the rights of the folder; it is tried again",
)

# ------------------------------------------------------------------------------------------- image, online change

PLC_IO_DIRECTION = ErrorEntry(
    304066,
    "{name} is declared as {declared}, but the machine has it as {found}",
    reaction=Reaction.STOP_ON_PATH,
    remedy="correct the declaration of the image, or the machine description (fieldbus.io)",
)
PLC_RELOAD_BUSY = ErrorEntry(
    304067,
    "PLC program {program} is not replaced: {functions} was being carried out for longer than {seconds:.0f} s",
    remedy="wait until the sequence has ended, or reset the channel, and reload again",
)
PLC_RELOAD_STATE = ErrorEntry(
    304068,
    "PLC program {program} is not replaced: the state of the old one does not fit into it: {what}",
    remedy="restart the PLC to begin with initial values",
)
PLC_RELOAD_RAISED = ErrorEntry(
    304069,
    "PLC program {program} is not replaced: its first cycle failed: {what}",
    remedy="the old program goes on; correct the new one and reload again",
)
PLC_NOT_RELOADABLE = ErrorEntry(
    304070,
    "there is no running PLC program to replace on {name}",
    remedy="a reset of the channel starts the program, with what its file contains now",
)
PLC_RELOAD_NO_ANSWER = ErrorEntry(
    304071,
    "the PLC of {name} has not answered within {seconds:.0f} s",
    remedy="is it running? (tandem hli watch)",
)
