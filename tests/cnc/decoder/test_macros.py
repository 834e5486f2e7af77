"""Macros: names for pieces of NC text."""

from __future__ import annotations

from dataclasses import replace

import pytest

from runtime.cnc.decoder import ChannelMemory
from runtime.cnc.decoder.setup import Limits
from runtime.diagnostics.catalogue import language as C  # noqa: N812 - a table of constants
from tests.cnc.decoder.programs import SETUP, decode
from tests.cnc.decoder.test_variables import refused, text, value, values


def ends(program: str, **options: object) -> list[list[float]]:
    run = decode(program, **options)  # type: ignore[arg-type]
    assert run.problem is None, run.problem
    return run.ends


@pytest.mark.spec("isg.macro.define-call")
def test_a_macro_is_called_by_its_name_beside_other_words() -> None:
    program = '"MOVE" = "G00 X10" P1 = 5\nN20 "MOVE" Y7\n"MOVE"="G00 X20"\n"MOVE"\nN30 "MOVE" ZP1'
    assert ends(program) == [[10, 7, 0], [20, 7, 0], [20, 7, 5]]


@pytest.mark.spec("isg.macro.define-call")
def test_names_differ_by_case_and_blanks() -> None:
    assert values('"A" = "P1=1"\n"a" = "P2=2"\n" A" = "P3=3"\n"a"\n" A"') == {2: 2, 3: 3}


@pytest.mark.spec("isg.macro.define-call")
def test_definitions_outlive_their_program() -> None:
    memory = ChannelMemory(SETUP)
    decode('"KEPT" = "G00 X3"\nM30', memory=memory)
    assert ends('"KEPT"', memory=memory) == [[3, 0, 0]]


@pytest.mark.spec("isg.macro.define-call", "isg.macro.init-tab", "chan.macros")
@pytest.mark.parametrize("statement", ["#INIT MACRO TAB", "N5 #INIT MAKRO TAB"])
def test_configured_macros_may_be_redefined_and_come_back(statement: str) -> None:
    setup = replace(SETUP, macros={"C": "X1"})
    memory = ChannelMemory(setup)
    program = f'G00 "C"\n"C" = "X2"\n"OWN" = "X4"\n"C"\n{statement}\n"C"\nP1 = EXIST["OWN"] P2 = EXIST["C"]\n"OWN"'
    run = decode(program, setup, memory=memory)
    assert [end[0] for end in run.ends] == [1, 2, 1]
    assert run.parameters == {1: 0, 2: 1}
    assert run.problem is not None
    assert (run.problem.entry, run.problem.place.line) == (C.MACRO_UNDEFINED, 8)


@pytest.mark.spec("isg.macro.define-call")
@pytest.mark.parametrize("call", ['"NOPE"', 'G00 X1 "NOPE"', 'X["NOPE" * 2]', 'P1 = "NOPE"', '$IF "NOPE"\n$ENDIF'])
def test_a_macro_that_is_not_defined(call: str) -> None:
    run = decode(call)
    assert run.problem is not None
    assert run.problem.entry is C.MACRO_UNDEFINED
    assert "NOPE" in str(run.problem)


@pytest.mark.spec("isg.macro.define-call")
@pytest.mark.parametrize("program", ['"ABCDE" = "X1"', '"A" = "X123456789"', '"A"="X1"\n"B"="X1"\n"A"="X2"\n"C"="X1"'])
def test_macros_have_limits(program: str) -> None:
    setup = replace(SETUP, limits=Limits(macros=2, macro_name=4, macro_content=9))
    assert values('"ABCD" = "P1 = 1  "\n"B" = ""\n"ABCD"', setup=setup) == {1: 1}
    assert refused(program, setup=setup) is C.MACRO_LIMIT


@pytest.mark.spec("isg.macro.nesting")
def test_macros_in_macros_are_replaced_when_they_are_called() -> None:
    program = '"MOVE1" = "G01 \\"POS 1\\" F1000"\n"POS 1" = "X500 Y200"\nN30 "MOVE1"\n"POS 1" = "X1"\nN40 "MOVE1"'
    run = decode(program)
    assert run.ends == [[500, 200, 0], [1, 200, 0]]
    assert [row["feed"] for row in run.rows if "feed" in row] == [1000, 1000]


@pytest.mark.spec("isg.macro.nesting")
def test_expressions_of_macros_may_be_the_numbers_of_g_and_m() -> None:
    setup = replace(SETUP, m_synch={**SETUP.m_synch, 60: SETUP.m_synch[10]})
    program = (
        'N10 " STRING 1 " = " 5*12 "\nN20 " STRING 2 " = " G \\" STRING 1 \\" - 6 "\n'
        'N30 " STRING 3 " = " M \\" STRING 1 \\" \\" STRING 2 \\" "\nN200 " STRING 3 "\nG00 X0'
    )
    run = decode(program, setup)
    assert run.problem is None, run.problem
    assert [row["number"] for row in run.rows if row["type"] == "m"] == [60]
    assert run.ends == [[100, 0, 0]]  # G54


@pytest.mark.spec("isg.macro.nesting")
@pytest.mark.parametrize("content", ["G 1/2", "G 1-2", "G 1/0"])
def test_what_is_no_number_of_a_g_function(content: str) -> None:
    assert refused(f'"A" = "{content}"\n"A" X1') in (C.G_NUMBER, C.DIVISION_BY_ZERO)


@pytest.mark.spec("isg.macro.nesting")
@pytest.mark.spec("isg.macro.restrictions")
@pytest.mark.parametrize(
    "program",
    [
        '"Macro_Recursive" = "G01 X100 \\"Macro_Recursive\\""\n"Macro_Recursive"',
        '"A" = "\\"B\\""\n"B" = "\\"A\\""\n"A"',
        "\n".join(f'"M{n}" = "\\"M{n + 1}\\""' for n in range(30)) + '\n"M30" = "P1=1"\n"M0"',
    ],
)
def test_a_macro_that_calls_itself_or_is_too_deep_is_told_when_it_is_called(program: str) -> None:
    run = decode(program)
    assert run.problem is not None
    assert (run.problem.entry, run.problem.place.line) == (C.MACRO_DEPTH, program.count("\n") + 1)
    assert decode(program.rsplit("\n", 1)[0]).problem is None


@pytest.mark.spec("isg.macro.expressions")
@pytest.mark.spec("isg.lex.macro-in-expression")
def test_macros_in_expressions() -> None:
    program = (
        'N10 "STRING1" = "COS[\\"STRING2\\"]"\nN20 "STRING2" = "5 * 12"\nN30 "STRING3" = "SIN[89.5 + \\"STRING1\\"]"\n'
        'N40 G00 X[-2 * "STRING1" + "STRING2" + "STRING3"]'
    )
    assert ends(program) == [[pytest.approx(60), 0, 0]]
    assert value('"E1" * 2', 'P1 = 4\n"E1" = "3 + P1"') == 11  # text takes the place of text
    assert value('["E1"] * 2', 'P1 = 4\n"E1" = "3 + P1"') == 14
    assert values('"C" = "P1 < 3"\nP1 = 0\n$WHILE "C"\nP1 = P1 + 1\n$ENDWHILE') == {1: 3}


@pytest.mark.spec("isg.macro.expressions")
@pytest.mark.spec("isg.lex.macro-in-expression")
@pytest.mark.parametrize("content", ["COS[", "90]", "]1[", "SIN[1]]"])
def test_a_macro_holds_complete_levels_of_brackets(content: str) -> None:
    assert refused(f'"A" = "{content}"') is C.MACRO_CONTENT


@pytest.mark.spec("isg.macro.address-letter")
def test_a_macro_may_be_the_letter_of_an_address_only() -> None:
    program = (
        "%L SUB\n"
        '"1.PA" "TARGET_1.PA" "2.PA" 100\nM17\n'
        '%M\nP12 = 5 V.P.POS1 = 20\n"1.PA" = "X" "2.PA" = "Y"\n"TARGET_1.PA" = "V.P.POS1 + P12"\nG00\nLL SUB\n'
        '"1.PA" = "Z" "2.PA" = "X"\nLL SUB\nM30'
    )
    assert ends(program) == [[25, 100, 0], [100, 100, 25]]


@pytest.mark.spec("isg.macro.restrictions")
def test_no_control_statements_and_no_strings_in_macros() -> None:
    assert refused('"IF" = "$IF"') is C.MACRO_CONTENT
    assert refused('"A" = "P1 = LEN[\\"text\\"]"\n"A"') is C.MACRO_UNDEFINED
    assert values('V.P.T = "text"\n"A" = "P1 = LEN[V.P.T + LEFT[V.P.T, 1]]"\n"A"') == {1: 5}


@pytest.mark.spec("isg.lex.macro-length-content")
def test_length_and_content_of_macros() -> None:
    before = '"Macro53" = "G53 X0 Y0 Z0"\n"Empty" = ""\n"MACRO_1" = "1 + 2"\n"MACRO_2" = "SIN[\\"MACRO_1\\"]"'
    assert value('MACRO_LENGTH["Macro53"]', before) == 12
    assert value('MACRO_LENGTH["Empty"]', before) == 0
    assert value('MACRO_LENGTH["None"]', before) == -1
    assert text('MACRO_CONTENT["MACRO_1"]', before) == "1 + 2"
    assert text('MACRO_CONTENT["MACRO_2"]', before) == "SIN[1 + 2]"
    assert refused('V.P.A = MACRO_CONTENT["None"]') is C.MACRO_UNDEFINED
