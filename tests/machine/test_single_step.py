"""Single block: which blocks are steps (P-CHAN-00015); marks of #STOP REVERSIBLE."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.config.machine import Machine
from runtime.hli.layout import PathWay, StopCondition
from tests.machine.driven import Driven
from tests.machine.test_backward_motion import at_begin, backward, make, place, way
from tests.machine.test_modes import with_channel

STEPS = """%STEPS
N10 G90 G01 F6000
N20 P1 = 20 (comment)
N30 M20
(only a comment)
/N35 M21
N40 XP1 M8
$IF P1 == 20
N50 #MSG SYN ["text"]
$ENDIF
N60 G04 0.01
#SINGLE STEP [DISABLE]
N70 M21
N80 X30
#SINGLE STEP [ENABLE]
N90 X40
N100 M30
"""


def stops(driven: Driven, most: int = 40) -> list[int]:
    """Lines at whose end the path stands and waits for continue, up to the end of the program."""
    found: list[int] = []
    for _ in range(20_000):
        driven.watch(1)
        if not driven.channel.active:
            return found
        if driven.channel.stop_condition & StopCondition.SINGLE_BLOCK:
            gate = driven.channel.interpolator.gate
            found.append(int(driven.channel.queue.record(gate)["line"]))
            assert len(found) < most
            driven.operator.continue_motion_rw = True
            driven.watch(1)
    raise AssertionError(f"it never came to an end: {found}")


@pytest.mark.spec("chan.single-step", "hli.ch.cu.single-step", "isg.add.single-step")
@pytest.mark.parametrize(
    ("mode", "lines"),
    [
        (-1, [7, 16]),
        (0, [4, 7, 9, 11, 16]),
        (1, [2, 3, 4, 7, 8, 9, 10, 11, 16]),
    ],
)
def test_which_blocks_are_steps(demo: Machine, tmp_path: Path, mode: int, lines: list[int]) -> None:
    driven = make(with_channel(demo, einzelstschrittmodus=mode), tmp_path)
    driven.operator.single_block_w = True
    driven.operator.program_block_ignore_w = 1
    driven.start(STEPS)
    assert [line for line in stops(driven) if line not in (12, 15)] == lines  # the statement itself is a block, too
    assert driven.alarms == []
    assert place(driven)[0] == 40.0


@pytest.mark.parametrize("words", ["G60 G01 X10\nG01 X20\nX30", "G360\nG01 X10\nX20\nG359\nX30", "G01 X10\nX20\nX30"])
def test_an_exact_stop_at_the_end_of_a_block_is_no_way_through_it(demo: Machine, tmp_path: Path, words: str) -> None:
    driven = make(demo, tmp_path)
    driven.operator.single_block_w = True
    driven.start(f"%EXACT\nG90 F6000\n{words}\nM30\n")
    places = [
        line
        for line, block in enumerate(f"%EXACT\nG90 F6000\n{words}".splitlines(), 1)
        if "X" in block and "%" not in block
    ]
    assert stops(driven) == places
    assert driven.alarms == []


@pytest.mark.parametrize("delay", [0.0, 0.5])
def test_a_function_that_is_acknowledged_late_is_no_way_through_the_end_of_its_block(
    demo: Machine, tmp_path: Path, delay: float
) -> None:
    """M50 is MVS_SNS: the path waits for it behind the motion, and stands already where the block ends."""
    synch = {**demo.channels[0].parameters.m_synch, 50: "MVS_SNS"}
    driven = make(with_channel(demo, m_synch=synch), tmp_path, M50=delay)
    driven.operator.single_block_w = True
    driven.start("%LATE\nN10 G90 G01 F6000 X10 M50\nN20 X20\nN30 X30 M50\nN40 M30\n")
    assert stops(driven) == [2, 3, 4]
    assert driven.alarms == []


@pytest.mark.spec("chan.single-step")
def test_without_single_block_no_step_slows_the_path_down(demo: Machine, tmp_path: Path) -> None:
    def seconds(function: str) -> float:
        driven = make(demo, tmp_path)
        driven.start("%MANY\nG90 G01 F12000\n" + "".join(f"X{i * 0.5}\n{function}\n" for i in range(200)) + "M30\n")
        return driven.until(lambda: not driven.channel.active)

    assert seconds("H12") == pytest.approx(seconds(""), abs=30)


MARKS = """%MARKS
N10 G90 G01 F6000 X20
N20 #STOP REVERSIBLE
N30 X40
N40 #STOP REVERSIBLE [LEVEL=6 USR_VAL=77]
N50 X60
N60 #STOP REVERSIBLE [1ST_FORWARD=0 BACKWARD=1 2ND_FORWARD=0]
N70 X80
N80 #STOP REVERSIBLE [BACKWARD=0]
N90 X100
N100 M30
"""


@pytest.mark.spec("hli.ch.cu.stop-level", "chan.fwbw.stop-marks")
@pytest.mark.parametrize("level", [0, 2])
def test_stop_marks(demo: Machine, tmp_path: Path, level: int) -> None:
    driven = make(demo, tmp_path)
    channel = driven.hli.channels[0]
    channel.control.stop_level.enable_w, channel.control.stop_level.command_w = True, level

    def marks(until: float) -> list[tuple[float, int]]:
        found: list[tuple[float, int]] = []
        for _ in range(20_000):
            driven.watch(1)
            if driven.channel.stop_condition & StopCondition.WAIT_CONTINUE:
                driven.watch(1)
                assert channel.status.is_stopped_r
                found.append((round(place(driven)[0], 6), int(channel.status.stop_user_value_r)))
                driven.operator.continue_motion_rw = True
                driven.watch(2)
                assert not channel.status.is_stopped_r
            if at_begin(driven) or (way(driven) is not PathWay.BACKWARD and place(driven)[0] > until):
                return found
        raise AssertionError("it never came to an end")

    driven.start(MARKS)
    level_mark = [(40.0, 77)] if level else []
    assert marks(90.0) == [(20.0, 0), *level_mark, (80.0, 0)]
    backward(driven, True)
    driven.until(lambda: way(driven) is PathWay.BACKWARD)
    assert marks(0.0) == [(60.0, 0), *level_mark, (20.0, 0)]
    backward(driven, False)
    driven.until(lambda: way(driven) is PathWay.REPEATING)
    assert marks(90.0) == [(20.0, 0), *level_mark, (80.0, 0)]
    driven.until_done()
    assert driven.alarms == []


@pytest.mark.spec("chan.fwbw.stop-marks")
def test_the_channel_says_what_marks_do_that_say_nothing(demo: Machine, tmp_path: Path) -> None:
    chosen = demo.channels[0].parameters.forward_backward.model_copy(update={"disable_stop_1st_forward": True})
    driven = make(with_channel(demo, forward_backward=chosen), tmp_path)
    driven.start(MARKS.replace("[LEVEL=6 USR_VAL=77]", "[1ST_FORWARD=1]"))
    driven.until(lambda: bool(driven.channel.stop_condition & StopCondition.WAIT_CONTINUE))
    assert place(driven)[0] == 40.0
    driven.reset()
    driven.until_done()
    driven.watch(2)
    assert not driven.hli.channels[0].status.is_stopped_r
