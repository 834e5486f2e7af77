"""The register of channel parameters: complete, without contradictions, and its own defaults can be written."""

from __future__ import annotations

import pytest

from runtime.config.channel.key import key_text, parse_key
from runtime.config.channel.parameter import ChannelParameter, Use
from runtime.config.channel.parameters import ChannelParameters
from runtime.config.channel.reading import parse_parameters
from runtime.config.channel.register import GROUPS, PARAMETERS, SPELLINGS, BadIndex, Found, look_up, suggestion
from runtime.config.channel.values import value_of
from runtime.config.contradictions import ContradictionError


def written(parameter: ChannelParameter, name: str = "") -> str:
    """A name with the first index allowed everywhere."""
    text = name or parameter.name
    letters = [part.split("]")[0] for part in parameter.name.split("[")[1:]]
    for letter, (first, _) in zip(letters, parameter.index, strict=True):
        text = text.replace(f"[{letter}]", f"[{first}]")
    return text


def test_every_parameter_stands_once() -> None:
    assert len(PARAMETERS) == 497
    assert len({parameter.number for parameter in PARAMETERS}) == 497
    assert len(SPELLINGS) == sum(1 + len(parameter.aliases) for parameter in PARAMETERS)
    assert not GROUPS & set(SPELLINGS)  # a name is a parameter or a group


@pytest.mark.parametrize("parameter", PARAMETERS, ids=lambda parameter: parameter.id)
def test_a_parameter_is_found_under_all_of_its_names_and_takes_its_default(parameter: ChannelParameter) -> None:
    for name in (parameter.name, *parameter.aliases):
        key = parse_key(written(parameter, name))
        assert key is not None
        found = look_up(key)
        assert isinstance(found, Found)
        assert found.parameter is parameter
        again = look_up(found.key)  # the main name leads to itself
        assert isinstance(again, Found)
        assert again.key == found.key
    if parameter.default is not None:
        assert value_of(parameter, parameter.default) == parameter.default


def test_older_names_are_the_same_parameter() -> None:
    for older, name in (
        ("werkzeug.synch", "tool.synch"),
        ("var_memory", "configuration.decoder.var_memory"),
        ("trafo[3].param[7]", "kin_step[0].trafo[3].param[7]"),
    ):
        key = parse_key(older)
        assert key is not None
        found = look_up(key)
        assert isinstance(found, Found)
        assert key_text(found.key) == name


@pytest.mark.parametrize(
    ("name", "first", "last"),
    [("m_synch[1000]", 0, 999), ("spindel[6].s_synch", 0, 5), ("gruppe[1].achse[0].bezeichnung", 0, 0),
     ("kinematik[90].rtcp", 91, 91), ("kinematik[0].param[0]", 1, 92)],
)  # fmt: skip
def test_indices_have_limits(name: str, first: int, last: int) -> None:
    found = look_up(parse_key(name) or ())
    assert isinstance(found, BadIndex)
    assert (found.first, found.last) == (first, last)


def test_a_wrong_name_gets_the_nearest_one() -> None:
    assert "'prog_start.feedrate'" in suggestion(("prog_start", "feedrat"))
    assert "'spindel[i].m3_synch'" in suggestion(("spindel", 0, "m3_sync"))
    assert "'configuration.decoder.p_param_number'" in suggestion(("p_param_number",))
    assert suggestion(("xyzzy",)) == ""


def test_the_typed_parameters_are_those_in_use_with_the_defaults_of_the_register() -> None:
    """Whoever marks a parameter as used adds it to the types, and the other way round."""

    def leaves(model: type, beginning: str) -> dict[str, object]:
        found: dict[str, object] = {}
        for field, info in model.model_fields.items():  # type: ignore[attr-defined]
            name = info.alias or field
            annotation = info.annotation
            inner = [a for a in getattr(annotation, "__args__", ()) if hasattr(a, "model_fields")]
            if hasattr(annotation, "model_fields"):
                found |= leaves(annotation, f"{beginning}{name}.")
            elif inner:
                found |= leaves(inner[0], f"{beginning}{name}[].")
            else:
                plural = "[]" if str(annotation).startswith("dict") else ""
                found[f"{beginning}{name}{plural}"] = info.get_default(call_default_factory=True)
        return found

    typed = leaves(ChannelParameters, "")
    used = {
        pattern: spelling.parameter
        for pattern, spelling in SPELLINGS.items()
        if spelling.parameter.use is Use.USED and spelling.name == spelling.parameter.name
    }
    assert set(typed) == set(used)
    for pattern, parameter in used.items():
        if not pattern.endswith("[]") and not str(typed[pattern]).startswith("PydanticUndefined"):
            # None: left out it means something else than its default
            assert typed[pattern] in (None, parameter.default), pattern


@pytest.mark.parametrize("use", [Use.UNSUPPORTED, Use.HARMLESS])
def test_every_parameter_that_is_not_in_use_is_told_when_it_is_changed(use: Use) -> None:
    """No parameter of the manual is dropped silently."""
    for parameter in PARAMETERS:
        if parameter.use is not use:
            continue
        others: list[object] = [0.5, *range(1, 60), "a", *parameter.range.split("|")]
        if parameter.kind == "BOOLEAN":
            others = [int(not parameter.default)]
        told: set[int] = set()
        for other in others:
            try:
                warnings = parse_parameters(f"{written(parameter)} {other}").warnings
                told |= {warning.entry.id for warning in warnings}
            except ContradictionError as error:
                told |= {mistake.entry.id for mistake in error.contradictions}
        assert (302025 if use is Use.HARMLESS else 302024) in told, parameter.name
