"""What channel parameters say of feed, look-ahead and HSC at the start of a program."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from runtime.cnc.blocks import (
    Line,
    Polyline,
    RadiusCompensation,
    Spline,
    SplineChange,
    SplineKind,
    Synch,
    Technology,
    TechnologyFunction,
)
from runtime.cnc.decoder import DecoderSetup, SpindleSetup
from runtime.config.loader import parse_machine
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.programs import SETUP, Run, decode, problems
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


# ---------------------------------------------------------------------------------------------------- G and M functions


def begun(text: str, parameters: str) -> Run:
    """A mill with three axes and a spindle, and these functions at program start."""
    chosen = setup_of(parameters)
    spindle = SpindleSetup("S", Synch.MOS, {3: Synch.MOS, 4: Synch.MOS, 5: Synch.MOS})
    return decode(text, replace(SETUP, spindles=(spindle,), start_g=chosen.start_g, start_m=chosen.start_m))


G_AT_START = pytest.mark.spec("chan.start.g-functions")


@G_AT_START
@pytest.mark.parametrize(
    ("group", "number", "text"),
    [
        (0, 0, "X10 Y5\nX3 Z4\nM30"),
        (0, 1, "F1000 X10 Y5\nX3 Z4\nM30"),
        (0, 2, "F1000 X10 Y10 I5 J5\nM30"),
        (0, 3, "F1000 X10 Y10 I5 J5\nM30"),
        (4, 17, "G02 F1000 X10 Y10 I5 J5\nM30"),
        (4, 18, "G02 F1000 X10 Z10 I5 K5\nM30"),
        (4, 19, "G02 F1000 Y10 Z10 J5 K5\nM30"),
        (12, 70, "G01 F1000 X10\nM30"),
        (12, 71, "G01 F1000 X10\nM30"),
        (14, 90, "G01 F1000 X10\nX10\nX4\nM30"),
        (14, 91, "G01 F1000 X10\nX10\nX4\nM30"),
        (23, 161, "G01 F1000 X10 Y10\nG02 X20 Y20 I20 J10\nM30"),
        (23, 162, "G01 F1000 X10 Y10\nG02 X20 Y20 I10 J0\nM30"),
        (25, 164, "G02 F1000 X10 Y10.0001 I5 J5\nM30"),
        (25, 165, "G02 F1000 X10 Y10.0001 I5 J5\nM30"),
        (8, 52, "G01 F1000 X10\nM30"),
        (21, 137, "G01 F1000 X10\nM30"),
        (32, 140, "G01 F1000 X10\nM30"),
        (22, 139, "V.G.WZ_AKT.R = 2\nG41 G01 F1000 X10 Y5\nX30\nG40 X40\nM30"),
        (22, 237, "V.G.WZ_AKT.R = 2\nG41 G01 F1000 X10 Y5\nX30\nG40 X40\nM30"),
        (6, 26, "V.G.WZ_AKT.R = 2\nG139 G41 G01 F1000 X10\nY30\nX0\nG40 X-9\nM30"),
    ],
)
def test_a_g_function_holds_from_program_start_as_if_it_stood_in_the_first_line(
    group: int, number: int, text: str
) -> None:
    at_start = begun(text, f"prog_start: {{g_gruppe: {{{group}: {{nr: {number}}}}}}}")
    ends_nothing = number in (52, 137)  # what they would end is not there, so they are no words either
    programmed = begun(text if ends_nothing else f"G{number} {text}", "prog_start.feedrate: 0")
    first = begun(text, "prog_start.feedrate: 0")
    for run in (at_start, programmed):
        assert run.problem is None, run.problem
    assert shapes(at_start) == shapes(programmed)
    if number not in (1, 3, 17, 52, 71, 90, 137, 140, 162, 165, 139):  # another one than is built in
        assert first.problem is not None or shapes(first) != shapes(at_start)


def shapes(run: Run) -> list[object]:
    """The blocks without the places in the text that they come from."""
    rows: list[object] = [{key: value for key, value in row.items() if key not in ("line", "n")} for row in run.rows]
    return rows + [replace(block, source=None) for block in run.blocks if isinstance(block, RadiusCompensation)]  # type: ignore[arg-type]


@G_AT_START
def test_without_a_choice_the_built_in_ones_hold() -> None:
    text = "G01 F1000 X10\nX10\nG02 X20 Y10 I5 J5\nM30"
    chosen = "prog_start: {g_gruppe: {14: {nr: -1}, 4: {nr: -1}}}"
    assert shapes(begun(text, chosen)) == shapes(begun(text, "prog_start.feedrate: 0"))


@G_AT_START
@pytest.mark.parametrize("number", [51, 141])
def test_what_the_language_does_not_have_is_refused_by_name_at_program_start(number: int) -> None:
    group = {51: 8, 141: 32}[number]
    run = begun("G01 F1000 X10\nM30", f"prog_start: {{g_gruppe: {{{group}: {{nr: {number}}}}}}}")
    assert run.problem is not None
    assert f"G{number}" in run.problem.text


@pytest.mark.spec("chan.start.m-functions")
@pytest.mark.parametrize(("number", "sense"), [(-1, 0), (5, 0), (3, 3), (4, 4)])
def test_the_spindle_turns_with_the_first_speed_if_the_channel_says_so(number: int, sense: int) -> None:
    run = begun("G01 F1000 X1\nS500\nS600\nM5\nS700\nM30", f"prog_start: {{m_gruppe: {{0: {{nr: {number}}}}}}}")
    assert run.problem is None, run.problem
    functions = [
        (block.number, block.value, block.sense)
        for block in run.blocks
        if isinstance(block, TechnologyFunction) and block.kind is Technology.S
    ]
    assert functions == [(0, 500.0, sense), (0, 600.0, 0), (5, 600.0, 0), (0, 700.0, 0)]


# ---------------------------------------------------------------------------------------------------- limits

LIMITS = pytest.mark.spec("chan.config.decoder-limits")
_SUBPROGRAMS = "%L A\nM17\n%L B\nM17\n%L C\nM17\n%MAIN\nLL A\nM30"


@LIMITS
def test_the_limits_of_the_channel_are_those_of_the_decoder() -> None:
    """They act where other tests show it: macros, labels, P parameters, V.CYC, tool lists."""
    usual = setup_of("prog_start.feedrate: 0")
    assert (usual.limits.parameters, usual.limits.macros) == (1000, 100)
    assert (usual.limits.macro_name, usual.limits.macro_content, usual.limits.cycle_memory) == (30, 80, 8000)
    assert (usual.rules.labels, usual.rules.names, usual.rules.local_programs) == (200, 200, 50)
    chosen = setup_of(
        "configuration: {decoder: {p_param_number: 5, macro_number: 60, macro_symbol_len: 7, macro_nc_code_len: 9,"
        " var_memory: 100, string_label_number: 3, expression_label_number: 4, max_local_subroutine_definitions: 2}}"
    )
    assert (chosen.limits.parameters, chosen.limits.macros) == (5, 60)
    assert (chosen.limits.macro_name, chosen.limits.macro_content, chosen.limits.cycle_memory) == (7, 9, 8100)
    assert (chosen.rules.labels, chosen.rules.names, chosen.rules.local_programs) == (4, 3, 2)


@LIMITS
def test_a_file_with_too_many_local_subprograms_is_refused_before_it_starts() -> None:
    limited = replace(SETUP, rules=setup_of("configuration.decoder.max_local_subroutine_definitions: 2").rules)
    (problem,) = problems(_SUBPROGRAMS, limited)
    assert (problem.entry, problem.place.line) == (catalogue.LOCAL_PROGRAMS_MANY, 5)
    assert problems(_SUBPROGRAMS, replace(SETUP, rules=replace(limited.rules, local_programs=3))) == []


@LIMITS
@pytest.mark.parametrize(
    ("text", "parameter", "entry"),
    [
        ("P1 = 1\nP2 = 2\nP3 = 3\nM30", "p_param_number: 2", catalogue.VARIABLE_LIMIT),
        ('"AB" = "X1"\n"ABC" = "X1"\nM30', "macro_symbol_len: 2", catalogue.MACRO_LIMIT),
        ('"AB" = "X1 Y1"\nM30', "macro_nc_code_len: 4", catalogue.MACRO_LIMIT),
        (
            '"A" = "X1"\n"B" = "X1"\n"C" = "X1"\nM30',
            "macro_number: 2, macro_definition_number: 1",
            catalogue.MACRO_LIMIT,
        ),
    ],
)
def test_what_goes_beyond_a_limit_is_an_error(text: str, parameter: str, entry: ErrorEntry) -> None:
    limits = setup_of(f"configuration: {{decoder: {{{parameter}}}}}").limits
    found = [problem.entry for problem in problems(text, replace(SETUP, limits=limits))]
    if not found:
        problem = decode(text, replace(SETUP, limits=limits)).problem
        assert problem is not None
        found = [problem.entry]
    assert found == [entry]
