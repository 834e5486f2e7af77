"""The area of the external variables and its directory."""

from __future__ import annotations

import math
from dataclasses import dataclass

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.hli.errors import HliError
from runtime.hli.external import (
    KINDS,
    TEXT,
    ExternalVariable,
    describe_external,
    directory_of,
    external_area,
    external_variables,
    read_external,
    size_of,
    write_external,
)
from runtime.hli.layout import EXTERNAL_BYTES, EXTERNAL_NAMES, Hli
from runtime.hli.memory import HliMemory


def variable(path: str, kind: str, offset: int, *dims: int, size: int = 0) -> ExternalVariable:
    """A packed array: the last index runs fastest."""
    size = size or size_of(kind)
    strides = tuple(size * math.prod(dims[i + 1 :]) for i in range(len(dims)))
    return ExternalVariable(path, kind, offset, size, dims, strides, "read_write", offset % 2 == 1)


@pytest.mark.spec("hli.area.external-variables")
def test_the_area_is_zero_at_the_start_and_seen_by_both_sides(shared: HliMemory) -> None:
    assert shared.name is not None
    with HliMemory.attach(shared.name) as other:
        ours, theirs = external_area(shared.hli), external_area(other.hli)
        assert len(ours) == EXTERNAL_BYTES
        assert not any(ours)
        assert write_external(ours, EXTERNAL_BYTES - 8, "REAL64", 8, 1.25)
        assert read_external(theirs, EXTERNAL_BYTES - 8, "REAL64", 8) == 1.25
        del ours, theirs


def test_the_directory_comes_out_as_it_went_in() -> None:
    entries = [
        variable("COUNT", "SGN32", 0),
        variable("TOOL.NAME", TEXT, 25, size=20),
        variable("GRID[][]", "BOOLEAN", 48, 3, 4),
        variable("PALLET[].PLACES[][]", "REAL64", 72, 2, 3, 4),
    ]
    hli = Hli()
    describe_external(hli, entries)
    assert external_variables(hli) == entries


@pytest.mark.parametrize(
    "entry",
    [
        variable("TOO_LONG" * 20, "UNS08", 0),
        variable("BEYOND", "REAL64", EXTERNAL_BYTES - 7),
        variable("ARRAY_BEYOND[]", "UNS08", EXTERNAL_BYTES - 10, 11),
        variable("BEFORE", "UNS08", -1),
        variable("MANY" + 7 * "[]", "UNS08", 0, 2, 2, 2, 2, 2, 2, 2),
        variable("NO_MARK", "UNS08", 0, 2),
        variable("EMPTY[]", "UNS08", 0, 0),
        variable("NO_TYPE", "LREAL", 0, size=8),
        variable("WRONG_SIZE", "SGN32", 0, size=2),
    ],
    ids=lambda entry: entry.path[:12],
)
def test_what_does_not_fit_is_an_error(entry: ExternalVariable) -> None:
    with pytest.raises(HliError) as caught:
        describe_external(Hli(), [entry])
    assert caught.value.problem.entry is catalogue.EXTERNAL_NOT_LAID_OUT
    assert entry.path in caught.value.problem.text


def test_the_prefix_of_a_program_may_stand_in_front() -> None:
    hli = Hli()
    describe_external(hli, [variable("V.E.COUNT", "SGN32", 0)])
    assert external_variables(hli)[0].path == "COUNT"


@dataclass(frozen=True)
class Element:
    """As a layout without marks of indices describes it."""

    type: str
    offset: int
    size: int
    dims: tuple[int, ...] = ()
    strides: tuple[int, ...] = ()
    access: str = "read"
    synchronous: bool = False
    elementary: bool = True


def test_the_directory_of_a_layout_marks_the_indices_of_every_level() -> None:
    elements = {
        "COUNT": Element("SGN32", 0, 4),
        "RACK": Element("Rack", 8, 48, (2,), (48,), elementary=False),
        "RACK.NAME": Element("STRING", 8, 8, (2,), (48,)),
        "RACK.PLACE": Element("Place", 16, 4, (2, 2, 5), (48, 20, 4), elementary=False),
        "RACK.PLACE.FULL": Element("BOOLEAN", 16, 1, (2, 2, 5), (48, 20, 4)),
        "RACK.PLACE.TOOLS": Element("UNS08", 17, 1, (2, 2, 5, 3), (48, 20, 4, 1), synchronous=True),
    }
    directory = directory_of(elements)
    assert [(v.path, v.offset, v.dims, v.strides, v.synchronous) for v in directory] == [
        ("COUNT", 0, (), (), False),
        ("RACK[].NAME", 8, (2,), (48,), False),
        ("RACK[].PLACE[][].FULL", 16, (2, 2, 5), (48, 20, 4), False),
        ("RACK[].PLACE[][].TOOLS[]", 17, (2, 2, 5, 3), (48, 20, 4, 1), True),
    ]
    hli = Hli()
    describe_external(hli, directory)
    assert external_variables(hli) == directory


def test_more_names_than_there_is_room_for_are_an_error() -> None:
    hli = Hli()
    entries = [variable(f"V{k}", "UNS08", k) for k in range(EXTERNAL_NAMES + 1)]
    describe_external(hli, entries[:-1])
    assert external_variables(hli) == entries[:-1]
    with pytest.raises(HliError):
        describe_external(hli, entries)


@pytest.mark.parametrize(
    ("kind", "written", "read"),
    [
        ("BOOLEAN", 0.5, 1),
        ("BOOLEAN", 0.49, 0),
        ("BOOLEAN", -3, 1),
        ("SGN08", -200.0, -128),
        ("UNS08", -1, 0),
        ("UNS08", 255.6, 255),
        ("SGN16", 2.5, 3),
        ("SGN16", -2.5, -2),
        ("UNS32", math.inf, 2**32 - 1),
        ("SGN32", -math.inf, -(2**31)),
        ("UNS64", 2**64 - 1, 2**64 - 1),
        ("REAL32", 1e300, 3.4028234663852886e38),
        ("REAL64", -0.1, -0.1),
        (TEXT, "grün", "grün"),
        (TEXT, "ü" * 30, "ü" * 19),
    ],
)
def test_values_are_rounded_and_limited_to_their_type(kind: str, written: float | str, read: float | str) -> None:
    area, size = memoryview(bytearray(64)), size_of(kind) or 20
    assert write_external(area, 16, kind, size, written)
    assert read_external(area, 16, kind, size) == pytest.approx(read)
    assert not any(area[:16])
    assert not any(area[16 + size :])


@settings(max_examples=300, deadline=None, derandomize=True)
@given(
    kind=st.sampled_from([*KINDS, "UNKNOWN"]),
    offset=st.integers(-100, 300),
    size=st.integers(-5, 100),
    value=st.floats() | st.integers() | st.text(max_size=200),
)
def test_nothing_that_is_written_raises_or_leaves_the_area(
    kind: str, offset: int, size: int, value: float | str
) -> None:
    memory = bytearray(300)
    write_external(memoryview(memory)[100:200], offset, kind, size, value)
    read_external(memoryview(memory)[100:200], offset, kind, size)
    assert not any(memory[:100])
    assert not any(memory[200:])
