"""What the CNC tells through the HLI at the end of every cycle, in the interface's own units."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from runtime.cnc.axes.supervision import AxisSupervision
from runtime.cnc.block_search import PointOfInterruption
from runtime.cnc.channel import Channel
from runtime.config.machine import Machine
from runtime.drives import DriveImage, DriveState
from runtime.hli.describe import describe_machine
from runtime.hli.layout import NAME, AxisState, Hli, StopCondition
from runtime.hli.memory import put_text
from runtime.hli.records import records
from runtime.hli.units import RAPID
from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]
LENGTH = 1e4  # 0.1 µm per mm, 0.0001 degrees per degree
TURN = 360.0  # degrees
SPEED = 1e3  # µm/s per mm/s, 0.001 degrees/s per degree/s
_WAIT_TECHNOLOGY = int(StopCondition.WAIT_TECHNOLOGY)
_WAIT_CONTINUE = int(StopCondition.WAIT_CONTINUE)
_DWELL = int(StopCondition.DWELL)
_FEED_HOLD = int(StopCondition.FEED_HOLD | StopCondition.AXIS_FEED_HOLD)
_AXIS_READY, _AXIS_ACTIVE = int(AxisState.READY), int(AxisState.ACTIVE)
_AXIS_HOLD, _AXIS_ERROR = int(AxisState.HOLD), int(AxisState.ERROR)
# The master takes a drive out of "switch on disabled" when it is to be enabled, and not before.
_ENABLED, _CAN_BE_ENABLED = int(DriveState.OPERATION_ENABLED), int(DriveState.SWITCH_ON_DISABLED)
_SIMULATION, _CANOPEN, _VIRTUAL = 4, 8, 16  # drive_type_r
_AXIS_ELEMENTS = (
    "status.axis_state_r",
    "status.command_position_r",
    "status.actual_position_r",
    "status.position_lag_r",
    "status.actual_velocity_r",
    "status.actual_torque_r",
    "status.drive_state_r",
    "status.drive_mode_r",
    "status.fault_code_r",
    "status.ready_for_power_on_r",
    "status.ready_for_control_loop_on_r",
    "status.in_position_r",
    "error_r",
)


@kernel
def _fill_axes(
    areas: npt.NDArray[np.void],
    target: Floats,
    actual: Floats,
    velocity: Floats,
    torque: Floats,
    lag: Floats,
    window: Floats,
    turn: Floats,
    state: npt.NDArray[np.int8],
    mode: npt.NDArray[np.int8],
    faults: npt.NDArray[np.int8],
    fault_code: npt.NDArray[np.int32],
    active: bool,
    held: bool,
) -> bool:
    """Fill the status of every axis; whether all are in position. Arrays (n_axes,); `areas` by `_AXIS_ELEMENTS`.

    `turn` (n_axes,): degrees in which positions of axes that turn without end are shown, 0 for others.
    """
    all_in_position = True
    for i in range(target.shape[0]):
        area = areas[i]
        enabled = state[i] == _ENABLED
        in_position = abs(lag[i]) <= window[i]
        command, place = target[i], actual[i]
        if turn[i] > 0.0:
            command -= turn[i] * np.floor(command / turn[i])
            place -= turn[i] * np.floor(place / turn[i])
        area["command_position_r"] = int(command * LENGTH)
        area["actual_position_r"] = int(place * LENGTH)
        area["position_lag_r"] = int(lag[i] * LENGTH)
        area["actual_velocity_r"] = int(velocity[i] * SPEED)
        area["actual_torque_r"] = int(torque[i] * 1000.0)
        area["drive_state_r"] = state[i]
        area["drive_mode_r"] = mode[i]
        area["fault_code_r"] = fault_code[i]
        area["ready_for_power_on_r"] = _CAN_BE_ENABLED <= state[i] <= _ENABLED
        area["ready_for_control_loop_on_r"] = enabled
        area["in_position_r"] = in_position
        area["error_r"] = faults[i] != 0
        if faults[i] != 0:
            area["axis_state_r"] = _AXIS_ERROR
        elif held or not enabled:
            area["axis_state_r"] = _AXIS_HOLD
        else:
            area["axis_state_r"] = _AXIS_ACTIVE if active else _AXIS_READY
        if not in_position:
            all_in_position = False
    return all_in_position


@warms("status of the axes")
def _warm() -> None:
    areas = records(Hli().axes, 1, *_AXIS_ELEMENTS)
    floats, states = np.zeros(1), np.zeros(1, dtype=np.int8)
    codes = np.zeros(1, dtype=np.int32)
    _fill_axes(
        areas, floats, floats, floats, floats, floats, floats, floats, states, states, states, codes, False, False
    )


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
        self._image = image
        self._supervision = supervision
        self._channel = channel
        self._status = hli.channels[0].status
        self._platform = hli.platform
        self._turn = np.array([TURN if axis.turns_without_end else 0.0 for axis in machine.axes])
        self._axes = records(hli.axes, len(machine.axes), *_AXIS_ELEMENTS)
        self._source = (-2, False)
        self._spindles = [(spindle, hli.axes[spindle.index].spindle) for spindle in channel.spindles]
        self._digital_in = np.frombuffer(hli.image.digital_in_r, dtype=np.uint8)
        self._digital_out = np.frombuffer(hli.image.digital_out_w, dtype=np.uint8)
        self._analogue_in = np.frombuffer(hli.image.analogue_in_r)
        self._analogue_out = np.frombuffer(hli.image.analogue_out_w)
        self._image_area = hli.image
        self._valid_before = b""
        describe_machine(hli, machine)
        for axis, described in zip(hli.axes, machine.axes, strict=False):
            there = described.drive is not None
            axis.status.drive_type_r = (_CANOPEN if real else _SIMULATION) if there else _VIRTUAL
            axis.status.referenced_r = described.homing is None  # see `_beside` for the path axes
        self._path_areas = [hli.axes[machine.axis_index(name)] for name in machine.channels[0].axes]
        self._interruption = self._status.interruption
        self._told_point: PointOfInterruption | None = None
        self._displays = [self._status.hb_display_r[k] for k in range(len(self._path_areas))]
        self._by_hand = True

    def inputs(self) -> None:
        """Start of the cycle: the machine's inputs, for the PLC."""
        self._digital_in[:] = self._image.digital_in
        self._analogue_in[:] = self._image.analogue_in
        valid = self._image.analogue_valid.tobytes()
        if valid != self._valid_before:
            self._valid_before = valid
            self._image_area.analogue_valid_r = sum(1 << k for k, one in enumerate(valid) if one)

    def outputs(self) -> None:
        """The PLC's outputs, for the bus."""
        self._image.digital_out[:] = self._digital_out
        self._image.analogue_out[:] = self._analogue_out

    def program(self, name: str) -> None:
        """A program starts."""
        put_text(self._status, "program_name_r", name)

    def status(self, override: float) -> None:
        """End of the cycle: channel, axes, spindles, bus figures."""
        channel, path, image = self._channel, self._channel.interpolator, self._image
        active, stop = channel.active, channel.stop_condition
        status = self._status
        status.active_feed_r = int(channel.shown_feed * SPEED)
        status.active_override_r = int(override * 1000.0 + 0.5)
        status.path_position_r = path.path_position * LENGTH
        status.covered_distance_r = int(path.covered * 1000.0)
        source = (path.index, active)
        if source != self._source:
            self._source = source
            status.line_r = max(path.line, 0) if active else 0
            status.block_number_r = path.n
            status.command_feed_r = int(min(channel.programmed_feed * SPEED, RAPID))
        status.block_counter_r = channel.block_counter
        status.path_way_r, status.path_kept_r = channel.path_way, channel.backward.stored
        status.decoder_program_end_r = not channel.link.running
        status.stop_condition_r = stop
        status.interpolation_active_r = active and not path.standstill
        status.program_end_r = channel.program_ended
        status.wait_techno_acknowledge_r = stop & _WAIT_TECHNOLOGY != 0
        status.wait_continue_r = stop & _WAIT_CONTINUE != 0
        status.wait_error_removal_r = channel.error is not None
        status.dwell_time_active_r = stop & _DWELL != 0
        status.prepared_blocks_r = channel.queue.capacity - channel.queue.free
        status.waiting_functions_r = channel.waiting_functions
        status.error_id_r = channel.error.id if channel.error else 0
        supervision = self._supervision
        status.axes_in_position_r = _fill_axes(
            self._axes,
            image.target_position,
            image.actual_position,
            image.actual_velocity,
            image.actual_torque,
            supervision.lag,
            supervision.window,
            self._turn,
            image.state,
            image.mode_shown,
            supervision.faults,
            image.fault_code,
            active,
            stop & _FEED_HOLD != 0,
        )
        for spindle, area in self._spindles:
            actual = float(image.actual_velocity[spindle.index])
            area.mode_r = int(spindle.mode)
            area.programmed_speed_r = int(spindle.programmed_speed * SPEED)
            area.command_speed_r = int(spindle.set_point * SPEED)
            area.actual_speed_r = int(actual * SPEED)
            area.rev_erreicht_r = spindle.reached(actual)
            area.rev_null_r = spindle.standing(actual)
        self._point(channel)
        self._beside(channel)
        platform = self._platform
        platform.bus_load_r = image.bus_load
        if image.buses_changed:
            self._show_buses(image)
        platform.emcy_count_r = image.emcy_count
        platform.frames_sent_r = image.frames_sent
        platform.frames_received_r = image.frames_received

    def _point(self, channel: Channel) -> None:
        """Where the program is, for whoever keeps it: the line first, so that a reader finds one that the way has passed."""
        point, told = channel.search.point, self._interruption
        if point is None:
            return
        if point is not self._told_point:
            self._told_point = point
            told.valid_r = False
            put_text(told, "program_r", point.program)
            for k, place in enumerate(point.begin):
                told.begin_r[k] = place * LENGTH
        told.line_r, told.block_number_r = point.line, point.n
        told.way_r = point.way * LENGTH
        told.valid_r = point.valid

    def _show_buses(self, image: DriveImage) -> None:
        image.buses_changed = False
        self._platform.bus_count_r = len(image.buses)
        for shown, bus in zip(self._platform.bus_r, image.buses, strict=False):
            shown.channel_r, shown.load_r, shown.gone_r = bus.channel.encode()[: NAME - 1], bus.load, bus.gone

    def _beside(self, channel: Channel) -> None:
        """References, and how the axes can be moved by hand; most cycles have nothing new."""
        beside, status = channel.beside, self._status
        status.machine_locked_r = channel.locked and channel.active
        for area, referenced in zip(self._path_areas, beside.referenced, strict=True):
            area.status.referenced_r = referenced
        if not (beside.engaged or self._by_hand):
            return
        self._by_hand = beside.engaged
        for hand, shown in zip(beside.axes, self._displays, strict=True):
            stage = hand.stage
            shown.state_r, shown.operation_mode_r = int(hand.state), int(hand.mode)
            shown.control_element_r = hand.element
            shown.hr_aufloesung_r, shown.tipp_geschw_r = int(stage.resolution * LENGTH), int(stage.velocity * SPEED)
            shown.jog_geschw_r, shown.jog_weg_r = int(stage.step_velocity * SPEED), int(stage.width * LENGTH)
            shown.offset_r = round(hand.offset * LENGTH)
