"""What the CNC tells through the HLI at the end of every cycle, in the interface's own units."""

from __future__ import annotations

from runtime.cnc.axes.supervision import AxisSupervision
from runtime.cnc.channel import Channel
from runtime.cnc.preparation_link import PreparationState
from runtime.config.machine import AxisType, Machine
from runtime.drives import DriveImage, DriveState
from runtime.hli.layout import AxisState, Hli, StopCondition
from runtime.hli.memory import put_text
from runtime.hli.units import INT32

LENGTH = 1e4  # 0.1 µm per mm, 0.0001 degrees per degree
SPEED = 1e3  # µm/s per mm/s, 0.001 degrees/s per degree/s
_AXIS_TYPE = {AxisType.LINEAR: 1, AxisType.ROTARY: 2, AxisType.SPINDLE: 4}
_CANOPEN = 8
_SIMULATION = 4


class Publisher:
    """Fills the status areas; built once, so that the cycle only copies numbers."""

    def __init__(
        self, machine: Machine, hli: Hli, image: DriveImage, supervision: AxisSupervision, channel: Channel, *, real: bool
    ) -> None:
        self._hli = hli
        self._image = image
        self._supervision = supervision
        self._channel = channel
        self._status = hli.channels[0].status
        self._axes = [hli.axes[i] for i in range(len(machine.axes))]
        self._spindles = [(spindle, hli.axes[spindle.index].spindle) for spindle in channel.spindles]
        described = machine.channels[0]
        head = hli.head
        head.channels_r = 1
        head.axes_r = len(machine.axes)
        head.cycle_time_r = round(machine.cycle.period * 1e6)
        area = hli.channels[0]
        area.name_r = described.name.encode()
        area.axis_count_r = len(described.axes)
        for k, name in enumerate(described.axes):
            area.axis_index_r[k] = machine.axis_index(name)
        for i, axis in enumerate(machine.axes):
            hli.axes[i].name_r = axis.name.encode()
            hli.axes[i].log_ax_n_r = axis.log_axis
            hli.axes[i].axis_type_r = _AXIS_TYPE[axis.type]
            hli.axes[i].status.drive_type_r = _CANOPEN if real else _SIMULATION
            hli.axes[i].status.referenced_r = True  # absolute encoders; homing is not in this version

    def inputs(self) -> None:
        """Start of the cycle: the machine's inputs, for the PLC."""
        image, area = self._image, self._hli.image
        area.digital_in_r[:] = image.digital_in.tolist()
        area.analogue_in_r[:] = image.analogue_in.tolist()

    def outputs(self) -> None:
        """The PLC's outputs, for the bus."""
        image, area = self._image, self._hli.image
        image.digital_out[:] = area.digital_out_w
        image.analogue_out[:] = area.analogue_out_w

    def program(self, name: str) -> None:
        """A program starts."""
        put_text(self._status, "program_name_r", name)

    def status(self, override: float) -> None:
        """End of the cycle: channel, axes, spindles, bus figures."""
        channel, path = self._channel, self._channel.interpolator
        status = self._status
        stop = channel.stop_condition
        status.active_feed_r = int(path.path_velocity * SPEED)
        status.active_override_r = int(override * 1000.0 + 0.5)
        status.path_position_r = path.path_position * LENGTH
        status.line_r = max(path.line, 0) if channel.active else 0
        status.block_number_r = path.n
        status.block_counter_r = channel.block_counter
        status.command_feed_r = int(min(channel.programmed_feed * SPEED, INT32))
        status.covered_distance_r = int(path.covered * 1000.0)
        status.decoder_program_end_r = channel.link.state is not PreparationState.RUNNING
        status.stop_condition_r = int(stop)
        status.interpolation_active_r = channel.active and not path.standstill
        status.program_end_r = channel.program_ended
        status.wait_techno_acknowledge_r = bool(stop & StopCondition.WAIT_TECHNOLOGY)
        status.wait_continue_r = bool(stop & StopCondition.WAIT_CONTINUE)
        status.wait_error_removal_r = channel.error is not None
        status.dwell_time_active_r = bool(stop & StopCondition.DWELL)
        status.prepared_blocks_r = channel.queue.capacity - channel.queue.free
        status.waiting_functions_r = channel.waiting_functions
        status.error_id_r = channel.error.id if channel.error else 0
        self._axis_status(channel.active)
        for spindle, area in self._spindles:
            actual = self._image.actual_velocity[spindle.index]
            area.mode_r = int(spindle.mode)
            area.programmed_speed_r = int(spindle.programmed_speed * SPEED)
            area.command_speed_r = int(spindle.set_point * SPEED)
            area.actual_speed_r = int(actual * SPEED)
            area.rev_erreicht_r = spindle.reached(actual)
            area.rev_null_r = spindle.standing(actual)
        platform, image = self._hli.platform, self._image
        platform.bus_load_r = image.bus_load
        platform.emcy_count_r = image.emcy_count
        platform.frames_sent_r = image.frames_sent
        platform.frames_received_r = image.frames_received

    def _axis_status(self, active: bool) -> None:
        image, supervision = self._image, self._supervision
        target = image.target_position.tolist()
        actual = image.actual_position.tolist()
        velocity = image.actual_velocity.tolist()
        lag = supervision.lag.tolist()
        states = image.state.tolist()
        faults = supervision.faults.tolist()
        codes = image.fault_code.tolist()
        in_position = supervision.in_position.tolist()
        held = bool(self._channel.stop_condition & StopCondition.FEED_HOLD)
        all_in_position = True
        for i, area in enumerate(self._axes):
            enabled = states[i] == DriveState.OPERATION_ENABLED
            status = area.status
            status.command_position_r = int(target[i] * LENGTH)
            status.actual_position_r = int(actual[i] * LENGTH)
            status.position_lag_r = int(lag[i] * LENGTH)
            status.actual_velocity_r = int(velocity[i] * SPEED)
            status.drive_state_r = states[i]
            status.fault_code_r = codes[i]
            status.ready_for_power_on_r = states[i] >= DriveState.READY_TO_SWITCH_ON and states[i] <= 5
            status.ready_for_control_loop_on_r = enabled
            status.in_position_r = in_position[i]
            all_in_position = all_in_position and in_position[i]
            if faults[i]:
                status.axis_state_r = AxisState.ERROR
            elif not enabled or held:
                status.axis_state_r = AxisState.HOLD
            else:
                status.axis_state_r = AxisState.ACTIVE if active else AxisState.READY
            area.error_r = faults[i] != 0
        self._status.axes_in_position_r = all_in_position


