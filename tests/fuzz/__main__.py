"""Look for bytes that break the decoder.

    python -m tests.fuzz --seconds 300      with atheris if it is installed, else with mutants of the seeds
    python -m tests.fuzz FILE …             run these inputs, to see again what was found

What breaks it is written to out/fuzz/; the exit code is 1 then.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib.util
import os
import subprocess
import sys
import time
import traceback
from collections.abc import Iterable, Sequence
from pathlib import Path

from tests.fuzz.harness import Harness
from tests.fuzz.mutation import SEEDS, dictionary, mutants

FINDS = Path("out/fuzz")
LONGEST = 4096  # bytes of an input of atheris


def search(inputs: Iterable[bytes], seconds: float) -> int:
    """Run inputs until the time is over or one breaks the decoder; the exit code."""
    end = time.monotonic() + seconds
    count = 0
    with Harness() as harness:
        for data in inputs:
            if time.monotonic() > end:
                break
            count += 1
            try:
                harness.run(data)
            except Exception:
                traceback.print_exc()
                print(f"input {count} breaks the decoder: {keep(data)}")
                return 1
    print(f"{count} inputs, none breaks the decoder")
    return 0


def keep(data: bytes) -> Path:
    """Write an input to out/fuzz/."""
    FINDS.mkdir(parents=True, exist_ok=True)
    file = FINDS / f"crash-{hashlib.sha256(data).hexdigest()[:16]}.nc"
    file.write_bytes(data)
    return file


def with_atheris(seconds: float) -> int:
    """Let atheris search, guided by the branches that are taken; the exit code.

    The kernels run uncompiled: their branches count too, and an index beyond an array is an error that one sees.
    """
    corpus = FINDS / "corpus"
    corpus.mkdir(parents=True, exist_ok=True)
    tokens = FINDS / "tokens.dict"
    tokens.write_text(dictionary(), encoding="ascii")
    command = [sys.executable, "-m", "tests.fuzz.coverage_guided", str(corpus), str(SEEDS), f"-dict={tokens}"]
    command += [f"-max_total_time={round(seconds)}", f"-max_len={LONGEST}", "-timeout=20", f"-artifact_prefix={FINDS}/"]
    run = subprocess.run(command, env=os.environ | {"NUMBA_DISABLE_JIT": "1"}, check=False)
    return int(run.returncode != 0)


def main(arguments: Sequence[str]) -> int:
    """Returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("files", type=Path, nargs="*", metavar="FILE", help="inputs to run")
    parser.add_argument("--seconds", type=float, default=300.0, help="how long to search, default 300")
    parser.add_argument("--seed", type=int, default=0, help="which row of mutants, without atheris")
    parser.add_argument("--mutants", action="store_true", help="mutants of the seeds even if atheris is there")
    given = parser.parse_args(arguments)
    if given.files:
        return search([file.read_bytes() for file in given.files], float("inf"))
    if not given.mutants:
        if importlib.util.find_spec("atheris"):
            return with_atheris(given.seconds)
        print("atheris is not installed (pip install atheris): mutants of the seeds instead")
    return search(mutants(given.seed), given.seconds)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
