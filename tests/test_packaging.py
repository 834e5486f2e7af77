"""What a fresh clone is installed from: the lock fits the project file and names no index, no host, no folder."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from packaging.requirements import Requirement

LOCK = Path("requirements.lock").read_text(encoding="utf-8")
PROJECT = tomllib.loads(Path("pyproject.toml").read_text(encoding="utf-8"))["project"]


def name(text: str) -> str:
    return re.sub(r"[-_.]+", "-", text).lower()


def test_the_lock_pins_every_dependency_within_its_bounds() -> None:
    pins = dict(re.findall(r"^([\w.-]+)==(\S+)$", LOCK, re.MULTILINE))
    wanted = [*PROJECT["dependencies"], *PROJECT["optional-dependencies"]["dev"]]
    for requirement in map(Requirement, wanted):
        assert requirement.specifier.contains(pins[name(requirement.name)]), requirement


def test_every_dependency_has_a_lower_bound() -> None:
    for requirement in map(Requirement, PROJECT["dependencies"]):
        assert any(specifier.operator == ">=" for specifier in requirement.specifier), requirement


def test_the_lock_names_no_host_and_no_folder() -> None:
    assert not re.search(r"https?:|file:|@|(^|\s)--|/\w+/", LOCK, re.MULTILINE)
    for line in LOCK.splitlines():
        assert re.fullmatch(r"[a-z0-9][a-z0-9._-]*==[0-9a-z.+!]+|    # +via.*|    #   .*", line), line
