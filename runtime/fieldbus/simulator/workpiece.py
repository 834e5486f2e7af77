"""A workpiece that the touch probes of simulated drives meet: a box in the space of some axes.

The probe is deflected while all of these axes are within their ranges. Its signal goes to every one of their drives, as if one
wire were looped through them; each latches its own position where the line between two steps crosses the face of the box.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from runtime.fieldbus.simulator.drive import SimulatedDrive


class SimulatedWorkpiece:
    """`box`: axis → from, to, in mm or degrees of its encoder since power-on; `drives` of them, with increments per unit."""

    def __init__(
        self, box: Mapping[str, tuple[float, float]], drives: Mapping[str, Sequence[tuple[SimulatedDrive, float]]]
    ) -> None:
        self._faces = [
            (drive, low * scale, high * scale) for name, (low, high) in box.items() for drive, scale in drives[name]
        ]
        self._before = [drive.servo.position for drive, _, _ in self._faces]
        self._inside = self._touches(self._before)

    def _touches(self, places: list[float]) -> bool:
        return all(low <= place <= high for place, (_, low, high) in zip(places, self._faces, strict=True)) and bool(
            places
        )

    def step(self) -> None:
        """The motors have moved: what the probes see."""
        places = [drive.servo.position for drive, _, _ in self._faces]
        inside = self._touches(places)
        if inside is not self._inside:
            share = self._crossing(places, inside)
            for (drive, _, _), before, after in zip(self._faces, self._before, places, strict=True):
                drive.motion.touch(inside, before + share * (after - before))
        self._before, self._inside = places, inside

    def _crossing(self, places: list[float], enters: bool) -> float:
        """Share of the step, 0…1, at which the box is entered (the last face is passed) or left (the first one is)."""
        shares = []
        for (_, low, high), before, after in zip(self._faces, self._before, places, strict=True):
            outside = before if enters else after
            if low <= outside <= high or before == after:
                continue
            face = low if outside < low else high
            shares.append((face - before) / (after - before))
        return (max if enters else min)(shares, default=0.0)
