"""Errors of macros, variables and drilling cycles in NCT programs. Where the manual has a number, the text begins with it."""

from runtime.diagnostics.errors import ErrorEntry

# -- expressions and variables -------------------------------------------------------------------------------------

DIVISION_BY_ZERO = ErrorEntry(
    324000,
    "3092 DIVISION BY 0 #: {name} by 0",
    remedy="check the divisor; a vacant variable counts as 0",
    source="NCT programmer's manual line 7301",
)
BITS = ErrorEntry(
    324001,
    "3091 ERRONEOUS OPERATION WITH #: {value:g} does not fit into 32 bits, {name} cannot be done with it",
    remedy="NOT, AND, OR and XOR take whole numbers from -2147483648 to 2147483647",
    source="NCT programmer's manual line 7284",
)
DOMAIN = ErrorEntry(
    324002,
    "3091 ERRONEOUS OPERATION WITH #: {name} has no value for {value:g}",
    remedy="SQRT takes no negative number, LN only positive ones, ASIN and ACOS -1 to 1, TAN no odd multiple of 90",
    source="NCT programmer's manual line 7332",
)
RESULT_RANGE = ErrorEntry(
    324003,
    "3091 ERRONEOUS OPERATION WITH #: the result of {name} is no finite number",
    remedy="check the values that it is made of",
)
DECIMAL_CODE = ErrorEntry(
    324004,
    "3091 ERRONEOUS OPERATION WITH #: {value:.10g} is nothing that {name} can convert",
    remedy="BCD takes whole numbers from 0 to 99999999, BIN their binary-coded form",
    source="NCT programmer's manual line 7371",
)
VARIABLE_UNKNOWN = ErrorEntry(
    324005,
    "there is no variable #{number}",
    remedy="#1 to #33 are local, #100 to #199 and #500 to #599 common; the others are system variables",
)
VARIABLE_NUMBER = ErrorEntry(
    324006, "{value:g} is no number of a variable", remedy="the number of a variable is a whole number from 0"
)
VARIABLE_READ_ONLY = ErrorEntry(
    324007, "#{number} can only be read", remedy="use another variable on the left side of ="
)
VARIABLE_WRITE_ONLY = ErrorEntry(324011, "#{number} can only be written", remedy="it has no value")
VARIABLE_PROTECTED = ErrorEntry(
    324008,
    "#{number} is write-protected: #{first} to #{last} are",
    remedy="use another variable, or change WRPROT1 and WRPROT2",
    source="NCT programmer's manual line 6715",
)

NUMBER_FIRST = ErrorEntry(
    324012,
    "a block number is a whole number, no variable",
    remedy="write N and its digits",
    source="NCT programmer's manual line 6600",
)

NUMBER_LONG = ErrorEntry(324013, "the number has more than {limit} characters", remedy="eight digits are enough")

# -- macro calls ---------------------------------------------------------------------------------------------------

ARGUMENT_TWICE = ErrorEntry(
    324020,
    "3064 BAD MACRO STATEMENT: {address} gives #{number} a second value",
    remedy="D to Z and the second to tenth I, J, K share variables: use one of the two argument lists",
    source="NCT programmer's manual line 6153",
)
ARGUMENT_ADDRESS = ErrorEntry(
    324021,
    "3064 BAD MACRO STATEMENT: {address} cannot be an argument of a macro call",
    remedy="arguments are A to F, H to K, M and Q to Z",
    source="NCT programmer's manual line 6075",
)
TOO_MANY_ARGUMENTS = ErrorEntry(
    324022,
    "3064 BAD MACRO STATEMENT: more than ten {address} in a macro call",
    source="NCT programmer's manual line 6081",
)

# -- control flow --------------------------------------------------------------------------------------------------

LOOP_NUMBER = ErrorEntry(
    324031,
    "3091 ERRONEOUS OPERATION WITH #: {number} is no number of a loop",
    remedy="DO and END take 1, 2 or 3",
    source="NCT programmer's manual line 7473",
)
LOOP_TWICE = ErrorEntry(
    324032,
    "3064 BAD MACRO STATEMENT: DO{number} within a loop of the same number, which begins in line {line}",
    remedy="give the inner loop another number, or end the outer one first",
    source="NCT programmer's manual line 7488",
)
LOOP_OPEN = ErrorEntry(
    324033,
    "3064 BAD MACRO STATEMENT: DO{number} has no END{number} in this program",
    remedy="DO and END stand in pairs in one program, and do not overlap",
    source="NCT programmer's manual line 7488",
)
LOOP_MISSING = ErrorEntry(
    324034,
    "72: END{number} without DO{number} before it",
    remedy="DO and END stand in pairs, DO first",
    source="NCT programmer's manual line 7480",
)
LOOP_OVERLAPS = ErrorEntry(
    324035,
    "3064 BAD MACRO STATEMENT: END{number} within the loop of DO{inner}, which begins in line {line}",
    remedy="end the inner loop first: loops do not overlap",
    source="NCT programmer's manual line 7545",
)
JUMP_INTO_LOOP = ErrorEntry(
    324036,
    "3064 BAD MACRO STATEMENT: N{number} stands within a loop that begins in line {line}; no jump leads into a loop",
    remedy="jump to the head of the loop",
    source="NCT programmer's manual line 7571",
)

# -- codes that call macros ----------------------------------------------------------------------------------------

CODE_NOT_FIRST = ErrorEntry(
    324023,
    "3064 BAD MACRO STATEMENT: {code} calls a macro and has to be the first word of its block",
    remedy="only the skip switch and the block number stand in front of it",
    source="NCT programmer's manual line 6360",
)

# -- drilling cycles -----------------------------------------------------------------------------------------------

NO_BOTTOM_OR_R = ErrorEntry(
    324050,
    "3053 NO BOTTOM OR R POINT: a drilling cycle needs Z and R",
    remedy="program both in the first block of the cycles, and R where another axis drills",
    source="NCT programmer's manual line 5069",
)
NO_ORIENTATION = ErrorEntry(
    324051,
    "3052 ERROR IN G76, G87: {name} needs a spindle that can be oriented",
    remedy="set orient1 in the description of the channel if the machine has one",
    source="NCT programmer's manual line 5278",
)
NOT_RIGID = ErrorEntry(
    324063,
    "3052 ERROR IN G76, G87: {name} needs a spindle that can follow the drilling axis",
    remedy="set index1 in the description of the channel if the machine has one",
    source="NCT programmer's manual line 5493",
)
SPEED_MISSING = ErrorEntry(
    324064, "{name} needs S, the speed of the spindle", remedy="program S before the cycle, or in its block"
)
CUT_MISSING = ErrorEntry(
    324052, "{name} needs Q, the depth of a cut", remedy="program Q in the first block of the cycle"
)
CUT_NEGATIVE = ErrorEntry(324053, "{address} {value:g} is no depth", remedy="Q is greater than 0, E not negative")
TOO_MANY_CUTS = ErrorEntry(324054, "more than {limit} cuts in one block", remedy="choose a greater Q, or a smaller L")
SPINDLE_STANDS = ErrorEntry(
    324055,
    "{name} needs the spindle turning with M{command}",
    remedy="program S and M{command} before the cycle, or in its block",
    source="NCT programmer's manual line 5432",
)
SHIFT_LETTER = ErrorEntry(
    324056, "{letter} has no meaning in this plane", remedy="the tool is shifted off the wall by {letters}"
)
SHIFT_MISSING = ErrorEntry(
    324057,
    "{name} needs a shift of the tool off the wall, to get through the hole",
    remedy="program I and J (G18: K and I, G19: J and K)",
)
BACK_BORING_LEVELS = ErrorEntry(
    324058,
    "G87 bores back from R to Z: Z has to lie between the initial point and R",
    source="NCT programmer's manual line 5715",
)
CYCLE_COMPENSATED = ErrorEntry(324059, "no drilling cycle while cutter compensation is on", remedy="program G40 before")
TWO_DRILLING_AXES = ErrorEntry(324060, "{first} and {second} both drill in this plane", remedy="program one of them")
NO_DRILLING_AXIS = ErrorEntry(324061, "the channel has no axis {axis} to drill with in this plane")

# -- system variables ----------------------------------------------------------------------------------------------

VALUE_REFUSED = ErrorEntry(324070, "#{number} cannot take the value {value}", remedy="it takes {allowed}")
VARIABLE_REFUSED = ErrorEntry(324071, "#{number} is not available: {reason}", remedy="write the program without it")
TEXT_TOO_LONG = ErrorEntry(
    324072,
    "the text of #{number} is longer than {limit} characters",
    remedy="shorten it",
    source="NCT programmer's manual line 6936",
)
