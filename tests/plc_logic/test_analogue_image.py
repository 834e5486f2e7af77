"""Analogue values by name in a PLC program, and on the whole machine with its test bench."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
import yaml

from runtime.config.loader import DEMO_MACHINE
from runtime.plc_logic import AnalogueInput, AnalogueOutput, Io, Output, PlcFailure, Program
from runtime.plc_logic.bench import Bench
from runtime.testbench import MachineBench


class PressIo(Io):
    pressure: AnalogueInput
    valve: AnalogueOutput
    lamp: Output


class Press(Program):
    """Opens its valve with the pressure that lacks, while it knows the pressure."""

    io: PressIo
    wrong = 0.0

    def cycle(self) -> None:
        io = self.io
        io.lamp = not io.is_valid("pressure")
        io.valve = self.wrong or (4.0 if io.lamp else 4.0 + 2.0 * (10.0 - io.pressure))


def bench(program: type[Press] = Press) -> Bench[Press]:
    return Bench(
        program, outputs=["lamp"], analogue_inputs=["other", "pressure"], analogue_outputs={"valve": (4.0, 20.0)}
    )


def test_values_are_read_and_put_out_by_name() -> None:
    press = bench()
    press.set(pressure=5.0)
    press.run(0.01)
    assert press.output_value("valve") == 14.0
    assert not press.output("lamp")
    assert isinstance(press.program.io, PressIo)
    assert {"pressure", "other", "valve", "lamp"} == set(dir(press.program.io))


def test_an_output_is_kept_within_its_limits() -> None:
    press = bench()
    press.set(pressure=-3.0)
    press.run(0.01)
    assert press.output_value("valve") == press.program.io.valve == 20.0


def test_an_input_that_is_not_valid() -> None:
    press = bench()
    press.set(pressure=math.nan)
    press.run(0.01)
    assert press.output("lamp")
    assert press.output_value("valve") == 4.0


class Wrong(Press):
    wrong = math.nan


def test_no_number_is_refused_at_its_line() -> None:
    press = bench(Wrong)
    with pytest.raises(PlcFailure, match="valve cannot be nan"):
        press.run(0.01)
    assert press.output_value("valve") == 0.0  # what a cycle that fails has set goes nowhere


class Sets(Press):
    def cycle(self) -> None:
        self.io.pressure = 1.0


class Asks(Press):
    def cycle(self) -> None:
        self.io.is_valid("presure")


class Mistaken(Io):
    pressure: Output


class Declares(Program):
    io: Mistaken


def test_mistakes_are_named() -> None:
    with pytest.raises(PlcFailure, match="pressure is an input"):
        bench(Sets).run(0.01)
    with pytest.raises(PlcFailure, match="no input or output presure; known: pressure"):
        bench(Asks).run(0.01)
    with pytest.raises(PlcFailure, match="pressure is declared as output, but the machine has it as analogue input"):
        Bench(Declares, analogue_inputs=["pressure"])


PROGRAM = """
from runtime.plc_logic import Program, m_function

class Press(Program):
    def cycle(self):
        self.io.valve = 4 + 2 * (10 - self.io.pressure) if self.io.is_valid("pressure") else 4

    @m_function()
    def all(self, f):
        return True
"""


@pytest.mark.parametrize("simulated_drives", [False, True])
def test_on_a_whole_machine(tmp_path: Path, simulated_drives: bool) -> None:
    description = yaml.safe_load(DEMO_MACHINE.read_text(encoding="utf-8"))
    description["plc"]["program"] = "press.py"
    description["fieldbus"]["bus"] |= {"interface": "virtual", "channel": "analogue"}
    description["fieldbus"]["bus"].pop("options", None)
    description["fieldbus"]["io"].append(
        {
            "node": 20,
            "analogue_inputs": [
                {"name": "pressure", "counts": [0, 20000], "values": [0, 10], "range": [-0.5, 10.5], "unit": "bar"}
            ],
            "analogue_outputs": [{"name": "valve", "counts": [0, 32000], "values": [4, 20], "unit": "mA"}],
        }
    )
    (tmp_path / "machine.yaml").write_text(yaml.safe_dump(description))
    (tmp_path / "press.py").write_text(PROGRAM)
    machine = MachineBench(tmp_path / "machine.yaml", simulated_drives=simulated_drives, folder=tmp_path)
    try:
        machine.set_value("pressure", 5.0)
        machine.wait_until(lambda: machine.value("valve") == 14.0, 0.1)
        assert machine.value("pressure") == 5.0
        assert machine.hli.image.analogue_valid_r == 1
        machine.set_value("pressure", -2.0)  # a broken wire
        machine.wait_until(lambda: machine.value("valve") == 4.0, 0.1)
        assert machine.hli.image.analogue_valid_r == 0
        with pytest.raises(KeyError, match="no analogue input"):
            machine.set_value("valve", 1.0)
    finally:
        machine.close()
