from __future__ import annotations

import numpy as np

from runtime.cnc.preparation_link import Failure, Order, PreparationLink, PreparationState, StartOrder


def test_an_order_crosses_shared_memory_and_is_answered() -> None:
    cycle = PreparationLink(3, "tandem-test-link")
    preparation = PreparationLink(3, "tandem-test-link", create=False)
    try:
        assert int(preparation.waiting_order) == Order.NONE
        cycle.start(StartOrder("/nc/ß.nc", np.array([1.0, 2.0, 3.0]), 0x3FF))
        assert not cycle.answered
        assert int(preparation.waiting_order) == Order.START
        order = preparation.read_start()
        assert (order.program, order.skip_levels) == ("/nc/ß.nc", 0x3FF)
        assert order.start.tolist() == [1.0, 2.0, 3.0]
        preparation.answer()
        assert cycle.answered
        assert cycle.state is PreparationState.RUNNING
        preparation.finish(PreparationState.FAILED, Failure(300001, "x" * 1000, "/nc/ß.nc", 17, 4))
        assert cycle.state is PreparationState.FAILED
        assert cycle.problem == Failure(300001, "x" * 400, "/nc/ß.nc", 17, 4)
    finally:
        preparation.close()
        cycle.close(unlink=True)


def test_a_new_start_forgets_the_old_problem() -> None:
    link = PreparationLink(2)
    link.finish(PreparationState.FAILED, Failure(300001, "old"))
    link.start(StartOrder("a.nc", np.zeros(2), 0))
    assert link.problem.id == 0
    link.answer()
    link.abort()
    assert link.waiting_order is Order.ABORT
