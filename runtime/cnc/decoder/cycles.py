"""Cycles: subprograms with transfer parameters, also modal ones (programming manual lines 7300–7562)."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.frames import Modal


def call_cycle(
    x: Execution, local: bool, name: str, column: int, transfer: dict[int, float | str], after_motion: bool | None
) -> None:
    """Call a cycle once; with `after_motion` True or False also behind each further block (with motion) of this level."""
    unit, section = x.levels.program(x.frame, local, name, column)
    if after_motion is not None:
        x.frame.modal = Modal(unit, section, name, transfer, after_motion)
    x.levels.enter_cycle(unit, section, name, column, transfer)


def after_block(x: Execution, motion: bool) -> None:
    """A block is done that was no call, control statement or end: the modal cycle of its level runs again."""
    modal = x.frames[-1].modal if x.frames else None
    if modal is not None and (motion or not modal.after_motion):
        x.levels.enter_cycle(modal.unit, modal.section, modal.name, 1, modal.transfer)
