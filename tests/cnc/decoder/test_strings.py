"""Numbers as text, strings, EXIST, SIZEOF: what expressions can hold beside decimal numbers."""

from __future__ import annotations

import pytest

from runtime.diagnostics.catalogue import language as C  # noqa: N812 - a table of constants
from tests.cnc.decoder.programs import SETUP, decode
from tests.cnc.decoder.scripted_outside import Machine
from tests.cnc.decoder.test_variables import WITH_EXTERNAL, refused, text, value, values

# -- numbers -------------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.lex.number-formats")
@pytest.mark.parametrize(
    ("written", "expected"),
    [
        ("10", 10), ("10.0", 10), (".10", 0.1), ("'16#FA1B'", 0xFA1B), ("'0x0ED2'", 0xED2), ("'H1869f'", 0x1869F),
        ("'2#101'", 5), ("'02#101'", 5), ("'B101'", 5), ("'8#17'", 15), ("'08#17'", 15), ("'H 00ff'", 255),
    ],
)  # fmt: skip
def test_number_formats(written: str, expected: float) -> None:
    assert value(written) == expected
    assert decode(f"G00 X{written}").ends == [[expected, 0, 0]]


@pytest.mark.spec("isg.lex.integer-double")
@pytest.mark.parametrize(
    ("written", "expected"), [("1.5e2", 150), ("-1.5e-2", -0.015), ("+7", 7), ("2147483647", 2147483647)]
)
def test_integers_and_decimal_numbers(written: str, expected: float) -> None:
    assert value(written) == expected


@pytest.mark.spec("isg.lex.integer-double")
def test_e_is_the_exponent_and_capital_e_the_feed_at_the_end() -> None:
    assert decode("G01 X1e1 F100 E50").ends == [[10, 0, 0]]
    assert refused("P1 = 5000000000") is C.NUMBER_RANGE


# -- EXIST and SIZEOF ----------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.lex.exist")
def test_exist_asks_without_making_anything() -> None:
    before = '"MACRO" = "X1"\nP1 = 0\n#VAR\nV.L.ARRAY[3]\n#ENDVAR\nV.P.THERE = 1'
    asked = {
        "V.P.THERE": 1, "V.P.NOT": 0, "V.L.ARRAY[0]": 1, "V.L.ARRAY[3]": 0, "V.S.NOT": 0, "P1": 1, "P2": 0, "M10": 1,
        "M77": 0, "H20": 1, "H77": 0, '"MACRO"': 1, '"NO MACRO"': 0, "V.E.BYTE": 1, "V.E.NOT": 0, "V.L.ARRAY": 0,
    }  # fmt: skip
    words = " ".join(f"P{100 + n}=EXIST[{name}]" for n, name in enumerate(asked))
    found = values(f"{before}\n{words}\nP200 = EXIST[V.P.NOT] + EXIST[P2]", setup=WITH_EXTERNAL)
    assert [found[100 + n] for n in range(len(asked))] == list(asked.values())
    assert found[200] == 0


@pytest.mark.spec("isg.lex.sizeof")
def test_sizes_of_arrays() -> None:
    before = "#VAR\nP99[3][4]\nV.P.A[2]\nV.L.B[5][6][7][8]\nV.S.C[9]\n#ENDVAR\nP5 = 1\nV.P.SCALAR = 1"
    asked = {
        "P99": 3, "P99,1": 3, "P99,2": 4, "P99,3": -1, "V.P.A": 2, "V.L.B,4": 8, "V.L.B,5": -1, "V.S.C": 9, "P5": -1,
        "V.P.SCALAR": -1, "V.P.NOT": -1, "V.E.GRID,2": 3, "P99,0": -1,
    }  # fmt: skip
    words = " ".join(f"P{100 + n}=SIZEOF[{name}]" for n, name in enumerate(asked))
    found = values(f"{before}\n{words}", setup=WITH_EXTERNAL)
    assert [found[100 + n] for n in range(len(asked))] == list(asked.values())


# -- strings -------------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.lex.string-substrings")
@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ('"Hello" + " world!"', "Hello world!"),
        ('LEFT["Hello world!", 5]', "Hello"),
        ('LEFT["abc", 10]', "abc"),
        ('MID["How are you?", 3, 5]', "are"),
        ('RIGHT["Hello world! How are you?", 12]', "How are you?"),
        ('RIGHT["abc", 0]', ""),
        ('LEFT["a" + "bc", 1 + 1] + RIGHT["xyz", 1]', "abz"),
    ],
)
def test_strings_are_joined_and_cut(expression: str, expected: str) -> None:
    assert text(expression) == expected


@pytest.mark.spec("isg.lex.string-substrings")
def test_length_of_strings() -> None:
    assert value('LEN["Hello world! How are you?"]') == 25
    assert value('LEN[""]') == 0


@pytest.mark.spec("isg.lex.string-ord")
def test_character_values() -> None:
    found = values('P1=ORD["Hello world!", 1] P2=ORD["Hello world!", 7] P3=ORD["Hello"] P4=ORD[""] P5=ORD["", 3]')
    assert found == {1: 72, 2: 119, 3: 72, 4: 0, 5: 0}
    assert refused('P1 = ORD["abc", 4]') is C.ORD_POSITION
    assert C.ORD_POSITION.id == 21545


@pytest.mark.spec("isg.lex.string-edit")
@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ('DELETE["Hello world! How are you?", 7, 6]', "Hello How are you?"),
        ('INSERT["Hello ! How are you?", "world", 6]', "Hello world! How are you?"),
        ('INSERT["b", "a", 0]', "ab"),
        ('REPLACE["What is your name?", "age", 4, 14]', "What is your age?"),
    ],
)
def test_strings_are_edited(expression: str, expected: str) -> None:
    assert text(expression) == expected


@pytest.mark.spec("isg.lex.string-edit")
def test_places_in_strings() -> None:
    assert value('FIND["Hello world! How are you?", "How"]') == 14
    assert value('FIND["Hello world! How are you?", "today"]') == 0
    for expression in ('DELETE["abc", 1, 4]', 'INSERT["abc", "x", 4]', 'REPLACE["abc", "x", 1, 0]'):
        assert refused(f"V.P.A = {expression}") is C.STRING_POSITION


@pytest.mark.spec("isg.lex.fstring")
@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ('FSTRING["part ", 5, " of ", P1 * 2]', "part 5 of 6"),
        ('FSTRING["a", 1.5, V.P.S] + "!"', "a1.5xy!"),
        ('FSTRING[FSTRING["(", 1, ")"], FSTRING["[", -2, "]"]]', "(1)[-2]"),
        ('FSTRING["only"]', "only"),
        ('FSTRING["x=", SIN[30]] + FSTRING[" y=", LEN["abc"]]', "x=0.5 y=3"),
    ],
)
def test_composed_strings(expression: str, expected: str) -> None:
    assert text(expression, 'P1 = 3\nV.P.S = "xy"') == expected


@pytest.mark.spec("isg.lex.string-compare")
@pytest.mark.parametrize(
    ("condition", "holds"),
    [
        ('V.P.A == "Peter"', True), ('V.P.A == "peter"', False), ('V.P.A != "Steve"', True), ('V.P.A > "Bob"', True),
        ('V.P.A >= "Peter"', True), ('V.P.A > "Peter"', False), ('V.P.A < "Tim"', True), ('V.P.A <= "Peter"', True),
        ('"a" + "b" == "ab"', True), ('"Z" < "a"', True), ('"" < "a"', True),
    ],
)  # fmt: skip
def test_strings_are_compared(condition: str, holds: bool) -> None:
    program = f'V.P.A = "Peter"\n$IF {condition}\nP1 = 1\n$ELSE\nP1 = 0\n$ENDIF'
    assert values(program) == {1: float(holds)}


def test_strings_and_numbers_are_not_compared() -> None:
    assert refused('P1 = 1 == "1"') is C.KINDS_MIXED
    assert refused('V.P.A = "1"\nP1 = V.P.A == 1') is C.KINDS_MIXED


@pytest.mark.spec("isg.lex.string-conversion")
def test_conversions() -> None:
    assert text("INT_TO_STR[123]") == "123"
    assert text("INT_TO_STR[-1.9]") == "-1"
    assert text("REAL_TO_STR[12.34]") == "12.34"
    assert text("REAL_TO_STR[3]") == "3.0"
    assert values(
        'P1 = STR_TO_INT["12"] P2 = STR_TO_REAL["123.45"] P3 = STR_TO_INT["-7.9"] P4 = STR_TO_REAL[" 1e2 "]'
    ) == {
        1: 12,
        2: 123.45,
        3: -7,
        4: 100,
    }
    assert refused('P1 = STR_TO_INT["twelve"]') is C.STRING_NO_NUMBER


def test_strings_of_external_variables() -> None:
    machine = Machine()
    machine.external[32:38] = b"Peter\0"
    found = values(
        'P1 = LEN[V.E.TEXT] P2 = V.E.TEXT == "Peter"\nV.E.TEXT = LEFT[V.E.TEXT, 2] + "x"',
        setup=WITH_EXTERNAL,
        outside=machine,
    )
    assert found == {1: 5, 2: 1}
    assert bytes(machine.external[32:36]) == b"Pex\0"


@pytest.mark.parametrize(
    ("program", "entry"),
    [
        ('P1 = "a" - "b"', C.MACRO_UNDEFINED),
        ('P1 = LEN["a"] + "b"', C.KINDS_MIXED),
        ("P1 = LEN[5]", C.NUMBER_NOT_ALLOWED),
        ('P1 = SIN["a"]', C.MACRO_UNDEFINED),
        ('V.P.A = "a"\nP1 = SIN[V.P.A]', C.STRING_NOT_ALLOWED),
        ('V.P.A = "a"\nX[V.P.A]', C.STRING_NOT_ALLOWED),
    ],
)
def test_strings_and_numbers_have_their_places(program: str, entry: object) -> None:
    assert refused(program) is entry


@pytest.mark.parametrize(
    "expression", ['ENCRYPT["key", "text"]', 'BLANK_HAS_KEY["TYPE"]', 'BLANK_VALUE_OF_KEY["TYPE"]']
)
def test_functions_that_cannot_be_had_say_why(expression: str) -> None:
    run = decode(f"V.P.A = {expression}", SETUP)
    assert run.problem is not None
    assert run.problem.entry is C.FUNCTION_UNSUPPORTED
    assert expression.split("[")[0] in str(run.problem)
