"""Arithmetic of the NCT dialect; expected values from the manual (lines 6640–6689, 7260–7434) or from the definition."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.nct import functions as f
from runtime.diagnostics.catalogue import nct_macros as catalogue

FULFILLED_WITH_VACANT = {("EQ", None), ("NE", 0.0), ("GE", None), ("GT", 0.0)}


@pytest.mark.parametrize(("operator", "right"), sorted(FULFILLED_WITH_VACANT, key=str))
def test_a_vacant_left_side_fulfils_what_zero_does_not(operator: str, right: float | None) -> None:
    compare = f.COMPARISONS[operator]
    assert compare(None, right)
    assert not compare(0.0, right)


@given(st.one_of(st.none(), st.floats(-1e6, 1e6)), st.one_of(st.none(), st.floats(-1e6, 1e6)))
def test_comparisons_are_an_order(a: float | None, b: float | None) -> None:
    holds = {name: compare(a, b) for name, compare in f.COMPARISONS.items()}
    assert holds["EQ"] is not holds["NE"]
    assert holds["LT"] is not holds["GE"]
    assert holds["GT"] is not holds["LE"]
    assert (holds["LT"], holds["EQ"], holds["GT"]).count(True) == 1


def test_a_vacant_value_counts_as_zero_and_the_result_is_not_vacant() -> None:
    assert f.multiply(None, 3.0) == 0.0
    assert f.add(None, None) == 0.0
    assert f.add(None, 2.0) == 2.0
    assert f.negate(None) == 0.0
    assert math.copysign(1.0, f.negate(0.0)) == 1.0  # no negative zero in a display


@pytest.mark.parametrize(
    ("name", "operand", "value"),
    [
        ("FIX", 4.8, 4.0),  # lines 7380–7392
        ("FIX", -6.7, -6.0),
        ("FUP", 12.1, 13.0),
        ("FUP", -7.3, -8.0),
        ("FUP", 12.0, 12.0),
        ("FUP", 0.1 * 3 * 10, 3.0),  # 3.0000000000000004 as a float
        ("FIX", 0.29 * 100, 29.0),  # 28.999999999999996
        ("BCD", 19.0, 0x19),
        ("BCD", 99_999_999.0, 0x99999999),
        ("BIN", 0x19, 19.0),
        ("BIN", 0x99999999, 99_999_999.0),
        ("BIN", 0.0, 0.0),
        ("SIN", 180.0, 0.0),
        ("SIN", 30.0, 0.5),
        ("COS", 60.0, 0.5),
        ("TAN", 45.0, 1.0),
        ("ASIN", -1.0, -90.0),
        ("ACOS", -1.0, 180.0),
        ("ATAN", -1.0, -45.0),
        ("SQRT", 9.0, 3.0),
        ("EXP", 0.0, 1.0),
        ("LN", math.e, 1.0),
        ("ABS", -3.5, 3.5),
        ("NOT", 0.0, -1.0),
        ("NOT", 5.0, -6.0),
    ],
)
def test_functions(name: str, operand: float, value: float) -> None:
    assert f.FUNCTIONS[name].call(float(operand)) == pytest.approx(value, abs=1e-12)


@given(st.integers(0, 99_999_999))
def test_bin_undoes_bcd(n: int) -> None:
    assert f.from_decimal_code(f.to_decimal_code(float(n))) == n


@given(st.integers(-(2**31), 2**31 - 1), st.integers(-(2**31), 2**31 - 1))
def test_bits_obey_de_morgan(a: int, b: int) -> None:
    left = f.bit_not(f.bit_and(float(a), float(b)))
    assert left == f.bit_or(f.bit_not(float(a)), f.bit_not(float(b)))
    assert f.bit_xor(float(a), float(b)) == f.bit_and(f.bit_or(float(a), float(b)), left)


def test_arithmetic() -> None:
    assert f.modulo(27.0, 4.0) == 3.0  # line 7322
    assert f.modulo(-27.0, 4.0) == -3.0
    assert f.divide(7.0, 2.0) == 3.5
    assert f.subtract(2.0, 5.0) == -3.0


@pytest.mark.parametrize(
    ("call", "entry", "name"),
    [
        (lambda: f.divide(1.0, 0.0), catalogue.DIVISION_BY_ZERO, "/"),
        (lambda: f.divide(1.0, None), catalogue.DIVISION_BY_ZERO, "/"),
        (lambda: f.modulo(1.0, 0.0), catalogue.DIVISION_BY_ZERO, "MOD"),
        (lambda: f.bit_and(2.0**31, 1.0), catalogue.BITS, "AND"),
        (lambda: f.bit_or(1.0, -(2.0**31) - 1), catalogue.BITS, "OR"),
        (lambda: f.bit_xor(1e12, 1.0), catalogue.BITS, "XOR"),
        (lambda: f.bit_not(2.0**31), catalogue.BITS, "NOT"),
        (lambda: f.square_root(-1.0), catalogue.DOMAIN, "SQRT"),
        (lambda: f.natural_logarithm(0.0), catalogue.DOMAIN, "LN"),
        (lambda: f.natural_logarithm(None), catalogue.DOMAIN, "LN"),
        (lambda: f.arc_sine(1.001), catalogue.DOMAIN, "ASIN"),
        (lambda: f.arc_cosine(-1.001), catalogue.DOMAIN, "ACOS"),
        (lambda: f.tangent(-270.0), catalogue.DOMAIN, "TAN"),
        (lambda: f.exponential(1e4), catalogue.RESULT_RANGE, "EXP"),
        (lambda: f.multiply(1e200, 1e200), catalogue.RESULT_RANGE, "*"),
        (lambda: f.to_decimal_code(-1.0), catalogue.DECIMAL_CODE, "BCD"),
        (lambda: f.to_decimal_code(1e8), catalogue.DECIMAL_CODE, "BCD"),
        (lambda: f.from_decimal_code(10.0), catalogue.DECIMAL_CODE, "BIN"),  # 16#A
        (lambda: f.from_decimal_code(-5.0), catalogue.DECIMAL_CODE, "BIN"),
    ],
)
def test_what_has_no_value_is_an_error(call: object, entry: object, name: str) -> None:
    with pytest.raises(CalculationError) as raised:
        call()  # type: ignore[operator]
    assert (raised.value.entry, raised.value.name) == (entry, name)


@pytest.mark.parametrize(("value", "nearest"), [(1.23, 1), (1.6, 2), (2.5, 3), (-2.5, -3), (-1.4, -1)])
def test_addresses_take_the_nearest_whole_number(value: float, nearest: int) -> None:
    assert f.whole(value) == nearest  # 1.23 and 1.6: lines 6610–6615
