"""A shared memory of its own for every test."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator

import pytest

from runtime.hli.memory import HliMemory

_numbers = itertools.count()


@pytest.fixture
def name() -> str:
    return f"tandem-test-{os.getpid()}-{next(_numbers)}"


@pytest.fixture
def shared(name: str) -> Iterator[HliMemory]:
    """The owner's side of a shared HLI."""
    with HliMemory.create(name) as memory:
        yield memory
