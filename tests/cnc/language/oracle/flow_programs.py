"""Random programs of nested flow.

Every loop counts a parameter of its own down (or is a $FOR), so all programs end, though some only after too many steps.
"""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis import strategies as st

from tests.cnc.language.oracle.flow import (
    VARIABLES,
    Assign,
    Body,
    Call,
    End,
    For,
    If,
    Leave,
    Loop,
    LoopKind,
    Move,
    Node,
    Number,
    Program,
    Statement,
    Switch,
)

LOOP_PARAMETERS = 50  # P50 … are counters of loops, nothing else writes them

_literals = st.sampled_from((0.0, 1.0, 2.0, 3.0, 0.25, 0.49, 0.5, 12.5)).map(Number)
_variables = st.sampled_from(VARIABLES).map(lambda parameter: Number(parameter=parameter))
_operands = st.one_of(_literals, _variables, _variables)
numbers = st.one_of(
    _operands,
    st.builds(
        lambda operator, first, second: Number(first.literal, first.parameter, operator, second),
        st.sampled_from(("+", "-", "*")),
        _operands,
        _operands,
    ),
)
conditions = st.one_of(
    numbers,
    st.builds(
        lambda operator, first, second: Number(first.literal, first.parameter, operator, second),
        st.sampled_from((">", "<=", "==")),
        _operands,
        _operands,
    ),
)


@dataclass(frozen=True, slots=True)
class _Place:
    """Where a statement stands: how many structures may still be nested, around it a loop, a $SWITCH, a subprogram."""

    statements: frozenset[Statement]
    depth: int
    counter: int
    callable: int
    in_loop: bool = False
    in_switch: bool = False
    in_subprogram: bool = False

    def inner(self, *, loop: bool = False, switch: bool = False) -> _Place:
        return _Place(
            self.statements,
            self.depth - 1,
            self.counter + 1,
            self.callable,
            self.in_loop or loop,
            switch or (self.in_switch and not loop),
            self.in_subprogram,
        )


@st.composite
def _bodies(draw: st.DrawFn, place: _Place, least: int = 0) -> Body:
    count = draw(st.integers(least, 3))
    return tuple(draw(_node(place)) for _ in range(count))


@st.composite
def _node(draw: st.DrawFn, place: _Place) -> Node:
    choices: list[Statement | None] = [None, None]
    if place.depth > 0:
        nested = (Statement.IF, Statement.FOR, Statement.WHILE, Statement.SWITCH, Statement.DO, Statement.REPEAT)
        choices += [statement for statement in nested if statement in place.statements]
    if place.callable and Statement.CALL in place.statements:
        choices.append(Statement.CALL)
    statement = draw(st.sampled_from(choices))
    match statement:
        case None:
            return draw(_simple(place))
        case Statement.IF:
            bodies = _bodies(place.inner())
            branches = draw(st.lists(st.tuples(conditions, bodies), min_size=1, max_size=3))
            return If(tuple(branches), draw(st.none() | _leaving(place.inner()) | bodies))
        case Statement.SWITCH:
            bodies = _bodies(place.inner(switch=True))
            values = st.one_of(_literals, _variables)
            cases = draw(st.lists(st.tuples(values, bodies), min_size=1, max_size=3))
            return Switch(draw(numbers), tuple(cases), draw(st.none() | bodies))
        case Statement.FOR:
            step = draw(st.sampled_from((1.0, 2.0, -1.0)))
            first, last = draw(_literals), draw(_operands)
            return For(LOOP_PARAMETERS + place.counter, first, last, step, draw(_bodies(place.inner(loop=True))))
        case Statement.CALL:
            return Call(draw(st.integers(0, place.callable - 1)))
    kind = LoopKind[statement.name]
    passes = draw(st.integers(0, 3))
    return Loop(kind, LOOP_PARAMETERS + place.counter, passes, draw(_bodies(place.inner(loop=True), 1)))


def _simple(place: _Place) -> st.SearchStrategy[Node]:
    return st.one_of(
        st.builds(Assign, st.sampled_from(VARIABLES), numbers),
        st.builds(Move, numbers),
        st.builds(Move, numbers),
    )


def _leaving(place: _Place) -> st.SearchStrategy[Body]:
    """A branch that ends with a jump out of what is around it, where there is something."""
    ends: list[End] = []
    if (place.in_loop or place.in_switch) and Statement.BREAK in place.statements:
        ends.append(End.BREAK)
    if place.in_loop and Statement.CONTINUE in place.statements:
        ends.append(End.CONTINUE)
    if place.in_subprogram:
        ends.append(End.RETURN)
    if not ends:
        return st.just(())
    leave = st.sampled_from(ends).map(Leave)
    return st.builds(lambda before, last: (*before, last), _bodies(place), leave)


@st.composite
def programs(draw: st.DrawFn, statements: frozenset[Statement], depth: int = 4) -> Program:
    """Programs of these statements, nested up to `depth` structures deep, with up to three subprograms."""
    subprograms: list[Body] = []
    if Statement.CALL in statements:
        for number in range(draw(st.integers(0, 3))):
            # The counters of a subprogram are its own: loops of those who call it run meanwhile.
            place = _Place(statements, 2, 10 * (number + 1), number, in_subprogram=True)
            subprograms.append(draw(_bodies(place, 1)))
    main = draw(_bodies(_Place(statements, depth, 0, len(subprograms)), 2))
    return Program(tuple(subprograms), main)
