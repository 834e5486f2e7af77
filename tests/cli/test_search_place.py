"""Places of a block search as the user writes them, and the operator who orders them."""

from __future__ import annotations

from pathlib import Path

import pytest
import typer

from runtime.cli.search_place import search_order
from runtime.hli.errors import HliError
from runtime.hli.layout import SearchState
from runtime.hli.operator import OrderRefusedError
from runtime.testbench.bench import MachineBench

PART = "%PART\nN10 G90 G01 F6000 X10 Y10\nN20 X80\nN30 Y60\nN40 M30\n"


@pytest.mark.parametrize(
    ("place", "kind", "value"),
    [("N80", 4, 80), ("n 7", 4, 7), ("12", 5, 12), ("block:40", 3, 40), ("offset:1000", 1, 1000), ("", 0, 0)],
)
def test_places(place: str, kind: int, value: int) -> None:
    order = search_order(place, 3, "sub.nc", 12.5, 600.0, automatic=True)
    assert (order.type, order.value, order.passes, order.covered, order.return_feed) == (kind, value, 3, 125, 10_000)
    assert (order.program, order.automatic_return, order.no_hold) == (b"sub.nc", True, True)


@pytest.mark.parametrize("place", ["X80", "N", "line 5", "-3", "block:"])
def test_what_is_no_place(place: str) -> None:
    with pytest.raises(typer.BadParameter):
        search_order(place)


def test_the_operator_goes_on_where_a_program_was_interrupted(tmp_path: Path) -> None:
    bench = MachineBench(folder=tmp_path)
    channel = bench.simulation.controller.channel
    with pytest.raises(HliError):  # nothing was interrupted yet
        bench.operator.restart(search_order(""))
    bench.start_program(PART)
    bench.wait_until(lambda: bench.line == 3 and channel.interpolator.covered > 0.4)
    bench.press("reset")
    bench.wait_until(lambda: not channel.active)
    bench.run(0.05)
    stood = float(channel.interpolator.position[0])
    assert bench.operator.restart(search_order("")) == str(tmp_path / "program.nc")
    status = bench.hli.channels[0].status
    bench.wait_until(lambda: status.block_search_state_r == SearchState.WAIT_FOR_RETURN)
    bench.press("continue")
    bench.wait_until(lambda: status.block_search_state_r == SearchState.WAIT_TO_CONTINUE)
    assert float(channel.interpolator.position[0]) == pytest.approx(stood, abs=1e-3)
    bench.press("continue")
    bench.wait_until(lambda: not channel.active)
    assert [round(float(p), 6) for p in channel.interpolator.position[:2]] == [80.0, 60.0]
    assert bench.alarms == ()
    with pytest.raises(OrderRefusedError):  # the search of an order that is refused holds for no other one
        bench.operator.start("", search_order("N30"))
    assert not bench.hli.operator[0].block_search.semaphor_rw
