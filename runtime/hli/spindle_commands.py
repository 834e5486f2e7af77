"""The slot for orders of the PLC to a spindle (hli.sp.cu.external-command), from both sides."""

from __future__ import annotations

from dataclasses import dataclass

from runtime.hli.layout import Axis, SpindleCommandKind, SpindleWay
from runtime.hli.units import LENGTH, SPEED


@dataclass(frozen=True, slots=True)
class SpindleCall:
    """An order in degrees and seconds; `kind` as it stands in the slot, which may be no number of the interface."""

    kind: int
    speed: float = 0.0  # degrees/s; 0: the one that is programmed
    angle: float = 0.0  # degrees: an angle, or the way to it
    way: SpindleWay = SpindleWay.ABSOLUTE
    value: float = 0.0


class SpindleCaller:
    """The PLC's side, of one spindle."""

    def __init__(self, axis: Axis) -> None:
        self._unit = axis.ext_to_ipo

    @property
    def error(self) -> int:
        """Why the last order was refused, 0 it was not."""
        value: int = self._unit.error_r
        return value

    @property
    def taken(self) -> bool:
        """The CNC has taken what was given."""
        return not self._unit.command_semaphor_rw

    def give(self, call: SpindleCall) -> bool:
        """Put an order into the slot; FALSE if the one before was not taken yet (then try again in the next cycle)."""
        unit = self._unit
        if unit.command_semaphor_rw:
            return False
        command = unit.command_w
        command.satz_typ = call.kind
        command.vb_prog = round(call.speed / SPEED)
        command.geo_gm_fkt = call.way
        command.fahrweg = round(call.angle / LENGTH)
        command.value = call.value
        unit.command_semaphor_rw = True
        return True


class SpindleSlot:
    """The CNC's side, of one spindle."""

    def __init__(self, axis: Axis) -> None:
        self._unit = axis.ext_to_ipo

    def take(self) -> SpindleCall | None:
        """The order that waits."""
        unit = self._unit
        if not unit.command_semaphor_rw:
            return None
        command = unit.command_w
        call = SpindleCall(
            int(command.satz_typ),
            command.vb_prog * SPEED,
            command.fahrweg * LENGTH,
            SpindleWay(command.geo_gm_fkt & (SpindleWay.SHORTEST | SpindleWay.ABSOLUTE)),
            float(command.value),
        )
        unit.command_semaphor_rw = False
        unit.commands_taken_r += 1
        return call

    def answer(self, error: int) -> None:
        """Why the order was refused, 0 it was not."""
        self._unit.error_r = error


KINDS = frozenset(int(kind) for kind in SpindleCommandKind)


def shown(kind: int) -> str:
    """M3, HOMING, or the number that is none of the interface."""
    return SpindleCommandKind(kind).name if kind in KINDS else str(kind)
