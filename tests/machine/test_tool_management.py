"""A machine whose tools are those of its PLC program: the whole road from D to the answer, in virtual time."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from runtime.config.loader import DEMO_MACHINE, parse_machine
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import tools as catalogue
from runtime.hli.memory import HliMemory
from runtime.hli.tools import ManagedTool, RequestKind, ToolLife, ToolOrder, ToolStore
from runtime.scheduler.simulation import Result, Simulation
from tests.machine.scripted_plc import ScriptedPlc

Write = Callable[[str], Path]
DELAY = 0.2  # s that the management takes


class ToolPlc(ScriptedPlc):
    """Knows tools 1 and 2; answers after a while."""

    def __init__(self, memory: HliMemory) -> None:
        super().__init__(memory, {})
        self.store = ToolStore(memory.hli.channels[0])
        self.orders: list[tuple[str, int]] = []
        self.parameters: list[float] = []
        self.life: list[ToolLife] = []
        self.silent = False
        self._due: tuple[float, ToolOrder] | None = None

    def wake(self, time: float) -> None:
        super().wake(time)
        order = self.store.take()
        if order is not None:
            self.orders.append((order.kind.name, order.id.basic))
            if order.kind is RequestKind.SAVE:
                self.parameters = order.parameters[:2]
            if order.kind is RequestKind.DATA:
                self._due = (time + DELAY, order)
        if self._due is not None and time >= self._due[0] and not self.silent:
            self._answer(self._due[1])
            self._due = None
        life = self.store.take_life()
        if life is not None:
            self.life.append(life)

    def _answer(self, order: ToolOrder) -> None:
        if order.id.basic > 2:
            self.store.refuse(order, "not in the magazine")
            return
        self.store.give(order, ManagedTool(order.id, radius=5.0, length=40.0 * order.id.basic, parameters=(7.0,)))


def machine(**parameters: object) -> Machine:
    text = DEMO_MACHINE.read_text()
    given = "".join(f"      {name}: {value}\n" for name, value in {"ext_wzv_vorhanden": 1, **parameters}.items())
    return parse_machine(text.replace("    parameters:\n", "    parameters:\n" + given))


def run(program: Path, plc: list[ToolPlc], **parameters: object) -> Result:
    def partner(memory: HliMemory) -> ToolPlc:
        plc.append(ToolPlc(memory))
        return plc[0]

    return Simulation(machine(**parameters), ideal_axes=True, partner=partner).run_program(program)


@pytest.mark.spec("chan.tool.external-management", "hli.tech.t-data")
def test_the_path_stands_at_the_d_word_until_the_tool_is_there(program: Write) -> None:
    plc: list[ToolPlc] = []
    text = "%T\nT1\nG01 X10 F6000\nD1\nP1=V.G.WZ_AKT.P[0]\nV.G.WZ_AKT.P[0]=P1+1\nX20 Z10\nD2\nZ10\nD0\nM30\n"
    result = run(program(text), plc, t_info_to_wzv=1)
    assert result.good, result.problems
    assert result.parameters == {1: 7}
    assert result.positions["Z"] == pytest.approx(90)
    assert plc[0].orders == [("PREPARE", 1), ("DATA", 1), ("SAVE", 1), ("DATA", 2), ("SAVE", 2)]
    assert result.time > 2 * DELAY


@pytest.mark.spec("chan.tool.external-management")
def test_a_refusal_ends_the_program_where_it_stands(program: Write) -> None:
    plc: list[ToolPlc] = []
    result = run(program("%T\nG01 X10 F6000\nD3\nX20\nM30\n"), plc)
    assert not result.good
    assert any(f"{catalogue.MANAGEMENT_REFUSED.id}: " in text for text in result.problems)
    assert any("not in the magazine" in text for text in result.problems)
    assert result.positions["X"] == pytest.approx(10)
