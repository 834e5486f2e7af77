"""Programs that set dynamics, as they are driven: weights, slopes, transitions, path limits, overrides."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.dynamic_settings import DynamicSettings, MoveSettings, VectorLimits, WeightedPart
from runtime.cnc.path_preparation.channel_dynamics import ChannelDynamics, WeightTable
from runtime.cnc.path_preparation.dynamic_limits import DynamicLimits
from tests.cnc.decoder.programs import SETUP
from tests.cnc.driven import LIMITS, Driven, driven
from tests.cnc.interpolator.driving import PERIOD, Order, check_path_laws

V, A, J = 400.0, 2000.0, 40_000.0  # of every axis


def peak(run: Driven) -> tuple[float, float, float]:
    """Greatest velocity, acceleration and jerk along the path."""
    return run.feed.max() / 60.0, np.abs(run.acceleration).max(), np.abs(run.jerk).max()


# ---------------------------------------------------------------------------------------------------- weights


@pytest.mark.spec("isg.g.velocity-weight-g127-g128")
@pytest.mark.parametrize(
    ("text", "velocities"),
    [
        ("G127 X70 Y60", (280.0, 240.0, 400.0)),
        ("G127 X70\nG127 Y60", (280.0, 240.0, 400.0)),
        ("G127 X50\nG127 X50", (200.0, 400.0, 400.0)),
        ("G127 X50\nG128=100", (400.0, 400.0, 400.0)),
        ("G128=25", (100.0, 100.0, 100.0)),
        ("G128=250", (400.0, 400.0, 400.0)),
    ],
)
def test_the_greatest_velocity_of_the_axes(text: str, velocities: tuple[float, float, float]) -> None:
    for axis, velocity in zip("XYZ", velocities, strict=True):
        for move in ("G00", "G01 F60000"):
            run = driven(f"{text}\n{move} {axis}300")
            assert peak(run)[0] == pytest.approx(velocity, rel=1e-6)


@pytest.mark.spec("isg.g.velocity-weight-g127-g128", "isg.g.rapid-weight-g129")
def test_a_weight_of_0_leaves_a_micron_per_second() -> None:
    for text in ("G128=0\nG01 F1000 X0.0005", "G129=0\nG00 X0.0005"):
        run = driven(text)
        assert peak(run)[0] == pytest.approx(1e-3)


@pytest.mark.spec("isg.g.velocity-weight-g127-g128", "isg.g.rapid-weight-g129")
def test_axis_words_beside_a_weight_of_all_axes_are_positions() -> None:
    for word in ("G128=50", "G129=50"):
        run = driven(f"G00 {word} X100 Y20")
        assert run.run.path[-1].tolist() == [100.0, 20.0, 0.0]
        assert run.axes[0][0] == pytest.approx(200.0, rel=1e-6)


@pytest.mark.spec("isg.g.rapid-weight-g129")
def test_rapid_velocity_alone() -> None:
    run = driven("G129=70\nG129=70\nG00 X300\nG01 F30000 X600")
    feed = run.feed / 60.0
    half = run.s < 300.0
    assert feed[half].max() == pytest.approx(280.0)
    assert feed[~half].max() == pytest.approx(400.0)
    assert peak(driven("G129=150\nG00 X300"))[0] == pytest.approx(400.0)


@pytest.mark.parametrize(
    ("text", "at_feed", "at_rapid"),
    [
        ("G130 X70", 1400.0, 2000.0),
        ("G130 X50\nG130 Y20", 1000.0, 2000.0),
        ("G131=50\nG131=50", 1000.0, 2000.0),
        ("G230 X30", 2000.0, 600.0),
        ("G231=80", 2000.0, 1600.0),
        ("G131=50 G231=25", 1000.0, 500.0),
        ("G131=300 G231=0", 2000.0, 20.0),
    ],
)
def test_acceleration_is_weighted_for_feed_and_rapid_moves(text: str, at_feed: float, at_rapid: float) -> None:
    for move, acceleration in (("G01 F20000", at_feed), ("G00", at_rapid)):
        run = driven(f"{text}\n{move} X300")
        check_path_laws(run.run)
        assert peak(run)[1] == pytest.approx(acceleration, rel=1e-4)


def test_less_acceleration_over_the_same_ramp_is_less_jerk() -> None:
    assert peak(driven("G131=50\nG01 F20000 X300"))[2] == pytest.approx(J / 2, rel=0.02)
    assert peak(driven("G131=50 G133=50\nG01 F20000 X300"))[2] == pytest.approx(J, rel=0.02)


@pytest.mark.parametrize(
    ("text", "at_feed", "at_rapid"),
    [
        ("G132 X200", J / 2, J),
        ("G133=400", J / 4, J),
        ("G233=200", J, J / 2),
        ("G132 X200\nG132 Y50", J / 2, J),
        ("G133=200\nG133=100", J, J),
        ("G133=50 G233=50", J, J),  # no faster than the machine description says
    ],
)
def test_ramp_times_are_weighted(text: str, at_feed: float, at_rapid: float) -> None:
    for move, jerk in (("G01 F20000", at_feed), ("G00", at_rapid)):
        run = driven(f"{text}\n{move} X300")
        assert peak(run)[2] == pytest.approx(jerk, rel=0.02)
        velocity, acceleration, _ = peak(run)
        assert acceleration == pytest.approx(min(A, math.sqrt(velocity * jerk)), rel=5e-3)


def test_the_geometric_ramp_time_slows_curves_down() -> None:
    program = "G01 F60000 X50\nG02 X60 Y-10 J-10\nG01 Y-60"
    usual, slower = driven(program), driven("G134=400\n" + program)
    arc = (usual.s > 52.0) & (usual.s < 63.0)
    arc_slower = (slower.s > 52.0) & (slower.s < 63.0)
    assert slower.feed[arc_slower].min() < 0.8 * usual.feed[arc].min()
    assert peak(slower)[2] == pytest.approx(J, rel=0.02)  # along the path nothing has changed
    assert driven("G134=400\n#SLOPE [TYPE=STEP]\n" + program).time == driven("#SLOPE [TYPE=STEP]\n" + program).time


def test_ramp_times_change_nothing_with_the_slope_step() -> None:
    program = "#SLOPE [TYPE=STEP]\nG01 F20000 X300"
    assert driven("G133=400\n" + program).time == driven(program).time


def test_moves_of_both_kinds_take_turns_in_one_run() -> None:
    """G00 and G01 of plain lines are one polyline; over its borders the lower limits count."""
    moves = "".join(f"G0{k % 2} X{10 * k}\n" for k in range(1, 300))
    run = driven("F9000\nG131=50\nG231=25\n" + moves)
    accelerations = run.records("a_limit")
    assert accelerations[:4] == pytest.approx([1000.0, 500.0, 1000.0, 500.0])
    assert len({int(n) for n in run.records("limits")}) == 2
    check_path_laws(run.run)


# ---------------------------------------------------------------------------------------------------- slopes


@pytest.mark.spec("isg.add.slope")
def test_slopes() -> None:
    """The same change of speed: at once, with constant jerk, as sin² over the same ramp time."""
    step, trapez, sin2, hsc = (
        driven(f"#SLOPE [TYPE={kind}]\nG01 F12000 X300") for kind in ("STEP", "TRAPEZ", "SIN2", "HSC")
    )
    assert peak(step)[1] == pytest.approx(A)
    assert peak(step)[2] == pytest.approx(A / PERIOD, rel=1e-6)
    assert peak(trapez)[2] == pytest.approx(J, rel=0.02)
    ramp = A / J
    assert trapez.time - step.time == pytest.approx(ramp, abs=3e-3)
    assert sin2.time - trapez.time > 0.0
    assert hsc.time == trapez.time
    for run in (step, trapez, sin2, hsc):
        check_path_laws(run.run)


@pytest.mark.spec("isg.add.slope", "chan.start.slope")
def test_the_slope_of_the_channel_comes_back() -> None:
    setup = replace(SETUP, dynamics=DynamicSettings(slope=DynamicSettings().slope.STEP))
    run = driven("G01 F12000 X300", setup=setup)
    assert peak(run)[2] > 10.0 * J
    run = driven("#SLOPE [TYPE=TRAPEZ NO_OPT=0]\nG01 F12000 X150\n#SLOPE DEFAULT\nG04 0.1\nX300", setup=setup)
    half = run.s < 149.0
    assert np.abs(run.jerk[half]).max() == pytest.approx(J, rel=0.02)
    assert np.abs(run.jerk[~half]).max() > 10.0 * J


# ---------------------------------------------------------------------------------------------------- transitions

TRANSITION = "isg.g.block-transition-g08-g09-g900-g901"


@pytest.mark.spec(TRANSITION)
@pytest.mark.parametrize("slope", ["STEP", "TRAPEZ", "SIN2"])
def test_where_a_block_brakes(slope: str) -> None:
    """The programs of the manual (lines 3875–3949), shorter: speed at the border, in front of it and behind it."""
    first = f"#SLOPE [TYPE={slope}]\nG01 {{}} X50 F1000\nX60 F400"
    for words, at_border in (("", 400.0), ("G08", 400.0), ("G900", 400.0), ("G901", 1000.0), ("G901 G09", 400.0)):
        run = driven(first.format(words))
        assert run.feed_at(50.0) == pytest.approx(at_border, rel=0.02), words
        assert run.feed_at(47.0) == pytest.approx(1000.0), words
        assert run.feed_at(53.0) == pytest.approx(400.0), words
    rising = driven(f"#SLOPE [TYPE={slope}]\nG901\nG01 X10 F400\nX50 F1000")
    assert rising.feed_at(10.0) == pytest.approx(400.0, rel=1e-3)  # G08: faster behind the border only


@pytest.mark.spec(TRANSITION)
def test_g09_with_g901_and_g900() -> None:
    """The third example of the manual (lines 3914–3940), shorter."""
    run = driven("G01 G901 X20 F2000\nG09 X40 F1600\nX60 F1200\nG900 X80 F800\nX100 F400")
    assert [run.feed_at(border) for border in (20.0, 40.0, 60.0, 80.0)] == pytest.approx(
        [2000.0, 1200.0, 1200.0, 400.0], rel=1e-3
    )


@pytest.mark.spec(TRANSITION)
def test_rapid_moves_brake_in_front_of_the_border() -> None:
    run = driven("G901\nG00 X200\nG01 F1000 X400")
    assert run.feed_at(200.0) == pytest.approx(1000.0, rel=1e-3)


@pytest.mark.spec(TRANSITION)
def test_g901_does_not_pass_a_limit_of_the_path() -> None:
    """The next block may not be driven so fast: its limit holds at the border (lines 3871–3873)."""
    run = driven("G901\nG127 Y10\nG01 F20000 X100\nX200.000001 Y100.000001 F20000")
    limit = run.records("v_limit")[1]
    assert run.feed_at(100.0) / 60.0 <= limit * 1.001
    run = driven("G901\nG01 F20000 X100\nG02 X110 Y-10 J-10 F1000")
    assert run.feed_at(100.0) / 60.0 <= run.records("v_entry")[1] * 1.001


@pytest.mark.spec(TRANSITION)
def test_under_an_override_late_braking_begins_at_the_border_too() -> None:
    run = driven("G901\nG01 X100 F4000\nX200 F1000", schedule=lambda _c, _i: Order(override=0.5))
    assert run.feed_at(100.0) == pytest.approx(2000.0, rel=1e-3)
    assert run.feed_at(104.0) == pytest.approx(500.0, rel=1e-3)


# ---------------------------------------------------------------------------------------------------- corner deceleration

CORNER = "isg.g.corner-deceleration"
PARAMETERS = "#SLOPE [TYPE=STEP]\nG01 X10 Y10 F1000\n#CORNER PARAM [DIST=10 UNIT={} FEED={}]\n"


@pytest.mark.spec(CORNER)
@pytest.mark.parametrize(("unit", "feed"), [("PERCENT", 50), ("FWORD", 500)])
def test_the_feed_falls_linearly_in_front_of_a_corner(unit: str, feed: int) -> None:
    """The example of the manual (lines 4541–4552)."""
    run = driven(PARAMETERS.format(unit, feed) + "G13\nX50\nX90\nG12\nX130")
    start = math.hypot(10.0, 10.0)
    for end in (start + 40.0, start + 80.0):
        for left in (10.5, 8.0, 5.0, 2.0, 0.5):
            assert run.feed_at(end - left) == pytest.approx(500.0 + 50.0 * min(left, 10.0), abs=30.0)
    assert run.feed_at(start + 60.0) == pytest.approx(1000.0)
    assert run.feed[(run.s > start + 85.0) & (run.s < start + 115.0)].min() == pytest.approx(1000.0)


@pytest.mark.spec(CORNER)
def test_an_arc_and_a_short_block_in_front_of_a_corner() -> None:
    run = driven(PARAMETERS.format("PERCENT", 50) + "G13\nG03 X40 Y40 J30\nG01 Y44 F1000\nY100\nG12")
    start = math.hypot(10.0, 10.0)
    arc = 15.0 * math.pi
    assert run.feed_at(start + arc - 5.0) == pytest.approx(750.0, abs=30.0)
    assert run.feed_at(start + arc + 3.9) == pytest.approx(500.0, abs=30.0)
    assert run.feed[(run.s > start + arc) & (run.s < start + arc + 4.0)].max() <= 720.0
    assert run.run.path[-1].tolist() == [40.0, 100.0, 0.0]


@pytest.mark.spec(CORNER)
def test_corner_deceleration_needs_the_slope_step() -> None:
    program = PARAMETERS.format("PERCENT", 50).replace("STEP", "TRAPEZ") + "G13\nX50\nX90"
    run = driven(program)
    assert run.feed[(run.s > 30.0) & (run.s < 80.0)].min() == pytest.approx(1000.0)


# ---------------------------------------------------------------------------------------------------- look-ahead

AHEAD = "isg.g.look-ahead-g115-g117"


@pytest.mark.spec(AHEAD)
def test_corners_can_be_passed_without_slowing_down() -> None:
    program = "G01 F3000 X100\nX200 Y40\nX300"
    held = driven(program)
    assert held.feed_at(100.0) < 2800.0
    for off in ("G115=0", "G115=4", "G115=8", "G115=12"):
        assert driven(f"{off}\n{program}").feed_at(100.0) == pytest.approx(3000.0), off
    for on in ("G115=2", "G115=6", "G115=10", "G115=14", "G115=0\nG117"):
        assert driven(f"{on}\n{program}").time == held.time, on


@pytest.mark.spec(AHEAD)
def test_an_axis_may_jump_at_corners() -> None:
    """The example of the manual (lines 6363–6371): the axes jump, the path keeps its speed."""
    program = "G01 F3000 X100 Y-100\nX0"
    border = 100.0 * math.sqrt(2.0)
    assert driven("G116 X1 Y2\n" + program).feed_at(border) == pytest.approx(3000.0)
    assert driven("G116 X1\n" + program).feed_at(border) < 1000.0  # Y has to slow down
    assert driven("G116 X1 Y2\nG117\n" + program).feed_at(border) < 1000.0
    assert driven("G116 X1\nG116 Y2\n" + program).feed_at(border) == pytest.approx(3000.0)


@pytest.mark.spec(AHEAD)
def test_the_acceleration_on_curves_can_be_left_out() -> None:
    program = "G01 F12000 X50\nG02 X60 Y-10 J-10\nG01 Y-60"
    assert driven(program).feed_at(58.0) < 8_000.0
    run = driven("G115=4\n" + program)
    assert run.feed_at(58.0) == pytest.approx(12_000.0, rel=1e-3)
    assert driven("G115=12\n" + program).feed_at(58.0) < 8_000.0


@pytest.mark.spec("chan.start.slope")
def test_weights_may_act_on_one_side_only() -> None:
    """P-CHAN-00001 and P-CHAN-00073: the sets of limits that the elements of the queue name."""
    for part, up, down in (("ALL", 0.5, 0.5), ("SPEEDING_UP", 0.5, 1.0), ("BRAKING", 1.0, 0.5)):
        chosen = WeightedPart[part]
        limits = DynamicLimits(LIMITS, PERIOD)
        limits.change(DynamicSettings(feed=MoveSettings((0.5,) * 3), weighted_acceleration=chosen))
        axes = limits.axis_limits(rapid=False)
        assert (axes.acceleration[0], axes.deceleration[0]) == (up * A, down * A)
        limits.change(DynamicSettings(feed=MoveSettings((), (2.0,) * 3), weighted_ramps=chosen))
        axes = limits.axis_limits(rapid=False)
        assert (axes.jerk[0], axes.braking_jerk[0]) == (up * J, down * J)


# ---------------------------------------------------------------------------------------------------- path limits

ON, OFF = "isg.add.vector-limit-on", "isg.add.vector-limit-off"
ACC = 3600.0 * 500.0  # mm/min²


@pytest.mark.spec(ON)
def test_limits_along_the_path() -> None:
    run = driven(f"#VECTOR LIMIT ON [ACC={ACC} VEL=6000 JERK=8000]\nG01 F20000 X300")
    assert peak(run) == pytest.approx((100.0, 500.0, 8000.0), rel=0.02)
    run = driven(f"#VECTOR LIMIT ON [VEL=6000 \\\nDEC={ACC}]\nG00 X300")
    assert peak(run)[0] == pytest.approx(100.0)
    assert run.acceleration.min() == pytest.approx(-500.0, rel=0.02)
    assert peak(driven("#VECTOR LIMIT ON [VEL=60000000]\nG01 F60000 X300"))[0] == pytest.approx(V)


@pytest.mark.spec(ON)
def test_limits_for_feed_or_rapid_moves_only() -> None:
    program = "G00 X100\nG01 F20000 X200"
    for word, speeds in (
        ("FEED", (400.0, 100.0)), ("RAPID", (100.0, 333.3333)), ("", (100.0, 100.0)), ("FEED RAPID", (100.0, 100.0)),
    ):  # fmt: skip
        limit = driven(f"#VECTOR LIMIT ON [VEL=6000 {word}]\n{program}").records("v_limit")
        assert [min(one, 333.3333 if k else 400.0) for k, one in enumerate(limit)] == pytest.approx(list(speeds)), word


@pytest.mark.spec(ON, "chan.vector-limit")
def test_limits_without_a_value_are_those_of_the_channel() -> None:
    setup = replace(SETUP, vector_limits=VectorLimits(acceleration=700.0, deceleration=600.0, velocity=50.0))
    run = driven("#VECTOR LIMIT ON ALL\nG01 F20000 X300", setup=setup)
    assert peak(run)[:2] == pytest.approx((50.0, 600.0), rel=1e-3)
    run = driven("#VECTOR LIMIT ON [ACC VEL=9000]\nG01 F20000 X300", setup=setup)
    assert peak(run)[:2] == pytest.approx((150.0, 700.0), rel=1e-3)
    run = driven("#VECTOR LIMIT ON [ACC=900 VEL]\nG01 F20000 X300", setup=replace(setup, vector_per_second=True))
    assert peak(run)[:2] == pytest.approx((50.0, 900.0), rel=1e-3)


@pytest.mark.spec(ON, "chan.vector-limit")
def test_limits_on_circles() -> None:
    program = "G01 F12000 X50\nG02 X60 Y-10 J-10\nG01 Y-60"
    for limit, speed in (
        (f"RADIAL_ACC={3600.0 * 250}", math.sqrt(250.0 * 10.0)),
        (f"RADIAL_JERK={60.0**3 * 1250}", math.cbrt(1250.0 * 100.0)),
    ):
        run = driven(f"#VECTOR LIMIT ON [{limit}]\n{program}")
        assert run.feed_at(58.0) / 60.0 == pytest.approx(speed, rel=1e-3)
    limited = f"#VECTOR LIMIT ON [ACC={ACC}]\n{program}"
    arc = [driven(limited, weights=ChannelDynamics(limit_on_circles=on)).records("a_limit")[1] for on in (True, False)]
    assert arc[0] == pytest.approx(500.0)
    assert arc[1] > 500.0


@pytest.mark.spec(ON)
def test_the_acceleration_in_a_transition() -> None:
    """Over a corner the velocity may change by the limit times a cycle."""
    program = "G01 F3000 X100\nX200 Y5"
    turn = np.linalg.norm(np.array([100.0, 5.0]) / math.hypot(100.0, 5.0) - [1.0, 0.0])
    run = driven(f"#VECTOR LIMIT ON [TRANS_ACC={3600.0 * 1000.0}]\n{program}")
    assert run.records("v_entry")[1] == pytest.approx(1000.0 * PERIOD / turn)
    assert run.feed_at(100.0) / 60.0 == pytest.approx(1000.0 * PERIOD / turn, rel=0.02)


@pytest.mark.spec(OFF)
def test_limits_are_taken_back() -> None:
    on = f"#VECTOR LIMIT ON [ACC={ACC} VEL=6000]\n"
    move = "G01 F20000 X300"
    assert peak(driven(f"{on}#VECTOR LIMIT OFF [ACC]\n{move}"))[:2] == pytest.approx((100.0, A), rel=1e-3)
    assert driven(f"{on}#VECTOR LIMIT OFF ALL\n{move}").time == driven(move).time
    assert driven(f"{on}#VECTOR LIMIT OFF [ACC \\\nVEL]\n{move}").time == driven(move).time


@pytest.mark.spec("isg.add.transvelmin")
def test_the_least_speed_at_corners() -> None:
    program = "G01 F3000 X100\nX100 Y100\nG02 X120 Y120 R20"
    assert driven(program).feed_at(100.0) < 1000.0
    run = driven("#TRANSVELMIN ON [1200]\n" + program)
    assert run.feed_at(100.0) == pytest.approx(1200.0, rel=1e-3)
    for off in ("#TRANSVELMIN ON", "#TRANSVELMIN ON [1200]\n#TRANSVELMIN OFF"):
        assert driven(f"{off}\n{program}").time == driven(program).time
    assert driven("#TRANSVELMIN ON [9000]\n" + program).feed_at(100.0) == pytest.approx(3000.0)  # no more than the feed
    assert driven("G70\n#TRANSVELMIN ON [47.24409]\nG71\n" + program).feed_at(100.0) == pytest.approx(1200.0, rel=1e-3)


# ---------------------------------------------------------------------------------------------------- weights by size

BY_LENGTH = WeightTable((10.0, 50.0, 1e6), ((0.1, 1.0, 1.0), (0.5, 0.5, 2.0), (1.0, 0.25, 1.0)))
BY_RADIUS = WeightTable((5.0, 50.0), ((0.01, 0.5, 2.0), (2.0, 2.0, 1.0)))


@pytest.mark.spec("chan.weight.path", "isg.add.dynamic-weight")
def test_straight_moves_are_weighted_by_their_length() -> None:
    weights = ChannelDynamics(by_length=BY_LENGTH)
    program = "G00 X5\nG00 X15\nG00 X65\nG01 F30000 X70\nX120\nX320"
    chosen = replace(SETUP, dynamics=DynamicSettings(path_weights=3))
    run = driven(program, setup=chosen, weights=weights)
    assert run.records("v_limit") == pytest.approx([40.0, 200.0, 400.0, 40.0, 400.0, 400.0])
    assert run.records("a_limit") == pytest.approx([2000.0, 1000.0, 500.0, 2000.0, 500.0, 500.0])
    assert run.records("j_limit") == pytest.approx([J, J / 4, J / 4, J, J / 4, J / 4])  # the second has twice the ramp
    check_path_laws(run.run)
    for active, limits in ((1, [40.0, 400.0]), (2, [400.0, 40.0])):
        setup = replace(SETUP, dynamics=DynamicSettings(path_weights=active))
        run = driven("G00 X5\nG01 F30000 X10", setup=setup, weights=weights)
        assert run.records("v_limit") == pytest.approx(limits)
    run = driven(
        "#DYNAMIC WEIGHT OFF [PATH]\nG00 X5\n#DYNAMIC WEIGHT ON [PATH]\nG00 X10", setup=chosen, weights=weights
    )
    assert run.records("v_limit") == pytest.approx([400.0, 40.0])
    run = driven("G129=50\nG00 X5\nG01 F30000 X10", setup=chosen, weights=weights)
    assert run.records("v_limit") == pytest.approx([200.0, 40.0])  # G129 takes the place of the table


@pytest.mark.spec("chan.weight.radius", "isg.add.dynamic-weight")
def test_circles_are_weighted_by_their_radius() -> None:
    weights = ChannelDynamics(by_radius=BY_RADIUS)
    chosen = replace(SETUP, dynamics=DynamicSettings(curve_weights=True))
    program = "F60000\nG02 X8 I4\nG02 X18 I5\nG01 X20"
    run = driven(program, setup=chosen, weights=weights)
    small, equal, line = run.records("v_limit")
    plain = driven(program, weights=weights).records("v_limit")
    assert small == pytest.approx(4.0)
    assert [equal, line] == pytest.approx(plain[1:])  # equal takes the next row, which is no more than 100 %
    run = driven("#DYNAMIC WEIGHT OFF [CURVE]\n" + program, setup=chosen, weights=weights)
    assert run.records("v_limit") == pytest.approx(plain)
    run = driven("G128=50\nG131=50\n#DYNAMIC WEIGHT ON [CURVE]\n" + program, weights=weights)
    assert run.records("v_limit")[0] == pytest.approx(2.0)


# ---------------------------------------------------------------------------------------------------- overrides


@pytest.mark.spec("isg.add.override")
def test_the_programmed_override() -> None:
    program = "G01 F6000 X100\nG00 X200\nG166 G01 X300\nG166 G00 X400"
    run = driven("#OVERRIDE [FEED_FACT=50 RAPID_FACT=25]\n" + program)
    assert [run.feed_at(way) for way in (60.0, 160.0, 250.0, 350.0)] == pytest.approx(
        [3000.0, 6000.0, 6000.0, 24000.0], rel=1e-3
    )
    run = driven("#OVERRIDE [FEED_FACT=200]\n#OVERRIDE [RAPID_FACT=10]\n" + program)
    assert [run.feed_at(way) for way in (60.0, 160.0)] == pytest.approx([12000.0, 2400.0], rel=1e-3)


@pytest.mark.spec("isg.add.override")
def test_operator_and_program_multiply() -> None:
    run = driven("#OVERRIDE [FEED_FACT=50]\nG01 F6000 X100", schedule=lambda _c, _i: Order(override=0.5))
    assert run.feed_at(60.0) == pytest.approx(1500.0)


def test_limits_of_the_axes_hold_with_all_of_it() -> None:
    program = (
        "G127 X80 Y50\nG130 X60\nG133=300\n#SLOPE [TYPE=SIN2]\nF20000\nG01 X50 Y20\nG02 X70 Y40 R20\nG00 X0\n"
        "#VECTOR LIMIT ON [VEL=9000 JERK=10000]\nG901 X30 Y30\nG01 F900 X31\nG03 X0 Y30 I-15.5\n"
    )
    run = driven(program)
    check_path_laws(run.run)
    velocity, acceleration = run.axes
    assert (velocity <= LIMITS.velocity * [0.8, 0.5, 1.0] * 1.005).all()
    assert (acceleration <= LIMITS.acceleration * 1.3 + 2.0 * LIMITS.velocity_step / PERIOD).all()


@pytest.mark.spec("isg.axis.override")
def test_overrides_of_axes() -> None:
    """The program of the manual (lines 30396–30415), shorter."""
    run = driven(
        "G01 X10 Y10 Z10 F6000\nX[OVERRIDE FEED_FACT=20 RAPID_FACT=60]\nN50 Y[OVERRIDE FEED_FACT=30 RAPID_FACT=70]\n"
        "Z[OVERRIDE FEED_FACT=40 \\\nRAPID_FACT=80]\nG00 X0\nY0\nZ0\nG01 X10 F6000\nY10\nZ10\nX20 Y20\nX30 Y30 Z20\n"
    )
    feed, rapid = run.records("feed"), run.records("v_limit")
    assert rapid[1:4] == pytest.approx([240.0, 280.0, 320.0])
    assert [one * 60 for one in feed[4:]] == pytest.approx([1200, 1800, 2400, 1200, 1200])
    (both,) = driven("#OVERRIDE [FEED_FACT=50]\nX[OVERRIDE FEED_FACT=20]\nG01 X1 F6000").records("feed")
    assert both * 60 == pytest.approx(600)
    (alone,) = driven("X[OVERRIDE FEED_FACT=20]\nG166 G01 X1 F6000").records("feed")
    assert alone * 60 == pytest.approx(6000)


@pytest.mark.spec("isg.g.velocity-weight-g127-g128")
@settings(max_examples=12, deadline=None, derandomize=True)
@given(
    st.lists(st.sampled_from(["G128=60", "G127 X30", "G131=40", "G230 Y20", "G133=300", "G901", "#SLOPE [TYPE=SIN2]",
                              "#VECTOR LIMIT ON [VEL=5000]", "G129=50", "#OVERRIDE [FEED_FACT=150]"]), max_size=4),
    st.lists(st.tuples(st.integers(0, 2), st.integers(-20, 20), st.integers(-20, 20), st.integers(500, 20000)),
             min_size=2, max_size=6),
    st.lists(st.tuples(st.integers(5, 80), st.sampled_from([0.0, 0.3, 1.0, 2.0]), st.booleans()), min_size=1, max_size=12),
)  # fmt: skip
def test_weighted_limits_hold_under_any_override(
    words: list[str], moves: list[tuple[int, int, int, int]], pattern: list[tuple[int, float, bool]]
) -> None:
    """Set-points of the axes, and the path in its own limits, whatever operator and program do together."""
    lines = [
        f"G0{kind} X{x} Y{y} F{f}" if kind < 2 else f"G02 X{x} Y{y} R{abs(x) + abs(y) + 30} F{f}"
        for kind, x, y, f in moves
    ]
    orders = [Order(override, hold) for cycles, override, hold in pattern for _ in range(cycles)]

    def schedule(cycle: int, _interpolator: object) -> Order:
        return orders[cycle] if cycle < len(orders) else Order()

    run = driven("\n".join([*words, *lines]), schedule=schedule)
    check_path_laws(run.run)
    share = np.ones(3)
    for word in words:
        if word == "G128=60":
            share[:] = 0.6
        elif word == "G127 X30":
            share[0] = 0.3
    velocity, _ = run.axes
    assert (velocity <= LIMITS.velocity * share * 1.005).all()
