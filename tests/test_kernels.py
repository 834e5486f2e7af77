from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from runtime.kernel_cache import cache_candidates, choose_cache


def test_the_cache_goes_where_it_can_be_written(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("")
    assert choose_cache([blocked, tmp_path / "second"], "v") == tmp_path / "second" / "v"
    assert choose_cache([blocked], "v") is None


def test_the_environment_decides_first() -> None:
    assert cache_candidates({"NUMBA_CACHE_DIR": "/a", "HOME": "/home/u"})[:2] == [
        Path("/a"),
        Path("/home/u/.cache/tandem/kernels"),
    ]
    assert cache_candidates({"XDG_CACHE_HOME": "/c", "HOME": "/home/u"})[0] == Path("/c/tandem/kernels")


@pytest.mark.skipif(bool(os.environ.get("NUMBA_DISABLE_JIT")), reason="nothing is compiled")
def test_a_second_process_loads_what_the_first_has_compiled(tmp_path: Path) -> None:
    script = (
        "import runtime.cnc.axes.supervision as s\n"
        "from runtime.kernels import warm_up\n"
        "warm_up()\n"
        "print(sum(s._supervise.stats.cache_hits.values()), sum(s._supervise.stats.cache_misses.values()))\n"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    counts = [
        subprocess.run(
            [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True
        ).stdout
        for _ in range(2)
    ]
    assert counts == ["0 1\n", "1 0\n"]
