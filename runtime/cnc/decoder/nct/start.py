"""What holds when a program starts, and what is left behind its end (manual lines 627–951)."""

from __future__ import annotations

from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.g_stroke_check import begin_watch
from runtime.cnc.decoder.nct.registry import G_CODES, tenths_of

# In their order; the codes of the configuration (CODES) come first.
START = ("13.1", "15", "25", "40", "49", "50", "50.1", "54", "64", "67", "69", "80", "97", "98")


def begin_program(x: NctExecution) -> None:
    """The state at program start. The work coordinate system is the first one (G54); inch or metric is what held before."""
    x.modal.centre_correction = False  # a centre that does not fit makes a spiral
    x.read_offsets()
    for number in (*(code.removeprefix("G") for code in x.nct.start_codes), *START):
        tenths = tenths_of(number)
        if tenths in G_CODES:
            x.select(tenths)
    if x.memory.inch is not None:
        x.select(200 if x.memory.inch else 210)
    begin_watch(x)
    x.modal_changed()
