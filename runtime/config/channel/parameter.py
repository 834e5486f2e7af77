"""What a channel parameter is: the form of a row of the register."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Literal

Kind = Literal[
    "BOOLEAN", "SGN08", "UNS08", "SGN16", "UNS16", "SGN32", "UNS32", "REAL64",  # numbers
    "STRING",  # text without blanks, or in quotes
    "CODE",  # text to the end of the line
    "KEYWORD",  # one of some words
    "FLAGS",  # some of these words, joined by "|"
    "SYNCH",  # a synchronisation type
    "UNDEFINED",  # the manual names the parameter only
]  # fmt: skip
Value = bool | int | float | str


class Use(Enum):
    """What the product makes of a parameter."""

    USED = "used"
    HARMLESS = "known, without effect: another value than the default gives a warning"
    UNSUPPORTED = "known, not supported yet: another value than the default is an error"


@dataclass(frozen=True, slots=True)
class ChannelParameter:
    """A channel parameter of the manual (004); `line` is where it is described there.

    `name` is the name in a list file, with letters for indices (`spindel[i].bezeichnung`); `index` holds the first and
    last value of each. `range` is `low..high` or alternatives joined by "|" (numbers, ranges or words); MIN and MAX
    are the limits of the type, MAX-1 is one less, ">0" is any greater value, nothing is the whole type; a number for
    texts is their greatest length. The default is always allowed. `aliases` are older names, `spellings` other ways to
    write a keyword.
    """

    number: int
    name: str
    kind: Kind
    range: str
    default: Value | None
    line: int
    meaning: str
    index: tuple[tuple[int, int], ...] = ()
    unit: str = ""
    aliases: tuple[str, ...] = ()
    spellings: Mapping[str, str] = field(default_factory=dict)
    use: Use = Use.UNSUPPORTED

    @property
    def id(self) -> str:
        """The manual's id, `P-CHAN-00041`."""
        return f"P-CHAN-{self.number:05}"
