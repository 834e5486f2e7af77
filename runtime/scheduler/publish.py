"""What the CNC tells through the HLI at the end of every cycle, in the interface's own units."""

from __future__ import annotations

import numpy as np

from runtime.cnc.axes.supervision import AxisSupervision
from runtime.cnc.channel import Channel
from runtime.cnc.preparation_link import PreparationState
from runtime.config.machine import AxisType, Machine
from runtime.drives import DriveImage, DriveState
from runtime.hli.layout import AxisState, Hli, StopCondition
from runtime.hli.memory import put_text
from runtime.hli.units import RAPID

LENGTH = 1e4  # 0.1 µm per mm, 0.0001 degrees per degree
SPEED = 1e3  # µm/s per mm/s, 0.001 degrees/s per degree/s
_AXIS_TYPE = {AxisType.LINEAR: 1, AxisType.ROTARY: 2, AxisType.SPINDLE: 4}
_WAIT_TECHNOLOGY = int(StopCondition.WAIT_TECHNOLOGY)
_WAIT_CONTINUE = int(StopCondition.WAIT_CONTINUE)
_DWELL = int(StopCondition.DWELL)
_FEED_HOLD = int(StopCondition.FEED_HOLD)
_AXIS_READY, _AXIS_ACTIVE = int(AxisState.READY), int(AxisState.ACTIVE)
_AXIS_HOLD, _AXIS_ERROR = int(AxisState.HOLD), int(AxisState.ERROR)
_ENABLED, _READY = int(DriveState.OPERATION_ENABLED), int(DriveState.READY_TO_SWITCH_ON)
_CANOPEN = 8
_SIMULATION = 4


class Publisher:
    """Fills the status areas; built once, so that the cycle only copies numbers."""

    def __init__(
        self,
        machine: Machine,
        hli: Hli,
        image: DriveImage,
        supervision: AxisSupervision,
        channel: Channel,
        *,
        real: bool,
    ) -> None:
        self._hli = hli
        self._image = image
        self._supervision = supervision
        self._channel = channel
        self._status = hli.channels[0].status
        self._axes = [hli.axes[i] for i in range(len(machine.axes))]
        self._axis_areas = [area.status for area in self._axes]
        self._spindles = [(spindle, hli.axes[spindle.index].spindle) for spindle in channel.spindles]
        self._digital_in = np.frombuffer(hli.image.digital_in_r, dtype=np.uint8)
        self._digital_out = np.frombuffer(hli.image.digital_out_w, dtype=np.uint8)
        self._analogue_in = np.frombuffer(hli.image.analogue_in_r)
        self._analogue_out = np.frombuffer(hli.image.analogue_out_w)
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
        self._digital_in[:] = self._image.digital_in
        self._analogue_in[:] = self._image.analogue_in

    def outputs(self) -> None:
        """The PLC's outputs, for the bus."""
        self._image.digital_out[:] = self._digital_out
        self._image.analogue_out[:] = self._analogue_out

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
        status.command_feed_r = int(min(channel.programmed_feed * SPEED, RAPID))
        status.covered_distance_r = int(path.covered * 1000.0)
        status.decoder_program_end_r = channel.link.state is not PreparationState.RUNNING
        status.stop_condition_r = stop
        status.interpolation_active_r = channel.active and not path.standstill
        status.program_end_r = channel.program_ended
        status.wait_techno_acknowledge_r = bool(stop & _WAIT_TECHNOLOGY)
        status.wait_continue_r = bool(stop & _WAIT_CONTINUE)
        status.wait_error_removal_r = channel.error is not None
        status.dwell_time_active_r = bool(stop & _DWELL)
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
        held = bool(self._channel.stop_condition & _FEED_HOLD)
        all_in_position = True
        for area, status, command, actual, velocity, lag, state, fault, code, in_position in zip(
            self._axes,
            self._axis_areas,
            (image.target_position * LENGTH).tolist(),
            (image.actual_position * LENGTH).tolist(),
            (image.actual_velocity * SPEED).tolist(),
            (supervision.lag * LENGTH).tolist(),
            image.state.tolist(),
            supervision.faults.tolist(),
            image.fault_code.tolist(),
            supervision.in_position.tolist(),
            strict=True,
        ):
            enabled = state == _ENABLED
            status.command_position_r = int(command)
            status.actual_position_r = int(actual)
            status.position_lag_r = int(lag)
            status.actual_velocity_r = int(velocity)
            status.drive_state_r = state
            status.fault_code_r = code
            status.ready_for_power_on_r = _READY <= state <= _ENABLED
            status.ready_for_control_loop_on_r = enabled
            status.in_position_r = in_position
            all_in_position = all_in_position and in_position
            if fault:
                status.axis_state_r = _AXIS_ERROR
            elif held or not enabled:
                status.axis_state_r = _AXIS_HOLD
            else:
                status.axis_state_r = _AXIS_ACTIVE if active else _AXIS_READY
            area.error_r = fault != 0
        self._status.axes_in_position_r = all_in_position
