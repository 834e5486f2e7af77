"""Which process data go between master and nodes: data, one row per PDO.

At 1 Mbit/s a cycle of 1 ms has room for some eight frames, so each frame carries only what the cycle needs. The error
code comes by EMCY, the velocity of an axis is the difference of its positions. What else a drive exchanges is packed behind,
into as few PDOs as it fits; what changes seldom goes out when it changes, and now and then anyhow.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from struct import calcsize
from typing import Final

from runtime.drives import DriveMode
from runtime.fieldbus import cia402
from runtime.fieldbus.pdo import EVENT, MAX_BITS, Direction, ObjectKey, PdoPlan

READ_INPUTS: Final = 0x6000  # CiA 401, bytes
WRITE_OUTPUTS: Final = 0x6200
READ_ANALOGUE: Final = {8: 0x6400, 16: 0x6401, 32: 0x6402}  # by their bits
WRITE_ANALOGUE: Final = {8: 0x6410, 16: 0x6411, 32: 0x6412}

# struct codes of the exchanged objects, as the profiles prescribe; an EDS that says otherwise is refused
CODES: Final = {
    cia402.CONTROLWORD: "H",
    cia402.STATUSWORD: "H",
    cia402.MODES_OF_OPERATION: "b",
    cia402.MODE_DISPLAY: "b",
    cia402.POSITION_ACTUAL: "i",
    cia402.VELOCITY_ACTUAL: "i",
    cia402.TARGET_TORQUE: "h",
    cia402.MAX_TORQUE: "H",
    cia402.TORQUE_ACTUAL: "h",
    cia402.TARGET_POSITION: "i",
    cia402.VELOCITY_OFFSET: "i",
    cia402.TORQUE_OFFSET: "h",
    cia402.PROBE_FUNCTION: "H",
    cia402.PROBE_STATUS: "H",
    cia402.PROBE_1_RISING: "i",
    cia402.PROBE_1_FALLING: "i",
    cia402.PROBE_2_RISING: "i",
    cia402.PROBE_2_FALLING: "i",
    cia402.INTERPOLATION_DATA: "i",
    cia402.FOLLOWING_ERROR: "i",
    cia402.DIGITAL_INPUTS: "I",
    cia402.TARGET_VELOCITY: "i",
    READ_INPUTS: "B",
    WRITE_OUTPUTS: "B",
    0x6400: "b",
    0x6401: "h",
    0x6402: "i",
    0x6410: "b",
    0x6411: "h",
    0x6412: "i",
}
IO_OBJECTS: Final = frozenset({READ_INPUTS, WRITE_OUTPUTS, *READ_ANALOGUE.values(), *WRITE_ANALOGUE.values()})
IO_PROFILE: Final = 401
IO_REFRESH: Final = 0.1  # s; inputs and outputs are sent when they change, and this often anyhow
DISPLAY_POSITION: Final = PdoPlan(
    Direction.TRANSMIT, 2, ((cia402.POSITION_ACTUAL, 0),), transmission=10
)  # of a spindle

PROBE_POSITIONS: Final = {
    "probe_1_rising": cia402.PROBE_1_RISING,
    "probe_1_falling": cia402.PROBE_1_FALLING,
    "probe_2_rising": cia402.PROBE_2_RISING,
    "probe_2_falling": cia402.PROBE_2_FALLING,
}
SET_POINT_OBJECTS: Final[dict[DriveMode, ObjectKey]] = {
    DriveMode.PROFILE_POSITION: (cia402.TARGET_POSITION, 0),
    DriveMode.PROFILE_VELOCITY: (cia402.TARGET_VELOCITY, 0),
    DriveMode.PROFILE_TORQUE: (cia402.TARGET_TORQUE, 0),
    DriveMode.INTERPOLATED_POSITION: (cia402.INTERPOLATION_DATA, 1),
    DriveMode.CYCLIC_SYNCHRONOUS_POSITION: (cia402.TARGET_POSITION, 0),
    DriveMode.CYCLIC_SYNCHRONOUS_VELOCITY: (cia402.TARGET_VELOCITY, 0),
    DriveMode.CYCLIC_SYNCHRONOUS_TORQUE: (cia402.TARGET_TORQUE, 0),
}


@dataclass(frozen=True, slots=True)
class DriveNeeds:
    """What a drive has to exchange."""

    spindle: bool
    mode: DriveMode  # the one in which it takes set-points
    modes: frozenset[DriveMode] = frozenset()  # the others that can be ordered
    velocity_offset: bool = False
    torque_offset: bool = False
    process_data: frozenset[str] = frozenset()
    inputs: bool = False


def plain_mode(spindle: bool) -> DriveMode:
    """The mode of a drive of which nothing is said."""
    return DriveMode.CYCLIC_SYNCHRONOUS_VELOCITY if spindle else DriveMode.CYCLIC_SYNCHRONOUS_POSITION


def drive_pdos(needs: DriveNeeds) -> tuple[PdoPlan, ...]:
    """The PDOs of a drive. Those beyond the predefined ones get their COB-ID later."""
    data = needs.process_data
    orders: list[ObjectKey] = [(cia402.CONTROLWORD, 0), SET_POINT_OBJECTS[needs.mode]]
    tells: list[ObjectKey] = [
        (cia402.STATUSWORD, 0),
        (cia402.VELOCITY_ACTUAL if needs.spindle else cia402.POSITION_ACTUAL, 0),
    ]
    if needs.modes:
        orders.append((cia402.MODES_OF_OPERATION, 0))
        tells.append((cia402.MODE_DISPLAY, 0))
    further = [
        (needs.velocity_offset, (cia402.VELOCITY_OFFSET, 0)),
        (needs.torque_offset, (cia402.TORQUE_OFFSET, 0)),
        ("torque_limit" in data, (cia402.MAX_TORQUE, 0)),
        (bool(data & PROBE_POSITIONS.keys()), (cia402.PROBE_FUNCTION, 0)),
    ]
    orders += [key for needed, key in further if needed]
    orders += sorted({SET_POINT_OBJECTS[mode] for mode in needs.modes if mode in SET_POINT_OBJECTS} - set(orders))
    if "torque" in data:
        tells.append((cia402.TORQUE_ACTUAL, 0))
    if "following_error" in data:
        tells.append((cia402.FOLLOWING_ERROR, 0))
    plans = _packed(Direction.RECEIVE, orders)
    first, *others = _packed(Direction.TRANSMIT, tells)
    plans += [first, DISPLAY_POSITION] if needs.spindle else [first]
    plans += [replace(plan, number=plan.number + needs.spindle) for plan in others]
    seldom: list[tuple[ObjectKey, ...]] = [((cia402.DIGITAL_INPUTS, 0),)] if needs.inputs else []
    # Status and position of a probe come in one frame, so that a position always is that of its status.
    seldom += [((cia402.PROBE_STATUS, 0), (PROBE_POSITIONS[name], 0)) for name in PROBE_POSITIONS if name in data]
    used = sum(plan.direction is Direction.TRANSMIT for plan in plans)
    plans += [
        PdoPlan(Direction.TRANSMIT, number, objects, EVENT, event_timer_ms=int(IO_REFRESH * 1000))
        for number, objects in enumerate(seldom, used + 1)
    ]
    return tuple(plans)


def _packed(direction: Direction, objects: list[ObjectKey]) -> list[PdoPlan]:
    """Each object into the first PDO that has room."""
    rows: list[list[ObjectKey]] = []
    for key in objects:
        room = next((row for row in rows if _bytes([*row, key]) * 8 <= MAX_BITS), None)
        if room is None:
            rows.append([key])
        else:
            room.append(key)
    return [PdoPlan(direction, number, tuple(row)) for number, row in enumerate(rows, 1)]


def _bytes(objects: list[ObjectKey]) -> int:
    return calcsize("<" + "".join(CODES[index] for index, _ in objects))


@dataclass(frozen=True, slots=True)
class AnalogueNeeds:
    """What an I/O node exchanges beside its bits. `every`: cycles; `period` of a cycle, s."""

    inputs: tuple[ObjectKey, ...] = ()  # told every so many cycles
    watched: tuple[ObjectKey, ...] = ()  # told when they change, and no more often than the others
    outputs: tuple[ObjectKey, ...] = ()
    every: int = 1
    period: float = 0.001

    def pdos(self, received: int, transmitted: int) -> list[PdoPlan]:
        """The PDOs, behind so many others."""
        outputs = [replace(plan, transmission=EVENT) for plan in _packed(Direction.RECEIVE, list(self.outputs))]
        inputs = [replace(plan, transmission=self.every) for plan in _packed(Direction.TRANSMIT, list(self.inputs))]
        inhibit = min(round(self.every * self.period * 1e4), 0xFFFF)
        inputs += [
            replace(plan, transmission=EVENT, event_timer_ms=int(IO_REFRESH * 1000), inhibit_time=inhibit)
            for plan in _packed(Direction.TRANSMIT, list(self.watched))
        ]
        return [replace(plan, number=received + k) for k, plan in enumerate(outputs, 1)] + [
            replace(plan, number=transmitted + k) for k, plan in enumerate(inputs, 1)
        ]


def io_pdos(inputs: int, outputs: int, analogue: AnalogueNeeds = AnalogueNeeds()) -> tuple[PdoPlan, ...]:
    """The PDOs of an I/O node with so many input and output bits, and these analogue values."""
    plans = []
    if outputs:
        objects = tuple((WRITE_OUTPUTS, k + 1) for k in range((outputs + 7) // 8))
        plans.append(PdoPlan(Direction.RECEIVE, 1, objects, EVENT))
    if inputs:
        objects = tuple((READ_INPUTS, k + 1) for k in range((inputs + 7) // 8))
        plans.append(PdoPlan(Direction.TRANSMIT, 1, objects, EVENT, event_timer_ms=int(IO_REFRESH * 1000)))
    return (*plans, *analogue.pdos(int(outputs > 0), int(inputs > 0)))
