"""Parts of the description that do not fit together, or are not what they have to be: found by our own checks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from runtime.diagnostics.errors import ErrorEntry, Place

Location = tuple[str | int, ...]  # keys and list indices from the root of the description


@dataclass(frozen=True, slots=True)
class Contradiction:
    """A mistake that a check of ours has found; `location` is the part of the description to blame.

    `place` is set instead where the part to blame stands in another file.
    """

    entry: ErrorEntry
    location: Location
    values: Mapping[str, object]
    at_key: bool = False  # the key itself is to blame, not its value
    place: Place | None = None


class ContradictionError(ValueError):
    """Everything found that does not fit together; locations count from the model whose validator raised it."""

    def __init__(self, contradictions: Iterable[Contradiction]) -> None:
        self.contradictions = tuple(contradictions)
        super().__init__("; ".join(c.entry.text.format(**c.values) for c in self.contradictions))
