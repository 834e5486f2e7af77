"""`tandem compare` and the pictures of motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from runtime.cli import main as cli
from runtime.cli.picture import columns
from runtime.cli.plot_motion import derivatives

PROGRAM = "%PART\nN10 G90 G01 X10 F3000\nN20 G02 X20 Y10 I10\nN30 G00 Z5\nN40 M30\n"


@pytest.fixture(scope="module")
def traces(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("traces")
    for name, text in (("usual", PROGRAM), ("slow", PROGRAM.replace("F3000", "F1500"))):
        (folder / f"{name}.nc").write_text(text)
        program, out = str(folder / f"{name}.nc"), str(folder / name)
        assert cli.main(["simulate", program, "--ideal-axes", "--no-plc", "--trace", out]) == 0
    return folder / "usual", folder / "slow"


def test_what_a_slower_feed_changes(traces: tuple[Path, Path], capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["compare", *map(str, traces)]) == 0
    printed = capsys.readouterr().out.splitlines()
    times = [float(word) for word in printed[0].split() if word.replace(".", "").isdigit()]
    assert times[1] > times[0]
    assert f"difference {times[1] - times[0]:+.3f} s" in printed[0]
    assert printed[2].startswith("greatest deviation 0.0")
    table = {int(row.split()[0]): float(row.split()[3]) for row in printed[4:] if row.split()[0].isdigit()}
    assert table[2] > 0.1
    assert table[3] > 0.1
    assert abs(table.get(4, 0.0)) < 0.0015  # rapid as before, but for the cycle in which the corner lies
    assert cli.main(["compare", str(traces[0]), str(traces[0])]) == 0
    assert "no line takes another time" in capsys.readouterr().out
    assert cli.main(["compare", *map(str, traces), "--lines", "1"]) == 0
    assert f"and {len(table) - 1} more lines, together +" in capsys.readouterr().out


def test_the_picture_of_a_comparison(
    traces: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture = tmp_path / "both.png"
    assert cli.main(["compare", *map(str, traces), "--plot", str(picture)]) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert f"picture {picture}" in capsys.readouterr().out


def test_folders_without_a_trace(traces: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["compare", str(traces[0]), str(tmp_path)]) == 1
    assert "305040" in capsys.readouterr().err
    assert cli.main(["compare", *map(str, traces), "--plot", str(tmp_path / "no" / "a.png")]) == 1
    assert "305003" in capsys.readouterr().err


def test_no_peak_is_lost_in_a_long_curve() -> None:
    x = np.arange(100_000.0)
    y = np.sin(x / 1000.0)
    y[54_321], y[67_890] = 5.0, -7.0
    curve = columns(x, y, bins=500)
    assert len(curve.x) <= 1000
    assert (curve.high.max(), curve.low.min()) == (5.0, -7.0)
    short = columns(x[:900], y[:900], bins=500)
    assert short.low is short.high


def test_derivatives_are_those_of_the_set_points() -> None:
    t = np.arange(0.0, 1.0, 1e-3)
    velocity, acceleration, jerk = derivatives(t**3, 1e-3)
    np.testing.assert_allclose(velocity[5:], 3.0 * (t[5:] - 0.5e-3) ** 2, atol=1e-5)
    np.testing.assert_allclose(acceleration[5:], 6.0 * (t[5:] - 1e-3), atol=1e-6)
    np.testing.assert_allclose(jerk[5:], 6.0, rtol=1e-3)
