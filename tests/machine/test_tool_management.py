"""A machine whose tools are those of its PLC program: the whole road from D to the answer, in virtual time."""

from __future__ import annotations

import math
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

    simulation = Simulation(machine(**parameters), ideal_axes=True, partner=partner)
    result = simulation.run_program(program)
    for _ in range(20):  # the last report finds its way
        simulation.cycle()
    return result


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


# -- tool life -----------------------------------------------------------------------------------------------------

F = 100.0  # mm/s of F6000


RESOLUTION = F * 0.001 * 1.01  # mm: of a cycle


def lives(program: Path, **parameters: object) -> list[tuple[str, float, float]]:
    """Identity, distance (mm) and time (s) of each report of tool life."""
    plc: list[ToolPlc] = []
    run(program, plc, tool_life_to_wzv=1, **parameters)
    ids = ["/".join(map(str, (life.id.basic, life.id.sister, life.id.variant))) for life in plc[0].life]
    return [(name, life.distance, life.time) for name, life in zip(ids, plc[0].life, strict=True)]


def are(told: list[tuple[str, float, float]], *expected: tuple[str, float]) -> bool:
    """The reports name these tools with these distances."""
    distances = pytest.approx([distance for _, distance in expected], abs=RESOLUTION)
    return [life[0] for life in told] == [name for name, _ in expected] and [life[1] for life in told] == distances


@pytest.mark.spec("isg.toolext.life-recording", "chan.tool.life")
def test_time_and_distance_at_feed_are_told_when_the_tool_changes(program: Write) -> None:
    text = "%T\nG01 X5 F6000\nT1\nG01 X25\nG00 X100\nG04 1\nG03 X100 I-10\nT2\nG01 X0\nT0\nX20\nT1\nX0\nM30\n"
    told = lives(program(text))
    assert are(told, ("1/0/0", 20 + 20 * math.pi), ("2/0/0", 100))
    first, second = told
    assert 1.0 <= second[2] <= 1.3  # 100 mm at 100 mm/s and the ramps; the dwell does not count
    assert first[2] == pytest.approx(first[1] / F, abs=0.4)


@pytest.mark.spec("isg.toolext.life-recording", "chan.tool.life")
def test_d_begins_the_record_where_the_channel_is_configured_so(program: Write) -> None:
    text = "%T\nD1\nG01 X10 F6000\nT2\nX30\nD2\nX60\nD0\nM30\n"
    assert are(lives(program(text), tool_life_with_d=1), ("1/0/0", 30), ("2/0/0", 30))
    assert lives(program(text)) == []  # T2 is still in the spindle


@pytest.mark.spec("chan.tool.life")
def test_rapid_traverse_and_reports_of_nothing_as_configured(program: Write) -> None:
    text = "%T\nT1\nG00 X50\nT2\nT3\nG01 X40 F6000\nT0\nM30\n"
    assert are(lives(program(text)), ("1/0/0", 0), ("2/0/0", 0), ("3/0/0", 10))
    assert are(lives(program(text), tool_life_to_wzv_suppress_zero=1), ("3/0/0", 10))
    told = lives(program(text), tool_life_capture_all_movements=1)
    assert are(told, ("1/0/0", 50), ("2/0/0", 0), ("3/0/0", 10))
    plc: list[ToolPlc] = []
    assert run(program(text), plc).good
    assert plc[0].life == []  # P-CHAN-00076 is off


@pytest.mark.spec("isg.toolext.life-weighting")
def test_factors_weight_what_is_recorded_from_their_place_on(program: Write) -> None:
    text = (
        "%T\nT1\nG01 X10 F6000\nV.TLM.DIST_FACT=0.5 V.TLM.TIME_FACT=0\nX30\nP1=V.TLM.DIST_FACT\n"
        "T2\nV.TLM.TIME_FACT=2 V.TLM.DIST_FACT=2\nX20\nT0\nM30\n"
    )
    told = lives(program(text))
    assert are(told, ("1/0/0", 20), ("2/0/0", 20))
    first, second = told
    assert first[2] < 0.25
    assert second[2] > first[2]


@pytest.mark.spec("isg.toolext.life-read-remove", "isg.toolext.life-def")
def test_the_record_can_be_read_set_back_and_preset(program: Write) -> None:
    text = (
        "%T\nT1\nG01 X10 F6000\n#TOOL LIFE READ [V.G.T_AKT]\nX30\n#TOOL LIFE READ [10,2,1]\n#TOOL LIFE REMOVE\nX40\n"
        "#TOOL LIFE READ [10]\n#TOOL LIFE DEF [DIST=1000 TIME=60]\nX45\nT0\nM30\n"
    )
    told = lives(program(text))
    assert are(told, ("1/0/0", 10), ("10/2/1", 30), ("10/0/0", 10), ("1/0/0", 1005))
    assert 60 < told[-1][2] < 60.5


@pytest.mark.spec("isg.toolext.life-recording")
def test_a_program_that_is_aborted_saves_what_was_recorded(program: Write) -> None:
    assert are(lives(program("%T\nT1\nG01 X10 F6000\nD9\nM30\n")), ("1/0/0", 10))
