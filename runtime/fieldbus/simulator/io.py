"""A simulated CiA 401 node: digital outputs go to the plant, digital inputs come from it."""

from __future__ import annotations

from typing import Final

from runtime.fieldbus.exchange import READ_INPUTS, WRITE_OUTPUTS
from runtime.fieldbus.network import PolledNetwork
from runtime.fieldbus.simulator.node import SimulatedNode

GROUPS: Final = 8  # bytes of inputs and of outputs
ERROR_MODE: Final = 0x6206  # bits that take the error value
ERROR_VALUE: Final = 0x6207


class SimulatedIo(SimulatedNode):
    """An I/O node with up to 64 inputs and 64 outputs, by their names in the machine description."""

    def __init__(
        self, node: int, eds: str, network: PolledNetwork, inputs: tuple[str, ...], outputs: tuple[str, ...]
    ) -> None:
        self.inputs = inputs
        self.outputs = outputs
        super().__init__(node, eds, network)
        self.reset_application()

    def reset_application(self) -> None:
        self.values = {(READ_INPUTS, k): self.values.get((READ_INPUTS, k), 0) for k in range(1, GROUPS + 1)}
        self.values |= {(WRITE_OUTPUTS, k): 0 for k in range(1, GROUPS + 1)}
        self.values[0x1001, 0] = 0

    def connection_lost(self) -> None:
        """Outputs take their error values (CiA 401): off, unless configured otherwise."""
        for k in range(1, GROUPS + 1):
            mask, value = self._number(ERROR_MODE, k), self._number(ERROR_VALUE, k)
            self.values[WRITE_OUTPUTS, k] = (self.values[WRITE_OUTPUTS, k] & ~mask) | (value & mask)

    def output_states(self) -> dict[str, bool]:
        return {name: bool(self.values[WRITE_OUTPUTS, k // 8 + 1] >> k % 8 & 1) for k, name in enumerate(self.outputs)}

    def set_inputs(self, states: dict[str, bool]) -> None:
        """Inputs that `states` does not name are FALSE."""
        for group in range(1, (len(self.inputs) + 7) // 8 + 1):
            names = self.inputs[(group - 1) * 8 : group * 8]
            self.values[READ_INPUTS, group] = sum(states.get(name, False) << k for k, name in enumerate(names))
