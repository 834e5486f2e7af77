"""What a running program keeps of axes that it moves beside its path; `cnc/decoder/independent.py` says what it means."""

from __future__ import annotations

from dataclasses import dataclass, field

from runtime.cnc.blocks import IndependentMotion, Technology


@dataclass(frozen=True, slots=True)
class OwnFunction:
    """An M or H function for the interface of the axis."""

    kind: Technology
    number: int
    column: int


@dataclass(frozen=True, slots=True)
class OwnMotion:
    """What stands in one bracket: the motion, None without, and its functions. `waits`: INDP_SYN."""

    axis: int
    column: int
    motion: IndependentMotion | None
    waits: bool
    functions: tuple[OwnFunction, ...] = ()


@dataclass(slots=True)
class OwnMotions:
    """`running`: axes (channel indices) that the path has not waited for; `of_block`: the brackets of the block in work."""

    running: set[int] = field(default_factory=set)
    of_block: list[OwnMotion] = field(default_factory=list)
