"""The inputs and outputs by name, as the program sees them: `self.io.clamp_valve = not self.io.clamp_closed`.

Inputs are copied at the start of a cycle and outputs written at its end, so that one cycle sees one state of the
machine, and a cycle that fails half-way changes nothing outside.

A program may declare what it uses; then names and directions are checked when it starts, and type checkers know them:

    class MillIo(Io):
        clamp_closed: Input
        clamp_valve: Output
        pressure: AnalogueInput  # bar, as the machine description says
        valve_current: AnalogueOutput

    class Mill(Program):
        io: MillIo

Analogue values are in the unit of the machine description. `io.is_valid("pressure")` is FALSE while its node is lost or
the value is outside of its range; an output is kept within its limits.
"""

from __future__ import annotations

import difflib
import math
from array import array
from collections.abc import Callable, Mapping
from typing import Annotated, Any, TypeAlias, get_args, get_origin, get_type_hints

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.hli.analogue import AnaloguePlaces, OutputPlace
from runtime.hli.layout import ProcessImage
from runtime.plc_logic.errors import PlcError

INPUT, OUTPUT = "input", "output"
ANALOGUE_INPUT, ANALOGUE_OUTPUT = "analogue input", "analogue output"
Input: TypeAlias = Annotated[bool, INPUT]
Output: TypeAlias = Annotated[bool, OUTPUT]
AnalogueInput: TypeAlias = Annotated[float, ANALOGUE_INPUT]
AnalogueOutput: TypeAlias = Annotated[float, ANALOGUE_OUTPUT]
NO_ANALOGUE = AnaloguePlaces({}, {})


class Io:
    """Attributes are the names of the machine description; an unknown name, or an input that is set, raises
    PlcError."""

    _input_image: memoryview
    _output_image: memoryview
    _input_bits: dict[str, tuple[int, int]]
    _output_bits: dict[str, tuple[int, int]]
    _inputs: bytes
    _outputs: bytearray
    _image: ProcessImage
    _values_in_image: memoryview  # of the analogue inputs that the machine has
    _values_out_image: memoryview
    _input_values: list[float]
    _output_values: list[float]
    _valid: int
    _places: AnaloguePlaces

    def __init__(
        self,
        image: ProcessImage,
        inputs: Mapping[str, int],
        outputs: Mapping[str, int],
        analogue: AnaloguePlaces = NO_ANALOGUE,
    ) -> None:
        """`inputs` and `outputs`: name -> bit of the image; `analogue`: places of the others."""
        values_in = memoryview(image.analogue_in_r).cast("B").cast("d")[: len(analogue.inputs)]
        values_out = memoryview(image.analogue_out_w).cast("B").cast("d")[: len(analogue.outputs)]
        self.__dict__.update(
            _image=image,
            _values_in_image=values_in,
            _values_out_image=values_out,
            _input_values=values_in.tolist(),
            _output_values=values_out.tolist(),
            _valid=image.analogue_valid_r,
            _places=analogue,
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

    def __setattr__(self, name: str, value: float) -> None:
        _assignment(self)(self, name, value)

    def __dir__(self) -> list[str]:
        return [*self._input_bits, *self._output_bits, *self._places.inputs, *self._places.outputs]

    def is_valid(self, name: str) -> bool:
        """Whether the node of an analogue input is there, and the value within its range. Raises PlcError: no such input."""
        try:
            place = self._places.inputs[name]
        except KeyError:
            raise self._unknown(name) from None
        return self._valid >> place & 1 != 0

    def _put_out(self, name: str, place: OutputPlace, value: float) -> None:
        if not math.isfinite(value):
            raise PlcError(catalogue.PLC_VALUE, name=name, value=value)
        self._output_values[place.place] = max(place.least, min(place.greatest, value))

    def read_inputs(self) -> None:
        """Start of a cycle."""
        own = self.__dict__
        own["_inputs"] = bytes(self._input_image)
        if self._places.inputs:
            own["_input_values"] = self._values_in_image.tolist()
            own["_valid"] = self._image.analogue_valid_r

    def write_outputs(self) -> None:
        """End of a cycle."""
        self._output_image[:] = self._outputs
        if self._places.outputs:
            self._values_out_image[:] = memoryview(array("d", self._output_values))

    def take_outputs_of(self, other: Io) -> None:
        """Begin with the outputs as another version of the program has left them."""
        self._outputs[:] = other._outputs
        self._output_values[:] = other._output_values

    def _unknown(self, name: str) -> PlcError:
        names = Io.__dir__(self)
        near = difflib.get_close_matches(name, names, n=3) or names
        return PlcError(catalogue.PLC_IO_NAME, name=name, known=", ".join(near) or "none")


def io_of(
    program: type,
    image: ProcessImage,
    inputs: Mapping[str, int],
    outputs: Mapping[str, int],
    analogue: AnaloguePlaces = NO_ANALOGUE,
) -> Io:
    """The image for a program: of the class it declares for `io`, with a property for every name.

    Raises PlcError if that class declares a name the machine doesn't have, or the wrong direction.
    """
    declared = _declared_class(program)
    namespace: dict[str, Any] = {name: _bit("_inputs", bit) for name, bit in inputs.items()}
    namespace |= {name: _bit("_outputs", bit) for name, bit in outputs.items()}
    namespace |= {name: _value("_input_values", place) for name, place in analogue.inputs.items()}
    namespace |= {name: _value("_output_values", place.place) for name, place in analogue.outputs.items()}
    bound: Io = type(declared.__name__, (declared,), namespace)(image, inputs, outputs, analogue)
    kinds = dict.fromkeys(inputs, INPUT) | dict.fromkeys(outputs, OUTPUT)
    kinds |= dict.fromkeys(analogue.inputs, ANALOGUE_INPUT) | dict.fromkeys(analogue.outputs, ANALOGUE_OUTPUT)
    for name, hint in get_type_hints(declared, include_extras=True).items():
        kind = get_args(hint)[1] if get_origin(hint) is Annotated else None
        if kind not in (INPUT, OUTPUT, ANALOGUE_INPUT, ANALOGUE_OUTPUT):
            continue
        if name not in kinds:
            raise bound._unknown(name)
        if kinds[name] != kind:
            raise PlcError(catalogue.PLC_IO_DIRECTION, name=name, declared=kind, found=kinds[name])
    type(bound).__setattr__ = _assignment(bound)  # type: ignore[assignment]
    return bound


def _declared_class(program: type) -> type[Io]:
    try:
        hint = get_type_hints(program).get("io")
    except NameError:  # names that are imported for type checkers only
        return Io
    return hint if isinstance(hint, type) and issubclass(hint, Io) else Io


def _assignment(io: Io) -> Callable[[Io, str, float], None]:
    """`__setattr__` of the class that is made for one image: it has names and outputs at hand, which saves half its time."""
    outputs = io._outputs
    places = {name: (byte, mask, 0xFF ^ mask) for name, (byte, mask) in io._output_bits.items()}

    def assign(io: Io, name: str, value: float) -> None:
        try:
            byte, mask, others = places[name]
        except KeyError:
            if (place := io._places.outputs.get(name)) is not None:
                io._put_out(name, place, value)
                return
            if name in io._input_bits or name in io._places.inputs:
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


def _value(image: str, place: int) -> property:
    """Reads one analogue value."""
    read: Callable[[Io], float]
    if image == "_input_values":

        def read(io: Io) -> float:
            return io._input_values[place]
    else:

        def read(io: Io) -> float:
            return io._output_values[place]

    return property(read)
