"""Reading the machine description."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

import yaml

from runtime.config.machine import Machine


def load_machine(path: Path | None) -> Machine:
    """The machine of a YAML file, or the built-in demo machine."""
    if path is None:
        text = resources.files("runtime.demo").joinpath("machine.yaml").read_text(encoding="utf-8")
    else:
        text = path.read_text(encoding="utf-8")
    return Machine.model_validate(yaml.safe_load(text))
