"""#FILTER: FIR filters behind the interpolator. What the drives are told, when functions come, and where the path stands."""

from __future__ import annotations

import random
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from runtime.config.fir_filter import FilterType, FirFilter
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import smoothing as catalogue
from runtime.diagnostics.events import EventKind
from runtime.hli.layout import ManualMode, StopCondition
from tests.cnc.decoder.programs import SETUP, decode
from tests.machine.driven import Driven
from tests.machine.scripted_plc import ScriptedPlc
from tests.machine.test_backward_motion import at_begin, backward
from tests.machine.test_modes import Hand, place
from tests.recorder.test_keyframes import assert_same_from_each, with_keyframes
from tests.recorder.test_replay import Recorded

Floats = npt.NDArray[np.float64]
SPEC = pytest.mark.spec("isg.smooth.fir-filter")
GAUSSIAN = FirFilter(type=FilterType.GAUSSIAN)
CORNERS = "N20 G01 F6000 X40\nN30 Y20\nN40 X60 Y50\nN50 G02 X90 Y50 I15 J0\nN60 G01 X120 Z-5\nN70 X100 Y0\n"


def filtered(demo: Machine, *filters: FirFilter | None, step: float = 5.0, **channel: object) -> Machine:
    """The demo machine with these filters of X, Y, Z, and with this jump of velocity at corners."""
    axes = tuple(
        axis.model_copy(update={"fir_filter": given, "velocity_step": step})
        for axis, given in zip(demo.axes, (*filters, *[None] * 4)[:4], strict=True)
    )
    changed = demo.channels[0].model_copy(update=channel)
    return demo.model_copy(update={"axes": axes, "channels": (changed,)})


class Watched(Driven):
    """What the path is at, and what the axes are told, in every cycle."""

    def __init__(self, machine: Machine, folder: Path, **delays: float | None) -> None:
        self.path: list[Floats] = []
        known = {(1, int(name[1:])): delay for name, delay in delays.items()}
        super().__init__(machine, folder, ideal_axes=True, partner=lambda memory: ScriptedPlc(memory, known))

    def watch(self, cycles: int) -> None:
        for _ in range(cycles):
            super().watch(1)
            self.path.append(self.channel.interpolator.position.copy())

    def forget(self) -> None:
        super().forget()
        self.path = [self.channel.interpolator.position.copy()]

    @property
    def places(self) -> Floats:
        return np.array(self.targets)[:, :3]

    def delay(self) -> int:
        return self.channel.interpolator._filter.delay

    def assert_axes_keep(self, most_jump: float = 0.0) -> None:
        """Velocity and acceleration of what the axes were told; `most_jump` of velocity within a cycle beside that."""
        velocity = np.diff(self.places, axis=0) / self.simulation.period
        change = np.abs(np.diff(velocity, axis=0))
        for i in range(3):
            axis = self.machine.axes[i]
            assert np.abs(velocity[:, i]).max() <= axis.velocity * 1.0001
            assert change[:, i].max() <= axis.acceleration * self.simulation.period * 1.005 + most_jump


def jerk_of(places: Floats, period: float = 0.001) -> Floats:
    made: Floats = np.abs(np.diff(places, n=3, axis=0)).max(axis=0) / period**3
    return made


@SPEC
@pytest.mark.parametrize("kind", list(FilterType))
def test_the_axes_come_to_the_exact_place_and_are_smoother(demo: Machine, tmp_path: Path, kind: FilterType) -> None:
    plain = Watched(filtered(demo), tmp_path)
    plain.start(f"%PLAIN\nN10 G90 G17\n{CORNERS}N80 M30\n")
    plain.until_done()
    one = FirFilter(type=kind, order=30)
    driven = Watched(filtered(demo, one, one, one), tmp_path)
    driven.start(f"%ON\nN10 G90 G17\n#FILTER ON\n{CORNERS}N80 M30\n")
    driven.until(lambda: driven.delay() > 0)
    driven.until_done()
    assert driven.alarms == []
    assert driven.places[-1] == pytest.approx(plain.places[-1], abs=0.0)
    driven.assert_axes_keep(most_jump=5.0)
    smoother = jerk_of(driven.places)[:2] / jerk_of(plain.places)[:2]
    assert (smoother <= 1.001).all() if kind is FilterType.TIME_DELAY else (smoother < 0.2).all()
    late = len(driven.places) - len(plain.places)
    assert 25 <= late <= 130  # the stops before and behind it, and the filter that runs empty


@SPEC
def test_axes_without_or_with_narrower_filters_wait_for_the_others(demo: Machine, tmp_path: Path) -> None:
    machine = filtered(
        demo, FirFilter(type=FilterType.MOVING_AVERAGE, order=60), FirFilter(type=FilterType.GAUSSIAN, order=20)
    )
    driven = Watched(machine, tmp_path)
    driven.start("%STRAIGHT\nN10 G90 G17\n#FILTER ON\nN20 G01 F6000 X60 Y60 Z30\nN30 M30\n")
    driven.until_done()
    x, y, z = driven.places.T
    moving = (x > 10.0) & (x < 50.0)  # at constant velocity: all of them at the same place of the line
    assert np.abs(x - y)[moving].max() < 1e-9
    assert np.abs(x - 2.0 * z)[moving].max() < 1e-9


@SPEC
@pytest.mark.parametrize("seed", range(4))
def test_no_axis_comes_farther_off_than_ax_dev(demo: Machine, tmp_path: Path, seed: int) -> None:
    rng = random.Random(seed)
    kinds = [rng.choice(list(FilterType)) for _ in range(3)]
    machine = filtered(demo, *(FirFilter(type=kind, order=rng.randrange(10, 100)) for kind in kinds))
    allowed = rng.choice([0.005, 0.02, 0.1])
    lines = ["G116 X1 Y1" if seed % 2 else "#TRANSVELMIN ON 3000"]  # what would make corners free counts for nothing
    for number in range(14):
        x, y = rng.uniform(0, 40), rng.uniform(0, 40)
        if rng.random() < 0.4:
            x, y = rng.uniform(0, 40), rng.uniform(0, 0.5)
        lines.append(f"N{number + 20} X{x:.3f} Y{y:.3f} Z{rng.uniform(-5, 0):.3f} F{rng.choice([2000, 8000, 20000])}")
    factor = rng.choice([1.0, 4.0])
    driven = Watched(machine, tmp_path)
    text = "\n".join(lines)
    driven.start(
        f"%TOLERANCE\nN10 G90 G17 G01 F6000\n#FILTER ON [AX_DEV={allowed} ACC_FACT={factor}]\n{text}\nN90 M30\n"
    )
    driven.until(lambda: driven.delay() > 0)
    delay = driven.delay()
    driven.forget()
    for _ in range(15):
        driven.operator.override_w = rng.choice([200, 1000, 2000])
        driven.operator.feedhold_w = rng.random() < 0.2
        driven.watch(rng.randrange(20, 120))
    driven.operator.feedhold_w, driven.operator.override_w = False, 2000
    driven.until_done()
    assert driven.alarms == []
    path = np.array(driven.path)
    off = np.abs(driven.places[delay:] - path[: len(path) - delay])
    assert off.max() <= allowed
    assert off.max() > 0.02 * allowed
    driven.assert_axes_keep(most_jump=5.0)


@SPEC
def test_without_jumps_at_corners_the_jerk_is_kept(demo: Machine, tmp_path: Path) -> None:
    one = FirFilter(type=FilterType.MOVING_AVERAGE, order=24)
    driven = Watched(filtered(demo, one, one, one, step=0.0), tmp_path)
    driven.start("%SOFT\nN10 G90 G17\n#FILTER ON\nN20 G01 F9000 X40\nN30 X80 Y30\nN40 Y0 Z-3\nN50 M30\n")
    driven.watch(250)
    driven.operator.feedhold_w = True
    driven.watch(150)
    driven.operator.feedhold_w = False
    driven.until_done()
    driven.assert_axes_keep()
    assert (jerk_of(driven.places) <= 60_000.0 * 1.01).all()


@SPEC
def test_acc_fact_makes_corners_faster(demo: Machine, tmp_path: Path) -> None:
    taken = []
    for factor in (1, 5):
        one = FirFilter(type=FilterType.GAUSSIAN, order=60)
        driven = Watched(filtered(demo, one, one, one), tmp_path)
        zigzag = "\n".join(f"N{20 + k} X{5 * k} Y{5 * (k % 2)}" for k in range(1, 15))
        driven.start(f"%ZIGZAG\nN10 G90 G17 G01 F6000\n#FILTER ON [ACC_FACT={factor}]\n{zigzag}\nN90 M30\n")
        driven.until_done()
        driven.assert_axes_keep(most_jump=5.0)
        taken.append(len(driven.targets))
    assert taken[1] < 0.95 * taken[0]


@SPEC
def test_on_off_and_other_values_never_jump(demo: Machine, tmp_path: Path) -> None:
    driven = Watched(filtered(demo, GAUSSIAN, GAUSSIAN, GAUSSIAN), tmp_path)
    driven.start(
        "%SWITCH\nN10 G90 G17 G01 F6000 X10\n#FILTER ON [ORDER=20]\nN20 X30 Y5\n#FILTER [ORDER=160 QUALITY=0.5]\nN30 X50 Y20\n"
        "#FILTER OFF\nN40 X70\n#FILTER ON [ORDER_TIME=9000 SHARE=50]\nN50 X90 Y0\nN60 M30\n"
    )
    delays = set()
    while driven.channel.active:
        driven.watch(1)
        delays.add(driven.delay())
    assert delays == {0, 10, 80, 4}
    assert driven.alarms == []
    driven.assert_axes_keep(most_jump=5.0)
    assert driven.places[-1] == pytest.approx([90.0, 0.0, 0.0], abs=0.0)
    driven.start("%AFTER\nN10 G90 G01 F6000 X80\nN20 M30\n")  # the next program begins without it
    driven.until_done()
    assert driven.delay() == 0


@SPEC
@pytest.mark.parametrize("on", ["", "#FILTER ON [ORDER=80]"])
def test_functions_come_where_the_axes_are(demo: Machine, tmp_path: Path, on: str) -> None:
    parameters = demo.channels[0].parameters
    functions = {71: "MOS", 72: "MVS_SVS", 73: "MEP_MOS", 74: "MET_MOS"}
    changed = parameters.model_copy(
        update={"m_synch": {**parameters.m_synch, **functions}, "m_pre_outp": {73: 50_000, 74: 40_000}}
    )
    driven = Watched(filtered(demo, GAUSSIAN, GAUSSIAN, GAUSSIAN, parameters=changed), tmp_path, M72=0.05)
    driven.start(
        f"%PLACES\nN10 G90 G17 G01 F6000\n{on}\nN20 X40\nN30 M71\nN40 X60\nN50 M73\nN60 X80\nN70 M74\nN80 X100\nN90 M72\n"
        "N100 X120\nN110 M30\n"
    )
    out: dict[int, float] = {}
    seen = 0
    while driven.channel.active:
        driven.watch(1)
        log = driven.simulation.log
        for event in log[seen:]:
            if event.kind is EventKind.M_OUT:
                out[event.number] = float(driven.places[-1][0])
        seen = len(log)
    cycle = 0.1  # mm at 100 mm/s
    assert out[71] == pytest.approx(40.0, abs=1.01 * cycle)
    assert out[73] == pytest.approx(60.0 - 5.0, abs=1.01 * cycle)
    assert out[74] == pytest.approx(80.0 - 4.0, abs=2.01 * cycle)
    assert out[72] == pytest.approx(100.0, abs=0.0)
    assert driven.alarms == []


@SPEC
def test_hold_single_block_and_reset_wait_until_the_axes_stand(demo: Machine, tmp_path: Path) -> None:
    one = FirFilter(type=FilterType.MOVING_AVERAGE, order=100)
    driven = Watched(filtered(demo, one, one, one), tmp_path)
    driven.start("%HOLD\nN10 G90 G17\n#FILTER ON\nN20 G01 F6000 X100\nN30 X200\nN40 M30\n")
    driven.until(lambda: float(driven.places[-1][0]) > 20.0)
    driven.operator.feedhold_w = True
    driven.until(lambda: driven.channel.held)
    stood = driven.places[-1]
    driven.watch(50)
    assert (driven.places[-1] == stood).all()
    assert stood == pytest.approx(driven.channel.interpolator.position, abs=0.0)
    driven.operator.feedhold_w = False
    driven.operator.single_block_w = True
    driven.until(lambda: bool(driven.channel.stop_condition & StopCondition.SINGLE_BLOCK))
    assert driven.places[-1] == pytest.approx([100.0, 0.0, 0.0], abs=0.0)
    driven.operator.single_block_w = False
    driven.operator.continue_motion_rw = True
    driven.until(lambda: float(driven.places[-1][0]) > 130.0)
    driven.operator.reset_rw = True
    driven.until_done()
    assert 130.0 < driven.places[-1][0] < 190.0
    driven.watch(20)
    driven.start("%AGAIN\nN10 G90 G01 F6000 X10\nN20 M30\n")
    driven.until_done()
    driven.assert_axes_keep(most_jump=5.0)
    assert driven.places[-1] == pytest.approx([10.0, 0.0, 0.0], abs=0.0)


@SPEC
def test_what_was_driven_with_another_filter_is_not_driven_back(demo: Machine, tmp_path: Path) -> None:
    driven = Watched(filtered(demo, GAUSSIAN, GAUSSIAN, GAUSSIAN, backward_storage=500), tmp_path)
    driven.start("%BACK\nN10 G90 G17 G01 F6000 X20\n#FILTER ON [ORDER=40]\nN20 X60\nN30 X80 Y20\nN40 X120\nN50 M30\n")
    driven.until(lambda: float(driven.places[-1][0]) > 100.0)
    backward(driven, True)
    driven.until(lambda: at_begin(driven))
    driven.until(lambda: driven.channel.interpolator.standstill)
    assert driven.places[-1] == pytest.approx([20.0, 0.0, 0.0], abs=1e-9)
    backward(driven, False)
    driven.until_done()
    assert driven.places[-1] == pytest.approx([120.0, 20.0, 0.0], abs=0.0)
    driven.assert_axes_keep(most_jump=5.0)
    assert driven.alarms == []


@SPEC
def test_a_filter_that_is_enabled_in_the_machine_description_holds_from_the_start(
    demo: Machine, tmp_path: Path
) -> None:
    machine = filtered(demo, FirFilter(type=FilterType.GAUSSIAN, order=30, enable=True))
    driven = Watched(machine, tmp_path)
    driven.start("%START\nN10 G90 G01 F6000 X20\n#FILTER OFF\nN20 X30\nN30 M30\n")
    assert driven.delay() == 15
    driven.until_done()
    assert driven.delay() == 0
    assert driven.places[-1] == pytest.approx([30.0, 0.0, 0.0], abs=0.0)


@SPEC
def test_a_replay_goes_on_in_the_middle_of_a_filter(demo: Machine, tmp_path: Path) -> None:
    recorded = Recorded(filtered(demo, GAUSSIAN, GAUSSIAN, GAUSSIAN), tmp_path, ideal_axes=True)
    recorded.start("%REPLAY\nN10 G90 G01 F6000\n#FILTER ON [ORDER=50 AX_DEV=0.05]\nN20 X40\nN30 Y10\nN40 M30\n")
    with_keyframes(recorded, 0.86, 97)
    recorded.run(0.5)  # the last one is written
    assert recorded.simulation.controller.interpolator.trail == 0.0
    assert_same_from_each(recorded, tmp_path, 3)


WRONG = [
    ("#FILTER ON [ORDER=10 ORDER_TIME=1000]", catalogue.CHOOSE_ONE),
    ("#FILTER ON [ORDER=201]", catalogue.VALUE_RANGE),
    ("#FILTER ON [ORDER=1.5]", catalogue.VALUE_RANGE),
    ("#FILTER ON [ORDER_TIME=200001]", catalogue.VALUE_RANGE),
    ("#FILTER [SHARE=101]", catalogue.VALUE_RANGE),
    ("#FILTER [AX_DEV=-0.1]", catalogue.VALUE_RANGE),
    ("#FILTER [FCUT=0.5]", catalogue.VALUE_RANGE),
    ("#FILTER [ACC_FACT=0.9]", catalogue.VALUE_RANGE),
    ("#FILTER [ACC_FACT=10.1]", catalogue.VALUE_RANGE),
    ("#FILTER [QUALITY=0]", catalogue.NOT_ABOVE),
    ("#FILTER [QUALITY=1.1]", catalogue.VALUE_RANGE),
    ("#FILTER ON", catalogue.FILTER_WITHOUT_ORDER),
]


@SPEC
@pytest.mark.parametrize(("text", "entry"), WRONG)
def test_wrong_values_are_refused(text: str, entry: object) -> None:
    setup = replace(SETUP, filters=(GAUSSIAN, None, None))
    problem = decode(f"{text}\nM30", setup).problem
    assert problem is not None
    assert problem.entry is entry
    assert decode("#FILTER ON [ORDER=10]\nG01 F100 X1\n#FILTER OFF\nM30", setup).problem is None


@SPEC
def test_without_a_filter_there_is_nothing_to_switch_on() -> None:
    problem = decode("#FILTER ON [ORDER=10]\nM30", SETUP).problem
    assert problem is not None
    assert problem.entry is catalogue.NO_FILTER
    assert decode("#FILTER OFF\nM30", SETUP).problem is None


def test_a_hand_beside_a_filtered_path_keeps_the_software_limit(demo: Machine, tmp_path: Path) -> None:
    driven = Watched(filtered(demo, GAUSSIAN), tmp_path)
    hand = Hand(driven)
    driven.start(
        "%H\nN5 G90 G01 F6000 X-45\nN10 #FILTER ON [ORDER=160]\nN15 G201 X1\nN20 G04 X2\nN25 G01 F24000 X300\nN30 M30\n"
    )
    driven.until(lambda: place(driven) == -45.0)
    driven.watch(300)
    hand.parameter("continuous_parameter", 1, velocity=300.0)
    hand.link(1, 1, ManualMode.CONTINUOUS)
    hand.press(1, 0)
    hand.press(1, -1)
    driven.watch(3000)
    hand.press(1, 0)
    driven.until_done()
    assert driven.alarms == []
    assert driven.places[:, 0].min() == pytest.approx(-50.0, abs=1e-6)
