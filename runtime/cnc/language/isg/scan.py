"""The fast road for plain blocks: a kernel that reads bytes and understands nothing else.

A plain block is: optional N with digits, then any of G0 G00 G1 G01, one-letter axis words and F with plain decimal
numbers, each at most once, then optionally a comment. An empty line is plain too. Whatever else stands in a line,
also every error, makes the kernel stop in front of that line, and the full parser takes it from there; so the two can
never disagree about what is an error, and the kernel needs no messages.

    bytes ─▶ scan_plain ─▶ one row per line: values, given axes, motion, feed, number
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.cnc.language.addresses import Addresses
from runtime.cnc.language.isg.expressions import NUMBER_LIMIT
from runtime.cnc.language.text import MAX_BLOCK
from runtime.kernels import kernel, warms

Ints = npt.NDArray[np.int64]
Floats = npt.NDArray[np.float64]
Bytes = npt.NDArray[np.uint8]

NO_MOTION = -1  # in `motion`: no G0 or G1 in the line
NO_NUMBER = -1  # in `number`: no N in the line
PLUS = 32  # see `given`
MAX_DIGITS = 15  # decimal digits that a float64 holds exactly; longer numbers go to the full parser

_N, _G, _F, _NONE = 100, 101, 102, -1  # meanings of letters besides axis indices
_POWERS: Floats = np.array([10.0**k for k in range(MAX_DIGITS + 1)])


class PlainRows(NamedTuple):
    """Room for plain blocks, one row each; n axes.

    `values` (rows, n) as programmed; `given` (rows,) bit per axis, and PLUS bits higher one for a + in front of its value;
    `motion` 0, 1 or NO_MOTION; `feed` NaN if there is
    none; `number` N or NO_NUMBER; `starts` (rows,) offsets in the window.
    """

    values: Floats
    given: Ints
    motion: Ints
    feed: Floats
    number: Ints
    starts: Ints

    @classmethod
    def empty(cls, rows: int, axes: int) -> PlainRows:
        return cls(
            np.zeros((rows, axes)),
            np.zeros(rows, np.int64),
            np.zeros(rows, np.int64),
            np.zeros(rows),
            np.zeros(rows, np.int64),
            np.zeros(rows, np.int64),
        )

    def head(self, count: int) -> PlainRows:
        """The first `count` rows, copied."""
        return PlainRows(
            self.values[:count].copy(),
            self.given[:count].copy(),
            self.motion[:count].copy(),
            self.feed[:count].copy(),
            self.number[:count].copy(),
            self.starts[:count].copy(),
        )


def letters(addresses: Addresses) -> Ints:
    """The meaning of each byte as an address: axis index, N, G, F, or none."""
    table = np.full(256, _NONE, np.int64)
    for index, name in enumerate(addresses.axes):
        if len(name) == 1:
            table[ord(name)] = index
    for letter, meaning in (("N", _N), ("G", _G), ("F", _F)):
        table[ord(letter)] = table[ord(letter.lower())] = meaning
    return table


@kernel
def scan_plain(
    data: Bytes,
    begin: int,
    final: bool,
    meaning: Ints,
    powers: Floats,
    values: Floats,
    given: Ints,
    motion: Ints,
    feed: Floats,
    number: Ints,
    starts: Ints,
) -> tuple[int, int, bool]:
    """Read plain lines from `data[begin:]` until one is not plain, the rows are full or the data ends.

    `final` tells that the file ends with the data; otherwise an unfinished last line is left alone.
    Returns the count of lines, the offset behind them, and whether a line that is not plain stands there.
    """
    size = data.size
    rows = given.size
    count = 0
    line = begin
    while count < rows and line < size:
        i = line
        given_here = 0
        motion_here = NO_MOTION
        feed_here = np.nan
        number_here = NO_NUMBER
        words = 0
        plain = True
        ended = False
        limit = min(size, line + MAX_BLOCK + 1)
        while i < limit:
            c = data[i]
            if c == 32 or c == 9:  # blank, TAB
                i += 1
                continue
            if c == 10:
                ended = True
                break
            if c == 13:  # CR belongs to the line end, nowhere else
                if i + 1 < size and data[i + 1] == 10:
                    i += 1
                    ended = True
                elif i + 1 >= size and final:
                    i += 1
                else:
                    plain = False
                break
            if c == 59:  # ';' comment up to the line end
                while i < limit and data[i] != 10:
                    i += 1
                continue
            if c == 40:  # '(' comment; inner ones need their ')', the outermost one may end with the line
                depth = 0
                while i < limit and data[i] != 10:
                    if data[i] == 40:
                        depth += 1
                    elif data[i] == 41:
                        depth -= 1
                    i += 1
                    if depth == 0:
                        break
                if depth > 1:
                    plain = False
                    break
                continue
            what = meaning[c]
            if what == _NONE:
                plain = False
                break
            i += 1
            while i < limit and (data[i] == 32 or data[i] == 9):
                i += 1
            negative = False
            plus = False
            if i < limit and (data[i] == 45 or data[i] == 43):
                negative = data[i] == 45
                plus = not negative
                i += 1
            mantissa = 0
            digits = 0
            decimals = 0
            point = False
            while i < limit:
                d = data[i]
                if 48 <= d <= 57:
                    mantissa = mantissa * 10 + (int(d) - 48)
                    digits += 1
                    if point:
                        decimals += 1
                    if digits > MAX_DIGITS:
                        break
                elif d == 46 and not point:
                    point = True
                else:
                    break
                i += 1
            if digits == 0 or digits > MAX_DIGITS:
                plain = False
                break
            if i < limit:
                # What may stand behind a number: line end, comment, or the next word. Anything else (an operator, "e",
                # "=", a second number) is for the full parser; so is a blank followed by such a thing.
                j = i
                while j < limit and (data[j] == 32 or data[j] == 9):
                    j += 1
                if j < limit:
                    d = data[j]
                    if not (d == 10 or d == 13 or d == 59 or d == 40 or meaning[d] != _NONE):
                        plain = False
                        break
            value = mantissa / powers[decimals]
            if value > NUMBER_LIMIT:
                plain = False
                break
            if negative:
                value = -value
            if what == _N:
                if words > 0 or point or negative:
                    plain = False
                    break
                number_here = mantissa
            elif what == _G:
                if point or negative or mantissa > 1 or motion_here != NO_MOTION:
                    plain = False
                    break
                motion_here = mantissa
            elif what == _F:
                if not np.isnan(feed_here):
                    plain = False
                    break
                feed_here = value
            else:
                bit = 1 << what
                if given_here & bit:
                    plain = False
                    break
                given_here |= bit
                if plus:
                    given_here |= bit << PLUS
                values[count, what] = value
            words += 1
        if not plain:
            while i < limit and data[i] != 10:
                i += 1
            # In an unfinished line nothing can be told yet, it may just be cut.
            return count, line, final or i < size
        if not ended:
            if i >= size and final and size - line <= MAX_BLOCK:
                i = size - 1
            elif i >= size and not final:
                return count, line, False
            else:
                return count, line, True  # longer than a block may be
        if i - line > MAX_BLOCK:
            return count, line, True
        given[count] = given_here
        motion[count] = motion_here
        feed[count] = feed_here
        number[count] = number_here
        starts[count] = line
        count += 1
        line = i + 1
    return count, line, False


class PlainScanner:
    """Scans windows of one program for plain blocks into rows that it reuses."""

    def __init__(self, addresses: Addresses, rows: int) -> None:
        self._meaning = letters(addresses)
        self.rows = PlainRows.empty(rows, len(addresses.axes))

    def scan(self, data: Bytes, begin: int, final: bool) -> tuple[int, int, bool]:
        """See `scan_plain`; what was read stands in `rows`."""
        count, offset, stopped = scan_plain(data, begin, final, self._meaning, _POWERS, *self.rows)
        return int(count), int(offset), bool(stopped)


@warms("plain NC blocks")
def _warm() -> None:
    scanner = PlainScanner(Addresses(("X", "Y", "Z")), 2)
    scanner.scan(np.frombuffer(b"N1 G01 X1.5 F100\nX2\n", np.uint8), 0, True)
