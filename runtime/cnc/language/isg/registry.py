"""The table of G functions: parser, checker and decoder read what is registered here, and nothing else.

To add a modal function, write a handler that changes the modal state and register it; a function with arguments of
its own also needs its words in `block.lark`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from runtime.cnc.language.isg.modal import ModalState, Motion, Plane


class Group(Enum):
    """Groups of functions that exclude each other, with the group numbers of P-CHAN-00063 (channel parameters line
    5130)."""

    PATH_CONDITION = "path condition"  # 0
    PLANE = "plane"  # 4
    UNIT = "unit"  # 12
    DIMENSION = "absolute or incremental dimension"  # 14
    CIRCLE_CENTRE = "circle centre"  # 23
    ZERO_OFFSET = "zero offset"
    FEED_MODE = "meaning of F"
    CIRCLE_RADIUS = "circle radius"


@dataclass(frozen=True, slots=True)
class GFunction:
    """One G function. `apply` changes the modal state when a block with it is executed, before its words count."""

    number: int
    group: Group
    modal: bool
    syntax: str
    spec: str
    apply: Callable[[ModalState], None]
    value: bool = False  # G<number>=<expression>


G_FUNCTIONS: dict[int, GFunction] = {}

# Numbers that the dialect knows, as ranges from–to; those not registered are refused as "not supported yet"
# instead of "unknown".
# fmt: off
_KNOWN_RANGES = (
    (0, 5), (8, 13), (17, 23), (25, 26), (33, 33), (40, 42), (51, 61), (63, 63), (66, 66), (68, 71), (74, 74),
    (80, 102), (106, 108), (112, 112), (115, 117), (127, 141), (150, 151), (159, 167), (193, 194), (196, 196),
    (200, 202), (230, 231), (233, 233), (236, 239), (260, 261), (293, 293), (301, 303), (310, 310), (331, 334),
    (338, 339), (351, 351), (359, 360), (800, 839), (900, 901),
)
# fmt: on
G_NUMBERS = frozenset(number for first, last in _KNOWN_RANGES for number in range(first, last + 1))


def _register(
    number: int, group: Group, spec: str, *, modal: bool = True, syntax: str = "", value: bool = False
) -> Callable[[Callable[[ModalState], None]], Callable[[ModalState], None]]:
    def register(apply: Callable[[ModalState], None]) -> Callable[[ModalState], None]:
        if number in G_FUNCTIONS:
            raise ValueError(f"G{number} is registered twice")
        G_FUNCTIONS[number] = GFunction(number, group, modal, syntax or f"G{number:02d}", spec, apply, value)
        return apply

    return register


@_register(0, Group.PATH_CONDITION, "isg.g.rapid-g00", syntax="G00 <axis>.. {<axis>..}")
def rapid(modal: ModalState) -> None:
    modal.motion = Motion.RAPID


@_register(1, Group.PATH_CONDITION, "isg.g.linear-g01", syntax="G01 <axis>.. {<axis>..} [F..]")
def linear(modal: ModalState) -> None:
    modal.motion = Motion.LINEAR


@_register(2, Group.PATH_CONDITION, "isg.g.circular-centre-g02-g03", syntax="G02 X.. Y.. I.. J.. | R..")
def circle_clockwise(modal: ModalState) -> None:
    modal.motion = Motion.CIRCLE_CW


@_register(3, Group.PATH_CONDITION, "isg.g.circular-centre-g02-g03", syntax="G03 X.. Y.. I.. J.. | R..")
def circle_counter_clockwise(modal: ModalState) -> None:
    modal.motion = Motion.CIRCLE_CCW


@_register(4, Group.PATH_CONDITION, "isg.g.dwell-g04-time", modal=False, syntax="G04 X.. | G04 <expr> | G04 S..")
def dwell(modal: ModalState) -> None:
    """Changes no modal state: the time is an argument, see the decoder."""


@_register(17, Group.PLANE, "isg.g.plane-g17-g18-g19")
def plane_xy(modal: ModalState) -> None:
    modal.plane = Plane.XY


@_register(18, Group.PLANE, "isg.g.plane-g17-g18-g19")
def plane_zx(modal: ModalState) -> None:
    modal.plane = Plane.ZX


@_register(19, Group.PLANE, "isg.g.plane-g17-g18-g19")
def plane_yz(modal: ModalState) -> None:
    modal.plane = Plane.YZ


def _zero_offset(number: int) -> None:
    @_register(number, Group.ZERO_OFFSET, "isg.g.zero-offset-g53-g59")
    def select(modal: ModalState) -> None:
        modal.zero_offset = number


for _number in range(53, 60):
    _zero_offset(_number)


@_register(70, Group.UNIT, "isg.g.units-g70-g71")
def inch(modal: ModalState) -> None:
    modal.inch = True


@_register(71, Group.UNIT, "isg.g.units-g70-g71")
def metric(modal: ModalState) -> None:
    modal.inch = False


@_register(90, Group.DIMENSION, "isg.g.dimension-g90-g91")
def absolute(modal: ModalState) -> None:
    modal.incremental = False


@_register(91, Group.DIMENSION, "isg.g.dimension-g90-g91")
def incremental(modal: ModalState) -> None:
    modal.incremental = True


@_register(94, Group.FEED_MODE, "isg.g.feed-mode-g93-g94-g95-g194")
def feed_per_minute(modal: ModalState) -> None:
    """The only meaning of F so far."""


@_register(161, Group.CIRCLE_CENTRE, "isg.g.circle-centre-mode-g161-g162")
def centre_absolute(modal: ModalState) -> None:
    modal.centre_absolute = True


@_register(162, Group.CIRCLE_CENTRE, "isg.g.circle-centre-mode-g161-g162")
def centre_relative(modal: ModalState) -> None:
    modal.centre_absolute = False


@_register(163, Group.CIRCLE_RADIUS, "isg.g.circular-radius", syntax="G163=..", value=True)
def circle_radius(modal: ModalState) -> None:
    """The same as R: its value is entered by the decoder like that of R."""
