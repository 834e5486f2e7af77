"""Looking into the HLI of a running machine: the tree as plain values, in mm, degrees, seconds and percent."""

from __future__ import annotations

import ctypes as c
from collections.abc import Mapping, Sequence
from typing import Any

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.hli.alarms import alarm_lines
from runtime.hli.errors import HliError
from runtime.hli.layout import Hli, Mode, State, StopCondition
from runtime.hli.memory import HliMemory, get_text
from runtime.hli.units import FACTORS

Plain = dict[str, "Plain"] | list["Plain"] | str | float | int | bool


def to_plain(value: Any, factor: float | None = None) -> Plain:
    """An element of the HLI with everything below it; `factor` converts its numbers.

    Element names stay as they are; structures become dictionaries, arrays lists. What has a factor in `units.FACTORS`
    is in mm, degrees, seconds or percent.
    """
    if isinstance(value, c.Structure):
        return {
            name: get_text(value, name)
            if isinstance(getattr(value, name), bytes)
            else to_plain(getattr(value, name), FACTORS.get(name, None if of is c.c_bool else factor))
            for name, of, *_ in value._fields_
        }
    if isinstance(value, c.Array):
        return [to_plain(item, factor) for item in value]
    if isinstance(value, bytes):
        return value.decode("utf-8", "replace")
    if isinstance(value, (bool, str)):
        return value
    if isinstance(value, (int, float)):
        return value if factor is None else round(value * factor, 9)
    raise TypeError(f"the HLI has no elements of type {type(value).__name__}")


def snapshot(hli: Hli) -> dict[str, Plain]:
    """The whole interface without what is not in use: areas of axes that do not exist, empty technology units and
    alarms."""
    head = hli.head
    channels = [_without_free_units(to_plain(hli.channels[i])) for i in range(head.channels_r)]
    return {
        "head": to_plain(head),
        "platform": to_plain(hli.platform),
        "channels": channels,
        "axes": [_without_free_units(to_plain(hli.axes[i])) for i in range(head.axes_r)],
        "operator": [to_plain(hli.operator[i]) for i in range(head.channels_r)],
        "image": to_plain(hli.image),
        "alarm_count_r": int(hli.alarm_count_r),
        "alarms": alarms_plain(hli),
    }


def alarms_plain(hli: Hli, *, active_only: bool = False) -> list[Plain]:
    """The alarm history, newest first."""
    return [
        {
            "sequence": line.sequence,
            "time": line.time_ns * 1e-9,
            "cycle": line.cycle,
            "id": line.id,
            "severity": line.severity.name.lower(),
            "axis": line.axis,
            "line": line.line,
            "active": line.active,
            "text": line.text,
        }
        for line in alarm_lines(hli, active_only=active_only)
    ]


def element(hli: Hli, path: str) -> Plain:
    """One element with everything below it: "channels.0.status", "axes.X.status.actual_position_r".

    Channels and axes go by index or name; the suffix (_r, _w, _rw) may be left out. Raises HliError for a wrong path.
    """
    here: Plain = snapshot(hli)
    for part in [part for part in path.split(".") if part]:
        here = _below(here, part, path)
    return here


def _below(here: Plain, part: str, path: str) -> Plain:
    found: Mapping[str, Plain]
    if isinstance(here, dict):
        found = here
    elif isinstance(here, list):
        found = {str(i): item for i, item in enumerate(here)}
        named = {str(item["name_r"]): item for item in here if isinstance(item, dict) and "name_r" in item}
        found = {**found, **named}
    else:
        found = {}
    for name in (part, f"{part}_r", f"{part}_w", f"{part}_rw"):
        if name in found:
            return found[name]
    known = ", ".join(list(found)[:24]) or "(nothing is below it)"
    raise HliError(catalogue.HLI_NO_ELEMENT, path=path, part=part, known=known)


def _without_free_units(area: Plain) -> Plain:
    assert isinstance(area, dict)
    units, used = area["techno_unit_std_sync"], area["used_units_std_sync_r"]
    assert isinstance(units, list)
    assert isinstance(used, int)
    area["techno_unit_std_sync"] = units[:used]
    return area


def mode_name(number: int) -> str:
    """AUTOMATIC for 2."""
    return Mode(number).name if number in list(Mode) else str(number)


def state_name(number: int) -> str:
    """ACTIVE for 4."""
    return State(number).name if number in list(State) else str(number)


def stop_conditions(mask: int) -> Sequence[str]:
    """The names of the bits of `stop_condition_r`, in plain words."""
    return [bit.name.lower().replace("_", " ") for bit in StopCondition if bit & mask and bit.name]


class HliClient:
    """A process that looks on: attached read-only, so it can neither disturb the machine nor needs its user's
    rights."""

    def __init__(self, name: str) -> None:
        """Raises HliError if there is no such machine, or it was built from another layout."""
        self._memory = HliMemory.attach(name, read_only=True)

    @property
    def hli(self) -> Hli:
        """The tree itself."""
        return self._memory.hli

    @property
    def running(self) -> bool:
        """The cycle runs and its process lives."""
        return bool(self.hli.head.running_r) and self._memory.owner_alive

    @property
    def starting(self) -> bool:
        """The process of the cycle lives, and has not run a cycle yet."""
        head = self.hli.head
        return not head.running_r and head.cycle_r == 0 and self._memory.owner_alive

    def snapshot(self) -> dict[str, Plain]:
        """See `snapshot`; `running` tells besides whether the owner lives."""
        return {"running": self.running, **snapshot(self.hli)}

    def element(self, path: str) -> Plain:
        """See `element`."""
        return element(self.hli, path)

    def close(self) -> None:
        """Let go of the memory."""
        self._memory.close()

    def __enter__(self) -> HliClient:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
