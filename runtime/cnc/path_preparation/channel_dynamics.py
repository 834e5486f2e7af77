"""What channel parameters say of the dynamics of the path: weights by path length and by radius (6302–6531), override."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from runtime.config.machine import Machine

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


class WeightRow(Protocol):
    """A row of the parameters: it holds below `limit` (mm), `factors` weight velocity, acceleration and ramp time."""

    @property
    def limit(self) -> float: ...
    @property
    def factors(self) -> tuple[float, float, float]: ...


@dataclass(frozen=True, slots=True)
class WeightTable:
    """`limits` (rows,) grow; a row holds below its limit and from that of the row before it on, the last one for everything."""

    limits: tuple[float, ...] = ()
    factors: tuple[tuple[float, float, float], ...] = ()

    @classmethod
    def of(cls, rows: Mapping[int, WeightRow]) -> WeightTable:
        """The rows of channel parameters in the order of their indices."""
        chosen = [rows[index] for index in sorted(rows)]
        return cls(tuple(row.limit for row in chosen), tuple(row.factors for row in chosen))

    def row(self, sizes: Floats) -> Ints:
        """The row of each length or radius (k,), mm; -1 where the table is empty."""
        if not self.limits:
            return np.full(len(sizes), -1, dtype=np.int64)
        found = np.searchsorted(self.limits, sizes, side="right")
        return np.minimum(found, len(self.limits) - 1).astype(np.int64)


@dataclass(frozen=True, slots=True)
class HoldRamp:
    """How the axes brake in feed hold: mm or degrees per s² and s, each (n,); inf and 0: as hard as they can.

    P-AXIS-00024 and P-AXIS-00081.
    """

    deceleration: Floats
    ramp_time: Floats


@dataclass(frozen=True, slots=True)
class ChannelDynamics:
    """What channel parameters say of the dynamics: both tables, whether a limit of the path acceleration acts on circles too
    (P-CHAN-00350), whether the override scales what the axes leave of a feed, not the feed itself (P-CHAN-00066), whether a
    feed that the PLC commands acts on rapid moves (P-CHAN-00102), whether #FF weights it (P-CHAN-00422), and the ramp of feed
    hold if it has one of its own (P-CHAN-00097)."""

    by_length: WeightTable = WeightTable()
    by_radius: WeightTable = WeightTable()
    limit_on_circles: bool = False
    override_of_limited: bool = False
    external_on_rapid: bool = False
    feed_factor_counts: bool = True
    hold: HoldRamp | None = None
    ramp: HoldRamp | None = None  # the same, whether it holds everywhere or not


def channel_dynamics(machine: Machine, channel: int = 0) -> ChannelDynamics:
    """The tables of a channel of the machine."""
    parameters = machine.channels[channel].parameters
    axes = {axis.name: axis for axis in machine.axes}
    ramps = [axes[name].feed_hold for name in machine.channels[channel].axes]
    ramp = HoldRamp(
        np.array([math.inf if one.deceleration is None else one.deceleration for one in ramps]),
        np.array([0.0 if one.ramp_time is None else one.ramp_time for one in ramps]),
    )
    return ChannelDynamics(
        WeightTable.of(parameters.dynamic_weighting),
        WeightTable.of(parameters.curve_dynamic_weighting),
        parameters.vector.cir_radial_acc_limit,
        parameters.override_weight_prog_feed != 1,
        parameters.plc_command_rapid_feed,
        not parameters.disable_feed_factor,
        ramp if parameters.use_drive_curr_limit else None,
        ramp,
    )
