"""M17 and M29 with brackets: back to a chosen level and place (programming manual lines 6646–6721)."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.flow import Flow
from runtime.cnc.decoder.frames import Frame
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock, Values
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.words import Word
from runtime.diagnostics.catalogue import language as catalogue


def return_to(x: Execution, flow: Flow, block: CompiledBlock, values: Values) -> None:
    """Leave the levels that the block says and go on at its target. Raises LineError."""
    word = block.returning
    assert word is not None
    jumps, number = (round_half_up(values[slot]) if slot >= 0 else None for slot in block.return_slots)
    above = len(x.frames) - 1
    count = above if word.target == "MAIN" else 1 if jumps is None else jumps
    if count < 1 and word.target != "MAIN":
        raise LineError(catalogue.JUMPS_INVALID, word.column, value=count)
    if jumps is not None and count > above:
        x.warn(catalogue.JUMPS_MANY, word.column, value=count, levels=above)
    aimed = number is not None or bool(word.name)
    if not above and not aimed:  # as M17 in the main program
        x.levels.finish([])
        return
    position = _position(x.frames[max(above - count, 0)], word, number) if aimed else None
    for _ in range(min(count, above)):
        x.levels.leave()
        if not x.frames:
            return
    if position is not None:
        frame = x.frame
        flow.go_to(frame, frame.index - 1, position[0], word.column)
        frame.row = position[1]


def _position(frame: Frame, word: Word, number: int | None) -> tuple[int, int]:
    """Entry and row of the target in the level that is returned to."""
    unit, section = frame.unit, frame.section
    if number is None:
        entry, label = unit.find_name(section, word.name), f"[{word.name}]"
        found = (entry, 0) if entry >= 0 else None
    else:
        label = f"N{number}"
        entry = unit.find_number(section, number)
        found = (entry, 0) if entry >= 0 else unit.numbered((frame.index, frame.row), section, number)
    if found is None:
        raise LineError(catalogue.LABEL_MISSING, word.column, label=label)
    return found
