"""Parameters of the NCT dialect: what its manual calls the parameter memory, under the names of the manual."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from runtime.config.model import Model
from runtime.config.quantity_fields import Length


class NctParameters(Model):
    """Machine dependent values of a channel for programs of the NCT dialect."""

    DELTV: Annotated[Length, Field(ge=0)] = 0.0  # corner vectors nearer to each other in both axes become one
    INTERFER: bool = True  # cutter compensation looks whether the tool would run against the programmed direction,
    ANGLAL: bool = True  # which is an error at once; false: vectors of the corners are left out until it does not
    ANG_ACCU: bool = False  # angles of G68 count in 0.00001 degrees, false: in 0.001
