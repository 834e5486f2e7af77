"""What channel parameters say of feed, look-ahead and HSC at the start of a program."""

from __future__ import annotations

import numpy as np
import pytest

from runtime.cnc.blocks import Line, Polyline, Spline, SplineChange, SplineKind
from runtime.cnc.decoder import DecoderSetup
from runtime.config.loader import parse_machine
from tests.cnc.decoder.programs import Run, decode
from tests.cnc.interpolator.driving import drive, limits
from tests.config.machines import with_parameters

FEED = pytest.mark.spec("chan.start.feed")


def setup_of(parameters: str) -> DecoderSetup:
    return DecoderSetup.from_machine(parse_machine(with_parameters(parameters)))


def decoded(text: str, parameters: str) -> Run:
    setup = setup_of(parameters)
    return decode(text, setup, start=(0.0,) * len(setup.axes))


def feeds(text: str, parameters: str) -> list[float]:
    run = decoded(text, parameters)
    assert run.problem is None, run.problem
    found: list[float] = []
    for block in run.blocks:
        if isinstance(block, Line):
            found.append(block.feed)
        elif isinstance(block, Polyline):
            found.extend(block.feeds.tolist())
    return found


@FEED
def test_a_feed_block_without_f_takes_the_feed_of_the_channel() -> None:
    text = "G01 X1\nX2 F300\nX3\nM30"
    assert feeds(text, "prog_start.feedrate: 1500") == [1500.0, 300.0, 300.0]
    missing = decoded("G01 X1\nM30", "prog_start.feedrate: 0")
    assert missing.problem is not None


@FEED
@pytest.mark.parametrize(("factor", "unit"), [("100", 1.0), ("0.1", 1000.0), ("-1", 1.0), ("0", 1.0)])
def test_the_factor_is_the_unit_of_f(factor: str, unit: float) -> None:
    assert feeds("G01 X1 F2\nX2 F3.5\nM30", f"prog_start.feedrate_factor: {factor}") == [2.0 * unit, 3.5 * unit]


@pytest.mark.spec("chan.config.ipo-lookahead")
@pytest.mark.parametrize(
    "parameters",
    [
        "configuration.interpolator.function: FCT_IPO_DEFAULT|FCT_LOOK_AHEAD_LOW",
        "configuration.interpolator.number_blocks_lah: 30",
        "configuration.interpolator.blocks_per_call: 20",
    ],
)
def test_smaller_buffers_of_the_look_ahead_are_told_to_have_no_effect(parameters: str) -> None:
    machine = parse_machine(with_parameters(parameters))
    assert [warning.entry.id for warning in machine.warnings] == [302025]


@pytest.mark.spec("chan.config.ipo-lookahead")
def test_the_look_ahead_sees_as_far_as_braking_needs_and_stops_at_what_it_knows() -> None:
    """Braking from 200 mm/s at 500 mm/s² takes 40 mm and more: 800 moves of 0.05 mm."""
    run = decode("G01 F12000\n" + "\n".join(f"X{0.05 * k:.2f}" for k in range(1, 4001)) + "\nM30")
    result = drive(run.blocks, limits(250.0, 500.0, 20_000.0, 0.0), np.zeros(3), most=6000, keep_records=False)
    assert result.finished
    assert max(result.v) == pytest.approx(200.0, rel=1e-6)
    assert result.positions[-1][0] == pytest.approx(200.0, abs=1e-9)
    assert np.abs(np.array(result.a)).max() <= 500.0 * 1.001


def test_the_b_spline_begins_with_the_values_of_the_channel() -> None:
    parameters = (
        "hsc.bspline: {path_deviation: 100, track_deviation: 20000, max_path_length: 50000, max_angle: 900000, "
        "auto_off_g00: 1, auto_off_path: 1, auto_off_track: 1}"
    )

    def chosen(parameters: str, statement: str) -> Spline:
        run = decoded(f"{statement}\nG01 F1000 X1\nM30", parameters)
        assert run.problem is None
        change = next(block for block in run.blocks if isinstance(block, SplineChange))
        assert change.spline is not None
        return change.spline

    spline = chosen(parameters, "#HSC ON [BSPLINE]")
    assert spline.kind is SplineKind.HSC
    assert (spline.deviation, spline.tracking_deviation, spline.longest) == pytest.approx((0.01, 2.0, 5.0))
    assert spline.greatest_angle == pytest.approx(90.0)
    assert (spline.without_rapid, spline.sharp, spline.sharp_tracking) == (True, True, True)
    programmed = chosen(parameters, "#HSC ON [BSPLINE PATH_DEV=0.3 MAX_ANGLE=20 AUTO_OFF_PATH=0]")
    assert (programmed.deviation, programmed.greatest_angle, programmed.sharp) == (0.3, 20.0, False)
    usual = chosen("hsc.bspline.max_angle: 0", "#HSC ON [BSPLINE]")
    assert (usual.deviation, usual.tracking_deviation, usual.greatest_angle) == pytest.approx((0.2, 5.0, 160.0))
