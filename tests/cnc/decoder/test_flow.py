"""Program structure, control statements, calls, skipping and parameters."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.blocks import BlockEnd, Floats, Line, Polyline, Stop, StopKind
from runtime.cnc.decoder import Decoder, ProgramError, load_program, look_through
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.language.isg.index import Rules
from runtime.cnc.motion_queue import MotionQueue, RecordKind
from runtime.cnc.path_preparation import PumpState, QueueWriter
from runtime.diagnostics.catalogue import language as C  # noqa: N812 - a table of constants
from runtime.diagnostics.errors import Severity
from tests.cnc.decoder.programs import SETUP, Run, decode


def xs(text: str, **options: object) -> list[float]:
    """X of all motions."""
    run = decode(text, **options)  # type: ignore[arg-type]
    assert run.problem is None, run.problem
    return [end[0] for end in run.ends]


# -- structure -----------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.lex.program-structure", "isg.sub.file-structure")
def test_execution_starts_at_the_main_program() -> None:
    assert xs("(head)\n%L A\nG00 X1\nM17\n%MAIN (name)\nG00 X2\nLL A\nX3\nM30\nX4\n") == [2, 1, 3]


@pytest.mark.spec("isg.lex.program-structure", "isg.mh.m02-m30-program-end")
@pytest.mark.parametrize("end", ["M30", "M02", "M2", "N99 M030", ""])
def test_the_end_of_the_program_is_one_stop(end: str) -> None:
    run = decode(f"G00 X1\n{end}")
    stops = [block for block in run.blocks if isinstance(block, Stop)]
    assert [stop.kind for stop in stops] == [StopKind.PROGRAM_END]
    assert run.blocks[-1] is stops[0]


def test_a_program_may_lack_its_name() -> None:
    assert xs("% \nG00 X1\nM30") == [1]


@pytest.mark.spec("isg.sub.local-call", "isg.mh.m17-m29-subprogram-end")
@pytest.mark.parametrize("end", ["M17\n", "M29\n", "M17\nX9\n", ""])
def test_a_local_subprogram_ends_with_m17_m29_or_the_next_program(end: str) -> None:
    assert xs(f"%L A\nG00 X1\n{end}%L B\nG00 X2\nM17\n%M\nLL A\nLL B\nG00 X3\nM30") == [1, 2, 3]


@pytest.mark.spec("isg.sub.global-call")
def test_global_subprograms_have_their_own_local_ones() -> None:
    files = {
        "sub.nc": "%L A\nG00 X20\nM17\n%SUB\nG00 X10\nLL A\nM17\nX99\n",
        "P4712": "G00 X30\n",
        "lib/deep.nc": "G00 X40\nM29\n",
    }
    text = "%L A\nG00 X1\nM17\n%M\nLL A\nL sub.nc\nL4712\nL P4712\nL lib/deep.nc\nLL A\nM30"
    files["4712"] = files["P4712"]
    assert xs(text, files=files) == [1, 10, 20, 30, 30, 40, 1]


@pytest.mark.spec("isg.mh.m02-m30-program-end", "isg.sub.local-call")
def test_m30_in_a_subprogram_ends_the_program_with_a_warning() -> None:
    run = decode("%L A\nG00 X1\nM30\nM17\n%M\nLL A\nX2\nM30")
    assert [end[0] for end in run.ends] == [1]
    assert [warning.entry for warning in run.decoder.warnings] == [C.END_IN_SUBPROGRAM]


def test_the_call_is_the_last_action_of_its_block() -> None:
    assert xs("%L A\nX2\nM17\n%M\nLL A G00 X1\nX3\nM30") == [1, 2, 3]


def test_levels_are_counted_and_given_back() -> None:
    deep = "".join(f"%L S{i}\nLL S{i + 1}\nM17\n" for i in range(47)) + "%L S47\nG00 X1\nM17\n"
    text = f"{deep}%M\n$FOR P1 = 1, 3, 1\nLL S0\n$ENDFOR\nM30"
    assert xs(text) == [1, 1, 1]


# -- comments, numbers, skipping -----------------------------------------------------------------------------------


@pytest.mark.spec("isg.lex.comments")
def test_comments() -> None:
    text = "G00 (a) X1 (b (nested) c) Y2\nX2 (open end\nX3 ; X4 ( \n;X5\n(X6) ; x\n X7 (X8 (X9))\nM30"
    assert [end[:2] for end in decode(text).ends] == [[1, 2], [2, 2], [3, 2], [7, 2]]


@pytest.mark.spec("isg.flow.block-number", "isg.lex.block-structure")
def test_block_numbers_are_rounded_expressions() -> None:
    text = "N10 G00 X1\nP1 = 3\nN[P1 * 10 + 0.5] X[2]\nNP1 X[3]\nX[4]\nM30"
    assert [(row["line"], row["n"]) for row in decode(text).rows if row["type"] == "line"] == [
        (1, 10),
        (3, 31),
        (4, 3),
        (5, None),
    ]


@pytest.mark.spec("isg.lex.block-skip", "isg.lex.block-skip-levels")
def test_skip_levels() -> None:
    text = "G00 X1\n/ X2\n/1 X3\n/2 N40 X4\n/10 X5\nX6\nM30"
    assert xs(text) == [1, 2, 3, 4, 5, 6]
    assert xs(text, skip=1) == [1, 4, 5, 6]
    assert xs(text, skip=2) == [1, 2, 3, 5, 6]
    assert xs(text, skip=1 << 9) == [1, 2, 3, 4, 6]
    assert xs(text, skip=0b1000000011) == [1, 6]


@pytest.mark.spec("isg.lex.block-skip-levels")
def test_skip_levels_act_while_the_program_runs() -> None:
    mask = iter([0, 1, 1, 0])
    assert xs("G00 X1\n/ X[2]\n/ X[3]\n/ X[4]\n/ X[5]\nM30", skip=lambda: next(mask)) == [1, 2, 5]


def test_a_skipped_loop_head_does_not_hang() -> None:
    assert xs("G00 X0\n/ $WHILE 1\nX[1]\n$ENDWHILE\n/ $FOR P1 = 1, 2, 1\nX[2]\n$ENDFOR\nM30", skip=1) == [0, 1, 2]


@pytest.mark.parametrize("end", ["\n", "\r\n", "\n\n", " \t\r\n"])
def test_line_ends(end: str) -> None:
    run = decode(end.join(["G00 X1", "X[2]", "M10", "X3", "M30"]))
    assert [end[0] for end in run.ends] == [1, 2, 3]


def test_a_byte_order_mark_is_no_text() -> None:
    assert [end[0] for end in decode(b"\xef\xbb\xbf%M\nG00 X1\nM30").ends] == [1]


# -- control statements --------------------------------------------------------------------------------------------

BRANCHES = "$IF P1 == 1\nX[1]\n$ELSEIF P1 == 2\nX[2]\n$ELSEIF P1 == 3\nX[3]\n$ELSE\nX[4]\n$ENDIF\nX[5]\nM30"


@pytest.mark.spec("isg.flow.if")
@pytest.mark.parametrize(("value", "expected"), [(1, 1), (2, 2), (3, 3), (7, 4)])
def test_the_first_true_branch_is_executed(value: int, expected: int) -> None:
    assert xs(f"G00 P1 = {value}\n{BRANCHES}") == [expected, 5]


@pytest.mark.spec("isg.flow.if", "isg.lex.comparison-truth")
@pytest.mark.parametrize(
    ("condition", "true"),
    [("0.5", True), ("0.49", False), ("-0.5", True), ("-0.49", False), ("TRUE", True), ("FALSE", False), ("7", True)],
)
def test_conditions_are_true_from_one_half_on(condition: str, true: bool) -> None:
    assert xs(f"G00\n$IF {condition}\nX1\n$ENDIF\nM30") == ([1] if true else [])
    assert xs(f"G00 P1 = 0\n$WHILE [{condition}] * [P1 < 2]\nP1 = P1 + 1\nX[P1]\n$ENDWHILE\nM30") == (
        [1, 2] if true else []
    )


@pytest.mark.spec("isg.flow.for")
@pytest.mark.parametrize(
    ("head", "passes", "last"),
    [
        ("1, 3, 1", [1, 2, 3], 4),
        ("1, 4, 2", [1, 3], 5),
        ("3, 1, -1", [3, 2, 1], 0),
        ("3, 1, 1", [], 3),
        ("1, 3, -1", [], 1),
        ("2, 2, 1", [2], 3),
    ],
)
def test_counting_loops(head: str, passes: list[float], last: float) -> None:
    run = decode(f"G00\nN1 $FOR P1 = {head}\nX[P1]\n$ENDFOR\nM30")
    assert [end[0] for end in run.ends] == passes
    assert run.parameters[1] == last


@pytest.mark.spec("isg.flow.for")
def test_the_bounds_of_a_loop_are_computed_once() -> None:
    assert xs("G00 P2 = 2\n$FOR P1 = 1, P2, 1\nX[P1] P2 = 9\n$ENDFOR\nM30") == [1, 2]


@pytest.mark.spec("isg.flow.for")
def test_step_zero_is_endless_with_one_warning() -> None:
    run = decode("$FOR P1 = 1, 2, 0\n$ENDFOR\nM30", idle_limit=1000)
    assert run.problem is not None
    assert run.problem.entry is C.ENDLESS_LOOP
    assert [warning.entry for warning in run.decoder.warnings] == [C.STEP_ZERO]


def test_the_counter_may_be_computed() -> None:
    run = decode("G00 P1 = 5\n$FOR P[P1 + 1] = 1, 2, 1\nX[P6]\n$ENDFOR\nM30")
    assert [end[0] for end in run.ends] == [1, 2]


@pytest.mark.spec("isg.flow.while")
def test_a_loop_without_motion_can_be_interrupted(tmp_path: Path) -> None:
    asked = []

    def interrupted() -> bool:
        asked.append(1)
        return len(asked) >= 3

    path = tmp_path / "a.nc"
    path.write_text("$WHILE 1\nP1 = 1\n$ENDWHILE\nM30")
    decoder = Decoder(load_program(path, SETUP), SETUP, start=np.zeros(3), interrupted=interrupted)
    assert list(decoder.blocks()) == []
    assert len(asked) == 3


def test_recursion_ends_with_an_error_and_no_python_recursion() -> None:
    run = decode("%L A\nG00 X[1]\nLL A\nM17\n%M\nLL A\nM30")
    assert run.problem is not None
    assert run.problem.entry is C.CALL_DEPTH
    assert len(run.ends) == 49  # the main program is level 1 of 50


# A program as nested statements, its text, and what a small interpreter makes of it.
Statement = tuple[object, ...]


def statements(depth: int) -> st.SearchStrategy[list[Statement]]:
    plain = st.tuples(st.just("x"), st.integers(0, 9))
    count = st.tuples(st.just("add"), st.integers(1, 3), st.integers(1, 4))
    if depth == 0:
        return st.lists(st.one_of(plain, count), max_size=3)
    inner = statements(depth - 1)
    condition = st.tuples(st.integers(1, 3), st.sampled_from(["<", ">=", "==", "!="]), st.integers(0, 6))
    branch = st.tuples(st.just("if"), st.lists(st.tuples(condition, inner), min_size=1, max_size=3), st.none() | inner)
    loop = st.tuples(st.just("for"), st.integers(0, 3), st.integers(-1, 3), st.sampled_from([1, 2, -1]), inner)
    until = st.tuples(st.just("while"), st.integers(0, 3), inner)
    return st.lists(st.one_of(plain, count, branch, loop, until), max_size=4)


def write(program: list[Statement], level: int = 0) -> list[str]:
    lines: list[str] = []
    for statement in program:
        match statement:
            case ("x", value):
                lines.append(f"X{value}" if value % 2 else f"X[{value}]")  # type: ignore[operator]
            case ("add", parameter, value):
                lines.append(f"P{parameter} = P{parameter} + {value}")
            case ("if", branches, otherwise):
                for i, ((parameter, operator, value), inner) in enumerate(branches):  # type: ignore[var-annotated, arg-type]
                    lines.append(f"{'$ELSEIF' if i else '$IF'} P{parameter} {operator} {value}")
                    lines += write(inner, level + 1)
                if otherwise is not None:
                    lines += ["$ELSE", *write(otherwise, level + 1)]  # type: ignore[arg-type]
                lines.append("$ENDIF")
            case ("for", start, end, step, inner):
                lines += [f"$FOR P{10 + level} = {start}, {end}, {step}", *write(inner, level + 1), "$ENDFOR"]  # type: ignore[arg-type]
            case ("while", count, inner):
                counter = f"P{20 + level}"
                lines += [f"{counter} = 0", f"$WHILE {counter} < {count}", f"{counter} = {counter} + 1"]
                lines += [*write(inner, level + 1), "$ENDWHILE"]  # type: ignore[arg-type]
    return lines


def interpret(program: list[Statement], p: dict[int, int], out: list[int]) -> None:
    compare = {"<": int.__lt__, ">=": int.__ge__, "==": int.__eq__, "!=": int.__ne__}
    for statement in program:
        match statement:
            case ("x", int(value)):
                out.append(value)
            case ("add", int(parameter), int(value)):
                p[parameter] += value
            case ("if", list(branches), otherwise):
                for (parameter, operator, value), inner in branches:
                    if compare[operator](p[parameter], value):
                        interpret(inner, p, out)
                        break
                else:
                    if isinstance(otherwise, list):
                        interpret(otherwise, p, out)
            case ("for", int(start), int(end), int(step), list(inner)):
                while start <= end if step > 0 else start >= end:
                    interpret(inner, p, out)
                    start += step
            case ("while", int(count), list(inner)):
                for _ in range(count):
                    interpret(inner, p, out)


@pytest.mark.spec("isg.flow.if", "isg.flow.for", "isg.flow.while", "isg.flow.control-block-rules")
@given(statements(2))
def test_nested_flow_equals_a_small_interpreter(program: list[Statement]) -> None:
    expected: list[int] = []
    parameters = {1: 0, 2: 0, 3: 0}
    interpret(program, parameters, expected)
    run = decode("\n".join(["G00 P1 = 0 P2 = 0 P3 = 0", *write(program), "M30"]), idle_limit=None)
    assert run.problem is None
    assert [end[0] for end in run.ends] == expected
    assert {number: run.parameters[number] for number in parameters} == parameters


# -- parameters ----------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.param.scalar", "isg.param.coordinates")
def test_parameters_stand_for_numbers() -> None:
    text = "P1 = 2 P2 = 3\nG00 XP1 Y P2 Z[P1 + P2]\nXP1*SIN[P2*30] Y=-P1 Z P1 ** P2\nM30"
    run = decode(text)
    assert run.ends == [[2, 3, 5], [2, -2, 8]]
    assert run.parameters == {1: 2, 2: 3}


@pytest.mark.spec("isg.param.indirect", "isg.param.scalar")
def test_indirect_parameters() -> None:
    run = decode("P1 = 20 P2 = 40\nPP1 = 50\nPP2 = PP1 + 1\nP3 = 1\nPPP3 = 7\nP[P1 + 5] = 8\nP[30.4] = 9\nM30")
    assert run.parameters == {1: 20, 2: 40, 20: 7, 40: 51, 3: 1, 25: 8, 30: 9}


def test_exist_asks_without_creating() -> None:
    text = "P1 = EXIST[P5] P2 = EXIST[M10] P3 = EXIST[M77] P4 = EXIST[H20] P6 = EXIST[P1]\nM30"
    assert decode(text).parameters == {1: 0, 2: 1, 3: 0, 4: 1, 6: 1}


def test_parameters_begin_anew_with_each_program() -> None:
    assert decode("P1 = 1\nM30").parameters == {1: 1}
    assert decode("M30").parameters == {}


# -- branches that are passed over ---------------------------------------------------------------------------------


@pytest.mark.spec("isg.flow.control-block-rules", "isg.flow.block-number")
@pytest.mark.parametrize(
    ("block", "entry"),
    [
        ("X Y", None),
        ("N20 XY", None),
        ("N[P1] FOO[", None),
        ("G777 #NOTHING", None),
        ("XY $GOTO N10", None),
        ('#MSG["$IF"]', None),
        ("NXY", C.VALUE_MISSING),
        ("N[1 + ] X1", C.VALUE_MISSING),
        ("$IF X Y\n$ENDIF", C.VALUE_MISSING),
        ("$FOO", C.CONTROL_UNKNOWN),
        ("$ IF 1", C.CONTROL_UNKNOWN),
        ("$FOR P1 = 1, 2\n$ENDFOR", C.CONTROL_INCOMPLETE),
        ("$ENDWHILE", C.CONTROL_WITHOUT_START),
        ("XY $GOTO N[", C.BRACKET_OPEN),
    ],
)
def test_only_numbers_and_control_statements_are_looked_at_there(block: str, entry: object) -> None:
    """Programming manual lines 8262–8326; a long program is not looked through before."""
    text = f"G00 X1\n$IF 0\n{block}\n$ENDIF\nX2\nM30"
    if entry is None:
        assert xs(text) == [1, 2]
    else:
        with pytest.raises(ProgramError) as caught:
            decode(text)
        assert (caught.value.problem.entry, caught.value.problem.place.line) == (entry, 3)
    run = decode(text + "\n" + "(padding)\n" * 27_000)
    assert (run.problem and run.problem.entry) == entry


@pytest.mark.spec("isg.flow.control-block-rules")
def test_the_check_warns_of_faults_in_branches(tmp_path: Path) -> None:
    path = tmp_path / "a.nc"
    path.write_text("$IF 0\nX Y\nN[ X1\n$ENDIF\nG777\n$GOTO N10\nG778\nN10: M30")
    found = [(problem.entry.id, problem.place.line, problem.entry.severity) for problem in look_through(path, SETUP)]
    assert found == [
        (C.VALUE_MISSING.id, 2, Severity.WARNING),
        (C.VALUE_MISSING.id, 3, Severity.ERROR),
        (C.G_UNKNOWN.id, 5, Severity.ERROR),
        (C.G_UNKNOWN.id, 7, Severity.WARNING),
    ]


@pytest.mark.spec("isg.flow.control-block-rules")
@pytest.mark.parametrize("text", ["$IF 1 $WHILE 1\n$ENDIF", "X1 $WHILE 1\n$ENDWHILE", "$WHILE 1 X1\n$ENDWHILE"])
def test_a_control_statement_stands_alone(text: str) -> None:
    with pytest.raises(ProgramError):
        decode(f"{text}\nM30")
    assert xs("G00 F1\n/2 N10 $IF 1\nX1\n$ENDIF\nM30") == [1]


# -- $SWITCH, $DO, $REPEAT, $BREAK, $CONTINUE ----------------------------------------------------------------------

CASES = (
    "G00 F1 P2 = 2\n$SWITCH {}\n$CASE 1\nX1\n$BREAK\n$CASE P2\nX2\n$IF P9\n$BREAK\n$ENDIF\nX22\n$BREAK\n"
    "$CASE -3\nX3\n$DEFAULT\nX4\n$ENDSWITCH\nX5\nM30"
)


@pytest.mark.spec("isg.flow.switch", "isg.flow.break")
@pytest.mark.parametrize(
    ("value", "expected"),
    [("1", [1]), ("1.0009", [1]), ("1.0011", [4]), ("P2", [2, 22]), ("[-3]", [3]), ("9", [4]), ("P3=INT[1.5]", [1])],
)
def test_switch(value: str, expected: list[float]) -> None:
    assert xs("P9 = 0\n" + CASES.format(value)) == [*expected, 5]


@pytest.mark.spec("isg.flow.switch", "isg.flow.break")
def test_switch_without_default_or_break() -> None:
    assert xs("P9 = 1\n" + CASES.format(2)) == [2, 5]
    assert xs("G00 F1\n$SWITCH 7\n$CASE 1\nX1\n$BREAK\n$ENDSWITCH\nX2\nM30") == [2]
    run = decode("P9 = 0\n" + CASES.format("-3"))
    assert [warning.entry for warning in run.decoder.warnings] == [C.CASE_OPEN]  # the branch ends at $DEFAULT
    for text in ("$SWITCH 1\n$CASE 1", "$CASE 1", "$DEFAULT", "$ENDSWITCH"):
        with pytest.raises(ProgramError):
            decode(text + "\nM30")


@pytest.mark.spec("isg.flow.do-repeat")
def test_do_and_repeat_run_at_least_once() -> None:
    assert xs("G00 P1 = 0 F1\n$DO\nP1 = P1 + 1\nX[P1]\n$ENDDO P1 <= 2\nX9\nM30") == [1, 2, 3, 9]
    assert xs("G00 P1 = 0 F1\n$REPEAT\nP1 = P1 + 1\nX[P1]\n$UNTIL P1 > 2\nX9\nM30") == [1, 2, 3, 9]
    assert xs("G00 F1\n$DO\nX1\n$ENDDO 0.49\n$REPEAT\nX2\n$UNTIL 0.5\nM30") == [1, 2]


LOOPS = {
    "$FOR": ("$FOR P1 = 1, 5, 1", "$ENDFOR"),
    "$WHILE": ("P1 = 0\n$WHILE P1 < 5\nP1 = P1 + 1", "$ENDWHILE"),
    "$DO": ("P1 = 0\n$DO\nP1 = P1 + 1", "$ENDDO P1 < 5"),
    "$REPEAT": ("P1 = 0\n$REPEAT\nP1 = P1 + 1", "$UNTIL P1 >= 5"),
}


@pytest.mark.spec("isg.flow.break", "isg.flow.continue")
@pytest.mark.parametrize("loop", LOOPS)
def test_break_and_continue(loop: str) -> None:
    first, last = LOOPS[loop]
    text = "G00 F1\n{0}\n$IF P1 == {2}\n$IF 1\n{3}\n$ENDIF\n$ENDIF\nX[P1]\n{1}\nX9\nM30"
    assert xs(text.format(first, last, 3, "$BREAK")) == [1, 2, 9]
    assert xs(text.format(first, last, 3, "$CONTINUE")) == [1, 2, 4, 5, 9]
    outer = f"$FOR P5 = 1, 2, 1\n{text.format(first, last, 2, '$BREAK')}\n$ENDFOR".replace("M30\n", "").replace(
        "G00", "G00"
    )
    assert xs(outer) == [1, 9, 1, 9]


@pytest.mark.spec("isg.flow.break", "isg.flow.continue")
@pytest.mark.parametrize(
    "text", ["$BREAK", "$CONTINUE", "$IF 1\n$BREAK\n$ENDIF", "$SWITCH 1\n$CASE 1\n$CONTINUE\n$ENDSWITCH"]
)
def test_break_and_continue_outside_a_loop(text: str) -> None:
    run = decode(f"{text}\nM30")
    assert run.problem is not None
    assert run.problem.entry is C.OUTSIDE_LOOP


@pytest.mark.spec("isg.flow.for")
def test_any_writable_variable_counts() -> None:
    assert xs("G00 F1\n$FOR V.P.COUNT = 1, 3, 1\nX[V.P.COUNT]\n$ENDFOR\nX[V.P.COUNT]\nM30") == [1, 2, 3, 4]
    with pytest.raises(ProgramError) as caught:
        decode("$FOR V.G.BLOCK_NR = 1, 3, 1\n$ENDFOR\nM30")
    assert caught.value.problem.entry is C.VARIABLE_READ_ONLY


# -- $GOTO ---------------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.flow.goto")
@pytest.mark.parametrize(
    ("label", "jump"), [("N40:", "N40"), ("N40:", "N40:"), ("[There]", "[tHERE]"), ("N7 [A_1]", "[ a_1 ]")]
)
def test_jumps_forward_and_backward(label: str, jump: str) -> None:
    assert xs(f"G00 F1\nX1 $GOTO {jump} Y1\nX2\n{label} X3\nX4\nM30") == [1, 3, 4]
    back = f"G00 P1 = 0 F1\n{label} X[P1]\nP1 = P1 + 1\n$IF P1 < 3 $GOTO {jump}\nX9\nM30"
    assert xs(back) == [0, 1, 2, 9]


@pytest.mark.spec("isg.flow.goto", "isg.add.comment-block")
def test_labels_belong_to_their_level_and_not_to_comments() -> None:
    both = "%L A\nG00 F1 $GOTO N10\nX1\nN10: X2\nM17\n%M\nLL A\n$GOTO N10\nX3\nN10: X4\nM30"
    assert xs(both) == [2, 4]
    for text in (
        "%L A\nN10: X1\nM17\n%M\nLL A\n$GOTO N10\nM30",
        "%L A\n$GOTO [IN_MAIN]\nM17\n%M\nLL A\n[IN_MAIN] M30",
        "$GOTO N10\n#COMMENT BEGIN\nN10:\n#COMMENT END\nM30",
    ):
        run = decode("G00 F1\n" + text if not text.startswith("%") else text.replace("X1", "G00 X1"))
        assert run.problem is not None
        assert run.problem.entry.id == 20840


@pytest.mark.spec("isg.flow.goto-structures")
def test_jumps_into_and_out_of_structures() -> None:
    into = "G00 F1\n$GOTO {}\n$IF 0\nX1\nN10: X2\n$ELSEIF 0\nX3\nN20: X4 $GOTO {}\n[E] $ELSE\nX5\nN30: X6\n$ENDIF\nX7\nN99:\nM30"
    assert xs(into.format("N10", "N99")) == [2, 7]
    assert xs(into.format("N20", "N30")) == [4, 6, 7]
    assert xs(into.format("N30", "N99")) == [6, 7]
    assert xs(into.format("[E]", "N99")) == [5, 6, 7]
    for first, last in LOOPS.values():
        inner = "$IF 1\n$SWITCH 1\n$CASE 1\nX[P1]\n$IF P1 == 2 $GOTO N9\n$BREAK\n$ENDSWITCH\n$ENDIF"
        out = f"G00 F1\n{first}\n{inner}\n{last}\nX8\nN9: X9\nM30"
        assert xs(out) == [1, 2, 9]
        for jump in ("$GOTO N5", "$GOTO N6"):
            run = decode(f"{jump}\n{first}\nN5: P2 = 1\n$IF 1\nN6: P2 = 1\n$ENDIF\n{last}\nM30")
            assert run.problem is not None
            assert run.problem.entry is C.JUMP_INTO_LOOP


@pytest.mark.spec("isg.flow.goto-structures")
def test_a_loop_that_was_left_by_a_jump_begins_anew() -> None:
    text = "G00 P5 = 0 F1\nN1: P5 = P5 + 1\n$FOR P1 = 1, 3, 1\nX[P1]\n$IF P1 == 2 AND P5 == 1 $GOTO N1\n$ENDFOR\nM30"
    assert xs(text) == [1, 2, 1, 2, 3]


@pytest.mark.spec("isg.flow.goto-parametric")
def test_computed_targets() -> None:
    text = "G00 F1 P1 = 20\n$GOTO {}\nX1\nN20: X2 $GOTO N99\nN40: X4 $GOTO N99\n[LBL] X5\nN99: M30"
    for target, expected in (("NP1", 2), ("N[P1 * 2]", 4), ("N P1 + P1", 4), ("N19.6", 2)):
        assert xs(text.format(target)) == [expected], target

    @dataclass(frozen=True)
    class External:
        path: str = "V.E.TARGET"
        offset: int = 0
        dims: tuple[int, ...] = ()
        strides: tuple[int, ...] = ()
        kind: str = "STRING"
        size: int = 30
        access: str = "rw"
        synchronous: bool = False

    setup = replace(SETUP, external=(External(),))
    assert xs('V.E.TARGET = "lbl"\n' + text.format("V.E.TARGET"), setup=setup) == [5]
    run = decode('V.E.TARGET = "no"\n$GOTO V.E.TARGET\nM30', setup)
    assert run.problem is not None
    assert run.problem.entry is C.LABEL_MISSING


@pytest.mark.spec("isg.flow.goto-label-store")
def test_labels_beyond_the_table_are_searched_with_a_warning() -> None:
    setup = replace(SETUP, rules=Rules(labels=2, names=2))
    for labels, entry in ((["N10:", "N20:", "N30:"], C.LABELS_FULL), (["[A]", "[B]", "[C]"], C.NAMES_FULL)):
        jump = labels[2].rstrip(":")
        text = (
            f"G00 P1 = 0 F1\n{labels[0]} X1\n{labels[1]} X2\n{labels[2]} X3\nP1 = P1 + 1\n$IF P1 < 3 $GOTO {jump}\nM30"
        )
        run = decode(text, setup)
        assert [end[0] for end in run.ends] == [1, 2, 3, 3, 3]
        assert [warning.entry for warning in run.decoder.warnings] == [entry]
        missing = decode(text.replace(f"$GOTO {jump}", "$GOTO [X]" if "[" in jump else "$GOTO N77"), setup)
        assert missing.problem is not None
        assert missing.problem.entry is C.LABEL_MISSING
    long = "a" * 84
    with pytest.raises(ProgramError) as caught:
        decode(f"[{long}] X1\nM30")
    assert caught.value.problem.entry is C.LABEL_LENGTH


# -- comment blocks, continued blocks, letters ---------------------------------------------------------------------


@pytest.mark.spec("isg.add.comment-block")
def test_comment_blocks() -> None:
    text = "#COMMENT BEGIN\n%L A\nG777 (\n#COMMENT END\n%M\nG00 X1\nN5 #COMMENT BEGIN (two)\nX2\n{}X3\n#COMMENT END\nX4\n{}M30"
    assert xs(text.format("", "")) == [1, 4]
    nested = text.format("#COMMENT BEGIN\nX5\n#COMMENT END\n", "")
    assert xs(nested) == [1, 4]
    flat = replace(SETUP, rules=Rules(nested_comments=False))
    assert xs(text.format("#COMMENT BEGIN\nX5\n", ""), setup=flat) == [1, 4]


@pytest.mark.spec("isg.add.comment-block")
@pytest.mark.parametrize(
    ("text", "entry", "line"),
    [
        ("X[1]\n#COMMENT BEGIN\nM30", C.COMMENT_BLOCK_OPEN, 2),
        ("#COMMENT BEGIN\n", C.COMMENT_BLOCK_OPEN, 1),
        ("#COMMENT END\nM30", C.COMMENT_BLOCK_END, 1),
        ("P1 = 1\n#COMMENT END\nM30", C.COMMENT_BLOCK_END, 2),
        ("P1 = 1\n#COMMENT BEGIN X1\n#COMMENT END\nM30", C.NOT_ALONE, 2),
        ("P1 = 1\n#COMMENT BEGIN\n#COMMENT END X1\nM30", C.NOT_ALONE, 3),
        ("P1 = 1\nX1 #COMMENT BEGIN\nM30", C.NOT_ALONE, 2),
    ],
)
def test_faulty_comment_blocks(text: str, entry: object, line: int) -> None:
    with pytest.raises(ProgramError) as caught:
        decode(text)
    assert (caught.value.problem.entry, caught.value.problem.place.line) == (entry, line)


@pytest.mark.spec("isg.lex.line-continuation")
def test_continued_blocks_are_one_block() -> None:
    run = decode(
        "N10 G00 X1 \\ (first)\nN20 Y[1 + \\\n2] Z4\n$IF P1 == 1 OR \\\n1 $GOTO N30\nX9\nN30: X5\nM30".replace(
            "P1 == 1", "1 == 2"
        )
    )
    assert run.ends == [[1, 3, 4], [5, 3, 4]]
    assert [(row["line"], row["n"]) for row in run.rows if row["type"] == "line"] == [(1, 10), (7, 30)]
    assert xs("#VAR\nV.P.A[2][2] = [1, 2, \\\n 3, 4]\n#ENDVAR\nG00 X[V.P.A[1][1]]\nM30") == [4]
    with pytest.raises(ProgramError) as caught:
        decode("G00 X1 \\\nY2 FOO\nM30")
    assert (caught.value.problem.place.line, caught.value.problem.place.column) in ((2, 4), (2, 5))
    for text in ("#FILE NAME [M6=a.nc \\\nD=b.nc]\nM30", "#FLUSH \\\nWAIT\nM30"):
        with pytest.raises(ProgramError) as caught:
            decode(text)
        assert caught.value.problem.entry is C.CONTINUATION


@pytest.mark.spec("isg.lex.address-letters")
def test_fixed_letters_in_both_cases_axes_in_theirs() -> None:
    upper = "N10 G01 X10 Y0 F100 S5 M10 H20 T3\nG02 X20 I5 J0 K0\nG02 X30 R5 E50\nP1 = 3 D0\nM30"
    lower = "".join(c if c in "XY" else c.lower() for c in upper)
    assert decode(lower).rows == decode(upper).rows
    assert xs("%L A\nG00 X1\nM17\n%M\nll A\nl sub.nc\nM30", files={"sub.nc": "G00 X2"}) == [1, 2]
    for letter in ("O1", "o1", "x1", "?"):
        with pytest.raises(ProgramError):
            decode(f"{letter}\nM30")


@pytest.mark.spec("isg.lex.axis-names")
def test_axis_names() -> None:
    setup = replace(SETUP, axes=("Y", "Y50", "Y_AXIS_1", "Z7"), linear=(True,) * 4, zero_offsets={})
    text = (
        "G00 Y50 = 51\nY52\nY50 Z7 = 54\nY 70 Z7 = 55\nY = 71 Z7=56\nY[2+3]\nY50 = [4*3]\nY_AXIS_1 = 23\n"
        "P1 = 2\nY50=P1\nY50 P1=7\nM30"
    )
    run = decode(text, setup, start=(0.0,) * 4)
    assert run.problem is None, run.problem
    assert [block.tolist() for block in ends_of(run)] == [
        [0, 51, 0, 0], [52, 51, 0, 0], [50, 51, 0, 54], [70, 51, 0, 55], [71, 51, 0, 56], [5, 51, 0, 56], [5, 12, 0, 56],
        [5, 12, 23, 56], [5, 2, 23, 56], [50, 2, 23, 56],
    ]  # fmt: skip
    for word, entry in (
        ("X1", C.AXIS_UNKNOWN),
        ("Y51=3", C.AXIS_UNKNOWN),
        ("Y", C.VALUE_MISSING),
        ("y1", C.ADDRESS_UNKNOWN),
    ):
        with pytest.raises(ProgramError) as caught:
            decode(f"{word}\nM30", setup, start=(0.0,) * 4)
        assert caught.value.problem.entry is entry


def ends_of(run: Run) -> list[Floats]:
    """Ends of all moves, for any number of axes."""
    ends: list[Floats] = []
    for block in run.blocks:
        if isinstance(block, Polyline):
            ends += list(block.points[1:])
        elif isinstance(block, Line):
            ends.append(block.end)
    return ends


# -- # statements --------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.add.hash-syntax")
def test_the_form_of_statements() -> None:
    for statement in (
        "[RESOLUTION=10]",
        "[RESOLUTION 10]",
        "[RESOLUTION10]",
        "[ RESOLUTION = 10 ]",
        "[RESOLUTIONP1]",
        "[RESOLUTION=P1,]",
    ):
        run = decode(f"P1 = 10\nN5 #single step {statement}\nM30")
        assert run.problem is None, run.problem
        assert run.decoder.execution.steps.resolution == 10
    for text, entry in (
        ("# FLUSH", C.STATEMENT_BLANK),
        ("#FLUSH X1", C.STATEMENT_ARGUMENTS),
        ("X1 #FLUSH", C.NOT_ALONE),
        ("#NOTHING", C.STATEMENT_UNKNOWN),
        ("#SINGLE STEP [STOP]", C.KEY_UNKNOWN),
        ("#CAXTRACK ON", C.STATEMENT_UNSUPPORTED),
    ):
        with pytest.raises(ProgramError) as caught:
            decode(f"{text}\nM30")
        assert caught.value.problem.entry is entry, text


def steps(text: str) -> list[int]:
    """Block numbers that single block stops behind."""
    numbers: list[int] = []
    for block in decode(text, files={"sub.nc": "N500 X[5]\nN501 X6\nM17"}).blocks:
        if isinstance(block, Polyline):
            numbers += block.numbers.tolist()
        elif isinstance(block, BlockEnd):
            numbers.append(block.source.n or 0)
    return numbers


@pytest.mark.spec("isg.add.single-step")
def test_single_step_ranges() -> None:
    text = (
        "N10 G00 X[1]\nN20 X[2]\nN40 #SINGLE STEP [DISABLE]\nN50 X3\nN55 #SINGLE STEP [DISABLE]\nN60 X[4]\nN65 L sub.nc\n"
        "N67 G02 F1 X5 R5\nN75 #SINGLE STEP [ENABLE]\nN80 X7 R5\nN90 G00 X8\nN100 #SINGLE STEP [ENABLE]\nN110 X9\nM30"
    )
    assert steps(text) == [10, 20, 80, 90, 110]
    text = "N10 #SINGLE STEP [RESOLUTION = 10]\nG00 F1\nN90 X0\nN91 X[1]\nN92 X2\nX3\nN100 X5\nN101 X6\nN115 X[7]\nM30"
    assert steps(text) == [90, 100, 115]
    for arguments, entry in (
        ("[DISABLE ENABLE]", C.SINGLE_STEP),
        ("[]", C.SINGLE_STEP),
        ("[RESOLUTION=0]", C.RESOLUTION_INVALID),
    ):
        run = decode(f"#SINGLE STEP {arguments}\nM30")
        assert run.problem is not None
        assert run.problem.entry is entry


@pytest.mark.spec("isg.add.single-step")
def test_the_queue_holds_no_step_inside_of_a_locked_range() -> None:
    run = decode(
        "N10 G00 X1\nN20 #SINGLE STEP [DISABLE]\nN30 X2\nN40 X[3]\nN50 #SINGLE STEP [ENABLE]\nN60 X4\nN70 G01 F1 X5 E1\nM30"
    )
    assert run.problem is None, run.problem
    limits = AxisLimits(*(np.full(3, value) for value in (400.0, 4000.0, 6e4, 5.0)))
    queue = MotionQueue(3, capacity=64)
    assert QueueWriter(queue, limits, 0.001, SETUP.axes).pump(iter(run.blocks)) is PumpState.FINISHED
    records = [queue.record(i) for i in range(queue.written)]
    steps = [int(r["n"]) for r in records if r["kind"] == RecordKind.BLOCK_END or r["block_end"]]
    assert [int(r["n"]) for r in records if r["kind"] == RecordKind.LINE] == [10, 30, 40, 60, 70]
    assert steps == [10, 60, 70]
