"""Errors of programs in the NCT dialect. Where the control has an error number of its own, the text begins with it.

320xxx reading and the frame of a program, 321xxx motion, functions, subprograms.
"""

from __future__ import annotations

from runtime.diagnostics.errors import ErrorEntry

# -- reading -------------------------------------------------------------------------------------------------------

NOT_SUPPORTED = ErrorEntry(
    320001, "{what} is not supported yet", remedy="this version does not know it; write it without"
)
ILLEGAL_G = ErrorEntry(
    320002, "3005 ILLEGAL G CODE: G{number} does not exist", remedy="`tandem lang --dialect nct` lists the G codes"
)
G_GROUP_TWICE = ErrorEntry(
    320003,
    "3005 ILLEGAL G CODE: G{number} and G{other} belong to the same group ({group})",
    remedy="one code of a group per block",
)
VALUE_EXCESS = ErrorEntry(
    320004, "3001 VALUE EXCESS: {address} {value:g} is not within {least:g} and {most:g}", remedy="check the value"
)
ADDRESS_UNKNOWN = ErrorEntry(
    320005, "{address!r} is no address", remedy="`tandem lang --dialect nct` lists the addresses"
)
ADDRESS_RIGHT = ErrorEntry(320006, "{what} is not allowed at address {address}")
AXIS_MISSING = ErrorEntry(320007, "the channel has no axis {address}", remedy="it has: {axes}")
WORD_TWICE = ErrorEntry(320008, "address {address} stands twice in the block", remedy="once is enough")
WORD_WITHOUT_MEANING = ErrorEntry(
    320009, "{address} has no meaning in this block", remedy="no code that is active takes it: leave it out"
)
SYNTAX = ErrorEntry(320010, "{found!r} is not understood here", remedy="check the spelling and the word before it")
VALUE_MISSING = ErrorEntry(320011, "{address} needs a number", remedy="write one behind it")
COMMENT_OPEN = ErrorEntry(320012, "the comment is not closed", remedy="a comment ends with ')' in the same block")
COMMENT_CLOSE = ErrorEntry(320013, "')' without '('")
CHARACTER = ErrorEntry(
    320014, "character {character!r} is not allowed outside comments", remedy="programs are ASCII text"
)
SKIP_NUMBER = ErrorEntry(
    320015, "a skip switch has a number from 1 to 9", remedy="/1 is the one of the operator's panel"
)
BLOCK_NUMBER = ErrorEntry(320016, "block number {number} is not within 1 and 99999")
MACRO_STATEMENT = ErrorEntry(320017, "3064 BAD MACRO STATEMENT: {reason}")
OPERATION = ErrorEntry(320018, "3091 ERRONEOUS OPERATION WITH #: {reason}")
VARIABLE_NUMBER_TEXT = ErrorEntry(320019, "#{text} is no variable", remedy="a variable has a whole number")

# -- the frame of a program ----------------------------------------------------------------------------------------

PROGRAM_NUMBER = ErrorEntry(320030, "{text!r} is no program number", remedy="O and exactly four digits, O0001 to O9999")
PROGRAM_NAME = ErrorEntry(
    320031, "{text!r} is not allowed behind the program number", remedy="a name in ( ), 16 characters at most"
)
PROGRAM_TWICE = ErrorEntry(320032, "O{number:04d} stands twice in this file, first in line {first}")
PROGRAM_MISSING = ErrorEntry(
    320033, "{file} holds no block", remedy="% and Onnnn begin a program, one block follows per line"
)

# -- motion and functions ------------------------------------------------------------------------------------------

CIRCLE = ErrorEntry(
    321001,
    "3014 ERRONEOUS CIRCLE DEF.: an arc needs R, or the centre letters of its plane",
    remedy="G17 takes I and J, G18 K and I, G19 J and K; R and a centre exclude each other",
)
RADIUS_DIFFERENCE = ErrorEntry(
    321002,
    "3011 RADIUS DIFFERENCE: {start:g} mm at the start and {end:g} mm at the end of the arc, {limit:g} mm may differ (RADDIF)",
    remedy="check the centre and the target",
)
CIRCLE_RADIUS = ErrorEntry(
    321003,
    "3012 ERRONEOUS CIRCLE DEF. R: the target of an arc with R is its start",
    remedy="a full circle needs its centre: I, J, K",
)
PLANE_COMPENSATED = ErrorEntry(
    321004, "3010 PLANE SELECT. IN G41, G42", remedy="program G40 before another plane is chosen"
)
CONFLICTING_M = ErrorEntry(
    321005, "3032 CONFLICTING M CODES: M{number:02d} and M{other:02d} belong to the same group", remedy="use two blocks"
)
TOO_MANY_M = ErrorEntry(321006, "3032 CONFLICTING M CODES: more than {most} in the block", remedy="use two blocks")
PLANE_MISSING = ErrorEntry(321007, "the channel has no axes of this plane", remedy="it has: {axes}")
ANGLE_COORDINATE = ErrorEntry(
    321008, "a straight line by ,A: {reason}", remedy="program one coordinate of the plane beside ,A"
)
POLAR_TURNS = ErrorEntry(
    321009,
    "3014 ERRONEOUS CIRCLE DEF.: the angle goes round against the sense of the arc",
    remedy="G02 goes with falling angles, G03 with rising ones",
)
CORNER_BOTH = ErrorEntry(321010, "3017 ,C AND ,R IN ONE BLOCK", remedy="program one of them")
CORNER_DEFINITION = ErrorEntry(
    321011,
    "3081 DEFINITION ERROR ,C ,R: {reason}",
    remedy="a chamfer or rounding stands between two of G01, G02, G03 in the plane",
)
CORNER_HIGH = ErrorEntry(321012, "3084 ,C ,R TOO HIGH: it does not fit between the motions", remedy="make it smaller")
SURFACE_SPINDLE = ErrorEntry(
    321013,
    "G96 needs a spindle that the control moves",
    remedy="configure the main spindle of the channel, or let the PLC do it",
)

G31_FORMAT = ErrorEntry(321014, "3051: G31: {reason}", remedy="G31 v F P: v are axis words, P is 0 to 3")
G31_STATE = ErrorEntry(321015, "3054 G31 IN INCORRECT STATE: {code} is active", remedy="end it before")

# -- subprograms ---------------------------------------------------------------------------------------------------

LEVEL_EXCESS = ErrorEntry(321020, "3069 LEVEL EXCESS: more than {limit} subprograms in each other")
NO_BLOCK = ErrorEntry(
    321021,
    "3070 NOT EXISTING BLOCK NO. P: no block of the program begins with N{number}",
    remedy="the number has to stand at the beginning of its block",
)
FAULTY_P = ErrorEntry(321022, "3071 MISSING OR FAULTY P", remedy="give P, a whole number in its range")
FAULTY_L = ErrorEntry(321023, "3072 DEFINITION ERROR L: {value:g} is not within {least} and 9999")
NO_PROGRAM = ErrorEntry(
    321024,
    "3073 NOT EXISTING PROGRAM: O{number:04d} is neither in this file nor in: {folders}",
    remedy="a program has the file name O{number:04d}.nc, or stands in the file of its caller",
)

# -- the machine description ---------------------------------------------------------------------------------------

SKIP_INPUT = ErrorEntry(320051, "skip: no node has an input {name}", remedy="inputs are: {known}")
START_CODES = ErrorEntry(320050, "codes: {first} and {second} exclude each other", remedy="name one of them")
