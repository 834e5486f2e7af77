"""The cycle of the machine: read, think, write. Everything it touches is built before the first call.

    fieldbus read ─▶ inputs to the HLI ─▶ wake the PLC ─▶ channel and axes ─▶ status to the HLI ─▶ fieldbus write

The same object runs in real time, woken by the clock, and in virtual time, as fast as it can. `cycle` never blocks; what goes
wrong in it becomes an alarm and the reaction that the catalogue gives it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from runtime.cnc.axes.compensation import AxisCompensation
from runtime.cnc.axes.homing import HomingDrive
from runtime.cnc.axes.job_slots import MachineJobs
from runtime.cnc.axes.kept_reference import KeptReferences
from runtime.cnc.axes.spindle import Spindle
from runtime.cnc.axes.spindle_orders import SpindleOrders
from runtime.cnc.axes.supervision import (
    FAULT_DRIVE,
    FAULT_DROPPED,
    FAULT_LAG,
    FAULT_OFFLINE,
    AxisFault,
    AxisSupervision,
)
from runtime.cnc.backward_motion import BackwardMotion, RepeatedStops
from runtime.cnc.beside_path import BesidePath
from runtime.cnc.channel import Channel
from runtime.cnc.gates import OperatorInfluence
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.measuring import Measuring
from runtime.cnc.motion_queue import MotionQueue
from runtime.cnc.preparation_link import PreparationLink, StartOrder
from runtime.cnc.stop_before import StopBefore
from runtime.cnc.technology import TechnologySettings
from runtime.config.machine import ChannelParameters, Machine
from runtime.diagnostics.catalogue import axis_jobs, system
from runtime.diagnostics.catalogue import machine as alarms
from runtime.diagnostics.errors import ErrorEntry, Problem, Reaction
from runtime.diagnostics.events import Event, EventKind, EventRing
from runtime.drives import DriveState, DriveSystem
from runtime.fieldbus.events import problem_of
from runtime.hli.describe import io_bits
from runtime.hli.layout import Mode
from runtime.hli.memory import HliMemory, get_text
from runtime.hli.modes import Work
from runtime.hli.technology import TechnologyPort
from runtime.scheduler.alarms import AlarmList
from runtime.scheduler.orders import Orders
from runtime.scheduler.plc_link import PlcPartner, PlcSupervision
from runtime.scheduler.publish import Publisher
from runtime.scheduler.search_orders import search_of

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
_ENABLED = int(DriveState.OPERATION_ENABLED)
_OFFLINE = int(DriveState.OFFLINE)
_PARKED_WAY = 1e-6  # mm, degrees: more than that is a motion
_UNREFERENCED = (Mode.MANUAL, Mode.HOMING)  # modes that need no reference
_SERVICE_EVERY = 64  # cycles between two looks at what the service process says
RESET_TIME = 0.5  # s that the drives get to leave their fault
SETTLED = 0.05  # s that the axes stand in position before their drives are switched off
_SETTLED_AT_LAST = 1.0  # s until that is no longer waited for: an axis may be held by what it has run into
_FAULTS = {
    FAULT_DRIVE: alarms.DRIVE_FAULT,
    FAULT_OFFLINE: alarms.DRIVE_OFFLINE,
    FAULT_LAG: alarms.FOLLOWING_ERROR,
    FAULT_DROPPED: alarms.AXIS_TRACKING,
}
_FAULTS_APART = {kind: replace(entry, reaction=Reaction.QUICK_STOP) for kind, entry in _FAULTS.items()}


def _repeated_stops(parameters: ChannelParameters) -> RepeatedStops:
    chosen = parameters.forward_backward
    return RepeatedStops(
        (chosen.disable_m00_backward, chosen.disable_m01_backward),
        (chosen.disable_m00_2nd_forward, chosen.disable_m01_2nd_forward),
    )


class Controller:
    """A whole machine in the cycle: one channel, its axes and spindles, the PLC's partner."""

    def __init__(
        self,
        machine: Machine,
        drives: DriveSystem,
        memory: HliMemory,
        events: EventRing,
        queue: MotionQueue,
        link: PreparationLink,
        plc: PlcPartner | None,
        wall_clock: Callable[[], int],
        *,
        real_drives: bool = True,
    ) -> None:
        self.machine = machine
        self.drives = drives
        self.memory = memory
        self.events = events
        hli = memory.hli
        self._head, self._platform = hli.head, hli.platform
        self.alarms = AlarmList(hli, events, wall_clock)
        described = machine.channels[0]
        self._path_axes = np.array([machine.axis_index(name) for name in described.axes])
        self._path_list: list[int] = self._path_axes.tolist()
        path_axes = [machine.axes[i] for i in self._path_list]
        self._stop_apart = described.parameters.independent_axis_error_stop
        period = self._period = machine.cycle.period
        filters = [axis.fir_filter for axis in path_axes]
        self.interpolator = Interpolator(queue, AxisLimits.of(path_axes), period, np.zeros(len(path_axes)), filters)
        indices = [machine.axis_index(spindle.bezeichnung) for spindle in described.parameters.spindel]
        spindles = [Spindle(machine.axes[i], i, period) for i in indices]
        inputs, _ = io_bits(machine)
        self._cam_bits = [inputs.get(axis.homing.switch or "", -1) if axis.homing else -1 for axis in machine.axes]
        homing = [HomingDrive(drives.image, i) for i in self._path_list]
        self.beside = BesidePath(path_axes, period, described.parameters, self._path_cam, self._path_shift, homing)
        self.channel = Channel(
            queue,
            self.interpolator,
            link,
            hli,
            hli.channels[0],
            spindles,
            {i: TechnologyPort(hli.axes[i]) for i in range(len(machine.axes))},
            TechnologySettings.of(described.parameters),
            events,
            period,
            self._path_axes,
            np.array([axis.in_position for axis in path_axes]),
            self.beside,
            StopBefore(self.interpolator, path_axes, described.parameters.hli_input_disable_condition),
            [axis.name for axis in machine.axes],
            OperatorInfluence(
                looks_at_axes=not described.parameters.suppress_ax_group_in_pos_check,
                feed_stretches_dwell=described.parameters.feed_override_weight_dwell_time,
                time_stretches_dwell=described.parameters.time_override_weight_dwell_time,
            ),
            BackwardMotion(self.interpolator, described.backward_storage, _repeated_stops(described.parameters)),
            Measuring(
                drives.image,
                [hli.axes[i] for i in self._path_list],
                self._path_list,
                [axis.name for axis in path_axes],
                period,
            ),
        )
        self.channel.actions.life.configure(described.parameters)
        self.supervision = AxisSupervision(machine, drives.image)
        self.compensation = AxisCompensation(machine, drives.image)
        self.publisher = Publisher(machine, hli, drives.image, self.supervision, self.channel, real=real_drives)
        self.orders = Orders(machine, hli)
        units = {i: self.orders.of_spindle(i) for i in indices}
        chosen = zip(indices, described.parameters.spindel, strict=True)
        moved = frozenset(i for i, spindle in chosen if spindle.plc_control)
        self.spindle_orders = SpindleOrders(hli, spindles, units, moved)
        self.jobs = MachineJobs(
            machine, hli, drives.image, self._path_list, self.channel.jobs.ordered, self, self.orders.torque_limits
        )
        self.references = KeptReferences(machine, hli, drives.image, self._has_reference, self.shift, self.refer)
        self.beside.commands = self.orders.manual
        self.supervision.lag_monitored = self.orders.lag_monitored
        self.plc = PlcSupervision(hli, plc, machine.plc.every) if plc else None
        self.cycle_number = 0
        self.time = 0.0
        self._none_on = np.zeros(len(machine.axes), dtype=np.bool_)
        self._states: list[int] = drives.image.state.tolist()
        self._enabled = [state == _ENABLED for state in self._states]
        self._path_enabled = False
        self.parked = np.zeros(len(machine.axes), dtype=np.bool_)  # out of use
        self._any_parked = False
        self._parked_at = np.zeros(len(path_axes))  # where the path has parked axes
        self._told = np.zeros(len(machine.axes), dtype=np.bool_)  # the bus has said why the axis is lost
        self._process_lost_before = 0
        self._not_retained = 0  # number of the alarm, 0 none
        self._astray: set[int] = set()  # path axes that were lost while the program ran
        self._stopping = False
        self._rested = self._in_place = 0.0  # s since the set-points rest, and since the axes are where these say
        self._moving_before = False

    # ------------------------------------------------------------------ the cycle

    def cycle(self, time: float) -> None:
        """One cycle at `time` seconds since the start of the runtime."""
        self.time = time
        self.cycle_number += 1
        self._head.cycle_r = self.cycle_number
        self._head.time_ns_r = int(time * 1e9)
        self.drives.read()
        self.publisher.inputs()
        self.orders.sample(time)
        if self.references.axes:
            for axis, problem in self.references.came():
                self.alarm(problem, axis)
        if self.orders.torque_limits_changed:
            self._limit_torques()
        self._watch_axes()
        self._watch_plc()
        if self.cycle_number % _SERVICE_EVERY == 0:
            self._watch_retaining()
        self.publisher.outputs()
        self._obey()
        self._move()
        if self.compensation.used:
            self.compensation.step()
        self.orders.show_limits(self.channel)
        self.publisher.status(self.orders.inputs.override)
        self.alarms.to_plc.poll()
        if self.references.axes:
            self.references.step()
        self.drives.write()

    def _move(self) -> None:
        """Path and spindles: one set-point for every axis."""
        image = self.drives.image
        enabled = self._enabled
        for spindle in self.channel.spindles:
            spindle.observe(float(image.actual_position[spindle.index]), float(image.actual_velocity[spindle.index]))
        self.channel.step(
            self.orders.inputs,
            self._path_enabled,
            image.actual_velocity,
            image.actual_position,
            self.time,
            self.cycle_number,
        )
        if self.channel.active and not self.channel.locked:
            if self._any_parked:
                self._move_without_parked()
            elif self._path_enabled and not self._astray:
                image.target_position[self._path_axes] = self.interpolator.set_point + self.beside.offset
            else:  # an axis without its drive tracks, the others still brake on the path
                self._brake_without_lost_axes(enabled)
        self.spindle_orders.step(enabled, image.actual_velocity, active=self.channel.active)
        if self.spindle_orders.problems:
            self._tell_spindles()
        if self.channel.feed_forward.changing:
            self.channel.feed_forward.step()
            image.feed_forward[self._path_axes] = self.channel.feed_forward.shares
        for spindle in self.channel.spindles:
            spindle.step(self.orders.spindle_override(spindle.index), enabled[spindle.index])
            image.target_velocity[spindle.index] = spindle.set_point
            if enabled[spindle.index]:
                image.target_position[spindle.index] += spindle.set_point * self._period
        self.jobs.step(
            enabled,
            self.channel.active,
            self.supervision.faults,
            self.supervision.in_position,
            self.orders.axis_commands,
        )
        while self.jobs.problems:
            axis, problem = self.jobs.problems.pop()
            self.alarm(problem, axis)
        if self.channel.problems:
            for problem in self._take_problems():
                self.alarm(problem)

    def _tell_spindles(self) -> None:
        for axis, problem in self.spindle_orders.problems:
            self.alarm(problem, axis)
        self.spindle_orders.problems.clear()

    def _move_without_parked(self) -> None:
        """Parked axes track; a path that would move one of them stops."""
        self._brake_without_lost_axes([on and not self.parked[i] for i, on in enumerate(self._enabled)])
        if self.channel.error is not None:
            return
        for k, i in enumerate(self._path_list):
            way = self.interpolator.set_point[k] + self.beside.offset[k] - self._parked_at[k]
            if self.parked[i] and abs(way) > _PARKED_WAY:
                self.alarm(Problem(alarms.PARKED_MOVED, {"axis": self.machine.axes[i].name}), i)
                return

    def _brake_without_lost_axes(self, enabled: list[bool]) -> None:
        """An axis that has left the path stays off it until the program is over: going back to it would be a jump."""
        for k, i in enumerate(self._path_list):
            if not enabled[i]:
                self._astray.add(i)
            elif i not in self._astray:
                self.drives.image.target_position[i] = self.interpolator.set_point[k] + self.beside.offset[k]

    def _path_cam(self, k: int) -> bool | None:
        return self.cam(self._path_list[k])

    def _path_shift(self, k: int, way: float) -> None:
        self.shift(self._path_list[k], way)

    def cam(self, axis: int) -> bool | None:
        """Whether an axis stands on its reference cam: from the PLC, or else from its input; None if nobody tells."""
        told = self.orders.reference_cam(axis)
        bit = self._cam_bits[axis]
        if told is not None or bit < 0:
            return told
        return bool(self.drives.image.digital_in[bit // 8] >> (bit % 8) & 1)

    def shift(self, axis: int, way: float) -> None:
        """An axis has found its reference: its coordinates shift, and so does where it is."""
        image = self.drives.image
        for positions in (image.origin, image.actual_position, image.target_position):
            positions[axis] += way

    def refer(self, axis: int, has_reference: bool) -> None:
        """A job has homed an axis, or begins to."""
        if axis in self._path_list:
            self.beside.referenced[self._path_list.index(axis)] = has_reference
        else:
            self.memory.hli.axes[axis].status.referenced_r = has_reference

    def _has_reference(self, axis: int) -> bool:
        if axis in self._path_list:
            return self.beside.referenced[self._path_list.index(axis)]
        return bool(self.memory.hli.axes[axis].status.referenced_r)

    def _take_problems(self) -> list[Problem]:
        found: list[Problem] = []
        while self.channel.problems:
            found.append(self.channel.problems.popleft())
        return found

    def _limit_torques(self) -> None:
        """The PLC has changed a torque limit. One that the drive does not get is no limit: the machine stops."""
        limits = self.orders.torque_limits
        self.drives.image.torque_limit[:] = limits
        for i in np.flatnonzero(np.isfinite(limits)).tolist():
            drive = self.machine.axes[i].drive
            if drive is None or "torque_limit" not in drive.process_data:
                self.alarm(Problem(alarms.TORQUE_LIMIT_UNKNOWN, {"axis": self.machine.axes[i].name}), i)

    # ------------------------------------------------------------------ watching

    def _watch_axes(self) -> None:
        image = self.drives.image
        self._follow_states()
        wanted = self._none_on if self._stopping and self._at_rest() and self._settled() else self.orders.drives_on
        while image.events:  # before the axes are judged: the bus knows the cause
            event = image.events.popleft()
            problem = problem_of(event, self.machine)
            if problem.entry.reaction >= Reaction.STOP_ON_PATH:
                if event.axis >= 0:
                    self._told[event.axis] = True
                elif event.node == 0:  # the bus itself
                    self._told[:] = True
            self.alarm(problem, event.axis)
        wanted = self._without_parked(wanted)
        for fault in self.supervision.monitor(wanted):
            self._axis_fault(fault)
        if not self._path_enabled:
            self._watch_tracking(wanted)

    def _follow_states(self) -> None:
        """An event for each drive that has changed its state."""
        states = self.drives.image.state.tolist()
        if states == self._states:
            return
        for i, (before, state) in enumerate(zip(self._states, states, strict=True)):
            if state != before:
                self._event(EventKind.DRIVE, number=i, value=float(state), axis=i)
        for k, i in enumerate(self._path_list):
            if states[i] == _OFFLINE:
                self.beside.lose_reference(k)
        self._states = states
        self._enabled = [state == _ENABLED for state in states]
        self._path_enabled = all(self._enabled[i] or self.parked[i] for i in self._path_list)

    def _without_parked(self, wanted: Flags) -> Flags:
        """The drives that shall be on, without those of axes out of use; that changes only while no program runs."""
        orders = self.orders
        if not self.channel.active and (self.parked != orders.park).any():
            self.parked[:] = orders.park
            self._path_enabled = all(self._enabled[i] or self.parked[i] for i in self._path_list)
        if self._any_parked or self.parked.any():
            self._any_parked = bool(self.parked.any())
            orders.show_parked(self.parked)
        return wanted & ~self.parked if self._any_parked else wanted

    def _watch_tracking(self, wanted: Flags) -> None:
        """A program cannot go on with an axis that was switched off: it would jump when it is switched on again."""
        if not self.channel.active or self.channel.error is not None or self._stopping:
            return
        for i in self._path_list:
            if not wanted[i] and not self._enabled[i] and not self.parked[i]:
                self.alarm(Problem(alarms.AXIS_TRACKING, {"axis": self.machine.axes[i].name}), i)
                return

    def _axis_fault(self, fault: AxisFault) -> None:
        """The faulty axis brakes by its drive; the others on the path, or (P-CHAN-00218) each by its drive as well."""
        axis = self.machine.axes[fault.axis]
        apart = self._stop_apart and fault.axis in self._path_list
        entry = (_FAULTS_APART if apart else _FAULTS)[fault.kind]
        if self._told[fault.axis] and fault.kind != FAULT_LAG:
            self._react(entry)
            return
        values: dict[str, object] = {
            "axis": axis.name,
            "code": int(fault.value),
            "lag": fault.value,
            "limit": axis.following_error,
        }
        self.alarm(Problem(entry, values), fault.axis)

    def _watch_plc(self) -> None:
        plc = self.plc
        if plc is None:
            return
        was = plc.running
        plc.wake(self.time)
        problem = plc.judge(int(self.time * 1e9))
        if plc.running != was:
            self._event(EventKind.PLC, number=int(plc.running))
        if problem is not None:
            self.alarm(problem)
        plc.reports(self.alarm, self.alarms.close)
        platform = self._platform
        if platform.process_lost_w != self._process_lost_before:
            self._process_lost_before = int(platform.process_lost_w)
            text = get_text(platform, "process_lost_text_w")
            self.alarm(Problem(alarms.PROCESS_LOST, {"process": text}))

    def _watch_retaining(self) -> None:
        """The service process writes what is retained, and says when it cannot."""
        failed = bool(self._platform.not_retained_w)
        if failed and not self._not_retained:
            entry = system.RETAINED_NOT_WRITTEN
            told = ErrorEntry(entry.id, "{text}", entry.severity, entry.reaction, entry.remedy)
            self._not_retained = self.alarm(Problem(told, {"text": get_text(self._platform, "not_retained_text_w")}))
        elif self._not_retained and not failed:
            self.alarms.close(self._not_retained)
            self._not_retained = 0

    # ------------------------------------------------------------------ orders and reactions

    def _obey(self) -> None:
        """What operator and PLC order in this cycle: reset, start, abort."""
        orders, channel = self.orders, self.channel
        if orders.take_reset():
            self.reset()
        refused = orders.mode_step(channel)
        if refused is not None:
            self.alarm(refused)
        not_linked = self.beside.take_orders()
        if not_linked is not None:
            self.alarm(not_linked)
        if orders.abort_ordered:
            channel.abort()
        if orders.start_work is not None:
            self._start(orders.start_work)
        moving = channel.active
        if moving != self._moving_before or orders.mode_changed:
            self._moving_before = moving
            self._event(EventKind.MODE, number=orders.mode, value=float(orders.state))

    def _start(self, work: Work) -> None:
        asked = self.orders.take_search()
        found = search_of(asked, work, self.channel.search.point, len(self._path_list))
        hindrance = self._hindrance(work.mode) or (found if isinstance(found, Problem) else None)
        if hindrance is not None:
            self.orders.start_refused()
            self.alarm(hindrance)
            return
        assert not isinstance(found, Problem)
        search, begin = found
        position = self.drives.image.target_position[self._path_axes].copy()
        self._astray.clear()
        self._parked_at[:] = position
        self.publisher.program(work.content)
        order = StartOrder(work.content, position, self.orders.skip_levels, work.mode, work.text, search, begin)
        self.channel.start(order, locked=self.orders.machine_lock, keeps_path=self.orders.keeps_path)

    def _hindrance(self, mode: Mode) -> Problem | None:
        """Why no program can start now."""
        image = self.drives.image
        if self.channel.restart_needed:
            return Problem(alarms.RESTART_NEEDED)
        if self.channel.error is not None:
            return Problem(alarms.CHANNEL_IN_ERROR)
        for i in self._path_axes:
            ready = image.state[i] == DriveState.OPERATION_ENABLED and not image.by_drive[i]
            if not ready and not self.parked[i]:
                return Problem(alarms.AXES_NOT_READY, {"axis": self.machine.axes[i].name})
        if self.plc is not None and not self.plc.running:
            return Problem(alarms.PLC_NOT_RUNNING)
        moved = self.jobs.moved_path_axis()
        if moved is not None:
            return Problem(axis_jobs.JOB_RUNS, {"axis": self.machine.axes[moved].name})
        if mode not in _UNREFERENCED:
            for i, referenced in zip(self._path_list, self.beside.referenced, strict=True):
                if not referenced and not self.parked[i]:
                    return Problem(alarms.NOT_REFERENCED, {"axis": self.machine.axes[i].name})
        return None

    def alarm(self, problem: Problem, axis: int = -1) -> int:
        """Tell it, and react as the catalogue says; returns its number in the history."""
        self._react(problem.entry)
        return self.alarms.add(problem, time=self.time, cycle=self.cycle_number, axis=axis)

    def _react(self, entry: ErrorEntry) -> None:
        if entry.reaction is Reaction.QUICK_STOP:
            self.supervision.quick_stop()
            self.jobs.let_go()
            self.channel.fail(entry)
            self.channel.abort_at_once(self.drives.image.actual_position[self._path_axes].copy())
        elif entry.reaction in (Reaction.STOP_ON_PATH, Reaction.STOP_AT_BLOCK_END):
            self.channel.fail(entry)
            self.jobs.stop(f"alarm {entry.id}")

    def reset(self) -> None:
        """Abort what runs, acknowledge faults and alarms, start the PLC again if it was lost."""
        self.channel.reset()
        self.jobs.reset()
        self.supervision.reset(max(2, round(RESET_TIME / self.machine.cycle.period)))
        self.alarms.acknowledge()
        self._not_retained = 0  # told again, if it is still so
        if self.channel.restart_needed:
            self.alarm(Problem(alarms.RESTART_NEEDED))
        self._told[:] = False
        self.drives.tell_again()
        if self.plc is not None:
            self.plc.restart()
        self._event(EventKind.RESET)

    # ------------------------------------------------------------------ the end

    def stop(self) -> None:
        """Bring everything to rest: the path brakes, the spindles stop, then the drives are switched off."""
        self._stopping = True
        self._rested = self._in_place = 0.0
        self.channel.reset()
        self.jobs.stop("the machine is switched off")

    @property
    def stopped(self) -> bool:
        """After `stop`: everything is at rest and no drive is enabled."""
        states = self.drives.image.state
        return self._stopping and self._at_rest() and not bool((states == DriveState.OPERATION_ENABLED).any())

    def _settled(self) -> bool:
        """The set-points rest, and the axes have come to where these say; one cycle of looking at it."""
        if self._in_place > SETTLED or self._rested > _SETTLED_AT_LAST:
            return True  # for good: what is switched off is no longer where it was told to be
        supervision = self.supervision
        self._rested += self._period
        there = bool((supervision.in_position | supervision.spindles | ~supervision.enabled).all())
        self._in_place = self._in_place + self._period if there else 0.0
        return False

    def _at_rest(self) -> bool:
        image = self.drives.image
        return (
            self.channel.at_rest
            and self.jobs.standing
            and all(
                image.state[spindle.index] == DriveState.OFFLINE
                or spindle.standing(image.actual_velocity[spindle.index])
                for spindle in self.channel.spindles
            )
        )

    def _event(self, kind: EventKind, number: int = 0, value: float = 0.0, axis: int = -1) -> None:
        self.events.put(Event(t=self.time, cycle=self.cycle_number, kind=kind, number=number, value=value, axis=axis))
