"""The harness under atheris; started by `python -m tests.fuzz`, takes the options of libFuzzer."""

from __future__ import annotations

import sys

import atheris

with atheris.instrument_imports(include=["runtime.cnc.language", "runtime.cnc.decoder"]):
    from tests.fuzz.harness import Harness

with Harness() as harness:

    def one_input(data: bytes) -> None:
        """What libFuzzer calls."""
        harness.run(data)

    atheris.Setup(sys.argv, one_input)
    atheris.Fuzz()
