"""Local, common and retained variables, and the arguments that fill the local ones (manual lines 6059–6160, 6690–6720)."""

from __future__ import annotations

import pytest

from runtime.cnc.decoder.common_variables import CommonVariables
from runtime.cnc.decoder.nct.arguments import Argument, ArgumentError, assigned
from runtime.cnc.decoder.nct.variables import Variables, no_locals
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.nct.functions import Value
from runtime.diagnostics.catalogue import nct_macros as catalogue


def unknown_read(number: int) -> Value:
    raise CalculationError(catalogue.VARIABLE_UNKNOWN, f"#{number}", number=number)


def unknown_write(number: int, value: Value) -> None:
    raise CalculationError(catalogue.VARIABLE_UNKNOWN, f"#{number}", number=number)


def variables(common: CommonVariables | None = None) -> Variables:
    level = no_locals()
    return Variables(common or CommonVariables(), lambda: level, unknown_read, unknown_write)


def test_what_was_never_written_is_vacant() -> None:
    v = variables()
    assert [v.read(number) for number in (0, 1, 33, 100, 199, 500, 599)] == [None] * 7


def test_a_vacant_value_makes_vacant_again() -> None:
    v = variables()
    for number in (7, 150, 550):
        v.write(number, 2.5)
        assert v.read(number) == 2.5
        v.write(number, None)
        assert v.read(number) is None


@pytest.mark.parametrize("number", [34, 99, 200, 499, 600])
def test_between_the_blocks_there_are_no_variables(number: int) -> None:
    with pytest.raises(CalculationError) as raised:
        variables().read(number)
    assert raised.value.entry is catalogue.VARIABLE_UNKNOWN
    with pytest.raises(CalculationError) as raised:
        variables().write(number, 1.0)
    assert raised.value.entry is catalogue.VARIABLE_UNKNOWN


def test_nothing_writes_the_vacant_one() -> None:
    with pytest.raises(CalculationError) as raised:
        variables().write(0, 1.0)
    assert raised.value.entry is catalogue.VARIABLE_READ_ONLY


def test_a_protected_range() -> None:
    common = CommonVariables(protected=(530, 540))
    common.restore({535: 4.0, 20: 1.0})
    v = variables(common)
    for number in (529, 541):
        v.write(number, 1.0)
    for number in (530, 535, 540):
        with pytest.raises(CalculationError) as raised:
            v.write(number, 1.0)
        assert raised.value.entry is catalogue.VARIABLE_PROTECTED
    assert v.read(535) == 4.0
    assert common.retained() == {529: 1.0, 535: 4.0, 541: 1.0}


def test_only_the_upper_hundred_is_retained() -> None:
    common = CommonVariables()
    v = variables(common)
    v.write(100, 1.0)
    v.write(500, 2.0)
    assert common.retained() == {500: 2.0}


@pytest.mark.parametrize("value", [-1.0, 1.5, 1e9])
def test_numbers_of_variables_are_whole(value: float) -> None:
    with pytest.raises(CalculationError) as raised:
        variables().number_of(value)
    assert raised.value.entry is catalogue.VARIABLE_NUMBER


def test_a_computed_number() -> None:
    assert variables().number_of(0.1 * 3 * 1000) == 300
    assert variables().number_of(None) == 0


# -- arguments


def given_by(text: str, more: str = "") -> list[Value]:
    words = [Argument(word[0], float(word[1:]), column) for column, word in enumerate(text.split(), 1)]
    return assigned(words, more)


def test_the_first_list() -> None:
    letters = "ABCIJKDEFHMQRSTUVWXYZ"
    numbers = [1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 13, *range(17, 27)]
    values = given_by(" ".join(f"{letter}{number}" for letter, number in zip(letters, numbers, strict=True)))
    assert {n: v for n, v in enumerate(values) if v is not None} == {n: float(n) for n in numbers}


def test_the_second_list_fills_four_to_thirty_three() -> None:
    values = given_by(" ".join(f"{letter}{3 * i + k}" for i in range(10) for k, letter in enumerate("IJK", 4)))
    assert values[4:] == [float(n) for n in range(4, 34)]


def test_both_lists_in_one_block() -> None:
    values = given_by("A2.12 B3.213 J36.9 J-12")  # line 6156
    assert (values[1], values[2], values[5], values[8]) == (2.12, 3.213, 36.9, -12.0)


@pytest.mark.parametrize(
    ("text", "entry", "column"),
    [
        ("A2.12 B3.213 J36.9 J-12 E129.73", catalogue.ARGUMENT_TWICE, 5),  # line 6156: both are #8
        ("X1 X2", catalogue.ARGUMENT_TWICE, 2),
        ("A1 G1", catalogue.ARGUMENT_ADDRESS, 2),
        ("N1", catalogue.ARGUMENT_ADDRESS, 1),
        (" ".join(["K1"] * 11), catalogue.TOO_MANY_ARGUMENTS, 11),
    ],
)
def test_arguments_that_cannot_be(text: str, entry: object, column: int) -> None:
    with pytest.raises(ArgumentError) as raised:
        given_by(text)
    assert (raised.value.entry, raised.value.column) == (entry, column)


def test_where_blocks_are_arguments_four_more_addresses_count() -> None:
    values = given_by("G1 L2 N250 P4", more="GLNP")  # line 6280
    assert (values[10], values[12], values[14], values[16]) == (1.0, 2.0, 250.0, 4.0)
