"""What a block consists of after parsing: words with their expressions, a control statement, or a # statement."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum

from runtime.cnc.language.isg.syntax import StatementSyntax
from runtime.cnc.language.motion_words import WordKind as WordKind

ADDITIONS = ("ANG", "CANG", "CHR", "CHF", "RND", "FRC")  # words with # among those of a motion block


class ValueKind(IntEnum):
    """What an expression gives; ANY is only known when it is executed."""

    NUMBER = 0
    STRING = 1
    ANY = 2


@dataclass(frozen=True, slots=True)
class Expression:
    """An expression as Python source over the names of a block's namespace.

    `constant` is its value if it is a plain number. `binding` tells how tight the source binds: 1 a bare sum, 2 a bare
    product, 3 anything that may stand everywhere. `depth` counts nested brackets. `flush` tells that it reads something of
    the interpolator: the preparation has to be in step with it before.
    """

    source: str
    constant: float | None = None
    binding: int = 3
    depth: int = 0
    kind: ValueKind = ValueKind.NUMBER
    flush: bool = False


@dataclass(frozen=True, slots=True)
class Word:
    """One word; `column` counts from 1.

    For ASSIGNMENT `target` is the source of a call that takes the value, with `{}` in its place. For DECLARATION `name` is
    the path of the variable, `target` its type or "", `values` the initial values, `indices` the sizes. `values` of a G word
    are the bracketed ones of G80[1,,2]: None where a place is empty. A call by a variable has its name as `value`. Of RETURN
    `target` is "MAIN" or "", `values` are levels and block number, `name` is a string label.
    """

    kind: WordKind
    column: int
    value: Expression | None = None
    index: int = 0
    extra: Expression | None = None  # additional value of an M or H function
    target: str = ""
    name: str = ""
    values: tuple[Expression | None, ...] = ()
    indices: tuple[Expression, ...] = ()
    flush: bool = False
    inner: tuple[Word, ...] = ()  # of a bracket
    job: ParsedStatement | None = None  # in a bracket, MC_...
    signs: str = ""  # of an axis word: the signs directly behind its name, at most two


class Control(Enum):
    """Control statements."""

    IF = "$IF"
    ELSEIF = "$ELSEIF"
    ELSE = "$ELSE"
    ENDIF = "$ENDIF"
    SWITCH = "$SWITCH"
    CASE = "$CASE"
    DEFAULT = "$DEFAULT"
    ENDSWITCH = "$ENDSWITCH"
    FOR = "$FOR"
    ENDFOR = "$ENDFOR"
    WHILE = "$WHILE"
    ENDWHILE = "$ENDWHILE"
    DO = "$DO"
    ENDDO = "$ENDDO"
    REPEAT = "$REPEAT"
    UNTIL = "$UNTIL"
    BREAK = "$BREAK"
    CONTINUE = "$CONTINUE"


@dataclass(frozen=True, slots=True)
class ControlStatement:
    """A control statement with its expressions: the condition, or start, end and step of `$FOR`.

    `target` and `counter` write and read the counter of `$FOR`, `goto` is the jump of `$IF .. $GOTO`.
    """

    control: Control
    column: int
    expressions: tuple[Expression, ...] = ()
    target: str = ""
    counter: Expression | None = None
    goto: Word | None = None


@dataclass(frozen=True, slots=True)
class Argument:
    """One argument of a # statement.

    `name` is the key ("" for none), `value` its expression, `text` what stands there literally (a name, an enumerated
    word), `index` the number of a key like PV3 or the channel index of an axis, `target` the source of a write access with
    `{}` in the place of the value.
    """

    name: str
    column: int
    value: Expression | None = None
    text: str = ""
    index: int = -1
    target: str = ""
    indices: tuple[Expression, ...] = ()


@dataclass(frozen=True, slots=True)
class ParsedStatement:
    """A # statement with its arguments in the order of the text."""

    syntax: StatementSyntax
    column: int
    arguments: tuple[Argument, ...] = ()


@dataclass(frozen=True, slots=True)
class ParsedBlock:
    """One block. `skip_level` is 0 if it is never skipped; `label` is the string label in upper case; `macros` are the
    definitions in it, name → content."""

    words: tuple[Word, ...] = ()
    control: ControlStatement | None = None
    statement: ParsedStatement | None = None
    number: Expression | None = None
    skip_level: int = 0
    label: str = ""
    macros: tuple[tuple[str, str], ...] = ()
    addition: ParsedStatement | None = None  # #ADD or #SUPPRESS OFFSETS beside words
