"""The scan kernel and the short cut for numeric blocks against the grammar: the same text, the same meaning."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from runtime.cnc.blocks import Synch
from runtime.cnc.decoder import ChannelMemory, DecoderSetup, Offline, SpindleSetup
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.library import Library
from runtime.cnc.language.isg.comments import LineError, blank_comments
from runtime.cnc.language.isg.numeric_blocks import numeric_block
from runtime.cnc.language.isg.scan import NO_MOTION, NO_NUMBER, PlainScanner
from runtime.cnc.language.isg.words import ParsedBlock, WordKind

SETUP = DecoderSetup(
    ("X", "Y", "Z", "A", "XY"),
    (True, True, True, False, True),
    (SpindleSetup("S"),),
    m_synch={8: Synch.MOS},
    h_synch={9: Synch.MOS},
)
EXECUTION = Execution(SETUP, ChannelMemory(SETUP), Offline(), Library(SETUP.addresses, ()), np.zeros(5), lambda: 0)
ADDRESSES, PARSER = SETUP.addresses, EXECUTION.parser

# Pieces that make plain blocks, nearly plain ones and faulty ones.
pieces = st.sampled_from(
    [
        *(
            "N10",
            "N",
            "G0",
            "G01",
            "g1",
            "G2",
            "G",
            "G00",
            "X",
            "Y",
            "Z",
            "A",
            "Q",
            "F",
            "f",
            "I",
            "M8",
            "S",
            "R5",
            "P1",
        ),
        *("E", "1", "-2.5", "+3", ".5", "7.", "0.1234567890123456", "12345678901", "-", ".", "=", "[", "]", "e3", "*"),
        *("/", "%", " ", "  ", "\t", "(c)", "(a(b)c)", "(open", "(a(b", ")", ";end", "\xe4", "\r", "D1", "T2", "XY=3"),
        *("H9", "K"),
    ]
)
lines = st.lists(pieces, max_size=10).map("".join)
words = st.tuples(st.sampled_from("XYZAFGNIRMS"), st.sampled_from(["1", "0", "-2.5", ".25", "8", "04"])).map("".join)
wordy = st.lists(words, max_size=6).map(" ".join)


def scan(data: bytes, rows: int = 100) -> tuple[int, int, bool, PlainScanner]:
    scanner = PlainScanner(ADDRESSES, rows)
    return *scanner.scan(np.frombuffer(data, np.uint8), 0, True), scanner


@pytest.mark.spec("isg.lex.block-structure", "isg.lex.comments", "isg.lex.axis-names")
@given(st.one_of(lines, wordy))
@example("X10Y5=3")
@example("X10 Y5 =3")
@example("X50 -3")
@example("N5 N6")
@example("G1 G1")
@example("X1 (a) -2")
def test_a_line_that_is_plain_for_the_kernel_means_the_same_for_the_grammar(line: str) -> None:
    count, _, stopped, scanner = scan(line.encode("latin-1"))
    if count == 0:
        assert stopped or not line
        return
    parsed = PARSER.parse(line, EXECUTION.environment)
    rows = scanner.rows
    expected = {(word.kind, word.index): word.value.constant for word in parsed.words if word.value is not None}
    got: dict[tuple[WordKind, int], float | None] = {
        (WordKind.AXIS, axis): rows.values[0, axis] for axis in range(4) if rows.given[0] >> axis & 1
    }
    if not math.isnan(rows.feed[0]):
        got[WordKind.FEED, 0] = rows.feed[0]
    assert got == expected
    motion = [word.index for word in parsed.words if word.kind is WordKind.G]
    assert motion == ([] if rows.motion[0] == NO_MOTION else [rows.motion[0]])
    number = NO_NUMBER if parsed.number is None else parsed.number.constant
    assert rows.number[0] == number


@given(st.one_of(lines, wordy))
@example("G04 X5")
@example("G04 5")
@example("/1 X5")
@example("X1" * 500)
def test_the_short_cut_gives_what_the_grammar_gives(line: str) -> None:
    def result(parse: object, blanked: str) -> object:
        try:
            return parse(blanked)  # type: ignore[operator]
        except LineError as error:
            return (error.entry.id, error.column)

    try:
        blanked = blank_comments(line)
    except LineError:
        return
    short = result(lambda text: numeric_block(text, ADDRESSES), blanked)
    if short is not None:
        assert short == result(PARSER.by_grammar, blanked)


def test_the_short_cut_takes_what_cam_programs_hold() -> None:
    for line in ("N12 G02 X1.5 Y-2 I0.5 J.5", "M8", "S18000 M8 T1", "G17 G90", "X1 R-5."):
        assert isinstance(numeric_block(line, ADDRESSES), ParsedBlock), line


def test_a_hopeless_line_is_given_up_at_once() -> None:
    """A regular expression that tries all ways to split the digits would never come back here."""
    assert numeric_block("X1234567890" * 300 + "!", ADDRESSES) is None


@given(st.lists(st.one_of(wordy, lines.filter(lambda line: "\r" not in line)), max_size=20), st.integers(1, 50))
def test_scanning_in_windows_equals_scanning_at_once(texts: list[str], size: int) -> None:
    data = "\n".join(texts).encode("latin-1")
    whole, offset, _, scanner = scan(data)
    expected = scanner.rows.head(whole)
    parts: list[list[float]] = []
    position, end = 0, size
    while True:
        final = end >= len(data)
        count, behind, stopped = scanner.scan(np.frombuffer(data[:end], np.uint8), position, final)
        parts += [list(row) for row in np.column_stack([scanner.rows.given, scanner.rows.feed])[:count]]
        position = behind
        if stopped or final:
            break
        end += size
    assert position == offset
    whole_rows = np.column_stack([expected.given, expected.feed])
    assert np.array_equal(np.array(parts).reshape(-1, 2), whole_rows, equal_nan=True)


@given(st.integers(-999999999, 999999999), st.integers(0, 6))
def test_numbers_are_exact(mantissa: int, decimals: int) -> None:
    text = f"{mantissa / 10**decimals:.{decimals}f}"
    _, _, _, scanner = scan(f"X{text}".encode())
    assert scanner.rows.values[0, 0] == float(text)


def test_lines_are_counted_and_found() -> None:
    count, offset, stopped, scanner = scan(b"X1\r\n\r\n(c)\nN5 Y2 F3 ; x\nM30\nX3")
    assert (count, offset, stopped) == (4, 23, True)
    assert scanner.rows.starts[:4].tolist() == [0, 4, 6, 10]


def test_a_block_that_is_too_long_is_left_to_the_parser() -> None:
    blanks = b" " * 3998
    assert scan(b"X1" + blanks + b"\nX2")[0] == 2
    assert scan(b"X1" + blanks + b" \nX2")[0] == 0
    assert scan(b"X1" + blanks + b" ")[0] == 0


def test_the_rows_may_be_full() -> None:
    count, offset, stopped, _ = scan(b"X1\nX2\nX3", rows=2)
    assert (count, offset, stopped) == (2, 6, False)
