"""Texts beside the motion queue, reports beside the preparation link."""

from __future__ import annotations

import os

import numpy as np
import pytest

from runtime.cnc.decoder_reports import REPORTS, Report, ReportKind
from runtime.cnc.motion_queue import MotionQueue
from runtime.cnc.preparation_link import PreparationLink, StartOrder
from runtime.cnc.queue_texts import TEXT_BYTES, TEXTS


def test_texts_cross_shared_memory_in_their_order_and_free_their_places() -> None:
    name = f"tandem-test-texts-{os.getpid()}"
    producer, consumer = MotionQueue(2, name, capacity=8), MotionQueue(2, name, create=False, capacity=8)
    try:
        for turn in range(3):
            indices = [producer.texts.put(f"{turn}: {k} ü") for k in range(TEXTS)]
            assert producer.texts.free == 0
            assert consumer.texts.take(-1) == ""
            assert [consumer.texts.take(index) for index in indices] == [f"{turn}: {k} ü" for k in range(TEXTS)]
            assert producer.texts.free == TEXTS
        producer.texts.put("dropped")
        consumer.discard_all()
        assert producer.texts.free == TEXTS
    finally:
        consumer.close()
        producer.close(unlink=True)


def test_a_long_text_ends_at_a_letter() -> None:
    queue = MotionQueue(1, capacity=1)
    assert queue.texts.take(queue.texts.put("x" + "ü" * TEXT_BYTES)) == "x" + "ü" * ((TEXT_BYTES - 1) // 2)


@pytest.mark.parametrize("name", [None, "tandem-test-reports"], ids=["private", "shared"])
def test_reports_arrive_once_with_their_numbers(name: str | None) -> None:
    cycle = PreparationLink(3, name)
    preparation = cycle if name is None else PreparationLink(3, name, create=False)
    sent = [
        Report(ReportKind.MESSAGE, f"text {k}", "ß.nc", k, None if k % 2 else 10 * k, k % 4, k % 3 == 0)
        for k in range(REPORTS + 5)
    ]
    try:
        assert not cycle.told.waiting
        assert [preparation.told.put(report) for report in sent[:REPORTS]] == list(range(1, REPORTS + 1))
        assert preparation.told.free == 0
        assert not preparation.told.was_told(1)
        assert cycle.told.take() == (1, sent[0])
        assert preparation.told.was_told(1)
        assert not preparation.told.was_told(2)
        assert not preparation.told.was_taken(1)
        cycle.told.confirm(1)
        assert preparation.told.was_taken(1)
        assert preparation.told.free == 1
        received = [sent[0]]
        for report in sent[REPORTS:]:
            preparation.told.put(report)
            received.append(cycle.told.take()[1])
        while cycle.told.waiting:
            received.append(cycle.told.take()[1])
        assert received == sent
        assert preparation.told.last == len(sent)
    finally:
        if preparation is not cycle:
            preparation.close()
        cycle.close(unlink=True)


def test_a_place_that_is_reached_tells_its_positions_and_a_start_counts_anew() -> None:
    link = PreparationLink(2)
    link.reach(np.array([1.0, 2.0]), np.array([1.1, 2.2]))
    link.reach(np.array([3.0, 4.0]), np.array([3.1, 4.2]))
    link.set_holds(True)
    assert (link.reached, link.holds) == (2, True)
    assert link.command_position.tolist() == [3.0, 4.0]
    assert link.actual_position.tolist() == [3.1, 4.2]
    link.start(StartOrder("a.nc", np.zeros(2), 0))
    assert (link.reached, link.holds) == (0, False)
