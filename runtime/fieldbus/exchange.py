"""Which process data go between master and nodes: data, one row per PDO.

At 1 Mbit/s a cycle of 1 ms has room for some eight frames, so each frame carries only what the cycle needs. The error
code comes by EMCY, the velocity of an axis is the difference of its positions.
"""

from __future__ import annotations

from typing import Final

from runtime.fieldbus.cia402 import (
    CONTROLWORD,
    POSITION_ACTUAL,
    STATUSWORD,
    TARGET_POSITION,
    TARGET_VELOCITY,
    VELOCITY_ACTUAL,
)
from runtime.fieldbus.pdo import EVENT, Direction, PdoPlan

AXIS_PDOS: Final = (
    PdoPlan(Direction.RECEIVE, 1, ((CONTROLWORD, 0), (TARGET_POSITION, 0))),
    PdoPlan(Direction.TRANSMIT, 1, ((STATUSWORD, 0), (POSITION_ACTUAL, 0))),
)
SPINDLE_PDOS: Final = (
    PdoPlan(Direction.RECEIVE, 1, ((CONTROLWORD, 0), (TARGET_VELOCITY, 0))),
    PdoPlan(Direction.TRANSMIT, 1, ((STATUSWORD, 0), (VELOCITY_ACTUAL, 0))),
    PdoPlan(Direction.TRANSMIT, 2, ((POSITION_ACTUAL, 0),), transmission=10),  # for display only
)

READ_INPUTS: Final = 0x6000  # CiA 401, bytes
WRITE_OUTPUTS: Final = 0x6200

# struct codes of the exchanged objects, as the profiles prescribe; an EDS that says otherwise is refused
CODES: Final = {
    CONTROLWORD: "H",
    STATUSWORD: "H",
    POSITION_ACTUAL: "i",
    VELOCITY_ACTUAL: "i",
    TARGET_POSITION: "i",
    TARGET_VELOCITY: "i",
    READ_INPUTS: "B",
    WRITE_OUTPUTS: "B",
}
IO_PROFILE: Final = 401
IO_REFRESH: Final = 0.1  # s; inputs and outputs are sent when they change, and this often anyhow


def io_pdos(inputs: int, outputs: int) -> tuple[PdoPlan, ...]:
    """The PDOs of an I/O node with so many input and output bits."""
    plans = []
    if outputs:
        objects = tuple((WRITE_OUTPUTS, k + 1) for k in range((outputs + 7) // 8))
        plans.append(PdoPlan(Direction.RECEIVE, 1, objects, EVENT))
    if inputs:
        objects = tuple((READ_INPUTS, k + 1) for k in range((inputs + 7) // 8))
        plans.append(PdoPlan(Direction.TRANSMIT, 1, objects, EVENT, event_timer_ms=int(IO_REFRESH * 1000)))
    return tuple(plans)
