"""External variables: their layout, and what every mistake in the description says at which place."""

from __future__ import annotations

import ctypes

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.config.external import AREA_SIZE, ExternalError, ExternalLayout, ExternalVariable, Member
from runtime.config.loader import parse_machine
from tests.config.machines import MACHINE, problems_of

DESCRIBED = """\
structures:
  Point:
    - {name: valid, type: BOOLEAN, access: read}
    - {name: at, type: REAL64, dims: [3]}
  Pallet:
    - {name: number, type: UNS16}
    - {name: corners, type: Point, dims: [2]}
    - {name: text, type: "STRING[5]"}
external_variables:
  - {name: flag, type: BOOLEAN}
  - {name: count, type: SGN32, access: read, synchronous: true}
  - {name: table, type: UNS16, dims: [2, 3]}
  - {name: pallet, type: Pallet, dims: [4], synchronous: true}
"""


def layout_of(text: str) -> ExternalLayout:
    return ExternalLayout.of(parse_machine(MACHINE + text))


def test_variables_lie_as_members_of_a_c_structure_do() -> None:
    class Point(ctypes.Structure):
        _fields_ = [("valid", ctypes.c_uint8), ("at", ctypes.c_double * 3)]

    class Pallet(ctypes.Structure):
        _fields_ = [("number", ctypes.c_uint16), ("corners", Point * 2), ("text", ctypes.c_char * 6)]

    class Area(ctypes.Structure):
        _fields_ = [
            ("flag", ctypes.c_uint8),
            ("count", ctypes.c_int32),
            ("table", (ctypes.c_uint16 * 3) * 2),
            ("pallet", Pallet * 4),
        ]

    layout = layout_of(DESCRIBED)
    assert layout.size == Area.pallet.offset + ctypes.sizeof(Pallet) * 4
    for name in ("flag", "count", "table", "pallet"):
        assert layout.element(name).offset == getattr(Area, name).offset
    assert layout.resolve("table[1][2]").offset == Area.table.offset + (1 * 3 + 2) * 2
    place = layout.resolve("pallet[3].corners[1].at[2]")
    assert place.offset == (
        Area.pallet.offset
        + 3 * ctypes.sizeof(Pallet)
        + Pallet.corners.offset
        + ctypes.sizeof(Point)
        + Point.at.offset
        + 16
    )
    assert (place.type, place.size) == ("REAL64", 8)
    assert layout.resolve("pallet.corners.at", 3, 1, 2) == place
    text = layout.resolve("pallet[0].text")
    assert (text.type, text.size, text.offset) == ("STRING", 6, Area.pallet.offset + Pallet.text.offset)


def test_rights_and_synchronism_go_down_to_members() -> None:
    layout = layout_of(DESCRIBED)
    count = layout.element("count")
    assert (count.readable, count.writable, count.synchronous) == (True, False, True)
    assert layout.element("flag").writable
    assert not layout.element("pallet.corners.valid").writable
    assert layout.element("pallet.corners.at").writable
    assert layout.element("pallet.corners.at").synchronous
    leaves = [element.path for element in layout.leaves("pallet.corners")]
    assert leaves == ["pallet.corners.valid", "pallet.corners.at"]
    assert [element.path for element in layout.leaves("table")] == ["table"]
    assert layout.element("pallet.corners.at").dims == (4, 2, 3)


def test_paths_that_lead_nowhere() -> None:
    layout = layout_of(DESCRIBED)
    for path, indices, part in (
        ("tabel", (), "do you mean V.E.table?"),
        ("table", (1,), "has 2 indices, not 1"),
        ("table", (1, 3), "index 3 is not within 0 to 2"),
        ("table", (-1, 0), "index -1 is not within 0 to 1"),
        ("flag", (0,), "has 0 indices"),
    ):
        with pytest.raises(ExternalError) as caught:
            layout.resolve(path, *indices)
        assert part in str(caught.value)


@given(
    st.lists(
        st.tuples(
            st.sampled_from(["BOOLEAN", "SGN16", "UNS32", "REAL64", "STRING[7]", "Inner"]),
            st.lists(st.integers(1, 4), max_size=3),
        ),
        min_size=1,
        max_size=8,
    )
)
def test_no_two_elements_share_a_byte_and_numbers_are_aligned(described: list[tuple[str, list[int]]]) -> None:
    structures = {"Inner": (Member(name="a", type="UNS08"), Member(name="b", type="REAL64", dims=(2,)))}
    variables = [
        ExternalVariable(name=f"v{index}", type=kind, dims=tuple(dims)) for index, (kind, dims) in enumerate(described)
    ]
    layout = ExternalLayout.lay_out(structures, variables)
    taken: set[int] = set()
    for element in layout.elements.values():
        if not element.elementary:
            continue
        indices: list[tuple[int, ...]] = [()]
        for extent in element.dims:
            indices = [(*index, i) for index in indices for i in range(extent)]
        for index in indices:
            offset = element.at(index)
            own = set(range(offset, offset + element.size))
            assert not own & taken
            assert element.type == "STRING" or offset % element.size == 0
            taken |= own
    assert max(taken) < layout.size


MISTAKES = {
    # name: (description, id, line, column, part of the text); it begins in line 9
    "unknown type": ("external_variables: [{name: a, type: SGN31}]", 302042, 9, 38, "'SGN32'?"),
    "unknown type of a member": ("structures: {A: [{name: a, type: B}]}", 302042, 9, 34, "type of a: 'B'"),
    "text without a length": ("external_variables: [{name: a, type: STRING}]", 302042, 9, 38, "'STRING'"),
    "text of length 0": ("external_variables: [{name: a, type: 'STRING[0]'}]", 302042, 9, 38, "'STRING[0]'"),
    "variable twice": (
        "external_variables:\n  - {name: a, type: UNS08}\n  - {name: a, type: UNS16}",
        302041,
        11,
        12,
        "External variable 'a'",
    ),
    "member twice": (
        "structures:\n  A: [{name: a, type: UNS08}, {name: a, type: UNS16}]",
        302041,
        10,
        38,
        "Member of A 'a'",
    ),
    "no name": ("external_variables: [{name: 1a, type: UNS08}]", 302040, 9, 29, "'1a'"),
    "structure named as a type": ("structures: {UNS08: [{name: a, type: UNS16}]}", 302040, 9, 14, "'UNS08'"),
    "structure in itself": (
        "structures:\n  A: [{name: b, type: B}]\n  B: [{name: a, type: A}]",
        302043,
        10,
        3,
        "'A' contains itself",
    ),
    "empty structure": ("structures: {A: []}", 302016, 9, 17, "at least 1"),
    "dimension 0": ("external_variables: [{name: a, type: UNS08, dims: [0]}]", 302010, 9, 52, "1 or more"),
    "unknown access": ("external_variables: [{name: a, type: UNS08, access: rw}]", 302015, 9, 53, "'rw'"),
    "unknown key": ("external_variables: [{name: a, type: UNS08, sync: true}]", 302006, 9, 45, "'sync'"),
    "too large": (
        "external_variables:\n  - {name: a, type: REAL64, dims: [8192]}\n  - {name: b, type: BOOLEAN}",
        302044,
        11,
        5,
        "65537 bytes with 'b'",
    ),
}


@pytest.mark.parametrize(("text", "number", "line", "column", "part"), MISTAKES.values(), ids=MISTAKES.keys())
def test_a_mistake_is_told_at_its_place(text: str, number: int, line: int, column: int, part: str) -> None:
    (problem,) = problems_of(MACHINE + text + "\n")
    assert (problem.entry.id, problem.place.line, problem.place.column) == (number, line, column)
    assert part in problem.text
    assert "hint" in problem.explained()


def test_the_whole_area_can_be_used() -> None:
    assert layout_of("external_variables: [{name: a, type: REAL64, dims: [8192]}]\n").size == AREA_SIZE
