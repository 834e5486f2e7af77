"""The language against a second telling of it: random programs have the outcome that `oracle` computes without the product."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, assume, given, reject, settings
from hypothesis import strategies as st

from tests.cnc.decoder.programs import decode, problems
from tests.cnc.language.oracle import expressions, printing, strings
from tests.cnc.language.oracle.expressions import PARAMETERS, RANGE, Term
from tests.cnc.language.oracle.flow import Program, Statement, TooLongError
from tests.cnc.language.oracle.flow_programs import programs
from tests.cnc.language.oracle.strings import Text

_WRITTEN = " ".join(f"P{number} = {value:g}" for number, value in PARAMETERS.items())


def result(term: Term) -> float | None:
    """What the decoder makes of an expression; None: an error, with a line."""
    text = f"{_WRITTEN}\nP99 = {term.text}\nM30\n"
    if found := problems(text):
        assert [problem.place.line for problem in found] == [2]
        return None
    return decode(text).parameters[99]


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


# -- flow ----------------------------------------------------------------------------------------------------------


@pytest.mark.spec(
    "isg.flow.if",
    "isg.flow.for",
    "isg.flow.while",
    "isg.flow.switch",
    "isg.flow.do-repeat",
    "isg.flow.break",
    "isg.flow.continue",
    "isg.sub.local-call",
)
@settings(max_examples=80, suppress_health_check=[HealthCheck.too_slow])  # each is a program of many blocks
@given(programs(frozenset(Statement)), st.lists(st.integers(0, 99), max_size=20))
def test_nested_flow_runs_as_the_manual_tells(program: Program, dress: list[int]) -> None:
    try:
        parameters, positions = program.outcome()
    except TooLongError:
        reject()
    run = decode(program.text(dress))
    assert run.problem is None
    assert run.parameters == parameters
    assert [end[0] for end in run.ends] == positions


# -- strings -------------------------------------------------------------------------------------------------------


def told(question: Term) -> float:
    """The answer of the decoder to a numeric question about strings."""
    return decode(f"P99 = {question.text}\nM30\n").parameters[99]


@pytest.mark.spec("isg.lex.string-substrings", "isg.lex.string-edit", "isg.lex.string-ord", "isg.lex.string-conversion")
@settings(max_examples=200)
@given(strings.questions)
def test_string_functions(question: Term) -> None:
    assert told(question) == pytest.approx(question.value)


@settings(max_examples=100)
@given(strings.strings)
def test_string_results_character_by_character(text: Text) -> None:
    """Length and place of the whole text in itself: only the text itself has both."""
    assert told(strings.length(text)) == len(text.value)
    if text.value:
        assert told(strings.found(text, strings.literal(text.value))) == 1


@pytest.mark.spec("isg.lex.string-compare")
@settings(max_examples=100)
@given(strings.comparisons)
def test_string_comparisons(comparison: Term) -> None:
    text = f"P99 = 0\n$IF {comparison.text}\nP99 = 1\n$ENDIF\nM30\n"
    assert decode(text).parameters[99] == comparison.value


# -- blocks --------------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.lex.block-structure", "isg.g.dimension-g90-g91", "isg.g.zero-offset-g53-g59", "isg.mh.feed-f")
@settings(max_examples=100)
@given(printing.blocks())
def test_blocks_end_where_their_words_say(blocks: list[printing.Block]) -> None:
    run = decode(printing.plainly(blocks))
    assert run.problem is None
    expected = printing.moves(blocks)
    assert run.ends == [pytest.approx([value / 1000 for value in end], abs=1e-9) for end, _ in expected]
    assert [row["feed"] for row in run.rows if "feed" in row] == [feed for _, feed in expected]


@pytest.mark.spec("isg.lex.block-structure", "isg.lex.comments", "isg.lex.number-formats", "isg.flow.block-number")
@settings(max_examples=100)
@given(printing.blocks(), st.integers(0, 2**32))
def test_the_way_of_writing_does_not_matter(blocks: list[printing.Block], seed: int) -> None:
    plain, other = decode(printing.plainly(blocks)), decode(printing.somehow(blocks, seed))
    assert plain.problem is None
    assert other.problem is None
    assert other.rows == plain.rows


@settings(max_examples=100)
@given(printing.blocks())
def test_printing_and_reading_again_gives_the_same_blocks(blocks: list[printing.Block]) -> None:
    rows = decode(printing.plainly(blocks)).rows
    again = decode(printing.rewritten(rows))
    assert again.problem is None
    assert len(again.rows) == len(rows)
    for row, other in zip(rows, again.rows, strict=True):
        assert set(row) == set(other)
        for key in set(row) - {"line", "to_pcs"}:  # zero offsets are gone, so programmed coordinates are others
            expected = row[key]
            assert other[key] == (pytest.approx(expected, abs=1e-6) if isinstance(expected, float | dict) else expected)
