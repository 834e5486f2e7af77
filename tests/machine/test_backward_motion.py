"""Backward and forward motion on the path, and sections that are left out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import machine as alarms
from runtime.diagnostics.events import EventKind
from runtime.hli.layout import PathWay, StopCondition
from tests.machine.driven import Driven
from tests.machine.scripted_plc import ScriptedPlc
from tests.machine.test_modes import with_channel

SPEC = "hli.ch.cu.backward-motion"
M = 1
Floats = npt.NDArray[np.float64]

# lines, an arc, a helix, polynomials at corners, short lines
TOUR = "\n".join(
    [
        "%TOUR",
        "N10 G90 G17 G01 F6000 X40",
        "N20 G03 X40 Y40 I0 J20",
        "N30 G02 X20 Y60 Z-10 I0 J20",
        "N40 #CONTOUR MODE ON [DEV, PATH_DEV 0.5]",
        "N50 G01 X50 Y60",
        "N60 X60 Y40",
        "N70 X90 Y45",
        "#CONTOUR MODE OFF",
        *[f"N{100 + i} X{90 + i * 0.5} Y{45 + (i % 3) * 0.2:.1f}" for i in range(1, 60)],
        "N200 G00 X150 Z0",
        "N210 M30",
        "",
    ]
)


def make(machine: Machine, folder: Path, storage: int = 500, **delays: float | None) -> Driven:
    channel = machine.channels[0].model_copy(update={"backward_storage": storage})
    machine = machine.model_copy(update={"channels": (channel,)})
    known = {(M, int(name[1:])): delay for name, delay in delays.items()}
    return Driven(machine, folder, ideal_axes=True, partner=lambda memory: ScriptedPlc(memory, known))


def way(driven: Driven) -> PathWay:
    return PathWay(driven.hli.channels[0].status.path_way_r)


def path_position(driven: Driven) -> float:
    return driven.channel.interpolator.path_position


def backward(driven: Driven, on: bool) -> None:
    driven.operator.backward_motion_w = on


def back_to(driven: Driven, position: float) -> None:
    backward(driven, True)
    driven.until(lambda: path_position(driven) <= position or at_begin(driven))


def at_begin(driven: Driven) -> bool:
    return bool(driven.channel.stop_condition & StopCondition.BACKWARD_END)


def place(driven: Driven) -> list[float]:
    return [float(p) for p in driven.channel.interpolator.position]


def reference_of(machine: Machine, folder: Path, text: str) -> Floats:
    """Way and place in each cycle of a run from begin to end, (cycles, 4)."""
    driven = make(machine, folder)
    driven.start(text)
    rows = []
    while driven.channel.active:
        driven.simulation.cycle()
        rows.append([path_position(driven), *place(driven)])
    assert driven.alarms == []
    return np.array(rows[:-2])


def assert_on(reference: Floats, rows: Floats) -> None:
    """Each row (way, place) lies where the reference was at this way."""
    for k in (1, 2, 3):
        expected = np.interp(rows[:, 0], reference[:, 0], reference[:, k])
        assert np.abs(rows[:, k] - expected).max() < 3e-3


def limits_kept(driven: Driven) -> None:
    """No axis changes its velocity in a cycle by more than its acceleration, and the step of a corner, allow."""
    driven.assert_no_jump()
    period = driven.simulation.period
    change = np.abs(np.diff(np.array(driven.targets), n=2, axis=0)) / period
    for k, axis in enumerate(driven.machine.axes[:3]):
        assert change[:, k].max() <= axis.acceleration * period * 1.001 + axis.velocity_step


@pytest.mark.spec(SPEC)
def test_back_and_forth_on_every_kind_of_element(demo: Machine, tmp_path: Path) -> None:
    reference = reference_of(demo, tmp_path, TOUR)
    length = float(reference[-1, 0])
    driven = make(demo, tmp_path)
    driven.start(TOUR)
    driven.forget()
    rows: list[list[float]] = []
    generator = np.random.default_rng(7)
    goals = [(0.3, 0.1), (0.5, 0.45), (0.8, 0.2), (0.85, 0.83), (0.97, 0.6)]
    for forth, back in goals:
        for goal, on in ((forth, False), (back, True)):
            backward(driven, on)
            for _ in range(20_000):
                driven.watch(1)
                rows.append([path_position(driven), *place(driven)])
                if (path_position(driven) - goal * length) * (-1 if on else 1) >= 0.0:
                    break
            if generator.random() < 0.3:  # turn again before the other way has begun
                backward(driven, not on)
                driven.watch(3)
                backward(driven, on)
    backward(driven, False)
    while driven.channel.active:
        driven.watch(1)
        rows.append([path_position(driven), *place(driven)])
    assert driven.alarms == []
    assert place(driven) == pytest.approx([150.0, float(reference[-1, 2]), 0.0])
    assert_on(reference, np.array(rows[:-2]))
    limits_kept(driven)


@pytest.mark.spec(SPEC)
def test_it_ends_where_the_storage_begins(demo: Machine, tmp_path: Path) -> None:
    driven = make(demo, tmp_path)
    driven.start(TOUR)
    driven.until(lambda: path_position(driven) > 100.0)
    back_to(driven, -1.0)
    driven.watch(50)
    assert StopCondition(driven.channel.stop_condition) == StopCondition.BACKWARD_END
    assert place(driven) == [0.0, 0.0, 0.0]
    assert way(driven) is PathWay.BACKWARD
    assert path_position(driven) == pytest.approx(0.0, abs=1e-6)
    backward(driven, False)
    driven.until(lambda: way(driven) is PathWay.REPEATING)
    driven.until(lambda: way(driven) is PathWay.ONWARD)
    driven.until_done()
    assert place(driven)[0] == 150.0
    small = make(demo, tmp_path, storage=20)
    small.start(TOUR)
    small.until(lambda: small.channel.interpolator.line > 60)
    at = path_position(small)
    back_to(small, -1.0)
    assert 0.0 < at - path_position(small) < 15.0  # some of the short lines
    assert small.channel.backward.stored <= 20
    backward(small, False)
    small.until_done()
    assert small.alarms == []
    limits_kept(small)


@pytest.mark.spec(SPEC, "isg.add.backward-storage-clear")
@pytest.mark.parametrize("block", ["#BACKWARD STORAGE CLEAR", "G74 X1"])
def test_nobody_goes_back_over_some_blocks(demo: Machine, tmp_path: Path, block: str) -> None:
    driven = make(demo, tmp_path)
    driven.start(f"%CLEAR\nN10 G90 G01 F6000 X30\n{block}\nN30 X60 Y5\nN40 M30\n")
    driven.until_x(50.0)
    back_to(driven, -1.0)
    driven.watch(5)
    assert place(driven) == pytest.approx([30.0, 0.0, 0.0])
    backward(driven, False)
    driven.until_done()
    assert place(driven) == [60.0, 5.0, 0.0]
    assert driven.alarms == []


@pytest.mark.spec(SPEC)
def test_without_a_storage_nothing_goes_back(demo: Machine, tmp_path: Path) -> None:
    for storage, off in ((0, False), (100, True)):
        driven = make(demo, tmp_path, storage=storage)
        unit = driven.hli.channels[0].control.backward_storage_off
        unit.enable_w, unit.command_w = True, off
        driven.start(TOUR)
        while path_position(driven) < 60.0:
            driven.watch(1)
        backward(driven, True)
        driven.until_done()
        assert place(driven)[0] == 150.0
        assert way(driven) is PathWay.ONWARD


@pytest.mark.spec(SPEC)
def test_feed_hold_override_single_block_and_reset(demo: Machine, tmp_path: Path) -> None:
    driven = make(demo, tmp_path)
    driven.start(TOUR)
    driven.until(lambda: path_position(driven) > 150.0)
    driven.operator.single_block_w = True
    backward(driven, True)
    stops = []
    for _ in range(3):
        driven.until(lambda: bool(driven.channel.stop_condition & StopCondition.SINGLE_BLOCK))
        stops.append([round(p, 4) for p in place(driven)])
        driven.operator.continue_motion_rw = True
        driven.watch(2)
    assert stops == [[20.0, 60.0, -10.0], [40.0, 40.0, 0.0], [40.0, 0.0, 0.0]]
    driven.operator.single_block_w = False
    driven.operator.override_w = 0
    driven.watch(500)
    held = place(driven)
    driven.watch(50)
    assert place(driven) == held
    assert way(driven) is PathWay.BACKWARD
    driven.operator.override_w = 500
    backward(driven, False)
    driven.until(lambda: way(driven) is PathWay.REPEATING)
    driven.until(lambda: place(driven)[1] > 10.0)
    driven.operator.feedhold_w = True
    driven.watch(500)
    held = place(driven)
    driven.watch(50)
    assert place(driven) == held
    driven.operator.feedhold_w = False
    driven.watch(20)
    driven.reset()
    driven.until_done()
    stood = place(driven)
    driven.watch(20)
    assert place(driven) == stood
    limits_kept(driven)
    backward(driven, False)
    driven.operator.override_w = 1000
    driven.start("%NEXT\nG90 G01 F6000 X20 Y20 Z0\nM30\n")
    driven.until_done()
    assert place(driven) == [20.0, 20.0, 0.0]
    assert driven.alarms == []


STOPS = "%STOPS\nN10 G90 G01 F6000 X20\nN20 M00\nN30 X40\nN40 M01\nN50 X60\nN60 X80\nN70 M30\n"


@pytest.mark.spec(SPEC, "chan.fwbw.m00-m01")
@pytest.mark.parametrize("name", ["", "disable_m00_backward", "disable_m01_backward", "disable_m00_2nd_forward"])
def test_programmed_stops(demo: Machine, tmp_path: Path, name: str) -> None:
    chosen = demo.channels[0].parameters.forward_backward.model_copy(update={name: True} if name else {})
    driven = make(with_channel(demo, forward_backward=chosen), tmp_path)
    driven.operator.optional_stop_w = True
    driven.start(STOPS)

    def stops() -> list[float]:
        found: list[float] = []
        for _ in range(20_000):
            driven.watch(1)
            if driven.channel.stop_condition & StopCondition.WAIT_CONTINUE:
                found.append(round(place(driven)[0], 6))
                driven.operator.continue_motion_rw = True
                driven.watch(2)
            turned = driven.channel.stop_condition & StopCondition.BACKWARD_END
            if turned or (way(driven) is not PathWay.BACKWARD and place(driven)[0] > 65.0):
                return found
        raise AssertionError("it never came to an end")

    assert stops() == [20.0, 40.0]
    backward(driven, True)
    driven.until(lambda: way(driven) is PathWay.BACKWARD)
    assert stops() == [stop for stop in (40.0, 20.0) if name != f"disable_m0{int(stop == 40.0)}_backward"]
    backward(driven, False)
    driven.until(lambda: way(driven) is PathWay.REPEATING)
    assert stops() == ([40.0] if name == "disable_m00_2nd_forward" else [20.0, 40.0])


def functions(driven: Driven) -> list[int]:
    return [event.number for event in driven.simulation.log if event.kind is EventKind.M_OUT]


@pytest.mark.spec(SPEC, "chan.mh.bwd-fwd-sync")
@pytest.mark.parametrize("late", [0.4, None])
def test_functions_backward(demo: Machine, tmp_path: Path, late: float | None) -> None:
    synch = {**demo.channels[0].parameters.m_synch, 50: "MVS_SVS|BWD_SYNCH", 51: "MVS_SVS", 52: "MVS_SNS|FWD_SYNCH"}
    driven = make(with_channel(demo, m_synch=synch), tmp_path, m50=0.0, m51=0.0)
    driven.start(
        "%F\nN10 G90 G01 F6000 X20 S500 M3\nN20 M51\nN30 X40\nN40 M50\nN50 X60 M52\nN60 M5\nN70 X80\nN80 M30\n"
    )
    driven.until_x(70.0)
    partner = driven.simulation.plc
    assert isinstance(partner, ScriptedPlc)
    partner.delays = {(M, 50): late, (M, 51): None, (M, 52): None}
    before = len(functions(driven))
    backward(driven, True)
    driven.until(lambda: len(functions(driven)) == before + 2)
    driven.watch(200)
    assert functions(driven)[before:] == [52, 50]
    assert place(driven)[0] == pytest.approx(40.0)  # waits for M50 only
    assert driven.channel.stop_condition & StopCondition.WAIT_TECHNOLOGY
    if late is None:
        backward(driven, False)  # it is still owed: the path goes on to the next place that waits, and no further
        driven.until(lambda: way(driven) is PathWay.REPEATING)
        driven.watch(300)
        assert place(driven)[0] == pytest.approx(40.0)
        assert driven.channel.stop_condition & StopCondition.WAIT_TECHNOLOGY
        driven.reset()
        driven.until_done()
        return
    driven.until(lambda: bool(driven.channel.stop_condition & StopCondition.BACKWARD_END))
    assert functions(driven)[before:] == [52, 50, 51]
    assert float(driven.image.target_velocity[3]) == 0.0  # as M5 has left it
    partner.delays = {(M, 51): None, (M, 52): late}
    backward(driven, False)
    driven.until(lambda: len(functions(driven)) == before + 6)
    assert functions(driven)[before + 3 :] == [51, 50, 52]
    driven.until_done()
    assert driven.alarms == []


# ---------------------------------------------------------------------------------------------------- sections

SECTIONS = """%SECTIONS
N10 G90 G01 F6000 X30
N20 #OPTIONAL EXECUTION ON {which}
N30 Z-5
N40 M20
N50 Y10
N60 Z0
N70 Y0
N80 #OPTIONAL EXECUTION OFF
N90 X60
N100 Y20
N110 M30
"""


def visited(driven: Driven) -> float:
    """How deep Z was since `forget`."""
    return float(np.array(driven.targets)[:, 2].min())


@pytest.mark.spec(SPEC, "isg.add.optional-execution")
def test_a_section_is_left_out_backward(demo: Machine, tmp_path: Path) -> None:
    driven = make(demo, tmp_path)
    driven.start(SECTIONS.format(which=""))
    driven.until_x(50.0)
    assert functions(driven) == [20]
    driven.forget()
    back_to(driven, -1.0)
    driven.watch(2)
    assert place(driven) == [0.0, 0.0, 0.0]
    assert visited(driven) == 0.0
    assert functions(driven) == [20]
    backward(driven, False)
    driven.until_done()
    assert visited(driven) == -5.0  # forward it is driven
    assert place(driven) == [60.0, 20.0, 0.0]
    assert driven.alarms == []
    limits_kept(driven)


@pytest.mark.spec("isg.add.optional-execution")
def test_a_section_in_which_the_path_turns_is_driven(demo: Machine, tmp_path: Path) -> None:
    driven = make(demo, tmp_path)
    driven.start(SECTIONS.format(which=""))
    driven.until(lambda: place(driven)[1] > 5.0)
    driven.forget()
    back_to(driven, 10.0)
    assert visited(driven) < -4.9
    backward(driven, False)
    driven.until_done()
    assert place(driven) == [60.0, 20.0, 0.0]
    assert driven.alarms == []


@pytest.mark.spec("isg.add.optional-execution", "hli.ch.cu.simulate-motion")
@pytest.mark.parametrize(
    ("which", "simulated", "mask", "left_out"),
    [
        ("", False, 0, False),
        ("", True, 0, True),
        ("[SIMULATE]", True, 0, True),
        ("[SIMULATE]", False, 0, False),
        ("[SIMULATE MASK='2#0110']", True, 0b0100, True),
        ("[SIMULATE MASK='2#0110']", True, 0b1001, False),
    ],
)
def test_a_section_is_left_out_in_simulated_motion(
    demo: Machine, tmp_path: Path, which: str, simulated: bool, mask: int, left_out: bool
) -> None:
    driven = make(demo, tmp_path)
    unit = driven.hli.channels[0].control.simulate_motion_mask
    unit.enable_w, unit.command_w = True, mask
    driven.operator.simulate_motion_w = simulated
    driven.start(SECTIONS.format(which=which))
    driven.until_done()
    assert place(driven) == [60.0, 20.0, 0.0]
    assert visited(driven) == (0.0 if left_out else -5.0)
    assert functions(driven) == ([] if left_out else [20])
    assert driven.alarms == []
    limits_kept(driven)


@pytest.mark.spec("hli.ch.cu.simulate-motion", "chan.mh.bwd-fwd-sync")
def test_functions_in_simulated_motion(demo: Machine, tmp_path: Path) -> None:
    """Nobody acknowledges, and the path goes on all the same, but for the function with FWD_SYNCH."""
    synch = {**demo.channels[0].parameters.m_synch, 51: "MVS_SVS", 52: "MVS_SNS|FWD_SYNCH", 53: "MNS_SNS"}
    text = "%F\nN10 G90 G01 F6000 X20\nN20 M51\nN30 X40 M53\nN40 X60 M52\nN50 X80 S500 M3\nN60 M30\n"
    driven = make(with_channel(demo, m_synch=synch), tmp_path, m51=None, m52=0.5, m53=None)
    driven.operator.simulate_motion_w = True
    driven.start(text)
    driven.until_x(59.9)
    outs = [event for event in driven.simulation.log if event.kind is EventKind.M_OUT]
    assert [(event.number, round(event.path_pos, 1)) for event in outs] == [(51, 20.0), (53, 40.0), (52, 40.0)]
    driven.until(lambda: bool(driven.channel.stop_condition & StopCondition.WAIT_TECHNOLOGY))
    assert place(driven)[0] == pytest.approx(60.0), "with FWD_SYNCH its type counts"
    driven.until_done()
    assert place(driven)[0] == 80.0
    assert driven.channel.spindles[0].set_point > 0.0, "what comes behind goes on with the spindle turning"
    assert driven.alarms == []
    limits_kept(driven)


@pytest.mark.spec("hli.ch.cu.simulate-motion")
def test_simulated_motion_is_switched_on_while_a_function_is_owed(demo: Machine, tmp_path: Path) -> None:
    """What was put out with its own type is waited for; what comes then is not."""
    driven = make(demo, tmp_path, m20=None)
    driven.start("%F\nN10 G90 G01 F6000 X20\nN20 M20\nN30 X40\nN40 M20\nN50 X60\nN60 M30\n")
    driven.until(lambda: bool(driven.channel.stop_condition & StopCondition.WAIT_TECHNOLOGY))
    driven.operator.simulate_motion_w = True
    driven.watch(200)
    assert place(driven)[0] == pytest.approx(20.0)
    assert driven.channel.stop_condition & StopCondition.WAIT_TECHNOLOGY
    driven.reset()
    driven.until_done()
    driven.start("%G\nN10 G90 G01 F6000 X20\nN20 M20\nN30 X40\nN40 M20\nN50 X60\nN60 M30\n")
    driven.until_done()
    assert place(driven)[0] == 60.0


@pytest.mark.spec("isg.add.optional-execution", "hli.ch.cu.simulate-motion")
def test_a_section_that_waits_for_the_machine_is_not_left_out(demo: Machine, tmp_path: Path) -> None:
    driven = make(demo, tmp_path)
    driven.operator.simulate_motion_w = True
    driven.start(SECTIONS.format(which="").replace("N50 Y10", "N50 #FLUSH WAIT"))
    driven.until_done()
    assert "line 6" in driven.alarm(alarms.SECTION_WAITS).text
    assert place(driven) == [30.0, 0.0, 0.0]
