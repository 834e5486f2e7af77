"""Kernels: typed functions over arrays and records, compiled by Numba and cached on disk, readable as plain Python.

With NUMBA_DISABLE_JIT=1 they run uncompiled; the tests do both. A module that has kernels registers a call that touches each
of them with the types that the runtime uses (`@warms`), so that all are compiled, or loaded from the cache, before a drive is
enabled: never in the cycle.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

from runtime.kernel_cache import CACHE

F = TypeVar("F", bound=Callable[..., Any])

setattr(numba.config, "CACHE_DIR", str(CACHE.folder))  # noqa: B010 - mypy does not see it there

_WARM_UPS: list[tuple[str, Callable[[], None]]] = []


def kernel(function: F) -> F:
    """Compile `function` at its first call, keep the machine code on disk, release the GIL, keep IEEE arithmetic."""
    return cast(F, numba.njit(cache=True, nogil=True, fastmath=False, error_model="numpy")(function))


def warms(name: str) -> Callable[[Callable[[], None]], Callable[[], None]]:
    """Register a warm-up call under the name of what it warms ("look-ahead")."""

    def register(call: Callable[[], None]) -> Callable[[], None]:
        _WARM_UPS.append((name, call))
        return call

    return register


def warm_up(progress: Callable[[str, int, int], None] | None = None, *, everything: bool = False) -> None:
    """Run all registered warm-ups; `progress(name, done, total)` is told before each.

    `everything`: those of every kernel there is are registered (scheduler.all_kernels), so the cache is complete afterwards.
    """
    with CACHE.filling(everything=everything):
        for done, (name, call) in enumerate(_WARM_UPS):
            if progress:
                progress(name, done, len(_WARM_UPS))
            call()
