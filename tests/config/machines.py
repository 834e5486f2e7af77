"""A small machine description to which tests add what they are about."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.config.channel import ChannelParameters
from runtime.config.loader import ConfigurationError, load_machine, parse_machine
from runtime.config.machine import Machine
from runtime.diagnostics.errors import Problem

MACHINE = """\
name: test
axes:
  - {name: X, log_axis: 1, velocity: 400, acceleration: 4000, jerk: 60000}
  - {name: Y, log_axis: 2, velocity: 400, acceleration: 4000, jerk: 60000}
  - {name: S, type: spindle, log_axis: 6, velocity: 36000, acceleration: 36000, jerk: 360000}
channels:
  - name: mill
    axes: [X, Y]
"""  # 8 lines


def with_parameters(yaml: str) -> str:
    """The machine with a block of channel parameters; its first line is line 10 of the text, indented by 6."""
    return MACHINE + "    parameters:\n" + "".join(f"      {line}\n" for line in yaml.splitlines())


def parameters_of(yaml: str) -> ChannelParameters:
    return parse_machine(with_parameters(yaml)).channels[0].parameters


def problems_of(text: str) -> tuple[Problem, ...]:
    with pytest.raises(ConfigurationError) as caught:
        parse_machine(text, file="m.yaml")
    return caught.value.problems


def write_machine(folder: Path, parameter_list: str, more: str = "") -> Path:
    """A description in `folder` with a list file `mill.lis`; `more` are further keys of the channel."""
    (folder / "mill.lis").write_text(parameter_list, encoding="utf-8")
    file = folder / "machine.yaml"
    file.write_text(MACHINE + "    parameter_list: mill.lis\n" + more, encoding="utf-8")
    return file


def machine_with_list(folder: Path, parameter_list: str, more: str = "") -> Machine:
    return load_machine(write_machine(folder, parameter_list, more))


def list_problems(folder: Path, parameter_list: str, more: str = "") -> tuple[Problem, ...]:
    with pytest.raises(ConfigurationError) as caught:
        machine_with_list(folder, parameter_list, more)
    return caught.value.problems
