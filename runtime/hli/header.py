"""The C header of the HLI, generated from the structures, so that programs in other languages can attach.

Static asserts on every size and offset make a compiler with another idea of alignment fail at once.
"""

from __future__ import annotations

import ctypes as c
import inspect
from collections.abc import Iterator
from typing import Any

from runtime.hli import layout
from runtime.hli.layout import Hli
from runtime.hli.memory import layout_hash

_C_TYPES: dict[type, str] = {
    c.c_bool: "bool",
    c.c_char: "char",
    c.c_double: "double",
    c.c_int8: "int8_t",
    c.c_int16: "int16_t",
    c.c_int32: "int32_t",
    c.c_int64: "int64_t",
    c.c_uint8: "uint8_t",
    c.c_uint16: "uint16_t",
    c.c_uint32: "uint32_t",
    c.c_uint64: "uint64_t",
}
_ENUMS = (
    layout.Mode,
    layout.State,
    layout.StopCondition,
    layout.AxisState,
    layout.ManualMode,
    layout.ManualState,
    layout.Blocked,
)


def _structures(kind: Any) -> Iterator[type[c.Structure]]:
    """All structures below and with `kind`, each before the first one that contains it."""
    if issubclass(kind, c.Array):
        yield from _structures(kind._type_)
    elif issubclass(kind, c.Structure):
        for _, of, *_ in kind._fields_:
            yield from _structures(of)
        yield kind


def _snake(name: str) -> str:
    return "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in name).lstrip("_")


def _c_name(kind: type[c.Structure]) -> str:
    return "tandem_hli" if kind is Hli else f"tandem_{_snake(kind.__name__)}"


def _declaration(name: str, of: Any) -> str:
    lengths = ""
    while issubclass(of, c.Array):
        lengths += f"[{of._length_}]"
        of = of._type_
    c_type = _c_name(of) if issubclass(of, c.Structure) else _C_TYPES[of]
    return f"{c_type} {name}{lengths}"


def _structure(kind: type[c.Structure]) -> list[str]:
    name = _c_name(kind)
    comment = [f" * {line}".rstrip() for line in inspect.cleandoc(kind.__doc__ or "").splitlines()]
    lines = ["", "/*", *comment, " */", "typedef struct {"]
    lines += [f"    {_declaration(element, of)};" for element, of, *_ in kind._fields_]
    lines += [f"}} {name};", f'TANDEM_ASSERT(sizeof({name}) == {c.sizeof(kind)}, "size of {name}");']
    for element, *_ in kind._fields_:
        offset = getattr(kind, element).offset
        lines.append(f'TANDEM_ASSERT(offsetof({name}, {element}) == {offset}, "offset of {name}.{element}");')
    return lines


def c_header() -> str:
    """The whole header, C11 and C++11."""
    lines = [
        "/* The High-Level Interface of Tandem; made by `tandem hli header`, not to be edited. */",
        "#ifndef TANDEM_HLI_H",
        "#define TANDEM_HLI_H",
        "",
        "#include <stdbool.h>",
        "#include <stddef.h>",
        "#include <stdint.h>",
        "",
        "#ifdef __cplusplus",
        "#define TANDEM_ASSERT static_assert",
        "#else",
        "#define TANDEM_ASSERT _Static_assert",
        "#endif",
        "",
        "/* Compare both with head.magic_r and head.layout_hash_r before any other access. */",
        f"#define TANDEM_HLI_MAGIC UINT64_C({layout.MAGIC:#x})",
        f'#define TANDEM_HLI_LAYOUT_HASH "{layout_hash()}"',
        f'#define TANDEM_HLI_VERSION "{layout.VERSION}"',
        "",
    ]
    for name, value in vars(layout).items():
        if name.isupper() and isinstance(value, int) and name != "MAGIC":
            lines.append(f"#define TANDEM_{name} {value}")
    for enum in _ENUMS:
        prefix = f"TANDEM_{_snake(enum.__name__).upper()}"
        lines += ["", f"/* {inspect.cleandoc(enum.__doc__ or '')} */", "enum {"]
        lines += [f"    {prefix}_{member.name} = {member.value:#x}," for member in enum.__members__.values()]
        lines.append("};")
    seen: set[type[c.Structure]] = set()
    for kind in _structures(Hli):
        if kind not in seen:
            seen.add(kind)
            lines += _structure(kind)
    lines += ["", "#endif", ""]
    return "\n".join(lines)
