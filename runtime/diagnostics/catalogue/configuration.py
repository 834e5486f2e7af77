"""Errors of the machine description and channel lists."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity

FILE_NOT_READABLE = ErrorEntry(
    302001,
    "The machine description cannot be read: {reason}",
    remedy="Give an existing file with -c/--config; without it the built-in demo machine is used.",
)
NOT_TEXT = ErrorEntry(
    302002,
    "The machine description is no UTF-8 text: {reason}",
    remedy="Save the file as UTF-8 text; config/machine.yaml of the distribution is a full example.",
)
EMPTY = ErrorEntry(
    302003,
    "The machine description is empty",
    remedy="config/machine.yaml of the distribution is a full example to start from.",
)
YAML_SYNTAX = ErrorEntry(
    302004,
    "This is no valid YAML: {reason}",
    remedy="Indent with spaces, put a space behind every colon, and close every bracket and quote.",
)
KEY_TWICE = ErrorEntry(
    302005,
    "Key {key!r} stands twice; the first one is in line {first_line}",
    remedy="Keep one of them.",
)
KEY_UNKNOWN = ErrorEntry(
    302006,
    "{key!r} is no key of {owner}{suggestion}",
    remedy="Known keys here: {known}.",
)
KEY_MISSING = ErrorEntry(
    302007,
    "{owner} lacks the key {key!r}",
    remedy="Add the key; config/machine.yaml of the distribution shows every key with its unit.",
)
WRONG_TYPE = ErrorEntry(
    302008,
    "{key}: {expected} is expected, not {given}",
    remedy="config/machine.yaml of the distribution shows every key with its type and unit.",
)
WRONG_UNIT = ErrorEntry(
    302009,
    "{key}: {unit!r} is no unit of {dimension}",
    remedy="Write the number with one of {allowed}, or without a unit in {internal}.",
)
OUT_OF_RANGE = ErrorEntry(
    302010,
    "{key}: {given} is out of range; {bound}",
    remedy="Give a value in the range.",
)
LIMITS_REVERSED = ErrorEntry(
    302011,
    "Axis {axis}: the lower software limit {minimum:g} is not below the upper one {maximum:g}",
    remedy="Exchange position_min and position_max, or correct the wrong one.",
)
NODE_TWICE = ErrorEntry(
    302012,
    "CANopen node id {node} is given to {first} and to {second}",
    remedy="Give every node an id of its own, here and at the device's switches.",
)
UNKNOWN_AXIS = ErrorEntry(
    302013,
    "{user} uses axis {axis!r}, which {reason}",
    remedy="Axes that can stand here: {known}.",
)
NOT_UNIQUE = ErrorEntry(
    302014,
    "{what} {value!r} is given more than once",
    remedy="Give every axis a name and a logical axis number of its own.",
)
UNKNOWN_CHOICE = ErrorEntry(
    302015,
    "{key}: {given} is unknown{suggestion}",
    remedy="Allowed: {allowed}.",
)
WRONG_LENGTH = ErrorEntry(
    302016,
    "{key}: {given} entries or characters are given; {bound}",
    remedy="config/machine.yaml of the distribution shows what belongs here.",
)
WRONG_PATTERN = ErrorEntry(
    302017,
    "{key}: {given} has not the form that is needed here",
    remedy="{rule}",
)
YAML_TAG = ErrorEntry(
    302018,
    "The tag {tag!r} is not allowed: a machine description holds plain values only",
    remedy="Remove the tag.",
)
YAML_RECURSION = ErrorEntry(
    302019,
    "The alias refers to the mapping or list that it stands in",
    remedy="Write the values out instead of the alias.",
)
WATCHDOG_TOO_SHORT = ErrorEntry(
    302020,
    "{what} of {timeout:g} s is not longer than {cycle:g} s, {of_what}",
    remedy="Give a multiple of it, so that one late cycle is no alarm.",
)
SPINDLE_EXPECTED = ErrorEntry(
    302021,
    "Channel {channel} lists axis {axis!r} as a spindle, but its type is {type}",
    remedy="Set `type: spindle` at the axis, or name another axis.",
)
UNSUITABLE = ErrorEntry(
    302022,
    "{key}: {reason}",
    remedy="config/machine.yaml of the distribution shows every key with its type and unit.",
)
PARAMETER_UNKNOWN = ErrorEntry(
    302023,
    "{key!r} is no parameter of {owner}{suggestion}",
    remedy="Channel parameters have the names of the manual, in exactly its letters.",
)
PARAMETER_UNSUPPORTED = ErrorEntry(
    302024,
    "{key} ({id}, {meaning}) is not supported yet; {possible}",
    remedy="Take the line out, and make sure that the machine can do without it.",
)
PARAMETER_WITHOUT_EFFECT = ErrorEntry(
    302025,
    "{key} ({id}, {meaning}) has no effect yet",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
    remedy="Motion and technology functions don't depend on it; nothing has to be done.",
)
PARAMETER_TWICE = ErrorEntry(
    302026,
    "{key} is given twice; it stands in {first} already",
    remedy="Keep one of them: a channel parameter stands in the description or in the list, once.",
)
PARAMETER_GROUP = ErrorEntry(
    302027,
    "{key} is a group of parameters, not a parameter",
    remedy="Name the parameter with all of its indices and its last name.",
)
LIST_KEY = ErrorEntry(
    302028,
    "{key!r} has not the form of a parameter's name",
    remedy="A line is a name like spindel[0].bezeichnung, blanks, and a value; comments begin with #.",
)
LIST_NOT_READABLE = ErrorEntry(
    302029,
    "The list of channel parameters cannot be read: {reason}",
    remedy="Give an existing text file with parameter_list; its name counts from the folder of the description.",
)
LIST_VALUE_MISSING = ErrorEntry(
    302030,
    "{key} has no value",
    remedy='Write the value behind the name in the same line; an empty text is "".',
)
LIST_BAR_MISSING = ErrorEntry(
    302031,
    "{value!r} is followed by {word!r} without a | between them",
    remedy="Join them with |, or begin the remark with #.",
)
INDEX_GAP = ErrorEntry(
    302033,
    "{group}[{index}] is given, {group}[{missing}] is not",
    remedy="Number the entries from 0 without gaps.",
)
PARAMETER_CONTRADICTS = ErrorEntry(
    302034,
    "{key} is {given}, but {what} is {other}",
    remedy="Correct one of them, or take the line out.",
)
PARAMETER_NOT_UNIQUE = ErrorEntry(
    302035,
    "{what} is {value!r} like that of {first}",
    remedy="Give every entry one of its own.",
)
PATH_PRIORITY_TWICE = ErrorEntry(
    302036,
    "path[{index}] has priority {priority} like path[{other}], and both are of type {type}",
    remedy="Give every folder of a type a priority of its own; 0 is searched first.",
    source="P-CHAN-00404",
)
PATHS_TWICE = ErrorEntry(
    302037,
    "Channel {channel} has program_paths and path[] parameters",
    remedy="Keep one of them; path[] tells main programs, subroutines and files apart.",
)
FEED_UNIT = ErrorEntry(
    302038,
    "prog_start.feedrate_factor: there is no feed unit {given}; F is taken in mm/min",
    severity=Severity.WARNING,
    reaction=Reaction.NONE,
    remedy="100 stands for mm/min, 0.1 for m/min.",
    source="P-CHAN-00108",
)
EXTERNAL_NAME = ErrorEntry(
    302040,
    "{key}: {given!r} is no name of an external variable, structure or member",
    remedy="A name is a letter or underscore, then letters, digits and underscores, 64 characters at most.",
)
EXTERNAL_TWICE = ErrorEntry(
    302041,
    "{what} {name!r} is described twice",
    remedy="Give every variable and structure, and every member of a structure, a name of its own.",
)
EXTERNAL_TYPE = ErrorEntry(
    302042,
    "{key}: {given!r} is no type{suggestion}",
    remedy="Types: {known}.",
)
EXTERNAL_RECURSION = ErrorEntry(
    302043,
    "Structure {name!r} contains itself",
    remedy="Take one of these out: {way}.",
)
EXTERNAL_TOO_LARGE = ErrorEntry(
    302044,
    "The external variables need {size} bytes with {name!r}; there are {area}",
    remedy="Make arrays or texts shorter.",
)
TO_FILL_IN = ErrorEntry(
    302045,
    "This is still to be filled in: {what}",
    remedy="Put the value of your machine in the place of the angle brackets; config/machine.yaml of the distribution shows "
    "every key with its unit.",
)
BUS_UNKNOWN = ErrorEntry(
    302046,
    "{owner} is on the bus {bus!r}, which is not described",
    remedy="Describe it under fieldbus.buses, or name one of these: {known}; without a name it is on fieldbus.bus.",
)
BUS_TWICE = ErrorEntry(
    302047,
    "The channel {channel} is that of two buses, {first} and {second}",
    remedy="Each bus has a channel (a CAN interface) of its own.",
)
COMPENSATION_TABLE = ErrorEntry(
    302051,
    "The table of pitch errors cannot be used: {reason}",
    remedy="Rows are a position and the error there, both in mm or degrees; lines of a file that begin with # are comments.",
)
DRIVE_CANNOT = ErrorEntry(
    302050,
    "Axis {axis} cannot have {what}: {reason}",
    remedy="Leave one of both out.",
)
SPINDLE_IN_PATH = ErrorEntry(
    314030,
    "Channel {channel} lists {axis} among its path axes, but it is a spindle",
    remedy="name it under `spindel` of the channel parameters",
    source="channel parameters line 3549",
)
ANALOGUE_UNFIT = ErrorEntry(
    302052,
    "The analogue channel {name} cannot be so: {reason}",
    remedy="counts are what the device tells at values; its manual has both",
)
ERROR_TEXTS = ErrorEntry(
    302090,
    "The error texts in {file} cannot be used: {reason}",
    remedy="A line is a number from 1 to 1000, a space, and its text; lines that begin with ; are comments.",
)
