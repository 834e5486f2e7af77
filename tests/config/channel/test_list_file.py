"""ISG list files of channel parameters: what a line can be, and what every mistake says at which place."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.config.channel.reading import parse_parameters
from runtime.config.loader import ConfigurationError, load_machine
from tests.config.machines import MACHINE, list_problems, machine_with_list, write_machine

LIST = """\
# Spindles, axes and technology of the mill
#==========================================
grp_anzahl                       1
gruppe[0].bezeichnung            main
gruppe[0].achs_anzahl            2
gruppe[0].achse[0].bezeichnung   X      first axis
gruppe[0].achse[0].log_achs_nr   1
gruppe[0].achse[1].bezeichnung   Y
gruppe[0].achse[1].log_achs_nr   2
gruppe[0].achse[1].default_feed_axis 1
spdl_anzahl                      1
spindel[0].bezeichnung           S
spindel[0].log_achs_nr           6
spindel[0].m3_synch              MVS_SVS | PLC_INFO   # with the order for the PLC
spindel[0].s_synch               MOS|PLC_INFO
main_spindle_ax_nr               6
main_spindle_name                S

m_synch[6]     MVS_SVS    0x00000002
m_synch[8]     0x00000004  MVS_SNS
m_synch[9]     1
m_synch[10]    0x00020001
m_synch[11]    NOT_VALID
h_synch[12]    MOS        (hole counter)
werkzeug.synch MVS_SVS    ; the older name
prog_start.g_gruppe[14].nr 91 (range: MASSANG)
prog_start.feedrate        1.5e3   mm/min
mittelpkt_diff             0x64    in 0.1µm
makro_def[4].symbol        CALC_P5
makro_def[4].nc_code       P5 = P2 + 3
makro_def[6].symbol        RELPOS1
makro_def[6].nc_code       G01 G91 X10 Y20 F100 # moves
makro_def[7].symbol        WAIT
makro_def[7].nc_code       #FLUSH WAIT
path[0].dir                "my programs"
path[0].id                 1
path[0].type               0x03
m6_prog_file               tool_change1
start_init_prog_file_mode  AUTOMATIC | MDI
configuration.decoder.msg_to_plc  WARNING
p_param_haltend            1
g800_prog_file[5]          pocket.nc
lin_aufloes                10000   a default of the manual
"""


@pytest.mark.spec("chan.list-syntax")
def test_a_list_is_taken_as_it_is(tmp_path: Path) -> None:
    machine = machine_with_list(tmp_path, LIST)
    assert machine.warnings == ()
    channel = machine.channels[0]
    parameters = channel.parameters
    (spindle,) = parameters.spindel
    assert (spindle.bezeichnung, spindle.m3_synch, spindle.s_synch) == ("S", "MVS_SVS | PLC_INFO", "MOS | PLC_INFO")
    assert parameters.m_synch == {6: "MVS_SVS", 8: "MVS_SNS", 9: "MOS", 10: "MOS | PLC_INFO", 11: "NOT_VALID"}
    assert parameters.h_synch == {12: "MOS"}
    assert parameters.tool.synch == "MVS_SVS"
    assert parameters.prog_start.g_functions == {14: 91}
    assert parameters.prog_start.feedrate == 1500.0
    assert parameters.centre_shift == pytest.approx(0.01)
    assert parameters.macros == {"CALC_P5": "P5 = P2 + 3", "RELPOS1": "G01 G91 X10 Y20 F100", "WAIT": "#FLUSH WAIT"}
    assert parameters.path[0].dir == str(tmp_path / "my programs")
    assert parameters.m6_prog_file == "tool_change1"
    assert parameters.start_init_prog_file_mode == "AUTOMATIC | MDI"
    assert parameters.configuration.decoder.msg_to_plc == "WARNING"
    assert parameters.p_param_haltend is True
    assert parameters.g_prog_files == {805: "pocket.nc"}
    assert parameters.feed_axes(2) == (1,)
    assert parameters.mittelpkt_faktor == 50  # not in the list: its default


MISTAKES = {
    # name: (line, id, column, part of the text)
    "unknown name": ("prog_start.feedrat 5", 302023, 1, "'prog_start.feedrate'"),
    "other letters": ("Mass_einh 0", 302023, 1, "'mass_einh'"),
    "parameter without its group": ("feedrate 5", 302023, 1, "feedrate"),
    "group without a parameter": ("spindel[0] S", 302027, 1, "spindel[0] is a group"),
    "no name": ("[0].x 5", 302028, 1, "'[0].x'"),
    "index outside": ("m_synch[1000] MOS", 302010, 1, "1000 is out of range; it must be 0 to 999"),
    "no value": ("  p_param_haltend", 302030, 3, "has no value"),
    "comment for a value": ("p_param_haltend # 1", 302030, 1, "has no value"),
    "text for a number": ("max_vb_override  high", 302008, 18, "a whole number is expected, not 'high'"),
    "fraction": ("mittelpkt_faktor 1.5", 302008, 18, "a whole number"),
    "out of range": ("max_vb_override 2001", 302010, 17, "it must be 0 to 2000"),
    "below the type": ("mittelpkt_faktor -1", 302010, 18, "1 to 65534"),
    "BOOLEAN of 2": ("p_param_haltend 2", 302008, 17, "0 or 1"),
    "number without end": (f"max_vb_override {'9' * 5000}", 302008, 17, "a whole number"),
    "index without end": (f"m_synch[{'9' * 5000}] MOS", 302028, 1, "has not the form"),
    "unknown keyword": ("configuration.decoder.msg_to_hmi WARN", 302015, 34, "'WARNING'?"),
    "unknown synchronisation": ("m_synch[8] MVS_SN", 302015, 12, "'MVS_SNS'?"),
    "unknown bit": ("m_synch[8] 0x10", 302015, 12, "0x10"),
    "two types": ("m_synch[8] MOS | MVS_SVS", 302022, 12, "exactly one"),
    "bar forgotten": ("m_synch[8] MVS_SVS PLC_INFO", 302031, 12, "'PLC_INFO' without a |"),
    "type of M functions only": ("tool.synch MVS_SLM", 302015, 12, "'MVS_SLM' is unknown"),
    "changes motion": ("lin_aufloes 1000", 302024, 13, "lin_aufloes (P-CHAN-00034"),
    "named in the manual only": ("t_with_tool_data_provide 1", 302024, 1, "P-CHAN-00322"),
    "twice": ("p_param_haltend 1\np_param_haltend 1", 302026, 1, "line 2 of the list"),
    "twice under an older name": ("tool.synch MOS\nwerkzeug.synch MOS", 302026, 1, "line 2"),
    "text too long": (f"m6_prog_file {'a' * 84}", 302016, 14, "at most 83"),
    "spindle without a name": ("spindel[0].s_synch MOS", 302007, 20, "spindel[0] lacks the key 'bezeichnung'"),
    "gap": ("spindel[1].bezeichnung S", 302033, 24, "spindel[0] is not"),
    "number of spindles": ("spdl_anzahl 2\nspindel[0].bezeichnung S", 302034, 13, "spdl_anzahl is 2"),
    "another main spindle": ("main_spindle_name M2\nspindel[0].bezeichnung S", 302034, 19, "first letter"),
    "spindle that is no axis": ("spindel[0].bezeichnung S2", 302013, 24, "'S2'"),
    "spindle that is a linear axis": ("spindel[0].bezeichnung X", 302021, 24, "its type is linear"),
    "logical number of a spindle": (
        "spindel[0].bezeichnung S\nspindel[0].log_achs_nr 7",
        302034,
        24,
        "log_axis of S is 6",
    ),
    "logical number of an axis": ("gruppe[0].achse[0].log_achs_nr 2", 302034, 32, "log_axis of X is 1"),
    "another axis": ("gruppe[0].achse[0].bezeichnung Z", 302034, 32, "is X"),
    "one axis more": ("gruppe[0].achse[2].default_feed_axis 1", 302034, 38, "not given"),
    "number of axes": ("gruppe[0].achs_anzahl 3", 302034, 23, "the number of axes is 2"),
    "two groups": ("grp_anzahl 0", 302010, 12, "it must be 1"),
}


@pytest.mark.parametrize(("text", "number", "column", "part"), MISTAKES.values(), ids=MISTAKES.keys())
@pytest.mark.spec("chan.list-syntax")
def test_a_mistake_is_told_at_its_place(tmp_path: Path, text: str, number: int, column: int, part: str) -> None:
    (problem,) = list_problems(tmp_path, "# comment\n" + text + "\n")
    assert problem.entry.id == number
    assert problem.place.file == str(tmp_path / "mill.lis")
    assert problem.place.column == column
    assert part in problem.text
    assert problem.place.text == ("# comment\n" + text).splitlines()[problem.place.line - 1]


def test_mistakes_of_the_description_come_first_and_all_are_told(tmp_path: Path) -> None:
    problems = list_problems(
        tmp_path, "lin_aufloes 1000\n[\np_param_haltend x\n", "    parameters: {m_synch: {8: MO}, x: 1}\n"
    )
    places = [(Path(problem.place.file).name, problem.place.line, problem.entry.id) for problem in problems]
    assert places == [
        ("machine.yaml", 10, 302015),
        ("machine.yaml", 10, 302023),
        ("mill.lis", 1, 302024),
        ("mill.lis", 2, 302028),
        ("mill.lis", 3, 302008),
    ]


def test_a_parameter_stands_in_the_list_or_in_the_description(tmp_path: Path) -> None:
    machine = machine_with_list(tmp_path, "m_synch[6] MOS\n", "    parameters: {m_synch: {8: MVS_SVS}}\n")
    assert machine.channels[0].parameters.m_synch == {6: "MOS", 8: "MVS_SVS"}
    (problem,) = list_problems(tmp_path, "m_synch[8] MOS\n", "    parameters: {m_synch: {8: MVS_SVS}}\n")
    assert (problem.entry.id, problem.place.line) == (302026, 1)
    assert "the machine description" in problem.text


def test_lists_that_cannot_be_read(tmp_path: Path) -> None:
    file = write_machine(tmp_path, "")
    for content, reason in ((None, "No such file"), (b"a\0b", "no text"), (b"#" * 1_000_001, "larger")):
        (tmp_path / "mill.lis").unlink()
        if content is not None:
            (tmp_path / "mill.lis").write_bytes(content)
        with pytest.raises(ConfigurationError) as caught:
            load_machine(file)
        (problem,) = caught.value.problems
        assert (problem.entry.id, problem.place.line, problem.place.column) == (302029, 9, 21)
        assert reason in problem.text
        (tmp_path / "mill.lis").touch()


def test_older_lists_are_latin_1_with_any_line_end(tmp_path: Path) -> None:
    (tmp_path / "mill.lis").write_bytes(b"mittelpkt_diff 100 in 0.1\xb5m\r\nmax_vb_override\t900\rp_param_haltend 1")
    (tmp_path / "m.yaml").write_text(MACHINE + "    parameter_list: mill.lis\n")
    parameters = load_machine(tmp_path / "m.yaml").channels[0].parameters
    assert (parameters.mittelpkt_diff, parameters.max_vb_override, parameters.p_param_haltend) == (100.0, 900, True)


@pytest.mark.parametrize(
    ("written", "code"),
    [
        ('#MSG ["a # b"]  G01  X1   ## moves', '#MSG ["a # b"]  G01  X1'),
        ("G01 X1 # moves", "G01 X1"),
        ("G01 #FLUSH WAIT", "G01 #FLUSH WAIT"),
        ("P1 = 2 ; 3", "P1 = 2 ; 3"),
        ("G01 #", "G01"),
    ],
)
def test_a_code_keeps_its_blanks_and_its_number_signs(written: str, code: str) -> None:
    parameters = parse_parameters(f"makro_def[0].symbol A\nmakro_def[0].nc_code   {written}\n")
    assert parameters.macros == {"A": code}
