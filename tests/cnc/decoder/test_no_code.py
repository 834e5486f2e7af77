"""A program is data: whatever stands in it, no text of it is ever executed as Python.

What is compiled is watched: it may name what the grammar names, and nothing that leads out of it.
"""

from __future__ import annotations

import ast
import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from runtime.cnc.language.errors import ProgramError, ProgramErrors
from runtime.cnc.language.isg import compiler
from tests.cnc.decoder.programs import decode

PAYLOADS = (
    "__import__('pathlib').Path('{mark}').touch()",
    "open('{mark}','w')",
    "().__class__.__base__.__subclasses__()",
    "X'];open('{mark}','w')#",
    "1]+[open('{mark}','w')",
    "1]\n    open('{mark}','w')\n[1",
    "{{open('{mark}','w')}}",
    "%s%n{{0.__class__}}",
    "\\x22;open('{mark}','w');\\x22",
    "a\"+str(open('{mark}','w'))+\"b",
    "'''+open('{mark}','w')+'''",
    "lambda:0",
    "block",
    "exec",
)
PLACES = (
    "P1 = {}",
    "X[{}]",
    'V.P.TEXT = "{}"',
    "V.P.{} = 1",
    '#MSG ["{}"]',
    '#MSG ["%s", "{}"]',
    '#MSG ["{}", P1]',
    '"{}" = "G01"',
    '"A" = "{}"\n"A"',
    '"A" = "P[{}]"\nP1 = "A"',
    "$GOTO [{}]",
    "[{}]: X1",
    "$IF {} > 1\n$ENDIF",
    "$FOR P1 = {}, 2, 1\n$ENDFOR",
    "L {}",
    'L CYCLE [NAME="{}" @P1={}]',
    '#FILE NAME [MSG="{}"]',
    'P1 = STR_LEN["{}"]',
    'V.P.T = LEFT["{}", 3]',
    "#VAR\nV.P.{}\n#ENDVAR",
    "; {}\n({})",
    "%L {}\nM17\n%MAIN\nM30",
)
DANGEROUS = (ast.Import, ast.ImportFrom, ast.Global, ast.Nonlocal, ast.ClassDef, ast.With, ast.Await)


@pytest.fixture
def watched(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The sources that were compiled; one that names what it must not is an error at once."""
    sources: list[str] = []
    made: Callable[..., Any] = compiler._made

    def watching(source: str, namespace: dict[str, Any]) -> Callable[..., Any]:
        sources.append(source)
        tree = ast.parse(source)
        own = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
        own |= {node.arg for node in ast.walk(tree) if isinstance(node, ast.arg)}
        for node in ast.walk(tree):
            assert not isinstance(node, DANGEROUS), source
            if isinstance(node, ast.Attribute):
                assert not node.attr.startswith("_"), source
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
                assert not node.id.startswith("__"), source
                assert node.id in own or node.id in namespace or node.id in {"abs", "float", "int", "str", "len"}, (
                    source
                )
        function: Callable[..., Any] = made(source, namespace)
        return function

    monkeypatch.setattr(compiler, "_made", watching)
    return sources


@pytest.mark.parametrize("place", PLACES)
def test_no_text_of_a_program_is_executed(place: str, watched: list[str], tmp_path: Path) -> None:
    mark = tmp_path / "mark"
    for payload in PAYLOADS:
        text = payload.replace("{mark}", str(mark))
        with contextlib.suppress(ProgramError, ProgramErrors):
            decode(f"P1 = 1\n{place.replace('{}', text)}\nM30")
        assert not mark.exists(), payload


def test_the_watch_sees_what_is_compiled(watched: list[str]) -> None:
    decode("P1 = 1\nX[P1 + SIN[30]]\nM30")
    assert any("sine" in source for source in watched)
