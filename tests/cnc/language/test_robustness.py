"""Whatever a file holds, there are blocks or program errors; and a long program takes no memory."""

from __future__ import annotations

import os
import tempfile
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.decoder import Decoder, ProgramError, load_program
from runtime.cnc.decoder.isg.registry import G_FUNCTIONS
from runtime.cnc.language.isg.parser import G_NUMBERS
from tests.cnc.decoder.programs import SETUP, decode

tokens = st.sampled_from(
    [
        *("%", "%L A", "LL A", "L x", "N1", "G0", "G1", "G2", "G4", "G54", "G70", "G91", "X", "Y1", "I2", "R3", "F9"),
        *("S1", "T1", "M3", "M10", "M30", "M17", "H20", "P1", "PP1", "P[", "=", "1", "-0.5", "1e5", "'H1F'", "["),
        *("]", "+", "**", "MOD", "SIN[", "ATAN2[", ",", "$IF", "$ELSEIF", "$ELSE", "$ENDIF", "$FOR", "$ENDFOR"),
        *("$WHILE", "$ENDWHILE", "\n", "\n", "\n", "(", ")", ";", "/", "/2", " ", "V.G.X", "#MSG", '"A"', "\\", "@P1"),
        *(
            ":",
            "EXIST[",
            "&&",
            "XOR",
            "<",
            "!=",
            "\x00",
            "$GOTO N1",
            "$GOTO [A]",
            "[A]",
            "N1:",
            "$SWITCH",
            "$CASE",
            "$DEFAULT",
        ),
        *(
            "$ENDSWITCH",
            "$DO",
            "$ENDDO",
            "$REPEAT",
            "$UNTIL",
            "$BREAK",
            "$CONTINUE",
            "LL CYCLE [NAME=A @P1=1 MODAL_BLOCK]",
        ),
        *(
            "L SEQUENCE [N1 ENDTAG]",
            "L SEQUENCE [[A] BEGIN]",
            "#SEQUENCE END",
            "#COMMENT BEGIN",
            "#COMMENT END",
            "\\\n",
        ),
        *("M17 [MAIN N1]", "M17 [JUMPS=2 [A]]", "G80[1,,@P1]", '#FILE NAME [G80="x"]', "#SINGLE STEP [RESOLUTION=2]"),
    ]
)


def survives(data: bytes) -> None:
    try:
        decode(data, idle_limit=2000)
    except ProgramError as error:
        for problem in error.problems:
            assert problem.explained()


@given(st.binary(max_size=200))
def test_random_bytes(data: bytes) -> None:
    survives(data)


@given(st.lists(tokens, max_size=40).map(" ".join))
def test_random_words(text: str) -> None:
    survives(text.encode("latin-1"))


@given(st.text(st.characters(min_codepoint=32, max_codepoint=126), max_size=80))
def test_random_lines(text: str) -> None:
    survives(text.encode())


@pytest.mark.skipif(
    os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="a million lines take too long without compiled kernels"
)
def test_memory_stays_flat_over_long_programs() -> None:
    """Nothing is held per line of plain blocks; 1 200 000 lines against 600 000."""

    def peak(lines: int, line: str) -> int:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "long.nc"
            path.write_text("%LONG\nG01 F1000\n" + line * lines + "M30\n")
            tracemalloc.start()
            program = load_program(path, SETUP)
            for _ in Decoder(program, SETUP, start=np.zeros(3)).blocks():
                pass
            _, most = tracemalloc.get_traced_memory()
            tracemalloc.stop()
            program.close()
            return most

    peak(1000, "X1 Y1\nX0\n")  # compile, import, build the parser
    assert peak(600_000, "X1 Y1\nX0\n") < 1.1 * peak(300_000, "X1 Y1\nX0\n")


def test_the_table_of_g_functions() -> None:
    assert set(G_FUNCTIONS) <= G_NUMBERS
    for number, function in G_FUNCTIONS.items():
        assert function.syntax.number == number
        assert function.syntax.spec
        assert all(spec.startswith("isg.") for spec in function.syntax.spec)
        assert function.syntax.syntax.startswith("G")
