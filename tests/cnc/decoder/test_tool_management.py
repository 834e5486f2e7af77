"""An external tool management as the decoder sees it: requests, answers, refusals, time-outs, what goes back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import pytest

from runtime.cnc.blocks import Block, Flush, FlushKind, Hold, Line, ToolLifeAction
from runtime.cnc.decoder import ChannelMemory
from runtime.cnc.tools.setup import ToolSetup
from runtime.diagnostics.catalogue import language as C  # noqa: N812 - a table of constants
from runtime.diagnostics.catalogue import tools as T  # noqa: N812
from runtime.hli.tools import Identity, ManagedTool, RequestKind, ToolAnswered
from tests.cnc.decoder.programs import SETUP, Run, decode, problems
from tests.cnc.decoder.scripted_outside import Machine

EXTERNAL = replace(SETUP, tools=ToolSetup(external=True, announce=True, answer_cycles=50))
TOOLS = {
    1: ManagedTool(Identity(1, 3), radius=5, length=50, parameters=(1.0, 2.0)),
    2: ManagedTool(Identity(2), radius=3, length=80, offsets=(10.0,), type=1, max_speed=8000),
    3: ManagedTool(Identity(3), valid=False),
    4: ManagedTool(Identity(5)),
    6: ManagedTool(Identity(6), radius=float("nan")),
}
Asked = tuple[RequestKind, Identity, tuple[float, ...]]


class Managed(Machine):
    """A machine with a tool management that answers when it was asked for the third time."""

    def __init__(self, tools: dict[int, ManagedTool], present: bool = True) -> None:
        super().__init__()
        self.tools, self.present = tools, present
        self.asked: list[Asked] = []
        self.patience = 2
        self._polls = 0

    def has_tool_management(self) -> bool:
        return self.present

    def ask_tool(self, kind: RequestKind, tool: Identity, parameters: Sequence[float] = ()) -> int:
        self.asked.append((kind, tool, tuple(parameters)))
        self._polls = 0
        return len(self.asked)

    def tool_answered(self, request: int) -> ToolAnswered | None:
        self._polls += 1
        kind, tool, _ = self.asked[request - 1]
        assert kind is RequestKind.DATA
        if self._polls <= self.patience:
            return None
        known = self.tools.get(tool.basic)
        return ToolAnswered(known) if known else ToolAnswered(None, "magazine is empty")

    def kinds(self) -> list[tuple[str, int]]:
        return [(kind.name, tool.basic) for kind, tool, _ in self.asked]


def run(text: str, outside: Machine | None = None, memory: ChannelMemory | None = None, **setup: object) -> Run:
    channel = replace(EXTERNAL, tools=replace(EXTERNAL.tools, **setup))  # type: ignore[arg-type]
    return decode(text, channel, outside=outside or Managed(TOOLS), memory=memory)


@pytest.mark.spec("chan.tool.external-management", "isg.mh.tool-select-t")
def test_d_asks_and_the_program_waits_for_the_answer() -> None:
    outside = Managed(TOOLS)
    made = run(
        "G00 X0\nT1\nX1\nD1 X2 Z0\nP1=V.G.WZ_AKT.R P2=V.G.WZ_AKT.P[1] P3=V.G.WZ_AKT.SISTER P4=V.G.D_AKT\nD0 Z0", outside
    )
    assert made.problem is None
    assert made.ends == [[0, 0, 0], [1, 0, 0], [2, 0, 50], [2, 0, 0]]
    assert made.parameters == {1: 5, 2: 2, 3: 3, 4: 1}
    assert outside.kinds() == [("PREPARE", 1), ("DATA", 1), ("SAVE", 1)]
    assert sum(isinstance(block, Hold) for block in made.blocks) == 2


def test_a_block_that_waits_is_executed_once() -> None:
    """Its assignments, its G functions and its T are not done again with every look for the answer."""
    outside = Managed(TOOLS)
    program = "P1=0 G00\nG92 X5\nP1=P1+1 G91 T2 D2 X10\nG91 G92 X1 D1\nG90 X0"
    made = run(program, outside)
    assert made.problem is None
    assert made.parameters == {1: 1}
    assert [end[0] for end in made.ends] == [10, 6]
    assert outside.kinds() == [("PREPARE", 2), ("DATA", 2), ("SAVE", 2), ("DATA", 1)]


@pytest.mark.spec("chan.tool.external-management")
@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("D9 X5", T.MANAGEMENT_REFUSED),
        ("D3 X5", T.TOOL_INVALID),
        ("D4 X5", T.MANAGEMENT_OTHER),
        ("D6 X5", T.VALUE_INVALID),
        ("#TOOL DATA [9]", T.MANAGEMENT_REFUSED),
    ],
)
def test_what_the_management_refuses_ends_the_program_before_its_block_moves(text: str, entry: object) -> None:
    made = run("G00 X1\n" + text)
    assert made.problem is not None
    assert made.problem.entry is entry
    assert made.problem.text
    assert [end[0] for end in made.ends] == [1]


@pytest.mark.spec("chan.tool.external-management")
def test_an_answer_that_does_not_come_and_a_management_that_is_not_there() -> None:
    late = Managed(TOOLS)
    late.patience = 10**6
    made = run("D1 X5", late)
    assert made.problem is not None
    assert made.problem.entry is T.MANAGEMENT_LATE
    assert 20 < sum(isinstance(block, Hold) for block in made.blocks) <= 60
    made = run("D1 X5", Managed(TOOLS, present=False))
    assert made.problem is not None
    assert made.problem.entry is T.MANAGEMENT_ABSENT


@pytest.mark.spec("chan.tool.external-management")
def test_free_values_go_back_when_another_tool_or_none_is_selected() -> None:
    outside = Managed(TOOLS)
    made = run("D1\nV.G.WZ_AKT.P[1] = 2.5 V.G.WZ_AKT.R = 4\nD2\nD0\nD0", outside)
    assert made.problem is None
    saved = [(tool, parameters) for kind, tool, parameters in outside.asked if kind is RequestKind.SAVE]
    assert saved == [(Identity(1, 3), (1.0, 2.5)), (Identity(2), ())]


@pytest.mark.spec("chan.tool.external-management")
@pytest.mark.parametrize("saves", [False, True])
def test_a_program_start_saves_the_tool_of_the_program_before_if_it_shall(saves: bool) -> None:
    channel = replace(EXTERNAL, tools=replace(EXTERNAL.tools, save_at_start=saves))
    memory = ChannelMemory(channel)
    assert run("D1\nV.G.WZ_AKT.P[0] = 9", memory=memory, save_at_start=saves).problem is None
    outside = Managed(TOOLS)
    made = run("G00 Z0", outside, memory, save_at_start=saves)
    assert made.ends == [[0, 0, 0]]
    assert outside.asked == ([(RequestKind.SAVE, Identity(1, 3), (9.0, 2.0))] if saves else [])
    again = Managed(TOOLS)
    run("X0", again, memory, save_at_start=saves)
    assert again.asked == []


@pytest.mark.spec("isg.toolext.tool-id", "isg.toolext.tool-data-prep")
def test_tools_are_asked_for_with_their_whole_identity() -> None:
    outside = Managed(TOOLS)
    made = run("#TOOL PREP [1,2,3]\n#TOOL DATA [1,3]\nP1=V.G.WZ_AKT.SISTER P2=V.TOOL.SISTER", outside)
    assert made.problem is None
    assert outside.asked[:2] == [(RequestKind.PREPARE, Identity(1, 2, 3), ()), (RequestKind.DATA, Identity(1, 3), ())]
    assert made.parameters == {1: 3, 2: 3}


def flushes(made: Run) -> list[tuple[FlushKind, int]]:
    return [(block.kind, block.source.line) for block in made.blocks if isinstance(block, Flush)]


@pytest.mark.spec("chan.tool.flush")
def test_t_and_d_flush_as_the_channel_is_configured() -> None:
    program = "G00 X1\nT1\nX2\nD1 X3\n#TOOL DATA [2]\nD0\nT2"
    assert flushes(run(program)) == []
    assert flushes(run(program, flush_at_t=True)) == [(FlushKind.CONTINUE, 2), (FlushKind.CONTINUE, 7)]
    waits = [(FlushKind.WAIT, line) for line in (4, 5, 6)]
    assert flushes(run(program, wait_at_d=True)) == waits
    internal = run("G00 X1\nT1 D0 X2", external=False, wait_at_d=True, implicit_d=True)
    assert flushes(internal) == [(FlushKind.WAIT, 2)]
    kinds = [type(block) for block in internal.blocks]
    motions = (Line, type(internal.blocks[0]))
    assert kinds.index(Flush) < max(i for i, kind in enumerate(kinds) if issubclass(kind, motions))
    assert flushes(run("T1", flush_at_t=True, external=False)) == []


@pytest.mark.spec("chan.tool.flush")
def test_the_flush_of_d_stands_behind_everything_before_it() -> None:
    made = run("G00 X1\nX2\nD1 X3", wait_at_d=True)

    def place(test: Callable[[Block], bool]) -> int:
        return next(i for i, block in enumerate(made.blocks) if test(block))

    flush = place(lambda block: isinstance(block, Flush))
    ends = [row["to"]["X"] for block in made.blocks[:flush] for row in Run(made.decoder, [block], None).rows]  # type: ignore[index]
    assert ends == [1, 2]


def test_data_of_any_tool_are_read_from_the_management_too() -> None:
    outside = Managed(TOOLS)
    made = run(
        "P1 = V.G.WZ[2].R\nG00 X[V.G.WZ[2].L + V.G.WZ[1].L]\n$IF V.G.WZ[1].R > 4\nX1\n$ENDIF\nT1\nP2=V.G.WZ[2].TYPE",
        outside,
    )
    assert made.problem is None, made.problem
    assert made.parameters == {1: 3, 2: 1}
    assert [end[0] for end in made.ends] == [130, 1]
    assert [request for request in outside.kinds() if request[0] == "DATA"] == [("DATA", 2), ("DATA", 1), ("DATA", 2)]


def test_data_of_a_management_are_read_only_and_read_alone() -> None:
    for text, entry in (
        ("V.G.WZ[1].R = 5", T.TABLE_FOREIGN),
        ("P1=1 P2=V.G.WZ[1].R", T.MANAGEMENT_ALONE),
        ("P1=V.G.WZ[9].R", T.MANAGEMENT_REFUSED),
    ):
        problem = run(text).problem
        assert problem is not None, text
        assert problem.entry is entry, text


def test_a_check_without_a_machine_takes_tools_without_dimensions_and_says_so() -> None:
    made = decode("T1 D1\nG00 Z0\nP1=V.G.WZ[4].R", EXTERNAL)
    assert made.problem is None
    assert made.ends == [[0, 0, 0]]
    assert [warning.entry for warning in made.decoder.warnings] == [T.MANAGEMENT_UNKNOWN]


# -- tool life -----------------------------------------------------------------------------------------------------


def life(made: Run) -> list[tuple[str, int, float, float]]:
    blocks = [block for block in made.blocks if isinstance(block, ToolLifeAction)]
    return [(block.command.value, block.basic, block.time, block.distance) for block in blocks]


@pytest.mark.spec("isg.toolext.life-weighting")
def test_factors_outlive_programs_and_are_1_at_first() -> None:
    memory = ChannelMemory(EXTERNAL)
    made = run("P1=V.TLM.TIME_FACT\nV.TLM.TIME_FACT=0.5\nV.TLM.DIST_FACT=3", memory=memory, tell_life=True)
    assert made.parameters == {1: 1}
    assert life(made) == [("V.TLM", 0, 1, 1), ("V.TLM", 0, 0.5, 1), ("V.TLM", 0, 0.5, 3)]
    made = run("P1=V.TLM.TIME_FACT P2=V.TLM.DIST_FACT", memory=memory, tell_life=True)
    assert made.parameters == {1: 0.5, 2: 3}
    assert life(made) == [("V.TLM", 0, 0.5, 3)]
    for text in ("V.TLM.TIME_FACT=-0.1", "V.TLM.DIST_FACT=-1"):
        problem = run(text, memory=memory).problem
        assert problem is not None
        assert problem.entry is T.FIELD_VALUE


def test_nobody_is_told_of_tool_life_who_does_not_want_to_know() -> None:
    program = "T1\n#TOOL LIFE READ [1]\n#TOOL LIFE REMOVE\n#TOOL LIFE DEF [DIST=1 TIME=2]\nV.TLM.TIME_FACT=2"
    assert life(run(program)) == []
    assert life(run(program, external=False, tell_life=True)) == []
    assert [row[0] for row in life(run(program, tell_life=True))] == [
        "V.TLM", "T", "#TOOL LIFE READ", "#TOOL LIFE REMOVE", "#TOOL LIFE DEF", "V.TLM"
    ]  # fmt: skip


@pytest.mark.spec("isg.toolext.life-def", "isg.toolext.life-read-remove")
def test_what_tool_life_does_not_take() -> None:
    for text, entry in (
        ("#TOOL LIFE DEF [DIST=-1 TIME=0]", T.FIELD_VALUE),
        ("#TOOL LIFE DEF [DIST=1]", C.KEY_MISSING),
        ("#TOOL LIFE READ []", T.ID_PARTS),
        ("#TOOL LIFE READ [,1]", T.ID_PARTS),
        ("#TOOL LIFE REMOVE [1]", C.STATEMENT_ARGUMENTS),
    ):
        assert [problem.entry for problem in problems(text, EXTERNAL)] == [entry], text
