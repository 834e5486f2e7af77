"""The simulated plant: what its inputs are does not depend on how often it is asked."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.fieldbus.simulator import SimulatedPlant

OUTPUTS = ("clamp_valve", "coolant_pump", "magazine_step")
MOMENTS = st.lists(st.tuples(st.integers(1, 700), st.sampled_from((*OUTPUTS, ""))), min_size=1, max_size=8)


@settings(max_examples=40, deadline=None)
@given(moments=MOMENTS)
def test_rare_looks_see_what_constant_looks_see(moments: list[tuple[int, str]]) -> None:
    rare, constant = SimulatedPlant(), SimulatedPlant()
    outputs = dict.fromkeys(OUTPUTS, False)
    time_ms = 0
    for wait_ms, toggled in moments:
        for k in range(time_ms + 1, time_ms + wait_ms):
            constant.step(k * 1e-3, outputs)
        time_ms += wait_ms
        if toggled:
            outputs[toggled] = not outputs[toggled]
        assert rare.step(time_ms * 1e-3, outputs) == constant.step(time_ms * 1e-3, outputs)


def test_a_hand_on_the_door_is_seen_at_rest_too() -> None:
    plant = SimulatedPlant()
    for k in range(1000):
        assert plant.step(k * 1e-3, {})["door_closed"]
    plant.force("door_closed", False)
    assert not plant.step(1.0, {})["door_closed"]
    plant.force("door_closed", None)
    assert plant.step(1.001, {})["door_closed"]
