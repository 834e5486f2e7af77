"""What stands in front of a recording: which runtime on which computer has recorded which machine, from where."""

from __future__ import annotations

import base64
import hashlib
import platform
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from runtime.config.machine import Machine
from runtime.config.yaml_core import CoreLoader
from runtime.diagnostics.version import version
from runtime.drives import DriveImage
from runtime.recorder.layouts import layouts

PACKAGE = Path(__file__).parents[1]
_SOURCES = ("*.py", "*.lark")


def source_hash(package: Path = PACKAGE) -> str:
    """SHA-256 over the sources of the runtime, 16 digits."""
    digest = hashlib.sha256()
    for pattern in _SOURCES:
        for path in sorted(package.rglob(pattern)):
            digest.update(str(path.relative_to(package)).encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def processor() -> str:
    """The model of the processor, as Linux names it."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.machine()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())


def make_header(
    machine: Machine, machine_file: Path | None, image: DriveImage, plc: str, *, real: bool
) -> dict[str, Any]:
    """`plc`: "process", "inline" or "none"; `image` as the controller is built with it; `real`: its drives are no ideal ones."""
    return {
        "version": version(),
        "sources": source_hash(),
        "processor": processor(),
        "layouts": layouts(image),
        "machine": machine.name,
        "description": _description(machine_file),
        "plc": plc,
        "real_drives": real,
        "image": base64.b64encode(image.words.tobytes()).decode(),
    }


def image_words(header: Mapping[str, Any]) -> npt.NDArray[np.int64]:
    """The drive image in front of the first cycle."""
    return np.frombuffer(base64.b64decode(header["image"]), dtype=np.int64)


def _description(machine_file: Path | None) -> dict[str, Any]:
    """The machine description and the parameter lists it names, as texts."""
    if machine_file is None:
        return {"text": "", "folder": "", "lists": {}}
    text = machine_file.read_text(encoding="utf-8-sig")
    lists = {}
    for channel in (CoreLoader(text).get_data() or {}).get("channels", ()):
        if name := channel.get("parameter_list"):
            lists[name] = (machine_file.parent / name).read_bytes().decode("utf-8", "surrogateescape")
    return {"text": text, "folder": str(machine_file.parent.absolute()), "lists": lists}


def described_machine(header: Mapping[str, Any], folder: Path) -> Machine:
    """The machine that was recorded; `folder` takes the files that its description needs. Raises as `load_machine`."""
    from runtime.config.loader import load_machine

    described = header["description"]
    if not described["text"]:
        return load_machine(None)
    values = CoreLoader(described["text"]).get_data()
    for number, (name, text) in enumerate(described["lists"].items()):
        path = folder / f"{number}.lis"
        path.write_bytes(text.encode("utf-8", "surrogateescape"))
        for channel in values["channels"]:
            if channel.get("parameter_list") == name:
                channel["parameter_list"] = str(path)
    return Machine.model_validate(values, context={"folder": Path(described["folder"])})
