"""Bad input through the `tandem` command: an error id, a place, exit code 1, no traceback, and nothing has moved."""

from __future__ import annotations

import json
import os
import signal
import threading
from dataclasses import dataclass
from pathlib import Path

import pytest
import yaml

from runtime.cli import main as cli
from runtime.config.loader import DEMO_MACHINE

Capture = pytest.CaptureFixture[str]

LOOP = "%X\nN10 P1 = 1\nN20 $WHILE P1 > 0\nN30   P1 = P1 + 1\nN40 $ENDWHILE\nN50 M30\n"


def run(capsys: Capture, *arguments: object) -> tuple[int, str]:
    """Exit code, and everything printed."""
    capsys.readouterr()
    code = cli.main([str(argument) for argument in arguments])
    captured = capsys.readouterr()
    assert "Traceback" not in captured.err + captured.out
    return code, captured.out + captured.err


# ---------------------------------------------------------------------------------------------------- programs

PROGRAMS: dict[str, tuple[bytes, str]] = {
    # what is wrong: program, `line:column: id` that is told
    "empty file": (b"", " 300003"),
    "binary file": (b"\x7fELF\x02\x01\x00\x00", " 300004"),
    "unclosed bracket": (b"%X\nG01 F100 X[1 + 2\nM30\n", "2:11: 300023"),
    "unclosed comment in a comment": (b"%X\nG01 X1 F100 (a (b)\nM30 )\n", "3:5: 300026"),
    "unknown G": (b"%X\nN10 G987 X1\nM30\n", "2:5: 300032"),
    "two G of one group": (b"%X\nN10 G00 G01 X1 F100\nM30\n", "2:9: 300034"),
    "missing circle centre": (b"%X\nN10 G17 G02 X1 F100\nM30\n", "2:13: 300093"),
    "radius too small": (b"%X\nN10 G17 G02 X10 R1 F100\nM30\n", "2:13: 300094"),
    "beyond a software limit": (b"%X\nN10 G00 X10 Z300\nM30\n", "2:13: 301001"),
    "beyond a software limit in a plain run": (b"%X\nN10 G01 F100\nX10 Y1\nX-51\nX20\nM30\n", "4:1: 301001"),
    "arc beyond a software limit": (b"%X\nN10 G17 G162 F100\nN20 G02 X80 Y0 I40 J0\nN30 G02 X-40 I-60\nM30\n", "4:1: 301001"),
    "F0": (b"%X\nN10 G01 X1 F0\nM30\n", "2:12: 300091"),
    "no F": (b"%X\nN10 G01 X1\nM30\n", "2:9: 300090"),
    "division by zero": (b"%X\nN10 G01 X[1 / 0] F100\nM30\n", "2:13: 300055"),
    "missing local subprogram": (b"%X\nN10 LL NONE\nM30\n", "2:5: 300012"),
    "missing global subprogram": (b"%X\nN10 L none.nc\nM30\n", "2:5: 300013"),
    "recursion without end": (b"%L A\nN10 LL A\nM17\n%X\nN10 LL A\nM30\n", "2:5: 300080"),
    "M function that is not configured": (b"%X\nN10 M777\nM30\n", "2:5: 300070"),
}  # fmt: skip


@pytest.mark.parametrize("what", list(PROGRAMS))
def test_a_wrong_program_is_refused_by_check_and_simulate(tmp_path: Path, capsys: Capture, what: str) -> None:
    content, told = PROGRAMS[what]
    program = tmp_path / "wrong.nc"
    program.write_bytes(content)
    for arguments in (("check",), ("simulate", "--ideal-axes", "--trace", tmp_path / "trace")):
        code, text = run(capsys, *arguments, program)
        assert code == 1
        assert f"{program}:{told}:" in text, text
    summary = json.loads((tmp_path / "trace" / "summary.json").read_text())
    assert any(f":{told}:" in error for error in summary["errors"])
    before_the_fault = {"beyond a software limit in a plain run": 10.0, "arc beyond a software limit": 80.0}
    assert summary["positions"]["X"] == pytest.approx(before_the_fault.get(what, 0.0)), "the faulty block has not moved"


def test_a_missing_file(tmp_path: Path, capsys: Capture) -> None:
    for command in ("check", "simulate", "blocks"):
        code, text = run(capsys, command, tmp_path / "none.nc")
        assert code == 1
        assert "300001" in text
        assert "none.nc" in text


def test_a_software_limit_names_axis_limit_and_value(tmp_path: Path, capsys: Capture) -> None:
    program = tmp_path / "far.nc"
    program.write_text("%X\nN10 G54 G00 X600\nM30\n")
    code, text = run(capsys, "check", program)
    assert code == 1
    assert "axis X, 700.0000" in text
    assert "position_max = 650.0000" in text


def test_an_error_in_a_global_subprogram_names_its_file(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "sub.nc").write_text("%SUB\nN10 G01 X[1 / 0] F100\nM17\n")
    program = tmp_path / "main.nc"
    program.write_text("%X\nN10 L sub.nc\nM30\n")
    description = yaml.safe_load(DEMO_MACHINE.read_text())
    description["channels"][0]["program_paths"] = [str(tmp_path)]
    machine = tmp_path / "machine.yaml"
    machine.write_text(yaml.safe_dump(description))
    for arguments in (("check",), ("simulate", "--ideal-axes")):
        code, text = run(capsys, *arguments, "-c", machine, program)
        assert code == 1
        assert "sub.nc:2:13: 300055" in text


def test_an_endless_loop_is_found_by_check(tmp_path: Path, capsys: Capture) -> None:
    program = tmp_path / "endless.nc"
    program.write_text(LOOP)
    code, text = run(capsys, "check", program)
    assert code == 1
    assert "300081" in text


@pytest.mark.parametrize("options", [[], ["--ideal-axes"]])
def test_an_endless_loop_in_simulate_can_be_interrupted(tmp_path: Path, capsys: Capture, options: list[str]) -> None:
    program = tmp_path / "endless.nc"
    program.write_text(LOOP)
    over = threading.Event()

    def press() -> None:
        """Ctrl-C, again if it came at a moment that does not heed it, as while a kernel is loaded."""
        pause = 1.0
        while not over.wait(pause):
            os.kill(os.getpid(), signal.SIGINT)
            pause = 10.0

    signal.signal(signal.SIGINT, signal.default_int_handler)  # whoever started the tests may ignore it
    interrupts = threading.Thread(target=press)
    interrupts.start()
    try:
        code, _ = run(capsys, "simulate", *options, program)
    finally:
        over.set()
        interrupts.join()
    assert code == 130


# ---------------------------------------------------------------------------------------------------- machine descriptions


@dataclass(frozen=True)
class Change:
    """A piece of the demo machine's description, what it is replaced by, and what is told."""

    old: str
    new: str
    told: str


DESCRIPTIONS = {
    "wrong key": Change("    jerk: 60 m/s^3\n", "    jerc: 60 m/s^3\n", "302006"),
    "wrong type": Change("  period: 1 ms", "  period: [1]", "302008"),
    "wrong unit": Change("    velocity: 24 m/min", "    velocity: 24 kg", "302009"),
    "two axes on one node id": Change("drive: {node: 2,", "drive: {node: 1,", "302012"),
    "no YAML": Change("name: demo mill", "name: [demo", "302004"),
    "wrong vendor": Change("vendor_id: 0x7A4D, product_code: 0x402}\n  - name: Y",
                           "vendor_id: 0x1234, product_code: 0x402}\n  - name: Y", "303023"),
}  # fmt: skip


@pytest.mark.parametrize("what", list(DESCRIPTIONS))
def test_a_wrong_description_starts_nothing(tmp_path: Path, capsys: Capture, what: str) -> None:
    change = DESCRIPTIONS[what]
    text = DEMO_MACHINE.read_text()
    assert change.old in text
    machine = tmp_path / "machine.yaml"
    machine.write_text(text.replace(change.old, change.new, 1))
    program = tmp_path / "good.nc"
    program.write_text("%X\nG90 G00 X10\nM30\n")
    code, told = run(capsys, "simulate", "-c", machine, program)
    assert code == 1
    assert change.told in told
    if change.told.startswith("302"):
        line = next(line for line in told.splitlines() if change.told in line)
        file, row, column, _ = line.split(":", 3)
        assert (file, row.isdigit(), column.strip().isdigit()) == (str(machine), True, True)
        assert run(capsys, "check", "-c", machine, program)[0] == 1
    else:
        assert "node 1 (axis X) is of vendor 0x7A4D, the machine description expects 0x1234" in told


def test_a_description_that_is_missing(tmp_path: Path, capsys: Capture) -> None:
    code, told = run(capsys, "check", "-c", tmp_path / "none.yaml", tmp_path / "x.nc")
    assert code == 1
    assert "302001" in told


# ---------------------------------------------------------------------------------------------------- PLC programs

PLCS = {
    "missing": (None, "304020", "there is no file"),
    "syntax error": ("from runtime.plc_logic import Program\nclass Bad(Program)\n    pass\n", "304021", "in line 2"),
    "no Program": ("x = 1\n", "304022", "contains no subclass of Program"),
    "error at import": ("raise ValueError('valve 7')\n", "304024", "valve 7"),
    "error in setup": (
        "from runtime.plc_logic import Program\nclass Bad(Program):\n    def setup(self):\n        1 / 0\n",
        "304025",
        "division by zero",
    ),
    "error in cycle": (
        "from runtime.plc_logic import Program\nclass Bad(Program):\n    def cycle(self):\n        self.io.valve_8 = 1\n",
        "304026",
        "valve_8",
    ),
}


@pytest.mark.parametrize("what", list(PLCS))
def test_a_wrong_plc_program_keeps_the_machine_from_starting(tmp_path: Path, capsys: Capture, what: str) -> None:
    source, number, says = PLCS[what]
    machine = tmp_path / "machine.yaml"
    machine.write_text(DEMO_MACHINE.read_text().replace("runtime.demo.plc:DemoMill", "bad.py"))
    if source is not None:
        (tmp_path / "bad.py").write_text(source)
    program = tmp_path / "good.nc"
    program.write_text("%X\nG90 G00 X10\nM30\n")
    code, told = run(capsys, "simulate", "--ideal-axes", "-c", machine, program)
    assert code == 1
    assert number in told
    assert says in told
    assert "bad.py" in told
    assert "path 0.000 mm" in told
