"""Random blocks: what they do, and the many ways to write them; and decoded rows written as a program again.

    blocks ──┬─ plainly() ──────────▶ text ─┐
             ├─ somehow(seed) ──────▶ text ─┴─▶ the same rows
             ├─ moves() ────────────▶ ends and feeds, computed here
             └─▶ rows ─ rewritten() ▶ text ───▶ the same path and functions once more

Lengths are whole thousandths of a millimetre, so that sums are exact.
"""

from __future__ import annotations

import random
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from hypothesis import strategies as st

AXES = "XYZ"
# Zero offsets of the channel that the tests decode with, thousandths of a millimetre.
OFFSETS = {53: (0, 0, 0), **{54 + k: (100_000 * (k + 1), 10_000 * (k + 1), 1000 * (k + 1)) for k in range(6)}}


@dataclass(frozen=True, slots=True)
class Arc:
    """Quarters of a circle in XY about a centre given from the start, thousandths of a millimetre."""

    centre: tuple[int, int]
    quarters: int
    clockwise: bool

    def way(self) -> tuple[int, int]:
        """From start to end."""
        x, y = -self.centre[0], -self.centre[1]
        for _ in range(self.quarters):
            x, y = (y, -x) if self.clockwise else (-y, x)
        return self.centre[0] + x, self.centre[1] + y


@dataclass(frozen=True, slots=True)
class Block:
    """One block: words and what they mean. An arc is written incrementally and leaves G91 and its G function behind."""

    number: int | None = None
    motion: int | None = None  # G00 or G01
    dimension: int | None = None  # G90 or G91
    offset: int | None = None  # G53 to G59
    axes: tuple[tuple[str, int], ...] = ()
    feed: int | None = None
    function: int | None = None  # M
    auxiliary: int | None = None  # H
    tool: int | None = None
    speed: int | None = None
    arc: Arc | None = None

    def words(self) -> list[tuple[str, int | None, str]]:
        """Address, thousandths of its value, and text where it is no length; without the block number."""
        modal = (self.motion, self.dimension, self.offset)
        found: list[tuple[str, int | None, str]] = [("G", None, str(number)) for number in modal if number is not None]
        axes = dict(self.axes)
        if self.arc is not None:
            found += [
                ("G", None, "91"),
                ("G", None, "162"),
                ("G", None, "17"),
                ("G", None, "2" if self.arc.clockwise else "3"),
            ]
            axes = dict(zip("XY", self.arc.way(), strict=True))
            found += [("I", self.arc.centre[0], ""), ("J", self.arc.centre[1], "")]
        found += [(axis, value, "") for axis, value in axes.items()]
        if self.feed is not None:
            found.append(("F", self.feed * 1000, ""))
        for letter, number in (("M", self.function), ("H", self.auxiliary), ("T", self.tool), ("S", self.speed)):
            if number is not None:
                found.append((letter, None, str(number)))
        return found


def plainly(blocks: Sequence[Block]) -> str:
    """The program with its words in one order, as short as can be."""
    lines = []
    for block in blocks:
        number = [] if block.number is None else [f"N{block.number}"]
        words = [letter + (text or f"{(value or 0) / 1000:g}") for letter, value, text in block.words()]
        lines.append(" ".join([*number, *words]))
    return "\n".join([*lines, "M30", ""])


def somehow(blocks: Sequence[Block], seed: int) -> str:
    """The same program, line by line: other orders of words, blanks, comments, cases, forms of numbers."""
    source = random.Random(seed)
    return "".join(_line(block, source) + source.choice(("\n", "\n", "\r\n")) for block in blocks) + "M30\n"


def _line(block: Block, source: random.Random) -> str:
    words = [_word(letter, value, text, source) for letter, value, text in block.words()]
    source.shuffle(words)
    if block.number is not None:
        letter = source.choice("Nn")
        words.insert(0, f"{letter}{source.choice(('', ' ', '0'))}{block.number}")
    line = source.choice(("", "", "  ", "(first)"))
    for word in words:
        # A name of several characters ends at its "=": in X5Y=3 it is X5Y.
        needed = "=" in word and line[-1:].isalnum()
        line += (" " if needed else "") + word + source.choice(("", "", " ", " ", "\t", "  ", "(c (inner) G2)"))
    return line + source.choice(("", "", "", "; M5 X1", " (open"))


def _word(letter: str, value: int | None, text: str, source: random.Random) -> str:
    if letter not in AXES:
        letter = source.choice((letter, letter.lower()))
    if value is None:
        return (
            letter + source.choice(("", "", " ") if letter in "gG" else ("", " ")) + source.choice((text, "0" + text))
        )
    number = _number(value, source)
    return letter + source.choice(("", "", "", " ", "=", " = ")) + number


def _number(thousandths: int, source: random.Random) -> str:
    digits = f"{abs(thousandths) // 1000}.{abs(thousandths) % 1000:03d}"
    digits = source.choice((digits, digits.rstrip("0"), digits.rstrip("0").rstrip("."), "0" + digits, digits + "0"))
    if digits.startswith("0.") and len(digits) > 2:
        digits = source.choice((digits, digits[1:]))
    number = ("-" if thousandths < 0 else source.choice(("", "", "+"))) + digits
    return source.choice((number, number, number, f"[{number}]", f"[ {number}*1 ]"))


# -- what they do --------------------------------------------------------------------------------------------------


def moves(blocks: Iterable[Block]) -> list[tuple[tuple[int, ...], int | None]]:
    """Where each motion ends, thousandths of a millimetre in machine coordinates, and its feed, None for rapid."""
    position = [0, 0, 0]
    motion, absolute, offset, feed = 1, True, 53, 0
    found: list[tuple[tuple[int, ...], int | None]] = []
    for block in blocks:
        motion = motion if block.motion is None else block.motion
        absolute = absolute if block.dimension is None else block.dimension == 90
        offset = offset if block.offset is None else block.offset
        feed = feed if block.feed is None else block.feed
        axes = dict(block.axes)
        if block.arc is not None:
            motion, absolute = 2, False
            axes = dict(zip("XY", block.arc.way(), strict=True))
        for axis, value in axes.items():
            at = AXES.index(axis)
            position[at] = value + OFFSETS[offset][at] if absolute else position[at] + value
        if axes:
            found.append((tuple(position), None if motion == 0 else feed))
    return found


# -- rows as a program ---------------------------------------------------------------------------------------------


def rewritten(rows: Sequence[Mapping[str, object]]) -> str:
    """Rows of blocks.jsonl (lines, arcs in XY, functions, the end) as a program in machine coordinates."""
    return "\n".join(["G90 G53 G161", *(" ".join(_rewritten(row)) for row in rows), ""])


def _rewritten(row: Mapping[str, object]) -> list[str]:
    words = [] if row["n"] is None else [f"N{row['n']}"]
    match row["type"]:
        case "line" | "arc":
            to, centre = row["to"], row.get("centre", {})
            assert isinstance(to, dict)
            assert isinstance(centre, dict)
            turn = 2 if float(str(row.get("angle", 0))) < 0 else 3
            words.append(f"G{turn}" if centre else "G0" if row["rapid"] else "G1")
            words += [f"{axis}{value:.9f}" for axis, value in to.items() if not centre or axis in centre]
            words += [f"{letter}{value:.9f}" for letter, value in zip("IJ", centre.values(), strict=False)]
            return words if row["rapid"] else [*words, f"F{row['feed']:.9f}"]
        case "s":
            speed = f"S{row['value']:.9f}"
            return [*words, speed, f"M{row['number']}"] if row["number"] else [*words, speed]
        case "m" | "h" | "t":
            return [*words, f"{str(row['type']).upper()}{row['number']}"]
        case "stop":
            return [*words, str(row["kind"])]
    raise AssertionError(f"no words for {row}")


# -- random ones ---------------------------------------------------------------------------------------------------

_lengths = st.integers(-50_000, 50_000) | st.sampled_from((0, 500, -500, 1000))
_numbers = st.none() | st.integers(0, 9999)
_arcs = st.builds(
    Arc,
    st.tuples(st.integers(-5000, 5000), st.integers(-5000, 5000)).filter(lambda centre: centre != (0, 0)),
    st.integers(1, 4),
    st.booleans(),
)


@st.composite
def blocks(draw: st.DrawFn) -> list[Block]:
    """Blocks that can be executed one after the other: there is a feed, and no axis word meets a circle."""
    found = [Block(draw(_numbers), dimension=90, feed=draw(st.integers(1, 9000)))]
    after_arc = False
    for _ in range(draw(st.integers(1, 12))):
        if draw(st.integers(0, 4)) == 0:
            found.append(Block(draw(_numbers), arc=draw(_arcs)))
            after_arc = True
            continue
        block = draw(_straight(st.sampled_from((0, 1)) if after_arc else st.sampled_from((None, 0, 1))))
        after_arc = False
        found.append(block)
    return found


def _straight(motion: st.SearchStrategy[int | None]) -> st.SearchStrategy[Block]:
    axes = st.dictionaries(st.sampled_from(AXES), _lengths, max_size=3).map(lambda found: tuple(found.items()))
    rarely = st.integers(0, 5).map(lambda number: number == 0)

    def sometimes(values: Iterable[int]) -> st.SearchStrategy[int | None]:
        choices = list(values)
        return rarely.flatmap(lambda yes: st.sampled_from(choices) if yes else st.none())

    return st.builds(
        Block,
        number=_numbers,
        motion=motion,
        dimension=sometimes((90, 91)),
        offset=sometimes(OFFSETS),
        axes=axes,
        feed=sometimes((1, 500, 12_000)),
        function=sometimes((10, 11, 12, 13)),
        auxiliary=sometimes((20, 21)),
        tool=sometimes((1, 12)),
        speed=sometimes((500, 18_000)),
    )
