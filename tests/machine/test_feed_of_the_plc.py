"""A feed that the PLC commands in place of the programmed one, and an override of its own for rapid moves."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.config.machine import Machine
from runtime.hli.layout import PathWay, StopCondition
from tests.machine.driven import Driven
from tests.machine.test_operator_influence import ideal, settled_speed, with_parameters

EXTERNAL = pytest.mark.spec("chan.plc-feed")
FF = pytest.mark.spec("isg.add.ff")
FEED = "%F\nG01 F3000 X600\nM30\n"
RAPID = "%F\nG00 X600\nM30\n"


def command(driven: Driven, speed: float) -> None:
    """The PLC commands a feed, mm/min."""
    channel = driven.hli.channels[0]
    channel.plc_present_w = True
    control = channel.control
    control.ext_command_speed.enable_w = control.ext_command_speed_valid.enable_w = True
    control.ext_command_speed.command_w = round(speed / 60.0 * 1000.0)
    control.ext_command_speed_valid.command_w = True


def withdraw(driven: Driven) -> None:
    driven.hli.channels[0].control.ext_command_speed_valid.command_w = False


@EXTERNAL
def test_a_feed_of_the_plc_takes_the_place_of_the_programmed_one(demo: Machine, tmp_path: Path) -> None:
    driven = ideal(demo, tmp_path)
    driven.start(FEED)
    assert settled_speed(driven) == pytest.approx(3000, rel=1e-3)
    command(driven, 1200)
    assert settled_speed(driven) == pytest.approx(1200, rel=1e-3)
    driven.operator.override_w = 500
    assert settled_speed(driven) == pytest.approx(600, rel=1e-3)
    command(driven, 6000)
    assert settled_speed(driven) == pytest.approx(3000, rel=1e-3)
    withdraw(driven)
    assert settled_speed(driven) == pytest.approx(1500, rel=1e-3)


@EXTERNAL
def test_a_feed_of_nothing_or_less_holds_a_path_that_cannot_go_back_and_tells_why(
    demo: Machine, tmp_path: Path
) -> None:
    driven = ideal(demo, tmp_path)
    driven.start(FEED)
    settled_speed(driven)
    for speed in (0.0, -1000.0):
        command(driven, speed)
        assert settled_speed(driven) == 0.0
        assert driven.channel.stop_condition & StopCondition.OVERRIDE_ZERO
        assert driven.hli.channels[0].control.ext_command_speed.state_r == round(speed / 60.0 * 1000.0)
        command(driven, 1500)
        assert settled_speed(driven) == pytest.approx(1500, rel=1e-3)


@pytest.mark.spec("chan.plc-feed", "hli.ch.cu.external-feed")
def test_a_feed_below_nothing_drives_the_path_backward(demo: Machine, tmp_path: Path) -> None:
    channel = demo.channels[0].model_copy(update={"backward_storage": 100})
    driven = ideal(demo.model_copy(update={"channels": (channel,)}), tmp_path)
    status = driven.hli.channels[0].status
    driven.start("%F\nG01 F3000 X30\nX60 Y30\nX200\nM30\n")
    driven.until_x(80.0)
    command(driven, -1200)
    driven.until(lambda: driven.channel.path_way == PathWay.BACKWARD)
    assert settled_speed(driven) == pytest.approx(1200, rel=1e-3)
    assert status.active_feed_r == pytest.approx(-20_000, rel=1e-3), "its sign shows"
    driven.operator.override_w = 500
    assert settled_speed(driven) == pytest.approx(600, rel=1e-3)
    command(driven, 1500)
    driven.until(lambda: driven.channel.path_way in (PathWay.REPEATING, PathWay.ONWARD))
    assert settled_speed(driven) == pytest.approx(750, rel=1e-3)
    assert status.active_feed_r == pytest.approx(12_500, rel=1e-3)
    command(driven, -6000)
    driven.until(lambda: bool(driven.channel.stop_condition & StopCondition.BACKWARD_END))
    assert driven.image.target_position[:2].tolist() == pytest.approx([0.0, 0.0], abs=1e-9)
    withdraw(driven)
    driven.operator.override_w = 1000
    driven.until_done()
    assert driven.image.target_position[:2].tolist() == [200.0, 30.0]
    assert driven.errors == []


@EXTERNAL
@pytest.mark.parametrize(("on_rapid", "expected"), [(False, 0.0), (True, 1200.0)])
def test_rapid_moves_take_it_where_the_channel_says_so(
    demo: Machine, tmp_path: Path, on_rapid: bool, expected: float
) -> None:
    driven = ideal(with_parameters(demo, plc_command_rapid_feed=on_rapid), tmp_path)
    command(driven, 1200)
    driven.start(RAPID)
    speed = settled_speed(driven)
    assert speed == pytest.approx(expected, rel=1e-3) if on_rapid else speed > 10_000


@FF
@EXTERNAL
@pytest.mark.parametrize(("disabled", "expected"), [(False, 600.0), (True, 1200.0)])
def test_the_program_weights_it(demo: Machine, tmp_path: Path, disabled: bool, expected: float) -> None:
    driven = ideal(with_parameters(demo, disable_feed_factor=disabled), tmp_path)
    command(driven, 1200)
    driven.start("%F\n#FF = 50\nG01 F3000 X600\nM30\n")
    assert settled_speed(driven) == pytest.approx(expected, rel=1e-3)
    withdraw(driven)
    assert settled_speed(driven) == pytest.approx(3000, rel=1e-3)


@pytest.mark.spec("chan.override.rapid")
@pytest.mark.parametrize(
    ("mode", "feed", "rapid", "on_feed", "on_rapid"),
    [
        ("NOT_USED", 500, 300, 0.5, 0.5),
        ("MINIMUM_OF_G0_G1", 500, 300, 0.5, 0.3),
        ("MINIMUM_OF_G0_G1", 200, 300, 0.2, 0.2),
        ("ACTIVE", 500, 700, 0.5, 0.7),
        ("ACTIVE_EXTENDED", 500, 700, 0.5, 0.7),
    ],
)
def test_rapid_moves_have_an_override_of_their_own(
    demo: Machine, tmp_path: Path, mode: str, feed: int, rapid: int, on_feed: float, on_rapid: float
) -> None:
    for text, share in ((FEED, on_feed), (RAPID, on_rapid)):
        driven = ideal(with_parameters(demo, g00_override_mode=mode), tmp_path)
        driven.start(text)
        full = settled_speed(driven)
        channel = driven.hli.channels[0]
        channel.plc_present_w = True
        for unit, value in ((channel.control.override, feed), (channel.control.rapid_override, rapid)):
            unit.enable_w, unit.command_w = True, value
        assert settled_speed(driven) == pytest.approx(share * full, rel=1e-3)


@pytest.mark.spec("chan.override.rapid")
def test_a_rapid_override_of_nothing_stops_rapid_moves_only(demo: Machine, tmp_path: Path) -> None:
    driven = ideal(with_parameters(demo, g00_override_mode="ACTIVE"), tmp_path)
    channel = driven.hli.channels[0]
    channel.plc_present_w = True
    channel.control.rapid_override.enable_w = True
    driven.start("%F\nG01 F6000 X20\nG00 X40\nM30\n")
    driven.watch(2000)
    assert driven.channel.interpolator.position[0] == pytest.approx(20.0, abs=1e-6)
    assert driven.channel.stop_condition & StopCondition.OVERRIDE_ZERO
    channel.control.rapid_override.command_w = 1000
    driven.watch(2000)
    assert driven.channel.interpolator.position[0] == pytest.approx(40.0, abs=1e-6)


@pytest.mark.spec("hli.ax.cu.override")
def test_the_override_of_an_axis_does_not_act_inside_of_a_path(demo: Machine, tmp_path: Path) -> None:
    driven = ideal(demo, tmp_path)
    axis = driven.hli.axes[0]
    axis.plc_present_w = True
    for unit in (axis.control.override, axis.control.override_valid):
        unit.enable_w, unit.command_w = True, 1
    axis.control.override.command_w = 300
    driven.start(FEED)
    assert settled_speed(driven) == pytest.approx(3000, rel=1e-3)
    assert axis.control.override.state_r == 300
