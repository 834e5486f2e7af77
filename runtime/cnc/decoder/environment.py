"""What names in expressions mean to a running program: the decoder's side of `Environment`."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from runtime.cnc.decoder.isg.known_variables import purpose_of
from runtime.cnc.decoder.isg.registry import VARIABLES, Variable
from runtime.cnc.decoder.user_variables import Scope
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg import functions
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import NAMES
from runtime.cnc.language.isg.environment import Access
from runtime.cnc.language.isg.words import ValueKind
from runtime.diagnostics.catalogue import language as catalogue

if TYPE_CHECKING:
    from runtime.cnc.decoder.execution import Execution

_USER = re.compile(r"V\.(P|S|L|CYC)\.([^\[\]]+)((?:\[\])*)$")
_EXTERNAL = "V.E."
_CLASSES = ("V.G.", "V.A.", "V.SPDL.", "V.SPDL_PROG.", "V.P.", "V.S.", "V.L.", "V.CYC.", "V.E.", "V.TOOL.", "V.TLM.")
_HINT = "classes: V.G, V.A, V.SPDL, V.SPDL_PROG, V.E, V.P, V.S, V.L, V.CYC; tandem lang lists the predefined ones"


class DecoderEnvironment:
    """Binds names to callables of one execution; every path is bound once and kept."""

    def __init__(self, execution: Execution) -> None:
        self._x = execution
        self._bound: dict[tuple[str, str], Access] = {}
        self.namespace: dict[str, object] = {
            **NAMES,
            "p": execution.parameters,
            "known_m": execution.setup.m_numbers,
            "known_h": execution.setup.h_numbers,
            "set_parameter": self._set_parameter,
            "new_parameter": self.new_parameter,
            "begin_transfer": execution.begin_transfer,
            "give_transfer": execution.give_transfer,
            "macro": self.macro,
            "macro_length": self._macro_length,
            "macro_content": self._macro_content,
        }

    # ------------------------------------------------------------------ Environment

    def read(self, path: str, column: int) -> Access:
        return self._access("get", path, column, self._reader)

    def write(self, path: str, column: int) -> Access:
        return self._access("set", path, column, self._writer)

    def exists(self, path: str) -> str:
        return self._access("has", path, 1, self._tester).name

    def size(self, path: str) -> str:
        return self._access("size", path, 1, self._sizer).name

    def macro(self, name: str) -> str | None:
        content = self._x.memory.macros.get(name)
        return content if content is not None else self._x.setup.macros.get(name)

    @property
    def macro_version(self) -> int:
        return self._x.memory.macro_version

    # ------------------------------------------------------------------ binding

    def _access(
        self, kind: str, path: str, column: int, make: Callable[[str, int], tuple[Callable[..., Any], ValueKind, bool]]
    ) -> Access:
        access = self._bound.get((kind, path))
        if access is None:
            call, gives, flush = make(path, column)
            name = f"{kind}_{len(self._bound)}"
            self.namespace[name] = call
            access = self._bound[kind, path] = Access(name, gives, flush)
        return access

    def _reader(self, path: str, column: int) -> tuple[Callable[..., Any], ValueKind, bool]:
        if path == "@P[]":
            return self._x.read_transfer, ValueKind.ANY, False
        if path.startswith("P[]"):
            return self._read_parameter_array, ValueKind.NUMBER, False
        match = _USER.match(path)
        if match:
            name, brackets = match.group(2), match.group(3)
            scope = self._scope(match.group(1))
            if not brackets:
                return (lambda: scope(name).read(name)), ValueKind.ANY, False
            return (lambda *indices: scope(name).read_element(name, indices)), ValueKind.ANY, False
        if path.startswith(_EXTERNAL):
            item = self._x.external.item(path, column)
            return item.read, item.kind, item.synchronous
        variable, axis = self._predefined(path, column)
        return self._with_axis(variable.read, variable, axis, 0), variable.kind, variable.flush

    def _writer(self, path: str, column: int) -> tuple[Callable[..., Any], ValueKind, bool]:
        if path == "@P[]":
            return self._x.write_transfer, ValueKind.ANY, False
        if path.startswith("P[]"):
            return self._write_parameter_array, ValueKind.NUMBER, False
        match = _USER.match(path)
        if match:
            kind, name, brackets = match.groups()
            if brackets:
                scope = self._scope(kind)
                return (lambda value, *indices: scope(name).write_element(name, value, indices)), ValueKind.ANY, False
            return self._scalar_writer(kind, name), ValueKind.ANY, False
        if path.startswith(_EXTERNAL):
            item = self._x.external.item(path, column)
            if not item.writable:
                raise LineError(catalogue.VARIABLE_READ_ONLY, column, name=path)
            return item.write, item.kind, False
        variable, axis = self._predefined(path, column)
        if variable.write is None:
            raise LineError(catalogue.VARIABLE_READ_ONLY, column, name=path.replace("[]", "[..]"))
        return self._with_axis(variable.write, variable, axis, 1), variable.kind, False

    def _tester(self, path: str, _: int) -> tuple[Callable[..., Any], ValueKind, bool]:
        if path == "@P[]":
            return self._x.has_transfer, ValueKind.NUMBER, False
        if path.startswith("P[]"):
            return self._has_parameter_array, ValueKind.NUMBER, False
        match = _USER.match(path)
        if match:
            scope, name = self._scope(match.group(1)), match.group(2)
            return (lambda *indices: scope(name).exists(name, indices)), ValueKind.NUMBER, False
        try:
            call, _, _ = self._reader(path, 1)
        except LineError:
            return (lambda *_indices: 0.0), ValueKind.NUMBER, False
        if path.startswith(_EXTERNAL):
            item = self._x.external.item(path, 1)
            return item.exists, ValueKind.NUMBER, False
        return partial(_readable, call), ValueKind.NUMBER, False

    def _sizer(self, path: str, _: int) -> tuple[Callable[..., Any], ValueKind, bool]:
        if path.startswith("P[]"):
            return self._size_parameter_array, ValueKind.NUMBER, False
        match = _USER.match(path)
        if match:
            scope, name = self._scope(match.group(1)), match.group(2)
            return (lambda dimension, *_: scope(name).size(name, dimension)), ValueKind.NUMBER, False
        if path.startswith(_EXTERNAL):
            return self._x.external.sizes(path), ValueKind.NUMBER, False
        return (lambda *_: -1.0), ValueKind.NUMBER, False

    def _predefined(self, path: str, column: int) -> tuple[Variable, int | None]:
        """The registered variable of a path, and the channel index of the axis or spindle that its name ends with."""
        variable = VARIABLES.get(path)
        if variable is not None:
            return variable, None
        head, _, last = path.rpartition(".")
        setup = self._x.setup
        beside = tuple(axis.name for axis in setup.other_axes)
        for what, names in (("<axis>", setup.axes), ("<axis beside>", beside), ("<spindle>", setup.spindle_names)):
            if last in names and f"{head}.{what}" in VARIABLES:
                return VARIABLES[f"{head}.{what}"], names.index(last)
            if path.endswith("[]") and what != "<axis beside>" and f"{path[:-2]}.{what}" in VARIABLES:
                return VARIABLES[f"{path[:-2]}.{what}"], None
        shown = path.replace("[]", "[..]")
        purpose = purpose_of(path)
        if purpose:
            raise LineError(catalogue.VARIABLE_UNSUPPORTED, column, name=shown, purpose=purpose)
        known_class = any(path.startswith(prefix) for prefix in _CLASSES)
        hint = f"axes: {', '.join(self._x.setup.axes)}" if known_class and f"{head}.<axis>" in VARIABLES else _HINT
        raise LineError(catalogue.VARIABLE_UNKNOWN, column, name=shown, hint=hint)

    def _with_axis(
        self, call: Callable[..., Any], variable: Variable, axis: int | None, values: int
    ) -> Callable[..., Any]:
        """The handler bound to the execution; indices of axes are whole numbers within the channel."""
        x = self._x
        count = 0
        if variable.path.endswith(".<axis>"):
            count = len(x.setup.axes)
        elif variable.path.endswith(".<axis beside>"):
            count = len(x.setup.other_axes)
        elif variable.path.endswith(".<spindle>"):
            count = len(x.setup.spindle_names)
        if not count:
            return partial(call, x)
        if axis is not None:
            return lambda *arguments: call(x, *arguments, axis)

        def by_index(*arguments: Any) -> Any:
            index = arguments[-1]
            if not -0.5 <= index < count - 0.5:
                raise CalculationError(catalogue.ARRAY_INDEX, variable.path, value=index, last=count - 1)
            return call(x, *arguments[:-1], functions.round_half_up(index))

        return by_index

    # ------------------------------------------------------------------ scopes

    def _scope(self, kind: str) -> Callable[[str], Scope]:
        """Where a variable of this class is read: for V.L and V.CYC the innermost level that has it."""
        x = self._x
        if kind == "P":
            return lambda _name: x.program_scope
        if kind == "S":
            return lambda _name: x.memory.static
        return x.local_scope if kind == "L" else x.cycle_scope

    def _scalar_writer(self, kind: str, name: str) -> Callable[[object], None]:
        """Writes a scalar where it is seen; between #VAR and #ENDVAR it is made anew on the level in work."""
        x, written = self._x, self._scope(kind)

        def write(value: object) -> None:
            scope = x.own_scope(kind) if x.declaring else written(name)
            there = name in scope
            if x.declaring:
                scope.declare(name, "", (), [value])
            else:
                scope.write(name, value)
            if kind == "CYC" and not there:
                x.check_cycle_memory(scope, name)

        return write

    # ------------------------------------------------------------------ P arrays and macros

    def new_parameter(self, number: int) -> None:
        """A parameter comes into being; CalculationError if there are too many, or an array has its number."""
        x = self._x
        if str(number) in x.parameter_arrays:
            raise CalculationError(catalogue.ARRAY_NEEDED, f"P{number}", given=0)
        limit = x.setup.limits.parameters
        if len(x.parameters) + len(x.parameter_arrays.arrays) >= limit:
            raise CalculationError(catalogue.VARIABLE_LIMIT, f"P{number}", limit=limit)

    def _set_parameter(self, number: int, value: float) -> None:
        if number not in self._x.parameters:
            self.new_parameter(number)
        self._x.parameters[number] = functions.as_number(value, f"P{number}")

    def _read_parameter_array(self, number: float, *indices: float) -> Any:
        return self._x.parameter_arrays.read_element(_parameter_name(number), indices)

    def _write_parameter_array(self, value: object, number: float, *indices: float) -> None:
        self._x.parameter_arrays.write_element(_parameter_name(number), value, indices)

    def _has_parameter_array(self, number: float, *indices: float) -> float:
        return self._x.parameter_arrays.exists(_parameter_name(number), indices)

    def _size_parameter_array(self, dimension: float, number: float) -> float:
        return self._x.parameter_arrays.size(_parameter_name(number), dimension)

    def _macro_length(self, name: str) -> float:
        content = self.macro(name)
        return -1.0 if content is None else float(len(content))

    def _macro_content(self, name: str) -> str:
        content = self.macro(name)
        if content is None:
            raise CalculationError(catalogue.MACRO_UNDEFINED, name, name=name)
        return self._x.expand(content)


def _parameter_name(number: float) -> str:
    return str(functions.round_half_up(number))


def _readable(call: Callable[..., Any], *indices: float) -> float:
    try:
        call(*indices)
    except (CalculationError, LineError):
        return 0.0
    return 1.0
