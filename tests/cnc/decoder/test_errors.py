"""Every error of the language: the right id at the right place, and nothing decoded before a faulty file is told."""

from __future__ import annotations

import os
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from runtime.cnc.blocks import Synch
from runtime.cnc.decoder import Decoder, DecoderSetupError, ProgramError, SpindleSetup, load_program, parse_synch
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.catalogue import tools
from runtime.diagnostics.errors import ErrorEntry, Problem
from tests.cnc.decoder.programs import SETUP, decode, found, problems, without_spindle

C = catalogue

# text, entry, line, column
STATIC: list[tuple[str, ErrorEntry, int, int]] = [
    ("%L A\nX1\nM17\n", C.MAIN_MISSING, 0, 0),
    ("(nothing)\n\n", C.MAIN_MISSING, 0, 0),
    ("%MAIN X10\nM30", C.HEADER_INVALID, 1, 7),
    ("%L (sub)\nM17\n%M\nM30", C.HEADER_NAME, 1, 1),
    ("%MAIN\nM30\n%L LATE\nM17\n", C.HEADER_LATE, 3, 1),
    ("N10\n%MAIN\nM30\n", C.HEADER_LATE, 2, 1),
    ("%L A\nM17\n%L A\nM17\n%M\nM30", C.LOCAL_TWICE, 3, 1),
    ("N1 LL NOWHERE\nM30", C.LOCAL_MISSING, 1, 4),
    ("L nowhere.nc\nM30", C.GLOBAL_MISSING, 1, 1),
    ("X1" + " " * 4000 + "\nM30", C.BLOCK_TOO_LONG, 1, 4001),
    ("X1 \xe4\nM30", C.CHARACTER_INVALID, 1, 4),
    ("X1..5\nM30", C.SYNTAX, 1, 4),
    ("X[1+[2*3]\nM30", C.BRACKET_OPEN, 1, 2),
    ("X[1+2]]\nM30", C.BRACKET_CLOSE, 1, 7),
    ("X1 (outer (inner\nM30", C.COMMENT_OPEN, 1, 11),
    ("X1 ) Y2\nM30", C.COMMENT_CLOSE, 1, 4),
    ("G01 X Y5\nM30", C.VALUE_MISSING, 1, 7),
    ("G01 X\nM30", C.VALUE_MISSING, 1, 5),
    ("x10\nM30", C.ADDRESS_UNKNOWN, 1, 1),
    ("G00 A5\nM30", C.AXIS_UNKNOWN, 1, 5),
    ("X50P1=7\nM30", C.AXIS_UNKNOWN, 1, 1),
    ("S2=500\nM30", C.SPINDLE_UNKNOWN, 1, 1),
    ("N1 G777\nM30", C.G_UNKNOWN, 1, 4),
    ("N1 G66 X5\nM30", C.G_UNSUPPORTED, 1, 4),
    ("G00 X1 G01\nM30", C.G_GROUP_TWICE, 1, 8),
    ("G90 X1 G90\nM30", C.G_GROUP_TWICE, 1, 8),
    ("G17 G18\nM30", C.G_GROUP_TWICE, 1, 5),
    ("G17=3\nM30", C.G_VALUE, 1, 1),
    ("G163\nM30", C.G_VALUE_MISSING, 1, 1),
    ("X1 Y2 X3\nM30", C.WORD_TWICE, 1, 7),
    ("F1 F2\nM30", C.WORD_TWICE, 1, 4),
    ("G04 2 X5\nM30", C.NOT_ALONE, 1, 1),
    ("$FOO\nM30", C.CONTROL_UNKNOWN, 1, 1),
    ("X1 $IF 1\nM30", C.CONTROL_PLACE, 1, 4),
    ("$FOR P1 = 1, 2\nM30", C.CONTROL_INCOMPLETE, 1, 15),
    ("N5 #ECS ON\nM30", C.STATEMENT_UNSUPPORTED, 1, 4),
    ("X[V.A.TORQUE_NOM.X]\nM30", C.VARIABLE_UNSUPPORTED, 1, 3),
    ("X[V.A.NONE.X]\nM30", C.VARIABLE_UNKNOWN, 1, 3),
    ("V.G.PROG_LEVEL = 3\nM30", C.VARIABLE_READ_ONLY, 1, 1),
    ("X1 $GOTO\nM30", C.CONTROL_INCOMPLETE, 1, 9),
    ("N1 $IF 1 $GOTO [A] X1\nM30", C.ADDRESS_UNKNOWN, 1, 20),
    ("N10: X1 N20\nM30", C.ADDRESS_UNKNOWN, 1, 9),
    ("X10 \\ Y10\nM30", C.NOT_SUPPORTED, 1, 5),
    ("#FLUSH \\\nWAIT\nM30", C.CONTINUATION, 1, 8),
    ("L CYCLE [NAME=a @P1=1]\nM30", C.GLOBAL_MISSING, 1, 15),
    ("L CYCLE [NAME=a @Q=1]\nM30", C.KEY_UNKNOWN, 1, 17),
    ("X=R1\nM30", C.NOT_SUPPORTED, 1, 3),
    ("/11 X1\nM30", C.SKIP_LEVEL, 1, 1),
    ("$ENDIF\nM30", C.CONTROL_WITHOUT_START, 1, 1),
    ("$IF 1\n$ENDWHILE\n$ENDIF\nM30", C.CONTROL_WITHOUT_START, 2, 1),
    ("$IF 1\n$ELSE\n$ELSE\n$ENDIF\nM30", C.CONTROL_WITHOUT_START, 3, 1),
    ("N1 $WHILE 1\nX1\nM30", C.CONTROL_OPEN, 1, 4),
    ("%L A\n$IF 1\nM17\n%B\n$ENDIF\nM30", C.CONTROL_OPEN, 2, 1),
    ("$IF 1\n" * 101 + "$ENDIF\n" * 100 + "M30", C.CONTROL_DEPTH, 101, 1),
    ("X9999999999\nM30", C.NUMBER_RANGE, 1, 2),
    ("P1=1e300\nM30", C.NUMBER_RANGE, 1, 4),
    ("X'16#FG'\nM30", C.LITERAL_BASE, 1, 2),
    ("X" + "SIN[" * 70 + "1" + "]" * 70 + "\nM30", C.EXPRESSION_DEPTH, 1, 38),
    ("X" + "EXIST[M" * 300 + "1" + "]" * 300 + "\nM30", C.EXPRESSION_DEPTH, 1, 1885),
    ("X FOO[1]\nM30", C.FUNCTION_UNKNOWN, 1, 3),
    ("X ATAN2[1]\nM30", C.FUNCTION_ARGUMENTS, 1, 3),
    ("P0 = 1\nM30", C.PARAMETER_INDEX, 1, 1),
    ("M77\nM30", C.M_UNDEFINED, 1, 1),
    ("X1 H77\nM30", C.H_UNDEFINED, 1, 4),
    ("M-1\nM30", C.FUNCTION_NEGATIVE, 1, 1),
    ("M3=5\nM30", C.VALUE_NOT_ALLOWED, 1, 1),
    ("M3 M5\nM30", C.SPINDLE_M_TWICE, 1, 4),
]

# text, entry, line, column; found while decoding
DYNAMIC: list[tuple[str, ErrorEntry, int, int]] = [
    ("G74 X0\nM30", C.HOMING_ORDER, 1, 1),
    ("N1 G74 X1.5\nM30", C.HOMING_ORDER, 1, 4),
    ("G201 X0\n#HANDWHEEL [AX=X RES1=1]\nM30", C.MANUAL_ACTIVE, 2, 1),
    ("#HANDWHEEL [AX=X AXNR=1 RES1=1]\nM30", C.MANUAL_AXIS, 1, 1),
    ("#HANDWHEEL [RES1=1]\nM30", C.MANUAL_AXIS, 1, 1),
    ("#JOG CONT [AX=X FEED1=0]\nM30", C.MANUAL_STAGE, 1, 23),
    ("#JOG INCR [AX=X DIST1=1 FEED1=100 DIST2=1]\nM30", C.MANUAL_PAIR, 1, 1),
    ("#MANUAL LIMITS [AX=X NEGATIVE=1 POSITIVE=2]\nM30", C.MANUAL_SIGN, 1, 1),
    ("D1\nM30", tools.TOOL_MISSING, 1, 1),
    ("X1 F1 $GOTO N10\nM30", C.LABEL_MISSING, 1, 7),
    ("G81\nM30", C.CALL_FILE, 1, 1),
    ("X[V.P.A]\nM30", C.VARIABLE_UNSET, 1, 3),
    ("P1 = @P3\nM30", C.TRANSFER_OUTSIDE, 1, 6),
    ("N1 $BREAK\nM30", C.OUTSIDE_LOOP, 1, 4),
    ("V.P.A = 1\nN2 L SEQUENCE [N9]\nM30", C.SEQUENCE_MISSING, 2, 4),
    ("P1 = 0\nX[5 / P1]\nM30", C.DIVISION_BY_ZERO, 2, 5),
    ("P1 = 5 MOD 0\nM30", C.DIVISION_BY_ZERO, 1, 8),
    ("P1 = 0 ** -1\nM30", C.DIVISION_BY_ZERO, 1, 8),
    ("P1 = SQRT[-1]\nM30", C.DOMAIN, 1, 6),
    ("P1 = LN[0]\nM30", C.DOMAIN, 1, 6),
    ("P1 = LOG[-1]\nM30", C.DOMAIN, 1, 6),
    ("P1 = ASIN[1.5]\nM30", C.DOMAIN, 1, 6),
    ("P1 = ACOS[-1.5]\nM30", C.DOMAIN, 1, 6),
    ("P1 = TAN[90]\nM30", C.DOMAIN, 1, 6),
    ("P1 = COT[180]\nM30", C.DOMAIN, 1, 6),
    ("P1 = [-8] ** 0.5\nM30", C.DOMAIN, 1, 11),
    ("P1 = EXP[1000]\nM30", C.RESULT_RANGE, 1, 6),
    ("P1 = 4000000000 * 2\nM30", C.RESULT_RANGE, 1, 1),
    ("N[-5]\nM30", C.RESULT_RANGE, 1, 1),
    ("P1 = [-1] & 3\nM30", C.OPERAND_NEGATIVE, 1, 11),
    ("P1 = INV[-1]\nM30", C.OPERAND_NEGATIVE, 1, 6),
    ("P1 = NOT[-1]\nM30", C.OPERAND_NEGATIVE, 1, 6),
    ("P1 = 1 AND [-1]\nM30", C.OPERAND_NEGATIVE, 1, 8),
    ("X[P5 + 1]\nM30", C.PARAMETER_UNSET, 1, 3),
    ("P1 = 0\nP[P1] = 5\nM30", C.PARAMETER_INDEX, 2, 1),
    ("P1 = 77\nM P1\nM30", C.M_UNDEFINED, 2, 1),
    ("P1 = -3\nX1 F1 H P1\nM30", C.FUNCTION_NEGATIVE, 2, 7),
    ("P1 = 3\nMP1 M4\nM30", C.SPINDLE_M_TWICE, 2, 5),
    ("S-5\nM30", C.SPEED_NEGATIVE, 1, 1),
    ("T[-1]\nM30", C.FUNCTION_NEGATIVE, 1, 1),
    ("%L A\nLL A\nM17\n%B\nLL A\nM30", C.CALL_DEPTH, 2, 1),
    ("$WHILE 1\nP1 = 1\n$ENDWHILE\nM30", C.ENDLESS_LOOP, 2, 0),
    ("G01 X5\nM30", C.FEED_MISSING, 1, 5),
    ("X5\nM30", C.FEED_MISSING, 1, 1),
    ("G01 X5 F0\nM30", C.FEED_INVALID, 1, 8),
    ("G00 X5 F-3\nM30", C.FEED_INVALID, 1, 8),
    ("G194 F100 G01 X5\nM30", C.FEED_PERCENT, 1, 6),
    ("G93 G01 X5 F2 E50\nM30", C.END_FEED_MODE, 1, 15),
    ("G01 G193 X5 F100\nM30", C.FEED_CHANGE_START, 1, 5),
    ("G95 F1\nG01 G293 X5\nM30", C.FEED_CHANGE_START, 2, 5),
    ("G00 X300000\nM30", C.POSITION_RANGE, 1, 5),
    ("G54\nG00 X213990\nM30", C.POSITION_RANGE, 2, 5),
    ("G02 X5 Y5 F100\nM30", C.CENTRE_MISSING, 1, 5),
    ("G02 Z5 F100\nM30", C.CENTRE_MISSING, 1, 5),
    ("G02 X10 R4 F100\nM30", C.RADIUS_TOO_SMALL, 1, 5),
    ("G02 X0 Y0 R4 F100\nM30", C.RADIUS_FULL_CIRCLE, 1, 5),
    ("G02 X10 Y0 I3 F100\nM30", C.CENTRE_DEVIATION, 1, 5),
    ("G02 I0 F100\nM30", C.RADIUS_ZERO, 1, 1),
    ("G02 X5 R0 F100\nM30", C.RADIUS_ZERO, 1, 5),
    ("G02 X5 R2000000000 F100\nM30", C.RADIUS_RANGE, 1, 5),
    ("G02 X10 I5 R5 F100\nM30", C.CENTRE_AND_RADIUS, 1, 12),
    ("G01 X10 I5 F100\nM30", C.CENTRE_WITHOUT_CIRCLE, 1, 9),
    ("G02 X10 Z5 I5 K-2 F100\nM30", C.PITCH_INVALID, 1, 15),
    ("G04 -1\nM30", C.DWELL_NEGATIVE, 1, 1),
    ("G04 S10\nM30", C.DWELL_SPEED, 1, 1),
]


@pytest.mark.spec("isg.lex.block-structure", "isg.g.g-function-system", "isg.flow.control-block-rules")
@pytest.mark.parametrize(("text", "entry", "line", "column"), STATIC)
def test_the_check_finds_it(text: str, entry: ErrorEntry, line: int, column: int) -> None:
    with pytest.raises(ProgramError) as caught:
        decode(text.encode("latin-1"))
    first = caught.value.problem
    assert (first.entry, first.place.line, first.place.column) == (entry, line, column), first
    assert first.explained()  # text and remedy can be filled in


@pytest.mark.spec("isg.lex.units-ranges", "isg.param.scalar", "isg.lex.numeric-functions", "isg.lex.trigonometry")
@pytest.mark.parametrize(("text", "entry", "line", "column"), DYNAMIC)
def test_the_decoder_finds_it(text: str, entry: ErrorEntry, line: int, column: int) -> None:
    run = decode(text)
    assert run.problem is not None
    assert (run.problem.entry, run.problem.place.line, run.problem.place.column) == (entry, line, column), run.problem
    assert run.problem.explained()


def test_what_comes_before_an_error_of_execution_is_decoded() -> None:
    run = decode("G00 X1\nX2\nP1 = 1 / 0\nX3\nM30")
    assert run.ends == [[1, 0, 0], [2, 0, 0]]


@pytest.mark.spec("isg.flow.control-block-rules")
def test_nothing_is_decoded_of_a_file_with_a_fault_at_its_end() -> None:
    with pytest.raises(ProgramError):
        decode("G00 X1\nX2\nM30\nG777")


def test_all_faulty_lines_are_told_but_not_more_than_twenty() -> None:
    assert [line for _, line, _ in found("G777\nX1\nM77\nG66\nM30")] == [1, 3, 4]
    assert len(problems("G777\n" * 50 + "M30")) == 20


def test_a_faulty_loop_is_told_once() -> None:
    assert [entry for entry, _, _ in found("$WHILE V.G.X\nX1\n$ENDWHILE\nM30")] == [C.VARIABLE_UNKNOWN]


def test_spindle_words_without_a_spindle() -> None:
    for text in ("S100", "M3", "G04 S3"):
        assert [entry for entry, _, _ in found(f"{text}\nM30", without_spindle())] == [C.SPINDLE_MISSING]


def test_locked_spindle_functions() -> None:
    setup = replace(SETUP, spindles=(SpindleSetup("S", Synch.MOS, {3: Synch.NOT_VALID, 4: Synch.MOS, 5: Synch.MOS}),))
    assert [entry for entry, _, _ in found("S100 M3\nM30", setup)] == [C.SPINDLE_LOCKED]


def test_spindle_functions_without_synchronisation_are_not_ignored() -> None:
    setup = replace(
        SETUP, spindles=(SpindleSetup("S", Synch.NO_SYNCH, {3: Synch.MOS, 4: Synch.MOS, 5: Synch.NO_SYNCH}),)
    )
    assert [entry for entry, _, _ in found("S100 M3\nM5\nM30", setup)] == [C.SPINDLE_NO_SYNCH]
    assert [entry for entry, _, _ in found("S100\nM30", setup)] == [C.SPINDLE_NO_SYNCH]


def test_plane_without_its_axes() -> None:
    setup = replace(SETUP, axes=("X", "Y"), linear=(True, True), zero_offsets={})
    run = decode("G18 G02 X5 R5 F100\nM30", setup, start=(0.0, 0.0))
    assert run.problem is not None
    assert run.problem.entry is C.PLANE_UNAVAILABLE


def test_dwell_with_another_axis() -> None:
    assert [entry for entry, _, _ in found("G04 Y5\nM30")] == [C.DWELL_AXIS]


# -- files ---------------------------------------------------------------------------------------------------------


def _problem(path: Path) -> Problem:
    with pytest.raises(ProgramError) as caught:
        load_program(path, SETUP)
    return caught.value.problem


def test_missing_file(tmp_path: Path) -> None:
    problem = _problem(tmp_path / "none.nc")
    assert problem.entry is C.FILE_MISSING
    assert "none.nc" in str(problem)


def test_empty_file(tmp_path: Path) -> None:
    (tmp_path / "a.nc").write_bytes(b"")
    assert _problem(tmp_path / "a.nc").entry is C.FILE_EMPTY


def test_binary_file(tmp_path: Path) -> None:
    (tmp_path / "a.nc").write_bytes(b"X1\n" + bytes(range(256)))
    assert _problem(tmp_path / "a.nc").entry is C.FILE_BINARY


def test_a_folder_is_no_program(tmp_path: Path) -> None:
    assert _problem(tmp_path).entry is C.FILE_UNREADABLE


def test_file_changed_while_it_runs(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    path.write_text("G00 X1\nM10\nX2\nM30\n")
    decoder = Decoder(load_program(path, SETUP), SETUP, start=np.zeros(3))
    blocks = decoder.blocks()
    next(blocks)
    path.write_text("G00\n")
    os.utime(path, ns=(1, 1))
    with pytest.raises(ProgramError) as caught:
        list(blocks)
    assert caught.value.problem.entry is C.FILE_CHANGED


def test_unknown_dialect(tmp_path: Path) -> None:
    with pytest.raises(ProgramError) as caught:
        load_program(tmp_path / "a.nc", SETUP, "step")
    assert caught.value.problem.entry is C.DIALECT_UNSUPPORTED


def test_faults_of_a_global_subprogram_name_its_file() -> None:
    (problem,) = problems("L sub.nc\nM30", files={"sub.nc": "G00 X1\nG777\nM17\n"})
    assert problem.place.file.endswith("sub.nc")
    assert problem.place.line == 2


# -- synchronisation types -----------------------------------------------------------------------------------------


def test_synchronisation_types() -> None:
    assert parse_synch("MVS_SVS") == Synch.MVS_SVS
    assert parse_synch("PLC_INFO | MVS_SNS") == Synch.MVS_SNS | Synch.PLC_INFO
    assert parse_synch("MNS_SNS|PLC_INFO") == Synch.MNS_SNS | Synch.PLC_INFO
    assert parse_synch("0x00020002") == Synch.MVS_SVS | Synch.PLC_INFO
    assert parse_synch("0x00000000") == Synch.NO_SYNCH
    assert parse_synch("NOT_VALID") == Synch.NOT_VALID
    assert parse_synch("-1") == Synch.NOT_VALID


@pytest.mark.parametrize("text", ["MVS_SVX", "", "MOS |", "0x10000002z", "0x00000010"])
def test_unknown_synchronisation_types(text: str) -> None:
    with pytest.raises(DecoderSetupError) as caught:
        parse_synch(text, "m_synch[7]")
    assert caught.value.problem.entry is C.SYNCH_UNKNOWN
    assert "m_synch[7]" in str(caught.value)


@pytest.mark.parametrize("text", ["MOS | MVS_SVS", "MOS | NOT_VALID", "0x3", "MVS_SLM | MVS_SLP"])
def test_synchronisation_types_to_come(text: str) -> None:
    with pytest.raises(DecoderSetupError) as caught:
        parse_synch(text, "m_synch[7]")
    assert caught.value.problem.entry is C.SYNCH_NOT_ONE
    assert "MVS_SNS" in caught.value.problem.explained()


def test_every_entry_of_the_catalogue_has_a_test() -> None:
    tested = {entry for _, entry, _, _ in STATIC + DYNAMIC}
    source = "".join(path.read_text() for path in Path(__file__).parents[1].rglob("test_*.py"))
    names = {name for name, value in vars(catalogue).items() if isinstance(value, ErrorEntry)}
    missing = {
        name
        for name in names
        if getattr(catalogue, name) not in tested and not re.search(rf"\b(C|catalogue)\.{name}\b", source)
    }
    assert not missing
