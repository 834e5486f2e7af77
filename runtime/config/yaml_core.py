"""YAML with the core schema of YAML 1.2: `on`, `NO` and `12:30` are text, `010` is ten, `1e3` is a number.

PyYAML follows YAML 1.1, where these are true, false, 750, eight and text.
"""

from __future__ import annotations

import math
import re

import yaml

_PREFIX = "tag:yaml.org,2002:"
_NUMBER_START = list("-+.0123456789")
_RESOLVERS: tuple[tuple[str, str, list[str]], ...] = (
    ("bool", r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    ("null", r"null|Null|NULL|~|", ["n", "N", "~", ""]),
    ("int", r"[-+]?[0-9]{1,30}|0x[0-9a-fA-F]{1,16}|0o[0-7]{1,20}", _NUMBER_START),
    (
        "float",
        r"[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)",
        _NUMBER_START,
    ),
    ("merge", r"<<", ["<"]),
)


class CoreLoader(yaml.SafeLoader):
    """Builds plain values only: mappings, lists, text, numbers, booleans, null."""

    yaml_implicit_resolvers: dict[str, list[tuple[str, re.Pattern[str]]]] = {}  # noqa: RUF012 - PyYAML's own class table

    def construct_core_int(self, node: yaml.ScalarNode) -> int:
        text = str(self.construct_scalar(node))
        return int(text, 0) if text[:2] in ("0x", "0o") else int(text)

    def construct_core_float(self, node: yaml.ScalarNode) -> float:
        text = str(self.construct_scalar(node)).lower()
        if text.endswith((".inf", ".nan")):
            return math.nan if "nan" in text else float(text.replace(".", ""))
        return float(text)


for _name, _pattern, _first in _RESOLVERS:
    CoreLoader.add_implicit_resolver(_PREFIX + _name, re.compile(rf"(?:{_pattern})\Z"), _first)
CoreLoader.add_constructor(_PREFIX + "int", CoreLoader.construct_core_int)
CoreLoader.add_constructor(_PREFIX + "float", CoreLoader.construct_core_float)


def plain_tag(loader: CoreLoader, node: yaml.Node) -> bool:
    """Whether a node is a plain value: no tag of Python objects, and no tag that contradicts the text (`!!int abc`)."""
    kind = node.tag.removeprefix(_PREFIX)
    if isinstance(node, yaml.MappingNode):
        return bool(kind == "map")
    if isinstance(node, yaml.SequenceNode):
        return bool(kind == "seq")
    resolved = loader.resolve(yaml.ScalarNode, node.value, (True, False))  # type: ignore[no-untyped-call]
    return bool(kind == "str" or resolved == node.tag)
