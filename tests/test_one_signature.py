"""Every kernel is warmed with what it is called with later: nothing is compiled once the machine runs.

A compilation in the cycle is a cycle of seconds. It does not show where the machine code of the other layout lies in the cache.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys

import numba
import pytest


@pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="nothing is compiled here")  # type: ignore[attr-defined]
def test_no_kernel_gets_a_signature_that_the_warm_up_has_not_given_it() -> None:
    """Plate with drives and recorder; contouring, splines, filter, compensation, backward motion, hold, single block."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.compiled_in_use"], capture_output=True, text=True, check=False, env=os.environ
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["kernels"] > 100  # it has looked
    assert found["gained"] == {}, "kernel: signatures after the warm-up, and after the programs"
