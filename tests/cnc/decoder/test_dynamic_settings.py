"""What programs say of dynamics: settings in the stream, feed axes, and what is wrong."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from runtime.cnc.blocks import Arc, DynamicsChange, ExactStop, Line, Polyline
from runtime.cnc.decoder.feed_group import FeedGroup
from runtime.cnc.dynamic_settings import DynamicSettings, Slope
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.programs import SETUP, decode, found

FOUR = replace(SETUP, axes=("X", "Y", "Z", "C"), linear=(True, True, True, False), zero_offsets={})
AT = (0.0, 0.0, 0.0, 0.0)


def settings(text: str, **options: object) -> DynamicSettings:
    """What holds at the end of a program."""
    run = decode(text, **options)  # type: ignore[arg-type]
    assert run.problem is None, run.problem
    changes = [block.settings for block in run.blocks if isinstance(block, DynamicsChange)]
    return changes[-1] if changes else run.decoder.execution.setup.dynamics


def feeds(text: str, setup: object = SETUP) -> list[float]:
    """The feed of every motion along the path as the queue measures it, mm/min."""
    run = decode(text, setup, start=AT[: len(setup.axes)])  # type: ignore[attr-defined, arg-type]
    assert run.problem is None, run.problem
    found: list[float] = []
    for block in run.blocks:
        if isinstance(block, Line | Arc):
            found.append(block.feed)
        elif isinstance(block, Polyline):
            found += block.feeds.tolist()
    return found


def test_a_change_stands_where_it_is_programmed() -> None:
    run = decode("G01 F100 X1\nX2\nG131=50 X3\nX4\nG131=50\nX5")
    (place,) = [
        k for k, block in enumerate(run.blocks) if isinstance(block, DynamicsChange)
    ]  # the second says nothing new
    moves = [len(b.feeds) if isinstance(b, Polyline) else isinstance(b, Line) for b in run.blocks]
    assert (sum(moves[:place]), sum(moves[place:])) == (2, 3)


def test_what_holds_at_program_start_comes_first() -> None:
    setup = replace(SETUP, dynamics=DynamicSettings(slope=Slope.SIN2))
    assert isinstance(decode("G01 F100 X1", setup).blocks[0], DynamicsChange)
    assert not any(isinstance(block, DynamicsChange) for block in decode("G01 F100 X1").blocks)


def test_what_a_cycle_changes() -> None:
    """G functions come back, what was programmed for single axes and statements stay (lines 7389–7392)."""
    files = {"C": "G131=50 G129=50 G901 G115=0\nG230 X50\n#SLOPE [TYPE=SIN2]\n#OVERRIDE [FEED_FACT=50]\nX3\nM17"}
    left = settings("%M\nG01 F1000 X1\nG131=80\nL CYCLE [NAME=C]\nX4\nM30", files=files)
    assert left.feed.acceleration == (0.8, 0.8, 0.8)
    assert (left.rapid_velocity, left.late_braking, left.look_ahead) == (None, False, 14)
    assert left.rapid.acceleration == (0.5, 1.0, 1.0)
    assert (left.slope, left.feed.override) == (Slope.SIN2, 0.5)


def test_a_new_program_begins_with_the_settings_of_the_channel() -> None:
    assert settings("G131=50\nM30").feed.acceleration == (0.5, 0.5, 0.5)
    assert settings("G01 F100 X1\nM30") == DynamicSettings()


def test_the_weight_of_an_external_feed() -> None:
    assert settings("#FF = 50").external_feed == 0.5
    assert settings("#FF=0").external_feed == pytest.approx(0.001)
    assert settings("#FF 2000000").external_feed == 10_000.0


@pytest.mark.parametrize(
    ("text", "entry", "line"),
    [
        ("G131=-1", catalogue.WEIGHT_INVALID, 1),
        ("G130 X-5", catalogue.WEIGHT_INVALID, 1),
        ("G127", catalogue.AXIS_ARGUMENT, 1),
        ("G900 G901", catalogue.G_GROUP_TWICE, 1),
        ("G08 G09", catalogue.G_GROUP_TWICE, 1),
        ("G115=3", catalogue.LOOK_AHEAD_NUMBER, 1),
        ("G115=16", catalogue.LOOK_AHEAD_NUMBER, 1),
        ("G115=-2", catalogue.LOOK_AHEAD_NUMBER, 1),
        ("G116", catalogue.AXIS_ARGUMENT, 1),
        ("#SLOPE [TYPE=ROUND]", catalogue.WORD_UNKNOWN, 1),
        ("#SLOPE [NO_OPT=1]", catalogue.KEY_MISSING, 1),
        ("#SLOPE [TYPE=STEP NO_OPT=2]", catalogue.FLAG_VALUE, 1),
        ("#VECTOR LIMIT ON [ACC=0]", catalogue.LIMIT_INVALID, 1),
        ("#VECTOR LIMIT ON [FEED]", catalogue.KEY_MISSING, 1),
        ("#VECTOR LIMIT OFF []", catalogue.KEY_MISSING, 1),
        ("#TRANSVELMIN ON [-5]", catalogue.FEED_INVALID, 1),
        ("#OVERRIDE [FEED_FACT=0]", catalogue.OVERRIDE_RANGE, 1),
        ("#OVERRIDE [RAPID_FACT=201]", catalogue.OVERRIDE_RANGE, 1),
        ("#TANGFEED [RMIN=-1]", catalogue.RADIUS_NEGATIVE, 1),
    ],
)
def test_wrong_settings(text: str, entry: ErrorEntry, line: int) -> None:
    assert [(e, at) for e, at, _ in found(text + "\nM30")] == [(entry, line)]


@pytest.mark.spec("isg.add.dynamic-weight")
def test_dynamic_weight_needs_to_know_which() -> None:
    assert [e for e, _, _ in found("#DYNAMIC WEIGHT ON []")] == [catalogue.KEY_MISSING]


@pytest.mark.spec("isg.g.corner-deceleration")
@pytest.mark.parametrize(
    ("text", "entry", "line"),
    [
        ("G13", catalogue.CORNER_PARAMETERS, 1),
        ("#CORNER PARAM [DIST=5 UNIT=PERCENT FEED=50]\nG12 G13", catalogue.G_GROUP_TWICE, 2),
        ("#CORNER PARAM [DIST=0 UNIT=PERCENT FEED=50]", catalogue.CORNER_DISTANCE, 1),
        ("#CORNER PARAM [DIST=5 UNIT=PERCENT FEED=0]", catalogue.FEED_INVALID, 1),
        ("#CORNER PARAM [DIST=5 UNIT=SPEED FEED=50]", catalogue.WORD_UNKNOWN, 1),
        ("#CORNER PARAM [DIST=5 FEED=50]", catalogue.KEY_MISSING, 1),
    ],
)
def test_wrong_corner_deceleration(text: str, entry: ErrorEntry, line: int) -> None:
    assert [(e, at) for e, at, _ in found(text + "\nM30")] == [(entry, line)]
    assert not list(found("#CORNER PARAM [DIST=5 UNIT=PERCENT FEED=50]\nG13\nG01 X5 F100\nM30"))


@pytest.mark.spec("chan.exact-stop")
def test_rapid_moves_may_end_with_an_exact_stop() -> None:
    run = decode("G00 X1\nX2\nG01 F100 X3\nX4\nG00 X5", replace(SETUP, exact_stop_after_rapid=True))
    order = [type(block) for block in run.blocks if isinstance(block, Line | Polyline | ExactStop)]
    assert order == [Line, ExactStop, Line, ExactStop, Line, Line, Line, ExactStop]


# ---------------------------------------------------------------------------------------------------- feed axes


@pytest.mark.spec("isg.add.fgroup")
def test_f_is_the_speed_of_the_feed_axes() -> None:
    """The time of a block is the way of the feed axes over F; the queue measures along X Y Z."""
    assert feeds("G01 F1000\n#FGROUP [X]\nX3 Y4") == [pytest.approx(1000 * 5 / 3)]
    assert feeds("G01 F1000\n#FGROUP [X, Y]\nX3 Y4 Z12") == [pytest.approx(1000 * 13 / 5)]
    assert feeds("G01 F1000\n#FGROUP [C]\nX3 Y4 C10", FOUR) == [pytest.approx(1000 * 5 / 10)]
    assert feeds("G01 F1000\n#FGROUP [X,Y,Z,C]\nX3 C4", FOUR) == [pytest.approx(1000 * 3 / 5)]
    assert feeds("G01 F1000\n#FGROUP [X]\nY4") == [1000.0]  # no feed axis moves: the others as usual
    assert feeds("G01 F1000\n#FGROUP [X]\nX3 Y4\n#FGROUP\nX6 Y8") == [pytest.approx(1000 * 5 / 3), 1000.0]


@pytest.mark.spec("isg.add.fgroup", "chan.feed.feed-axes")
def test_the_usual_feed_axes_are_configured() -> None:
    setup = replace(SETUP, feed_group=FeedGroup((1.0, 0.0, 0.0)), feed_axes_configured=True)
    assert feeds("G01 F1000\nX3 Y4\n#FGROUP [X,Y,Z]\nX6 Y8\n#FGROUP\nX9 Y12", setup) == pytest.approx(
        [1000 * 5 / 3, 1000, 1000 * 5 / 3]
    )
    warned = decode("#FGROUP").decoder.warnings
    assert [problem.entry for problem in warned] == [catalogue.FEED_GROUP_DEFAULT]
    assert decode("#FGROUP", setup).decoder.warnings == []
    weakest = replace(SETUP, feed_group=FeedGroup(weakest=True), feed_axes_configured=True)
    assert feeds("G01 F1000\nX3 Y4", weakest) == [pytest.approx(1000 * 5 / 4)]


@pytest.mark.spec("isg.add.fgroup")
def test_circles_need_all_main_axes_or_none() -> None:
    assert feeds("G01 F1000\n#FGROUP [X,Y,Z]\nG02 X10 I5") == [1000.0]
    (feed,) = feeds("F1000\n#FGROUP [C]\nG02 X10 I5 C30", FOUR)
    assert feed == pytest.approx(1000 * 5 * math.pi / 30)
    for group in ("X", "X,Y", "X=2,Y=1,Z=1"):
        assert [e for e, _, _ in found(f"F1000\n#FGROUP [{group}]\nG02 X10 I5")] == [catalogue.FEED_GROUP_CIRCLE]


@pytest.mark.spec("isg.add.fgroup-factors")
def test_feed_axes_with_factors() -> None:
    assert feeds("G01 F1000\n#FGROUP [X=2, Y]\nX3 Y8") == [pytest.approx(1000 * math.hypot(3, 8) / 10)]
    assert feeds("G01 F1000\n#FGROUP [X=2,Y=2,Z=2]\nG02 X10 I5") == [500.0]
    for factor in ("0", "0.0001", "1001", "-1"):
        assert [e for e, _, _ in found(f"#FGROUP [X={factor}]")] == [catalogue.FEED_GROUP_FACTOR]


@pytest.mark.spec("isg.add.fgroup-rot")
def test_a_rotary_axis_at_its_radius() -> None:
    """The programs of the manual (lines 15679–15702): F is the speed at the radius."""
    (plain, turned) = feeds("G01 C180 F1000\n#FGROUP ROT [AX=C REF=10]\nG01 C360 F1000\n#FGROUP ROT", FOUR)
    assert plain == 1000.0
    assert turned == pytest.approx(5729.6, rel=1e-4)
    (diagonal,) = feeds("#FGROUP ROT[AX=C REF=10]\nG01 G91 X10 C57.295779 F1000", FOUR)
    assert diagonal == pytest.approx(1000 / math.sqrt(2))  # X and the circumference at the same speed
    assert feeds("F1000\n#FGROUP ROT [AX=C REF=10]\nG02 X10 I5\n#FGROUP\nG01 C10", FOUR) == [1000.0, 1000.0]
    assert [e for e, _, _ in found("#FGROUP ROT [AX=X REF=0]")] == [catalogue.FEED_GROUP_RADIUS]


@pytest.mark.spec("isg.add.fgroup-waxis")
def test_the_axis_with_the_longest_way_moves_at_f() -> None:
    assert feeds("#FGROUP WAXIS\nG01 F1000 X10 Y200") == [pytest.approx(1000 * math.hypot(10, 200) / 200)]


@pytest.mark.spec("isg.add.fgroup")
def test_end_feeds_and_feed_changes_count_for_the_feed_axes_too() -> None:
    run = decode("G01 F1000 X0.001\n#FGROUP [X]\nX3.001 Y4 E500\nG193 X6.001 Y8 F400\nG293 G02 X6.001 I5 F200")
    line = next(block for block in run.blocks if isinstance(block, Line) and block.end_feed)
    assert line.end_feed == pytest.approx(500 * 5 / 3)
    change = next(block for block in run.blocks if isinstance(block, Polyline) and block.one_block)
    assert change.feeds[[0, -1]] == pytest.approx([1000 * 5 / 3, 400 * 5 / 3], rel=0.02)


@pytest.mark.parametrize(
    "text", ["#FGROUP X", "#FGROUP []", "#FGROUP [X] Y", "#FGROUP [Q]", "#FGROUP [X", "#FGROUP ROT [AX=X]"]
)
def test_feed_axes_that_are_not_understood(text: str) -> None:
    assert len(list(found(text))) == 1


@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("X[OVERRIDE FEED_FACT=0]", catalogue.OVERRIDE_RANGE),
        ("X[OVERRIDE RAPID_FACT=500]", catalogue.OVERRIDE_RANGE),
        ("Q[OVERRIDE FEED_FACT=50]", catalogue.AXIS_UNKNOWN),
        ("X[OVERRIDE FEED_FACT=50", catalogue.BRACKET_OPEN),
        ("X[OVERRIDE FEED_FACT=50] Y1", catalogue.STATEMENT_ARGUMENTS),
    ],
)
def test_wrong_overrides_of_axes(text: str, entry: ErrorEntry) -> None:
    assert [e for e, _, _ in found(text)] == [entry]


@pytest.mark.spec("chan.ahead.no-chamfers")
@pytest.mark.parametrize("text", ["G01 F100 X5 G301=1\nY5", "G01 F100 X5\nG302 I1\nY5"])
def test_chamfers_and_roundings_can_be_switched_off(text: str) -> None:
    assert not list(found(text))
    assert [e for e, _, _ in found(text, replace(SETUP, no_corners=True))] == [catalogue.CORNERS_OFF]
