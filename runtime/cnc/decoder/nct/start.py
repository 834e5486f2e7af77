"""What holds when a program starts: the codes marked in the table, or chosen (manual lines 627–951)."""

from __future__ import annotations

from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.registry import G_CODES, tenths_of

# In their order; codes that are not registered are passed over. Where the table leaves a choice, it is CODES.
START = (
    "0",
    "13.1",
    "15",
    "17",
    "21",
    "25",
    "40",
    "49",
    "50",
    "50.1",
    "54",
    "64",
    "67",
    "69",
    "80",
    "90",
    "94",
    "97",
    "98",
)


def begin_program(x: NctExecution) -> None:
    """The state at program start. The work coordinate system is the first one (G54)."""
    x.modal.centre_correction = False  # a centre that does not fit makes a spiral
    x.read_offsets()
    for number in START:
        tenths = tenths_of(number)
        if tenths in G_CODES:
            x.select(tenths)
    x.modal_changed()
