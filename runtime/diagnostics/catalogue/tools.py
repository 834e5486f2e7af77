"""Errors of tools: the tool table and its files, selection, tool management."""

from runtime.diagnostics.errors import ErrorEntry, Reaction, Severity

# -- selection in programs -----------------------------------------------------------------------------------------

LENGTH_MINIMUM = ErrorEntry(
    21426,
    "tool {number} is {length:.4f} mm long, the shortest allowed tool {minimum:.4f} mm",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="correct the length of the tool in the tool table, or tool.minimum_length of the channel",
    source="P-CHAN-00156",
)
RADIUS_MINIMUM = ErrorEntry(
    21427,
    "tool {number} has a radius of {radius:.4f} mm, the smallest allowed one is {minimum:.4f} mm",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="correct the radius of the tool in the tool table, or tool.minimum_radius of the channel",
    source="P-CHAN-00157",
)
TOOL_MISSING = ErrorEntry(
    307001,
    "there is no tool {number}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="enter it: tandem tools set {number} radius=.. length=..",
)
TOOL_INVALID = ErrorEntry(
    307002,
    "tool {number} is marked as not valid",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="take another tool, or measure it and set its field `valid` to 1",
)
NUMBER_INVALID = ErrorEntry(
    307003,
    "{word}{value:.9g}: numbers of tools are 0 to {limit}",
    reaction=Reaction.STOP_AT_BLOCK_END,
)
FIELD_VALUE = ErrorEntry(307004, "{name} cannot be {value:.9g}: {reason}", reaction=Reaction.STOP_AT_BLOCK_END)
TABLE_FOREIGN = ErrorEntry(
    307005,
    "the tool data are those of an external tool management: a program cannot write {name}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="V.G.WZ_AKT changes the data of the active tool while it is selected",
)
LENGTH_AXIS = ErrorEntry(
    307006,
    "the tool length cannot act in {axis}: only in a main axis ({axes})",
    reaction=Reaction.STOP_AT_BLOCK_END,
)
ID_PARTS = ErrorEntry(
    307007,
    "a tool is named by its basic number, and by sister and variant number if it has them",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="write [<basic>], [<basic>,<sister>] or [<basic>,<sister>,<variant>]",
)

# -- the tool table and its files ----------------------------------------------------------------------------------

VALUE_INVALID = ErrorEntry(307020, "{field} cannot be {value!r}: a {kind} is expected")
VALUE_RANGE = ErrorEntry(307021, "{field} = {value:.9g} is not within {least:.9g} and {greatest:.9g}")
NAME_INVALID = ErrorEntry(307022, "the name {name!r} is no text of at most {limit} printable characters")
TABLE_FAILED = ErrorEntry(
    307030,
    "the tool table cannot be used: {reason}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="check the file and its access rights; what it holds can be made anew from a tool list (tandem tools import)",
)
TABLE_VERSION = ErrorEntry(
    307031,
    "the tool table has the form {version}, this version knows {known}",
    remedy="export it with the version that made it, and import it with this one",
)
LIST_UNREADABLE = ErrorEntry(307032, "the file cannot be read: {reason}", remedy="check its name and access rights")
LIST_KEY = ErrorEntry(
    307033,
    "{key} is no datum of a tool",
    remedy="a line is wz[<number>].<datum> <value>, with one of: {known}",
)
LIST_VALUE = ErrorEntry(307034, "{key} needs a number, but has {value!r}")
LIST_TWICE = ErrorEntry(307035, "{key} stands twice, first in line {first}")
LIST_UNSUPPORTED = ErrorEntry(
    307036,
    "{key} is not supported: {what}",
    remedy="leave it out, or give it its default",
)
LIST_IGNORED = ErrorEntry(307037, "{key} has no effect: {what}", severity=Severity.WARNING, reaction=Reaction.NONE)
TOOLS_MANY = ErrorEntry(
    307038,
    "{count} tools are more than the channel has room for: {limit}",
    remedy="raise configuration.decoder.max_number_of_tools of the channel (P-CHAN-00419)",
)
ELEMENT_RANGE = ErrorEntry(307039, "{key}: {field} has the elements 0 to {last}")
TOOL_NUMBER = ErrorEntry(307040, "{value!r} is no number of a tool: 1 to {limit}")
NEGATIVE_RADIUS = ErrorEntry(
    307041,
    "the radius of tool {number}, {value:g}, is negative",
    remedy="to change the side of the compensation a program may write V.G.WZ_AKT.R",
)
FIELD_UNKNOWN = ErrorEntry(307042, "a tool has no datum {field!r}", remedy="known: {known}")
UNIT_WRONG = ErrorEntry(307043, "{field} = {value!r}: this unit does not belong to it", remedy="units: {units}")
TOOL_TWICE = ErrorEntry(307044, "tool {number} stands twice")
CSV_NUMBER = ErrorEntry(307045, "a column `number` is missing in the first line")
COLUMN_TWICE = ErrorEntry(307046, "the column {name!r} stands twice")
CSV_CELLS = ErrorEntry(307047, "the line has {count} cells, the first one {expected}")
ASSIGNMENT = ErrorEntry(
    307048, "{text!r} is no assignment", remedy="write <datum>=<value>, e.g. radius=5 or length='50 mm'"
)
FILE_KIND = ErrorEntry(
    307049,
    "what {name} holds is not known by its name",
    remedy="tool lists end with .lis, tables of spreadsheets with .csv",
)

# -- external tool management --------------------------------------------------------------------------------------

MANAGEMENT_ABSENT = ErrorEntry(
    307060,
    "tool {tool} is wanted of an external tool management, and there is no PLC",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="the management is a part of the PLC program; without one set ext_wzv_vorhanden to 0 (P-CHAN-00016)",
)
MANAGEMENT_LATE = ErrorEntry(
    307061,
    "the tool management does not answer for tool {tool}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="check the PLC program; tools.answer_timeout of the machine description is how long it has",
)
MANAGEMENT_REFUSED = ErrorEntry(
    307062, "the tool management refuses tool {tool}: {reason}", reaction=Reaction.STOP_AT_BLOCK_END
)
MANAGEMENT_OTHER = ErrorEntry(
    307063,
    "the tool management has answered with the data of tool {other} for tool {tool}",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="the basic number of the answer has to be that of the request",
)
MANAGEMENT_ALONE = ErrorEntry(
    307064,
    "data of an external tool management are read in a block with several assignments",
    reaction=Reaction.STOP_AT_BLOCK_END,
    remedy="write the assignment into a block of its own: it waits for the answer",
)
MANAGEMENT_UNKNOWN = ErrorEntry(
    307065,
    "tool {tool} is that of an external tool management: without the machine it is taken to have no dimensions",
    Severity.WARNING,
    Reaction.NONE,
)
