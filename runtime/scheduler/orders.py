"""What operator and PLC want, sampled once per cycle, and the operating mode that comes of it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from runtime.cnc.channel import Channel
from runtime.cnc.channel_inputs import ChannelInputs
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import plc as catalogue
from runtime.diagnostics.errors import Problem
from runtime.hli.control import AxisCommands, ChannelCommands, ModeAgreement
from runtime.hli.layout import Hli, Mode, SearchOrder, State
from runtime.hli.manual import ManualCommands
from runtime.hli.modes import Action, Refusal, Wish, Work, next_step, work_of
from runtime.hli.sampled_override import SampledOverride


class Orders:
    """Control units of the channel and of all axes, and the mode unit with its way to the wanted state."""

    def __init__(self, machine: Machine, hli: Hli) -> None:
        described = machine.channels[0]
        self._channel = hli.channels[0]
        self._channel_commands = ChannelCommands(hli.channels[0], hli.operator[0], described.parameters.max_vb_override)
        self._axis_commands = [AxisCommands(hli.axes[i]) for i in range(len(machine.axes))]
        self._path_commands = [self._axis_commands[machine.axis_index(name)] for name in described.axes]
        self._unit = hli.channels[0].control.mode_and_state
        n = len(self._path_commands)
        self.inputs = ChannelInputs(axis_holds=[False] * n, blocked=[0] * n, limits=[None] * n)
        self.manual = ManualCommands(hli.channels[0], hli.operator[0])
        delay = described.parameters.override_delay * 1e-6
        self._override = SampledOverride(delay, machine.cycle.period)
        self._rapid_override = SampledOverride(delay, machine.cycle.period)
        self._rapid_mode = described.parameters.g00_override_mode
        self.drives_on: npt.NDArray[np.bool_] = np.ones(len(machine.axes), dtype=np.bool_)
        self.lag_monitored: npt.NDArray[np.bool_] = np.ones(len(machine.axes), dtype=np.bool_)
        self.torque_limits: npt.NDArray[np.float64] = np.full(len(machine.axes), np.inf)  # share of the rated torque
        self.torque_limits_changed = False  # in this cycle
        self.park: npt.NDArray[np.bool_] = np.zeros(len(machine.axes), dtype=np.bool_)  # wanted
        self.mode = Mode.STANDBY
        self.state = State.SELECTED
        self.mode_changed = False
        self.start_work: Work | None = None  # in this cycle
        self.abort_ordered = False  # in this cycle
        self._reset_ordered = self._reset_taken = False
        self._hold = False  # by the mode unit
        self._program = ""  # loaded
        self._wish: Wish | None = None
        self._asked = True  # by the operator
        self._agreement = ModeAgreement(hli.channels[0])

    def sample(self, time: float) -> None:
        """Start of the cycle at `time` (s): read every control unit; `drives_on` (n_axes,) tells which drives shall be on."""
        commands = self._channel_commands
        commands.sample()
        self.manual.sample(self._channel.plc_present_w, time)
        changed = self.torque_limits_changed = False
        for axis in self._axis_commands:
            if axis.sample():
                changed = True
        if changed:
            self._sample_path_axes()
            self.drives_on[:] = [axis.drive_on for axis in self._axis_commands]
            self.lag_monitored[:] = [axis.lag_monitored for axis in self._axis_commands]
            limits = [axis.torque_limit for axis in self._axis_commands]
            self.torque_limits_changed = limits != self.torque_limits.tolist()
            self.torque_limits[:] = limits
            self.park[:] = [axis.parked for axis in self._axis_commands]
            self._reset_ordered = self._reset_ordered or any(axis.reset for axis in self._axis_commands)
        inputs = self.inputs
        inputs.override = self._override.take(commands.override)
        self._sample_rapid(commands.rapid_override)
        inputs.external_feed, inputs.feeds_backward = commands.external_feed, commands.feeds_backward
        inputs.time_override = commands.time_override
        inputs.feed_hold = commands.feed_hold or self._hold
        inputs.single_block = commands.single_block
        inputs.optional_stop = commands.optional_stop
        inputs.continue_motion = commands.continue_motion
        inputs.read_disable = commands.read_disable
        inputs.delete_distance = commands.delete_distance
        inputs.backward, inputs.stop_level = commands.backward, commands.stop_level
        inputs.simulate_motion, inputs.simulate_mask = commands.simulate_motion, commands.simulate_mask

    def _sample_rapid(self, ordered: float) -> None:
        """The override of rapid moves, and of what moves beside the path (P-CHAN-00181)."""
        inputs, mode = self.inputs, self._rapid_mode
        inputs.rapid_override = inputs.alone_override = inputs.override
        if mode == "NOT_USED":
            return
        rapid = self._rapid_override.take(ordered)
        inputs.rapid_override = min(rapid, inputs.override) if mode == "MINIMUM_OF_G0_G1" else rapid
        if mode == "ACTIVE_EXTENDED":
            inputs.alone_override = rapid

    def _sample_path_axes(self) -> None:
        inputs = self.inputs
        for k, axis in enumerate(self._path_commands):
            inputs.axis_holds[k] = axis.feed_hold or not axis.release
            inputs.blocked[k] = axis.blocked
            inputs.limits[k] = axis.limits
        inputs.axis_feed_hold = any(inputs.axis_holds)
        inputs.restricted = any(inputs.blocked) or any(limits is not None for limits in inputs.limits)

    def show_parked(self, parked: npt.NDArray[np.bool_]) -> None:
        """Which axes (n_axes,) are out of use."""
        for axis, state in zip(self._axis_commands, parked.tolist(), strict=True):
            axis.show_parked(state)

    def show_limits(self, channel: Channel) -> None:
        """How the path axes with dynamic limits stand to them."""
        if not self.inputs.restricted:
            return
        path = channel.interpolator.set_point + channel.beside.offset
        for k, (axis, limits) in enumerate(zip(self._path_commands, self.inputs.limits, strict=True)):
            if limits is not None:
                axis.show_limits(channel.stop_before.limit_state(k, limits, float(path[k])))

    def reference_cam(self, axis: int) -> bool | None:
        """What the PLC says of the reference cam of an axis (index in the machine), None if it says nothing."""
        return self._axis_commands[axis].reference_cam

    def spindle_override(self, axis: int) -> float:
        """Share of the programmed speed."""
        return self._axis_commands[axis].override

    def of_spindle(self, axis: int) -> AxisCommands:
        """The control units of a spindle (index in the machine)."""
        return self._axis_commands[axis]

    def axis_commands(self, axis: int) -> tuple[float, bool]:
        """Override of an axis that moves alone, and whether it is held."""
        commands = self._axis_commands[axis]
        return commands.override, commands.feed_hold or not commands.release

    @property
    def machine_lock(self) -> bool:
        """No axis shall move in a program that starts now."""
        return self._channel_commands.machine_lock

    @property
    def keeps_path(self) -> bool:
        """What a program that starts now drives is kept, to be driven backward."""
        return not self._channel_commands.backward_storage_off

    @property
    def skip_levels(self) -> int:
        """Bit n-1 is skip level n."""
        return self._channel_commands.skip_levels

    def take_search(self) -> SearchOrder | None:
        """A program is started: where it is to be entered, None at its beginning."""
        return self._channel_commands.search.take(self._channel.plc_present_w, asked=self._asked)

    def take_reset(self) -> bool:
        """A reset is ordered in this cycle, by the channel's unit, an axis' unit or the mode unit."""
        ordered = self._reset_taken = self._channel_commands.reset or self._reset_ordered
        self._reset_ordered = False
        return ordered

    # ------------------------------------------------------------------ mode unit

    def mode_step(self, channel: Channel) -> Problem | None:
        """One step of the mode unit; a refused order is handed back as a problem."""
        self.start_work = None
        self.abort_ordered = False
        before = (self.mode, self.state)
        self._follow(channel)
        refused = self._given_up() or self._take_order()
        self._unit.mode_r = self.mode
        self._unit.state_r = self.state
        self.mode_changed = (self.mode, self.state) != before
        return refused

    def _follow(self, channel: Channel) -> None:
        """The state is what the channel does."""
        if self.mode is Mode.STANDBY:
            return
        if channel.error is not None:
            self.state = State.ERROR
        elif channel.active:
            self.state = State.HOLD if channel.held else State.ACTIVE
        elif self.state in (State.ACTIVE, State.HOLD, State.ERROR):
            self.state = State.SELECTED
            self._hold = False

    def _take_order(self) -> Problem | None:
        modes = self._channel_commands.modes
        if self._wish is None:
            order = modes.take(self._channel.plc_present_w)
            if order is None:
                return None
            self._wish, self._asked = order.wish, order.asked
        for _ in range(4):  # the longest way has three steps
            step = next_step(self.mode, self.state, self._wish)
            if step is None:
                if self._wish.to_state == State.ACTIVE:
                    self._hold = False  # taken back while the path still brakes: the state has not changed
                break
            if isinstance(step, Refusal):
                if self._wish.to_state == State.ACTIVE:
                    self._channel_commands.search.start_refused()
                self._wish = None
                self._agreement.withdraw()
                modes.answer(step.problem)
                return step.problem
            if step.action is Action.SELECT and not self._agreement.given(step.mode):
                modes.answer()  # it is the PLC's turn; the order stands until it agrees
                return None
            self._carry_out(step.action, step.parameter)
            self.mode, self.state = step.mode, step.state
            if step.rest is None:
                break
            self._wish = step.rest
        self._wish = None
        modes.answer()
        return None

    def _given_up(self) -> Problem | None:
        """A reset withdraws an order that waits for the PLC."""
        if not self._reset_taken or self._wish is None:
            return None
        problem = Problem(catalogue.MODE_NOT_AGREED, {"mode": Mode(self._wish.to_mode).name})
        self._wish = None
        self._agreement.withdraw()
        self._channel_commands.modes.answer(problem)
        return problem

    def _carry_out(self, action: Action, parameter: str) -> None:
        if action is Action.LOAD:
            self._program = parameter
        elif action is Action.UNLOAD:
            self._program = ""
        elif action is Action.START:
            self.start_work = work_of(self.mode, self._program)
            self._hold = False
        elif action is Action.HOLD:
            self._hold = True
        elif action is Action.CONTINUE:
            self._hold = False
        elif action is Action.ABORT:
            self.abort_ordered = True
        elif action is Action.RESET:
            self._reset_ordered = True

    def start_refused(self) -> None:
        """The channel could not start: the program is not active."""
        self.state = State.SELECTED
        self._unit.state_r = self.state
