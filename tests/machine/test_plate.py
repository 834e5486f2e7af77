"""A whole part through `tandem simulate --trace`: formats of the trace, order of its events, and the path against the blocks."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from runtime.cli import main as cli
from runtime.config.machine import Machine

Row = dict[str, Any]
Floats = npt.NDArray[np.float64]
PROGRAM = Path(__file__).parents[1] / "programs" / "cover.nc"
AXES = ("X", "Y", "Z")
PERIOD = 0.001  # s


@dataclass(frozen=True)
class Trace:
    """What `--trace` wrote."""

    blocks: list[Row]
    events: list[Row]
    samples: dict[str, npt.NDArray[Any]]
    summary: Row

    @classmethod
    def read(cls, folder: Path) -> Trace:
        assert sorted(path.name for path in folder.iterdir()) == [
            "blocks.jsonl", "events.jsonl", "samples.npz", "summary.json",
        ]  # fmt: skip
        with np.load(folder / "samples.npz") as archive:
            samples = {name: archive[name] for name in archive.files}
        lines = {name: (folder / f"{name}.jsonl").read_text().splitlines() for name in ("blocks", "events")}
        rows = {name: [json.loads(line) for line in text] for name, text in lines.items()}
        return cls(rows["blocks"], rows["events"], samples, json.loads((folder / "summary.json").read_text()))

    @property
    def places(self) -> Floats:
        """(cycles, 3), mm."""
        return np.column_stack([self.samples[name] for name in AXES])

    def motions(self) -> list[Row]:
        return [row for row in self.blocks if row["type"] in ("line", "arc", "helix")]

    def of(self, *kinds: str) -> list[Row]:
        return [row for row in self.events if row["event"] in kinds]

    def at(self, t: float) -> int:
        """Index of the sample at a time."""
        return int(np.searchsorted(self.samples["t"], t - PERIOD / 2))


@pytest.fixture(scope="module")
def trace(tmp_path_factory: pytest.TempPathFactory) -> Trace:
    folder = tmp_path_factory.mktemp("trace")
    assert cli.main(["simulate", str(PROGRAM), "--ideal-axes", "--trace", str(folder)]) == 0
    return Trace.read(folder)


# ---------------------------------------------------------------------------------------------------- formats


def test_blocks_have_the_documented_fields(trace: Trace) -> None:
    assert {row["type"] for row in trace.blocks} == {"line", "arc", "helix", "dwell", "m", "h", "s", "t", "stop"}
    for row in trace.blocks:
        assert isinstance(row["line"], int)
        assert row["n"] is None or isinstance(row["n"], int)
        assert row["program"] == "cover.nc"
    for row in trace.motions():
        for key in ("from", "to", "to_pcs"):
            assert list(row[key]) == list(AXES)
            assert all(isinstance(value, float) for value in row[key].values())
        assert isinstance(row["rapid"], bool)
        assert (row["feed"] is None) is row["rapid"]
        arc = {"centre", "radius", "angle", "plane"}
        assert (arc & set(row)) == (set() if row["type"] == "line" else arc)
        if row["type"] != "line":
            assert list(row["centre"]) == ["X", "Y"]
            assert row["plane"] == "XY"
            assert row["radius"] in (pytest.approx(5.0),)
        assert (row["type"] == "helix") is (row["type"] != "line" and row["from"]["Z"] != row["to"]["Z"])


def test_a_block_begins_where_the_one_before_ended_and_is_shifted_by_its_zero_offset(
    demo: Machine, trace: Trace
) -> None:
    shift = demo.channels[0].zero_offsets["G54"]
    for before, after in zip(trace.motions()[:-1], trace.motions()[1:], strict=True):
        assert after["from"] == pytest.approx(before["to"], abs=1e-9)
    for row in trace.motions():
        assert {name: row["to"][name] - shift[name] for name in AXES} == pytest.approx(row["to_pcs"], abs=1e-9)


def test_events_have_the_documented_fields(trace: Trace) -> None:
    keys = {"t": float, "cycle": int, "event": str, "line": int, "number": int, "value": float, "path_pos": float}
    for row in trace.events:
        assert {key: type(row[key]) for key in keys} == keys, row
        assert row["n"] is None or isinstance(row["n"], int)
        assert row["t"] == pytest.approx(row["cycle"] * PERIOD)
        assert set(row) <= {*keys, "n", "axis", "text"}
    times = [row["cycle"] for row in trace.events]
    assert times == sorted(times)
    assert not trace.of("error")


def test_samples_are_one_row_per_cycle(trace: Trace) -> None:
    samples = trace.samples
    assert list(samples) == ["t", *AXES, "v_path", "line"]
    assert len({len(array) for array in samples.values()}) == 1
    assert all(samples[name].dtype == np.float64 for name in ("t", *AXES, "v_path"))
    assert samples["line"].dtype == np.int64
    assert np.diff(samples["t"]) == pytest.approx(PERIOD)
    assert samples["v_path"].min() >= 0.0
    assert set(np.unique(samples["line"])) <= {0, *(row["line"] for row in trace.blocks)}


def test_summary_tells_the_whole(trace: Trace) -> None:
    summary = trace.summary
    assert set(summary) == {"time_s", "path_length_mm", "positions", "errors", "variables", "messages"}
    assert summary["errors"] == summary["messages"] == []
    assert summary["positions"] == pytest.approx({"X": 108.0, "Y": 83.0, "Z": 120.0})
    assert summary["variables"]["P1"] == 8.0
    assert summary["variables"]["P15"] == 3.5
    assert summary["time_s"] == pytest.approx(len(trace.samples["t"]) * PERIOD, abs=3 * PERIOD)
    length = sum(
        math.dist(row["from"].values(), row["to"].values()) for row in trace.motions() if row["type"] == "line"
    )
    for row in trace.motions():
        if row["type"] != "line":
            turn = abs(math.radians(row["angle"])) * row["radius"]
            length += math.hypot(turn, row["to"]["Z"] - row["from"]["Z"])
    assert summary["path_length_mm"] == pytest.approx(length, abs=1e-6)


# ---------------------------------------------------------------------------------------------------- order of events


def test_functions_come_in_the_order_of_the_program(trace: Trace) -> None:
    out = [(row["event"][0], row["number"], row["value"]) for row in trace.of("m_out", "h_out", "s_out", "t_out")]
    holes = [("h", 12, float(count)) for count in range(1, 9)]
    assert out == [
        ("m", 20, 0.0), ("t", 1, 0.0), ("m", 6, 0.0), ("s", 3, 3000.0), ("m", 8, 0.0), ("m", 9, 0.0),
        ("t", 2, 0.0), ("m", 6, 0.0), ("s", 3, 4000.0), ("m", 8, 0.0), *holes, ("m", 9, 0.0),
        ("t", 3, 0.0), ("m", 6, 0.0), ("s", 3, 5000.0), ("s", 5, 5000.0), ("m", 21, 0.0),
    ]  # fmt: skip


def standing(trace: Trace, begin: Row, end: Row) -> bool:
    """The path stands from one event to the other."""
    places = trace.places[trace.at(begin["t"]) : trace.at(end["t"]) + 1]
    return bool((np.ptp(places, axis=0) < 1e-9).all())


def test_what_the_path_waits_for_is_acknowledged_before_it_goes_on(trace: Trace) -> None:
    """MVS_SVS: out, acknowledged, then motion (clamp, tool change, spindle at speed)."""
    waiting = {("m", 20), ("m", 6), ("s", 3)}
    pairs = 0
    for row in trace.of("m_out", "s_out"):
        if (row["event"][0], row["number"]) not in waiting:
            continue
        ack = next(
            a for a in trace.of(f"{row['event'][0]}_ack") if a["cycle"] > row["cycle"] and a["line"] == row["line"]
        )
        assert standing(trace, row, ack), row
        pairs += 1
    assert pairs == 1 + 3 + 3
    first_motion = trace.samples["t"][int(np.argmax(trace.samples["v_path"] > 0.0))]
    for number in (20, 6, 3):
        assert next(a for a in trace.of("m_ack", "s_ack") if a["number"] == number)["t"] < first_motion


def test_the_spindle_is_ordered_at_once_and_acknowledged_at_speed(demo: Machine, trace: Trace) -> None:
    spindle = demo.axes[3]
    before = 0.0
    for out, ack in zip(trace.of("s_out")[:3], [a for a in trace.of("s_ack") if a["number"] == 3], strict=True):
        change = abs(out["value"] * 6.0 - before)
        # no quicker than the spindle can: less than its ramp, by the 2 % that count as reached
        assert ack["t"] - out["t"] >= 0.9 * change / spindle.acceleration
        before = out["value"] * 6.0


def test_coolant_is_acknowledged_while_the_path_goes_on(trace: Trace) -> None:
    """MVS_SNS: put out with the path standing for the spindle or not, never a stop of its own before the motion."""
    for out, ack in zip([m for m in trace.of("m_out") if m["number"] == 8],
                        [m for m in trace.of("m_ack") if m["number"] == 8], strict=True):  # fmt: skip
        assert 0.2 <= ack["t"] - out["t"] < 0.25, "the pressure switch of the plant"


def test_the_clamp_opens_after_the_last_motion_and_the_program_ends_after_it(trace: Trace) -> None:
    (out,) = [row for row in trace.of("m_out") if row["number"] == 21]
    (ack,) = [row for row in trace.of("m_ack") if row["number"] == 21]
    assert np.abs(trace.places[trace.at(out["t"]) :] - [108.0, 83.0, 120.0]).max() < 1e-9
    end = trace.of("mode")[-1]
    assert out["cycle"] < ack["cycle"] < end["cycle"]
    assert trace.of("block_end")[-1]["line"] == trace.blocks[-1]["line"], "M30"


def test_every_motion_has_its_start_and_end_in_order(trace: Trace) -> None:
    started = [row["line"] for row in trace.of("block_start")]
    motions = [row["line"] for row in trace.motions() if row["from"] != row["to"] or row["type"] != "line"]
    position = iter(started)
    assert all(line in position for line in motions), "block_start in the order of the program"
    assert len(trace.of("block_start")) == len(trace.of("block_end"))
    path = [row["path_pos"] for row in trace.of("block_start")]
    assert path == sorted(path)


# ---------------------------------------------------------------------------------------------------- the path


def ends(row: Row) -> tuple[Floats, Floats]:
    return np.array(list(row["from"].values())), np.array(list(row["to"].values()))


def distance(row: Row, places: Floats) -> Floats:
    """Of places (k, 3) from the line, arc or helix of a block."""
    begin, end = ends(row)
    if row["type"] == "line":
        way = end - begin
        share = np.clip((places - begin) @ way / max(float(way @ way), 1e-300), 0.0, 1.0)
        return np.asarray(np.linalg.norm(places - (begin + share[:, None] * way), axis=1))
    centre = np.array(list(row["centre"].values()))
    first = math.atan2(*(begin[:2] - centre)[::-1])
    turned = np.arctan2(places[:, 1] - centre[1], places[:, 0] - centre[0]) - first
    sign = math.copysign(1.0, row["angle"])
    share = np.mod(sign * turned + 1e-9, 2.0 * np.pi) / abs(math.radians(row["angle"]))
    best = np.full(len(places), np.inf)
    for turn in (
        share,
        np.zeros(len(places)),
        np.ones(len(places)),
    ):  # the ends too: they are the seam of a full circle
        inside = np.clip(turn, 0.0, 1.0)
        angle = first + inside * math.radians(row["angle"])
        on = np.column_stack([centre[0] + row["radius"] * np.cos(angle), centre[1] + row["radius"] * np.sin(angle),
                              begin[2] + inside * (end[2] - begin[2])])  # fmt: skip
        best = np.minimum(best, np.linalg.norm(places - on, axis=1))
    return best


def test_the_sampled_path_is_the_programmed_one(trace: Trace) -> None:
    """Every sample lies on the block that the events tell, and every end point is passed within one cycle's travel."""
    places = trace.places
    blocks = [row for row in trace.motions() if row["from"] != row["to"] or row["type"] != "line"]
    starts = iter(trace.of("block_start"))
    begins = [trace.at(next(row for row in starts if row["line"] == block["line"])["t"]) for block in blocks]
    for block, begin, after in zip(blocks, begins, [*begins[1:], len(places)], strict=True):
        beside = distance(block, places[begin:after])
        assert beside.max(initial=0.0) <= 1e-6, block
        _, end = ends(block)
        last = max(after - 1, 0)
        travel = float(trace.samples["v_path"][last : last + 2].max()) * PERIOD  # there and back, at a reversal
        assert np.linalg.norm(places[last] - end) <= travel + 1e-6, block
        if after < len(places):
            assert np.linalg.norm(places[after] - end) <= travel + 1e-6, block
    assert len(blocks) == 97
