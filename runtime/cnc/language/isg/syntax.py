"""How G functions, # statements and variables are written: what parser, checker, reference and coverage read.

The decoder registers each of them once, with its handler; here is the part of a registration that has to do with text.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, auto


class Group(Enum):
    """Groups of functions that exclude each other in a block, with the numbers of P-CHAN-00063 (channel parameters line
    5130)."""

    PATH_CONDITION = "path condition"  # 0
    PLANE = "plane"  # 4
    UNIT = "unit"  # 12
    DIMENSION = "absolute or incremental dimension"  # 14
    MIRROR = "mirroring in the plane"
    CIRCLE_CENTRE = "circle centre"  # 23
    CENTRE_CORRECTION = "circle centre correction"
    ZERO_OFFSET = "zero offset"
    FEED_MODE = "meaning of F"
    FEED_CHANGE = "linear feed change"
    CIRCLE_RADIUS = "circle radius"
    ROTATION = "contour rotation"
    ARGUMENTS = "function with axis words as arguments"
    CORNER = "chamfer or rounding"
    CALL = "implicit subprogram call"
    OVERRIDE = "override"
    EXACT_STOP = "exact stop"
    MANUAL = "manual mode"
    ACCELERATING = "acceleration or deceleration in the block"
    BRAKING = "where a block brakes"
    CORNER_DECELERATION = "corner deceleration"
    LOOK_AHEAD = "look-ahead"
    FEED_FORWARD = "feedforward control"  # 21
    COMPENSATION = "radius compensation"
    APPROACH = "approach of the radius compensation"
    OUTSIDE_CORNER = "outside corners of the radius compensation"
    COMPENSATED_FEED = "feed of the radius compensation"
    MASKING = "contour masking"
    CONTOURING = "polynomial contouring"
    SPLINE = "spline"
    DIAMETER = "diameter or radius"
    CUTTING_SPEED = "meaning of S"
    MEASURING = "measuring run"
    MEASURING_THROUGH = "measuring run that goes on"
    NONE = ""  # excludes nothing


class Values(Enum):
    """What may follow a G number."""

    NONE = auto()
    EQUALS = auto()  # G163=<expression>, needed
    OPTIONAL = auto()  # G301 or G301=<expression>
    BRACKETS = auto()  # G80 or G80[<expression>, ...]


@dataclass(frozen=True, slots=True)
class GSyntax:
    """One G function as it is written. `axis_arguments`: the axis words of its block are arguments and no targets."""

    number: int
    group: Group
    modal: bool
    syntax: str
    spec: tuple[str, ...]
    values: Values = Values.NONE
    axis_arguments: bool = False
    alone: bool = False  # only N may stand beside it (and its arguments)


class KeyKind(Enum):
    """What a key of a # statement takes."""

    NUMBER = auto()
    STRING = auto()  # a quoted text or a string expression
    VALUE = auto()  # number or string
    FLAG = auto()  # nothing
    SWITCH = auto()  # a number or nothing
    AXIS = auto()  # an axis name
    WORD = auto()  # one of `words`
    NAME = auto()  # a file or program name, quoted or not
    TARGET = auto()  # something that can be assigned: P parameter or variable, written as the key itself
    MACHINE_AXIS = auto()  # the name of any axis of the machine, or its logical number
    LABEL = auto()  # a string label in brackets, without a key


@dataclass(frozen=True, slots=True)
class Key:
    """A key of a # statement; `indexed` ones carry a number (PV1): the least and the greatest."""

    name: str
    kind: KeyKind = KeyKind.NUMBER
    words: tuple[str, ...] = ()
    indexed: tuple[int, int] | None = None
    needed: bool = False
    many: bool = False  # it may be given several times


class Form(Enum):
    """How the arguments of a # statement are written."""

    ALONE = auto()  # none
    VALUE = auto()  # #TIME 2.5, #FF = 50
    KEYS = auto()  # [KEY=.. KEY ..]
    AXES = auto()  # X1 Y2, with values
    AXIS_LIST = auto()  # X Y or X1 Y1: values without meaning
    AXIS_BRACKET = auto()  # [X, Y=2]: values may be left out
    VARIABLES = auto()  # V.P.A, P1
    MESSAGE = auto()  # <words> ["text", value, ...]
    ASSIGNMENTS = auto()  # [P1=X, V.P.A=Y]: target = axis
    PLACES = auto()  # [1,,P3]: values by their place, places may stay empty
    DIRECTION = auto()  # [Z+]: an axis and a sign
    PAIRS = auto()  # [1, Z=Y, 4=2]: a number, then pairs of axes by name or number
    SYSTEM = (
        auto()
    )  # [2] [10,0,5,,,45]: number or name of a coordinate system, values by their place; either may be missing
    SPINDLE = auto()  # [S2] or [11]: the name of a spindle, or its logical axis number


@dataclass(frozen=True, slots=True)
class StatementSyntax:
    """One # statement as it is written; `name` without #, words separated by one blank.

    `optional`: the arguments may be left out. `words` may stand in front of the bracket of a message.
    `flush`: the preparation has to be in step with the interpolator before it.
    `continued`: a backslash may tie the next line to it (cycle calls always may).
    """

    name: str
    syntax: tuple[str, ...]
    spec: tuple[str, ...]
    form: Form = Form.ALONE
    keys: tuple[Key, ...] = ()
    words: tuple[str, ...] = ()
    optional: bool = False
    flush: bool = False
    modal: bool = False
    alias_of: str = ""
    prefix: str = "#"
    continued: bool = False


@dataclass(frozen=True, slots=True)
class VariableSyntax:
    """A predefined variable as it is written: `V.G.NP[j].V.<axis>`; `access` is "r" or "rw"."""

    syntax: str
    spec: str
    access: str
    meaning: str
    unit: str = ""


@dataclass(frozen=True, slots=True)
class Vocabulary:
    """What the parser knows: G functions by number, statements by name, what may stand several times in a block."""

    g: Mapping[int, GSyntax]
    statements: Mapping[str, StatementSyntax]
    repeatable: frozenset[Group] = frozenset()
    repeats_axes: bool = False  # an axis may stand several times in a block
