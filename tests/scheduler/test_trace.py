from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from runtime.diagnostics.events import Event, EventKind
from runtime.scheduler.trace import SampleRecorder, TraceWriter, event_row


def record(count: int) -> SampleRecorder:
    samples = SampleRecorder(["X", "Y"])
    for i in range(count):
        samples.add(i * 0.001, np.array([i, -i], dtype=float), 5.0, i // 10, rapid=i % 3 == 0)
    return samples


def test_samples_grow_over_the_chunks_and_keep_their_order() -> None:
    arrays = record(10_000).arrays()
    assert list(arrays) == ["t", "X", "Y", "v_path", "line"]
    np.testing.assert_array_equal(arrays["X"], np.arange(10_000.0))
    np.testing.assert_array_equal(arrays["Y"], -np.arange(10_000.0))
    assert arrays["line"].dtype == np.int64


def test_rapid_moves_are_known_beside_the_trace() -> None:
    samples = record(5000)
    np.testing.assert_array_equal(samples.rapid, np.arange(5000) % 3 == 0)
    assert "rapid" not in samples.arrays()


def test_equal_runs_are_equal_files(tmp_path: Path) -> None:
    for name in "ab":
        writer = TraceWriter(tmp_path / name)
        writer.block({"line": 1, "type": "line"})
        writer.event(Event(t=0.1, cycle=100, kind=EventKind.M_OUT, line=3, n=30, number=8))
        writer.close(record(5000), {"time_s": 1.0})
    for file in ("blocks.jsonl", "events.jsonl", "samples.npz", "summary.json"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()
    with np.load(tmp_path / "a" / "samples.npz") as archive:
        assert archive["X"][-1] == 4999.0


def test_an_event_row_has_the_names_of_the_trace_format() -> None:
    row = event_row(Event(t=0.25, cycle=250, kind=EventKind.M_ACK, line=3, n=30, number=8, path_pos=12.5))
    assert json.loads(json.dumps(row)) == {
        "t": 0.25, "cycle": 250, "event": "m_ack", "line": 3, "n": 30, "number": 8, "value": 0.0, "path_pos": 12.5,
    }  # fmt: skip
