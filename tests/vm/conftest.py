"""The virtual machine is started only when its tests are asked for: `make test-vm`, or `pytest tests/vm`."""

from __future__ import annotations

from pathlib import Path

import pytest

FOLDER = Path(__file__).parent


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Ignore this folder unless it, or something in it, was named."""
    named = [(config.invocation_params.dir / argument.split("::")[0]).resolve() for argument in config.args]
    if any(path == FOLDER or FOLDER in path.parents for path in named):
        return None
    return True
