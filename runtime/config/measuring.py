"""An axis that measures: where the signal of its probe comes from."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from runtime.config.model import Model
from runtime.config.quantity_fields import Velocity

SignalName = Literal["drive", "input", "plc", "plc_first_event", "plc_timestamp"]


class MeasuringSetup(Model):
    """The axis may be named in a measuring block (P-AXIS-00118).

    `drive`: the touch probe of its drive latches the position itself. `input`: an input of the process image. `plc`: the control
    unit probing_signal of the axis; with `plc_first_event` that of any axis counts for all, with `plc_timestamp` the unit
    probing_time says when.
    """

    signal: SignalName = "drive"  # P-AXIS-00516
    touch_probe: Annotated[int, Field(ge=1, le=2)] = 1  # P-AXIS-00517, of the drive
    input: str | None = None  # name of the input; with `drive` the one that tells whether the probe is deflected
    edge: Literal["rising", "falling"] = "rising"  # P-AXIS-00518
    feed: Velocity | None = None  # P-AXIS-00215, of measuring type 2
