"""The digital inputs and outputs by name, as the program sees them: `self.io.clamp_valve = not self.io.clamp_closed`.

Inputs are copied at the start of a cycle and outputs written at its end, so that one cycle sees one state of the
machine, and a cycle that fails half-way changes nothing outside.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.hli.layout import ProcessImage
from runtime.plc_logic.errors import PlcError


class Io:
    """Attributes are the names of the machine description; an unknown name, or an input that is set, raises
    PlcError."""

    __slots__ = ("_input_bits", "_input_image", "_inputs", "_output_bits", "_output_image", "_outputs")

    _input_image: memoryview
    _output_image: memoryview
    _input_bits: dict[str, tuple[int, int]]
    _output_bits: dict[str, tuple[int, int]]
    _inputs: bytes
    _outputs: bytearray

    def __init__(self, image: ProcessImage, inputs: Mapping[str, int], outputs: Mapping[str, int]) -> None:
        """`inputs` and `outputs`: name -> bit of the image."""
        place = object.__setattr__
        place(self, "_input_image", memoryview(image.digital_in_r).cast("B"))
        place(self, "_output_image", memoryview(image.digital_out_w).cast("B"))
        place(self, "_input_bits", {name: (bit // 8, 1 << bit % 8) for name, bit in inputs.items()})
        place(self, "_output_bits", {name: (bit // 8, 1 << bit % 8) for name, bit in outputs.items()})
        place(self, "_inputs", bytes(image.digital_in_r))
        place(self, "_outputs", bytearray(image.digital_out_w))

    def __getattr__(self, name: str) -> bool:
        if (place := self._input_bits.get(name)) is not None:
            return self._inputs[place[0]] & place[1] != 0
        if (place := self._output_bits.get(name)) is not None:
            return self._outputs[place[0]] & place[1] != 0
        if name.startswith("__"):
            raise AttributeError(name)
        raise self._unknown(name)

    def __setattr__(self, name: str, value: bool) -> None:
        if (place := self._output_bits.get(name)) is None:
            if name in self._input_bits:
                raise PlcError(catalogue.PLC_INPUT_ASSIGNED, name=name)
            raise self._unknown(name)
        if value:
            self._outputs[place[0]] |= place[1]
        else:
            self._outputs[place[0]] &= ~place[1]

    def __dir__(self) -> list[str]:
        return [*self._input_bits, *self._output_bits]

    def read_inputs(self) -> None:
        """Start of a cycle."""
        object.__setattr__(self, "_inputs", bytes(self._input_image))

    def write_outputs(self) -> None:
        """End of a cycle."""
        self._output_image[:] = self._outputs

    def _unknown(self, name: str) -> PlcError:
        names = [*self._input_bits, *self._output_bits]
        near = difflib.get_close_matches(name, names, n=3) or names
        return PlcError(catalogue.PLC_IO_NAME, name=name, known=", ".join(near) or "none")
