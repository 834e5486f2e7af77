"""What channel parameters have to do with each other."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping

from runtime.config.channel.key import Key, key_text
from runtime.config.channel.parameter import Value
from runtime.config.channel.parameters import DecoderConfiguration, PathKind
from runtime.config.contradictions import Contradiction
from runtime.diagnostics.catalogue import configuration as errors

# P-CHAN-00063 (manual line 5130): G group -> functions that may be active at program start
START_G_FUNCTIONS: Mapping[int, tuple[int, ...]] = {
    0: (0, 1, 2, 3, 4),
    4: (17, 18, 19),
    6: (25, 26),
    8: (51, 52),
    12: (70, 71),
    14: (90, 91),
    21: (135, 137),
    22: (138, 139, 236, 237, 238, 239),
    23: (161, 162),
    25: (164, 165),
    32: (140, 141),
}
START_M_FUNCTIONS: Mapping[int, tuple[int, ...]] = {0: (3, 4, 5)}
_START_TABLES: Mapping[Key, Mapping[int, tuple[int, ...]]] = {
    ("prog_start", "g_gruppe"): START_G_FUNCTIONS,
    ("prog_start", "m_gruppe"): START_M_FUNCTIONS,
}
_Values = Mapping[Key, Value]


def check(values: dict[Key, Value]) -> tuple[tuple[Contradiction, ...], tuple[Contradiction, ...]]:
    """Mistakes and warnings; their locations are keys. A feed unit that does not exist is replaced in `values`."""
    mistakes = (
        *_gaps(values),
        *_missing_members(values),
        *_spindles(values),
        *_start_functions(values),
        *_macros(values),
        *_paths(values),
        *_weights(values),
        *_run_ahead(values),
    )
    return mistakes, tuple(_feed_unit(values))


def _members(values: _Values, group: str) -> dict[int, dict[str, Value]]:
    """Index -> member -> value of `group[i].member`."""
    members: dict[int, dict[str, Value]] = defaultdict(dict)
    for key, value in values.items():
        if key[0] == group and len(key) == 3:
            members[int(key[1])][str(key[2])] = value
    return members


def _gaps(values: _Values) -> Iterator[Contradiction]:
    indices = sorted(_members(values, "spindel"))
    for expected, index in enumerate(indices):
        if index != expected:
            yield Contradiction(
                errors.INDEX_GAP, ("spindel", index), {"group": "spindel", "index": index, "missing": expected}
            )
            return


def _missing_members(values: _Values) -> Iterator[Contradiction]:
    for group, needed in (
        ("spindel", ["bezeichnung"]),
        ("makro_def", ["symbol", "nc_code"]),
        ("path", ["dir", "type"]),
    ):
        for index, members in _members(values, group).items():
            for name in needed:
                if not members.get(name):
                    about = {"key": name, "owner": f"{group}[{index}]"}
                    yield Contradiction(errors.KEY_MISSING, (group, index), about)


def _spindles(values: _Values) -> Iterator[Contradiction]:
    spindles = _members(values, "spindel")
    number = values.get(("spdl_anzahl",), 0)
    if number and number != len(spindles):
        yield _other(("spdl_anzahl",), number, "the number of spindles in spindel[]", len(spindles))
    value = values.get(("main_spindle_ax_nr",))
    numbers = [members.get("log_achs_nr") for members in spindles.values()]
    if value and value not in numbers:
        yield _other(("main_spindle_ax_nr",), value, "log_achs_nr of one of spindel[]",
                     ", ".join(str(number) for number in numbers if number is not None) or "not given")  # fmt: skip
    for key in ("bezeichnung", "log_achs_nr"):
        first: dict[object, int] = {}
        for index, members in sorted(spindles.items()):
            given = members.get(key)
            if given is not None and first.setdefault(given, index) != index:
                about = {"what": f"spindel[{index}].{key}", "value": given, "first": f"spindel[{first[given]}]"}
                yield Contradiction(errors.PARAMETER_NOT_UNIQUE, ("spindel", index, key), about)
    name = values.get(("main_spindle_name",))
    if name and not str(name).upper().startswith("S"):
        yield _other(("main_spindle_name",), name, "the first letter of a spindle's name", "S")


def _other(key: Key, value: object, what: str, other: object) -> Contradiction:
    return Contradiction(
        errors.PARAMETER_CONTRADICTS, key, {"key": key_text(key), "given": value, "what": what, "other": other}
    )


def _start_functions(values: _Values) -> Iterator[Contradiction]:
    for key, value in values.items():
        if key[:2] in _START_TABLES and value != -1:
            allowed = _START_TABLES[key[:2]].get(int(key[2]), ())
            if value not in allowed:
                possible = ", ".join(map(str, (-1, *allowed)))
                about = {"key": key_text(key), "given": value, "suggestion": "", "allowed": possible}
                yield Contradiction(errors.UNKNOWN_CHOICE, key, about)


def _macros(values: _Values) -> Iterator[Contradiction]:
    decoder = DecoderConfiguration.model_validate(
        {str(key[2]): value for key, value in values.items() if key[:2] == ("configuration", "decoder")}
    )
    if decoder.macro_definition_number >= decoder.macro_number:
        limit: Key = ("configuration", "decoder", "macro_definition_number")
        if limit not in values:
            limit = ("configuration", "decoder", "macro_number")
        about = {"key": "configuration.decoder.macro_definition_number", "given": decoder.macro_definition_number}
        yield Contradiction(errors.OUT_OF_RANGE, limit, {**about, "bound": "it must be less than macro_number"})
    macros = _members(values, "makro_def")
    names: dict[Value, int] = {}
    for count, (index, macro) in enumerate(sorted(macros.items()), start=1):
        if count > decoder.macro_definition_number:
            bound = f"at most {decoder.macro_definition_number} are possible (macro_definition_number)"
            about = {"key": "makro_def", "given": len(macros), "bound": bound}
            yield Contradiction(errors.WRONG_LENGTH, ("makro_def", index), about)
            break
        for member, greatest, name in (
            ("symbol", decoder.macro_symbol_len, "macro_symbol_len"),
            ("nc_code", decoder.macro_nc_code_len, "macro_nc_code_len"),
        ):
            length = len(str(macro.get(member, "")))
            if length > greatest:
                key: Key = ("makro_def", index, member)
                about = {"key": key_text(key), "given": length, "bound": f"at most {greatest} are possible ({name})"}
                yield Contradiction(errors.WRONG_LENGTH, key, about)
        symbol = macro.get("symbol", "")
        if symbol and symbol in names:
            about = {"what": f"makro_def[{index}].symbol", "value": symbol, "first": f"makro_def[{names[symbol]}]"}
            yield Contradiction(errors.PARAMETER_NOT_UNIQUE, ("makro_def", index, "symbol"), about)
        names.setdefault(symbol, index)


def _paths(values: _Values) -> Iterator[Contradiction]:
    numbers: dict[Value, int] = {}
    priorities: dict[tuple[PathKind, Value], int] = {}
    for index, path in sorted(_members(values, "path").items()):
        if number := path.get("id", 0):
            if number in numbers:
                about = {"what": f"path[{index}].id", "value": number, "first": f"path[{numbers[number]}]"}
                yield Contradiction(errors.PARAMETER_NOT_UNIQUE, ("path", index, "id"), about)
            numbers.setdefault(number, index)
        priority = path.get("priority", 0)
        for kind in PathKind:
            if PathKind(int(path.get("type", 0))) & kind:
                if (kind, priority) in priorities:
                    other = priorities[kind, priority]
                    about = {"index": index, "other": other, "priority": priority, "type": f"0x{kind.value:02X}"}
                    yield Contradiction(errors.PATH_PRIORITY_TWICE, _given(values, ("path", index), "priority"), about)
                    break
                priorities[kind, priority] = index


def _weights(values: _Values) -> Iterator[Contradiction]:
    """Rows of the weights by length and radius: complete, without gaps, with growing limits."""
    for group, limit in (("dynamic_weighting", "path_limit"), ("curve_dynamic_weighting", "radius_limit")):
        below: Value = 0
        for expected, (index, row) in enumerate(sorted(_members(values, group).items())):
            if index != expected:
                about = {"group": group, "index": index, "missing": expected}
                yield Contradiction(errors.INDEX_GAP, (group, index), about)
                return
            for name in (limit, "velocity_fact", "acceleration_fact", "ramp_time_fact"):
                if not row.get(name):
                    yield Contradiction(errors.KEY_MISSING, (group, index), {"key": name, "owner": f"{group}[{index}]"})
            reached = row.get(limit, 0)
            if reached and float(reached) <= float(below):
                about = {"key": f"{group}[{index}].{limit}", "given": reached, "bound": f"it must be more than {below}"}
                yield Contradiction(errors.OUT_OF_RANGE, (group, index, limit), about)
            below = reached or below


def _run_ahead(values: _Values) -> Iterator[Contradiction]:
    """The decoder is held back by one kind of limit only (manual line 6934)."""
    kinds = ("max_nc_blocks_ahead", "max_motion_blocks_ahead", "max_time_ahead")
    given = [name for name in kinds if values.get((name,))]
    for name in given[1:]:
        yield _other((name,), values[name,], f"the other limit that is given, {given[0]}", values[given[0],])


def _given(values: _Values, group: Key, member: str) -> Key:
    """The member if it was given, else its group."""
    return (*group, member) if (*group, member) in values else group


def _feed_unit(values: dict[Key, Value]) -> Iterator[Contradiction]:
    """0 and negative units are taken as 100; only -1 does so without a warning (P-CHAN-00108)."""
    key: Key = ("prog_start", "feedrate_factor")
    factor = values.get(key, 100.0)
    if float(factor) <= 0.0:
        values[key] = 100.0
        if factor != -1.0:
            yield Contradiction(errors.FEED_UNIT, key, {"given": f"{factor:g}"})
