"""Variables: P parameters, variables of one's own, external ones, and those of the control."""

from __future__ import annotations

import struct
from dataclasses import dataclass, replace

import pytest

from runtime.cnc.blocks import ExternalWrite, Flush, Polyline, Synch, TechnologyFunction
from runtime.cnc.decoder import ChannelMemory, ProgramError
from runtime.cnc.decoder.isg.known_variables import KNOWN, purpose_of
from runtime.cnc.decoder.isg.registry import G_FUNCTIONS, STATEMENTS, VARIABLES
from runtime.cnc.decoder.isg.variables_flags import ABSENT
from runtime.cnc.decoder.setup import Limits
from runtime.diagnostics.catalogue import language as C  # noqa: N812 - a table of constants
from runtime.diagnostics.catalogue import technology as T  # noqa: N812
from tests.cnc.decoder.programs import SETUP, Run, decode
from tests.cnc.decoder.scripted_outside import Machine


@dataclass(frozen=True)
class Entry:
    """An external variable as the configuration lays it out."""

    path: str
    offset: int
    kind: str
    size: int
    dims: tuple[int, ...] = ()
    strides: tuple[int, ...] = ()
    access: str = "rw"
    synchronous: bool = False


EXTERNAL = (
    Entry("V.E.BYTE", 0, "UNS08", 1),
    Entry("V.E.REAL", 16, "REAL64", 8),
    Entry("V.E.SYNC", 8, "SGN32", 4, synchronous=True),
    Entry("V.E.TEXT", 32, "STRING", 11),
    Entry("V.E.READ", 48, "SGN16", 2, access="r"),
    Entry("V.E.ARRAY[]", 64, "SGN32", 4, (5,), (4,)),
    Entry("V.E.GRID[][]", 96, "UNS08", 1, (2, 3), (3, 1)),
    Entry("V.E.S[].POS", 128, "REAL64", 8, (3,), (16,)),
    Entry("V.E.S[].NR", 136, "SGN32", 4, (3,), (16,)),
    Entry("V.E.MIX.A", 192, "UNS08", 1),
    Entry("V.E.MIX.B", 193, "UNS08", 1, synchronous=True),
    Entry("V.E.PART.A", 200, "UNS08", 1),
    Entry("V.E.PART.B", 201, "UNS08", 1, access="r"),
)
WITH_EXTERNAL = replace(SETUP, external=EXTERNAL)


def values(text: str, **options: object) -> dict[int, float]:
    """The P parameters at the end."""
    run = decode(text, **options)  # type: ignore[arg-type]
    assert run.problem is None, run.problem
    return run.parameters


def value(expression: str, before: str = "", **options: object) -> float:
    return values(f"{before}\nP99 = {expression}", **options)[99]


def text(expression: str, before: str = "", **options: object) -> object:
    run = decode(f"{before}\nV.P.RESULT = {expression}", **options)  # type: ignore[arg-type]
    assert run.problem is None, run.problem
    return run.value("RESULT")


def refused(program: str, **options: object) -> object:
    """The entry of the error, of the check or the execution."""
    try:
        run = decode(program, **options)  # type: ignore[arg-type]
    except ProgramError as error:
        return error.problem.entry
    assert run.problem is not None
    return run.problem.entry


def writes(run: Run) -> list[ExternalWrite]:
    return [block for block in run.blocks if isinstance(block, ExternalWrite)]


# -- P parameters --------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.param.scalar")
def test_parameters_come_into_being_with_the_first_write_and_live_in_subprograms() -> None:
    program = "%L S\nP3 = P1 + P2\nP1 = 9\nM17\n%M\nN10 P1=20.5 P2=12.6 F100\nLL S\nP[P4_INDEX] = 1\nM30"
    assert values(program.replace("P4_INDEX", "P1 - 5")) == pytest.approx({1: 9, 2: 12.6, 3: 33.1, 4: 1})


@pytest.mark.spec("isg.param.scalar")
@pytest.mark.parametrize(
    ("program", "entry"),
    [
        ("P0 = 1", C.PARAMETER_INDEX),
        ("P[0] = 1", C.PARAMETER_INDEX),
        ("P[-1] = 1", C.PARAMETER_INDEX),
        ("P1 = P2", C.PARAMETER_UNSET),
    ],
)
def test_what_parameters_refuse(program: str, entry: object) -> None:
    assert refused(program) is entry


@pytest.mark.spec("isg.param.scalar")
@pytest.mark.parametrize("last", ["P4 = 1", "P[4] = 1", "$FOR P4 = 1, 2, 1\n$ENDFOR", "#VAR\nP4[2]\n#ENDVAR"])
def test_there_are_no_more_parameters_than_configured(last: str) -> None:
    setup = replace(SETUP, limits=Limits(parameters=3))
    start = "P1=1 P2=1\n#VAR\nP3[5]\n#ENDVAR\nP2=2 P3[4]=7\n"
    assert values(start, setup=setup) == {1: 1, 2: 2}
    assert refused(start + last, setup=setup) is C.VARIABLE_LIMIT
    assert 1 not in values(f"{start}#DELETE P1\n{last}", setup=setup)


@pytest.mark.spec("isg.param.arrays")
def test_arrays_are_declared_and_filled_row_by_row() -> None:
    program = (
        "#VAR\nP10[3][6] = [10,11,12,13,14,15, \\\n20,21,22,23,24,25, \\\n30,31,32,33,34,35]\nP20 = 7\nP30[2]\n#ENDVAR\n"
        "P1 = P10[0][5] P2 = P10[2][0] P3 = P20 P4 = P30[1]\nP10[1][1+1] = 5\nP5 = P10[1][2]"
    )
    assert values(program) == {1: 15, 2: 30, 3: 7, 4: 0, 5: 5, 20: 7}


@pytest.mark.spec("isg.param.arrays")
@pytest.mark.parametrize(
    ("program", "entry"),
    [
        ("P10[1] = 5", C.VARIABLE_UNSET),
        ("#VAR\nP10[2]\n#ENDVAR\nP1 = P10[2]", C.ARRAY_INDEX),
        ("#VAR\nP10[2]\n#ENDVAR\nP1 = P10[-1]", C.ARRAY_INDEX),
        ("#VAR\nP10[2]\n#ENDVAR\nP1 = P10[0][0]", C.ARRAY_NEEDED),
        ("#VAR\nP10[2]\n#ENDVAR\nP10 = 1", C.ARRAY_NEEDED),
        ("#VAR\nP10[2] = [1,2,3]\n#ENDVAR", C.ARRAY_VALUES),
        ("#VAR\nP10[0]\n#ENDVAR", C.ARRAY_SIZE),
        ("#VAR\nP10[1][1][1][1][1]\n#ENDVAR", C.ARRAY_DIMENSIONS),
    ],
)
def test_what_arrays_refuse(program: str, entry: object) -> None:
    assert refused(program) is entry


@pytest.mark.spec("isg.param.delete-exist-sizeof")
def test_parameters_and_arrays_can_be_deleted_and_asked_for() -> None:
    program = (
        "P10=1\n#VAR\nP20[3][4]\n#ENDVAR\n"
        "P1=EXIST[P10] P2=EXIST[P20[2][3]] P3=EXIST[P20[3][3]] P4=SIZEOF[P20] P5=SIZEOF[P20,2] P6=SIZEOF[P20,3]\n"
        "P7=SIZEOF[P10] P8=EXIST[P99]\n#DELETE P10, P20, P98\nP11=EXIST[P10] P12=EXIST[P20[0][0]] P13=SIZEOF[P20]"
    )
    found = values(program)
    assert [found[number] for number in (1, 2, 3, 4, 5, 6, 7, 8)] == [1, 1, 0, 3, 4, -1, -1, 0]
    assert [found[number] for number in (11, 12, 13)] == [0, 0, -1]
    assert 10 not in found
    assert 99 not in found  # asking makes nothing


@pytest.mark.spec("isg.param.coordinates")
def test_axis_words_take_expressions() -> None:
    run = decode("P1=10 P2=1\nG00 XP1*SIN[P2*30] Y=P1+1 Z[P1*2]")
    assert run.ends == [[pytest.approx(5), 11, 20]]


@pytest.mark.spec("isg.param.indirect")
def test_indirect_parameters() -> None:
    program = (
        "P120=10\nPP120=123.456\nP1=20 P2=40\nPP1=50\nPP2=PP1\nP3=120\nPPP3=7\n$FOR P4=10,12,1\nP[P4+5]=0\n$ENDFOR"
    )
    found = values(program)
    assert {n: found[n] for n in (10, 15, 16, 17, 20, 40)} == {10: 7, 15: 0, 16: 0, 17: 0, 20: 50, 40: 50}


@pytest.mark.spec("isg.param.indirect")
def test_a_pointer_to_no_parameter_is_an_error() -> None:
    assert refused("P1 = 0\nPP1 = 1") is C.PARAMETER_INDEX


@pytest.mark.spec("isg.param.program-global", "chan.p-params-persistent")
@pytest.mark.parametrize("kept", [True, False])
def test_parameters_outlive_their_program_if_configured(kept: bool) -> None:
    setup = replace(SETUP, keep_parameters=kept)
    memory = ChannelMemory(setup)
    decode("P1 = 5\n#VAR\nP2[2] = [8, 9]\n#ENDVAR", setup, memory=memory)
    program = "P3 = EXIST[P1] P4 = EXIST[P2[1]]\n$IF EXIST[P1]\nP5 = P1 + P2[1]\n$ENDIF"
    found = values(program, setup=setup, memory=memory)
    assert found == ({1: 5, 3: 1, 4: 1, 5: 14} if kept else {3: 0, 4: 0})


# -- variables of one's own ----------------------------------------------------------------------------------------


@pytest.mark.spec("isg.var.user-declaration")
def test_declarations_with_types_and_initial_values() -> None:
    program = (
        '#VAR\nV.P.VAR_1\nV.P.VAR_2 = 10.67\nV.P.VAR_3 : UNS32 = 10\nV.L.NAME_1 : STRING[20] = "BASEPLATE"\n'
        "V.L.VAR_1 : REAL64 = 23.45\nV.L.VAR_2 : SGN08\nV.S.FLAG : BOOLEAN = 7\nV.P.EMPTY : STRING[5]\n#ENDVAR\n"
        "P1=V.P.VAR_1 P2=V.P.VAR_2 P3=V.P.VAR_3 P4=LEN[V.L.NAME_1] P5=V.L.VAR_1 P6=V.L.VAR_2 P7=V.S.FLAG P8=LEN[V.P.EMPTY]\n"
        "V.P.VAR_3 = 2.5\nP9 = V.P.VAR_3"
    )
    assert values(program) == {1: 0, 2: 10.67, 3: 10, 4: 9, 5: 23.45, 6: 0, 7: 1, 8: 0, 9: 3}


@pytest.mark.spec("isg.var.user-declaration")
def test_declarations_may_stand_in_the_flow_and_continue_on_the_next_line() -> None:
    program = (
        "$IF 1\n#VAR\nV.P.ARRAY_1[3][6] = [10,11,12,13,14,15, \\\n20,21,22,23,24,25, \\\n30,31,32,33,34,35]\n"
        "V.L.MY[2][2][2][2] : UNS08 = [1,2,3]\n#ENDVAR\n$ENDIF\n"
        "P1 = V.P.ARRAY_1[0][5] P2 = V.P.ARRAY_1[2][1] P3 = V.L.MY[0][0][1][0] P4 = V.L.MY[1][1][1][1]"
    )
    assert values(program) == {1: 15, 2: 31, 3: 3, 4: 0}


@pytest.mark.spec("isg.var.user-declaration")
@pytest.mark.parametrize(
    ("program", "entry"),
    [
        ("V.P.A : UNS08", C.DECLARATION_PLACE),
        ("#VAR\nV.P.A : STRING[127]\n#ENDVAR", C.TYPE_INVALID),
        ("#VAR\nV.P.A : UNS08 = 256\n#ENDVAR", C.RESULT_RANGE),
        ("#VAR\nV.P.A : SGN16\n#ENDVAR\nV.P.A = -32769", C.RESULT_RANGE),
        ('#VAR\nV.P.A : STRING[3] = "abcd"\n#ENDVAR', C.STRING_TOO_LONG),
        ('#VAR\nV.P.A : UNS08 = "a"\n#ENDVAR', C.STRING_NOT_ALLOWED),
        ("#VAR\nV.P.A : STRING[3] = 5\n#ENDVAR", C.NUMBER_NOT_ALLOWED),
        ("#VAR\nV.P.A[1][1][1][1][1]\n#ENDVAR", C.ARRAY_DIMENSIONS),
        ("V.P.A[1] = 5", C.VARIABLE_UNSET),
        ("P1 = V.P.A", C.VARIABLE_UNSET),
        ("V.P.A = 1\nP1 = V.P.A[0]", C.ARRAY_NEEDED),
        ("#VAR\nV.P.A[2]\n#ENDVAR\nP1 = V.P.A", C.VARIABLE_UNSET),
    ],
)
def test_what_declarations_refuse(program: str, entry: object) -> None:
    assert refused(program) is entry


@pytest.mark.spec("isg.var.user-declaration")
def test_there_are_no_more_variables_than_configured() -> None:
    setup = replace(SETUP, limits=Limits(program_variables=2))
    assert refused("V.P.A=1\nV.P.B=1\nV.P.A=2\nV.P.C=1", setup=setup) is C.VARIABLE_LIMIT


@pytest.mark.spec("isg.var.delete-exist-sizeof")
def test_variables_can_be_deleted_and_asked_for() -> None:
    program = (
        "#VAR\nV.P.A[3][6]\nV.L.B[2]\nV.S.C = 1\n#ENDVAR\nV.P.D = 1\n"
        "P1=EXIST[V.P.A[0][0]] P2=EXIST[V.P.A[3][0]] P3=SIZEOF[V.P.A] P4=SIZEOF[V.P.A,2] P5=SIZEOF[V.P.A,3]\n"
        "P6=SIZEOF[V.P.D] P7=EXIST[V.S.C] P8=EXIST[V.P.NOPE] P9=EXIST[V.L.B[1]]\n"
        "#DELETE V.P.A, V.L.B, V.P.D, V.S.C, V.P.NOPE\n"
        "P11=EXIST[V.P.A[0][0]] P12=EXIST[V.L.B[0]] P13=EXIST[V.P.D] P14=EXIST[V.S.C] P15=SIZEOF[V.P.A]"
    )
    found = values(program)
    assert [found[n] for n in range(1, 10)] == [1, 0, 3, 6, -1, -1, 1, 0, 1]
    assert [found[n] for n in range(11, 16)] == [0, 0, 0, 0, -1]


def test_only_variables_of_programs_can_be_deleted() -> None:
    assert refused("#DELETE V.G.BLOCK_NR") is C.STATEMENT_ARGUMENTS


@pytest.mark.spec("isg.var.p-variables")
def test_p_variables_are_seen_on_all_levels_and_gone_with_the_program() -> None:
    memory = ChannelMemory(SETUP)
    program = "%L S\nP1 = V.P.A\nV.P.A = 2\nV.P.B = 3\nM17\n%M\nV.P.A = 1\nLL S\nP2 = V.P.A + V.P.B\nM30"
    assert values(program, memory=memory) == {1: 1, 2: 5}
    assert value("EXIST[V.P.A]", memory=memory) == 0


@pytest.mark.spec("isg.var.s-variables")
def test_s_variables_outlive_their_program() -> None:
    memory = ChannelMemory(SETUP)
    first = "$IF EXIST[V.S.EXAMPLE[0]] == TRUE\nV.S.EXAMPLE[2] = 10\n$ELSE\n#VAR\nV.S.EXAMPLE[5] = [1,2,3,4,5]\n#ENDVAR\n$ENDIF"
    decode(first, memory=memory)
    assert value("V.S.EXAMPLE[2]", memory=memory) == 3
    decode(first, memory=memory)
    assert value("V.S.EXAMPLE[2]", memory=memory) == 10
    decode("#DELETE V.S.EXAMPLE", memory=memory)
    assert value("EXIST[V.S.EXAMPLE[0]]", memory=memory) == 0


@pytest.mark.spec("isg.var.l-variables")
def test_l_variables_belong_to_their_level_and_are_seen_below() -> None:
    program = (
        "%L SEES\nP1 = V.L.A\nV.L.A = 2\nV.L.OWN = 5\nLL DEEPER\nM17\n%L DEEPER\nP3 = V.L.OWN\nM17\n"
        "%L HIDES\n#VAR\nV.L.A = 7\n#ENDVAR\nV.L.A = V.L.A + 1\nP4 = V.L.A\nM17\n"
        "%M\nV.L.A = 1\nLL SEES\nP2 = V.L.A\nLL HIDES\nP5 = V.L.A P6 = EXIST[V.L.OWN]\nM30"
    )
    assert values(program) == {1: 1, 2: 2, 3: 5, 4: 8, 5: 2, 6: 0}


@pytest.mark.spec("isg.var.l-variables")
def test_an_l_variable_of_a_higher_level_cannot_be_deleted() -> None:
    program = "%L S\n{}#DELETE V.L.A\nM17\n%M\nV.L.A = 1\nLL S\nP1 = V.L.A\nM30"
    assert refused(program.format("")) is C.DELETE_HIGHER
    assert values(program.format("#VAR\nV.L.A = 3\n#ENDVAR\n")) == {1: 1}


@pytest.mark.spec("isg.var.cycle-variables")
def test_the_most_local_cycle_variable_wins_and_goes_with_its_level() -> None:
    program = (
        "%L S\nP1 = V.CYC.A\n#VAR\nV.CYC.A : SGN32 = 7\nV.CYC.F[2][2] : REAL64 = [1,2,3,4]\n#ENDVAR\nLL T\nM17\n"
        "%L T\nP2 = V.CYC.A P3 = V.CYC.F[1][0]\nM17\n"
        "%M\n#VAR\nV.CYC.A : UNS08 = 1\n#ENDVAR\nLL S\nP4 = V.CYC.A P5 = EXIST[V.CYC.F[0][0]]\n"
        "#DELETE V.CYC.A, V.CYC.NEVER\nP6 = EXIST[V.CYC.A]\nM30"
    )
    assert values(program) == {1: 1, 2: 7, 3: 3, 4: 1, 5: 0, 6: 0}


@pytest.mark.spec("isg.var.cycle-variables")
def test_a_cycle_variable_of_a_higher_level_cannot_be_deleted() -> None:
    assert refused("%L S\n#DELETE V.CYC.A\nM17\n%M\nV.CYC.A = 1\nLL S\nM30") is C.DELETE_HIGHER


@pytest.mark.spec("isg.var.cycle-variables")
def test_cycle_variables_have_a_memory_in_bytes() -> None:
    setup = replace(SETUP, limits=Limits(cycle_memory=20))
    fits = "#VAR\nV.CYC.A : REAL64\nV.CYC.B[5] : SGN16\nV.CYC.C : STRING[1]\n#ENDVAR\n"
    assert values(fits + "P1 = 1", setup=setup) == {1: 1}
    for more in ("V.CYC.D = 1", "#VAR\nV.CYC.D : BOOLEAN\n#ENDVAR"):
        assert refused(fits + more, setup=setup) is C.CYCLE_MEMORY
        assert values(f"{fits}#DELETE V.CYC.A\n{more}\nP1 = 1", setup=setup) == {1: 1}


# -- external variables --------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.var.external-variables")
def test_asynchronous_external_variables_are_read_and_written_at_once() -> None:
    machine = Machine()
    program = (
        'P1 = V.E.BYTE\nV.E.BYTE = 2.5\nV.E.REAL = -1.25\nV.E.TEXT = "hello"\nV.E.ARRAY[4] = -7\nV.E.GRID[1][2] = 9\n'
        "V.E.S[2].POS = 4.5\nV.E.S[2].NR = V.E.ARRAY[4]\nG00 XV.E.REAL YV.E.S[2].POS"
    )
    run = decode(program, WITH_EXTERNAL, outside=machine)
    assert run.problem is None
    assert run.parameters == {1: 0}
    area = machine.external
    assert area[0] == 3
    assert struct.unpack_from("<d", area, 16)[0] == -1.25
    assert bytes(area[32:43]) == b"hello" + bytes(6)
    assert struct.unpack_from("<i", area, 80)[0] == -7
    assert area[101] == 9
    assert struct.unpack_from("<d", area, 160)[0] == 4.5
    assert struct.unpack_from("<i", area, 168)[0] == -7
    assert run.ends == [[-1.25, 4.5, 0]]
    assert not any(isinstance(block, (Flush, ExternalWrite)) for block in run.blocks)


@pytest.mark.parametrize("array", ["V.P.A", "V.L.A", "P7"])
def test_a_parameter_alone_is_an_index(array: str) -> None:
    program = f"#VAR\n{array}[2][2] = [10, 11, 12, 13]\n#ENDVAR\nP1 = 1 P2 = 0\nP3 = {array}[P1][P2]\n{array}[P2][ P1 ] = 20\n"
    assert values(program + f"P4 = {array}[0][1]\n#DELETE {array}\nP5 = EXIST[{array}[P1][P2]]") == {
        1: 1,
        2: 0,
        3: 12,
        4: 20,
        5: 0,
    }


def test_a_label_may_be_called_like_a_parameter() -> None:
    assert values("$GOTO [P9]\nP1 = 1\n[P9] P2 = 2\nN10 [P8] P3 = 3") == {2: 2, 3: 3}


@pytest.mark.spec("isg.var.external-variables")
def test_synchronous_external_variables_are_written_on_the_path_and_reading_them_flushes() -> None:
    run = decode("G01 X1 F100\nN20 V.E.SYNC = 5\nX2\nP1 = V.E.SYNC + 1\nX3", WITH_EXTERNAL)
    assert [type(block) for block in run.blocks][:5] == [Polyline, ExternalWrite, Polyline, Flush, Polyline]
    (write,) = writes(run)
    assert (write.offset, write.kind, write.size, write.value) == (8, "SGN32", 4, 5.0)
    assert (write.source.line, write.source.n) == (2, 20)
    assert run.parameters == {1: 1}  # nobody has carried the write out here


@pytest.mark.spec("isg.var.external-variables")
@pytest.mark.parametrize(
    ("branches", "flushes", "reached"),
    [
        ("$IF P1 == 1\nP2 = 1\n$ELSEIF V.E.SYNC == 0\nP2 = 2\n$ENDIF", 1, 2),
        ("$IF P1 == 0\nP2 = 1\n$ELSEIF V.E.SYNC == 0\nP2 = 2\n$ENDIF", 0, 1),
        ("$IF V.E.SYNC == 1\nP2 = 1\n$ELSEIF V.E.SYNC == 0\nP2 = 2\n$ENDIF", 1, 2),
        ("$IF P1\nP2 = 1\n$ELSEIF V.E.SYNC\nP2 = 2\n$ELSEIF V.E.SYNC\nP2 = 3\n$ELSE\nP2 = 4\n$ENDIF", 1, 4),
        ("$SWITCH P1\n$CASE V.E.SYNC\nP2 = 1\n$BREAK\n$DEFAULT\nP2 = 2\n$ENDSWITCH", 1, 1),
        ("$SWITCH P1\n$CASE 0\nP2 = 1\n$BREAK\n$CASE V.E.SYNC\nP2 = 2\n$ENDSWITCH", 0, 1),
    ],
)
def test_a_branch_flushes_before_its_condition_reads_a_synchronous_variable(
    branches: str, flushes: int, reached: int
) -> None:
    run = decode(f"P1 = 0\nG01 X1 F100\n{branches}\nX2", WITH_EXTERNAL)
    assert run.problem is None, run.problem
    kinds = [type(block) for block in run.blocks]
    assert kinds.count(Flush) == flushes
    assert kinds[: 1 + flushes] == [Polyline, Flush][: 1 + flushes]
    assert run.parameters[2] == reached


@pytest.mark.parametrize("condition", ["$IF V.E.SYNC\n", "$IF 0\n$ELSEIF V.E.SYNC\n"])
def test_a_condition_cannot_flush_while_a_contour_line_waits(condition: str) -> None:
    program = f"G01 #ANG=30 F100\n{condition}P1 = 1\n$ENDIF\n#ANG=60 X20 Y30"
    assert refused(program, setup=WITH_EXTERNAL) is C.CONTOUR_LINE_UNDETERMINED


@pytest.mark.spec("isg.var.external-variables")
@pytest.mark.parametrize(
    ("program", "entry"),
    [
        ("V.E.READ = 1", C.VARIABLE_READ_ONLY),
        ("P1 = V.E.NOPE", C.VARIABLE_UNKNOWN),
        ("P1 = V.E.S", C.ARRAY_NEEDED),
        ("P1 = V.E.MIX", C.VARIABLE_UNKNOWN),
        ("P1 = V.E.ARRAY", C.ARRAY_NEEDED),
        ("P1 = V.E.ARRAY[5]", C.ARRAY_INDEX),
        ("V.E.ARRAY[-1] = 1", C.ARRAY_INDEX),
        ("V.E.BYTE = 300", C.RESULT_RANGE),
        ('V.E.BYTE = "a"', C.STRING_NOT_ALLOWED),
        ('V.E.TEXT = "01234567890"', C.STRING_TOO_LONG),
        ("V.E.TEXT = 1", C.NUMBER_NOT_ALLOWED),
    ],
)
def test_what_external_variables_refuse(program: str, entry: object) -> None:
    assert refused(program, setup=WITH_EXTERNAL) is entry


def test_external_variables_can_be_asked_for() -> None:
    program = (
        "P1=EXIST[V.E.BYTE] P2=EXIST[V.E.NOPE] P3=EXIST[V.E.ARRAY[4]] P4=EXIST[V.E.ARRAY[5]] "
        "P5=SIZEOF[V.E.ARRAY] P6=SIZEOF[V.E.GRID,2] P7=SIZEOF[V.E.BYTE] P8=SIZEOF[V.E.GRID,3] P9=SIZEOF[V.E.S]"
    )
    assert values(program, setup=WITH_EXTERNAL) == {1: 1, 2: 0, 3: 1, 4: 0, 5: 5, 6: 3, 7: -1, 8: -1, 9: 3}


@pytest.mark.spec("isg.var.external-init")
def test_external_variables_are_set_back_to_zero() -> None:
    machine = Machine()
    machine.external[:256] = bytes([255]) * 256
    program = "N1 #INIT V.E.BYTE, V.E.TEXT\n#INIT V.E.ARRAY[1], V.E.GRID[1]\n#INIT V.E.S[0].NR, V.E.S[1]\n#INIT V.E.MIX"
    run = decode(program, WITH_EXTERNAL, outside=machine)
    assert run.problem is None, run.problem
    zero = {index for index in range(256) if machine.external[index] == 0}
    expected = {
        0,
        *range(32, 43),
        *range(68, 72),
        *range(99, 102),
        *range(136, 140),
        *range(144, 152),
        *range(152, 156),
    }
    assert zero == expected
    # one synchronous member: all of the structure is set on the path
    assert [(write.offset, write.value, write.source.line) for write in writes(run)] == [(192, 0.0, 4), (193, 0.0, 4)]


@pytest.mark.spec("isg.var.external-init")
@pytest.mark.parametrize(
    ("program", "entry"),
    [
        ("#INIT V.E.READ", C.VARIABLE_READ_ONLY),
        ("#INIT V.E.PART", C.VARIABLE_READ_ONLY),
        ("#INIT V.E.NOPE", C.VARIABLE_UNKNOWN),
        ("#INIT V.E.ARRAY[5]", C.ARRAY_INDEX),
    ],
)
def test_what_cannot_be_set_back(program: str, entry: object) -> None:
    machine = Machine()
    machine.external[:256] = bytes([255]) * 256
    assert refused(program, setup=WITH_EXTERNAL, outside=machine) is entry
    assert bytes(machine.external[:256]) == bytes([255]) * 256


# -- names of the control's variables ------------------------------------------------------------------------------


@pytest.mark.spec("isg.var.access-syntax")
def test_axes_by_name_and_by_index_are_the_same() -> None:
    program = "G00 X1 Y2 Z3\n" + " ".join(f"P{n + 1}=V.A.ABS.{'XYZ'[n]} P{n + 11}=V.A.ABS[{n}]" for n in range(3))
    assert values(program) == {1: 1, 2: 2, 3: 3, 11: 1, 12: 2, 13: 3}
    found = values(
        "V.G.NP[2].V[1] = 100\nP1 = V.G.NP[2].V.Y P2 = V.G.NP_AKT.V[1] P3 = V.SPDL_PROG.SPEED.S P4 = V.SPDL_PROG.SPEED[0]"
    )
    assert found == {1: 100, 2: 0, 3: 0, 4: 0}


@pytest.mark.spec("isg.var.access-syntax")
def test_axis_names_of_several_characters_and_variables_behind_addresses() -> None:
    setup = replace(SETUP, axes=("X", "Y", "Z_SLIDE"))
    run = decode("G00 X5 Z_SLIDE=7\nG91 XV.A.ABS.Z_SLIDE YV.A.ABS[0]*2", setup)
    assert run.ends[-1] == [12, 10, 7]


@pytest.mark.spec("isg.var.access-syntax")
@pytest.mark.parametrize(
    ("program", "entry"),
    [
        ("V.A.ABS.X = 5", C.VARIABLE_READ_ONLY),
        ("P1 = V.A.ABS.S", C.VARIABLE_UNKNOWN),
        ("P1 = V.A.ABS.Q", C.VARIABLE_UNKNOWN),
        ("P1 = V.A.ABS[3]", C.ARRAY_INDEX),
        ("P1 = V.A.ABS", C.VARIABLE_UNKNOWN),
        ("P1 = V.G.NOTHING", C.VARIABLE_UNKNOWN),
        ("P1 = V.G.WZ[1].LINKPOINT.X", C.VARIABLE_UNSUPPORTED),
        ("V.G.WZ_AKT.GOBJECT[3].X = 1", C.VARIABLE_UNSUPPORTED),
        ("P1 = V.A.TRANSFORM.X", C.VARIABLE_UNSUPPORTED),
        ("P1 = V.G.SPEED_LIMIT.VEL_LIMIT", C.VARIABLE_UNSUPPORTED),
    ],
)
def test_variables_that_are_read_only_unknown_or_still_to_come(program: str, entry: object) -> None:
    assert refused(program) is entry


@pytest.mark.spec("isg.var.access-syntax")
def test_exist_tells_whether_a_variable_axis_or_spindle_is_there() -> None:
    names = (
        "V.A.ABS.X",
        "V.A.ABS.Q",
        "V.A.ABS[2]",
        "V.A.ABS[3]",
        "V.SPDL.NBR_IN_CHANNEL",
        "V.G.NOTHING",
        "V.G.WZ[1].R",
    )
    program = " ".join(f"P{n}=EXIST[{name}]" for n, name in enumerate(names, 1))
    assert list(values(program).values()) == [1, 0, 1, 0, 1, 0, 0]
    spindle = "EXIST[V.SPDL_PROG.SPEED.{}]"
    assert [value(spindle.format(name)) for name in ("S", "S2")] == [1, 0]


def test_no_variable_is_both_there_and_still_to_come() -> None:
    there = [
        path for path in VARIABLES if not path.endswith("<axis beside>")
    ]  # those of the path's axes are still to come
    assert [path for path in there if purpose_of(path)] == []
    assert all(purpose for purpose in KNOWN.values())


# -- V.G: blocks, feed, circles, state -----------------------------------------------------------------------------


@pytest.mark.spec("isg.var.g-block-feed-circle")
def test_block_unit_and_feed() -> None:
    program = (
        "P1=V.G.FEEDRATE P2=V.G.FEEDRATE_MODE P3=V.G.MASS_MM P4=V.G.MASS_360 P5=V.G.FEEDRATE_SCALE\n"
        "N70 G01 X1 F2000\nN80 X2\nP6=V.G.BLOCK_NR P7=V.G.FEEDRATE\nG70 F10\nP8=V.G.MASS_MM P9=V.G.FEEDRATE\n"
        "G71 G93 F5\nP10=V.G.FEEDRATE_MODE P11=V.G.FEEDRATE"
    )
    found = values(program)
    assert found == pytest.approx({1: 0, 2: 94, 3: 0, 4: 0, 5: 1, 6: 80, 7: 2000, 8: 1, 9: 10, 10: 93, 11: 5})


@pytest.mark.spec("isg.var.g-block-feed-circle")
def test_one_program_fits_both_units_of_f() -> None:
    metres = replace(SETUP, feed_factor=1000.0)
    for setup in (SETUP, metres):
        run = decode("G01 X1 F2000 / V.G.FEEDRATE_SCALE\nP1 = V.G.FEEDRATE * V.G.FEEDRATE_SCALE", setup)
        assert run.rows[0]["feed"] == 2000
        assert run.parameters == {1: 2000}


@pytest.mark.spec("isg.var.g-block-feed-circle")
def test_circle_data_are_those_of_the_corrected_centre() -> None:
    program = "G01 X0 Y0 F100\nG02 X10 Y0 I5.01 J0\nP1=V.G.I P2=V.G.J P3=V.G.K P4=V.G.R P5=V.G.MERR[0] P6=V.G.MERR[1]"
    found = values(program)
    assert found == pytest.approx({1: 5, 2: 0, 3: 0, 4: 5, 5: -0.01, 6: 0}, abs=1e-9)
    assert refused("P1 = V.G.MERR[2]") is C.SET_INDEX


def test_without_a_contour_rotation_its_variables_are_zero() -> None:
    assert values("P1=V.G.ROT_ACTIVE P2=V.G.ROT_ANGLE P3=V.G.ROT_CENTER1 P4=V.G.ROT_CENTER2") == {
        1: 0,
        2: 0,
        3: 0,
        4: 0,
    }


def test_state_of_the_channel() -> None:
    program = (
        "P1=V.G.PROG_ABS P2=V.G.ACT_PLANE P3=V.G.CNC_CHANNEL\nG91 G19 T7\nP4=V.G.PROG_ABS P5=V.G.ACT_PLANE P6=V.G.T_AKT"
    )
    assert values(program) == {1: 1, 2: 17, 3: 1, 4: 0, 5: 19, 6: 7}


def test_random_numbers_repeat_with_the_program() -> None:
    program = "P1=V.G.RANDOM P2=V.G.RANDOM P3=V.G.RANDOM"
    first, again, other = values(program), values(program), values(program, name="other.nc")
    assert first == again != other
    assert len(set(first.values())) == 3
    assert all(0 <= number <= 1 for number in first.values())


def test_version_of_the_control() -> None:
    found = values(
        "P1=V.G.CNC_VERSION.MAJOR P2=V.G.CNC_VERSION.MINOR P3=V.G.CNC_VERSION.BUILD P4=V.G.CNC_VERSION.PATCH"
    )
    assert all(part >= 0 and part == int(part) for part in found.values())


# -- zero offsets --------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.var.g-zero-offsets")
@pytest.mark.spec("isg.g.zero-offset-variables")
def test_stored_offsets_are_changed_for_good_and_active_ones_until_the_next_selection() -> None:
    memory = ChannelMemory(SETUP)
    program = (
        "G00 G54 X0\nV.G.NP_AKT.V.X = 7\nX0\nP1=V.G.NP[1].V.X P2=V.G.NP_AKT.V.X P3=V.G.NP_AKT.IDX\nG54 X0\n"
        "V.G.NP[1].V.X = 3\nX0\nG54 X0\nV.G.NP_AKT.V.X = 9\nV.G.NP[12].ALL = V.G.NP_AKT.ALL\nG91 X0\nG90 X0"
    )
    run = decode(program, memory=memory)
    assert [end[0] for end in run.ends] == [100, 7, 100, 100, 3, 3, 9]
    assert run.parameters == {1: 100, 2: 7, 3: 1}
    assert value("V.G.NP[12].V.X + V.G.NP[1].V.X", memory=memory) == 12


@pytest.mark.spec("isg.var.g-zero-offsets")
@pytest.mark.spec("isg.g.zero-offset-variables")
def test_the_default_set_is_active_when_the_next_program_starts() -> None:
    memory = ChannelMemory(SETUP)
    run = decode("P1 = V.G.NP_DEFAULT\nV.G.NP_DEFAULT = 2\nG00 X0", memory=memory)
    assert (run.ends, run.parameters) == ([[0, 0, 0]], {1: 0})
    run = decode("P1 = V.G.NP_AKT.IDX\nG00 X0", memory=memory)
    assert (run.ends, run.parameters) == ([[200, 0, 0]], {1: 2})


@pytest.mark.spec("isg.g.zero-offset-arithmetic")
def test_whole_sets_are_added_and_subtracted() -> None:
    program = (
        "V.G.NP[7].ALL = V.G.NP[2].ALL + V.G.NP[4].ALL\nV.G.NP[8].ALL = V.G.NP[7].ALL\nV.G.NP[8].ALL -= V.G.NP[1].ALL\n"
        "G55\nV.G.NP_AKT.ALL += V.G.NP[2].ALL + V.G.NP[4].ALL\n"
        "P1=V.G.NP[7].V.X P2=V.G.NP[7].V.Z P3=V.G.NP[8].V.Y P4=V.G.NP_AKT.V.X P5=V.G.NP[2].V.X"
    )
    assert values(program) == {1: 600, 2: 6, 3: 50, 4: 800, 5: 200}


@pytest.mark.spec("isg.g.zero-offset-arithmetic")
@pytest.mark.parametrize(
    "program",
    [
        "V.G.NP[1].ALL = V.G.NP[2].ALL + V.G.NP[4].V.X",
        "V.G.NP[1].ALL = V.G.NP[2].ALL + 100",
        "V.G.NP[1].ALL = 100 + V.G.NP[2].ALL",
        "V.G.NP[1].ALL = 100",
        "V.G.NP[1].ALL += 1",
        "V.G.NP[1].ALL = V.G.NP[2].ALL * 2",
        "V.G.NP[1].V.X = V.G.NP[2].ALL",
        "P1 = V.G.NP[2].ALL",
        "X = V.G.NP[2].ALL",
        "V.P.A = V.G.NP[2].ALL",
        'V.P.A = FSTRING["set ", V.G.NP[2].ALL]',
        "P1 = ABS[V.G.NP[2].ALL]",
        "#ERROR [PV1=V.G.NP[2].ALL]",
        "$IF V.G.NP[2].ALL == V.G.NP[2].ALL\n$ENDIF",
    ],
)
def test_whole_sets_do_not_mix_with_single_values(program: str) -> None:
    assert refused(program) is C.SETS_MIXED


@pytest.mark.spec("isg.var.g-zero-offsets")
def test_offsets_are_told_in_inch_with_inch() -> None:
    assert values("V.G.NP[1].V.X = 25.4\nG70\nP1=V.G.NP[1].V.X\nV.G.NP[1].V.X = 2\nG71\nP2=V.G.NP[1].V.X") == {
        1: 1,
        2: 50.8,
    }


@pytest.mark.spec("isg.var.g-zero-offsets")
@pytest.mark.parametrize(
    "program", ["V.G.NP[97].V.X = 1", "P1 = V.G.NP[-1].V.X", "V.G.NP_DEFAULT = 97", "P1=V.G.NP[97].ALL"]
)
def test_there_are_97_sets(program: str) -> None:
    assert refused(program) is C.SET_INDEX
    assert values("V.G.NP[96].V.X = 4\nP1 = V.G.NP[96].V.X") == {1: 4}


def test_writes_of_stored_sets_are_counted() -> None:
    program = (
        "P1=V.G.NP[1].INVOKE_COUNT\nV.G.NP[1].V.X=15\nV.G.NP[1].V.X=16\nV.G.NP[1].ALL=V.G.NP[2].ALL\n"
        "P2=V.G.NP[1].INVOKE_COUNT P3=V.G.NP[2].INVOKE_COUNT\nG54\nP4=V.G.NP_AKT.INVOKE_COUNT"
    )
    assert values(program) == {1: 0, 2: 3, 3: 0, 4: 3}


@pytest.mark.spec("isg.g.zero-offset-groups")
def test_a_macro_makes_a_set_from_others() -> None:
    rule = "V.G.NP[1].ALL = V.G.NP[2].ALL + V.G.NP[4].ALL"
    own = f'N10 " VERSCH_1 " = " {rule} "\nN20 " VERSCH_1 "\nN30 G54\nG00 X0 Y0 Z0'
    assert decode(own).ends == [[600, 60, 6]]
    configured = replace(SETUP, macros={"VERSCH_1": rule})
    assert decode('N20 "VERSCH_1"\nN30 G54\nG00 X0 Y0 Z0', configured).ends == [[600, 60, 6]]


# -- V.G: programs -------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.var.g-timestamp")
def test_time_stamps() -> None:
    machine = Machine()
    assert text("V.G.TIME_STAMP", outside=machine) == "26.11.2026 14:08:10:123"
    assert text("V.G.TIME_STAMP_FILE_NAME", outside=machine) == "20261126T140810123"


@pytest.mark.spec("isg.var.g-program-version")
def test_versions_of_programs_are_handed_down_and_not_up() -> None:
    program = (
        '%L UP_1\nV.P.A=V.G.PROG_VERSION.COMPLETE\nV.G.PROG_VERSION.COMPLETE = "5.1.2.3"\nLL UP_2\nM17\n'
        "%L UP_2\nV.P.B=V.G.PROG_VERSION.COMPLETE\nV.G.PROG_VERSION.PATCH = 9\nV.P.C=V.G.PROG_VERSION.COMPLETE\nM17\n"
        '%MAIN\nV.P.O=V.G.PROG_VERSION.COMPLETE\nV.G.PROG_VERSION.COMPLETE = "4.1.2.3"\nLL UP_1\n'
        "V.P.D=V.G.PROG_VERSION.COMPLETE\nP1=V.G.PROG_VERSION.MAJOR P2=V.G.PROG_VERSION.BUILD\nM30"
    )
    run = decode(program)
    assert run.problem is None, run.problem
    assert [run.value(name) for name in "OABCD"] == ["0.0.0.0", "4.1.2.3", "5.1.2.3", "5.1.2.9", "4.1.2.3"]
    assert run.parameters == {1: 4, 2: 2}


@pytest.mark.spec("isg.var.g-program-version")
@pytest.mark.parametrize("version", ["", "1.2.3", "1.2.3.4.5", "a.1.2.3", "256.0.0.0", "1.2.3.-4", "1. 2.3.4"])
def test_what_is_no_version(version: str) -> None:
    assert refused(f'V.G.PROG_VERSION.COMPLETE = "{version}"') is C.VERSION_FORM


# -- V.G: flags and functions --------------------------------------------------------------------------------------


def test_flags_of_functions_that_are_there() -> None:
    program = (
        "P1=V.G.MIRROR_ACTIVE P2=V.G.CIRCLE_CP_ABS P3=V.G.CIRCLE_CPC_ACTIVE\n"
        "G161\nP4=V.G.CIRCLE_CP_ABS\nG162\nP5=V.G.CIRCLE_CP_ABS"
    )
    assert values(program) == {1: 0, 2: 0, 3: 1, 4: 1, 5: 0}


@pytest.mark.parametrize("name", ABSENT)
def test_a_function_that_is_not_there_is_not_active(name: str) -> None:
    """Its flag is 0; once something switches it on, the flag has to be made true: until then it is refused."""
    statements, g = ABSENT[name]
    there = any(number in G_FUNCTIONS for number in g) or any(
        f"{key} ".startswith(f"{beginning} ") for beginning in statements for key in STATEMENTS
    )
    if there:
        assert refused(f"P1 = V.G.{name}") is C.VARIABLE_UNSUPPORTED
    else:
        assert value(f"V.G.{name}") == 0


def test_synchronisation_of_functions_is_read_and_changed_for_the_programs_that_follow() -> None:
    memory = ChannelMemory(SETUP)
    program = (
        "P1=V.G.M_FCT[10].SYNCH P2=V.G.H_FCT[21].SYNCH\nM10\nV.G.M_FCT[10].SYNCH = '0x4'\nM10\nP3=V.G.M_FCT[10].SYNCH"
    )
    run = decode(program, memory=memory)
    assert run.problem is None, run.problem
    assert run.parameters == {1: 1, 2: 8, 3: 4}
    synchs = [block.synch for block in run.blocks if isinstance(block, TechnologyFunction)]
    assert synchs == [Synch.MOS, Synch.MVS_SNS]
    assert value("V.G.M_FCT[10].SYNCH", memory=memory) == 4


@pytest.mark.spec("isg.var.g-mh-functions", "chan.mh.pre-output-values")
def test_a_lead_that_does_not_fit_changes_the_type() -> None:
    memory = ChannelMemory(SETUP)
    program = (
        "V.G.M_FCT[10].PRE_OUTP_PATH = 25\nP1=V.G.M_FCT[10].SYNCH P2=V.G.M_FCT[10].PRE_OUTP_PATH\nM10\n"
        "V.G.H_FCT[20].PRE_OUTP_TIME = 0.04\nP3=V.G.H_FCT[20].SYNCH P4=V.G.H_FCT[20].PRE_OUTP_TIME\nH20\n"
        "V.G.M_FCT[11].SYNCH = '0x100000' V.G.M_FCT[11].PRE_OUTP_PATH = 5\nP5=V.G.M_FCT[11].SYNCH\n"
        "G70 P6=V.G.M_FCT[10].PRE_OUTP_PATH\nM30"
    )
    run = decode(program, memory=memory)
    assert run.problem is None, run.problem
    assert run.parameters == pytest.approx(
        {1: 0x1000000, 2: 25.0, 3: 0x2000000, 4: 0.04, 5: 0x100000, 6: 25.0}
    )  # the parameters of a block are computed before G70 acts
    leads = [(f.synch, f.lead) for f in run.blocks if isinstance(f, TechnologyFunction)]
    assert [synch for synch, _ in leads] == [Synch.MEP_SVS, Synch.MET_SVS]
    assert [lead for _, lead in leads] == pytest.approx([25.0, 0.04])
    assert value("V.G.M_FCT[10].PRE_OUTP_PATH", "G70", memory=memory) == pytest.approx(25.0 / 25.4)


@pytest.mark.parametrize(
    ("program", "entry"),
    [
        ("P1 = V.G.M_FCT[77].SYNCH", C.FUNCTION_NOT_CONFIGURED),
        ("V.G.H_FCT[77].SYNCH = 1", C.FUNCTION_NOT_CONFIGURED),
        ("V.G.M_FCT[10].SYNCH = 3", C.SYNCH_NOT_ONE),
        ("V.G.M_FCT[10].SYNCH = 16", C.SYNCH_UNKNOWN),
        ("P1 = V.G.H_FCT[20].PRE_OUTP_TIME", T.PRE_OUTPUT),
        ("V.G.M_FCT[10].SYNCH = -1", C.SYNCH_VALUE),
        ("P1 = V.G.M_FCT[10].PRE_OUTP_PATH", T.PRE_OUTPUT),
        ("V.G.M_FCT[10].PRE_OUTP_PATH = 5\nP1 = V.G.M_FCT[10].PRE_OUTP_TIME", T.PRE_OUTPUT),
        ("V.G.M_FCT[10].PRE_OUTP_TIME = -1", T.PRE_OUTPUT_VALUE),
        ("V.G.H_FCT[20].PRE_OUTP_PATH = 429497", T.PRE_OUTPUT_VALUE),
        ("V.G.M_FCT[10].PRE_OUTP_PATH = 5 V.G.M_FCT[10].SYNCH = 2\nM10", T.MICRO_JOINT),
        ("V.G.H_FCT[77].PRE_OUTP_PATH = 1", C.FUNCTION_NOT_CONFIGURED),
    ],
)
def test_what_synchronisation_refuses(program: str, entry: object) -> None:
    run = decode(program)
    assert run.problem is not None
    assert run.problem.entry is entry
    assert run.problem.explained()  # text and remedy can be filled in


# -- axes and spindles ---------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.var.a-coordinates")
def test_coordinates_of_the_block_before() -> None:
    program = (
        "P1=V.A.ABS.X\nG00 G54 X5 Y6\nP2=V.A.ABS.X P3=V.A.PROG.X P4=V.A.MENT.Y P5=V.A.ACS.ABS.Y\n"
        "V.G.NP_AKT.V.X = 0\nP6=V.A.PROG.X P7=V.A.ABS.X\nG70 X1\nP8=V.A.ABS.X P9=V.A.PROG.X"
    )
    found = values(program, start=(3.0, 0.0, 0.0))
    assert found == pytest.approx({1: 3, 2: 105, 3: 5, 4: 6, 5: 16, 6: 5, 7: 105, 8: 1, 9: 1})


@pytest.mark.spec("isg.var.a-limits-offsets")
def test_limits_and_status_of_axes() -> None:
    setup = replace(SETUP, position_limits=((-10.0, 254.0), (None, None), (None, 5.0)), log_axes=(4, 5, 9))
    program = (
        "P1=V.A.-SWE.X P2=V.A.+SWE[0] P3=V.A.-SWE_MDS.X P4=V.A.+SWE_MDS.Z P5=V.A.LOG_AX_NR.Z P6=V.A.MIRROR.X\n"
        "P7=V.A.BZP.X P8=V.A.PZV.Y V.P.NAME=V.A.AX_LIST_NAME[1]\nG70\nP9=V.A.+SWE.X"
    )
    run = decode(program, setup)
    assert run.problem is None, run.problem
    assert run.parameters == pytest.approx({1: -10, 2: 254, 3: -10, 4: 5, 5: 9, 6: 1, 7: 0, 8: 0, 9: 10})
    assert run.value("NAME") == "Y"
    assert refused("P1 = V.A.-SWE.Y", setup=setup) is C.LIMIT_MISSING
    narrower = "G98 X-5\nG99 Z4\nP1=V.A.-SWE.X P2=V.A.-SWE_MDS.X P3=V.A.+SWE.Z P4=V.A.+SWE.X"
    assert values(narrower, setup=setup) == {1: -5, 2: -10, 3: 4, 4: 254}


def test_mode_of_linear_and_modulo_axes() -> None:
    setup = replace(
        SETUP,
        axes=("X", "A", "C"),
        linear=(True, False, False),
        position_limits=((None, None), (-90.0, 90.0), (None, None)),
        zero_offsets={},
    )
    asked = "P1=V.A.MODE.X P2=V.A.MODE.C P3=V.A.MODULO_VALUE.X P4=V.A.MODULO_VALUE.A P5=V.A.MODULO_VALUE.C"
    assert values(asked, setup=setup) == {1: 1, 2: 4, 3: 0, 4: 0, 5: 360}
    assert refused("P1=V.A.MODE.A", setup=setup) is C.VARIABLE_UNSUPPORTED


@pytest.mark.parametrize(
    ("name", "g"),
    [("AXIS_DEACTIVATED", None)],
)
def test_a_state_that_no_axis_can_get_into(name: str, g: int | None) -> None:
    assert g not in G_FUNCTIONS  # else the variable has to tell what it does
    assert value(f"V.A.{name}.X") == 0


@pytest.mark.parametrize("name", ["AXIS_DEACTIVATED", "RERF"])
def test_asking_whether_an_axis_is_parked_or_has_its_reference_flushes(name: str) -> None:
    assert isinstance(decode(f"P1=V.A.{name}.X").blocks[0], Flush)


@pytest.mark.spec("isg.var.a-limits-offsets")
def test_the_reference_point_is_where_homing_finds_it() -> None:
    setup = replace(SETUP, reference_points=(-25.4, 0.0, 0.0))
    assert values("G92 X10\nG00 X5\nP1=V.A.REF.X\nG70\nP2=V.A.REF.X", setup=setup, start=(3.0, 0.0, 0.0)) == {
        1: -25.4,
        2: -1.0,
    }


@pytest.mark.spec("isg.var.a-limits-offsets")
@pytest.mark.parametrize("name", ["-SWE", "+SWE", "-SWE_MDS", "+SWE_MDS", "REF", "BZP", "PZV"])
def test_limits_and_offsets_can_only_be_read(name: str) -> None:
    assert refused(f"V.A.{name}.X = 1") is C.VARIABLE_READ_ONLY


@pytest.mark.spec("isg.var.a-limits-offsets")
def test_offsets_of_axes() -> None:
    assert values("G92 X10\nG00 X0\nP1=V.A.BZP.X P2=V.A.ABS.X P3=V.A.BZP.Y") == {1: 10, 2: 10, 3: 0}


@pytest.mark.spec("isg.var.a-coordinates")
def test_coordinates_of_mirrored_axes() -> None:
    asked = "P1=V.G.MIRROR_ACTIVE P2=V.A.MIRROR.X P3=V.A.MIRROR.Y P4=V.A.ABS.X P5=V.A.PROG.X P6=V.A.MENT.X"
    program = f"G00 X5 Y2\nG21 X5 Y3\n{asked}"
    assert values(program) == {1: 1, 2: -1, 3: 1, 4: -5, 5: 5, 6: 5}


@pytest.mark.spec("isg.var.a-coordinates")
def test_coordinates_under_a_contour_rotation_are_those_of_the_machine_axes() -> None:
    program = (
        "#ROTATION ON [ANGLE=90 CENTER1=10 CENTER2=0]\nG00 X5 Y2\nP1=V.G.ROT_ACTIVE P2=V.G.ROT_ANGLE P3=V.G.ROT_CENTER1\n"
        "P4=V.G.ROT_CENTER2 P5=V.A.PROG.X P6=V.A.ABS.X P7=V.A.PROG.Y\n#ROTATION OFF\nP8=V.G.ROT_ACTIVE P9=V.G.ROT_ANGLE"
    )
    assert values(program) == pytest.approx({1: 1, 2: 90, 3: 10, 4: 0, 5: 8, 6: 8, 7: 5, 8: 0, 9: 0})


def test_axes_have_no_compensations_and_asking_for_them_flushes() -> None:
    kinds = ("CROSS", "PLANE", "LEAD", "TEMP", "FRICT", "CROSSTALK")
    names = [f"{kind}_COMP_{item}" for kind in kinds for item in ("INIT", "ACTIVE", "CURR")]
    names += ["BACKLASH_COMP_ACTIVE", "BACKLASH_COMP_CURR"]
    for name in names:
        run = decode(f"P1 = V.A.{name}.X")
        assert run.parameters == {1: 0}
        assert isinstance(run.blocks[0], Flush)


def test_spindle_data() -> None:
    setup = replace(SETUP, log_spindles=(6,))
    program = (
        "P1=V.SPDL.LOG_AX_NR.S P2=V.SPDL.NBR_IN_CHANNEL P3=V.SPDL.PLC_CONTROL.S P4=V.SPDL.M_FCT_FREE\n"
        "P5=V.SPDL_PROG.MOVE_CMD.S\nM3 S1000\nP6=V.SPDL_PROG.SPEED.S P7=V.SPDL_PROG.MOVE_CMD[0]\nG04 S50\nM4\n"
        "P8=V.SPDL_PROG.MOVE_CMD.S P9=V.SPDL_PROG.DWELL_ROT_COUNT.S"
    )
    assert values(program, setup=setup) == {1: 6, 2: 1, 3: 0, 4: 0, 5: 5, 6: 1000, 7: 3, 8: 4, 9: 50}
    assert refused("V.SPDL.M_FCT_FREE = 2") is C.ARRAY_INDEX
