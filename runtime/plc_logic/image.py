"""The inputs and outputs by name, as the program sees them: `self.io.clamp_valve = not self.io.clamp_closed`.

Inputs are copied at the start of a cycle and outputs written at its end, so that one cycle sees one state of the
machine, and a cycle that fails half-way changes nothing outside.

A program may declare what it uses; then names and directions are checked when it starts, and type checkers know them:

    class MillIo(Io):
        clamp_closed: Input
        clamp_valve: Output

    class Mill(Program):
        io: MillIo
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from typing import Annotated, Any, TypeAlias, get_args, get_origin, get_type_hints

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.hli.layout import ProcessImage
from runtime.plc_logic.errors import PlcError

INPUT, OUTPUT = "input", "output"
Input: TypeAlias = Annotated[bool, INPUT]
Output: TypeAlias = Annotated[bool, OUTPUT]


class Io:
    """Attributes are the names of the machine description; an unknown name, or an input that is set, raises
    PlcError."""

    _input_image: memoryview
    _output_image: memoryview
    _input_bits: dict[str, tuple[int, int]]
    _output_bits: dict[str, tuple[int, int]]
    _inputs: bytes
    _outputs: bytearray

    def __init__(self, image: ProcessImage, inputs: Mapping[str, int], outputs: Mapping[str, int]) -> None:
        """`inputs` and `outputs`: name -> bit of the image."""
        self.__dict__.update(
            _input_image=memoryview(image.digital_in_r).cast("B"),
            _output_image=memoryview(image.digital_out_w).cast("B"),
            _input_bits={name: (bit // 8, 1 << bit % 8) for name, bit in inputs.items()},
            _output_bits={name: (bit // 8, 1 << bit % 8) for name, bit in outputs.items()},
            _inputs=bytes(image.digital_in_r),
            _outputs=bytearray(image.digital_out_w),
        )

    def __getattr__(self, name: str) -> bool:
        if name.startswith("__"):
            raise AttributeError(name)
        raise self._unknown(name)

    def __setattr__(self, name: str, value: bool) -> None:
        _assignment(self)(self, name, value)

    def __dir__(self) -> list[str]:
        return [*self._input_bits, *self._output_bits]

    def read_inputs(self) -> None:
        """Start of a cycle."""
        self.__dict__["_inputs"] = bytes(self._input_image)

    def write_outputs(self) -> None:
        """End of a cycle."""
        self._output_image[:] = self._outputs

    def take_outputs_of(self, other: Io) -> None:
        """Begin with the outputs as another version of the program has left them."""
        self._outputs[:] = other._outputs

    def _unknown(self, name: str) -> PlcError:
        names = [*self._input_bits, *self._output_bits]
        near = difflib.get_close_matches(name, names, n=3) or names
        return PlcError(catalogue.PLC_IO_NAME, name=name, known=", ".join(near) or "none")


def io_of(program: type, image: ProcessImage, inputs: Mapping[str, int], outputs: Mapping[str, int]) -> Io:
    """The image for a program: of the class it declares for `io`, with a property for every name.

    Raises PlcError if that class declares a name the machine doesn't have, or the wrong direction.
    """
    declared = _declared_class(program)
    namespace: dict[str, Any] = {name: _bit("_inputs", bit) for name, bit in inputs.items()}
    namespace |= {name: _bit("_outputs", bit) for name, bit in outputs.items()}
    bound: Io = type(declared.__name__, (declared,), namespace)(image, inputs, outputs)
    for name, hint in get_type_hints(declared, include_extras=True).items():
        direction = get_args(hint)[1] if get_origin(hint) is Annotated else None
        if direction not in (INPUT, OUTPUT):
            continue
        if name not in inputs and name not in outputs:
            raise bound._unknown(name)
        if (name in inputs) is not (direction == INPUT):
            other = INPUT if name in inputs else OUTPUT
            raise PlcError(catalogue.PLC_IO_DIRECTION, name=name, declared=direction, found=other)
    type(bound).__setattr__ = _assignment(bound)  # type: ignore[assignment]
    return bound


def _declared_class(program: type) -> type[Io]:
    try:
        hint = get_type_hints(program).get("io")
    except NameError:  # names that are imported for type checkers only
        return Io
    return hint if isinstance(hint, type) and issubclass(hint, Io) else Io


def _assignment(io: Io) -> Callable[[Io, str, bool], None]:
    """`__setattr__` of the class that is made for one image: it has names and outputs at hand, which saves half its time."""
    outputs = io._outputs
    places = {name: (byte, mask, 0xFF ^ mask) for name, (byte, mask) in io._output_bits.items()}

    def assign(io: Io, name: str, value: bool) -> None:
        try:
            byte, mask, others = places[name]
        except KeyError:
            if name in io._input_bits:
                raise PlcError(catalogue.PLC_INPUT_ASSIGNED, name=name) from None
            raise io._unknown(name) from None
        if value:
            outputs[byte] |= mask
        else:
            outputs[byte] &= others

    return assign


def _bit(image: str, bit: int) -> property:
    """Reads one bit; a property of the class, as the lookup of a name that is none takes five times as long."""
    byte, mask = divmod(bit, 8)
    mask = 1 << mask
    read: Callable[[Io], bool]
    if image == "_inputs":

        def read(io: Io) -> bool:
            return io._inputs[byte] & mask != 0
    else:

        def read(io: Io) -> bool:
            return io._outputs[byte] & mask != 0

    return property(read)
