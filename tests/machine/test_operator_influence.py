"""What operator and PLC influence, as channel parameters say: override, dwell, continue, how far the decoder is ahead."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from runtime.config.channel.parameters import ChannelParameters
from runtime.config.machine import FeedHoldRamp, Machine
from runtime.hli.layout import StopCondition
from runtime.hli.sampled_override import SampledOverride
from runtime.scheduler.run_ahead import RunAhead
from tests.machine.driven import Driven


def with_parameters(demo: Machine, **parameters: object) -> Machine:
    """The demo machine with other channel parameters."""
    (channel,) = demo.channels
    changed = channel.parameters.model_copy(update=parameters)
    return demo.model_copy(update={"channels": (channel.model_copy(update={"parameters": changed}),)})


def ideal(machine: Machine, folder: Path) -> Driven:
    return Driven(machine, folder, ideal_axes=True, plc=False)


def settled_speed(driven: Driven) -> float:
    """Path velocity in mm/min after the override has acted."""
    driven.watch(300)
    return driven.channel.interpolator.path_velocity * 60.0


# ---------------------------------------------------------------------------------------------------- override

FAST = "%F\nG01 F30000 X600\nM30\n"  # the axes do 24 m/min


@pytest.mark.spec("chan.override.feed-mode")
@pytest.mark.parametrize(("mode", "speeds"), [(0, (24000, 12000)), (1, (24000, 15000)), (2, (24000, 12000))])
def test_override_of_what_is_possible_or_of_what_is_programmed(
    demo: Machine, tmp_path: Path, mode: int, speeds: tuple[float, float]
) -> None:
    driven = ideal(with_parameters(demo, override_weight_prog_feed=mode), tmp_path)
    driven.start(FAST)
    assert settled_speed(driven) == pytest.approx(speeds[0], rel=1e-3)
    assert driven.channel.programmed_feed == pytest.approx(500.0)  # F as it was written
    driven.operator.override_w = 500
    assert settled_speed(driven) == pytest.approx(speeds[1], rel=1e-3)


@pytest.mark.spec("chan.override.feed-mode")
def test_without_a_limit_both_modes_are_the_same(demo: Machine, tmp_path: Path) -> None:
    for mode in (0, 1):
        driven = ideal(with_parameters(demo, override_weight_prog_feed=mode, max_vb_override=2000), tmp_path)
        driven.operator.override_w = 1500
        driven.start("%F\nG01 F3000 X100\nM30\n")
        assert settled_speed(driven) == pytest.approx(4500, rel=1e-3)


@pytest.mark.spec("chan.override.limit-delay")
def test_another_override_is_taken_at_once_and_the_next_one_later() -> None:
    sampled = SampledOverride(delay=0.02, period=0.001)
    assert [sampled.take(1.0) for _ in range(3)] == [1.0] * 3
    taken = [sampled.take(0.9 - 0.01 * k) for k in range(45)]
    changes = [k for k in range(45) if k == 0 or taken[k] != taken[k - 1]]
    assert changes == [0, 20, 40]
    assert sampled.take(0.0) == 0.0  # a stop never waits
    assert SampledOverride(delay=10e-6, period=0.001)._cycles == 10
    assert SampledOverride(delay=100.0, period=0.001)._cycles == 100_000


@pytest.mark.spec("chan.override.limit-delay")
def test_the_override_of_the_machine_is_sampled_and_limited(demo: Machine, tmp_path: Path) -> None:
    driven = ideal(with_parameters(demo, override_delay=50_000, max_vb_override=1200), tmp_path)
    driven.start("%F\nG01 F3000 X100\nM30\n")
    driven.operator.override_w = 1500
    driven.watch(2)
    status = driven.hli.channels[0].status
    assert status.active_override_r == 1200
    driven.operator.override_w = 700
    driven.watch(30)
    assert status.active_override_r == 1200
    driven.watch(30)
    assert status.active_override_r == 700
    driven.operator.override_w = 0
    driven.watch(1)
    assert status.active_override_r == 0


# ---------------------------------------------------------------------------------------------------- time, dwell


def dwell_cycles(driven: Driven, override: int, time_override: int) -> int:
    """Cycles of a dwell of 0.2 s."""
    channel = driven.hli.channels[0]
    driven.operator.override_w = override
    channel.plc_present_w = True
    channel.control.time_override.command_w = time_override
    channel.control.time_override.enable_w = True
    driven.start("%D\nG04 0.2\nG01 F3000 X1\nM30\n")
    driven.until(lambda: bool(channel.status.dwell_time_active_r))
    return driven.until(lambda: not channel.status.dwell_time_active_r)


@pytest.mark.spec("chan.override.dwell")
@pytest.mark.parametrize(
    ("parameters", "override", "time_override", "cycles"),
    [
        ({}, 500, 500, 200),
        ({"feed_override_weight_dwell_time": True}, 500, 500, 400),
        ({"time_override_weight_dwell_time": True}, 500, 500, 400),
        ({"time_override_weight_dwell_time": True, "feed_override_weight_dwell_time": True}, 500, 500, 800),
        ({"time_override_weight_dwell_time": True}, 1000, 2000, 100),
    ],
)
def test_overrides_stretch_dwells(
    demo: Machine, tmp_path: Path, parameters: dict[str, bool], override: int, time_override: int, cycles: int
) -> None:
    driven = ideal(with_parameters(demo, **parameters), tmp_path)
    assert dwell_cycles(driven, override, time_override) == pytest.approx(cycles, abs=3)


def test_the_time_override_scales_the_path(demo: Machine, tmp_path: Path) -> None:
    driven = ideal(demo, tmp_path)
    channel = driven.hli.channels[0]
    channel.plc_present_w = True
    channel.control.time_override.command_w = 250
    channel.control.time_override.enable_w = True
    driven.operator.override_w = 500
    driven.start("%F\nG01 F3000 X100\nM30\n")
    assert settled_speed(driven) == pytest.approx(375, rel=1e-3)
    assert channel.control.time_override.state_r == 250
    channel.plc_present_w = False
    assert settled_speed(driven) == pytest.approx(1500, rel=1e-3)


# ---------------------------------------------------------------------------------------------------- continue


@pytest.mark.spec("chan.inpos-check")
@pytest.mark.parametrize(("suppress", "waits"), [(False, True), (True, False)])
@pytest.mark.parametrize("stop", ["M00", "single block"])
def test_continue_waits_for_the_axes(demo: Machine, tmp_path: Path, suppress: bool, waits: bool, stop: str) -> None:
    """Servos with a tiny window, and an operator who presses at once."""
    axes = tuple(axis.model_copy(update={"in_position": 0.0005}) for axis in demo.axes)
    machine = with_parameters(demo.model_copy(update={"axes": axes}), suppress_ax_group_in_pos_check=suppress)
    driven = Driven(machine, tmp_path, plc=False)
    driven.operator.single_block_w = stop != "M00"
    driven.start(f"%S\nG01 F6000 X20 {'M00' if stop == 'M00' else ''}\nX40\nM30\n")
    driven.until(lambda: bool(driven.channel.stop_condition & StopCondition.WAIT_CONTINUE))
    lag = abs(driven.channel.interpolator.position[0] - driven.image.actual_position[0])
    assert lag > 0.0005, "there is something to wait for"
    driven.operator.continue_motion_rw = True
    driven.watch(2)
    stands = bool(driven.channel.stop_condition & StopCondition.EXACT_STOP)
    assert stands is waits
    driven.operator.single_block_w = False
    driven.until(lambda: driven.channel.interpolator.position[0] > 20.0, limit=3.0)
    driven.until_done()


# ---------------------------------------------------------------------------------------------------- run ahead

MANY = "%M\nG01 F3000\n" + "".join(f"X{k * 0.5:g}\n" for k in range(1, 120)) + "M30\n"


def ahead(driven: Driven) -> int:
    """The most motions that were known ahead of the path."""
    most = 0
    while driven.channel.active and len(driven.targets) < 3000:
        driven.watch(1)
        queue = driven.simulation.queue
        most = max(most, queue.written - queue.read)
    return most


@pytest.mark.spec("chan.ahead.limit")
@pytest.mark.parametrize(
    ("parameters", "most"),
    [
        ({"max_motion_blocks_ahead": 10}, 12),
        ({"max_nc_blocks_ahead": 10}, 12),
        ({"max_time_ahead": 600_000.0}, 65),
        ({"max_motion_blocks_ahead": 3, "dec_max_ahead_protected": "ACTIVE"}, 53),
    ],
)
def test_the_decoder_is_not_further_ahead_than_it_may_be(
    demo: Machine, tmp_path: Path, parameters: dict[str, object], most: int
) -> None:
    driven = ideal(with_parameters(demo, **parameters), tmp_path)
    driven.start(MANY)
    known = ahead(driven)
    assert known <= most
    assert known >= 0.8 * most - 2
    assert driven.image.target_position[0] == pytest.approx(59.5)


@pytest.mark.spec("chan.ahead.limit")
def test_protected_limits_cost_no_time(demo: Machine, tmp_path: Path) -> None:
    cycles = []
    for parameters in ({}, {"max_motion_blocks_ahead": 3, "dec_max_ahead_protected": "ACTIVE"}):
        driven = ideal(with_parameters(demo, **parameters), tmp_path)
        driven.start(MANY)
        ahead(driven)
        cycles.append(len(driven.targets))
    assert abs(cycles[1] - cycles[0]) <= 2


def test_what_run_ahead_is_made_of() -> None:
    assert RunAhead.of(ChannelParameters()).unlimited
    limit = RunAhead.of(ChannelParameters(max_time_ahead=2e6))
    assert (limit.seconds, limit.protected) == (2.0, True)


# ---------------------------------------------------------------------------------------------------- feedhold


def test_feed_hold_brakes_with_the_weighted_acceleration(demo: Machine, tmp_path: Path) -> None:
    """Without P-CHAN-00097 feed hold takes what is valid, and the weights of feed hold change nothing."""
    ways = []
    for words in ("", "G131=25", "G131=25 G334=200"):
        driven = ideal(demo, tmp_path)
        driven.start(f"%H\n{words}\nG01 F6000 X600\nM30\n")
        driven.until_x(200.0)
        driven.operator.feedhold_w = True
        begin = driven.image.target_position[0]
        driven.until(lambda d=driven: d.channel.interpolator.standstill)  # type: ignore[misc]
        ways.append(float(driven.image.target_position[0] - begin))
        v = np.diff(np.array(driven.targets)[:, 0]) / 1e-3
        assert (np.diff(v)[-400:] / 1e-3).min() >= -4000.0 * 1.001
    assert ways[1] > 1.8 * ways[0]
    assert ways[2] == pytest.approx(ways[1])


@pytest.mark.spec("chan.feedhold-ramp", "isg.g.acceleration-weight", "isg.g.ramp-time-weight")
def test_feed_hold_with_its_own_ramp_is_weighted_by_the_program(demo: Machine, tmp_path: Path) -> None:
    axes = tuple(
        axis.model_copy(update={"feed_hold": FeedHoldRamp(deceleration=1000.0, ramp_time=0.1)}) for axis in demo.axes
    )
    machine = with_parameters(demo.model_copy(update={"axes": axes}), use_drive_curr_limit=True)
    for words, deceleration, jerk in (
        ("G131=20", 1000.0, 10_000.0),
        ("G131=20 G334=200", 2000.0, 20_000.0),
        ("G131=20 G333 X200\nG338 X50", 2000.0, 40_000.0),
        ("G131=20 G334=50", 1000.0, 10_000.0),  # 500 would be less than the 800 of the program
        ("G131=20 G339=200", 1000.0, 5_000.0),
    ):
        driven = ideal(machine, tmp_path)
        driven.start(f"%H\n{words}\nG01 F6000 X600\nM30\n")
        driven.until_x(200.0)
        driven.operator.feedhold_w = True
        begin = driven.image.target_position[0]
        driven.until(lambda d=driven: d.channel.interpolator.standstill)  # type: ignore[misc]
        way, v = float(driven.image.target_position[0] - begin), 100.0
        least = (
            v * (v / deceleration + deceleration / jerk) / 2.0 if v > deceleration**2 / jerk else v * (v / jerk) ** 0.5
        )
        assert way == pytest.approx(least, abs=0.3), words  # seen some cycles later
        acceleration = np.diff(np.array(driven.targets)[:, 0], 2) / 1e-6
        assert acceleration.min() >= -deceleration * 1.001
