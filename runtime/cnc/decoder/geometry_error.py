"""What the pure geometry of the decoder raises: it knows no places, the decoder adds line and column."""

from __future__ import annotations

from runtime.diagnostics.errors import ErrorEntry


class GeometryError(Exception):
    """What is programmed is no geometry: a catalogue entry and the values of its text."""

    def __init__(self, entry: ErrorEntry, **values: object) -> None:
        super().__init__(entry.id)
        self.entry = entry
        self.values = values
