"""The language against a second telling of it: random programs have the outcome that `oracle` computes without the product."""

from __future__ import annotations

import pytest
from hypothesis import assume, given, settings

from tests.cnc.decoder.programs import ProgramError, Run, decode
from tests.cnc.language.oracle import expressions
from tests.cnc.language.oracle.expressions import PARAMETERS, RANGE, Term

# What the decoder knows. As long as a part is False here, its programs must be refused before anything is executed.
STRINGS = False

_WRITTEN = " ".join(f"P{number} = {value:g}" for number, value in PARAMETERS.items())


def result(term: Term) -> float | None:
    """What the decoder makes of an expression; None: an error, with a line."""
    try:
        run = decode(f"{_WRITTEN}\nP99 = {term.text}\nM30\n")
    except ProgramError as error:
        assert error.problem.place.line == 2
        return None
    if run.problem is not None:
        assert run.problem.place.line == 2
        return None
    return run.parameters[99]


# -- expressions ---------------------------------------------------------------------------------------------------


@pytest.mark.spec(
    *("isg.lex.arithmetic-operators", "isg.lex.bit-operators", "isg.lex.logic-operators", "isg.lex.comparison-truth"),
    *("isg.lex.numeric-functions", "isg.lex.rounding-functions", "isg.lex.min-max-sign", "isg.lex.number-formats"),
)
@settings(max_examples=400)
@given(expressions.expressions)
def test_expressions_have_the_value_of_the_manual(term: Term) -> None:
    value = term.value
    if value is not None:
        assume(not RANGE < abs(value) < RANGE + 1)
        value = value if abs(value) <= RANGE else None
    assert result(term) == value


@settings(max_examples=30)
@given(expressions.with_unwritten_parameter)
def test_a_parameter_that_was_never_written_has_no_value(term: Term) -> None:
    assert result(term) is None


@pytest.mark.spec("isg.lex.trigonometry", "isg.lex.numeric-functions")
@given(expressions.smooth_expressions)
def test_functions_in_expressions(term: Term) -> None:
    assert term.value is not None
    assume(abs(term.value) <= RANGE)
    assert result(term) == pytest.approx(term.value, rel=1e-9, abs=1e-6)
