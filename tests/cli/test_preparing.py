"""The first start, which compiles the kernels: a service manager is told how far it is, and to be patient."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from pathlib import Path

import numba
import pytest

# What `tandem run` does at its start, with one group of kernels in the place of all.
FIRST_START = """
import sys
import types

sys.modules["runtime.scheduler.all_kernels"] = types.ModuleType("runtime.scheduler.all_kernels")
import runtime.cnc.axes.supervision  # registers its warm-up
from runtime.cli.preparing import compile_kernels
from runtime.kernel_cache import CACHE

compile_kernels()
assert CACHE.warm
print(sum(runtime.cnc.axes.supervision._supervise.stats.cache_misses.values()))
"""


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled here")  # type: ignore[attr-defined]
def test_the_service_manager_is_told_of_each_group_and_to_wait_longer(tmp_path: Path) -> None:
    """Without EXTEND_TIMEOUT_USEC systemd would end a start that compiles for longer than TimeoutStartSec."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(str(tmp_path / "notify"))
        environment = os.environ | {
            "NOTIFY_SOCKET": str(tmp_path / "notify"),
            "NUMBA_CACHE_DIR": str(tmp_path / "cache"),
        }

        def start() -> tuple[str, str, list[str]]:
            done = subprocess.run(
                [sys.executable, "-c", FIRST_START], capture_output=True, text=True, check=True, env=environment
            )
            told = []
            manager.setblocking(False)
            while True:
                try:
                    told.append(manager.recv(4096).decode())
                except BlockingIOError:
                    return done.stdout, done.stderr, told

        compiled, said, told = start()
        assert compiled == "1\n"
        assert "compiling kernels, as at every first start of a version: about a minute" in said
        assert told == [
            "STATUS=first start of this version: compiling kernels, 0 of 1 groups\nEXTEND_TIMEOUT_USEC=120000000"
        ]
        # the next start finds them: nothing to wait for, nothing said
        assert start() == ("0\n", "", [])
