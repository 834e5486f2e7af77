"""Elements of all axes as one record array."""

from __future__ import annotations

from runtime.hli.layout import MAX_AXES, Hli
from runtime.hli.records import records


def test_the_array_is_a_view_of_the_areas() -> None:
    hli = Hli()
    areas = records(hli.axes, 3, "status.actual_position_r", "error_r", "control.override.state_r")
    assert areas.dtype.names == ("actual_position_r", "error_r", "state_r")
    areas["actual_position_r"] = [10, -20, 30]
    areas["error_r"][1] = True
    hli.axes[2].control.override.state_r = 700
    assert [hli.axes[i].status.actual_position_r for i in range(3)] == [10, -20, 30]
    assert [hli.axes[i].error_r for i in range(3)] == [False, True, False]
    assert areas["state_r"].tolist() == [0, 0, 700]


def test_the_last_area_is_reached() -> None:
    hli = Hli()
    records(hli.axes, MAX_AXES, "status.in_position_r")["in_position_r"][-1] = True
    assert hli.axes[MAX_AXES - 1].status.in_position_r
    assert not hli.axes[MAX_AXES - 2].status.in_position_r
