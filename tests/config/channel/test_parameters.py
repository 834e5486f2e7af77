"""Channel parameters in the YAML tree: mistakes at their place, what the typed tree says, what belongs together."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.config.channel import PathKind
from runtime.config.loader import load_machine, parse_machine
from runtime.diagnostics.catalogue import configuration as errors
from tests.config.machines import MACHINE, machine_with_list, parameters_of, problems_of, with_parameters


def test_the_tree_can_be_written_in_several_ways() -> None:
    tree = parameters_of("prog_start: {feedrate: 100, g_gruppe: {14: {nr: 91}}}\nm_synch: {8: MOS}")
    flat = parameters_of("prog_start.feedrate: 100\nprog_start.g_gruppe[14].nr: 91\n'm_synch[8]': 0x1")
    assert (tree.prog_start, tree.m_synch) == (flat.prog_start, flat.m_synch)
    assert (flat.prog_start.feedrate, flat.prog_start.g_functions, flat.m_synch) == (100.0, {14: 91}, {8: "MOS"})


def test_without_parameters_the_defaults_of_the_manual_hold() -> None:
    parameters = parse_machine(MACHINE).channels[0].parameters
    assert parameters.centre_shift == pytest.approx(2.0)
    assert parameters.centre_shift_share == 0.05
    assert parameters.radius_difference == 0.0
    assert parameters.prog_start.feed_unit == 1.0
    assert parameters.create_cycle_param_on_read is True
    assert parameters.configuration.decoder.tools == 200
    assert parameters.feed_axes(5) == (0, 1, 2)
    assert parameters.feed_axes(2) == (0, 1)
    assert parameters.g_prog_files == {}


def test_values_in_use() -> None:
    parameters = parameters_of(
        "max_radius_diff_circle: 100\nmax_proz_radius_diff_circle: 10\nprog_start.feedrate_factor: 0.1\n"
        "g81_prog_file: drill.nc\ng800_prog_file: [face.nc, pocket.nc]\nconfiguration.decoder.max_number_of_tools: 5\n"
        "final_prog_file_mode: MDI|AUTOMATIC\nrange_check_prog_soft_limits: true"
    )
    assert parameters.radius_difference == pytest.approx(0.01)
    assert parameters.radius_difference_share == 0.01
    assert parameters.prog_start.feed_unit == 1000.0
    assert parameters.g_prog_files == {81: "drill.nc", 800: "face.nc", 801: "pocket.nc"}
    assert parameters.configuration.decoder.tools == 5
    assert parameters.final_prog_file_mode == "MDI | AUTOMATIC"
    assert parameters.range_check_prog_soft_limits is True


MISTAKES = {
    # name: (parameters, id, line, column, part of the text); the parameters begin in line 10, column 7
    "unknown group": ("prog_strt: {feedrate: 1}", 302023, 10, 7, "'prog_start'"),
    "unknown name in a group": (
        "prog_start:\n  feedrat: 1",
        302023,
        11,
        9,
        "no parameter of prog_start; do you mean 'fe",
    ),
    "unknown name in a list": ("spindel:\n  - {bezeichnung: S, m3_sync: MOS}", 302023, 11, 28, "'m3_synch'"),
    "key that is no name": ("true: 1", 302023, 10, 7, "True"),
    "text for an index": ("m_synch: {M8: MOS}", 302023, 10, 17, "no parameter of m_synch"),
    "one value for an array": ("m_synch: MOS", 302027, 10, 7, "m_synch is a group"),
    "mapping for a value": ("mass_einh: {a: 1}", 302008, 10, 18, "not a mapping"),
    "nothing": ("max_vb_override:", 302008, 10, 23, "not nothing"),
    "text for a number": ("max_vb_override: '900'", 302008, 10, 24, "not '900'"),
    "number for a text": ("m6_prog_file: 6", 302008, 10, 21, "text is expected, not 6"),
    "truth for a number": ("max_vb_override: true", 302008, 10, 24, "whole number"),
    "infinite": ("mittelpkt_diff: .inf", 302008, 10, 23, "finite"),
    "out of range": ("mittelpkt_diff: -1", 302010, 10, 23, "0 or more"),
    "index outside": ("g800_prog_file: {40: a}", 302010, 10, 24, "0 to 39"),
    "not supported": ("log_number_tracking_axis: 1", 302024, 10, 33, "P-CHAN-00095"),
    "written twice": ("tool: {synch: MOS}\nwerkzeug: {synch: MOS}", 302026, 11, 18, "werkzeug.synch is given twice"),
    "feed unit": ("prog_start.feedrate_factor: 60", 302010, 10, 35, "0 or less or 0.1 or 100"),
    "no start function of the group": (
        "prog_start: {g_gruppe: {4: {nr: 90}}}",
        302015,
        10,
        39,
        "g_gruppe[4].nr: 90 is unknown",
    ),
    "group without start functions": ("prog_start: {g_gruppe: {5: {nr: 40}}}", 302015, 10, 39, "g_gruppe[5].nr: 40"),
    "macro without a code": ("makro_def: [{symbol: A}]", 302007, 10, 28, "lacks the key 'nc_code'"),
    "macro twice": (
        "makro_def: [{symbol: A, nc_code: G0}, {symbol: A, nc_code: G1}]",
        302035,
        10,
        54,
        "like that of makro_def[0]",
    ),
    "macro name too long": (f"makro_def: [{{symbol: {'A' * 31}, nc_code: G0}}]", 302016, 10, 28, "at most 30"),
    "macro code too long": (f"makro_def: [{{symbol: A, nc_code: {'A' * 81}}}]", 302016, 10, 40, "macro_nc_code_len"),
    "too many macros": (
        "configuration: {decoder: {macro_definition_number: 1}}\nmakro_def:\n"
        "  - {symbol: A, nc_code: G0}\n  - {symbol: B, nc_code: G1}",
        302016,
        13,
        20,
        "at most 1 are possible",
    ),
    "more macros of the list than of all": (
        "configuration.decoder.macro_number: 20",
        302010,
        10,
        43,
        "less than macro_number",
    ),
    "folder without a kind": ("path: [{dir: a}]", 302007, 10, 20, "path[0] lacks the key 'type'"),
    "folder twice": ("path: [{dir: a, type: 1, id: 1}, {dir: b, type: 2, id: 1}]", 302035, 10, 62, "path[1].id"),
    "priority twice": ("path: [{dir: a, type: 3}, {dir: b, type: 2}]", 302036, 10, 39, "type 0x02"),
}


@pytest.mark.spec("chan.paths", "chan.macros")
@pytest.mark.parametrize(("yaml", "number", "line", "column", "part"), MISTAKES.values(), ids=MISTAKES.keys())
def test_a_mistake_is_told_at_its_place(yaml: str, number: int, line: int, column: int, part: str) -> None:
    (problem,) = problems_of(with_parameters(yaml))
    assert (problem.entry.id, problem.place.line, problem.place.column) == (number, line, column)
    assert part in problem.text
    assert "hint" in problem.explained()


@pytest.mark.spec("chan.macros")
def test_limits_of_macros_can_be_raised() -> None:
    parameters = parameters_of(
        "configuration: {decoder: {macro_number: 300, macro_definition_number: 200, macro_symbol_len: 128}}\n"
        f"makro_def: {{199: {{symbol: {'A' * 128}, nc_code: G0}}}}"
    )
    assert parameters.macros == {"A" * 128: "G0"}


def test_what_has_no_effect_is_told_as_a_warning(tmp_path: Path) -> None:
    machine = machine_with_list(
        tmp_path, "rpf_prozess_zeit 500\n", "    parameters: {aep: {output_mode: 1}, prog_start.feedrate_factor: 0}\n"
    )
    told = [(Path(warning.place.file).name, warning.place.line, warning.entry.id) for warning in machine.warnings]
    assert told == [("machine.yaml", 10, 302025), ("machine.yaml", 10, 302038), ("mill.lis", 1, 302025)]
    assert "P-CHAN-00024" in machine.warnings[0].text
    assert machine.channels[0].parameters.prog_start.feed_unit == 1.0


def test_a_feed_unit_of_minus_1_is_mm_per_minute_without_a_warning() -> None:
    machine = parse_machine(with_parameters("prog_start.feedrate_factor: -1"))
    assert machine.warnings == ()
    assert machine.channels[0].parameters.prog_start.feedrate_factor == 100.0


@pytest.mark.spec("chan.paths")
def test_folders_are_searched_by_kind_and_priority(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(
        with_parameters(
            "path:\n"
            "  - {dir: last, type: 0x03, priority: 7}\n"
            "  - {dir: /cycles, type: 2, priority: 0}\n"
            "  - {dir: out, type: 0x0C, priority: 0}\n"
        )
    )
    channel = load_machine(tmp_path / "m.yaml").channels[0]
    assert channel.folders(PathKind.MAIN) == (str(tmp_path / "last"),)
    assert channel.folders(PathKind.SUBROUTINE) == ("/cycles", str(tmp_path / "last"))
    assert channel.folders(PathKind.MESSAGES) == (str(tmp_path / "out"),)
    assert channel.folders(PathKind.DEBUG) == (str(tmp_path / "out"),)


def test_without_path_parameters_program_paths_hold_programs(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(MACHINE + "    program_paths: [a, b]\n")
    channel = load_machine(tmp_path / "m.yaml").channels[0]
    assert channel.folders(PathKind.MAIN) == channel.folders(PathKind.SUBROUTINE) == channel.program_paths
    assert channel.program_paths == (str(tmp_path / "a"), str(tmp_path / "b"))
    assert channel.folders(PathKind.MESSAGES) == ()


def test_program_paths_and_path_parameters_exclude_each_other() -> None:
    text = with_parameters("path: [{dir: a, type: 3}]") + "    program_paths: [b]\n"
    (problem,) = problems_of(text)
    assert (problem.entry.id, problem.place.line, problem.place.column) == (302037, 11, 5)


@pytest.mark.spec("chan.weight.path", "chan.weight.radius")
def test_weights_by_length_and_radius() -> None:
    parameters = parameters_of(
        "dynamic_weighting_active: 3\n"
        "dynamic_weighting: [{path_limit: 10000, velocity_fact: 100, acceleration_fact: 1000, ramp_time_fact: 2000},"
        " {path_limit: 20000, velocity_fact: 500, acceleration_fact: 900, ramp_time_fact: 1000}]\n"
        "curve_dynamic_weighting: [{radius_limit: 50, velocity_fact: 11, acceleration_fact: 12, ramp_time_fact: 13}]"
    )
    assert parameters.dynamic_weighting_active == 3
    assert [row.limit for row in parameters.dynamic_weighting.values()] == [1.0, 2.0]
    assert parameters.dynamic_weighting[0].factors == (0.1, 1.0, 2.0)
    assert parameters.curve_dynamic_weighting[0].limit == pytest.approx(0.005)
    assert parameters.curve_dynamic_weighting[0].factors == pytest.approx((0.011, 0.012, 0.013))


@pytest.mark.spec("chan.weight.path")
@pytest.mark.parametrize(
    ("rows", "id_"),
    [
        ("{1: {path_limit: 1, velocity_fact: 11, acceleration_fact: 11, ramp_time_fact: 11}}", 302033),
        ("{0: {path_limit: 1, velocity_fact: 11, acceleration_fact: 11}}", errors.KEY_MISSING.id),
        ("[{path_limit: 5, velocity_fact: 11, acceleration_fact: 11, ramp_time_fact: 11},"
         " {path_limit: 5, velocity_fact: 11, acceleration_fact: 11, ramp_time_fact: 11}]", errors.OUT_OF_RANGE.id),
    ],
)  # fmt: skip
def test_weights_that_do_not_fit_together(rows: str, id_: int) -> None:
    problems = problems_of(with_parameters(f"dynamic_weighting: {rows}"))
    assert [problem.entry.id for problem in problems] == [id_]


@pytest.mark.spec("chan.vector-limit")
def test_path_limits_and_their_unit() -> None:
    usual = parameters_of("prog_start.feedrate: 0").vector
    assert usual.per_square_second("acceleration") == pytest.approx(1e8 / 3600)
    given = parameters_of("vector: {acc_dec_unit: MM_S2, acceleration: 500}").vector
    assert given.per_square_second("acceleration") == 500.0
    assert given.per_square_second("deceleration") == pytest.approx(1e8 / 3600)


@pytest.mark.spec("chan.start.slope")
def test_the_slope_that_is_not_given_is_not_step() -> None:
    """The register's own default would let the jerk go: axes are described with a jerk."""
    assert parameters_of("prog_start.feedrate: 0").prog_start.slope.profile is None
    assert parameters_of("prog_start.slope.profile: 0").prog_start.slope.profile == 0
