"""Analogue inputs and outputs of CiA 401 nodes, from the machine description to the wire and back."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from runtime.config.analogue import AnalogueInput, AnalogueOutput
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.fieldbus import wire
from runtime.fieldbus.analogue import DELTA, ERROR_VALUE, GLOBAL_ENABLE, TRIGGER, Output
from runtime.fieldbus.described import make_links
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.links import Receiver
from runtime.fieldbus.simulator import Fault
from tests.fieldbus.rig import Rig, demo_description

PRESSURE = {"name": "pressure", "unit": "bar", "counts": [0, 20000], "values": [0, 10], "range": [-0.5, 9.5]}
LEVEL = {"name": "level", "bits": 8, "values": [0, 127]}
TORCH = {"name": "height", "bits": 32, "counts": [-1000000, 1000000], "values": [-5, 5], "unit": "mm", "delta": 0.01}
VALVE = {"name": "valve", "unit": "mA", "counts": [0, 10000], "values": [4, 20]}
FAN = {"name": "fan", "bits": 8, "counts": [0, 100], "values": [0, 100], "off": 30}


def described(**more: Any) -> dict[str, Any]:
    description = demo_description()
    node = {"node": 20, "analogue_inputs": [PRESSURE, LEVEL, TORCH], "analogue_outputs": [VALVE, FAN]}
    description["fieldbus"]["io"].append(node | more)
    return description


def _hear(heard: list[int], cob_id: int, take: Receiver, data: bytearray) -> None:
    heard.append(cob_id)
    take(data)


def test_values_come_and_go_in_their_units() -> None:
    with Rig(described()) as rig:
        rig.simulated.plant.values |= {"pressure": 5.0, "level": 100.0, "height": -2.5}
        rig.started()
        image, node = rig.image, rig.simulated.ios[20]
        assert image.analogue_in[:3].tolist() == [5.0, 100.0, -2.5]  # read at the boot
        assert image.analogue_valid[:4].tolist() == [True, True, True, False]
        image.analogue_out[:2] = 12.0, 55.0
        rig.simulated.plant.values |= {"pressure": 6.0, "level": -3.0}
        rig.cycle(25)
        assert image.analogue_in[:2].tolist() == [6.0, -3.0]
        assert node.values[0x6411, 1] == 5000
        assert node.values[0x6410, 2] == 55
        assert node.output_values() == {"valve": 12.0, "fan": 55.0}
        assert not rig.events


def test_inputs_come_every_so_many_cycles_and_watched_ones_when_they_change() -> None:
    with Rig(described(analogue_every=5)) as rig:
        rig.started()
        node = rig.simulated.ios[20]
        assert node._number(GLOBAL_ENABLE) == 1
        assert node._number(TRIGGER, 3) == 4
        assert node._number(DELTA, 3) == 2000  # 0.01 mm of 0.000005 mm
        assert node._number(TRIGGER, 1) == 7  # as the device has it
        heard: list[int] = []
        for cob_id in (0x194, 0x294):  # node 20 has no bits, so its PDOs 1 and 2
            rig.master.frames.table[cob_id] = partial(_hear, heard, cob_id, rig.master.frames.table[cob_id])
        rig.cycle(90)
        assert heard.count(0x194) == 18
        assert heard.count(0x294) <= 1  # its timer
        heard.clear()
        rig.simulated.plant.values["height"] = 0.02
        rig.cycle(3)
        assert rig.image.analogue_in[2] == pytest.approx(0.02)
        heard.clear()
        for k in range(50):  # it trembles by less than its delta
            rig.simulated.plant.values["height"] = 0.02 + 0.004 * (k % 2)
            rig.cycle()
        assert heard.count(0x294) == 0
        for k in range(50):  # more than that, in every cycle: told no more often than every fifth
            rig.simulated.plant.values["height"] = 0.1 * k
            rig.cycle()
        assert 9 <= heard.count(0x294) <= 11


def test_the_planned_load_is_the_measured_one() -> None:
    with Rig(described(analogue_every=2)) as rig:
        rig.started()
        rig.cycle(300)
        planned = wire.planned_load(make_links(rig.machine), rig.machine.fieldbus.bus, rig.machine.cycle.period)
        # what is told when it changes is planned at its worst
        assert rig.image.bus_load < planned
        rig.cycle(1)
        for k in range(300):
            rig.simulated.plant.values["height"] = 0.1 * (k % 20)
            rig.cycle()
        assert rig.image.bus_load == pytest.approx(planned, rel=0.01)


def test_a_broken_wire_is_not_valid_and_told_once_a_second() -> None:
    with Rig(described()) as rig:
        rig.started()
        rig.simulated.plant.values["pressure"] = -0.6
        rig.cycle(20)
        assert not rig.image.analogue_valid[0]
        assert rig.image.analogue_in[0] == pytest.approx(-0.6)
        assert rig.event_ids() == [catalogue.ANALOGUE_OUT_OF_RANGE.id]
        text = rig.problems()[0].text
        assert "I/O node 1 (node 20)" in text
        assert "pressure is -0.6 bar" in text
        for k in range(100):  # a loose contact
            rig.simulated.plant.values["pressure"] = -0.6 if k % 2 else 1.0
            rig.cycle(12)
        assert len(rig.events) == 2
        assert rig.image.analogue_valid[1]


def test_inputs_of_a_lost_node_are_not_valid_and_its_outputs_are_off() -> None:
    with Rig(described()) as rig:
        rig.simulated.plant.values["pressure"] = 3.0
        rig.started()
        rig.image.analogue_out[:2] = 12.0, 55.0
        rig.cycle(5)
        node = rig.simulated.ios[20]
        rig.simulated.inject(20, Fault.SILENT)
        assert rig.run_until(lambda: not rig.image.analogue_valid[:3].any())
        assert rig.image.analogue_in[0] == 3.0
        assert catalogue.HEARTBEAT_LOST.id in rig.event_ids()
        assert node._number(ERROR_VALUE, 2) == 30
        rig.simulated.heal(20)
        assert rig.run_until(lambda: bool(rig.image.analogue_valid[:3].all()), 12.0)
        assert node.output_values() == {"valve": 12.0, "fan": 55.0}
        rig.master_alive = False
        rig.cycle(400)  # the heartbeat of the master is missed
        assert node.output_values() == {"valve": 4.0, "fan": 30.0}


def test_at_the_end_outputs_are_off() -> None:
    with Rig(described()) as rig:
        rig.started()
        rig.image.analogue_out[:2] = 12.0, 55.0
        rig.cycle(5)
        rig.master.stop()
        rig.idle()
        assert rig.simulated.ios[20].output_values() == {"valve": 4.0, "fan": 30.0}


def test_a_delta_in_the_upper_bits() -> None:
    watched = LEVEL | {"bits": 16, "counts": [0, 1000], "values": [0, 10], "delta": 1}
    with Rig(described(analogue_inputs=[watched], left_adjusted=True)) as rig:
        rig.started()
        node = rig.simulated.ios[20]
        assert node._number(DELTA, 1) == 100 << 16
        timer = node._transmit[0].sent_at
        assert rig.run_until(lambda: node._transmit[0].sent_at > timer)
        rig.simulated.plant.values["level"] = 0.9
        rig.cycle(20)
        assert rig.image.analogue_in[0] == 0.0
        rig.simulated.plant.values["level"] = 1.1
        rig.cycle(20)
        assert rig.image.analogue_in[0] == pytest.approx(1.1)


@given(
    value=st.floats(allow_nan=True, allow_infinity=True),
    bits=st.sampled_from([8, 16, 32]),
    values=st.tuples(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4)).filter(lambda ends: abs(ends[0] - ends[1]) > 1.0),
    share=st.floats(0.0, 1.0),
)
def test_an_output_never_leaves_its_limits(value: float, bits: Any, values: tuple[float, float], share: float) -> None:
    low, high = min(values), max(values)
    bound = low + share * (high - low) / 2
    one = AnalogueOutput(
        name="x", bits=bits, values=values, range=(bound, high), off=high
    )  # fmt: skip
    counts = Output(one, (0x6411, 1), 0).counts(value)
    assert abs(counts) <= 1 << bits - 1
    put_out = one.offset + one.factor * counts
    half = abs(one.factor) / 2 + 1e-9 * max(abs(low), abs(high), 1.0)
    assert bound - half <= put_out <= high + half
    if math.isfinite(value) and bound <= value <= high:
        assert abs(put_out - value) <= half


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"analogue_inputs": [PRESSURE, PRESSURE]}, "Input or output 'pressure' is given"),
        ({"analogue_inputs": [PRESSURE | {"name": "door_closed"}]}, "Input or output 'door_closed' is given"),
        ({"analogue_inputs": [PRESSURE | {"channel": 3}, LEVEL | {"channel": 3}]}, "channel 3 of the device is given twice"),
        ({"analogue_inputs": [LEVEL | {"counts": [0, 128]}]}, "counts of 8 bits go from -128 to 127"),
        ({"analogue_inputs": [LEVEL | {"counts": [5, 5]}]}, "both ends are the same"),
        ({"analogue_inputs": [LEVEL | {"range": [5, 5]}]}, "its first value is not below the second"),
        ({"analogue_outputs": [FAN | {"range": [0, 128]}]}, "the counts reach from -128 to 127"),
        ({"analogue_outputs": [FAN | {"off": 101}]}, "101 is not between 0 and 100"),
        ({"analogue_outputs": [FAN | {"name": f"f{k}"} for k in range(33)]}, "a machine has 32 at most"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused(change: dict[str, Any], says: str) -> None:
    with pytest.raises(ValidationError, match=says):
        Machine.model_validate(described(**change))


def test_a_device_without_the_object_is_refused() -> None:
    many = [LEVEL | {"name": f"level_{k}", "bits": 16} for k in range(9)]
    with Rig(described(analogue_inputs=many)) as rig, pytest.raises(FieldbusError, match="0x6401:9"):
        rig.master.start()


def test_more_values_than_the_predefined_pdos_carry() -> None:
    inputs = [{"name": f"i{k}", "bits": 32, "counts": [0, 1000], "values": [0, 1000]} for k in range(8)]
    outputs = [{"name": f"o{k}", "bits": 32, "counts": [0, 1000], "values": [0, 1000]} for k in range(8)]
    more = {"inputs": ["a"], "outputs": ["b"], "analogue_inputs": inputs, "analogue_outputs": outputs}
    with Rig(described(**more)) as rig:
        rig.simulated.plant.values |= {f"i{k}": 10.0 * k for k in range(8)}
        rig.started()
        own = {plan.own_cob_id for link in rig.master._links for plan in link.layouts if plan.number > 4}
        assert own == {0x680, 0x681}  # PDO 5 of each direction: one has the bits
        node = rig.simulated.ios[20]
        assert node._number(0x1404, 1) in own
        assert node._number(0x1804, 1) & 0x7FF in own
        rig.simulated.plant.values |= {f"i{k}": 20.0 * k for k in range(8)}
        rig.image.analogue_out[:8] = np.arange(8) * 3.0
        rig.cycle(15)
        assert rig.image.analogue_in[:8].tolist() == [20.0 * k for k in range(8)]
        assert list(node.output_values().values()) == [3.0 * k for k in range(8)]
        rig.simulated.inject(20, Fault.SILENT)  # and what has an identifier of its own is silent too
        rig.simulated.plant.values |= {f"i{k}": 1.0 for k in range(8)}
        rig.cycle(50)
        assert rig.image.analogue_in[7] == 140.0


def test_input_and_scale() -> None:
    one = AnalogueInput(name="x", counts=(6400, 32000), values=(4.0, 20.0))
    assert one.offset == 0.0
    assert one.factor * 19200 == 12.0
    falling = AnalogueInput(name="x", bits=8, values=(127.0, 0.0))
    assert falling.offset == 127.0
    assert falling.bounds == (0.0, 255.0)
