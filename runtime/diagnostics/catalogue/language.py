"""Errors of NC programs: reading, decoding, variables, subprograms."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity

# -- files and program structure -----------------------------------------------------------------------------------

FILE_MISSING = ErrorEntry(300001, "program file {file} does not exist", remedy="check the name and the program paths")
FILE_UNREADABLE = ErrorEntry(300002, "program file {file} cannot be read: {reason}", remedy="check its access rights")
FILE_EMPTY = ErrorEntry(300003, "program {file} is empty", remedy="a program needs at least one block")
FILE_BINARY = ErrorEntry(
    300004,
    "{file} is not a text file (byte 0x{byte:02X} at offset {offset})",
    remedy="NC programs are ASCII text",
)
FILE_CHANGED = ErrorEntry(
    300005,
    "program file {file} was changed while it was being executed",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="start the program again",
)
MAIN_MISSING = ErrorEntry(
    300006, "{file} holds no main program", remedy="add a main program: % and a name, behind the local subprograms"
)
DIALECT_UNSUPPORTED = ErrorEntry(
    300007, "dialect {dialect} is not supported yet", remedy="programs can be written in: {supported}"
)
HEADER_INVALID = ErrorEntry(
    300008, "{text!r} is not allowed behind the program name", remedy="only a comment may follow the name"
)
HEADER_NAME = ErrorEntry(300009, "%L needs the name of the local subprogram", remedy="write %L NAME")
HEADER_LATE = ErrorEntry(
    300010,
    "definition of {name!r} behind the start of the main program",
    remedy="local subprograms and the line % NAME stand before the first block of the main program",
)
LOCAL_TWICE = ErrorEntry(300011, "local subprogram {name!r} is defined twice, first in line {first}")
LOCAL_MISSING = ErrorEntry(
    300012,
    "local subprogram {name!r} is not defined in this file",
    remedy="define it with %L {name} before the main program, or call a file with L",
)
GLOBAL_MISSING = ErrorEntry(
    300013,
    "file of global subprogram {name!r} not found in: {paths}",
    remedy="give the whole file name with extension, or add its folder to program_paths",
)

# -- characters and words ------------------------------------------------------------------------------------------

BLOCK_TOO_LONG = ErrorEntry(
    300020,
    "block is longer than {limit} characters",
    remedy="split it, or shorten its comments",
    source="programming manual line 1121",
)
CHARACTER_INVALID = ErrorEntry(
    300021, "character {character!r} is not allowed outside comments", remedy="NC programs are ASCII text"
)
SYNTAX = ErrorEntry(300022, "{found!r} is not understood here", remedy="check the spelling and the word before it")
BRACKET_OPEN = ErrorEntry(300023, "'[' has no matching ']'", remedy="close the bracket in the same block")
BRACKET_CLOSE = ErrorEntry(300024, "']' has no matching '['")
COMMENT_OPEN = ErrorEntry(
    300025,
    "inner '(' of a comment has no matching ')'",
    remedy="close the inner comment; only the outermost one may end with the line",
)
COMMENT_CLOSE = ErrorEntry(300026, "')' without '('", remedy="expressions are bracketed with [ and ]")
VALUE_MISSING = ErrorEntry(300027, "{address} has no value", remedy="a number or an expression must follow")
ADDRESS_UNKNOWN = ErrorEntry(
    300028, "address {address!r} is not known", remedy="axes of this channel: {axes}; upper and lower case differ"
)
AXIS_UNKNOWN = ErrorEntry(
    300030,
    "axis {axis!r} is not an axis of this channel",
    remedy="axes: {axes}; a blank separates a word from a following one with '='",
)
SPINDLE_UNKNOWN = ErrorEntry(
    300031, "spindle {spindle!r} is not a spindle of this channel", remedy="spindles: {spindles}"
)
G_UNKNOWN = ErrorEntry(300032, "G{number} is not a G function")
G_UNSUPPORTED = ErrorEntry(300033, "G{number} is not supported yet")
G_GROUP_TWICE = ErrorEntry(
    300034, "G{number} and G{other} exclude each other in a block ({group})", remedy="write one of them"
)
G_VALUE = ErrorEntry(300035, "G{number} takes no value with '='")
G_VALUE_MISSING = ErrorEntry(300036, "G{number} needs a value: G{number}=..")
WORD_TWICE = ErrorEntry(300037, "{address} stands twice in the block")
NOT_ALONE = ErrorEntry(300038, "{word} must be alone in its block", remedy="only a block number may stand beside it")
CONTROL_UNKNOWN = ErrorEntry(300039, "{statement} is not a control statement")
CONTROL_PLACE = ErrorEntry(
    300040, "{statement} must be the only statement of its block", remedy="only / and N may stand before it"
)
NOT_SUPPORTED = ErrorEntry(300041, "{what} is not supported yet")
SKIP_LEVEL = ErrorEntry(300042, "skip level {level} does not exist", remedy="levels are 1 to 10")
CONTROL_WITHOUT_START = ErrorEntry(300043, "{statement} without {start}")
CONTROL_OPEN = ErrorEntry(300044, "{statement} is not closed by {end}", remedy="add {end}")
CONTROL_DEPTH = ErrorEntry(300045, "control statements are nested deeper than {limit}")
CONTROL_INCOMPLETE = ErrorEntry(
    300046,
    "{statement} is incomplete",
    remedy="$FOR P1 = start, end, step; $IF and $WHILE take a condition, $GOTO a label",
)

# -- expressions ---------------------------------------------------------------------------------------------------

NUMBER_RANGE = ErrorEntry(
    300050,
    "number {text} is outside the allowed range of ±{limit:.0f}",
    source="programming manual line 1356",
)
LITERAL_BASE = ErrorEntry(
    300051, "{text} is not a number", remedy="hexadecimal '16#1F' '0x1F' 'H1F', binary '2#101' 'B101', octal '8#17'"
)
EXPRESSION_DEPTH = ErrorEntry(300052, "expression is nested deeper than {limit} brackets", remedy="use P parameters")
FUNCTION_UNKNOWN = ErrorEntry(300053, "function {function} is not known")
FUNCTION_ARGUMENTS = ErrorEntry(300054, "{function} takes {expected} arguments, not {given}")
DIVISION_BY_ZERO = ErrorEntry(300055, "division by zero", reaction=Reaction.STOP_AT_BLOCK_END)
DOMAIN = ErrorEntry(
    300056,
    "{name} is not defined for {value:.9g}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual lines 1458, 1551",
)
RESULT_RANGE = ErrorEntry(
    300057, "result {value:.9g} of {name} is outside the allowed range", reaction=Reaction.STOP_AT_BLOCK_END
)
OPERAND_NEGATIVE = ErrorEntry(
    300058,
    "{name} allows no operand outside 0 to 4294967295, but got {value:.9g}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual lines 1470, 1485",
)
PARAMETER_UNSET = ErrorEntry(
    300059,
    "{name} is read before it has a value",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="assign it first, or ask with EXIST[{name}]",
)
PARAMETER_INDEX = ErrorEntry(
    300060,
    "{value:.9g} is no number of a P parameter",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="numbers are integers from 1 on",
    source="programming manual line 8105",
)

# -- M, H, S, T ----------------------------------------------------------------------------------------------------

M_UNDEFINED = ErrorEntry(
    300070, "M{number} is not configured", remedy="give m_synch[{number}] a synchronisation type", source="P-CHAN-00041"
)
H_UNDEFINED = ErrorEntry(
    300071, "H{number} is not configured", remedy="give h_synch[{number}] a synchronisation type", source="P-CHAN-00027"
)
FUNCTION_NEGATIVE = ErrorEntry(300072, "number {value:.9g} of the {address} function is negative")
SPINDLE_MISSING = ErrorEntry(
    300073, "{word} needs a spindle, but the channel has none", remedy="configure spindel[0] of the channel"
)
VALUE_NOT_ALLOWED = ErrorEntry(300074, "M{number} takes no additional value", source="programming manual line 6823")
SPINDLE_M_TWICE = ErrorEntry(300075, "M{number} and M{other} exclude each other in a block")
SPEED_NEGATIVE = ErrorEntry(300076, "spindle speed {value:.9g} is negative", reaction=Reaction.STOP_AT_BLOCK_END)
SYNCH_UNKNOWN = ErrorEntry(
    300077, "{parameter}: {text!r} is not a synchronisation type", remedy="known are {known}, or a hexadecimal value"
)
SYNCH_NOT_ONE = ErrorEntry(
    300078,
    "{parameter}: {text!r} is not one synchronisation type, with flags beside it or without",
    remedy="types are {supported}",
)
SPINDLE_LOCKED = ErrorEntry(
    300079, "{word} is locked by synchronisation type NOT_VALID", remedy="configure its synchronisation type"
)

SPINDLE_NO_SYNCH = ErrorEntry(
    300084,
    "{word} has no synchronisation type: with NO_SYNCH it would not be executed",
    remedy="give it one in spindel[] of the channel parameters, MOS if the path need not wait",
)

# -- execution -----------------------------------------------------------------------------------------------------

CALL_DEPTH = ErrorEntry(
    300080,
    "subprograms are nested deeper than {limit} levels (call of {name!r})",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="does a subprogram call itself without end?",
    source="channel parameters line 7555",
)
ENDLESS_LOOP = ErrorEntry(
    300081,
    "{count} blocks were executed without motion or output: endless loop",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="check the condition of the loop",
)
END_IN_SUBPROGRAM = ErrorEntry(
    300082, "M{number} in subprogram {name!r} ends the whole program", Severity.WARNING, Reaction.NONE
)
STEP_ZERO = ErrorEntry(300083, "$FOR with step 0 is an endless loop", Severity.WARNING, Reaction.NONE)

# -- motion --------------------------------------------------------------------------------------------------------

FEED_MISSING = ErrorEntry(
    300090,
    "G0{motion} without a feed",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="program F before or in this block",
)
FEED_INVALID = ErrorEntry(
    300091, "feed F{value:.9g} must be above 0", reaction=Reaction.STOP_AT_BLOCK_END, remedy="program an F above 0"
)
POSITION_RANGE = ErrorEntry(
    300092,
    "target {value:.9g} of axis {axis} is outside ±{limit:.0f}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual line 1974",
)
CENTRE_MISSING = ErrorEntry(
    300093,
    "G0{motion} without a circle centre or radius",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="program {letters} or R",
)
RADIUS_TOO_SMALL = ErrorEntry(
    300094,
    "radius {radius:.6g} mm is too small: the target is {distance:.6g} mm away, so at least {needed:.6g} mm are needed",
    reaction=Reaction.STOP_AT_BLOCK_END,
)
RADIUS_FULL_CIRCLE = ErrorEntry(
    300095,
    "start and target are equal, a full circle cannot be programmed by radius",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="program the centre with {letters}",
    source="programming manual line 2412",
)
CENTRE_DEVIATION = ErrorEntry(
    20035,
    "circle centre would have to move by {shift:.6g} mm to fit start and target, allowed are {limit:.6g} mm",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="check {letters}, the target, and G161/G162",
    source="programming manual line 19635; P-CHAN-00059, P-CHAN-00060",
)
RADIUS_ZERO = ErrorEntry(300097, "the circle has radius 0", reaction=Reaction.STOP_AT_BLOCK_END)
RADIUS_RANGE = ErrorEntry(
    300098,
    "circle radius {radius:.6g} mm is above {limit:.0f} mm",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual line 1979",
)
CENTRE_AND_RADIUS = ErrorEntry(
    300099, "circle centre and radius in one block", reaction=Reaction.STOP_AT_BLOCK_END, remedy="program one of them"
)
CENTRE_WITHOUT_CIRCLE = ErrorEntry(
    300100,
    "{letter} has no meaning with G0{motion}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="I, J, K belong to G02 and G03",
)
PITCH_INVALID = ErrorEntry(
    300101, "pitch {letter} {value:.9g} of the helix must be above 0", reaction=Reaction.STOP_AT_BLOCK_END
)
PLANE_UNAVAILABLE = ErrorEntry(
    300102,
    "G{plane} needs {needed} main axes, the channel has {axes}",
    reaction=Reaction.STOP_AT_BLOCK_END,
)
DWELL_NEGATIVE = ErrorEntry(300103, "dwell time {value:.9g} is negative", reaction=Reaction.STOP_AT_BLOCK_END)
DWELL_SPEED = ErrorEntry(
    300104,
    "dwell by spindle revolutions needs a spindle speed",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="program S before",
)
DWELL_AXIS = ErrorEntry(
    300105, "G04 takes the time with the first main axis {axis} or without an address, not with {address}"
)

# -- strings -------------------------------------------------------------------------------------------------------

STRING_NOT_ALLOWED = ErrorEntry(300110, "{what} needs a number, not a string", reaction=Reaction.STOP_AT_BLOCK_END)
NUMBER_NOT_ALLOWED = ErrorEntry(300111, "{what} needs a string, not a number", reaction=Reaction.STOP_AT_BLOCK_END)
KINDS_MIXED = ErrorEntry(
    300112,
    "{operator} cannot join a string with a number",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="convert one of them: INT_TO_STR, REAL_TO_STR, STR_TO_INT, STR_TO_REAL",
)
STRING_POSITION = ErrorEntry(
    300113, "{value:.9g} is no position or count in the string of {name}", reaction=Reaction.STOP_AT_BLOCK_END
)
STRING_TOO_LONG = ErrorEntry(
    300114, "the string of {name} is longer than {limit} characters", reaction=Reaction.STOP_AT_BLOCK_END
)
STRING_NO_NUMBER = ErrorEntry(300115, "{text!r} is not a number ({name})", reaction=Reaction.STOP_AT_BLOCK_END)
ORD_POSITION = ErrorEntry(
    21545,
    "ORD: position {value:.9g} lies beyond the string",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual line 1660",
)
MACRO_UNDEFINED = ErrorEntry(
    300120,
    'macro or string "{name}" is not understood here',
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy='define the macro before: "{name}" = "..."',
)
MACRO_DEPTH = ErrorEntry(
    300121, 'macro "{name}" calls itself or is nested deeper than {limit}', reaction=Reaction.STOP_AT_BLOCK_END
)
MACRO_CONTENT = ErrorEntry(
    300122,
    'macro "{name}" may not contain {what}',
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual 26133",
)
MACRO_LIMIT = ErrorEntry(
    300123,
    'macro "{name}": {what} is above the limit of {limit}',
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="P-CHAN-00509",
)
STATEMENT_UNKNOWN = ErrorEntry(300130, "#{name} is not a statement", remedy="check the spelling; tandem lang lists all")
STATEMENT_UNSUPPORTED = ErrorEntry(300137, "statement #{name} is not supported yet")
STATEMENT_BLANK = ErrorEntry(
    300131, "no blank may stand between # and the keyword", source="programming manual line 11058"
)
KEY_UNKNOWN = ErrorEntry(300132, "{key!r} is no argument of {statement}", remedy="arguments: {known}")
KEY_TWICE = ErrorEntry(300133, "{key} stands twice in {statement}")
KEY_MISSING = ErrorEntry(300134, "{statement} needs {key}", remedy="written as: {syntax}")
STATEMENT_ARGUMENTS = ErrorEntry(300135, "{found!r} is not understood in {statement}", remedy="written as: {syntax}")
WORD_UNKNOWN = ErrorEntry(300136, "{word!r} is no value of {key}", remedy="values: {known}")
VARIABLE_UNKNOWN = ErrorEntry(
    300140, "variable {name} is not known", reaction=Reaction.STOP_AT_BLOCK_END, remedy="{hint}"
)
VARIABLE_READ_ONLY = ErrorEntry(300141, "variable {name} can only be read", reaction=Reaction.STOP_AT_BLOCK_END)
VARIABLE_UNSET = ErrorEntry(
    300142,
    "variable {name} does not exist",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="declare it in #VAR … #ENDVAR or assign it first, or ask with EXIST[{name}]",
)
ARRAY_INDEX = ErrorEntry(300143, "index {value:.9g} of {name} is outside 0…{last}", reaction=Reaction.STOP_AT_BLOCK_END)
ARRAY_NEEDED = ErrorEntry(300144, "{name} is no array with {given} dimensions", reaction=Reaction.STOP_AT_BLOCK_END)
LABEL_MISSING = ErrorEntry(
    20840,
    "label {label} does not exist in this program level",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="P-ERR-20840",
)
JUMP_INTO_LOOP = ErrorEntry(
    300150,
    "$GOTO jumps into the loop that begins in line {line}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual line 8562",
)
OUTSIDE_LOOP = ErrorEntry(300151, "{statement} stands outside {where}", reaction=Reaction.STOP_AT_BLOCK_END)
COMMENT_BLOCK_OPEN = ErrorEntry(300152, "#COMMENT BEGIN has no #COMMENT END", remedy="add #COMMENT END")
COMMENT_BLOCK_END = ErrorEntry(300153, "#COMMENT END without #COMMENT BEGIN")
CONTINUATION = ErrorEntry(
    300154,
    "a # statement cannot go on in the next line",
    remedy="write it in one line",
    source="programming manual line 1271",
)
TYPE_INVALID = ErrorEntry(
    300145,
    "{type} is no data type",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="BOOLEAN, SGN08, UNS08, SGN16, UNS16, SGN32, UNS32, REAL64, STRING[0…126]",
)
ARRAY_DIMENSIONS = ErrorEntry(300146, "{name} has more than {limit} dimensions", reaction=Reaction.STOP_AT_BLOCK_END)
ARRAY_SIZE = ErrorEntry(
    300147,
    "the sizes of {name} are not possible",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="every dimension from 1 on, at most {limit} elements in all",
)
ARRAY_VALUES = ErrorEntry(
    300148, "{name} has {given} initial values, but only {count} elements", reaction=Reaction.STOP_AT_BLOCK_END
)
VARIABLE_LIMIT = ErrorEntry(
    300149, "{name}: more than {limit} variables of this kind", reaction=Reaction.STOP_AT_BLOCK_END
)
DECLARATION_PLACE = ErrorEntry(
    300155,
    "{name} is declared outside #VAR … #ENDVAR",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="put the declaration between #VAR and #ENDVAR",
)
DELETE_HIGHER = ErrorEntry(
    20933,
    "{name} was made on a higher program level and cannot be deleted here",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual line 22118",
)
TRANSFER_OUTSIDE = ErrorEntry(
    300156,
    "{name} can only be used in a cycle",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual line 7343",
)
TRANSFER_MISSING = ErrorEntry(
    20394,
    "transfer parameter {name} was not given in the call",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="P-CHAN-00463",
)
AXIS_ARGUMENT = ErrorEntry(300157, "G{number} needs axis words", reaction=Reaction.STOP_AT_BLOCK_END)
RETURN_TARGET = ErrorEntry(300158, "{text!r} is not understood behind M17 or M29")
CALL_FILE = ErrorEntry(
    20131,
    "no program is assigned to {word}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="configure it, or assign one with #FILE NAME",
)
FEED_SPINDLE = ErrorEntry(
    300106,
    "feed per revolution needs a spindle speed",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="program S before",
)
FEED_PERCENT = ErrorEntry(
    300107,
    "G194 takes less than 100 percent, not {value:.9g}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual line 5260",
)
END_FEED_MODE = ErrorEntry(
    300108, "E works only with G94", reaction=Reaction.STOP_AT_BLOCK_END, source="programming manual line 6922"
)
CORNER_WITHOUT_MOTION = ErrorEntry(
    300109, "a chamfer or rounding needs the motion that it belongs to", reaction=Reaction.STOP_AT_BLOCK_END
)

# -- variables, macros and strings ---------------------------------------------------------------------------------

VARIABLE_UNSUPPORTED = ErrorEntry(
    300200, "variable {name} ({purpose}) is not supported yet", reaction=Reaction.STOP_AT_BLOCK_END
)
SETS_MIXED = ErrorEntry(
    300201,
    "{name}: whole sets of values (.ALL) cannot be combined with single values",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="only + and - between sets; change single axes in an assignment of their own",
    source="programming manual line 4690",
)
SET_INDEX = ErrorEntry(
    300202,
    "index {value:.9g} of {name} is not between {first} and {last}",
    reaction=Reaction.STOP_AT_BLOCK_END,
)
CYCLE_MEMORY = ErrorEntry(
    300203,
    "{name} does not fit into the {limit} bytes of the V.CYC variables",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="delete some, or raise configuration.decoder.var_memory",
    source="P-CHAN-00418",
)
SYNCH_VALUE = ErrorEntry(
    300204,
    "{name}: {value} is no synchronisation type that can be used",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="P-CHAN-00041",
)
FUNCTION_NOT_CONFIGURED = ErrorEntry(
    300205,
    "{name}: {letter}{number} is not configured",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="give {letter}{number} a synchronisation type in the channel parameters",
)
VERSION_FORM = ErrorEntry(
    22015,
    "{text!r} is no program version",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="write <major>.<minor>.<build>.<patch>, each 0 to 255",
    source="programming manual line 21557",
)
FUNCTION_UNSUPPORTED = ErrorEntry(300208, "{function} is not supported: {reason}")
G_NUMBER = ErrorEntry(
    300209, "the number of a G function is a plain number, not {text!r}", remedy="write the number itself"
)

LIMIT_MISSING = ErrorEntry(
    300229, "{name}: axis {axis} has no such software limit", reaction=Reaction.STOP_AT_BLOCK_END
)

# -- messages, errors, timers --------------------------------------------------------------------------------------

MESSAGE_MARKS = ErrorEntry(
    300210,
    "{statement} has {marks} format elements, but {values} values",
    remedy="a percent sign itself is written %%",
    source="programming manual line 13403",
)
MESSAGE_VALUES = ErrorEntry(300211, "{statement} takes at most {limit} values", source="programming manual line 13403")
MESSAGE_MARK = ErrorEntry(
    300212, "{mark!r} is no format element", remedy="format elements: %d, %u, %f, %s, and %% for a percent sign"
)
MESSAGE_VALUE = ErrorEntry(
    300213,
    "{mark} of {statement} takes {wanted}, not {given}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual line 13395",
)
MESSAGE_MODE = ErrorEntry(
    300214,
    "{word} cannot stand here in {statement}",
    remedy="written as: {syntax}",
    source="programming manual line 13327",
)
ERROR_VALUE = ErrorEntry(
    300215,
    "{key} of #ERROR is {value}, allowed is {allowed}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual line 15348",
)
TIMER_NUMBER = ErrorEntry(
    300216,
    "#TIMER has no counter {value:.9g}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="counters are 0 to {last}, and one of them is named: ID=..",
    source="programming manual line 15524",
)

# -- files ---------------------------------------------------------------------------------------------------------

FILE_OUTSIDE = ErrorEntry(
    300220,
    "file {file!r} lies outside the folders of the channel",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="programs reach files in: {folders}",
)
FILE_NAME_INVALID = ErrorEntry(300221, "{file!r} is no file name", reaction=Reaction.STOP_AT_BLOCK_END)
FILE_NOT_FOUND = ErrorEntry(300222, "file {file!r} not found in: {folders}", reaction=Reaction.STOP_AT_BLOCK_END)
FILE_TARGET_FOLDER = ErrorEntry(
    300223, "folder of the new file {file!r} does not exist", reaction=Reaction.STOP_AT_BLOCK_END
)
FILE_THERE = ErrorEntry(
    300224,
    "file {file!r} exists already",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="OVRMODE=1 allows to overwrite it",
)
FILE_IN_USE = ErrorEntry(300225, "file {file!r} belongs to the running program", reaction=Reaction.STOP_AT_BLOCK_END)
FILE_PROTECTED = ErrorEntry(
    21627,
    "file {file!r} is protected against writing",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual line 16264",
)
FILE_REFUSED = ErrorEntry(
    300226,
    "file {file!r}: {reason}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="check the access rights of its folder",
)
OVERWRITE_MODE = ErrorEntry(300227, "OVRMODE is 0 or 1, not {value:.9g}", reaction=Reaction.STOP_AT_BLOCK_END)
BACKUP_COUNT = ErrorEntry(
    300228, "{key} is {value:.9g}: a whole number from 0 on is needed", reaction=Reaction.STOP_AT_BLOCK_END
)

# -- corners and contour lines -------------------------------------------------------------------------------------

CORNER_SIZE = ErrorEntry(
    300400,
    "size {size:.6g} of the {what} must be above 0",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual line 5305",
)
CORNER_TOO_LARGE = ErrorEntry(
    300401,
    "{what} of {size:.6g} mm does not fit between this motion and the one in line {next_line}: at most {largest:.6g} mm",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="make it smaller, or the shorter of both motions longer",
    source="programming manual line 5482",
)
CORNER_OPEN = ErrorEntry(
    300402,
    "no motion follows the {what} before the end of the program",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="a chamfer or rounding stands between two motions: program the second one, or leave it out",
    source="programming manual line 5301",
)
CORNER_DIRECTION = ErrorEntry(
    300403,
    "{what}: the motion in line {line} has no way in the plane of axes {plane}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="both motions beside it must move in the plane of the second one, and more than earlier chamfers and "
    "roundings take away",
)
CORNER_REVERSAL = ErrorEntry(
    300404,
    "{what}: the motion in line {next_line} goes back the way this one came",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="there is no corner to work on: leave the {what} out, or check the targets",
)
CORNER_NEIGHBOUR = ErrorEntry(
    300405,
    "{what}: {reason}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="it can stand between lines, and arcs of the plane of the second motion",
    source="programming manual lines 5301, 5367",
)
CORNER_WAIT = ErrorEntry(
    300406,
    "the program waits for the path (line {wait_line}) before the motion behind the {what} is known",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="move #FLUSH WAIT, or what reads current values, out of the corner",
)
CORNER_TANGENTIAL = ErrorEntry(
    300407,
    "nothing is inserted for the {what}: the motion in line {next_line} goes on in the same direction",
    Severity.WARNING,
    Reaction.NONE,
    source="programming manual line 5525",
)
CONTOUR_LINE_UNREACHABLE = ErrorEntry(
    300410,
    "{target} cannot be reached from the start point under {angle:.6g} degrees",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="the angle counts from the first axis of the plane to the second; the target lies ahead in this direction",
    source="programming manual line 2776",
)
CONTOUR_LINE_PARALLEL = ErrorEntry(
    300411,
    "contour lines under {first:.6g} and {second:.6g} degrees are parallel and do not meet in one point",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="check both angles",
)
CONTOUR_LINE_UNDETERMINED = ErrorEntry(
    300412,
    "the contour line under {angle:.6g} degrees has no target",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="program a coordinate with #ANG, or a second contour line in the next motion block",
    source="programming manual line 2883",
)
CONTOUR_LINE_OVERDETERMINED = ErrorEntry(
    300413,
    "angle {angle:.6g} and target of the contour line contradict: the target lies {distance:.6g} mm beside it",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="program the angle and one coordinate",
)
CONTOUR_LINE_INCREMENTAL = ErrorEntry(
    300414,
    "the target of the second contour line must be absolute",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="program G90: the corner before it is not known yet",
    source="programming manual line 2822",
)
ARC_POINTS_EQUAL = ErrorEntry(
    300416,
    "{first} and {second} of the arc in space are the same point",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="full circles are not possible with G303",
    source="programming manual line 2657",
)
ARC_POINTS_IN_LINE = ErrorEntry(
    300417,
    "the three points of the arc in space lie on a straight line",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="move the interim point (I, J, K) aside, or program G01",
    source="programming manual line 2657",
)
OPENING_ANGLE = ErrorEntry(
    300418,
    "opening angle {angle:.6g} of the circle must be above 0 and at most 360 degrees",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="G02 and G03 give the direction",
)
RADIUS_DIFFERENCE = ErrorEntry(
    300419,
    "radius {start:.6g} mm at the start of the circle and {end:.6g} mm at its end differ by more than {limit:.6g} mm",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="check {letters} and the target, or use G165",
    source="P-CHAN-00171, P-CHAN-00172",
)

# -- coordinates and offsets ---------------------------------------------------------------------------------------

ROTATION_ENDED = ErrorEntry(
    300430,
    "G{number} ends the contour rotation",
    Severity.WARNING,
    Reaction.NONE,
    source="programming manual line 14643",
)
ROTATION_AXES = ErrorEntry(300431, "the centre of rotation takes only {axes}", reaction=Reaction.STOP_AT_BLOCK_END)
MIRROR_VALUE = ErrorEntry(300432, "G351 takes -1 (mirrored) or 1, not {value:.9g}", reaction=Reaction.STOP_AT_BLOCK_END)
SCALE_FACTOR = ErrorEntry(300433, "scale factor {value:.9g} must be above 0", reaction=Reaction.STOP_AT_BLOCK_END)
SCALE_ACTIVE = ErrorEntry(
    300434,
    "scale factors cannot be changed while scaling is on",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="program #SCALE OFF before",
)
SCALE_AXIS = ErrorEntry(300435, "axis {axis} is not linear and cannot be scaled", reaction=Reaction.STOP_AT_BLOCK_END)
ZERO_OFFSET_INDEX = ErrorEntry(
    300436, "zero offset {value:.9g} does not exist, there are 0 to {last}", reaction=Reaction.STOP_AT_BLOCK_END
)
FLAG_VALUE = ErrorEntry(300437, "0 or 1 is expected, not {value:.9g}", reaction=Reaction.STOP_AT_BLOCK_END)
LIMITS_REVERSED = ErrorEntry(
    300438,
    "the positive software limit of axis {axis} must lie above the negative one",
    reaction=Reaction.STOP_AT_BLOCK_END,
)
LIMIT_CLAMPED_NEGATIVE = ErrorEntry(
    21648,
    "negative software limit of axis {axis} is kept at {limit:.9g}",
    Severity.WARNING,
    Reaction.NONE,
    source="P-CHAN-00498",
)
LIMIT_CLAMPED_POSITIVE = ErrorEntry(
    21650,
    "positive software limit of axis {axis} is kept at {limit:.9g}",
    Severity.WARNING,
    Reaction.NONE,
    source="P-CHAN-00498",
)
PRESET_MIRRORED = ErrorEntry(
    300439, "position preset is not possible while mirroring is on", reaction=Reaction.STOP_AT_BLOCK_END
)
SUPPRESS_AXES = ErrorEntry(
    300440, "#SUPPRESS OFFSETS needs axis words in its block", reaction=Reaction.STOP_AT_BLOCK_END
)
FEED_CHANGE_START = ErrorEntry(
    300441,
    "G{number} needs G94 and a feed to begin with",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="program F in a block before",
)
ANGLE_WITHOUT_CIRCLE = ErrorEntry(300442, "#CANG belongs to G02 and G03", reaction=Reaction.STOP_AT_BLOCK_END)
ANGLE_WITH_CIRCLE = ErrorEntry(
    300443, "#ANG makes straight lines: not with G02, G03 and G303", reaction=Reaction.STOP_AT_BLOCK_END
)
ANGLE_AND_TARGET = ErrorEntry(
    300444,
    "#CANG gives the target in the plane, no coordinates may stand beside it",
    reaction=Reaction.STOP_AT_BLOCK_END,
)
CORNER_TWICE = ErrorEntry(
    300445, "only one chamfer or rounding can stand at the end of a block", reaction=Reaction.STOP_AT_BLOCK_END
)
CORNER_FEED_ALONE = ErrorEntry(
    300446, "#FRC needs the chamfer or rounding that it belongs to", reaction=Reaction.STOP_AT_BLOCK_END
)
CORNER_BLOCK = ErrorEntry(
    300447,
    "G301 and G302 without a value are blocks of their own: no axis words",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="write G301=.. or G302=.. in the block of the first motion",
)
ARC_MAIN_AXES = ErrorEntry(
    300448, "G303 needs three main axes, the channel has {axes}", reaction=Reaction.STOP_AT_BLOCK_END
)
FEED_CHANGE_BESIDE = ErrorEntry(
    300450, "{word}: not in a block with a linear feed change (G193, G293)", reaction=Reaction.STOP_AT_BLOCK_END
)
CORNER_FEED_MODE = ErrorEntry(
    300451,
    "a chamfer or rounding can have a feed of its own with G94 and G95, not with G{number}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="leave the feed out: that of the motion before holds",
)
ADDITION_WITHOUT_MOTION = ErrorEntry(
    300452,
    "#ANG, #CANG, chamfers and roundings belong to a block with motion",
    reaction=Reaction.STOP_AT_BLOCK_END,
)
LIMIT_OPEN = ErrorEntry(
    300453,
    "axis {axis} has no software limit that a way could be added to",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="program the limit with G90",
    source="programming manual line 3107",
)
ARC_BESIDE = ErrorEntry(300454, "{word} is not possible in a block with G303", reaction=Reaction.STOP_AT_BLOCK_END)
ANGLE_AND_PITCH = ErrorEntry(
    300455,
    "#CANG makes one turn at most: no pitch {letter} beside it",
    reaction=Reaction.STOP_AT_BLOCK_END,
)
CONTOUR_LINE_SYSTEM = ErrorEntry(
    300456,
    "plane, offsets, mirroring, rotation or scale have changed since the contour line in line {line}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="change them before both lines, or give the first one a coordinate",
)

# -- flow, levels, cycles, sequences -------------------------------------------------------------------------------

LABELS_FULL = ErrorEntry(
    20829,
    "more than {limit} expression labels: further ones are searched for at every jump",
    Severity.WARNING,
    Reaction.NONE,
    source="P-ERR-20829",
)
NAMES_FULL = ErrorEntry(
    20831,
    "more than {limit} string labels: further ones are searched for at every jump",
    Severity.WARNING,
    Reaction.NONE,
    source="P-ERR-20831",
)
LOCAL_PROGRAMS_MANY = ErrorEntry(
    306310,
    "%L {name}: a file may define at most {limit} local subprograms",
    remedy="put it into a file of its own, or raise configuration.decoder.max_local_subroutine_definitions (P-CHAN-00505)",
)
LABEL_LENGTH = ErrorEntry(300160, "label [{name}] is longer than {limit} characters")
NAME_CHARACTER = ErrorEntry(
    300161,
    "{character!r} is not allowed in the program name {name!r}",
    remedy='blanks, tabs and ( ; " ] , # $ separate words; rename the program',
    source="programming manual line 1073",
)
NAME_LENGTH = ErrorEntry(300162, "program name {name} is longer than {limit} characters")
CASE_OPEN = ErrorEntry(
    300163,
    "the branch in front of {statement} has no $BREAK: it ends here",
    Severity.WARNING,
    Reaction.NONE,
    remedy="end it with $BREAK",
)
CALL_BESIDE = ErrorEntry(
    300164,
    "{word} and {other} both want to be the last action of the block",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="write them in two blocks",
)
JUMPS_MANY = ErrorEntry(
    300165,
    "JUMPS={value} from level {levels} above the main program: back to the main program",
    Severity.WARNING,
    Reaction.NONE,
    source="programming manual line 6674",
)
JUMPS_INVALID = ErrorEntry(300166, "JUMPS={value}: at least one level is left", reaction=Reaction.STOP_AT_BLOCK_END)
RETAIN_OUTSIDE = ErrorEntry(
    300167, "#RETAIN CYCLE CHANGES has no effect outside a cycle", Severity.WARNING, Reaction.NONE
)
VALUES_MANY = ErrorEntry(300168, "{word} takes at most {limit} values", reaction=Reaction.STOP_AT_BLOCK_END)
SEQUENCE_MISSING = ErrorEntry(
    300169, "{what} does not exist in {program}: no sequence to execute", reaction=Reaction.STOP_AT_BLOCK_END
)
SEQUENCE_ORDER = ErrorEntry(
    300170, "the sequence ends with {last} before it begins with {first}", reaction=Reaction.STOP_AT_BLOCK_END
)
SEQUENCE_REPEAT = ErrorEntry(300171, "REPEAT={value}: at least 1", reaction=Reaction.STOP_AT_BLOCK_END)
SEQUENCE_OPEN = ErrorEntry(
    300172,
    "the end of {program} is reached inside a sequence",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="end it with #SEQUENCE END, or name its last block",
)
SEQUENCE_LIMITS = ErrorEntry(
    300173,
    "a sequence needs one or two block numbers, or one or two labels; with BEGIN one",
    reaction=Reaction.STOP_AT_BLOCK_END,
)
CYCLE_MODAL = ErrorEntry(300175, "MODAL_MOVE and MODAL_BLOCK exclude each other", reaction=Reaction.STOP_AT_BLOCK_END)
SINGLE_STEP = ErrorEntry(
    300176, "#SINGLE STEP takes exactly one of DISABLE, ENABLE, RESOLUTION", reaction=Reaction.STOP_AT_BLOCK_END
)
RESOLUTION_INVALID = ErrorEntry(300174, "RESOLUTION={value:.9g}: at least 1", reaction=Reaction.STOP_AT_BLOCK_END)
POSITIONS_KIND = ErrorEntry(
    300480,
    "#CHANNEL INIT takes exactly one of CMDPOS and ACTPOS, in front of the axes",
    reaction=Reaction.STOP_AT_BLOCK_END,
)
LOGICAL_AXIS = ErrorEntry(
    300481,
    "no axis of the channel has the logical number {value:.9g}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="{known}",
)
ACTUAL_FIRST = ErrorEntry(
    300482,
    "the first motion behind #CHANNEL INIT [ACTPOS] has to be straight",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="the path stands at the command position, beside the start of this arc: write G01 to its start in front of it",
)
EXACT_STOP_ALONE = ErrorEntry(
    20003,
    "G60 in a block without motion",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="write G60 into the block whose target is to be reached exactly",
    source="programming manual line 4424",
)
HOMING_ORDER = ErrorEntry(
    300770,
    "G74 {axis}{value:.9g}: the order of homing is a whole number from 1 on",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="axes with the same number are homed together, those with a lower one first: G74 Z1 X2 Y2",
)
MANUAL_ACTIVE = ErrorEntry(
    300771,
    "{statement}: axis {axis} is in manual mode",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="end manual mode of the axis first (G202)",
    source="programming manual line 5713",
)
MANUAL_AXIS = ErrorEntry(
    300772,
    "{statement} takes exactly one of AX and AXNR",
    reaction=Reaction.STOP_AT_BLOCK_END,
)
MANUAL_STAGE = ErrorEntry(
    300773,
    "{statement}: {key} is {value:.9g}, it has to be above 0",
    reaction=Reaction.STOP_AT_BLOCK_END,
)
MANUAL_PAIR = ErrorEntry(
    300774,
    "{statement}: {first} and {second} belong together",
    reaction=Reaction.STOP_AT_BLOCK_END,
)
MANUAL_SIGN = ErrorEntry(
    300775,
    "#MANUAL LIMITS: NEGATIVE has to be below 0 and POSITIVE above 0, they are {negative:.9g} and {positive:.9g}",
    reaction=Reaction.STOP_AT_BLOCK_END,
)

# -- dynamics ------------------------------------------------------------------------------------------------------

WEIGHT_INVALID = ErrorEntry(
    300600,
    "{value:.9g} % is no weight",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="give 0 or more; more than 100 % counts up to the limits of the axis",
)
CORNER_DISTANCE = ErrorEntry(
    300601,
    "DIST={value:.9g}: the corner distance has to be greater than 0",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual line 4534",
)
CORNER_PARAMETERS = ErrorEntry(
    300602,
    "G13 before its parameters are known",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="program #CORNER PARAM [DIST=.. UNIT=.. FEED=..] in front of it",
    source="programming manual line 4526",
)
LOOK_AHEAD_NUMBER = ErrorEntry(
    300603,
    "G115={value:.9g}: an even number from 0 to 14 is expected",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="2 limits block transitions, 4 the chord error, 8 the acceleration on curves; add what shall hold",
    source="programming manual line 6306",
)
LIMIT_INVALID = ErrorEntry(
    300604, "{key}={value:.9g}: a limit has to be greater than 0", reaction=Reaction.STOP_AT_BLOCK_END
)
OVERRIDE_RANGE = ErrorEntry(
    300605,
    "an override of {value:.9g} % lies outside {least:g} to {most:g} %",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual line 17070",
)
FEED_GROUP_CIRCLE = ErrorEntry(
    300606,
    "for a circle the feed axes are either all main axes with the same factor, or none of them",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="select the feed axes with #FGROUP, or #FGROUP alone for the usual ones",
    source="programming manual line 15592",
)
FEED_GROUP_FACTOR = ErrorEntry(
    300607,
    "feed factor {value:.9g} of axis {axis} lies outside 0.001 to 1000",
    reaction=Reaction.STOP_AT_BLOCK_END,
    source="programming manual line 15637",
)
FEED_GROUP_RADIUS = ErrorEntry(
    300608, "REF={value:.9g}: the reference radius has to be greater than 0", reaction=Reaction.STOP_AT_BLOCK_END
)
FEED_GROUP_DEFAULT = ErrorEntry(
    21209,
    "no feed axes are configured: F is the speed along the main axes",
    Severity.WARNING,
    Reaction.NONE,
    remedy="set gruppe[0].achse[].default_feed_axis to choose them",
    source="P-ERR-21209",
)
RADIUS_NEGATIVE = ErrorEntry(
    300609, "RMIN={value:.9g}: a radius of 0 or more is expected", reaction=Reaction.STOP_AT_BLOCK_END
)
CORNERS_OFF = ErrorEntry(
    300610,
    "G{number}: chamfers and roundings are switched off (disable_chamfers_roundings, P-CHAN-00273)",
    reaction=Reaction.STOP_AT_BLOCK_END,
)
SECTION_OPEN = ErrorEntry(
    21719,
    "the program level ends within #OPTIONAL EXECUTION ON",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="end the section with #OPTIONAL EXECUTION OFF in the level in which it begins",
    source="programming manual, line 16819",
)
SECTION_MOVES = ErrorEntry(
    50452,
    "axis {axis} stands at {end:.4f} behind the section of #OPTIONAL EXECUTION, and at {begin:.4f} before it",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="lead every axis back within the section: who leaves it out goes on from where it began",
    source="programming manual, line 16777",
)
SECTION_MASK = ErrorEntry(
    300790,
    "#OPTIONAL EXECUTION: MASK belongs to SIMULATE, and is a whole number of 0 to 2^63 - 1",
    reaction=Reaction.STOP_AT_BLOCK_END,
)
