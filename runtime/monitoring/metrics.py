"""Which figures of a running machine are metrics, and how each is read from the interface memory: the one table.

Names and units follow the Prometheus conventions: base units (seconds, meters, ratios of 0 to 1), `_total` for what
only grows. Linear axes are in meters, axes that turn in degrees, under different names, so that no series mixes units.
A state is a gauge per possible state, 1 for the one that holds.
"""

from __future__ import annotations

import itertools
import platform
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum, IntEnum, IntFlag
from typing import Protocol

from runtime.diagnostics.version import version
from runtime.drives import DriveState
from runtime.hli.layout import Axis, BusStatus, Channel, Hli, Mode, State, StopCondition

_LENGTH = 1e-7  # 0.1 µm in m
_SPEED = 1e-6  # µm/s in m/s
_ANGLE = 1e-4  # 0.0001 degrees in degrees
_TURNING = 1e-3  # 0.001 degrees/s in degrees/s
_LINEAR_AXIS = 1  # axis_type_r


class HistogramReading(Protocol):
    """A histogram of durations, as runtime.scheduler.statistics keeps it."""

    @property
    def bounds(self) -> tuple[float, ...]:
        """Upper bounds of all buckets but the last, s."""

    @property
    def counts(self) -> tuple[int, ...]:
        """Durations per bucket, one more than there are bounds."""

    @property
    def sum(self) -> float:
        """All durations together, s."""


class CycleReading(Protocol):
    """The histograms of the cycle."""

    @property
    def work(self) -> HistogramReading:
        """Start to end of the work."""

    @property
    def lateness(self) -> HistogramReading:
        """Due time to start."""


class RecorderReading(Protocol):
    """Figures of the flight recorder, as runtime.recorder.drain keeps them."""

    bytes: int  # on the disk
    records: int  # cycles that were recorded
    dropped: int  # that found the ring full
    lost: int  # that the disk did not take
    saved: int  # recordings that alarms have saved
    writing: bool


@dataclass(frozen=True, slots=True)
class Source:
    """What the metrics are read from."""

    hli: Hli
    cycle: CycleReading
    errors: Mapping[tuple[str, str], int]  # (id, severity) -> how often
    recorder: RecorderReading | None = None


class Kind(Enum):
    GAUGE = "gauge"
    COUNTER = "counter"
    HISTOGRAM = "histogram"


Samples = Iterator[tuple[tuple[str, ...], float]]  # values of the labels, value


@dataclass(frozen=True, slots=True)
class Metric:
    """A row of the table: `name` as it is scraped (counters with `_total`), the labels, and how to read all samples."""

    name: str
    kind: Kind
    help: str
    labels: tuple[str, ...] = ()
    read: Callable[[Source], Samples] | None = None
    histogram: Callable[[Source], HistogramReading] | None = None


# ---------------------------------------------------------------------------------------------- ways to read


def _one(value: Callable[[Hli], float]) -> Callable[[Source], Samples]:
    def read(source: Source) -> Samples:
        yield (), value(source.hli)

    return read


def _recorder(value: Callable[[RecorderReading], float]) -> Callable[[Source], Samples]:
    """Nothing is told of a recorder that is switched off."""

    def read(source: Source) -> Samples:
        if source.recorder is not None:
            yield (), value(source.recorder)

    return read


def _lost(source: Source) -> Samples:
    if source.recorder is not None:
        yield ("ring",), source.recorder.dropped
        yield ("disk",), source.recorder.lost


def _text(raw: bytes) -> str:
    return raw.decode("utf-8", "replace")


def _axes(hli: Hli) -> Iterator[Axis]:
    return (hli.axes[index] for index in range(hli.head.axes_r))


def _channels(hli: Hli) -> Iterator[Channel]:
    return (hli.channels[index] for index in range(hli.head.channels_r))


def _per_axis(value: Callable[[Axis], float], *, linear: bool | None = None) -> Callable[[Source], Samples]:
    """`linear`: only the linear axes (True), only those that turn (False), all (None)."""

    def read(source: Source) -> Samples:
        for axis in _axes(source.hli):
            if linear is None or linear == (axis.axis_type_r == _LINEAR_AXIS):
                yield (_text(axis.name_r),), value(axis)

    return read


def _per_channel(value: Callable[[Channel], float]) -> Callable[[Source], Samples]:
    def read(source: Source) -> Samples:
        for channel in _channels(source.hli):
            yield (_text(channel.name_r),), value(channel)

    return read


def _states(owner: str, states: type[IntEnum], value: int) -> Samples:
    for state in states:
        yield (owner, state.name.lower()), float(state == value)


def _drive_states(source: Source) -> Samples:
    for axis in _axes(source.hli):
        yield from _states(_text(axis.name_r), DriveState, axis.status.drive_state_r)


def _channel_states(states: type[IntEnum], value: Callable[[Channel], int]) -> Callable[[Source], Samples]:
    def read(source: Source) -> Samples:
        for channel in _channels(source.hli):
            yield from _states(_text(channel.name_r), states, value(channel))

    return read


def _stop_conditions(source: Source) -> Samples:
    conditions: Sequence[IntFlag] = [condition for condition in StopCondition if condition]
    for channel in _channels(source.hli):
        holds = channel.status.stop_condition_r
        for condition in conditions:
            yield (_text(channel.name_r), str(condition.name).lower()), float(bool(holds & condition))


def _build(source: Source) -> Samples:
    yield (version(), platform.python_version(), _text(source.hli.head.version_r)), 1.0


def _frames(source: Source) -> Samples:
    yield ("sent",), source.hli.platform.frames_sent_r
    yield ("received",), source.hli.platform.frames_received_r


def _buses(source: Source) -> Iterator[BusStatus]:
    platform = source.hli.platform
    return itertools.islice(platform.bus_r, platform.bus_count_r)


def _loads(source: Source) -> Samples:
    for bus in _buses(source):
        yield (_text(bus.channel_r),), bus.load_r


def _gone(source: Source) -> Samples:
    for bus in _buses(source):
        yield (_text(bus.channel_r),), float(bus.gone_r)


def _errors(source: Source) -> Samples:
    yield from source.errors.items()


# ---------------------------------------------------------------------------------------------- the table

METRICS: tuple[Metric, ...] = (
    Metric(
        "tandem_build_info",
        Kind.GAUGE,
        "Versions of the distribution, of Python and of the interface layout; always 1.",
        ("version", "python", "interface"),
        _build,
    ),
    Metric(
        "tandem_running",
        Kind.GAUGE,
        "1 while the cycle runs, 0 before its start and after its end.",
        read=_one(lambda hli: hli.head.running_r),
    ),
    # the cycle
    Metric(
        "tandem_cycle_work_seconds",
        Kind.HISTOGRAM,
        "Time that the work of a cycle takes.",
        histogram=lambda source: source.cycle.work,
    ),
    Metric(
        "tandem_cycle_lateness_seconds",
        Kind.HISTOGRAM,
        "Time from when a cycle is due to when it starts: the jitter.",
        histogram=lambda source: source.cycle.lateness,
    ),
    Metric(
        "tandem_cycle_period_seconds",
        Kind.GAUGE,
        "Time between two cycles, as configured.",
        read=_one(lambda hli: hli.head.cycle_time_r / 1e6),
    ),
    Metric("tandem_cycles_total", Kind.COUNTER, "Cycles since the start.", read=_one(lambda hli: hli.head.cycle_r)),
    Metric(
        "tandem_cycle_overruns_total",
        Kind.COUNTER,
        "Cycles that were due while the one before was still at work.",
        read=_one(lambda hli: hli.platform.overruns_r),
    ),
    # the PLC
    Metric(
        "tandem_plc_running",
        Kind.GAUGE,
        "1 while the PLC program runs and its watchdog is satisfied.",
        read=_one(lambda hli: hli.platform.plc_running_r),
    ),
    Metric(
        "tandem_plc_cycle_seconds",
        Kind.GAUGE,
        "Time that the last PLC cycle took.",
        read=_one(lambda hli: hli.platform.plc_cycle_time_ns_w / 1e9),
    ),
    Metric(
        "tandem_plc_overruns_total",
        Kind.COUNTER,
        "PLC cycles that were due while the one before was still at work.",
        read=_one(lambda hli: hli.platform.plc_overruns_r),
    ),
    # the bus
    Metric(
        "tandem_can_load_ratio",
        Kind.GAUGE,
        "Share of the capacity of a CAN bus that is used.",
        ("channel",),
        _loads,
    ),
    Metric("tandem_can_bus_gone", Kind.GAUGE, "1 while a CAN bus is off or out of order.", ("channel",), _gone),
    Metric("tandem_can_frames_total", Kind.COUNTER, "CAN frames of the master.", ("direction",), _frames),
    Metric(
        "tandem_can_emcy_total",
        Kind.COUNTER,
        "Emergency messages (EMCY) of all nodes.",
        read=_one(lambda hli: hli.platform.emcy_count_r),
    ),
    # axes
    Metric(
        "tandem_axis_position_meters",
        Kind.GAUGE,
        "Actual position of a linear axis.",
        ("axis",),
        _per_axis(lambda axis: axis.status.actual_position_r * _LENGTH, linear=True),
    ),
    Metric(
        "tandem_axis_position_degrees",
        Kind.GAUGE,
        "Actual position of a rotary axis or spindle.",
        ("axis",),
        _per_axis(lambda axis: axis.status.actual_position_r * _ANGLE, linear=False),
    ),
    Metric(
        "tandem_axis_following_error_meters",
        Kind.GAUGE,
        "Command minus actual position of a linear axis.",
        ("axis",),
        _per_axis(lambda axis: axis.status.position_lag_r * _LENGTH, linear=True),
    ),
    Metric(
        "tandem_axis_following_error_degrees",
        Kind.GAUGE,
        "Command minus actual position of a rotary axis or spindle.",
        ("axis",),
        _per_axis(lambda axis: axis.status.position_lag_r * _ANGLE, linear=False),
    ),
    Metric(
        "tandem_axis_velocity_meters_per_second",
        Kind.GAUGE,
        "Actual velocity of a linear axis.",
        ("axis",),
        _per_axis(lambda axis: axis.status.actual_velocity_r * _SPEED, linear=True),
    ),
    Metric(
        "tandem_axis_velocity_degrees_per_second",
        Kind.GAUGE,
        "Actual velocity of a rotary axis or spindle; 6 degrees/s are 1 rev/min.",
        ("axis",),
        _per_axis(lambda axis: axis.status.actual_velocity_r * _TURNING, linear=False),
    ),
    Metric(
        "tandem_axis_drive_state",
        Kind.GAUGE,
        "State of the drive (CiA 402): 1 for the state that holds, 0 for the others.",
        ("axis", "state"),
        _drive_states,
    ),
    Metric(
        "tandem_axis_error",
        Kind.GAUGE,
        "1 while the axis is in error.",
        ("axis",),
        _per_axis(lambda axis: axis.error_r),
    ),
    # channels
    Metric(
        "tandem_channel_mode",
        Kind.GAUGE,
        "Operating mode: 1 for the mode that holds, 0 for the others.",
        ("channel", "mode"),
        _channel_states(Mode, lambda channel: int(channel.control.mode_and_state.mode_r)),
    ),
    Metric(
        "tandem_channel_state",
        Kind.GAUGE,
        "State inside the mode: 1 for the state that holds, 0 for the others.",
        ("channel", "state"),
        _channel_states(State, lambda channel: int(channel.control.mode_and_state.state_r)),
    ),
    Metric(
        "tandem_channel_stop_condition",
        Kind.GAUGE,
        "Why the path does not move although a program is active: 1 for each condition that holds.",
        ("channel", "condition"),
        _stop_conditions,
    ),
    Metric(
        "tandem_channel_active_line",
        Kind.GAUGE,
        "Program line of the block in the interpolator.",
        ("channel",),
        _per_channel(lambda channel: channel.status.line_r),
    ),
    Metric(
        "tandem_channel_override_ratio",
        Kind.GAUGE,
        "Feed override in force.",
        ("channel",),
        _per_channel(lambda channel: channel.status.active_override_r / 1000),
    ),
    Metric(
        "tandem_channel_feed_meters_per_second",
        Kind.GAUGE,
        "Actual path velocity.",
        ("channel",),
        _per_channel(lambda channel: channel.status.active_feed_r * _SPEED),
    ),
    Metric(
        "tandem_channel_functions_waiting",
        Kind.GAUGE,
        "Technology functions (M, H, S, T) that the PLC has not yet acknowledged.",
        ("channel",),
        _per_channel(lambda channel: channel.status.waiting_functions_r),
    ),
    Metric(
        "tandem_channel_prepared_blocks",
        Kind.GAUGE,
        "Path elements that wait in the motion queue.",
        ("channel",),
        _per_channel(lambda channel: channel.status.prepared_blocks_r),
    ),
    Metric(
        "tandem_channel_blocks_total",
        Kind.COUNTER,
        "NC blocks that were finished.",
        ("channel",),
        _per_channel(lambda channel: channel.status.block_counter_r),
    ),
    # flight recorder
    Metric(
        "tandem_recorder_bytes",
        Kind.GAUGE,
        "Bytes that the flight recorder has on the disk.",
        read=_recorder(lambda recorder: recorder.bytes),
    ),
    Metric(
        "tandem_recorder_writing",
        Kind.GAUGE,
        "1 while the disk takes what is recorded.",
        read=_recorder(lambda recorder: recorder.writing),
    ),
    Metric(
        "tandem_recorder_records_total",
        Kind.COUNTER,
        "Cycles that were recorded.",
        read=_recorder(lambda recorder: recorder.records),
    ),
    Metric(
        "tandem_recorder_dropped_total",
        Kind.COUNTER,
        "Recorded cycles that were lost, as the ring or the disk was full.",
        ("at",),
        _lost,
    ),
    Metric(
        "tandem_recorder_saved_total",
        Kind.COUNTER,
        "Recordings that alarms have saved.",
        read=_recorder(lambda recorder: recorder.saved),
    ),
    # errors
    Metric(
        "tandem_errors_total",
        Kind.COUNTER,
        "Errors and warnings, by their number in the catalogue.",
        ("id", "severity"),
        _errors,
    ),
)
