"""Standard functions and conversions against the standard's rules and against laws."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.plc_logic import PlcError
from runtime.plc_logic import conversions as conv
from runtime.plc_logic import iec_functions as iec
from runtime.plc_logic.iec_time import TIME, TIME_TO_STRING

WORD = st.integers(0, 2**16 - 1)
COUNT = st.integers(0, 40)
TEXT = st.text(max_size=20)


@given(WORD, COUNT)
def test_rotations_lose_no_bit_and_undo_each_other(word: int, n: int) -> None:
    turned = iec.ROL(word, n, 16)
    assert iec.ROR(turned, n, 16) == word
    assert turned.bit_count() == word.bit_count()
    assert iec.ROL(word, 1, 16) == (word * 2 % 2**16) + word // 2**15


@given(WORD, COUNT)
def test_shifts_fill_with_zero_and_stay_in_their_width(word: int, n: int) -> None:
    assert iec.SHL(word, n, 16) == word * 2**n % 2**16
    assert iec.SHR(word, n, 16) == word // 2**n
    assert iec.NOT(word, 16) == 2**16 - 1 - word


@given(st.integers(0, 2**40))
def test_gray_codes_of_neighbours_differ_in_one_bit(value: int) -> None:
    assert iec.GRAY_TO_INT(iec.INT_TO_GRAY(value)) == value
    assert (iec.INT_TO_GRAY(value) ^ iec.INT_TO_GRAY(value + 1)).bit_count() == 1


@given(st.lists(st.booleans(), min_size=1, max_size=64), st.data())
def test_bits_go_into_numbers_and_back(bits: list[bool], data: st.DataObject) -> None:
    number = iec.PACK(*bits)
    assert list(iec.UNPACK(number, len(bits))) == bits
    place = data.draw(st.integers(0, len(bits) - 1))
    assert iec.BIT(number, place) is bits[place]
    turned = iec.SET_BIT(number, place, not bits[place])
    assert iec.BIT(turned, place) is not bits[place]
    assert iec.SET_BIT(turned, place, bits[place]) == number


@given(st.integers(-(10**6), 10**6), st.integers(-1000, 1000).filter(bool))
def test_division_goes_towards_zero_and_the_rest_has_the_sign_of_the_dividend(a: int, b: int) -> None:
    assert iec.DIV(a, b) == math.trunc(a / b)
    assert iec.MOD(a, b) == int(math.fmod(a, b))


@given(TEXT, st.data())
def test_strings_are_cut_and_joined(text: str, data: st.DataObject) -> None:
    at = data.draw(st.integers(0, len(text)))
    assert iec.CONCAT(iec.LEFT(text, at), iec.RIGHT(text, len(text) - at)) == text
    put = iec.INSERT(text, "#*", at)
    assert iec.MID(put, 2, at + 1) == "#*"
    assert iec.DELETE(put, 2, at + 1) == text
    assert iec.REPLACE(put, "", 2, at + 1) == text
    found = iec.FIND(put, "#*")
    assert found == put.index("#*") + 1
    assert iec.FIND(text, "#*?") in (0, text.find("#*?") + 1)


def test_selection_and_comparison() -> None:
    assert (iec.SEL(False, 1, 2), iec.SEL(True, 1, 2)) == (1, 2)
    assert iec.MUX(2, "a", "b", "c") == "c"
    assert [iec.LIMIT(0, value, 10) for value in (-1, 5, 11)] == [0, 5, 10]
    assert (iec.MAX(1, 3, 2), iec.MIN(1, 3, 2)) == (3, 1)
    assert iec.GT(3, 2, 1)
    assert not iec.GT(3, 3)
    assert iec.GE(3, 3, 1)
    assert not iec.GE(1, 3)
    assert iec.LT(1, 2, 3)
    assert not iec.LT(1, 1)
    assert iec.LE(1, 1, 2)
    assert not iec.LE(2, 1)
    assert iec.EQ("a", "a", "a")
    assert not iec.EQ(1, 1, 2)
    assert iec.NE(1, 2)
    assert [iec.SIGN(value) for value in (-3.0, 0.0, 2.0)] == [-1, 0, 1]


@given(st.floats(4, 20))
def test_scaling_and_curves_go_through_their_points(current: float) -> None:
    bar = iec.SCALE(current, 4.0, 20.0, 0.0, 10.0)
    assert bar == pytest.approx((current - 4.0) / 1.6)
    assert iec.CHARCURVE(current, (4.0, 0.0), (12.0, 5.0), (20.0, 10.0)) == pytest.approx(bar)
    assert iec.CHARCURVE(3.0, (4.0, 1.0), (20.0, 10.0)) == 1.0
    assert iec.CHARCURVE(30.0, (4.0, 1.0), (20.0, 10.0)) == 10.0


@pytest.mark.parametrize(
    "call",
    [
        lambda: iec.MUX(2, 1, 2),
        lambda: iec.MUX(-1, 1, 2),
        lambda: iec.DIV(1, 0),
        lambda: iec.SQRT(-1),
        lambda: iec.EXPT(0.0, -1.0),
        lambda: iec.EXPT(-1.0, 0.5),
        lambda: iec.SCALE(1, 2, 2, 0, 1),
        lambda: iec.CHARCURVE(1, (2, 0), (1, 0)),
        lambda: iec.CHARCURVE(1),
        lambda: iec.SHL(1, -1),
        lambda: iec.SHL(1, 1, 12),
        lambda: iec.LEFT("abc", 4),
        lambda: iec.RIGHT("abc", 4),
        lambda: iec.MID("abc", 1, 0),
        lambda: iec.INSERT("abc", "", 4),
        lambda: iec.DELETE("abc", 2, 3),
        lambda: conv.BCD_TO_INT(0x1A),
        lambda: conv.INT_TO_BCD(-1),
        lambda: conv.TO_INT("x"),
        lambda: conv.TO_INT(math.inf),
        lambda: conv.TO_REAL(1e39),
        lambda: TIME("T#"),
        lambda: TIME("T#1m1h"),
        lambda: TIME("T#1.5m1s"),
        lambda: TIME("5"),
    ],
)
def test_what_has_no_result_is_told(call: Callable[[], object]) -> None:
    with pytest.raises(PlcError) as caught:
        call()
    assert caught.value.problem.text
    assert caught.value.problem.hint


@given(st.sampled_from(sorted(conv.RANGES)), st.integers(-(2**70), 2**70))
def test_whole_numbers_fit_or_are_refused(kind: str, value: int) -> None:
    low, high = conv.RANGES[kind]
    convert = getattr(conv, f"TO_{kind}")
    if low <= value <= high:
        assert convert(value) == value == convert(str(value))
    else:
        with pytest.raises(PlcError, match=str(high)):
            convert(value)
    assert convert(low) == low
    assert convert(high) == high


@given(st.sampled_from(sorted(conv.WIDTHS)), st.integers(-(2**70), 2**70))
def test_bit_strings_take_the_lowest_bits(kind: str, value: int) -> None:
    assert getattr(conv, f"TO_{kind}")(value) == value % 2 ** conv.WIDTHS[kind]


def test_real_numbers_round_to_the_nearest_even() -> None:
    assert [conv.TO_INT(value) for value in (0.5, 1.5, 2.5, -0.5, -1.5, 2.4, -2.6)] == [0, 2, 2, 0, -2, 2, -3]
    assert [iec.TRUNC(value) for value in (2.9, -2.9)] == [2, -2]
    assert conv.TO_REAL(0.1) == struct.unpack("<f", struct.pack("<f", 0.1))[0] != 0.1


def test_texts() -> None:
    assert conv.TO_INT("16#7FFF") == 32767
    assert conv.TO_BYTE("2#1010_0001") == 0xA1
    assert conv.TO_INT("-16#10") == -16
    assert conv.TO_LREAL(" 1.5E3 ") == 1500.0
    assert conv.TO_BOOL("TRUE")
    assert not conv.TO_BOOL("0")
    assert [conv.TO_STRING(value) for value in (True, 12, 0.1, "x")] == ["TRUE", "12", "0.1", "x"]
    assert conv.BCD_TO_INT(0x1234) == 1234
    assert conv.INT_TO_BCD(1234) == 0x1234


@given(st.integers(-(10**12), 10**12))
def test_durations_are_spelt_and_read(milliseconds: int) -> None:
    seconds = milliseconds / 1000
    assert TIME(TIME_TO_STRING(seconds)) == pytest.approx(seconds, abs=1e-6)


def test_duration_literals() -> None:
    assert TIME("T#1h30m") == 5400.0
    assert TIME("time#-2.5s") == -2.5
    assert TIME("T#1d_2h_3m_4s_5ms") == pytest.approx(93_784.005)
    assert TIME("250us") == pytest.approx(0.00025)
    assert TIME_TO_STRING(5405.25) == "T#1h30m5s250ms"
    assert TIME_TO_STRING(0) == "T#0s"
    assert conv.TO_TIME(1500) == 1.5
    assert conv.TO_TIME("T#2s") == 2.0
