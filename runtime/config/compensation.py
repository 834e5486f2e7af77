"""Corrections between an axis and its drive: backlash, and the errors of its screw or scale along the way."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Annotated

from pydantic import Field, model_validator

from runtime.config.contradictions import Contradiction, ContradictionError
from runtime.config.model import FileBeside, Model
from runtime.config.quantity_fields import Length, Velocity
from runtime.diagnostics.catalogue import configuration as errors

GREATEST_ROWS = 4096
STEEPEST = 0.02  # greatest change of the error per way: more is no table of errors

Row = Annotated[tuple[float, float], Field(strict=False)]


class Compensation(Model):
    """What is added between the position of the axis and that of its drive, and taken away from what the drive tells."""

    backlash: Annotated[Length, Field(ge=0)] = 0.0  # way that is lost at a reversal
    pitch_errors: (
        FileBeside | Annotated[tuple[Row, ...], Field(strict=False)]
    ) = ()  # rows of position and error, or a file of them
    velocity: Velocity = 5.0  # greatest speed of a change of the correction, mm/s or degrees/s

    @model_validator(mode="after")
    def _usable(self) -> Compensation:
        try:
            rows = self.rows()
        except (OSError, ValueError) as error:
            raise _bad(getattr(error, "strerror", None) or str(error)) from None
        if len(rows) == 1:
            raise _bad("one row is no table: two are needed at least")
        if len(rows) > GREATEST_ROWS:
            raise _bad(f"{len(rows)} rows, {GREATEST_ROWS} are the most")
        for (before, first), (place, second) in pairwise(rows):
            if not place > before:
                raise _bad(f"positions have to increase: {place:g} stands behind {before:g}")
            if not abs(second - first) <= STEEPEST * (place - before):
                raise _bad(f"between {before:g} and {place:g} the error changes by more than {STEEPEST:.0%} of the way")
        return self

    def rows(self) -> tuple[tuple[float, float], ...]:
        """Positions and errors, mm or degrees. Raises OSError or ValueError for a file that cannot be read."""
        if not isinstance(self.pitch_errors, str):
            return self.pitch_errors
        found: list[tuple[float, float]] = []
        for number, line in enumerate(Path(self.pitch_errors).read_text(encoding="utf-8").splitlines(), 1):
            text = line.partition("#")[0].strip()
            if not text:
                continue
            fields = text.replace(";", " ").replace(",", " ").split()
            try:
                place, error = (float(field) for field in fields)
            except ValueError:
                if not found and number == 1:
                    continue  # names of the columns
                raise ValueError(f"line {number} is not `position, error`") from None
            found.append((place, error))
        return tuple(found)


def _bad(reason: str) -> ContradictionError:
    return ContradictionError([Contradiction(errors.COMPENSATION_TABLE, ("pitch_errors",), {"reason": reason})])
