"""Mutants of the seed programs, the same ones for the same number: a fuzzer without any knowledge of coverage."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from pathlib import Path

SEEDS = Path(__file__).parent / "seeds"
LONGEST = 8000  # bytes of a mutant

# What the dialect is made of, and what stands at its borders.
_WORDS = r"""
% / /5 N10 N10: G0 G01 G2 G3 G4 G17 G18 G19 G53 G54 G59 G70 G71 G90 G91 G92 G94 G161 G162 G163= G301 G302 G999 G1=
X Y Z X1= XYZ= I J K R R1= A C F E S S= T D M3 M4 M5 M6 M10= M00 M02 M17 M29 M30 M999999 H20 P1 P1= PP1 P[ P1[ @P1
$IF $ELSEIF $ELSE $ENDIF $SWITCH $CASE $DEFAULT $ENDSWITCH [A] $FOR $ENDFOR $WHILE $ENDWHILE $DO $ENDDO $REPEAT $UNTIL
$BREAK $CONTINUE $RETURN V.P.A V.L.A V.S.A V.G.BLOCK_NR V.A.ACT_POS.X V.E.A V.SPDL.S V.CYC.A #VAR #ENDVAR #DELETE
#MSG #FLUSH #TIMER #ERROR #ADD #CHR #RND #ANG "M" " \" "%s%d%f"
+ - * / ** MOD & | ^ && || AND OR XOR == != <= >= < > [ ] [[ ]] ( ) ; , = \ 'H1F' '2#101' '8#17' TRUE FALSE PI
SIN[ ATAN2[ SQRT[ LN[ ROUND[ EXIST[ SIZEOF[ MIN[ LEFT[ MID[ FIND[ LEN[ ORD[ INSERT[ REPLACE[ DELETE[ INT_TO_STR[
STR_TO_REAL[ FSTRING[ MACRO_LENGTH[ 0 1 -1 .5 -.001 1e9 1e308 1e-308 4294967295 4294967296 2147483648 99999999999999999999
"""
_WITH_BLANKS = (
    *(
        "%L SUB",
        "LL SUB",
        "L fuzz.nc",
        "L CYCLE",
        "$IF 1",
        "$GOTO N10",
        "$GOTO [A]",
        "$FOR P1=1,2,1",
        "#FLUSH WAIT",
        " MOD ",
    ),
    *(
        "#MSG SAVE ",
        "#ROTATION ON",
        "#SCALE ON",
        "#COMMENT BEGIN",
        "#COMMENT END",
        "#INIT MACRO TAB",
        '"M" = ',
        " ",
        "\t",
    ),
    *("\n", "\r\n", "\n\n", "\0", "\x1a", "\x03", "\x0b", "\xe4", "\xff", "\xef\xbb\xbf"),
)
TOKENS = tuple(token.encode("latin-1") for token in (*_WORDS.split(), *_WITH_BLANKS))


def seeds() -> list[bytes]:
    """The seed programs, by name."""
    return [file.read_bytes() for file in sorted(SEEDS.glob("*.nc"))]


def mutants(number: int) -> Iterator[bytes]:
    """Mutants without end; `number` chooses the row."""
    source = random.Random(number)
    programs = seeds()
    while True:
        data = bytearray(source.choice(programs))
        for _ in range(source.choice((1, 1, 1, 2, 2, 3, 5, 8))):
            source.choice(_MUTATIONS)(data, source, programs)
        yield bytes(data[:LONGEST])


def dictionary() -> str:
    """The tokens in the form that libFuzzer reads."""
    return "".join('"' + "".join(f"\\x{byte:02x}" for byte in token) + '"\n' for token in TOKENS)


# -- one change each -----------------------------------------------------------------------------------------------

Mutation = Callable[[bytearray, random.Random, list[bytes]], None]


def _place(data: bytearray, source: random.Random) -> int:
    return source.randint(0, len(data))


def _part(data: bytes | bytearray, source: random.Random, longest: int) -> tuple[int, int]:
    begin = source.randint(0, len(data))
    return begin, min(len(data), begin + source.randint(1, longest))


def _insert_token(data: bytearray, source: random.Random, _: list[bytes]) -> None:
    at = _place(data, source)
    data[at:at] = source.choice(TOKENS)


def _replace_by_token(data: bytearray, source: random.Random, _: list[bytes]) -> None:
    begin, end = _part(data, source, 6)
    data[begin:end] = source.choice(TOKENS)


def _delete(data: bytearray, source: random.Random, _: list[bytes]) -> None:
    begin, end = _part(data, source, 12)
    del data[begin:end]


def _repeat(data: bytearray, source: random.Random, _: list[bytes]) -> None:
    begin, end = _part(data, source, 20)
    data[begin:begin] = data[begin:end] * source.choice((1, 1, 2, 10, 300))


def _change_byte(data: bytearray, source: random.Random, _: list[bytes]) -> None:
    if data:
        data[source.randrange(len(data))] = source.randrange(256)


def _change_number(data: bytearray, source: random.Random, _: list[bytes]) -> None:
    digits = [at for at, byte in enumerate(data) if 48 <= byte <= 57]
    if digits:
        at = source.choice(digits)
        data[at : at + 1] = source.choice((b"0", b"-1", b".", b"9999999999", b"1e5", b"[P1]", b"", b"5.", b"'HFF'"))


def _swap_lines(data: bytearray, source: random.Random, _: list[bytes]) -> None:
    lines = bytes(data).split(b"\n")
    first, second = source.randrange(len(lines)), source.randrange(len(lines))
    lines[first], lines[second] = lines[second], lines[first]
    data[:] = b"\n".join(lines)


def _drop_line(data: bytearray, source: random.Random, _: list[bytes]) -> None:
    lines = bytes(data).split(b"\n")
    del lines[source.randrange(len(lines))]
    data[:] = b"\n".join(lines)


def _graft(data: bytearray, source: random.Random, programs: list[bytes]) -> None:
    """Some lines of another seed."""
    lines = source.choice(programs).split(b"\n")
    begin, end = _part(b"." * len(lines), source, 6)
    at = _place(data, source)
    data[at:at] = b"\n" + b"\n".join(lines[begin:end]) + b"\n"


def _cut(data: bytearray, source: random.Random, _: list[bytes]) -> None:
    del data[_place(data, source) :]


_MUTATIONS: tuple[Mutation, ...] = (
    *(_insert_token, _replace_by_token, _delete, _repeat, _change_byte, _change_number, _swap_lines, _drop_line),
    *(_graft, _insert_token, _replace_by_token, _change_number, _cut),
)
