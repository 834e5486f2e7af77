"""Programs of nested flow: a tree that is printed as an NC program, and run by a small interpreter.

    Program ──┬─ text() ──▶ the decoder ──▶ parameters, positions of X
              └─ outcome() ────────────▶ the same, or something is wrong

Conditions are numbers: true from |0.5| on.
$BREAK leaves the innermost loop or $SWITCH; $CONTINUE goes on with the innermost loop, in $DO and $REPEAT at the condition.
A $CASE ends with its $BREAK unless it is the last one, since the manual does not tell what happens without.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Protocol

STEPS = 4000  # statements that a program may execute
SWITCH_TOLERANCE = 0.001  # line 8531
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


class End(Enum):
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

    def run(self, machine: Machine) -> End: ...


Body = tuple[Node, ...]


def _print(body: Body) -> Iterator[str]:
    for node in body:
        yield from node.lines()


def _run(body: Body, machine: Machine) -> End:
    for node in body:
        machine.step()
        end = node.run(machine)
        if end is not End.NORMAL:
            return end
    return End.NORMAL


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

    def run(self, machine: Machine) -> End:
        value = self.number.value(machine)
        machine.parameters[self.parameter] = abs(value) % 50 * (-1 if value < 0 else 1)
        return End.NORMAL


@dataclass(frozen=True, slots=True)
class Move:
    """A block of its own kind if the place is a literal: a plain one."""

    place: Number

    def lines(self) -> Iterator[str]:
        text = self.place.text()
        yield f"X{text}" if self.place.parameter is None and self.place.other is None else f"X[{text}]"

    def run(self, machine: Machine) -> End:
        machine.positions.append(self.place.value(machine))
        return End.NORMAL


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

    def run(self, machine: Machine) -> End:
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

    def run(self, machine: Machine) -> End:
        value = self.number.value(machine)
        chosen = self.default or ()
        for number, body in self.cases:
            if abs(number.value(machine) - value) < SWITCH_TOLERANCE:
                chosen = body
                break
        end = _run(chosen, machine)
        return End.NORMAL if end is End.BREAK else end


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

    def run(self, machine: Machine) -> End:
        parameters = machine.parameters
        first, last = self.first.value(machine), self.last.value(machine)
        parameters[self.parameter] = first
        while parameters[self.parameter] <= last if self.step > 0 else parameters[self.parameter] >= last:
            machine.step()
            end = _run(self.body, machine)
            if end is End.BREAK:
                break
            if end is End.RETURN:
                return end
            parameters[self.parameter] += self.step
        return End.NORMAL


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

    def run(self, machine: Machine) -> End:
        machine.parameters[self.counter] = self.passes
        if self.kind is LoopKind.WHILE and self.passes <= 0:
            return End.NORMAL
        while True:
            machine.step()
            machine.parameters[self.counter] -= 1
            end = _run(self.body, machine)
            if end is End.RETURN:
                return end
            if end is End.BREAK or machine.parameters[self.counter] <= 0:
                return End.NORMAL


@dataclass(frozen=True, slots=True)
class Leave:
    """$BREAK, $CONTINUE, and M17 in the middle of a subprogram."""

    end: End

    def lines(self) -> Iterator[str]:
        yield {End.BREAK: "$BREAK", End.CONTINUE: "$CONTINUE", End.RETURN: "M17"}[self.end]

    def run(self, machine: Machine) -> End:
        return self.end


@dataclass(frozen=True, slots=True)
class Call:
    """LL: parameters are those of the whole program."""

    number: int

    def lines(self) -> Iterator[str]:
        yield f"LL SUB{self.number}"

    def run(self, machine: Machine) -> End:
        _run(machine.subprograms[self.number], machine)
        return End.NORMAL


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
