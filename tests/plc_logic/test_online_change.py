"""Online change: what keeps its state, what begins anew, what is refused, and that the old program then lacks nothing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.plc_logic import PlcFailure, Program
from runtime.plc_logic.bench import Bench
from runtime.plc_logic.loader import load_program
from runtime.plc_logic.online_change import start_of, take_over
from runtime.plc_logic.retained_variables import RetainJournal

HEAD = """
from dataclasses import dataclass
from enum import Enum
from runtime.plc_logic import *
"""

FIRST = """
class Step(Enum):
    IDLE = 0
    CLAMPED = 1

@dataclass
class Station:
    name: str
    parts: int = 0

class Mill(Program):
    kept = retain(0)

    def setup(self):
        self.count = 0
        self.limit = 100
        self.late = TON(PT=0.2)
        self.timers = [TON(PT=0.1) for _ in range(3)]
        self.step = Step.IDLE
        self.stations = {"a": Station("a"), "b": Station("b")}
        self.action = self.waiting
        self.valve = self.io

    def waiting(self):
        self.action = self.working

    def working(self):
        pass

    @m_function(20)
    def clamp(self, f):
        self.io.valve = True
        return self.io.closed

    @m_function(30)
    def steps(self, f):
        yield from self.until(lambda: self.io.closed, 100.0, "waits")

    def cycle(self):
        self.count += 1
        self.kept += 1
        self.late(IN=True)
        self.timers[1](IN=True)
        self.step = Step.CLAMPED
        self.stations["a"].parts += 1
        self.stations.setdefault("new", Station("new")).parts += 1
        self.seen = True
        self.action()
"""


@pytest.fixture
def version(tmp_path: Path) -> Callable[[str], type[Program]]:
    """Write a version of the program and load it as an online change does."""

    def write(text: str) -> type[Program]:
        (tmp_path / "mill.py").write_text(HEAD + text)
        return load_program("mill.py", tmp_path, anew=True)

    return write


def running(program: type[Program]) -> Bench[Program]:
    bench: Bench[Program] = Bench(program, inputs=["closed"], outputs=["valve"])
    bench.run(0.1)
    return bench


def test_unchanged_variables_keep_their_state_and_changed_ones_begin_anew(
    version: Callable[[str], type[Program]],
) -> None:
    bench = running(version(FIRST))
    before = bench.program
    text = FIRST.replace("self.limit = 100", "self.limit = 200\n        self.added = 7").replace(
        "TON(PT=0.2)", "TON(PT=0.15)"
    )
    said = bench.replace(version(text.replace("self.count += 1", "self.count += 10")))
    now = vars(bench.program)
    platform = bench.hli.platform
    assert platform.plc_cycle_done_w == platform.plc_cycle_request_r, "its first cycle is one of the CNC's"
    assert bench.program is not before
    assert now["count"] == 25 + 10
    assert (now["limit"], now["added"]) == (200, 7)
    assert pytest.approx(0.1) == now["late"].ET, "the timer counts on, with its new time"
    bench.run(0.06)
    assert now["late"].Q
    assert "limit" in said.partition("begun anew")[2]
    assert "count" in said.partition("begun anew")[0]
    assert now["seen"], "what was made while it ran"
    assert bench.program.kept == 25 + 16  # type: ignore[attr-defined]


def test_objects_of_the_programs_own_classes_become_those_of_the_new_version(
    version: Callable[[str], type[Program]],
) -> None:
    bench = running(version(FIRST))
    text = FIRST.replace(
        "    parts: int = 0", "    parts: int = 0\n\n    def double(self):\n        return 2 * self.parts"
    )
    bench.replace(version(text))
    now = vars(bench.program)
    assert now["stations"]["a"].double() == 2 * 26
    assert now["stations"]["new"].double() == 2 * 26
    assert now["stations"]["b"].parts == 0
    assert now["step"] is type(now["step"]).CLAMPED
    assert type(now["step"]) is bench.program.setup.__func__.__globals__["Step"]  # type: ignore[attr-defined]
    assert now["action"].__self__ is bench.program
    assert now["action"].__name__ == "working"
    assert now["timers"][1].ET > 0.09
    assert now["timers"][0].ET == 0.0
    assert now["valve"] is bench.program.io


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("class Mill(Program):", "class Mill(Program:"), "304021"),
        (("class Mill(Program):", "import nothing_like_this\nclass Mill(Program):"), "304024"),
    ],
)
def test_a_version_that_cannot_be_loaded_leaves_the_modules_alone(
    version: Callable[[str], type[Program]], change: tuple[str, str], says: str
) -> None:
    version(FIRST)
    with pytest.raises(PlcFailure, match=says):
        version(FIRST.replace(*change))
    assert version(FIRST).__name__ == "Mill"


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("self.count = 0", "self.count = 1 / 0"), "ZeroDivisionError"),
        (("self.kept += 1", "self.kept += undefined"), "first cycle failed: NameError"),
        (("self.kept += 1", "self.io.nothing = 1"), "no input or output nothing"),
        (("    CLAMPED = 1", "    OTHER = 1"), "Step.CLAMPED, which is there no more"),
        (("def working(", "def other("), "Mill.working, which is there no more"),
    ],
)
def test_a_broken_version_is_refused_and_the_old_one_goes_on_with_its_state(
    version: Callable[[str], type[Program]], change: tuple[str, str], says: str
) -> None:
    bench = running(version(FIRST))
    sent = bench.m(20)
    bench.run(0.02)
    before, count = bench.program, vars(bench.program)["count"]
    with pytest.raises(PlcFailure, match=says):
        bench.replace(version(FIRST.replace(*change)))
    assert bench.program is before
    assert vars(before)["count"] == count + 1
    assert pytest.approx(0.12) == vars(before)["late"].ET
    bench.run(0.1)
    assert vars(before)["count"] == count + 26
    bench.set(closed=True)
    bench.run(0.02)
    assert sent.done, "a function under way is finished by the old program"


def test_a_function_that_only_the_refused_version_has_finished_is_not_lost(
    version: Callable[[str], type[Program]],
) -> None:
    """It came in the trial cycle, and the new handler was done with it before the cycle failed."""
    bench = running(version(FIRST))
    broken = FIRST.replace("return self.io.closed", "return True").replace("self.kept += 1", "self.kept += undefined")
    loaded = version(broken)
    sent = bench.m(20)
    with pytest.raises(PlcFailure, match="NameError"):
        bench.replace(loaded)
    bench.run(0.1)
    assert not sent.done
    bench.set(closed=True)
    bench.run(0.02)
    assert sent.done


def test_a_reset_in_the_trial_cycle_reaches_the_old_program(version: Callable[[str], type[Program]]) -> None:
    text = FIRST.replace(
        "def waiting(self)", "def on_reset(self):\n        self.was_reset = True\n\n    def waiting(self)"
    )
    bench = running(version(text))
    loaded = version(text.replace("self.kept += 1", "self.kept += undefined"))
    bench.reset()
    with pytest.raises(PlcFailure, match="NameError"):
        bench.replace(loaded)
    assert vars(bench.program)["was_reset"]


def test_a_function_under_way_is_finished_by_the_new_version(version: Callable[[str], type[Program]]) -> None:
    bench = running(version(FIRST))
    sent = bench.m(20)
    bench.run(0.02)
    bench.replace(version(FIRST.replace("return self.io.closed", "return True")))
    bench.run(0.02)
    assert sent.done
    assert bench.output("valve"), "outputs stay as they were"


def test_a_sequence_ends_in_the_version_that_has_begun_it(version: Callable[[str], type[Program]]) -> None:
    bench = running(version(FIRST))
    old = bench.program
    bench.m(30)
    bench.run(0.02)
    with pytest.raises(PlcFailure, match="304067: PLC program Mill is not replaced: M30 was being carried out"):
        bench.replace(version(FIRST))
    assert bench.program is old
    bench.hli.platform.reload_request_w += 1
    bench.run(0.1)
    assert bench.program is old
    bench.set(closed=True)
    bench.run(0.02)
    assert bench.program is not old


def test_retained_variables_go_on_in_their_journal(version: Callable[[str], type[Program]], tmp_path: Path) -> None:
    def journal() -> RetainJournal:
        return RetainJournal(tmp_path / "state")

    bench: Bench[Program] = Bench(version(FIRST), inputs=["closed"], outputs=["valve"], journal=journal)
    bench.run(0.1)
    bench.replace(version(FIRST.replace("kept = retain(0)", "kept = retain(0)\n    more = retain(5)")))
    bench.run(0.1)
    bench.host.stop()
    assert dict(journal().kept) == {"kept": 51, "more": 5}


def test_neighbours_of_the_program_are_loaded_anew(tmp_path: Path) -> None:
    (tmp_path / "neighbour_of_mill.py").write_text("STEP = 1\n")
    (tmp_path / "mill.py").write_text(
        HEAD + "import neighbour_of_mill\nclass Mill(Program):\n    step = neighbour_of_mill.STEP\n"
    )
    assert vars(load_program("mill.py", tmp_path))["step"] == 1
    (tmp_path / "neighbour_of_mill.py").write_text("STEP = 2\n")
    assert vars(load_program("mill.py", tmp_path, anew=True))["step"] == 2


# --------------------------------------------------------------------------------------------- laws

PLAIN = st.one_of(st.integers(), st.booleans(), st.text(max_size=3), st.none(), st.floats(allow_nan=False))
VALUE = st.recursive(
    PLAIN, lambda item: st.lists(item, max_size=3) | st.dictionaries(st.text(max_size=2), item, max_size=3)
)


class Anything(Program):
    def __init__(self, values: dict[str, object]) -> None:
        vars(self).update(values)


@given(st.dictionaries(st.sampled_from("abcd"), VALUE), st.dictionaries(st.sampled_from("abcd"), VALUE))
def test_the_same_text_keeps_everything_and_nothing_is_shared(start: dict[str, object], now: dict[str, object]) -> None:
    old = Anything(start)
    first = start_of(old, {})
    vars(old).clear()
    vars(old).update(now)
    new = Anything(start_of(Anything(first), {}))
    take_over(old, first, new, {})
    # lists of one length are merged element by element; what stands there is what stood there before
    assert vars(new) == now
    for name, value in vars(new).items():
        if isinstance(value, list | dict) and value:
            assert value is not now[name]


@given(st.dictionaries(st.sampled_from("abcd"), PLAIN), st.dictionaries(st.sampled_from("abcd"), PLAIN))
def test_the_state_of_the_start_gives_the_new_start(start: dict[str, object], later: dict[str, object]) -> None:
    """A program in which nothing has happened yet becomes the new one, whatever the two texts are."""
    old, new = Anything(start), Anything(later)
    take_over(old, start_of(old, {}), new, {})
    assert vars(new) == later
