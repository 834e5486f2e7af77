"""The trace of a simulated run: blocks.jsonl, events.jsonl, samples.npz and summary.json in one folder.

Two runs of the same program give the same bytes, so nothing here knows the date, the host or a path.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO

import numpy as np
import numpy.typing as npt

from runtime.diagnostics.events import RECEIVERS, Event, EventKind

_CHUNK = 4096
Floats = npt.NDArray[np.float64]


class SampleRecorder:
    """One row per cycle: time, commanded position of every axis, path velocity, line, rapid or not; grows by chunks."""

    def __init__(self, axis_names: Sequence[str]) -> None:
        self.axis_names = list(axis_names)
        self._width = len(self.axis_names) + 4
        self._full: list[Floats] = []
        self._chunk: Floats = np.empty((_CHUNK, self._width))
        self._used = 0

    def add(self, t: float, position: Floats, v_path: float, line: int, rapid: bool = False) -> None:
        """`t` s, `position` (n_axes,) mm or degrees, `v_path` mm/s."""
        if self._used == _CHUNK:
            self._full.append(self._chunk)
            self._chunk = np.empty((_CHUNK, self._width))
            self._used = 0
        row = self._chunk[self._used]
        row[0] = t
        row[1:-3] = position
        row[-3] = v_path
        row[-2] = line
        row[-1] = rapid
        self._used += 1

    def arrays(self) -> dict[str, npt.NDArray[np.generic]]:
        """`t`, one array per axis name, `v_path` (mm/s), `line`; each (cycles,)."""
        rows = self._rows()
        columns: dict[str, npt.NDArray[np.generic]] = {"t": rows[:, 0]}
        for i, name in enumerate(self.axis_names):
            columns[name] = rows[:, 1 + i]
        columns["v_path"] = rows[:, -3]
        columns["line"] = rows[:, -2].astype(np.int64)
        return columns

    @property
    def rapid(self) -> npt.NDArray[np.bool_]:
        """Which rows are of rapid moves, or of no move at all, (cycles,); for pictures, no part of the trace."""
        flags: npt.NDArray[np.bool_] = self._rows()[:, -1] != 0.0
        return flags

    def _rows(self) -> Floats:
        return np.concatenate([*self._full, self._chunk[: self._used]])


def write_samples(path: Path, arrays: Mapping[str, npt.NDArray[np.generic]]) -> None:
    """As `numpy.savez`, but with a fixed date in the archive, so that equal samples are equal files."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        for name, array in arrays.items():
            with archive.open(zipfile.ZipInfo(f"{name}.npy", (1980, 1, 1, 0, 0, 0)), "w", force_zip64=True) as file:
                np.lib.format.write_array(file, np.ascontiguousarray(array), allow_pickle=False)


def event_row(event: Event) -> dict[str, object]:
    """An event as it stands in events.jsonl; what does not apply to its kind is left out."""
    row: dict[str, object] = {
        "t": round(event.t, 9),
        "cycle": event.cycle,
        "event": event.kind.name.lower(),
        "line": event.line,
        "n": event.n,
        "number": event.number,
        "value": event.value,
        "path_pos": round(event.path_pos, 9),
    }
    if event.axis >= 0:
        row["axis"] = event.axis
    if event.kind is EventKind.MESSAGE:
        row["receiver"] = RECEIVERS[event.number]
    if event.text:
        row["text"] = event.text
    return row


class TraceWriter:
    """Writes the trace folder while the simulation runs."""

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._folder = folder
        self._blocks: IO[str] = (folder / "blocks.jsonl").open("w", encoding="utf-8")
        self._events: IO[str] = (folder / "events.jsonl").open("w", encoding="utf-8")

    def block(self, row: Mapping[str, object]) -> None:
        self._blocks.write(json.dumps(row) + "\n")

    def event(self, event: Event) -> None:
        self._events.write(json.dumps(event_row(event)) + "\n")

    def close(self, samples: SampleRecorder, summary: Mapping[str, object]) -> None:
        """Write what stands at the end."""
        self._blocks.close()
        self._events.close()
        write_samples(self._folder / "samples.npz", samples.arrays())
        (self._folder / "summary.json").write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
