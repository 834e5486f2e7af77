"""#OPTIONAL EXECUTION, #BACKWARD STORAGE CLEAR, #BLOCKSEARCH: what becomes of them in the stream."""

from __future__ import annotations

import pytest

from runtime.cnc.blocks import ClearStorage, OptionalSection, SearchArea
from runtime.cnc.decoder import ProgramError
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.catalogue import smoothing
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.programs import decode


@pytest.mark.spec("isg.add.optional-execution")
def test_sections_do_not_nest() -> None:
    text = (
        "G01 F100 X10\n#OPTIONAL EXECUTION ON [SIMULATE MASK='2#0101']\nX20\n#OPTIONAL EXECUTION ON\nX10\n"
        "#OPTIONAL EXECUTION OFF\n#OPTIONAL EXECUTION OFF\nX30\nM30"
    )
    sections = [block for block in decode(text).blocks if isinstance(block, OptionalSection)]
    assert [(section.begins, section.simulate, section.mask) for section in sections] == [
        (True, True, 5),
        (False, False, None),
    ]


@pytest.mark.spec("isg.add.optional-execution")
@pytest.mark.parametrize(
    ("text", "entry", "line"),
    [
        ("G01 F100 X10\n#OPTIONAL EXECUTION ON\nX20\n#OPTIONAL EXECUTION OFF\nM30", catalogue.SECTION_MOVES, 4),
        ("#OPTIONAL EXECUTION ON\nN1 M30", catalogue.SECTION_OPEN, 2),
        ("#OPTIONAL EXECUTION ON\nN1 G00 X0", catalogue.SECTION_OPEN, 2),
        ("%L A\n#OPTIONAL EXECUTION ON\nM17\n%M\nLL A\n#OPTIONAL EXECUTION OFF\nM30", catalogue.SECTION_OPEN, 3),
        ("#STOP REVERSIBLE [LEVEL=-1]\nM30", smoothing.VALUE_RANGE, 1),
        ("#OPTIONAL EXECUTION ON [MASK=1]\nM30", catalogue.SECTION_MASK, 1),
        ("#OPTIONAL EXECUTION ON [SIMULATE MASK=-1]\nM30", catalogue.SECTION_MASK, 1),
    ],
)
def test_what_a_section_must_not_be(text: str, entry: ErrorEntry, line: int) -> None:
    try:
        problem = decode(text).problem
    except ProgramError as error:
        problem = error.problem
    assert problem is not None
    assert (problem.entry, problem.place.line) == (entry, line)


@pytest.mark.spec("isg.add.backward-storage-clear")
def test_places_that_nobody_enters_or_goes_back_over() -> None:
    blocks = decode("G00 X1\n#BACKWARD STORAGE CLEAR\n#BLOCKSEARCH LOCKED\nX2\n#BLOCKSEARCH RELEASED\nM30").blocks
    found = [block for block in blocks if isinstance(block, ClearStorage | SearchArea)]
    assert [(type(block), block.source.line) for block in found] == [
        (ClearStorage, 2),
        (SearchArea, 3),
        (SearchArea, 5),
    ]
    assert [block.locked for block in found if isinstance(block, SearchArea)] == [True, False]
