"""A simulated CiA 401 node: its outputs go to the plant, its inputs come from it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from runtime.config.machine import IoNode
from runtime.fieldbus.analogue import (
    COUNTS,
    DELTA,
    ERROR_MODE,
    ERROR_VALUE,
    GLOBAL_ENABLE,
    TRIGGER,
    TRIGGER_DELTA,
    AnalogueValues,
)
from runtime.fieldbus.exchange import READ_ANALOGUE, READ_INPUTS, WRITE_ANALOGUE, WRITE_OUTPUTS
from runtime.fieldbus.network import PolledNetwork
from runtime.fieldbus.simulator.node import Pdo, SimulatedNode

GROUPS: Final = 8  # bytes of inputs and of outputs, and analogue channels
DIGITAL_ERROR_MODE: Final = 0x6206  # bits that take the error value
DIGITAL_ERROR_VALUE: Final = 0x6207


class SimulatedIo(SimulatedNode):
    """An I/O node with up to 64 inputs and outputs, and 8 analogue ones, by their names in the machine description."""

    def __init__(self, described: IoNode, eds: str, network: PolledNetwork) -> None:
        self.inputs, self.outputs = described.inputs, described.outputs
        self.analogue = AnalogueValues.of(described, 0, 0)
        super().__init__(described.node, eds, network)
        self.reset_application()

    def reset_application(self) -> None:
        values = self.values
        self.values = {}
        for index in (READ_INPUTS, *READ_ANALOGUE.values()):
            self.values |= {(index, k): values.get((index, k), 0) for k in range(1, GROUPS + 1)}
        for index in (WRITE_OUTPUTS, *WRITE_ANALOGUE.values()):
            self.values |= {(index, k): 0 for k in range(1, GROUPS + 1)}
        self.values[0x1001, 0] = 0

    def connection_lost(self) -> None:
        """Outputs take their error values (CiA 401): off, unless configured otherwise."""
        for k in range(1, GROUPS + 1):
            mask, value = self._number(DIGITAL_ERROR_MODE, k), self._number(DIGITAL_ERROR_VALUE, k)
            self.values[WRITE_OUTPUTS, k] = (self.values[WRITE_OUTPUTS, k] & ~mask) | (value & mask)
        for one in self.analogue.outputs:
            if self._number(ERROR_MODE, one.key[1]):
                number = self._number(ERROR_VALUE, one.key[1])
                self.values[one.key] = self.analogue.counts_of(number, one.described.bits)

    def changed(self, pdo: Pdo) -> bool:
        """Analogue inputs are told when they have changed by their delta, and this is enabled."""
        objects = pdo.layout.objects
        if objects[0][0] not in READ_ANALOGUE.values():
            return super().changed(pdo)
        if not self._number(GLOBAL_ENABLE) or not pdo.sent:
            return False
        before = dict(zip(objects, pdo.layout.codec.unpack(pdo.sent), strict=True))
        for one in self.analogue.inputs:
            if one.key in before and self._number(TRIGGER, one.key[1]) & TRIGGER_DELTA:
                delta = self.analogue.counts_of(self._number(DELTA, one.key[1]), one.described.bits)
                if abs(self.values[one.key] - before[one.key]) >= max(delta, 1):
                    return True
        return False

    def output_states(self) -> dict[str, bool]:
        return {name: bool(self.values[WRITE_OUTPUTS, k // 8 + 1] >> k % 8 & 1) for k, name in enumerate(self.outputs)}

    def output_values(self) -> dict[str, float]:
        """Analogue outputs, in their unit."""
        return {
            one.described.name: one.described.offset + one.described.factor * self.values[one.key]
            for one in self.analogue.outputs
        }

    def set_inputs(self, states: dict[str, bool]) -> None:
        """Inputs that `states` does not name are FALSE."""
        for group in range(1, (len(self.inputs) + 7) // 8 + 1):
            names = self.inputs[(group - 1) * 8 : group * 8]
            self.values[READ_INPUTS, group] = sum(states.get(name, False) << k for k, name in enumerate(names))

    def set_input_values(self, values: Mapping[str, float]) -> None:
        """Analogue inputs, in their unit; what the converter cannot tell is its end."""
        for one in self.analogue.inputs:
            low, high = COUNTS[one.described.bits]
            counts = round((values.get(one.described.name, 0.0) - one.described.offset) / one.described.factor)
            self.values[one.key] = max(low, min(high, counts))
