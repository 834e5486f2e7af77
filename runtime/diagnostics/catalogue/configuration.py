"""Errors of the machine description and channel lists."""

from runtime.diagnostics.errors import ErrorEntry

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
    "{what} {value!r} is given to more than one axis",
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
ERROR_TEXTS = ErrorEntry(
    302090,
    "The error texts in {file} cannot be used: {reason}",
    remedy="A line is a number from 1 to 1000, a space, and its text; lines that begin with ; are comments.",
)
