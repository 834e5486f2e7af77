"""Machine descriptions: what is taken, and what every mistake says at which place."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from runtime.config.loader import DEMO_MACHINE, ConfigurationError, load_machine, parse_machine
from runtime.config.machine import SYNCH_FLAGS, SYNCH_TYPES, Axis, AxisType, Machine, UnitError, parse_quantity
from runtime.diagnostics.errors import Problem

GOOD = """\
name: test
axes:
  - name: X
    log_axis: 1
    velocity: 24 m/min
    acceleration: 4 m/s^2
    jerk: 60 m/s^3
    drive: {node: 1}
  - name: S
    type: spindle
    log_axis: 6
    velocity: 6000 rev/min
    acceleration: 6000 rev/min/s
    jerk: 60000
    drive: {node: 6}
channels:
  - name: mill
    axes: [X]
"""


def problems_of(text: str) -> tuple[Problem, ...]:
    with pytest.raises(ConfigurationError) as caught:
        parse_machine(text, file="m.yaml")
    return caught.value.problems


def changed(old: str, new: str) -> str:
    assert GOOD.count(old) == 1
    return GOOD.replace(old, new)


def test_the_demo_machine_and_the_example_are_taken() -> None:
    assert load_machine().name == "demo mill"
    assert load_machine(Path("config/machine.yaml")).fieldbus.bus.interface == "socketcan"


def test_the_example_shows_every_key() -> None:
    """Whoever adds a key to the description adds it to the example."""
    text = Path("config/machine.yaml").read_text(encoding="utf-8")

    def keys(schema: object) -> set[str]:
        found: set[str] = set()
        if isinstance(schema, dict):
            found |= set(schema.get("properties", {}))
            for value in schema.values():
                found |= keys(value)
        elif isinstance(schema, list):
            for value in schema:
                found |= keys(value)
        return found

    missing = [key for key in sorted(keys(Machine.model_json_schema())) if f"{key}:" not in text]
    assert missing == []


def test_units_are_converted_to_mm_degrees_and_seconds() -> None:
    machine = parse_machine(GOOD)
    assert machine.axes[0].velocity == pytest.approx(400.0)
    assert machine.axes[0].jerk == 60_000.0
    assert machine.axes[1].velocity == 36_000.0
    assert machine.axes[1].jerk == 60_000.0
    assert machine.axes[1].type is AxisType.SPINDLE
    assert parse_quantity("0.5 inch", "length") == pytest.approx(12.7)
    assert parse_quantity("2 m/s²", "acceleration") == 2000.0
    with pytest.raises(UnitError):
        parse_quantity("0.5 g", "acceleration")


def test_paths_count_from_the_folder_of_the_description(tmp_path: Path) -> None:
    file = tmp_path / "m.yaml"
    file.write_text(GOOD.replace("{node: 1}", "{node: 1, eds: servo.eds}") + "plc: {program: plc.py}\n")
    machine = load_machine(file)
    assert machine.axes[0].drive is not None
    assert machine.axes[0].drive.eds == str(tmp_path / "servo.eds")
    assert machine.plc.program == str(tmp_path / "plc.py")
    assert machine.channels[0].program_paths == (".",)
    file.write_text(GOOD + "plc: {program: 'package.module:Mill'}\n")
    assert load_machine(file).plc.program == "package.module:Mill"


MISTAKES = {
    # name: (changed from, to, id, line, column, part of the text)
    "wrong key": ("    jerk: 60 m/s^3", "    jerk: 60 m/s^3\n    velocity_stop: 5", 302006, 8, 5, "'velocity_step'"),
    "wrong key at the root": ("name: test", "name: test\nacces: []", 302006, 2, 1, "'axes'"),
    "missing key": ("    velocity: 24 m/min\n", "", 302007, 3, 5, "axes[0] lacks the key 'velocity'"),
    "text for a number": ("velocity: 24 m/min", "velocity: fast", 302008, 5, 15, "not 'fast'"),
    "number for a text": ("name: test", "name: 5", 302008, 1, 7, "text is expected"),
    "bool for a number": ("log_axis: 1", "log_axis: true", 302008, 4, 15, "whole number"),
    "fraction": ("log_axis: 1", "log_axis: 1.5", 302008, 4, 15, "whole number"),
    "list for a mapping": ("drive: {node: 1}", "drive: [1]", 302008, 8, 12, "not a list"),
    "nothing for a list": ("axes: [X]", "axes:", 302008, 18, 10, "not nothing"),
    "not a number": ("velocity: 24 m/min", "velocity: .nan", 302008, 5, 15, "finite"),
    "wrong unit": ("24 m/min", "24 m/s^2", 302009, 5, 15, "'m/s^2' is no unit of velocity"),
    "unknown unit": ("4 m/s^2", "0.5 g", 302009, 6, 19, "'g' is no unit of acceleration"),
    "angle at a linear axis": ("24 m/min", "24 rev/min", 302009, 5, 15, "'rev/min' is no unit of velocity"),
    "length at a spindle": ("6000 rev/min\n", "60 m/min\n", 302009, 12, 15, "'m/min' is no unit of angular velocity"),
    "node id too large": ("{node: 1}", "{node: 128}", 302010, 8, 19, "127 or less"),
    "velocity zero": ("24 m/min", "0 m/min", 302010, 5, 15, "greater than 0"),
    "limits reversed": (
        "    jerk: 60 m/s^3",
        "    jerk: 60 m/s^3\n    position_min: 1 m\n    position_max: 5",
        302011,
        8,
        19,
        "Axis X: the lower software limit 1000 is not below the upper one 5",
    ),
    "two axes on one node id": ("{node: 6}", "{node: 1}", 302012, 15, 19, "given to axis X and to axis S"),
    "axis on the node id of the master": ("{node: 6}", "{node: 127}", 302012, 15, 19, "the master"),
    "I/O on the node id of an axis": (
        "name: test",
        "name: test\nfieldbus: {io: [{node: 6}]}",
        302012,
        2,
        24,
        "fieldbus.io[0]",
    ),
    "unknown axis": ("axes: [X]", "axes: [X, Y]", 302013, 18, 15, "Channel mill uses axis 'Y'"),
    "axis twice in a channel": ("axes: [X]", "axes: [X, X]", 302013, 18, 15, "stands in the list already"),
    "unknown axis of a zero offset": (
        "axes: [X]",
        "axes: [X]\n    zero_offsets: {G54: {Z: 1}}",
        302013,
        19,
        26,
        "Zero offset G54",
    ),
    "axis name twice": ("name: S", "name: X", 302014, 9, 11, "Axis name 'X'"),
    "logical number twice": ("log_axis: 6", "log_axis: 1", 302014, 11, 15, "Logical axis number 1"),
    "unknown type": ("spindle", "spindel", 302015, 10, 11, "'spindle'?"),
    "unknown interface": ("name: test", "name: test\nfieldbus: {bus: {interface: can}}", 302015, 2, 29, "'can'"),
    "unknown synchronisation": (
        "axes: [X]",
        "axes: [X]\n    parameters: {m_synch: {8: MVS_SN}}",
        302015,
        19,
        31,
        "'MVS_SNS'?",
    ),
    "two synchronisation types": (
        "axes: [X]",
        "axes: [X]\n    parameters: {m_synch: {8: MOS | MVS_SNS}}",
        302022,
        19,
        31,
        "exactly one",
    ),
    "M number that does not exist": (
        "axes: [X]",
        "axes: [X]\n    parameters: {m_synch: {1000: MOS}}",
        302010,
        19,
        28,
        "999",
    ),
    "no axis in a channel": ("axes: [X]", "axes: []", 302016, 18, 11, "at least 1"),
    "axis name with R": ("name: X", "name: R1", 302017, 3, 11, "'R1'"),
    "zero offset that does not exist": (
        "axes: [X]",
        "axes: [X]\n    zero_offsets: {G60: {X: 1}}",
        302017,
        19,
        20,
        "'G60'",
    ),
    "a linear axis as spindle": (
        "axes: [X]",
        "axes: [X]\n    parameters: {spindel: [{bezeichnung: X}]}",
        302021,
        19,
        42,
        "its type is linear",
    ),
    "PLC watchdog shorter than its cycle": (
        "name: test",
        "name: test\nplc: {every: 10, watchdog: 5 ms}",
        302020,
        2,
        28,
        "PLC watchdog of 0.005 s",
    ),
    "option that is a list": (
        "name: test",
        "name: test\nfieldbus: {bus: {options: {a: [1]}}}",
        302008,
        2,
        31,
        "options.a",
    ),
}


@pytest.mark.parametrize(("old", "new", "number", "line", "column", "part"), MISTAKES.values(), ids=MISTAKES.keys())
def test_a_mistake_is_told_at_its_place(old: str, new: str, number: int, line: int, column: int, part: str) -> None:
    text = changed(old, new)
    (problem,) = problems_of(text)
    assert (problem.entry.id, problem.place.line, problem.place.column) == (number, line, column)
    assert part in problem.text
    assert problem.place.text == text.splitlines()[line - 1]
    assert str(problem).startswith(f"m.yaml:{line}:{column}: {number}: ")
    assert "hint" in problem.explained()


def test_every_mistake_is_told_in_the_order_of_the_file() -> None:
    text = changed("velocity: 24 m/min", "velocity: 24 m").replace("type: spindle", "type: round") + "color: red\n"
    assert [problem.entry.id for problem in problems_of(text)] == [302009, 302015, 302006]


YAML_MISTAKES = {
    "empty": ("", 302003, 0),
    "only a comment": ("# nothing\n", 302003, 0),
    "only text": ("hello", 302008, 1),
    "unclosed bracket": ("axes: [X\nname: y\n", 302004, 2),
    "two colons": ("name: a: b\n", 302004, 1),
    "tab": ("cycle:\n\tperiod: 1\n", 302004, 2),
    "second document": ("name: a\n---\nname: b\n", 302004, 2),
    "unknown alias": ("name: *a\n", 302004, 1),
    "nested too deeply": ("a: " + "[" * 5000, 302004, 0),
    "key twice": (GOOD + "name: again\n", 302005, 19),
    "inner key twice": (changed("{node: 1}", "{node: 1, node: 2}"), 302005, 8),
    "number key twice": ("a: {8: x, 0x8: y}", 302005, 1),
    "Python object": ("name: !!python/object/apply:os.system ['true']\n", 302018, 1),
    "local tag": ("name: !machine x\n", 302018, 1),
    "number tag on a text": ("name: !!int x\n", 302018, 1),
    "alias to itself": ("name: x\naxes: &a [*a]\n", 302019, 2),
    "control character": ("name: \x00\n", 302002, 0),
}


@pytest.mark.parametrize(("text", "number", "line"), YAML_MISTAKES.values(), ids=YAML_MISTAKES.keys())
def test_yaml_mistakes(text: str, number: int, line: int) -> None:
    problem = problems_of(text)[0]
    assert (problem.entry.id, problem.place.line) == (number, line)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    def number_of(path: Path) -> int:
        with pytest.raises(ConfigurationError) as caught:
            load_machine(path)
        assert caught.value.problem.place.file == str(path)
        return caught.value.problem.entry.id

    assert number_of(tmp_path / "missing.yaml") == 302001
    assert number_of(tmp_path) == 302001
    assert number_of(Path("/dev/zero")) == 302001
    (tmp_path / "binary.yaml").write_bytes(bytes(range(256)))
    assert number_of(tmp_path / "binary.yaml") == 302002
    (tmp_path / "empty.yaml").write_bytes(b"")
    assert number_of(tmp_path / "empty.yaml") == 302003


def test_words_of_yaml_1_1_are_text_and_numbers_are_decimal() -> None:
    text = GOOD + "fieldbus: {bus: {channel: on}, io: [{node: 010, inputs: [no, yes, 12:30], vendor_id: 0xFF}]}\n"
    machine = parse_machine(text)
    assert machine.fieldbus.bus.channel == "on"
    assert machine.fieldbus.io[0].inputs == ("no", "yes", "12:30")
    assert machine.fieldbus.io[0].node == 10
    assert machine.fieldbus.io[0].vendor_id == 255
    assert parse_machine(changed("24 m/min", "1e3")).axes[0].velocity == 1000.0


def test_merge_keys_give_common_values_and_own_ones_win() -> None:
    text = changed("  - name: S", "  - &s\n    name: S").replace(
        "channels:", "  - {<<: *s, name: A, log_axis: 7}\nchannels:"
    )
    (problem,) = problems_of(text)
    assert problem.entry.id == 302012  # the drive came along, with its node id
    machine = parse_machine(text.replace("log_axis: 7}", "log_axis: 7, drive: {node: 7}}"))
    assert (machine.axes[2].name, machine.axes[2].velocity) == ("A", 36_000.0)


def test_synchronisation_types_are_those_of_the_blocks() -> None:
    from runtime.cnc.blocks import Synch

    assert set(SYNCH_TYPES + SYNCH_FLAGS) == set(Synch.__members__)


def test_the_demo_machine_is_found_without_importing_the_demo() -> None:
    code = "import sys; from runtime.config import loader; loader.load_machine(); print('runtime.demo' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=os.getcwd())
    assert done.stdout.strip() == "False"
    assert yaml.safe_load(DEMO_MACHINE.read_text())["name"] == "demo mill"


def test_an_axis_made_in_code_is_checked_too() -> None:
    with pytest.raises(ValueError, match="lower software limit"):
        Axis(name="X", log_axis=1, velocity=1, acceleration=1, jerk=1, position_min=2.0, position_max=1.0)
