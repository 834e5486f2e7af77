"""Axis couplings of a channel: slaves that do what their masters do (programming manual 12926–13301).

    defined (kept from program to program) ─ AX LINK ON ─▶ active ─ AX LINK OFF, end of the program ─▶ defined

While a group is active the decoder leaves its slaves where they were; the cycle adds the way of the master. Behind it the decoder
adds the same way. Every slave has one master, no slave is a master, in whatever groups they are.
"""

from __future__ import annotations

from collections.abc import Iterable

from runtime.cnc.blocks import CoupledAxis, CouplingChange
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.language.isg.comments import LineError
from runtime.diagnostics.catalogue import axes as errors

MAIN_AXES = 3
GROUPS = 5  # 0…4


def expect_uncoupled(x: Execution, what: str, column: int) -> None:
    """LineError while a coupling is active."""
    if x.coupling.active:
        raise LineError(errors.COUPLING_ACTIVE, column, what=what, group=next(reversed(x.coupling.active)))


def expect_no_slave(x: Execution, axes: Iterable[int], column: int) -> None:
    """LineError for an axis that follows another one."""
    for axis in axes:
        if axis in x.coupling.slaves:
            master = x.setup.axes[x.coupling.slaves[axis].master]
            raise LineError(errors.COUPLED_SLAVE, column, axis=x.setup.axes[axis], master=master)


def define(x: Execution, group: int, pairs: list[tuple[int, int]], column: int) -> None:
    """A group of pairs (logical axis numbers of slave and master) instead of what it was. Raises LineError."""

    def wrong(what: str) -> LineError:
        return LineError(errors.COUPLING_PAIRS, column, group=group, what=what)

    if not 1 <= group < GROUPS:
        raise LineError(errors.COUPLING_GROUP, column, value=group, last=GROUPS - 1)
    if group in x.coupling.active:
        raise LineError(errors.COUPLING_CHANGED, column, group=group)
    known = {number: held for number, held in x.memory.couplings.items() if number != group}
    others = [pair for held in known.values() for pair in held]
    masters_of = dict(others)
    for slave, master in pairs:
        if slave == master:
            raise wrong(f"axis {slave} is its own master")
        if masters_of.setdefault(slave, master) != master:
            raise wrong(f"axis {slave} has another master, {masters_of[slave]}")
    for slave in masters_of:
        if slave in masters_of.values():
            raise wrong(f"axis {slave} is slave and master")
    x.memory.couplings[group] = tuple(pairs)


def enable(x: Execution, group: int, column: int) -> None:
    """The slaves of a group follow from here on. Raises LineError."""
    pairs = x.memory.couplings.get(group)
    if not pairs:
        raise LineError(errors.COUPLING_UNDEFINED, column, group=group)
    if group in x.coupling.active:
        return
    coupled = [_coupled(x, group, slave, master, column) for slave, master in pairs]
    x.coupling.active[group] = tuple(coupled)
    x.coupling.slaves |= {one.slave: one for one in coupled}
    x.coupling.last = group
    x.emit(CouplingChange(x.source, tuple(x.coupling.slaves.values())))
    _changed(x)


def _coupled(x: Execution, group: int, slave: int, master: int, column: int) -> CoupledAxis:
    numbers = x.setup.log_axes

    def wrong(what: str) -> LineError:
        return LineError(errors.COUPLING_PAIRS, column, group=group, what=what)

    for number in (slave, master):
        if number not in numbers:
            known = ", ".join(f"{name} {n}" for name, n in zip(x.setup.axes, numbers, strict=False))
            raise wrong(f"axis {number} is not in the channel ({known or 'none has a number'})")
    one, other = numbers.index(slave), numbers.index(master)
    names = x.setup.axes
    if one < MAIN_AXES:
        raise wrong(f"{names[one]} is a main axis, which can be no slave")
    if x.setup.linear[one] != x.setup.linear[other] or (one in x.modulo.ranges) != (other in x.modulo.ranges):
        raise wrong(f"{names[one]} and {names[other]} are not of the same type")
    if one in x.manual_axes or other in x.manual_axes:
        raise wrong(f"{names[one]} or {names[other]} is moved by hand (G201)")
    if other < MAIN_AXES and x.coordinates.frame is not None:
        raise wrong(f"{names[other]} is turned by a coordinate system")
    if one in x.coupling.slaves:
        raise wrong(f"{names[one]} follows another axis already")
    position = x.coordinates.position
    return CoupledAxis(one, other, position[one] - position[other])


def disable(x: Execution, groups: Iterable[int]) -> None:
    """The slaves of these groups stay where they are from here on."""
    ended = [one for group in tuple(groups) for one in x.coupling.active.pop(group, ())]
    if not ended:
        return
    position = x.coordinates.position.copy()
    for one in ended:
        position[one.slave] = position[one.master] + one.offset
        del x.coupling.slaves[one.slave]
    x.coordinates.position = position
    ends = tuple((one.slave, position[one.slave]) for one in ended)
    x.emit(CouplingChange(x.source, tuple(x.coupling.slaves.values()), ends))
    _changed(x)


def _changed(x: Execution) -> None:
    x.memory.coupled = tuple(x.coupling.active)
    x.modal_changed()


def restore(x: Execution) -> None:
    """At program start: groups that the end of the program before, or a reset, has ended (P-CHAN-00105, P-CHAN-00104)."""
    groups, ended = x.memory.coupled, x.memory.came_to_end
    x.memory.coupled, x.memory.came_to_end = (), False
    if x.setup.couplings_after_end if ended else x.setup.couplings_after_reset:
        for group in groups:
            enable(x, group, 1)
