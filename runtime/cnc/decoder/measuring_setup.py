"""What the configuration says of measuring: the probes of the axes (P-AXIS-00118, 00215, 00516…00518), and the parameters of the
channel."""

from __future__ import annotations

from dataclasses import dataclass

from runtime.cnc.blocks import ProbeSignal
from runtime.config.machine import Axis, ChannelParameters, Machine
from runtime.hli.describe import io_bits


@dataclass(frozen=True, slots=True)
class AxisProbe:
    """The probe of an axis. `number`: touch probe of its drive; `level`: bit of the process image, -1 none; `feed` in mm/min or
    degrees/min; `latched`: touch probes of the drive with the edges (TRUE rising) that it tells."""

    signal: ProbeSignal
    number: int = 1
    level: int = -1
    rising: bool = True
    feed: float | None = None
    latched: frozenset[tuple[int, bool]] = frozenset()

    @classmethod
    def of(cls, axis: Axis, inputs: dict[str, int]) -> AxisProbe | None:
        """Of an axis as it is described; None if it does not measure."""
        setup = axis.measuring
        if setup is None:
            return None
        names = () if axis.drive is None else axis.drive.process_data
        parts = [name.split("_") for name in names if name.startswith("probe_")]
        return cls(
            ProbeSignal[setup.signal.upper()],
            setup.touch_probe,
            inputs.get(setup.input or "", -1),
            setup.edge == "rising",
            None if setup.feed is None else setup.feed * 60.0,
            frozenset((int(number), edge == "rising") for _, number, edge in parts),
        )


@dataclass(frozen=True, slots=True)
class MeasuringChannel:
    """The probes of the axes, (n,), and the parameters of the channel."""

    probes: tuple[AxisProbe | None, ...] = ()
    type: int = 1  # P-CHAN-00057
    error_no_signal: bool = False  # P-CHAN-00176
    brakes_as_rapid: bool = False  # P-CHAN-00214
    within_limits: bool = False  # P-CHAN-00268
    as_feed: bool = False  # P-CHAN-00296
    includes_ball: bool = True  # P-CHAN-00311
    may_be_deflected: bool = False  # P-CHAN-00312
    error_no_way: bool = True  # P-CHAN-00313
    command_counts: bool = False  # P-CHAN-00440
    all_axes: bool = False  # P-CHAN-00327

    @classmethod
    def of(cls, machine: Machine, axes: list[Axis], parameters: ChannelParameters) -> MeasuringChannel:
        """Of a channel with these axes."""
        inputs, _ = io_bits(machine)
        return cls(
            tuple(AxisProbe.of(axis, inputs) for axis in axes),
            parameters.messtyp,
            parameters.meas_error_no_signal,
            bool(parameters.meas_deceleration_mode),
            parameters.meas_soft_limit_move_path,
            parameters.meas_use_std_dynamic,
            not parameters.meas_pcs_value_no_probe_radius,
            parameters.meas_allow_actuated_probe,
            parameters.meas_error_no_move_path,
            parameters.meas_trafo_with_cmd_pos,
            parameters.meas_all_axes,
        )
