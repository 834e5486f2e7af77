"""Random programs of nested flow: a tree that is printed as an NC program, and run by a small interpreter.

    programs(…) ──▶ Program ──┬─ lines() ──▶ the decoder ──▶ parameters, positions of X
                              └─ outcome() ──────────────▶ the same, or something is wrong

Every loop counts a parameter of its own down (or is a $FOR), so all programs end. Conditions are numbers: true from |0.5| on.
$BREAK leaves the innermost loop or $SWITCH; $CONTINUE goes on with the innermost loop, in $DO and $REPEAT at the condition.
A $CASE ends with its $BREAK unless it is the last one, since the manual does not tell what happens without.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Protocol

from hypothesis import strategies as st

STEPS = 4000  # statements that a program may execute
SWITCH_TOLERANCE = 0.001  # line 8531
LOOP_PARAMETERS = 50  # P50 … are counters of loops, nothing else writes them
VARIABLES = (1, 2, 3, 4, 5)


class Statement(Enum):
    """What a program may be made of besides assignments and moves; how it begins in the text."""

    IF = "$IF"
    FOR = "$FOR"
    WHILE = "$WHILE"
    CALL = "LL"
    SWITCH = "$SWITCH"
    DO = "$DO"
    REPEAT = "$REPEAT"
    BREAK = "$BREAK"
    CONTINUE = "$CONTINUE"


class TooLongError(Exception):
    """The program executes more than STEPS statements."""


class _End(Enum):
    """How a body ended."""

    NORMAL = auto()
    BREAK = auto()
    CONTINUE = auto()
    RETURN = auto()


@dataclass(slots=True)
class Machine:
    """What the interpreter changes."""

    parameters: dict[int, float] = field(default_factory=dict)
    positions: list[float] = field(default_factory=list)
    subprograms: Sequence[Body] = ()
    steps: int = 0

    def step(self) -> None:
        self.steps += 1
        if self.steps > STEPS:
            raise TooLongError


class Node(Protocol):
    """A statement: its lines, and what it does."""

    def lines(self) -> Iterator[str]: ...

    def run(self, machine: Machine) -> _End: ...


Body = tuple[Node, ...]


def _print(body: Body) -> Iterator[str]:
    for node in body:
        yield from node.lines()


def _run(body: Body, machine: Machine) -> _End:
    for node in body:
        machine.step()
        end = node.run(machine)
        if end is not _End.NORMAL:
            return end
    return _End.NORMAL


# -- numbers -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Number:
    """A literal, or a parameter if `parameter` is given, with what is done to it: `P1 + 2`, `P1 - P2`, `P1 > 2`."""

    literal: float = 0.0
    parameter: int | None = None
    operator: str = ""
    other: Number | None = None

    def text(self) -> str:
        first = f"{self.literal:g}" if self.parameter is None else f"P{self.parameter}"
        if self.other is None:
            return first
        return f"{first} {self.operator} {self.other.text()}"

    def value(self, machine: Machine) -> float:
        first = self.literal if self.parameter is None else machine.parameters[self.parameter]
        if self.other is None:
            return first
        second = self.other.value(machine)
        match self.operator:
            case "+":
                return first + second
            case "-":
                return first - second
            case "*":
                return first * second
            case ">":
                return float(first > second)
            case "<=":
                return float(first <= second)
            case "==":
                return float(first == second)
        raise AssertionError(self.operator)


def _true(value: float) -> bool:
    return abs(value) >= 0.5


# -- statements ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Assign:
    """The remainder keeps the numbers small; it has the sign of the dividend."""

    parameter: int
    number: Number

    def lines(self) -> Iterator[str]:
        yield f"P{self.parameter} = [{self.number.text()}] MOD 50"

    def run(self, machine: Machine) -> _End:
        value = self.number.value(machine)
        machine.parameters[self.parameter] = abs(value) % 50 * (-1 if value < 0 else 1)
        return _End.NORMAL


@dataclass(frozen=True, slots=True)
class Move:
    """A block of its own kind if the place is a literal: a plain one."""

    place: Number

    def lines(self) -> Iterator[str]:
        text = self.place.text()
        yield f"X{text}" if self.place.parameter is None and self.place.other is None else f"X[{text}]"

    def run(self, machine: Machine) -> _End:
        machine.positions.append(self.place.value(machine))
        return _End.NORMAL


@dataclass(frozen=True, slots=True)
class If:
    branches: tuple[tuple[Number, Body], ...]
    otherwise: Body | None

    def lines(self) -> Iterator[str]:
        for number, (condition, body) in enumerate(self.branches):
            yield f"{'$ELSEIF' if number else '$IF'} {condition.text()}"
            yield from _print(body)
        if self.otherwise is not None:
            yield "$ELSE"
            yield from _print(self.otherwise)
        yield "$ENDIF"

    def run(self, machine: Machine) -> _End:
        for condition, body in self.branches:
            if _true(condition.value(machine)):
                return _run(body, machine)
        return _run(self.otherwise or (), machine)


@dataclass(frozen=True, slots=True)
class Switch:
    number: Number
    cases: tuple[tuple[Number, Body], ...]
    default: Body | None

    def lines(self) -> Iterator[str]:
        yield f"$SWITCH {self.number.text()}"
        for place, (number, body) in enumerate(self.cases, 1):
            yield f"$CASE {number.text()}"
            yield from _print(body)
            if place < len(self.cases) or self.default is not None:
                yield "$BREAK"
        if self.default is not None:
            yield "$DEFAULT"
            yield from _print(self.default)
        yield "$ENDSWITCH"

    def run(self, machine: Machine) -> _End:
        value = self.number.value(machine)
        chosen = self.default or ()
        for number, body in self.cases:
            if abs(number.value(machine) - value) < SWITCH_TOLERANCE:
                chosen = body
                break
        end = _run(chosen, machine)
        return _End.NORMAL if end is _End.BREAK else end


@dataclass(frozen=True, slots=True)
class For:
    parameter: int
    first: Number
    last: Number
    step: float
    body: Body

    def lines(self) -> Iterator[str]:
        yield f"$FOR P{self.parameter} = {self.first.text()}, {self.last.text()}, {self.step:g}"
        yield from _print(self.body)
        yield "$ENDFOR"

    def run(self, machine: Machine) -> _End:
        parameters = machine.parameters
        first, last = self.first.value(machine), self.last.value(machine)
        parameters[self.parameter] = first
        while parameters[self.parameter] <= last if self.step > 0 else parameters[self.parameter] >= last:
            machine.step()
            end = _run(self.body, machine)
            if end is _End.BREAK:
                break
            if end is _End.RETURN:
                return end
            parameters[self.parameter] += self.step
        return _End.NORMAL


class LoopKind(Enum):
    """Head and end of a loop with a condition."""

    WHILE = ("$WHILE {0}", "$ENDWHILE")
    DO = ("$DO", "$ENDDO {0}")
    REPEAT = ("$REPEAT", "$UNTIL {0}")


@dataclass(frozen=True, slots=True)
class Loop:
    """Goes on while `counter`, counted down at the start of each pass from `passes`, is above 0 (and ends with $REPEAT when it
    is not any more)."""

    kind: LoopKind
    counter: int
    passes: int
    body: Body

    def lines(self) -> Iterator[str]:
        condition = f"P{self.counter} {'<=' if self.kind is LoopKind.REPEAT else '>'} 0"
        head, end = (text.format(condition) for text in self.kind.value)
        yield f"P{self.counter} = {self.passes}"
        yield head
        yield f"P{self.counter} = P{self.counter} - 1"
        yield from _print(self.body)
        yield end

    def run(self, machine: Machine) -> _End:
        machine.parameters[self.counter] = self.passes
        if self.kind is LoopKind.WHILE and self.passes <= 0:
            return _End.NORMAL
        while True:
            machine.step()
            machine.parameters[self.counter] -= 1
            end = _run(self.body, machine)
            if end is _End.RETURN:
                return end
            if end is _End.BREAK or machine.parameters[self.counter] <= 0:
                return _End.NORMAL


@dataclass(frozen=True, slots=True)
class Leave:
    """$BREAK, $CONTINUE, and M17 in the middle of a subprogram."""

    end: _End

    def lines(self) -> Iterator[str]:
        yield {_End.BREAK: "$BREAK", _End.CONTINUE: "$CONTINUE", _End.RETURN: "M17"}[self.end]

    def run(self, machine: Machine) -> _End:
        return self.end


@dataclass(frozen=True, slots=True)
class Call:
    """LL: parameters are those of the whole program."""

    number: int

    def lines(self) -> Iterator[str]:
        yield f"LL SUB{self.number}"

    def run(self, machine: Machine) -> _End:
        _run(machine.subprograms[self.number], machine)
        return _End.NORMAL


@dataclass(frozen=True, slots=True)
class Program:
    """Subprograms call only those with a smaller number."""

    subprograms: tuple[Body, ...]
    main: Body

    def text(self, dress: Sequence[int] = ()) -> str:
        """The NC program; `dress` (any numbers) chooses block numbers, comments, cases of keywords and empty lines."""
        lines: list[str] = []
        for number, body in enumerate(self.subprograms):
            lines += [f"%L SUB{number}", *_print(body), "M17"]
        start = [f"P{number} = {number}" for number in VARIABLES]
        lines += ["%MAIN", "G01 F1000", *start, *_print(self.main), "M30"]
        return "\n".join(_dressed(line, dress[at % len(dress)] if dress else 0) for at, line in enumerate(lines)) + "\n"

    @property
    def statements(self) -> frozenset[Statement]:
        """Which of them it holds."""
        words = {line.split()[0] for body in (*self.subprograms, self.main) for line in _print(body)}
        return frozenset(statement for statement in Statement if statement.value in words)

    def outcome(self) -> tuple[Mapping[int, float], Sequence[float]]:
        """Final parameters, and the positions of X in order. Raises TooLongError."""
        machine = Machine({number: float(number) for number in VARIABLES}, subprograms=self.subprograms)
        _run(self.main, machine)
        return machine.parameters, machine.positions


def _dressed(line: str, dress: int) -> str:
    if line.startswith("%"):
        return line
    match dress % 8:
        case 1:
            return f"N{dress} {line}"
        case 2:
            return f"{line} (comment $ENDIF)"
        case 3:
            return f"{line} ; $ELSE"
        case 4:
            return f"\n(nothing)\n  {line}"
        case 5 if "$" in line:
            return line.lower().replace("p", "P")
        case 6:
            return f"N{dress}\t{line}  "
    return line


# -- random ones ---------------------------------------------------------------------------------------------------

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
    ends: list[_End] = []
    if (place.in_loop or place.in_switch) and Statement.BREAK in place.statements:
        ends.append(_End.BREAK)
    if place.in_loop and Statement.CONTINUE in place.statements:
        ends.append(_End.CONTINUE)
    if place.in_subprogram:
        ends.append(_End.RETURN)
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
