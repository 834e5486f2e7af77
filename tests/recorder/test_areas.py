"""A memory that two write to: nothing is lost, flags come last, and what was recorded makes the same memory again."""

from __future__ import annotations

import ctypes as c

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.config import load_machine
from runtime.hli.layout import Hli
from runtime.hli.memory import HliMemory
from runtime.recorder.areas import Area, apply_changes, words_of
from runtime.recorder.elements import elements_of
from runtime.recorder.machine_areas import hli_area

OUT = np.zeros(4096, dtype=np.int64)


class Mixed(c.Structure):
    """Elements of every size, some beside each other in one word."""

    _fields_ = (
        ("flag_rw", c.c_bool),
        ("a_w", c.c_uint8),
        ("b_r", c.c_uint16),
        ("c_w", c.c_int32),
        ("text_w", c.c_char * 13),
        ("d_r", c.c_double),
        ("second_rw", c.c_bool),
        ("e_r", c.c_uint64 * 12),
    )


NAMES = ("flag_rw", "a_w", "b_r", "c_w", "d_r", "second_rw")


def area() -> tuple[Mixed, Mixed, Area]:
    shared, own = Mixed(), Mixed()
    return shared, own, Area(words_of(shared), words_of(own), elements_of(Mixed))


writes = st.lists(st.tuples(st.sampled_from(NAMES), st.integers(0, 1)), max_size=6)


@pytest.mark.uncompiled
@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(writes, writes), max_size=6))
def test_both_sides_agree_and_the_record_makes_the_same_memory(rounds: list[tuple[list[tuple[str, int]], ...]]) -> None:
    shared, own, border = area()
    again = np.zeros_like(border.own)
    agreed = again.copy()
    for number, (others, ours) in enumerate(rounds, 1):
        for name, value in others:
            setattr(shared, name, value * number)
        end = border.take_in(1, OUT, 0)
        apply_changes(OUT[1:end], again, agreed)
        assert bytes(shared) == bytes(own)
        for name, value in ours:
            setattr(own, name, value * number)
        end = border.give_out(2, OUT, 0)
        apply_changes(OUT[1:end], again, agreed)
        assert bytes(shared) == bytes(own)
        assert again.tobytes() == bytes(own)


def test_what_others_write_beside_our_element_in_the_same_word_stays() -> None:
    shared, own, border = area()
    own.b_r = 500
    shared.a_w, shared.c_w = 7, -3  # after the cycle has begun
    border.give_out(2, OUT, 0)
    assert (shared.a_w, shared.b_r, shared.c_w) == (7, 500, -3)
    border.take_in(1, OUT, 0)
    assert (own.a_w, own.b_r, own.c_w) == (7, 500, -3)


def test_flags_come_in_before_what_they_guard_and_go_out_behind_it() -> None:
    shared, own, border = area()
    shared.text_w, shared.second_rw = b"order", True
    end = border.take_in(1, OUT, 0)
    first = int(OUT[1]) >> 32
    assert first == Mixed.second_rw.offset // 8
    own.d_r, own.second_rw = 2.5, False
    end = border.give_out(2, OUT, 0)
    assert int(OUT[end - 2]) >> 32 == Mixed.second_rw.offset // 8
    assert (shared.d_r, shared.second_rw) == (2.5, False)


def test_every_flag_of_the_hli_is_one_and_every_byte_belongs_to_an_element() -> None:
    flags = {element.name.rsplit(".", 1)[-1] for element in elements_of(Hli) if element.flag}
    assert {"command_semaphor_rw", "semaphor_rw", "please_rw", "order_semaphor_rw", "sequence_r"} <= flags
    private = HliMemory.private()
    found = hli_area(load_machine(None), HliMemory.private().hli, private.hli)
    looked_at = {int(word) for begin, end in found.guarded for word in range(begin, end)} | set(found.flags.tolist())
    for name in ("head", "platform", "image", "timers", "alarms"):
        place = getattr(Hli, name)
        assert set(range(place.offset // 8, (place.offset + place.size) // 8)) <= looked_at, name
    assert (Hli.external_names.offset + 800) // 8 not in looked_at


def test_a_record_without_room_is_told_and_what_came_is_whole() -> None:
    shared, own, border = area()
    for k in range(12):
        shared.e_r[k] = k + 1
    small = np.zeros(6, dtype=np.int64)
    assert border.take_in(1, small, 0) > len(small)
    assert bytes(shared) == bytes(own)
