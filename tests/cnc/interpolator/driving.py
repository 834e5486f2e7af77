"""Drive blocks through writer, queue and interpolator as a channel does, and keep what happened in every cycle."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from runtime.cnc.blocks import Block
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.interpolator import cycle as motion
from runtime.cnc.motion_queue import MotionQueue, RecordKind
from runtime.cnc.path_preparation import PumpState, QueueWriter
from runtime.cnc.path_preparation.channel_dynamics import ChannelDynamics

Floats = npt.NDArray[np.float64]

PERIOD = 0.001


@dataclass
class Order:
    """What the operator and the channel want in a cycle."""

    override: float = 1.0
    hold: bool = False
    single_block: bool = False
    open_gates: bool = True  # whatever gate is known
    feed_queue: bool = True  # let the preparation run


Schedule = Callable[[int, Interpolator], Order]


@dataclass
class Drive:
    """One run. Element k of the lists belongs to cycle k."""

    positions: list[Floats] = field(default_factory=list)
    velocities: list[Floats] = field(default_factory=list)
    v: list[float] = field(default_factory=list)
    a: list[float] = field(default_factory=list)
    s: list[float] = field(default_factory=list)
    record: list[int] = field(default_factory=list)
    passed: list[tuple[int, int]] = field(default_factory=list)  # (cycle, index)
    starved: list[bool] = field(default_factory=list)
    at_gate: list[bool] = field(default_factory=list)
    elements: dict[int, np.void] = field(default_factory=dict)  # copies of the records by absolute index
    finished: bool = False
    overflows: int = 0
    refused: int = 0

    @property
    def path(self) -> Floats:
        """Commanded positions (cycles, n)."""
        return np.array(self.positions)

    @property
    def cycles(self) -> int:
        return len(self.v)


def always(_cycle: int, _interpolator: Interpolator) -> Order:
    return Order()


def drive(
    blocks: Iterable[Block],
    limits: AxisLimits,
    start: Floats,
    schedule: Schedule = always,
    *,
    most: int = 100_000,
    budget: int = 4000,
    capacity: int = 4096,
    keep_records: bool = True,
    weights: ChannelDynamics | None = None,
) -> Drive:
    """Run until everything is passed, or `most` cycles."""
    queue = MotionQueue(limits.n, capacity=capacity)
    writer = QueueWriter(queue, limits, PERIOD, weights=weights)
    interpolator = Interpolator(queue, limits, PERIOD, start)
    stream = iter(blocks)
    state = PumpState.MORE
    result = Drive()
    copied = 0
    for cycle in range(most):
        order = schedule(cycle, interpolator)
        if order.feed_queue and state is not PumpState.FINISHED:
            state = writer.pump(stream, budget)
            while keep_records and copied < queue.written:
                result.elements[copied] = queue.record(copied).copy()
                copied += 1
        if order.open_gates and interpolator.gate >= 0:
            interpolator.open_gate()
        interpolator.step(override=order.override, feed_hold=order.hold, single_block=order.single_block)
        result.positions.append(interpolator.position.copy())
        result.velocities.append(interpolator.velocity.copy())
        result.v.append(interpolator.path_velocity)
        result.a.append(float(interpolator._f[motion.A]))
        result.s.append(interpolator.path_position)
        result.record.append(interpolator.index)
        result.starved.append(interpolator.starved)
        result.at_gate.append(interpolator.at_gate)
        result.passed.extend((cycle, index) for index in interpolator.passed)
        told = sum(1 for _ in ()) if not result.passed else result.passed[-1][1] + 1
        done = state is PumpState.FINISHED and interpolator.standstill and interpolator.gate < 0
        last = queue.written - 1
        while last >= told and last >= 0 and int(queue.record(last)["kind"]) == RecordKind.GATE:
            last -= 1
        if done and told >= last + 1:
            result.finished = True
            break
    result.overflows = interpolator.overflows
    result.refused = interpolator.refused
    return result


def limits(velocity: float, acceleration: float, jerk: float, step: float, n: int = 3) -> AxisLimits:
    """The same limits for all axes."""
    return AxisLimits(np.full(n, velocity), np.full(n, acceleration), np.full(n, jerk), np.full(n, step))


def check_path_laws(run: Drive) -> None:
    """Limits along the path in every cycle, whatever was ordered: v, a, j of the elements, corners, no way back."""
    v, a, s = np.array([0.0, *run.v]), np.array([0.0, *run.a]), np.array([0.0, *run.s])
    assert np.isfinite(v).all()
    assert np.isfinite(a).all()
    assert np.isfinite(run.path).all()
    assert run.overflows == 0, f"{run.overflows} cycles in too many pieces"
    assert (np.diff(s) >= 0.0).all(), f"way back at {np.argmin(np.diff(s))}: {np.diff(s).min()}"
    assert (v >= 0.0).all(), "negative velocity"
    moving = {k: r for k, r in run.elements.items() if r["kind"] <= RecordKind.POLYNOMIAL}
    before = -1
    for cycle in range(run.cycles):
        now = run.record[cycle]
        if now < 0:
            continue
        touched = [moving[k] for k in range(max(before, 0), now + 1) if k in moving]
        if touched:
            A = max(float(r["a_limit"]) for r in touched)
            J = max(float(r["j_limit"]) for r in touched)
            V = max(float(r["v_limit"]) for r in touched)
            place = f"cycle {cycle}, record {now}"
            assert v[cycle + 1] <= V * (1 + 1e-6) + 1e-6, f"{place}: v {v[cycle + 1]} > {V}"
            assert abs(a[cycle + 1]) <= A * (1 + 1e-4) + 1e-3, f"{place}: a {a[cycle + 1]} > {A}"
            jump = sum(2.0 * float(r["a_entry"]) for r in touched[1:])  # in corners the acceleration may jump
            change = max(abs(a[cycle + 1] - a[cycle]) - jump, 0.0) / PERIOD
            assert change <= J * 1.05 + 10.0, f"{place}: j {change} > {J}"
            for r in touched[1:]:
                entry = float(r["v_entry"])
                # crossed somewhere in the cycle with a = 0, at most J T²/2 faster at one of its ends
                slowest = min(v[cycle], v[cycle + 1]) - J * PERIOD**2 / 2 - float(r["a_entry"]) * PERIOD
                assert slowest <= entry + 1e-6, f"{place}: corner at {slowest} > {entry}"
                assert max(v[cycle], v[cycle + 1]) <= entry + A * PERIOD + 1e-6, f"{place}: corner {entry}"
        before = max(before, now)
