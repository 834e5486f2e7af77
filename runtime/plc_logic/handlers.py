"""Handlers of technology functions: methods of a program that say with a decorator what they carry out.

    @m_function(20)
    def close_clamp(self, f: NcFunction) -> bool:
        self.io.clamp_valve = True
        return self.io.clamp_closed

A handler is called in every PLC cycle from the moment the function has come until it returns True: then the function is
acknowledged. A sequence of steps reads better as a generator: `yield` waits for the next cycle, its end acknowledges.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeVar

from runtime.hli.technology import Function, Kind
from runtime.hli.units import LENGTH, REV_PER_MIN

F = TypeVar("F", bound=Callable[..., "bool | Iterator[None]"])
Key = tuple[Kind, int | None]  # None: every number that has no handler of its own


@dataclass(slots=True)
class NcFunction:
    """A technology function that a handler carries out."""

    kind: Kind
    number: int  # M and H: the function; T: the tool; S: 3, 4, 5, 19, or 0 for a new speed only
    value: int  # additional value of M and H (M20 = 7), else 0
    speed: float  # S: rev/min
    position: float  # S, M19: degrees
    line: int  # program line
    area: str  # name of the channel or axis that gave it out
    acknowledged: bool  # whether the path waits for it somewhere
    sister: int = 0  # T: sister and variant number of the tool, 0 none
    variant: int = 0
    elapsed: float = 0.0  # seconds since it came

    @property
    def tool(self) -> int:
        """T: the tool number."""
        return self.number

    def __str__(self) -> str:
        return f"{self.kind.name}{self.number}"


def nc_function(function: Function, area: str) -> NcFunction:
    """The interface's function in the program's units."""
    return NcFunction(
        kind=Kind(function.kind),
        number=function.number,
        value=function.value,
        speed=function.revolutions * REV_PER_MIN,
        position=function.position * LENGTH,
        line=function.line,
        area=area,
        acknowledged=function.acknowledged,
        sister=function.sister,
        variant=function.variant,
    )


def m_function(*numbers: int) -> Callable[[F], F]:
    """The method carries out these M functions; without numbers, all that have no handler of their own."""
    return _handles(Kind.M, numbers)


def h_function(*numbers: int) -> Callable[[F], F]:
    """The method carries out these H functions; without numbers, all that have no handler of their own."""
    return _handles(Kind.H, numbers)


def s_function(*numbers: int) -> Callable[[F], F]:
    """The method carries out spindle functions: 3, 4, 5, 19, or 0 for a new speed; without numbers, all others."""
    return _handles(Kind.S, numbers)


def t_function(*numbers: int) -> Callable[[F], F]:
    """The method is told which tool is selected; without numbers, every tool."""
    return _handles(Kind.T, numbers)


def _handles(kind: Kind, numbers: tuple[int, ...]) -> Callable[[F], F]:
    def mark(method: F) -> F:
        keys: list[Key] = getattr(method, "handles", [])
        method.handles = keys + [(kind, number) for number in numbers or (None,)]  # type: ignore[attr-defined]
        return method

    return mark
